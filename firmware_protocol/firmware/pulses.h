/* Wheels that do not turn below a least speed: what is slower, they are driven in pulses of it. The
 * twin of pulses.py, whose text says why.
 */
#ifndef CLEARWAY_PULSES_H
#define CLEARWAY_PULSES_H

#include <stdbool.h>
#include <stdint.h>

#define CW_PULSE_US 25000

/* What to drive a wheel at that is ordered to turn at `order` and was driven at `driven` in the last
 * cycle, in eighths of mm/s; never less than the least speed but 0, and 0 where the order is. `owed`
 * is what it was ordered and not driven up to now, in those times microseconds; one of the two
 * wheels is half a pulse `ahead`. */
int16_t cw_pulsed(int16_t order, int16_t driven, int32_t owed, bool ahead);

#endif
