/* Whole-number geometry for processors without floating point. The twin of fixed.py, bit for
 * bit: the same sums, products and shifts in the same order.
 *
 * - Places are micrometres. Headings are 32-bit binary angles: 2^32 is a full turn, so that sums
 *   wrap by themselves; all other angles are their upper 16 bits, 2^16 a turn.
 * - Parts of a whole are of 16384, signed, or of 65536, unsigned.
 * - A vector between two places is in quarters: 4 um, so that the whole range of the wire fits.
 */
#ifndef CLEARWAY_FIXED_H
#define CLEARWAY_FIXED_H

#include <stdbool.h>
#include <stdint.h>

/* An angle of 2^16 a turn. */
#define CW_MRAD(milliradians) ((uint16_t)((milliradians) * 10430ul / 1000u))

/* Sum and difference modulo 2^32, as headings and counters need them. */
static inline int32_t cw_sum(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t cw_difference(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/* The size of a number; that of -2^31 is 2^31. */
uint32_t cw_size(int32_t a);

/* The same for 16 bits, and how far an angle is from 0, either way round. */
uint16_t cw_short_size(int16_t a);

/* A number within plus and minus `most`. */
int16_t cw_clip(int32_t a, int16_t most);

/* a * part / 65536, rounded down. */
uint16_t cw_part(uint16_t a, uint16_t part);

/* a * part / 16384, to the nearest; the result has to fit. */
int32_t cw_scale(int32_t a, int16_t part);

/* The whole part of the square root. */
uint16_t cw_root(uint32_t square);

/* The sine of an angle, of 16384. */
int16_t cw_sine(uint16_t angle);

/* The vector from one place (x, y in micrometres) to another, in quarters. */
void cw_between(const int32_t *from, const int32_t *to, int32_t *out_vector);

/* Turn a vector by an angle. */
void cw_turn(int32_t *vector, uint16_t angle);

/* Turn a vector onto the x axis, so that x becomes its length and y nearly 0: its bearing. */
uint16_t cw_measure(int32_t *vector);

#endif
