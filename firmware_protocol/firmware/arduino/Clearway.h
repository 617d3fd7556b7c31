/* The library for Arduino sketches; program.h, settings.h, port.h and port_arduino.h have the
 * manual. */
#ifndef CLEARWAY_ARDUINO_H
#define CLEARWAY_ARDUINO_H

#ifdef __cplusplus
extern "C" {
#endif

#include <clearway/port.h>
#include <clearway/port_arduino.h>
#include <clearway/program.h>
#include <clearway/settings.h>

/* On an ATmega328P: whether the watchdog restarts a program that hangs. A sketch for a Nano with
 * the old bootloader, which never comes back from the watchdog, defines it to return false. */
bool cw_board_has_watchdog(void);

#ifdef __cplusplus
}
#endif

#endif
