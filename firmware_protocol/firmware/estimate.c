#include "estimate.h"

#include <string.h>

#define HEADING_GAIN 13107u /* of 65536: a fifth */
#define DRIFT_MAX 419904l   /* 0.6 rad/m */
#define HISTORY_STEP_US 40000ul
#define JUMP_UM 150000ul
#define JUMP_ANGLE 5215u /* 0.5 rad, of 65536 */
#define JUMPS_BELIEVED 5u

void cw_estimate_init(cw_estimate *estimate)
{
    memset(estimate, 0, sizeof *estimate);
}

void cw_estimate_advance(cw_estimate *estimate, int32_t travel_um, int32_t turn, uint32_t now_us)
{
    cw_pose *pose = &estimate->pose;
    cw_past *history = estimate->history;
    if (travel_um != 0 || turn != 0) {
        cw_vector step;
        int32_t drift = estimate->drift >> 4;
        int32_t drifted = cw_scale(travel_um, (uint16_t)cw_size(drift)) * 1024;
        turn = drift < 0 ? cw_difference(turn, drifted) : cw_sum(turn, drifted);
        step.x = travel_um;
        step.y = 0;
        step.angle = cw_sum(pose->heading, turn >> 1);
        cw_turn(&step);
        estimate->travel_um = cw_sum(estimate->travel_um, travel_um);
        pose->place.x_um = cw_sum(pose->place.x_um, step.x);
        pose->place.y_um = cw_sum(pose->place.y_um, step.y);
        pose->heading = cw_sum(pose->heading, turn);
    }
    if (estimate->kept == 0u || now_us - history->time_us >= HISTORY_STEP_US) {
        memmove(history + 1, history, sizeof *history * (CW_HISTORY - 1u));
        history->pose = *pose;
        history->time_us = now_us;
        if (estimate->kept < CW_HISTORY) {
            estimate->kept++;
        }
    }
}

/* A part of the way from `from` towards `to`. */
static int32_t blended(int32_t from, int32_t to, uint16_t part)
{
    return cw_sum(from, cw_scale(cw_difference(to, from), part));
}

/* The estimate at a past time, interpolated; false where it is forgotten. */
static bool pose_then(const cw_estimate *estimate, uint32_t time_us, uint32_t now_us,
                      cw_pose *out_pose)
{
    const cw_past *past = estimate->history;
    uint8_t left = estimate->kept;
    *out_pose = estimate->pose;
    for (; left > 0u; left--, past++) {
        uint32_t since_us = time_us - past->time_us;
        uint32_t span_us = now_us - past->time_us;
        if ((int32_t)since_us >= 0) {
            uint16_t part = 0xFFFFu;
            while (span_us > 0xFFFFu) {
                span_us >>= 1;
                since_us >>= 1;
            }
            if (since_us < span_us) {
                part = (uint16_t)((since_us << 16) / span_us);
            }
            out_pose->place.x_um = blended(past->pose.place.x_um, out_pose->place.x_um, part);
            out_pose->place.y_um = blended(past->pose.place.y_um, out_pose->place.y_um, part);
            out_pose->heading = blended(past->pose.heading, out_pose->heading, part);
            return true;
        }
        *out_pose = past->pose;
        now_us = past->time_us;
    }
    return estimate->kept == 0u || (int32_t)(time_us + HISTORY_STEP_US - now_us) >= 0;
}

/* Turn a pose about a place and shift it: the motion between both is kept. */
static void move_about(cw_pose *pose, cw_place about, const cw_vector *shift)
{
    cw_vector arm;
    cw_between(about, pose->place, &arm);
    arm.angle = shift->angle;
    cw_turn(&arm);
    pose->place.x_um = cw_sum(cw_sum(about.x_um, shift->x), arm.x);
    pose->place.y_um = cw_sum(cw_sum(about.y_um, shift->y), arm.y);
    pose->heading = cw_sum(pose->heading, shift->angle);
}

bool cw_estimate_correct(cw_estimate *estimate, const cw_pose *seen, uint32_t age_us,
                         uint32_t now_us)
{
    cw_pose then;
    cw_vector shift;
    int16_t turn;
    uint8_t i;
    age_us = now_us - age_us; /* when the camera saw it */
    if (!pose_then(estimate, age_us, now_us, &then)) {
        return false;
    }
    cw_between(then.place, seen->place, &shift);
    shift.angle = cw_difference(seen->heading, then.heading);
    turn = (int16_t)(shift.angle >> 16);
    if (estimate->known) {
        uint16_t turn_size = (uint16_t)cw_size(turn);
        if (cw_size(shift.x) > JUMP_UM || cw_size(shift.y) > JUMP_UM || turn_size > JUMP_ANGLE) {
            estimate->jumps++;
            if (estimate->jumps < JUMPS_BELIEVED) {
                return false;
            }
        } else {
            int32_t learned = cw_scale(estimate->travel_um, turn_size);
            learned = estimate->drift + 2 * (turn < 0 ? -learned : learned);
            estimate->drift = learned > DRIFT_MAX    ? DRIFT_MAX
                              : learned < -DRIFT_MAX ? -DRIFT_MAX
                                                     : learned;
            shift.x = (shift.x + 2) >> 2;
            shift.y = (shift.y + 2) >> 2;
            shift.angle = cw_scale(shift.angle, HEADING_GAIN);
        }
    }
    estimate->jumps = 0;
    estimate->travel_um = 0;
    move_about(&estimate->pose, then.place, &shift);
    for (i = 0; i < estimate->kept; i++) {
        move_about(&estimate->history[i].pose, then.place, &shift);
    }
    if (!estimate->fix_recent || (int32_t)(age_us - estimate->fix_us) > 0) {
        estimate->fix_us = age_us;
    }
    estimate->known = true;
    estimate->fix_recent = true;
    return true;
}
