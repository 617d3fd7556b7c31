#include "follower.h"

#include <string.h>

#include "wire.h"

#define TURN_ENTER CW_MRAD(800)
#define TURN_STANDING CW_MRAD(200)
#define STANDING_Q10 20480l /* 20 mm/s */
#define TURN_EXIT CW_MRAD(40)
#define PASS_RADIUS_UM 5000
#define START_RADIUS_UM 20000
#define STOP_TOLERANCE_UM 3000
#define TURNED_TOLERANCE_UM 4500
#define HEADING_TOLERANCE CW_MRAD(6)
#define SETTLE_US 250000ul
#define STUCK_US 3000000ul
#define DOCK_ATTEMPTS 8u
#define CRAWL_Q10 10240l
#define DOCK_SPEED_Q10 61440l
#define DOCK_BEARING CW_MRAD(150)
#define SHORT_UM 1000 /* a line shorter than this has no direction */

#define FAR_UM 0x10000000l /* 268 m; a line counts as no longer */

/* Of the settings; a compiler that knows them computes these. */
#define TRACK_HUNDREDTHS (cw_robot_settings.track_um / 100u)
#define SPIN_OF(milliradians) ((uint32_t)(milliradians) * TRACK_HUNDREDTHS / 20000u) /* mm/s */
#define MAX_SPIN_MM_S SPIN_OF(cw_robot_settings.max_turn_mrad_s)
#define SPIN_BRAKE_MM_S2 ((uint16_t)SPIN_OF(cw_robot_settings.turn_acceleration_mrad_s2))
#define BRAKE_MM_S2 ((uint16_t)((uint32_t)cw_robot_settings.acceleration_mm_s2 * 8u / 5u))
#define PERIMETER_UM ((int32_t)(TRACK_HUNDREDTHS * 31416u / 100u)) /* of a turn on the spot */
#define MIN_SPIN_Q10 ((int32_t)TRACK_HUNDREDTHS)                   /* 20 mrad/s */
#define PER_CYCLE(mm_s2) ((uint16_t)((uint32_t)(mm_s2) * 4194u / 1000u))
#define BEND_LIMIT                                                                               \
    ((uint32_t)cw_robot_settings.lateral_mm_s2 * (cw_robot_settings.track_um / 2000u) * 1024u)

/* The way to the waypoint at the queue's head, and where the robot is on it. */
typedef struct {
    cw_vector leg;        /* x: its length, angle: its direction */
    int32_t distance_um;  /* of the robot from the waypoint */
    int32_t remaining_um; /* along the leg; negative behind the waypoint */
    int32_t beside_um;    /* beside the leg, or behind its beginning */
} sight;

static void look(const cw_follower *follower, const cw_pose *pose, cw_place at, sight *out)
{
    cw_vector vector;
    cw_between(pose->place, at, &vector);
    cw_measure(&vector);
    out->distance_um = vector.x;
    cw_between(follower->from, at, &out->leg);
    cw_measure(&out->leg);
    out->remaining_um = 0;
    out->beside_um = 0;
    if (out->leg.x >= SHORT_UM / 10) {
        cw_between(follower->from, pose->place, &vector);
        vector.angle = cw_difference(0, out->leg.angle);
        cw_turn(&vector);
        out->remaining_um = out->leg.x - vector.x;
        out->beside_um = vector.y < 0 ? -vector.y : vector.y;
        if (-vector.x > out->beside_um) {
            out->beside_um = -vector.x;
        }
    }
}

/* Whether the line bends at the end of `leg`, on the way to waypoint `next`, too much to be
 * driven; `leg` becomes the way there. A short one keeps the direction of the one before. */
static bool next_leg(cw_vector *leg, const cw_waypoint *at, const cw_waypoint *next)
{
    bool was_short = leg->x < SHORT_UM;
    int32_t before = leg->angle;
    cw_between(at->place, next->place, leg);
    cw_measure(leg);
    if (leg->x < SHORT_UM) {
        leg->angle = before;
    }
    return !was_short && cw_size(cw_difference(leg->angle, before)) > (uint32_t)TURN_ENTER;
}

static void new_target(cw_follower *follower)
{
    follower->attempts = 0;
    follower->still_us = 0;
    follower->docking = false;
}

static void leave(cw_follower *follower, const cw_waypoint *at)
{
    follower->from = at->place;
    follower->from_speed_mm_s = at->speed_mm_s;
    new_target(follower);
}

void cw_follower_init(cw_follower *follower)
{
    memset(follower, 0, sizeof *follower);
    follower->first = true;
}

void cw_follower_begin(cw_follower *follower, const cw_pose *pose)
{
    follower->phase = CW_PHASE_TRACK;
    follower->from = pose->place;
    follower->from_speed_mm_s = 0;
    follower->first = true;
    new_target(follower);
    follower->progress = *pose;
    follower->progress_us = 0;
}

void cw_follower_freeze(cw_follower *follower)
{
    follower->speed_q10 = 0;
    follower->spin_q10 = 0;
}

/* Speeds. */

static void slew(int32_t *speed, int32_t wanted, uint16_t dt_us, uint16_t per_cycle)
{
    int32_t step = (int32_t)((uint32_t)dt_us * per_cycle >> 12);
    int32_t change = wanted - *speed;
    *speed += change > step ? step : change < -step ? -step : change;
}

static void slew_speed(cw_follower *follower, int32_t speed_q10, uint16_t dt_us)
{
    slew(&follower->speed_q10, speed_q10, dt_us,
         PER_CYCLE(cw_robot_settings.acceleration_mm_s2));
}

static void slew_spin(cw_follower *follower, int32_t spin_q10, uint16_t dt_us)
{
    slew(&follower->spin_q10, spin_q10, dt_us, PER_CYCLE(SPIN_BRAKE_MM_S2));
}

static void stand(cw_follower *follower, int32_t spin_q10, uint16_t dt_us)
{
    slew_speed(follower, 0, dt_us);
    slew_spin(follower, spin_q10, dt_us);
}

static void drive_along(cw_follower *follower, int32_t speed_q10, uint16_t dt_us)
{
    int32_t bend = follower->bend;
    int32_t spin;
    slew_speed(follower, speed_q10, dt_us);
    spin = cw_scale(follower->speed_q10, (uint16_t)cw_size(bend)) * 4;
    slew_spin(follower, bend < 0 ? -spin : spin, dt_us);
}

/* The square of the speed in mm/s that brakes take back within a distance; brakes are believed
 * to be 2 % weaker than they are, so that a thousand may be 1024. */
static uint32_t braked(int32_t distance_um, uint16_t brake_mm_s2)
{
    if (distance_um > 0x3FFFFF) {
        distance_um = 0x3FFFFF; /* 4 m */
    }
    return ((uint32_t)(uint16_t)(distance_um >> 6) * brake_mm_s2) >> 4;
}

/* The speed towards a stop: the square root alone would arrive with a jerk that slow motors
 * cannot follow, so near it the speed is four times the distance left, a second. */
static int32_t approach(uint32_t square, int32_t distance_um)
{
    int32_t speed = (int32_t)cw_root(square) * 1024;
    if (distance_um < 0x1000000 && distance_um * 4 < speed) {
        speed = distance_um * 4;
    }
    return speed;
}

static int32_t turn_towards(int32_t off)
{
    uint16_t part = (uint16_t)(cw_size(off) >> 16);
    int32_t arc_um = cw_scale(PERIMETER_UM, part);
    int32_t spin = approach(braked(arc_um, SPIN_BRAKE_MM_S2), arc_um);
    if (spin > (int32_t)(MAX_SPIN_MM_S * 1024u)) {
        spin = (int32_t)(MAX_SPIN_MM_S * 1024u);
    }
    if (spin < MIN_SPIN_Q10) {
        spin = MIN_SPIN_Q10;
    }
    return off < 0 ? -spin : spin;
}

/* Following the line. */

static uint8_t pass_waypoints(cw_follower *follower, const cw_pose *pose, cw_queue *queue,
                              sight *out)
{
    uint8_t passed = 0;
    while (passed < queue->count) {
        const cw_waypoint *at = cw_queue_at(queue, passed);
        int32_t radius = (int32_t)at->acceptance * 100;
        look(follower, pose, at->place, out);
        if (follower->phase > CW_PHASE_TURN) {
            break;
        }
        if (at->flags != 0u) {
            if (follower->first && out->distance_um <= START_RADIUS_UM) {
                follower->phase = CW_PHASE_SETTLE;
            }
            break;
        }
        if (radius < PASS_RADIUS_UM) {
            radius = PASS_RADIUS_UM;
        }
        if (follower->first && radius < START_RADIUS_UM) {
            radius = START_RADIUS_UM;
        }
        if (passed + 1u < queue->count) {
            cw_vector leg = out->leg;
            if (next_leg(&leg, at, cw_queue_at(queue, (uint8_t)(passed + 1u)))) {
                radius = follower->first ? START_RADIUS_UM : STOP_TOLERANCE_UM;
            }
        }
        if (out->distance_um > radius && out->remaining_um > 0) {
            break;
        }
        leave(follower, at);
        follower->first = false;
        passed++;
    }
    return passed;
}

/* Walk along the line ahead: find the point that is pursued, steer to it (`bend`), and see what
 * speed the waypoints allow here, each its own plus what the brakes take back. Returns the speed
 * towards the line's next stop; `out_off` is the bearing of the pursued point. */
static int32_t steer(cw_follower *follower, const cw_pose *pose, cw_queue *queue, uint8_t begin,
                     const sight *seen, int32_t *out_off)
{
    const cw_waypoint *at = cw_queue_at(queue, begin);
    cw_vector leg = seen->leg, point;
    cw_place pursued;
    bool found = false;
    int32_t ahead_um = seen->remaining_um;
    int32_t lookahead_um =
        (int32_t)cw_robot_settings.lookahead_mm * 1000 +
        (int32_t)cw_scale((int32_t)cw_size(follower->speed_q10), cw_robot_settings.lookahead_ms) *
            64;
    uint16_t fast = cw_robot_settings.max_speed_mm_s;
    uint16_t either = follower->from_speed_mm_s > at->speed_mm_s ? follower->from_speed_mm_s
                                                                 : at->speed_mm_s;
    uint32_t square, bend;
    int32_t speed;
    if (either != 0u && either < fast) {
        fast = either; /* a line is driven at the speed of its faster end */
    }
    square = (uint32_t)fast * fast;
    pursued = at->place;
    for (;;) {
        cw_vector next = leg;
        const cw_waypoint *after = cw_queue_at(queue, (uint8_t)(begin + 1u));
        bool last = begin + 1u >= queue->count || at->flags != 0u || next_leg(&next, at, after);
        uint32_t allowed;
        if (ahead_um < 0) {
            ahead_um = 0;
        } else if (ahead_um > FAR_UM) {
            ahead_um = FAR_UM;
        }
        if (!found && (last || ahead_um >= lookahead_um)) {
            found = true;
            point.x = lookahead_um - ahead_um;
            point.y = 0;
            point.angle = leg.angle;
            cw_turn(&point);
            pursued.x_um = cw_sum(at->place.x_um, point.x);
            pursued.y_um = cw_sum(at->place.y_um, point.y);
        }
        allowed = braked(ahead_um, BRAKE_MM_S2);
        if (last) {
            speed = approach(allowed < square ? allowed : square, ahead_um);
            break;
        }
        if (found && allowed >= square) {
            speed = (int32_t)cw_root(square) * 1024;
            break;
        }
        allowed += (uint32_t)at->speed_mm_s * at->speed_mm_s;
        if (allowed < square) {
            square = allowed;
        }
        ahead_um += next.x;
        leg = next;
        at = after;
        begin++;
    }
    cw_between(pose->place, pursued, &point);
    cw_measure(&point);
    *out_off = cw_difference(point.angle, pose->heading);
    square = (uint32_t)point.x >> 3;
    if (square == 0u) {
        square = 1;
    }
    point.x = 32768;
    point.y = 0;
    point.angle = (int32_t)cw_size(*out_off);
    cw_turn(&point);
    /* pure pursuit: the bend is twice the bearing's sine over the distance */
    bend = ((cw_robot_settings.track_um >> 3) * (uint32_t)point.y >> 1) / square;
    if (bend > 0xFFFFu) {
        bend = 0xFFFFu;
    }
    follower->bend = *out_off < 0 ? -(int32_t)bend : (int32_t)bend;
    bend >>= 4;
    if (bend != 0u) {
        uint32_t limit = (uint32_t)cw_root(BEND_LIMIT / bend) * 1024u;
        if ((uint32_t)speed > limit) {
            speed = (int32_t)limit;
        }
        limit = (MAX_SPIN_MM_S << 20) / bend;
        if ((uint32_t)speed > limit) {
            speed = (int32_t)limit;
        }
    }
    return speed;
}

static cw_trouble track(cw_follower *follower, uint16_t dt_us, const cw_pose *pose,
                        cw_queue *queue, uint8_t begin, const sight *seen)
{
    int32_t off, speed, enter;
    if (cw_queue_at(queue, begin)->flags != 0u && seen->remaining_um <= SHORT_UM) {
        follower->phase = CW_PHASE_SETTLE;
        stand(follower, 0, dt_us);
        return CW_TROUBLE_NONE;
    }
    if (seen->beside_um > (int32_t)cw_robot_settings.max_deviation_mm * 1000) {
        return CW_TROUBLE_OFF_PATH;
    }
    speed = steer(follower, pose, queue, begin, seen, &off);
    enter = follower->speed_q10 < STANDING_Q10 ? TURN_STANDING : TURN_ENTER;
    if (follower->phase == CW_PHASE_TURN) {
        enter = TURN_EXIT;
    }
    if (cw_size(off) > (uint32_t)enter) {
        follower->phase = CW_PHASE_TURN;
        stand(follower, turn_towards(off), dt_us);
        return CW_TROUBLE_NONE;
    }
    follower->phase = CW_PHASE_TRACK;
    follower->first = false;
    drive_along(follower, speed > CRAWL_Q10 ? speed : CRAWL_Q10, dt_us);
    return CW_TROUBLE_NONE;
}

/* Stopping. */

static bool stands_long_enough(cw_follower *follower, uint16_t dt_us, bool still)
{
    stand(follower, 0, dt_us);
    if (!still || follower->speed_q10 != 0 || follower->spin_q10 != 0) {
        follower->still_us = 0;
        return false;
    }
    follower->still_us += dt_us;
    return follower->still_us >= SETTLE_US;
}

/* Whether the robot stands near enough; otherwise it docks. */
static bool is_there(cw_follower *follower, const cw_waypoint *at, const sight *seen,
                     int32_t tolerance_um)
{
    int32_t radius = (int32_t)at->acceptance * 100;
    follower->still_us = 0;
    if (seen->distance_um <= (radius > tolerance_um ? radius : tolerance_um)) {
        return true;
    }
    follower->phase = CW_PHASE_DOCK;
    follower->docking = false;
    follower->attempts++;
    return false;
}

static void settle(cw_follower *follower, uint16_t dt_us, bool still, const cw_waypoint *at,
                   const sight *seen)
{
    if (stands_long_enough(follower, dt_us, still) &&
        is_there(follower, at, seen, STOP_TOLERANCE_UM)) {
        follower->phase = at->heading == CW_HEADING_FREE ? CW_PHASE_DWELL : CW_PHASE_ALIGN;
    }
}

/* Drive straight to the target, forwards or backwards, turning towards it first. */
static void dock(cw_follower *follower, uint16_t dt_us, const cw_pose *pose, cw_place place)
{
    cw_vector to;
    int32_t speed, off;
    bool back;
    cw_between(pose->place, place, &to);
    to.angle = cw_difference(0, pose->heading);
    cw_turn(&to);
    back = to.x < 0;
    if (back) {
        to.x = -to.x;
        to.y = -to.y;
    }
    if (!follower->docking && cw_size(to.y) > STOP_TOLERANCE_UM * 3 / 10) {
        cw_vector copy = to;
        cw_measure(&copy);
        off = copy.angle;
        if (cw_size(off) > (uint32_t)DOCK_BEARING) {
            stand(follower, turn_towards(off), dt_us);
            return;
        }
    }
    follower->docking = true;
    if (to.x < 700) {
        stand(follower, 0, dt_us);
        follower->phase = CW_PHASE_SETTLE;
        follower->still_us = 0;
        return;
    }
    speed = to.x > DOCK_SPEED_Q10 / 4 ? DOCK_SPEED_Q10 : to.x * 4;
    if (speed < CRAWL_Q10) {
        speed = CRAWL_Q10;
    }
    slew_speed(follower, back ? -speed : speed, dt_us);
    slew_spin(follower, 0, dt_us);
}

static void align(cw_follower *follower, uint16_t dt_us, const cw_pose *pose, bool still,
                  const cw_waypoint *at, const sight *seen)
{
    int32_t off = cw_difference(cw_angle_of(at->heading), pose->heading);
    if (cw_size(off) > (uint32_t)HEADING_TOLERANCE) {
        follower->still_us = 0;
        stand(follower, turn_towards(off), dt_us);
    } else if (stands_long_enough(follower, dt_us, still) &&
               is_there(follower, at, seen, TURNED_TOLERANCE_UM)) {
        follower->phase = CW_PHASE_DWELL;
    }
}

static bool is_stuck(cw_follower *follower, uint16_t dt_us, const cw_pose *pose)
{
    const cw_pose *was = &follower->progress;
    if (follower->phase == CW_PHASE_SETTLE || follower->phase == CW_PHASE_DWELL ||
        cw_size(cw_difference(pose->place.x_um, was->place.x_um)) > 3000u ||
        cw_size(cw_difference(pose->place.y_um, was->place.y_um)) > 3000u ||
        cw_size(cw_difference(pose->heading, was->heading)) > (uint32_t)CW_MRAD(30)) {
        follower->progress = *pose;
        follower->progress_us = 0;
        return false;
    }
    follower->progress_us += dt_us;
    return follower->progress_us > STUCK_US;
}

uint8_t cw_follower_halt(cw_follower *follower, uint16_t dt_us, const cw_pose *pose,
                         cw_queue *queue)
{
    uint8_t executed = 0;
    if (follower->speed_q10 <= 0 || follower->phase != CW_PHASE_TRACK) {
        stand(follower, 0, dt_us);
    } else {
        sight seen;
        int32_t off;
        executed = pass_waypoints(follower, pose, queue, &seen);
        if (executed < queue->count && follower->phase == CW_PHASE_TRACK) {
            (void)steer(follower, pose, queue, executed, &seen, &off);
        }
        drive_along(follower, 0, dt_us);
    }
    return executed;
}

uint8_t cw_follower_step(cw_follower *follower, uint16_t dt_us, const cw_pose *pose, bool still,
                         cw_queue *queue, cw_trouble *out_trouble)
{
    sight seen;
    uint8_t executed = pass_waypoints(follower, pose, queue, &seen);
    const cw_waypoint *at = cw_queue_at(queue, executed);
    *out_trouble = CW_TROUBLE_NONE;
    if (executed == queue->count) {
        follower->progress_us = 0;
        stand(follower, 0, dt_us);
        return executed;
    }
    if (follower->phase <= CW_PHASE_TURN) {
        *out_trouble = track(follower, dt_us, pose, queue, executed, &seen);
    } else if (follower->phase == CW_PHASE_SETTLE) {
        settle(follower, dt_us, still, at, &seen);
    } else if (follower->phase == CW_PHASE_DOCK) {
        dock(follower, dt_us, pose, at->place);
    } else if (follower->phase == CW_PHASE_ALIGN) {
        align(follower, dt_us, pose, still, at, &seen);
    } else {
        stand(follower, 0, dt_us);
        follower->still_us += dt_us;
        if (follower->still_us > (uint32_t)at->dwell * 100000u) {
            executed++;
            follower->phase = CW_PHASE_TRACK;
            leave(follower, at);
        }
    }
    if (*out_trouble == CW_TROUBLE_NONE &&
        (follower->attempts > DOCK_ATTEMPTS || is_stuck(follower, dt_us, pose))) {
        *out_trouble = CW_TROUBLE_STUCK;
    }
    return executed;
}
