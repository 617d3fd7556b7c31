/* Whole-number geometry for processors without floating point. The twin of fixed_point.py, bit
 * for bit: the same additions and shifts in the same order.
 *
 * - Places are micrometres. Angles are 32-bit binary angles: 2^32 is a full turn, so that sums
 *   wrap by themselves; CW_MRAD makes them from milliradians.
 * - Speeds are mm/s times 1024, "q10".
 * - A vector's x and y are within 2^29 um; cw_between keeps to that.
 */
#ifndef CLEARWAY_FIXED_H
#define CLEARWAY_FIXED_H

#include <stdbool.h>
#include <stdint.h>

#define CW_MRAD(milliradians) ((int32_t)(milliradians) * 683565l)

typedef struct {
    int32_t x_um;
    int32_t y_um;
} cw_place;

typedef struct {
    int32_t x;
    int32_t y;
    int32_t angle;
} cw_vector;

/* Sum and difference modulo 2^32, as angles and counters need them. */
static inline int32_t cw_sum(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t cw_difference(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/* The size of a number; that of -2^31 is 2^31. */
static inline uint32_t cw_size(int32_t a)
{
    return a < 0 ? 0ul - (uint32_t)a : (uint32_t)a;
}

/* a * part / 65536, to the nearest. */
int32_t cw_scale(int32_t a, uint16_t part);

/* The whole part of the square root. */
uint16_t cw_root(uint32_t square);

/* The vector from one place to another; further than 536 m along x or y counts as 536 m. */
void cw_between(cw_place from, cw_place to, cw_vector *out_vector);

/* Turn a vector by its angle; the angle is used up. */
void cw_turn(cw_vector *vector);

/* Turn a vector onto the x axis: x becomes its length, y nearly 0, `angle` its bearing. */
void cw_measure(cw_vector *vector);

#endif
