#include "follower.h"

#include <math.h>
#include <stddef.h>

#include "wire.h"

#define PI 3.14159265f
#define POSITION_GAIN 0.25f
#define HEADING_GAIN 0.2f
#define DRIFT_GAIN 0.5f
#define DRIFT_MAX 0.6f
#define HISTORY_STEP_US 40000ul
#define JUMP_M 0.15f
#define JUMP_RAD 0.5f
#define JUMPS_BELIEVED 5u

#define TURN_ENTER_RAD 0.8f
#define TURN_ENTER_COS 0.69670671f
#define TURN_STANDING_RAD 0.2f
#define STANDING_M_S 0.02f
#define TURN_EXIT_RAD 0.04f
#define PASS_RADIUS_M 0.005f
#define START_RADIUS_M 0.02f
#define STOP_TOLERANCE_M 0.003f
#define HEADING_TOLERANCE_RAD 0.006f
#define SETTLE_S 0.25f
#define STUCK_S 3.0f
#define DOCK_ATTEMPTS 8u
#define CRAWL_M_S 0.01f
#define DOCK_SPEED_M_S 0.06f
#define APPROACH_PER_S 4.0f

const cw_drive_settings cw_default_settings = {0.12f, 0.5f, 0.5f, 0.6f, 2.5f,
                                               8.0f,  0.04f, 0.15f, 0.15f};

/* A waypoint's place in float; the rest is read from the record where it is needed. */
typedef struct {
    float x;
    float y;
} place;

static float limited(float value, float limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

static float least(float a, float b)
{
    return a < b ? a : b;
}

static float most(float a, float b)
{
    return a > b ? a : b;
}

static float length_of(float x, float y)
{
    return sqrtf(x * x + y * y);
}

float cw_wrap_angle(float angle_rad)
{
    while (angle_rad > PI) {
        angle_rad -= 2.0f * PI;
    }
    while (angle_rad < -PI) {
        angle_rad += 2.0f * PI;
    }
    return angle_rad;
}

/* The estimate. */

static cw_past *past_at(cw_estimate *estimate, uint8_t index)
{
    return &estimate->history[(uint8_t)(estimate->oldest + index) % CW_HISTORY];
}

void cw_estimate_init(cw_estimate *estimate)
{
    static const cw_pose origin = {0.0f, 0.0f, 0.0f};
    uint8_t i;
    estimate->pose = origin;
    for (i = 0; i < CW_HISTORY; i++) {
        estimate->history[i].time_us = 0;
        estimate->history[i].pose = origin;
    }
    estimate->oldest = 0;
    estimate->kept = 0;
    estimate->jumps = 0;
    estimate->known = false;
    estimate->fix_recent = false;
    estimate->fix_us = 0;
    estimate->drift_rad_per_m = 0.0f;
    estimate->travel_m = 0.0f;
}

void cw_estimate_advance(cw_estimate *estimate, float track_m, uint32_t now_us, float left_m,
                         float right_m)
{
    float ds = (left_m + right_m) * 0.5f;
    float turn = (right_m - left_m) / track_m + estimate->drift_rad_per_m * ds;
    cw_pose *pose = &estimate->pose;
    if (left_m < 0.0f || left_m > 0.0f || right_m < 0.0f || right_m > 0.0f) {
        float middle = pose->heading_rad + turn * 0.5f;
        estimate->travel_m += ds;
        pose->x_m += ds * cosf(middle);
        pose->y_m += ds * sinf(middle);
        pose->heading_rad = cw_wrap_angle(pose->heading_rad + turn);
    }
    if (estimate->kept == 0u ||
        now_us - past_at(estimate, (uint8_t)(estimate->kept - 1u))->time_us >= HISTORY_STEP_US) {
        cw_past *newest;
        if (estimate->kept == CW_HISTORY) {
            estimate->oldest = (uint8_t)((estimate->oldest + 1u) % CW_HISTORY);
        } else {
            estimate->kept++;
        }
        newest = past_at(estimate, (uint8_t)(estimate->kept - 1u));
        newest->time_us = now_us;
        newest->pose = *pose;
    }
}

/* The estimate at a past time, interpolated; false where it is forgotten. */
static bool pose_then(cw_estimate *estimate, uint32_t time_us, uint32_t now_us, cw_pose *out_pose)
{
    uint32_t later_us = now_us;
    cw_pose later = estimate->pose;
    uint8_t i;
    for (i = estimate->kept; i-- > 0u;) {
        const cw_past *past = past_at(estimate, i);
        if ((int32_t)(time_us - past->time_us) >= 0) {
            uint32_t span = later_us - past->time_us;
            float t = span > 0u ? (float)(time_us - past->time_us) / (float)span : 1.0f;
            t = least(t, 1.0f);
            out_pose->x_m = past->pose.x_m + t * (later.x_m - past->pose.x_m);
            out_pose->y_m = past->pose.y_m + t * (later.y_m - past->pose.y_m);
            out_pose->heading_rad =
                cw_wrap_angle(past->pose.heading_rad +
                              t * cw_wrap_angle(later.heading_rad - past->pose.heading_rad));
            return true;
        }
        later_us = past->time_us;
        later = past->pose;
    }
    *out_pose = later;
    return estimate->kept == 0u || (int32_t)(time_us + HISTORY_STEP_US - later_us) >= 0;
}

static void move_about(cw_pose *pose, const cw_pose *about, float dx, float dy, float c, float s,
                       float turn)
{
    float rx = pose->x_m - about->x_m;
    float ry = pose->y_m - about->y_m;
    pose->x_m = about->x_m + dx + c * rx - s * ry;
    pose->y_m = about->y_m + dy + s * rx + c * ry;
    pose->heading_rad = cw_wrap_angle(pose->heading_rad + turn);
}

bool cw_estimate_correct(cw_estimate *estimate, cw_pose seen, uint32_t age_us, uint32_t now_us)
{
    uint32_t seen_us = now_us - age_us;
    cw_pose then;
    float dx, dy, turn, c, s;
    bool far;
    uint8_t i;
    if (!pose_then(estimate, seen_us, now_us, &then)) {
        return false;
    }
    dx = seen.x_m - then.x_m;
    dy = seen.y_m - then.y_m;
    turn = cw_wrap_angle(seen.heading_rad - then.heading_rad);
    far = length_of(dx, dy) > JUMP_M || fabsf(turn) > JUMP_RAD;
    if (estimate->known && far) {
        estimate->jumps++;
        if (estimate->jumps < JUMPS_BELIEVED) {
            return false;
        }
    }
    estimate->jumps = 0;
    if (estimate->known && !far) {
        estimate->drift_rad_per_m = limited(
            estimate->drift_rad_per_m + DRIFT_GAIN * turn * estimate->travel_m, DRIFT_MAX);
        dx *= POSITION_GAIN;
        dy *= POSITION_GAIN;
        turn *= HEADING_GAIN;
    }
    estimate->travel_m = 0.0f;
    c = cosf(turn);
    s = sinf(turn);
    move_about(&estimate->pose, &then, dx, dy, c, s, turn);
    for (i = 0; i < estimate->kept; i++) {
        move_about(&estimate->history[i].pose, &then, dx, dy, c, s, turn);
    }
    if (!estimate->fix_recent || (int32_t)(seen_us - estimate->fix_us) > 0) {
        estimate->fix_us = seen_us;
    }
    estimate->known = true;
    estimate->fix_recent = true;
    return true;
}

/* The queue. */

static place place_of(cw_targets targets, uint8_t index)
{
    const uint8_t *record = targets.get(targets.queue, index);
    place at;
    at.x = (float)(int32_t)cw_get_u32(record) * 1e-6f;
    at.y = (float)(int32_t)cw_get_u32(record + 4) * 1e-6f;
    return at;
}

static float speed_of(const uint8_t *record)
{
    return (float)cw_get_u16(record + 10) * 1e-3f;
}

static float acceptance_of(const uint8_t *record)
{
    return (float)cw_get_u16(record + 12) * 1e-4f;
}

static bool stops(const uint8_t *record)
{
    return record[15] != 0u;
}

/* Whether the line from `before` over `at` to waypoint `index` + 1 bends too much to drive. */
static bool is_corner(place before, place at, cw_targets targets, uint8_t index)
{
    float ax, ay, bx, by, dot, a2, b2;
    place after;
    if (index + 1u >= targets.count) {
        return false;
    }
    after = place_of(targets, (uint8_t)(index + 1u));
    ax = at.x - before.x;
    ay = at.y - before.y;
    bx = after.x - at.x;
    by = after.y - at.y;
    a2 = ax * ax + ay * ay;
    b2 = bx * bx + by * by;
    if (a2 < 1e-6f || b2 < 1e-6f) {
        return false;
    }
    dot = ax * bx + ay * by;
    return dot < 0.0f || dot * dot < TURN_ENTER_COS * TURN_ENTER_COS * a2 * b2;
}

/* The follower. */

static void new_target(cw_follower *follower)
{
    follower->attempts = 0;
    follower->still_s = 0.0f;
    follower->docking = false;
}

static void leave(cw_follower *follower, place at, const uint8_t *record)
{
    follower->from_x_m = at.x;
    follower->from_y_m = at.y;
    follower->from_speed_m_s = speed_of(record);
    new_target(follower);
}

void cw_follower_init(cw_follower *follower, const cw_drive_settings *settings)
{
    static const cw_pose origin = {0.0f, 0.0f, 0.0f};
    follower->settings = settings;
    follower->speed_m_s = 0.0f;
    follower->turn_rad_s = 0.0f;
    cw_follower_begin(follower, origin);
}

void cw_follower_begin(cw_follower *follower, cw_pose pose)
{
    follower->phase = CW_PHASE_TRACK;
    follower->from_x_m = pose.x_m;
    follower->from_y_m = pose.y_m;
    follower->from_speed_m_s = 0.0f;
    follower->first = true;
    new_target(follower);
    follower->progress_pose = pose;
    follower->progress_s = 0.0f;
}

void cw_follower_freeze(cw_follower *follower)
{
    follower->speed_m_s = 0.0f;
    follower->turn_rad_s = 0.0f;
}

static void slew_speed(cw_follower *follower, float speed, float dt_s)
{
    float step = follower->settings->acceleration_m_s2 * dt_s;
    follower->speed_m_s += limited(speed - follower->speed_m_s, step);
}

static void slew_turn(cw_follower *follower, float turn, float dt_s)
{
    float step = follower->settings->turn_acceleration_rad_s2 * dt_s;
    follower->turn_rad_s += limited(turn - follower->turn_rad_s, step);
}

static void slew(cw_follower *follower, float speed, float turn, float dt_s)
{
    slew_speed(follower, speed, dt_s);
    slew_turn(follower, turn, dt_s);
}

static float turn_towards(const cw_follower *follower, float off_rad)
{
    float off = fabsf(off_rad);
    float rate = least(follower->settings->max_turn_rad_s,
                       least(sqrtf(follower->settings->turn_acceleration_rad_s2 * off),
                             APPROACH_PER_S * off));
    rate = most(rate, 0.02f);
    return off_rad < 0.0f ? -rate : rate;
}

/* How far along the line the target still is, and how far the robot is beside the line or
 * behind its beginning. */
static float remaining_to(const cw_follower *follower, cw_pose pose, place at,
                          float *out_deviation)
{
    float dx = at.x - follower->from_x_m;
    float dy = at.y - follower->from_y_m;
    float length = length_of(dx, dy);
    float x = pose.x_m - follower->from_x_m;
    float y = pose.y_m - follower->from_y_m;
    *out_deviation = 0.0f;
    if (length < 1e-4f) {
        return 0.0f;
    }
    *out_deviation = most(fabsf(y * dx - x * dy), -(x * dx + y * dy)) / length;
    return ((at.x - pose.x_m) * dx + (at.y - pose.y_m) * dy) / length;
}

static uint8_t pass_waypoints(cw_follower *follower, cw_pose pose, cw_targets targets)
{
    uint8_t passed = 0;
    while ((follower->phase == CW_PHASE_TRACK || follower->phase == CW_PHASE_TURN) &&
           passed < targets.count) {
        const uint8_t *record = targets.get(targets.queue, passed);
        place at = place_of(targets, passed);
        float distance = length_of(at.x - pose.x_m, at.y - pose.y_m);
        float deviation, radius;
        place from;
        if (stops(record)) {
            if (follower->first && distance <= START_RADIUS_M) {
                follower->phase = CW_PHASE_SETTLE;
            }
            break;
        }
        radius = most(acceptance_of(record), PASS_RADIUS_M);
        if (follower->first) {
            radius = most(radius, START_RADIUS_M);
        }
        from.x = follower->from_x_m;
        from.y = follower->from_y_m;
        if (is_corner(from, at, targets, passed)) {
            radius = follower->first ? START_RADIUS_M : STOP_TOLERANCE_M;
        }
        if (distance > radius && remaining_to(follower, pose, at, &deviation) > 0.0f) {
            break;
        }
        leave(follower, at, record);
        follower->first = false;
        passed++;
    }
    return passed;
}

/* The point on the line that is pursued. */
static place lookahead(const cw_follower *follower, cw_pose pose, cw_targets targets,
                       uint8_t begin)
{
    float left = follower->settings->lookahead_m +
                 follower->settings->lookahead_s * fabsf(follower->speed_m_s);
    place start, before;
    uint8_t i;
    start.x = follower->from_x_m;
    start.y = follower->from_y_m;
    before = start;
    for (i = begin; i < targets.count; i++) {
        place at = place_of(targets, i);
        float dx = at.x - start.x;
        float dy = at.y - start.y;
        float length = length_of(dx, dy);
        float along = 0.0f;
        if (length < 1e-4f) {
            before = at;
            continue;
        }
        dx /= length;
        dy /= length;
        if (i == begin) {
            along = most(0.0f, (pose.x_m - start.x) * dx + (pose.y_m - start.y) * dy);
        }
        if (i + 1u >= targets.count || stops(targets.get(targets.queue, i)) ||
            along + left <= length || is_corner(before, at, targets, i)) {
            start.x += dx * (along + left);
            start.y += dy * (along + left);
            return start;
        }
        left -= most(0.0f, length - along);
        start = at;
        before = at;
    }
    return start;
}

/* The curvature that leads to the pursued point, and its bearing. */
static float steer(const cw_follower *follower, cw_pose pose, cw_targets targets, uint8_t begin,
                   float *out_off)
{
    place ahead = lookahead(follower, pose, targets, begin);
    float dx = ahead.x - pose.x_m;
    float dy = ahead.y - pose.y_m;
    *out_off = cw_wrap_angle(atan2f(dy, dx) - pose.heading_rad);
    return 2.0f * sinf(*out_off) / most(1e-6f, length_of(dx, dy));
}

/* What the waypoints ahead allow here: each its speed plus what the brakes take back. */
static float speed_limit(const cw_follower *follower, float remaining, cw_targets targets,
                         uint8_t begin)
{
    float brake = 2.0f * 0.8f * follower->settings->acceleration_m_s2;
    float allowed = follower->settings->max_speed_m_s;
    float either = most(follower->from_speed_m_s, speed_of(targets.get(targets.queue, begin)));
    float ahead = most(0.0f, remaining);
    float horizon;
    place before;
    uint8_t i;
    before.x = follower->from_x_m;
    before.y = follower->from_y_m;
    if (either > 0.0f) {
        allowed = least(allowed, either);
    }
    horizon = allowed * allowed / brake;
    for (i = begin; i < targets.count; i++) {
        const uint8_t *record = targets.get(targets.queue, i);
        place at = place_of(targets, i);
        place after;
        float speed;
        if (stops(record) || i + 1u >= targets.count || is_corner(before, at, targets, i)) {
            return least(allowed, least(sqrtf(brake * ahead), APPROACH_PER_S * ahead));
        }
        speed = speed_of(record);
        allowed = least(allowed, sqrtf(speed * speed + brake * ahead));
        if (ahead > horizon) {
            break;
        }
        after = place_of(targets, (uint8_t)(i + 1u));
        ahead += length_of(after.x - at.x, after.y - at.y);
        before = at;
    }
    return allowed;
}

static cw_trouble track(cw_follower *follower, float dt_s, cw_pose pose, cw_targets targets,
                        uint8_t begin)
{
    float deviation, off, curvature, speed, enter;
    float remaining = remaining_to(follower, pose, place_of(targets, begin), &deviation);
    if (stops(targets.get(targets.queue, begin)) && remaining <= 0.001f) {
        follower->phase = CW_PHASE_SETTLE;
        slew(follower, 0.0f, 0.0f, dt_s);
        return CW_TROUBLE_NONE;
    }
    if (deviation > follower->settings->max_deviation_m) {
        return CW_TROUBLE_OFF_PATH;
    }
    curvature = steer(follower, pose, targets, begin, &off);
    enter = fabsf(follower->speed_m_s) < STANDING_M_S ? TURN_STANDING_RAD : TURN_ENTER_RAD;
    if (fabsf(off) > (follower->phase == CW_PHASE_TURN ? TURN_EXIT_RAD : enter)) {
        follower->phase = CW_PHASE_TURN;
        slew(follower, 0.0f, turn_towards(follower, off), dt_s);
        return CW_TROUBLE_NONE;
    }
    follower->phase = CW_PHASE_TRACK;
    speed = speed_limit(follower, remaining, targets, begin);
    if (fabsf(curvature) > 1e-6f) {
        float bend = fabsf(curvature);
        speed = least(speed, sqrtf(follower->settings->lateral_m_s2 / bend));
        speed = least(speed, follower->settings->max_turn_rad_s / bend);
    }
    follower->first = false;
    slew_speed(follower, most(speed, CRAWL_M_S), dt_s);
    slew_turn(follower, curvature * follower->speed_m_s, dt_s);
    return CW_TROUBLE_NONE;
}

static void count_standing(cw_follower *follower, float dt_s, float measured_m_s)
{
    bool standing = fabsf(measured_m_s) < 0.004f && fabsf(follower->speed_m_s) <= 0.0f &&
                    fabsf(follower->turn_rad_s) <= 0.0f;
    follower->still_s = standing ? follower->still_s + dt_s : 0.0f;
}

static void begin_docking(cw_follower *follower)
{
    follower->phase = CW_PHASE_DOCK;
    follower->docking = false;
    follower->attempts++;
}

static float distance_to(cw_pose pose, place at)
{
    return length_of(at.x - pose.x_m, at.y - pose.y_m);
}

static void settle(cw_follower *follower, float dt_s, cw_pose pose, float measured_m_s, place at,
                   const uint8_t *record)
{
    slew(follower, 0.0f, 0.0f, dt_s);
    count_standing(follower, dt_s, measured_m_s);
    if (follower->still_s < SETTLE_S) {
        return;
    }
    follower->still_s = 0.0f;
    if (distance_to(pose, at) > most(acceptance_of(record), STOP_TOLERANCE_M)) {
        begin_docking(follower);
    } else if ((int16_t)cw_get_u16(record + 8) == CW_HEADING_FREE) {
        follower->phase = CW_PHASE_DWELL;
    } else {
        follower->phase = CW_PHASE_ALIGN;
    }
}

/* Drive straight to the target, forwards or backwards, turning towards it first. */
static void dock(cw_follower *follower, float dt_s, cw_pose pose, place at)
{
    float dx = at.x - pose.x_m;
    float dy = at.y - pose.y_m;
    float c = cosf(pose.heading_rad);
    float s = sinf(pose.heading_rad);
    float forward = c * dx + s * dy;
    float sideways = c * dy - s * dx;
    float off = atan2f(sideways, forward);
    float speed;
    if (fabsf(off) > PI / 2.0f) {
        off = cw_wrap_angle(off + PI);
    }
    if (!follower->docking && fabsf(off) > 0.15f && fabsf(sideways) > 0.3f * STOP_TOLERANCE_M) {
        slew(follower, 0.0f, turn_towards(follower, off), dt_s);
        return;
    }
    follower->docking = true;
    if (fabsf(forward) < 0.0007f) {
        slew(follower, 0.0f, 0.0f, dt_s);
        follower->phase = CW_PHASE_SETTLE;
        follower->still_s = 0.0f;
        return;
    }
    speed = most(CRAWL_M_S, least(DOCK_SPEED_M_S, APPROACH_PER_S * fabsf(forward)));
    slew(follower, forward < 0.0f ? -speed : speed, 0.0f, dt_s);
}

static void align(cw_follower *follower, float dt_s, cw_pose pose, float measured_m_s, place at,
                  const uint8_t *record)
{
    float heading = (float)(int16_t)cw_get_u16(record + 8) * 1e-4f;
    float off = cw_wrap_angle(heading - pose.heading_rad);
    if (fabsf(off) > HEADING_TOLERANCE_RAD) {
        follower->still_s = 0.0f;
        slew(follower, 0.0f, turn_towards(follower, off), dt_s);
        return;
    }
    slew(follower, 0.0f, 0.0f, dt_s);
    count_standing(follower, dt_s, measured_m_s);
    if (follower->still_s < SETTLE_S) {
        return;
    }
    follower->still_s = 0.0f;
    if (distance_to(pose, at) > most(acceptance_of(record), 1.5f * STOP_TOLERANCE_M)) {
        begin_docking(follower);
    } else {
        follower->phase = CW_PHASE_DWELL;
    }
}

static bool is_stuck(cw_follower *follower, float dt_s, cw_pose pose)
{
    const cw_pose *was = &follower->progress_pose;
    float moved = length_of(pose.x_m - was->x_m, pose.y_m - was->y_m);
    float turned = fabsf(cw_wrap_angle(pose.heading_rad - was->heading_rad));
    if (follower->phase == CW_PHASE_SETTLE || follower->phase == CW_PHASE_DWELL ||
        moved > 0.003f || turned > 0.03f) {
        follower->progress_pose = pose;
        follower->progress_s = 0.0f;
        return false;
    }
    follower->progress_s += dt_s;
    return follower->progress_s > STUCK_S;
}

uint8_t cw_follower_halt(cw_follower *follower, float dt_s, cw_pose pose, cw_targets targets)
{
    float curvature, off;
    uint8_t executed;
    if (follower->speed_m_s <= 0.0f || follower->phase != CW_PHASE_TRACK) {
        slew(follower, 0.0f, 0.0f, dt_s);
        return 0;
    }
    executed = pass_waypoints(follower, pose, targets);
    if (executed < targets.count && follower->phase == CW_PHASE_TRACK) {
        curvature = steer(follower, pose, targets, executed, &off);
    } else {
        curvature = follower->turn_rad_s / follower->speed_m_s;
    }
    slew_speed(follower, 0.0f, dt_s);
    slew_turn(follower, curvature * follower->speed_m_s, dt_s);
    return executed;
}

uint8_t cw_follower_step(cw_follower *follower, float dt_s, cw_pose pose, float measured_m_s,
                         cw_targets targets, cw_trouble *out_trouble)
{
    uint8_t executed = pass_waypoints(follower, pose, targets);
    const uint8_t *record;
    place at;
    *out_trouble = CW_TROUBLE_NONE;
    if (executed == targets.count) {
        follower->progress_s = 0.0f;
        slew(follower, 0.0f, 0.0f, dt_s);
        return executed;
    }
    record = targets.get(targets.queue, executed);
    at = place_of(targets, executed);
    switch ((cw_phase)follower->phase) {
    case CW_PHASE_TRACK:
    case CW_PHASE_TURN:
        *out_trouble = track(follower, dt_s, pose, targets, executed);
        break;
    case CW_PHASE_SETTLE:
        settle(follower, dt_s, pose, measured_m_s, at, record);
        break;
    case CW_PHASE_DOCK:
        dock(follower, dt_s, pose, at);
        break;
    case CW_PHASE_ALIGN:
        align(follower, dt_s, pose, measured_m_s, at, record);
        break;
    case CW_PHASE_DWELL:
    default:
        slew(follower, 0.0f, 0.0f, dt_s);
        follower->still_s += dt_s;
        if (follower->still_s >= (float)record[14] * 0.1f) {
            executed++;
            follower->phase = CW_PHASE_TRACK;
            leave(follower, at, record);
        }
        break;
    }
    if (*out_trouble == CW_TROUBLE_NONE &&
        (follower->attempts > DOCK_ATTEMPTS || is_stuck(follower, dt_s, pose))) {
        *out_trouble = CW_TROUBLE_STUCK;
    }
    return executed;
}
