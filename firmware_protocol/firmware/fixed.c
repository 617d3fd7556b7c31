#include "fixed.h"

#include "flash.h"

#define STEPS 16u
#define GAIN 39797u            /* 65536 over the length that the steps add */
#define LARGE 0x10000000ul     /* 2^28: what a vector is blown up to */
#define FAR 0x8000000l         /* 2^27 times 4 um: 536 m */
#define HALF_TURN ((int32_t)-2147483647l - 1l)

/* atan(2^-i) as binary angles. */
static const int32_t step_angles[STEPS] CW_IN_FLASH = {
    536870912l, 316933406l, 167458907l, 85004756l, 42667331l, 21354465l, 10679838l, 5340245l,
    2670163l,   1335087l,   667544l,    333772l,   166886l,   83443l,    41722l,    20861l};

int32_t cw_scale(int32_t a, uint16_t part)
{
    uint32_t low = (uint32_t)(uint16_t)a * part;
    return (int32_t)(int16_t)(a >> 16) * (int32_t)part + (int32_t)((low + 0x8000u) >> 16);
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

static int32_t apart(int32_t from, int32_t to)
{
    /* in quarters first, where no difference overflows */
    int32_t coarse = (to >> 2) - (from >> 2);
    if (coarse >= FAR) {
        return FAR * 4;
    }
    if (coarse <= -FAR) {
        return -FAR * 4;
    }
    return to - from;
}

void cw_between(cw_place from, cw_place to, cw_vector *out_vector)
{
    out_vector->x = apart(from.x_um, to.x_um);
    out_vector->y = apart(from.y_um, to.y_um);
    out_vector->angle = 0;
}

/* Volder's algorithm (CORDIC, 1959): turns by atan(2^-i) need additions and shifts only. */
static void turn(cw_vector *vector, bool measure)
{
    int32_t x = vector->x;
    int32_t y = vector->y;
    int32_t angle = vector->angle;
    uint32_t half = 0;
    uint8_t i, up = 0;
    if ((x | y) == 0) {
        return;
    }
    while ((cw_size(x) | cw_size(y)) < LARGE) {
        x += x;
        y += y;
        up++;
    }
    if (measure ? x < 0 : cw_size(angle) > 0x40000000ul) {
        x = -x;
        y = -y;
        angle = cw_sum(angle, HALF_TURN);
    }
    for (i = 0; i < STEPS; i++) {
        int32_t dx = y >> i;
        int32_t dy = x >> i;
        int32_t step = (int32_t)CW_FLASH_WORD(&step_angles[i]);
        if (measure ? y < 0 : angle >= 0) {
            dx = -dx;
            dy = -dy;
            step = -step;
        }
        x += dx;
        y -= dy;
        angle = cw_sum(angle, step);
    }
    if (up > 0u) {
        half = (uint32_t)1u << (up - 1u);
    }
    vector->x = (cw_scale(x, GAIN) + (int32_t)half) >> up;
    vector->y = (cw_scale(y, GAIN) + (int32_t)half) >> up;
    vector->angle = angle;
}

void cw_turn(cw_vector *vector)
{
    turn(vector, false);
}

void cw_measure(cw_vector *vector)
{
    vector->angle = 0;
    turn(vector, true);
}
