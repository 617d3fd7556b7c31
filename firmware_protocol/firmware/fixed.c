#include "fixed.h"

#include "flash.h"

/* Odd polynomials on 0..1, the coefficients fitted for the least largest error: the sine of a
 * quarter turn, and the arc tangent as a part of an eighth of a turn. */
static const uint16_t sine_series[3] CW_IN_FLASH = {51455u, 42078u, 4709u};
static const uint16_t arc_series[3] CW_IN_FLASH = {41528u, 24095u, 6627u};

uint32_t cw_size(int32_t a)
{
    return a < 0 ? 0ul - (uint32_t)a : (uint32_t)a;
}

CW_APART uint16_t cw_short_size(int16_t a)
{
    return a < 0 ? (uint16_t)(0u - (uint16_t)a) : (uint16_t)a;
}

CW_APART int16_t cw_clip(int32_t a, int16_t most)
{
    if (a > most) {
        return most;
    }
    if (a < -most) {
        return (int16_t)-most;
    }
    return (int16_t)a;
}

uint16_t cw_part(uint16_t a, uint16_t part)
{
    return (uint16_t)((uint32_t)a * part >> 16);
}

int32_t cw_scale(int32_t a, int16_t part)
{
    int32_t low = (int32_t)(uint16_t)a * part;
    int32_t high = (int32_t)(int16_t)(a >> 16) * part;
    return (int32_t)((uint32_t)high << 2) + ((low + 0x2000) >> 14);
}

uint16_t cw_root(uint32_t square)
{
    uint16_t root = 0;
    uint16_t bit = 0x8000u;
    do {
        uint16_t larger = (uint16_t)(root | bit);
        if ((uint32_t)larger * larger <= square) {
            root = larger;
        }
        bit >>= 1;
    } while (bit != 0u);
    return root;
}

/* z (c0 - z^2 (c1 - z^2 c2)), of 32768; z of 65536. */
static uint16_t series(uint16_t z, const uint16_t *c)
{
    uint16_t square = cw_part(z, z);
    uint16_t inner = (uint16_t)(CW_FLASH_SHORT(c + 1) - cw_part(square, CW_FLASH_SHORT(c + 2)));
    return cw_part(z, (uint16_t)(CW_FLASH_SHORT(c) - (cw_part(square, inner) >> 1)));
}

int16_t cw_sine(uint16_t angle)
{
    uint16_t up = (uint16_t)(angle << 1); /* half a turn is 65536 */
    int16_t sine;
    if ((up & 0x8000u) != 0u) {
        up = (uint16_t)(0u - up);
        if ((up & 0x8000u) != 0u) {
            up--;
        }
    }
    sine = (int16_t)((uint16_t)(series((uint16_t)(up << 1), sine_series) + 1u) >> 1);
    return (angle & 0x8000u) != 0u ? (int16_t)-sine : sine;
}

void cw_between(const int32_t *from, const int32_t *to, int32_t *out_vector)
{
    uint8_t i;
    for (i = 0; i < 2u; i++) {
        out_vector[i] = (to[i] >> 2) - (from[i] >> 2);
    }
}

void cw_turn(int32_t *vector, uint16_t angle)
{
    int16_t sine = cw_sine(angle);
    int16_t cosine = cw_sine((uint16_t)(angle + 0x4000u));
    int32_t x = vector[0];
    int32_t y = vector[1];
    vector[0] = cw_scale(x, cosine) - cw_scale(y, sine);
    vector[1] = cw_scale(x, sine) + cw_scale(y, cosine);
}

uint16_t cw_measure(int32_t *vector)
{
    uint32_t large = cw_size(vector[0]);
    uint32_t small = cw_size(vector[1]);
    uint16_t angle = 0xFFFFu;
    bool steep = small > large;
    if (steep) {
        uint32_t other = large;
        large = small;
        small = other;
    }
    while (large > 0xFFFFu) {
        large >>= 1;
        small >>= 1;
    }
    if (small != large) {
        angle = (uint16_t)((small << 16) / large);
    }
    angle = (uint16_t)((uint16_t)(series(angle, arc_series) + 2u) >> 2);
    if (steep) {
        angle = (uint16_t)(0x4000u - angle);
    }
    if (vector[0] < 0) {
        angle = (uint16_t)(0x8000u - angle);
    }
    if (vector[1] < 0) {
        angle = (uint16_t)(0u - angle);
    }
    cw_turn(vector, (uint16_t)(0u - angle));
    return angle;
}
