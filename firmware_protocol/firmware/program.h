/* The firmware's program on any board: begin once, then call round without a pause. The board is
 * behind port.h; its program also defines cw_robot_settings (settings.h). */
#ifndef CLEARWAY_PROGRAM_H
#define CLEARWAY_PROGRAM_H

/* The port has to be ready. */
void cw_program_begin(void);

/* Take what has arrived, answer, and every 10 ms do one control cycle. */
void cw_program_round(void);

#endif
