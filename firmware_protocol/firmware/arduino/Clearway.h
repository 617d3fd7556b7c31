/* The library for Arduino sketches; program.h, settings.h, port.h and port_arduino.h have the
 * manual. */
#ifndef CLEARWAY_ARDUINO_H
#define CLEARWAY_ARDUINO_H

#ifdef __cplusplus
extern "C" {
#endif

#include "port.h"
#include "port_arduino.h"
#include "program.h"
#include "settings.h"

#ifdef __cplusplus
}
#endif

#endif
