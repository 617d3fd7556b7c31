#include "estimate.h"

#include <string.h>

#define DRIFT_MAX 419904ul /* 0.6 rad/m */
/* 537 m. What the wheels have travelled since the last fix is counted no further, so that it does
 * not wrap: below 2^30 with a cycle's travel more, as MicroPython needs it too. */
#define TRAVEL_MAX 536870912l
#define HISTORY_STEP 156u  /* 40 ms */
#define JUMP_UM 150000ul
#define JUMP_SHIFT 11 /* of a heading: 0.45 rad */
#define JUMPS_BELIEVED 5u

static void add(int32_t *to, const int32_t *by)
{
    uint8_t i;
    for (i = 0; i < 3u; i++) {
        to[i] = cw_sum(to[i], by[i]);
    }
}

void cw_estimate_advance(cw_estimate *estimate, int32_t travel_um, int32_t turn, uint16_t now)
{
    cw_past *past = estimate->history;
    int32_t step[3];
    int32_t travelled;
    if ((uint16_t)(past->time - past[1].time) >= HISTORY_STEP) {
        memmove(past + 1, past, sizeof *past * (CW_HISTORY - 1u));
    }
    travelled = cw_sum(estimate->travel_um, travel_um);
    if (travelled > TRAVEL_MAX) {
        travelled = TRAVEL_MAX;
    } else if (travelled < -TRAVEL_MAX) {
        travelled = -TRAVEL_MAX;
    }
    estimate->travel_um = travelled;
    step[0] = travel_um;
    step[1] = 0;
    step[2] = cw_sum(
        turn,
        (int32_t)((uint32_t)cw_scale(travel_um, (int16_t)(estimate->drift >> 4)) << 8));
    cw_turn(step, (uint16_t)(cw_sum(estimate->pose[2], step[2] >> 1) >> 16));
    add(estimate->pose, step);
    add(estimate->moved, step);
    past->moved[0] = (uint16_t)(estimate->moved[0] >> 8);
    past->moved[1] = (uint16_t)(estimate->moved[1] >> 8);
    past->moved[2] = (uint16_t)(estimate->moved[2] >> 16);
    past->time = now;
}

bool cw_estimate_correct(cw_estimate *estimate, const int32_t seen[3], uint32_t seen_us)
{
    const cw_past *past = estimate->history;
    int32_t shift[3];
    int16_t since, turn;
    int16_t part = 0;
    bool near = true;
    uint8_t i = CW_HISTORY;
    while ((since = (int16_t)((uint16_t)(seen_us >> 8) - past->time)) < 0) {
        if (--i == 0u) {
            return false; /* forgotten */
        }
        past++;
    }
    if (past != estimate->history) {
        part = (int16_t)(((uint32_t)(uint16_t)since << 14) /
                         (uint16_t)(past[-1].time - past->time));
    }
    /* what the wheels have done since is laid on top of what was seen */
    for (i = 0; i < 3u; i++) {
        uint16_t before = past->moved[i];
        int32_t since_then;
        uint32_t size;
        if (part != 0) {
            before = (uint16_t)(before + cw_scale((int16_t)(past[-1].moved[i] - before), part));
        }
        since_then = (int32_t)(int16_t)(estimate->history->moved[i] - before) * 256;
        if (i == 2u) {
            since_then *= 256;
        }
        shift[i] = cw_sum(cw_difference(seen[i], estimate->pose[i]), since_then);
        size = cw_size(shift[i]);
        if (i == 2u) {
            size >>= JUMP_SHIFT;
        }
        if (size > JUMP_UM) {
            near = false;
        }
    }
    if (estimate->known) {
        if (near) {
            turn = (int16_t)(shift[2] >> 16);
            estimate->travel_um =
                estimate->drift + (cw_scale(estimate->travel_um, turn) >> 1);
            if (cw_size(estimate->travel_um) <= DRIFT_MAX) {
                estimate->drift = estimate->travel_um;
            }
            for (i = 0; i < 3u; i++) {
                shift[i] = (shift[i] + 2) >> 2;
            }
        } else if (++estimate->jumps < JUMPS_BELIEVED) {
            return false;
        }
    }
    add(estimate->pose, shift);
    estimate->jumps = 0;
    estimate->travel_um = 0;
    if (!estimate->fix_recent || (int32_t)(seen_us - estimate->fix_us) > 0) {
        estimate->fix_us = seen_us;
    }
    estimate->known = true;
    estimate->fix_recent = true;
    return true;
}
