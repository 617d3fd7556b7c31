#include "follower.h"

#include <string.h>

#include "flash.h"
#include "wire.h"

#define TURN_ENTER CW_MRAD(800)
#define TURN_STANDING CW_MRAD(200)
#define TURN_EXIT CW_MRAD(40)
#define AIM_MS 16u
#define DOCK_BEARING CW_MRAD(150)
#define STANDING (20 * 8)
#define CRAWL (10 * 8)
#define DOCK_SPEED (60 * 8)
#define LENGTH(um) ((um) / 64)
#define PASS_RADIUS LENGTH(5000)
#define START_RADIUS LENGTH(20000)
#define STOP_TOLERANCE LENGTH(2000)
#define TURNED_TOLERANCE LENGTH(3000)
#define SIDEWAYS LENGTH(900)
#define DOCKED LENGTH(700)
#define SHORT LENGTH(1000)  /* a line shorter than this has no direction */
#define NOWHERE LENGTH(128) /* a line shorter than this is none */
#define FAR 32000           /* 2 m */
#define MOST_SPIN (2000 * 8)
#define SETTLE_US 250000ul
#define STOOD_UM 1000u /* in that time: 4 mm/s */
#define STUCK_US 3000000ul
#define PROGRESS 12u /* of 256 um */
#define DOCK_ATTEMPTS 8u

/* Of the settings; a compiler that knows them computes these. */
#define TRACK_HUNDREDTHS (cw_robot_settings.track_um / 100u)
#define SPIN_OF(milliradians) ((uint32_t)(milliradians) * TRACK_HUNDREDTHS / 20000u) /* mm/s */
#define MAX_SPIN_MM_S ((uint16_t)SPIN_OF(cw_robot_settings.max_turn_mrad_s))
#define SPIN_BRAKE_MM_S2 ((uint16_t)SPIN_OF(cw_robot_settings.turn_acceleration_mrad_s2))
#define BRAKE_MM_S2 ((uint16_t)((uint32_t)cw_robot_settings.acceleration_mm_s2 * 8u / 5u))
#define TRACK ((uint16_t)LENGTH(cw_robot_settings.track_um))
#define PERIMETER ((uint16_t)(TRACK_HUNDREDTHS * 31416u / 6400u)) /* of a turn on the spot */
#define MIN_SPIN ((int16_t)(TRACK_HUNDREDTHS / 128u + 1u))         /* 20 mrad/s */
#define PULSE_TURN                                                                               \
    ((uint16_t)((uint32_t)cw_robot_settings.least_wheel_mm_s * AIM_MS * CW_ANGLE_PER_UM >> 16))
#define HEADING_TOLERANCE (PULSE_TURN > CW_MRAD(6) ? PULSE_TURN : CW_MRAD(6))
#define PER_CYCLE(mm_s2) ((uint16_t)((uint32_t)(mm_s2) * 4194u / 8000u))
#define BEND_LIMIT                                                                               \
    ((uint32_t)cw_robot_settings.lateral_mm_s2 * (cw_robot_settings.track_um / 2000u) * 1024u)

/* Quarters as a length. */
static int16_t length_of(int32_t quarters)
{
    return cw_clip(quarters >> 4, FAR);
}

CW_APART static uint16_t heading_of(const int32_t *pose)
{
    return (uint16_t)(pose[2] >> 16);
}

static uint16_t aside(uint16_t angle)
{
    return cw_short_size((int16_t)angle);
}

CW_APART static void look(cw_follower *follower, const int32_t *pose, const int32_t *at)
{
    int32_t vector[2];
    uint16_t bearing;
    cw_between(follower->from, at, vector);
    follower->leg.direction = cw_measure(vector);
    follower->leg.length = (uint16_t)length_of(vector[0]);
    cw_between(at, pose, vector);
    bearing = cw_measure(vector);
    follower->distance = length_of(vector[0]);
    follower->remaining = 0;
    follower->beside = 0;
    if (follower->leg.length >= NOWHERE) {
        vector[1] = 0;
        cw_turn(vector, (uint16_t)(bearing - follower->leg.direction));
        follower->remaining = (int16_t)-length_of(vector[0]);
        follower->beside = (int16_t)cw_short_size(length_of(vector[1]));
        if (follower->remaining > 0 &&
            follower->remaining - (int16_t)follower->leg.length > follower->beside) {
            follower->beside = (int16_t)(follower->remaining - (int16_t)follower->leg.length);
        }
    }
}

/* Whether the line bends at the end of a leg, on the way to the next waypoint, too much to be
 * driven; the leg becomes the way there. A short one keeps the direction of the one before. */
static bool next_leg(cw_leg *leg, const cw_waypoint *at, const cw_waypoint *next)
{
    int32_t vector[2];
    bool was_short = leg->length < SHORT;
    uint16_t before = leg->direction;
    uint16_t direction;
    cw_between(at->place, next->place, vector);
    direction = cw_measure(vector);
    leg->length = (uint16_t)length_of(vector[0]);
    if (leg->length < SHORT) {
        return false;
    }
    leg->direction = direction;
    return !was_short && aside((uint16_t)(direction - before)) > TURN_ENTER;
}

static void new_target(cw_follower *follower)
{
    follower->attempts = 0;
    follower->still_us = 0;
    follower->docking = false;
}

CW_APART static void leave(cw_follower *follower, const cw_waypoint *at)
{
    memcpy(follower->from, at->place, sizeof follower->from);
    follower->from_speed_mm_s = at->speed_mm_s;
    new_target(follower);
}

CW_APART static void progress(cw_follower *follower, const int32_t *pose)
{
    follower->progress[0] = (uint16_t)(pose[0] >> 8);
    follower->progress[1] = (uint16_t)(pose[1] >> 8);
    follower->progress[2] = heading_of(pose);
    follower->progress_us = 0;
}

void cw_follower_init(cw_follower *follower)
{
    memset(follower, 0, sizeof *follower);
    follower->first = true;
}

void cw_follower_begin(cw_follower *follower, const int32_t *pose)
{
    follower->phase = CW_PHASE_TRACK;
    memcpy(follower->from, pose, sizeof follower->from);
    follower->from_speed_mm_s = 0;
    follower->first = true;
    new_target(follower);
    progress(follower, pose);
}

/* Speeds. */

/* No two speeds differ by more than 16 bits hold. */
CW_APART static void slew(int16_t *speed, int16_t wanted, uint16_t dt_us, uint16_t per_cycle)
{
    int16_t most = (int16_t)cw_part(dt_us, per_cycle);
    wanted = (int16_t)(wanted - *speed);
    if (wanted > most) {
        wanted = most;
    } else if (wanted < -most) {
        wanted = (int16_t)-most;
    }
    *speed = (int16_t)(*speed + wanted);
}

static void slew_speed(cw_follower *follower, int16_t speed)
{
    slew(&follower->speed, speed, follower->dt_us,
         PER_CYCLE(cw_robot_settings.acceleration_mm_s2));
}

static void slew_spin(cw_follower *follower, int16_t spin)
{
    slew(&follower->spin, spin, follower->dt_us, PER_CYCLE(SPIN_BRAKE_MM_S2));
}

static void move(cw_follower *follower, int16_t speed, int16_t spin)
{
    slew_speed(follower, speed);
    slew_spin(follower, spin);
}

static void stand(cw_follower *follower)
{
    move(follower, 0, 0);
}

static void drive_along(cw_follower *follower, int16_t speed)
{
    slew_speed(follower, speed);
    slew_spin(follower, cw_clip((int32_t)follower->speed * follower->bend >> 14, MOST_SPIN));
}

/* The square of the speed in mm/s that brakes take back within a distance; brakes are believed
 * to be 2 % weaker than they are, so that a thousand may be 1024. */
static uint32_t braked(uint16_t distance, uint16_t brake_mm_s2)
{
    return (uint32_t)distance * brake_mm_s2 >> 4;
}

/* The speed towards a stop: the square root alone would arrive with a jerk that slow motors
 * cannot follow, so near it the speed is four times the distance left, a second. */
CW_APART static int16_t approach(uint32_t square, uint16_t distance)
{
    uint16_t speed = (uint16_t)(cw_root(square) << 3);
    if (distance < speed >> 1) {
        speed = (uint16_t)(distance << 1);
    }
    return (int16_t)speed;
}

static void turn_towards(cw_follower *follower, uint16_t off)
{
    uint16_t arc = cw_part(PERIMETER, aside(off));
    int16_t spin = approach(braked(arc, SPIN_BRAKE_MM_S2), arc);
    if (spin > (int16_t)(MAX_SPIN_MM_S * 8u)) {
        spin = (int16_t)(MAX_SPIN_MM_S * 8u);
    }
    if (spin < MIN_SPIN) {
        spin = MIN_SPIN;
    }
    move(follower, 0, (off & 0x8000u) != 0u ? (int16_t)-spin : spin);
}

/* Following the line. */

static uint8_t pass_waypoints(cw_follower *follower, const int32_t *pose, cw_queue *queue)
{
    uint8_t passed = 0;
    while (passed < queue->count) {
        const cw_waypoint *at = cw_queue_at(queue, passed);
        uint16_t radius;
        cw_leg leg;
        look(follower, pose, at->place);
        if (follower->phase > CW_PHASE_TURN) {
            break;
        }
        if (at->flags != 0u) {
            if (follower->first && follower->distance <= START_RADIUS) {
                follower->phase = CW_PHASE_SETTLE;
            }
            break;
        }
        radius = cw_radius(at);
        if (radius < PASS_RADIUS) {
            radius = PASS_RADIUS;
        }
        leg = follower->leg;
        if (passed + 1u < queue->count &&
            next_leg(&leg, at, cw_queue_at(queue, (uint8_t)(passed + 1u)))) {
            radius = STOP_TOLERANCE;
        }
        if (follower->first && radius < START_RADIUS) {
            radius = START_RADIUS;
        }
        if ((uint16_t)follower->distance > radius && follower->remaining > 0) {
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
static int16_t steer(cw_follower *follower, const int32_t *pose, cw_queue *queue, uint8_t begin,
                     uint16_t *out_off)
{
    const cw_waypoint *at = cw_queue_at(queue, begin);
    int32_t to[2];
    bool found = false;
    uint16_t ahead = follower->remaining < 0 ? 0u : (uint16_t)follower->remaining;
    uint16_t lookahead =
        (uint16_t)(LENGTH(cw_robot_settings.lookahead_mm * 1000ul) +
                   ((uint32_t)cw_short_size(follower->speed) * cw_robot_settings.lookahead_ms >> 9));
    uint16_t fast = cw_robot_settings.max_speed_mm_s;
    uint16_t either = follower->from_speed_mm_s > at->speed_mm_s ? follower->from_speed_mm_s
                                                                 : at->speed_mm_s;
    uint32_t square, allowed;
    uint16_t speed, bend, distance;
    bool last;
    if (either != 0u && either < fast) {
        fast = either; /* a line is driven at the speed of its faster end */
    }
    square = (uint32_t)fast * fast;
    for (;;) {
        const cw_waypoint *after = cw_queue_at(queue, ++begin);
        uint16_t direction = follower->leg.direction;
        last = begin >= queue->count || at->flags != 0u ||
               next_leg(&follower->leg, at, after);
        if (!found && (last || ahead >= lookahead)) {
            int32_t point[2];
            found = true;
            point[0] = ((int32_t)lookahead - ahead) * 16;
            point[1] = 0;
            cw_turn(point, direction);
            cw_between(pose, at->place, to);
            to[0] += point[0];
            to[1] += point[1];
        }
        allowed = braked(ahead, BRAKE_MM_S2);
        if (last || (found && allowed >= square)) {
            break;
        }
        allowed += (uint32_t)at->speed_mm_s * at->speed_mm_s;
        if (allowed < square) {
            square = allowed;
        }
        ahead = (uint16_t)(ahead + follower->leg.length);
        if (ahead > FAR) {
            ahead = FAR;
        }
        at = after;
    }
    if (allowed < square) {
        square = allowed;
    }
    *out_off = (uint16_t)(cw_measure(to) - heading_of(pose));
    distance = (uint16_t)length_of(to[0]);
    /* pure pursuit: the bend is twice the bearing's sine over the distance */
    allowed = (uint32_t)TRACK * (uint16_t)cw_sine(aside(*out_off));
    if (distance != 0u) {
        allowed /= distance;
    }
    bend = allowed > 0x7FFFu ? 0x7FFFu : (uint16_t)allowed;
    follower->bend = (*out_off & 0x8000u) != 0u ? (int16_t)-(int16_t)bend : (int16_t)bend;
    bend = (uint16_t)((bend >> 4) + 1u);
    allowed = BEND_LIMIT / bend;
    speed = (uint16_t)approach(allowed < square ? allowed : square, last ? ahead : 0xFFFFu);
    allowed = ((uint32_t)MAX_SPIN_MM_S << 13) / bend;
    return (int16_t)(speed > allowed ? (uint16_t)allowed : speed);
}

static cw_trouble track(cw_follower *follower, const int32_t *pose, cw_queue *queue, uint8_t begin)
{
    int16_t speed;
    uint16_t off, enter;
    if (cw_queue_at(queue, begin)->flags != 0u && follower->remaining <= SHORT) {
        follower->phase = CW_PHASE_SETTLE;
        stand(follower);
        return CW_TROUBLE_NONE;
    }
    if (follower->beside > (int16_t)LENGTH(cw_robot_settings.max_deviation_mm * 1000ul)) {
        return CW_TROUBLE_OFF_PATH;
    }
    speed = steer(follower, pose, queue, begin, &off);
    enter = follower->speed < STANDING ? TURN_STANDING : TURN_ENTER;
    if (follower->phase == CW_PHASE_TURN) {
        enter = TURN_EXIT;
    }
    if (aside(off) > enter) {
        follower->phase = CW_PHASE_TURN;
        turn_towards(follower, off);
        return CW_TROUBLE_NONE;
    }
    follower->phase = CW_PHASE_TRACK;
    follower->first = false;
    drive_along(follower, speed > CRAWL ? speed : CRAWL);
    return CW_TROUBLE_NONE;
}

/* Stopping. */

/* Whether the robot has stood long enough, and whether it stands near enough; otherwise it
 * docks. */
static bool has_settled(cw_follower *follower, int32_t ahead_um, const cw_waypoint *at,
                        uint16_t tolerance)
{
    uint16_t radius = cw_radius(at);
    stand(follower);
    if (follower->still_us == 0u) {
        follower->stood_um = 0;
    }
    ahead_um += follower->stood_um;
    if (cw_size(ahead_um) > STOOD_UM || follower->speed != 0 || follower->spin != 0) {
        follower->still_us = 0;
        return false;
    }
    follower->stood_um = (int16_t)ahead_um;
    follower->still_us += follower->dt_us;
    if (follower->still_us < SETTLE_US) {
        return false;
    }
    follower->still_us = 0;
    if ((uint16_t)follower->distance <= (radius > tolerance ? radius : tolerance)) {
        return true;
    }
    follower->phase = CW_PHASE_DOCK;
    follower->docking = false;
    follower->attempts++;
    return false;
}

/* Drive straight to the target, forwards or backwards, turning towards it first. */
static void dock(cw_follower *follower, const int32_t *pose, const int32_t *place)
{
    int32_t to[2];
    int16_t ahead, speed;
    uint16_t beside, off;
    bool back;
    cw_between(pose, place, to);
    cw_turn(to, (uint16_t)(0u - heading_of(pose)));
    back = to[0] < 0;
    if (back) {
        to[0] = -to[0];
        to[1] = -to[1];
    }
    ahead = length_of(to[0]);
    beside = cw_short_size(length_of(to[1]));
    off = cw_measure(to);
    if (!follower->docking && beside > SIDEWAYS && aside(off) > DOCK_BEARING) {
        turn_towards(follower, off);
        return;
    }
    follower->docking = true;
    if (ahead < DOCKED) {
        stand(follower);
        follower->phase = CW_PHASE_SETTLE;
        follower->still_us = 0;
        return;
    }
    speed = ahead > DOCK_SPEED / 2 ? DOCK_SPEED : (int16_t)(ahead * 2);
    if (speed < CRAWL) {
        speed = CRAWL;
    }
    move(follower, back ? (int16_t)-speed : speed, 0);
}

static bool is_stuck(cw_follower *follower, const int32_t *pose)
{
    if (follower->phase == CW_PHASE_SETTLE || follower->phase == CW_PHASE_DWELL ||
        aside((uint16_t)((uint16_t)(pose[0] >> 8) - follower->progress[0])) > PROGRESS ||
        aside((uint16_t)((uint16_t)(pose[1] >> 8) - follower->progress[1])) > PROGRESS ||
        aside((uint16_t)(heading_of(pose) - follower->progress[2])) > CW_MRAD(30)) {
        progress(follower, pose);
        return false;
    }
    follower->progress_us += follower->dt_us;
    return follower->progress_us > STUCK_US;
}

uint8_t cw_follower_halt(cw_follower *follower, const int32_t *pose, cw_queue *queue)
{
    uint8_t executed = 0;
    if (follower->speed <= 0 || follower->phase != CW_PHASE_TRACK) {
        stand(follower);
    } else {
        uint16_t off;
        executed = pass_waypoints(follower, pose, queue);
        if (executed < queue->count && follower->phase == CW_PHASE_TRACK) {
            (void)steer(follower, pose, queue, executed, &off);
        }
        drive_along(follower, 0);
    }
    return executed;
}

uint8_t cw_follower_step(cw_follower *follower, const int32_t *pose, int32_t ahead_um,
                         cw_queue *queue, cw_trouble *out_trouble)
{
    uint8_t executed = pass_waypoints(follower, pose, queue);
    const cw_waypoint *at = cw_queue_at(queue, executed);
    uint16_t off = 0;
    *out_trouble = CW_TROUBLE_NONE;
    if (executed == queue->count) {
        follower->progress_us = 0;
        stand(follower);
        return executed;
    }
    switch (follower->phase) {
    case CW_PHASE_TRACK:
    case CW_PHASE_TURN:
        *out_trouble = track(follower, pose, queue, executed);
        break;
    case CW_PHASE_DOCK:
        dock(follower, pose, at->place);
        break;
    case CW_PHASE_DWELL:
        stand(follower);
        follower->still_us += follower->dt_us;
        if (follower->still_us >= (uint32_t)at->dwell * 100000u) {
            executed++;
            follower->phase = CW_PHASE_TRACK;
            leave(follower, at);
        }
        break;
    case CW_PHASE_ALIGN:
        off = (uint16_t)(cw_angle_of(at->heading) - heading_of(pose));
        if (aside(off) > HEADING_TOLERANCE) {
            follower->still_us = 0;
            turn_towards(follower, off);
        } else if (has_settled(follower, ahead_um, at, TURNED_TOLERANCE)) {
            follower->phase = CW_PHASE_DWELL;
        }
        break;
    default:
        if (has_settled(follower, ahead_um, at, STOP_TOLERANCE)) {
            follower->phase = at->heading == CW_HEADING_FREE ? CW_PHASE_DWELL : CW_PHASE_ALIGN;
        }
        break;
    }
    if (*out_trouble == CW_TROUBLE_NONE &&
        (follower->attempts > DOCK_ATTEMPTS || is_stuck(follower, pose))) {
        *out_trouble = CW_TROUBLE_STUCK;
    }
    return executed;
}
