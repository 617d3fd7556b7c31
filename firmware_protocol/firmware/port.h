/* What a board supplies. port_main.c is the program; a port is these functions.
 *
 * None of them waits. Times are microseconds of a free-running clock that may wrap.
 */
#ifndef CLEARWAY_PORT_H
#define CLEARWAY_PORT_H

#include <stdbool.h>
#include <stdint.h>

#include "follower.h"
#include "link.h"

/* Clock, serial port, motors, encoders; false where the board cannot start. */
bool cw_port_begin(int argc, char **argv);

/* Boot id (another one at each boot), reset cause, firmware hash. */
void cw_port_identity(cw_identity *out_identity);

uint32_t cw_port_now_us(void);

/* Up to `room` bytes that have arrived; how many. */
uint8_t cw_port_read(uint8_t *out_data, uint8_t room);

/* Bytes lost before cw_port_read since the last call. */
uint16_t cw_port_overruns(void);

/* Whether the transmitter has finished, so that the next frame may be given. */
bool cw_port_can_write(void);

/* Send a frame; `data` stays untouched until cw_port_can_write is true again. */
void cw_port_write(const uint8_t *data, uint8_t length);

/* Whether the receive interrupt, or a button, has seen an emergency stop since the last call. */
bool cw_port_estop_seen(void);

/* What the wheels, left and right, have travelled since the last call, in micrometres: within
 * plus and minus CW_LEAP_UM. */
void cw_port_travel(int32_t out_travel_um[2]);

void cw_port_drive(cw_wheels wheels);

/* Something to do between two rounds, as feeding a watchdog; false ends the program. */
bool cw_port_idle(void);

#endif
