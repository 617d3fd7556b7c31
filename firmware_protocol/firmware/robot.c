#include "robot.h"

#include <string.h>

#include "flash.h"
#include "pulses.h"

#define DT_MAX_US 60000ul
#define SMOOTHING_US 30000u
#define TURNING 72u /* 9 mm/s: one late step of both encoders reads as 8.3 */

static void change(cw_robot *robot, cw_state to, cw_reason reason)
{
    if (robot->state != (uint8_t)to) {
        robot->state = (uint8_t)to;
        robot->reason = (uint8_t)reason;
        robot->news = true;
    }
}

static void halt(cw_robot *robot, cw_reason reason)
{
    if (robot->state == CW_STATE_RUN) {
        change(robot, CW_STATE_HOLD, reason);
        robot->alarm = true;
        robot->hurry = true;
    }
}

static uint32_t mission_seed(uint32_t mission)
{
    uint8_t bytes[4];
    (void)cw_put_u32(bytes, mission);
    return cw_crc32c(bytes, 4, 0);
}

static void forget_mission(cw_robot *robot, uint32_t mission)
{
    robot->queue.head = 0;
    robot->queue.count = 0;
    robot->unsummed = 0;
    robot->mission = mission;
    robot->accept_next = 0;
    robot->exec_next = 0;
    robot->prefix_crc = mission_seed(mission);
    robot->exec_crc = robot->prefix_crc;
    robot->done = false;
    robot->ended = false;
    robot->news = true;
}

static void motors_off(cw_robot *robot)
{
    memset(&robot->wheels, 0, sizeof robot->wheels);
    memset(robot->owed, 0, sizeof robot->owed);
}

void cw_robot_init(cw_robot *robot)
{
    memset(robot, 0, sizeof *robot);
    robot->reason = CW_REASON_BOOTED;
    robot->lease.pose_age_ms = CW_NO_POSE_MS;
    forget_mission(robot, 0);
    cw_follower_init(&robot->follower);
}

void cw_robot_open_session(cw_robot *robot)
{
    robot->lease_valid = false;
    robot->lease.issued_us = robot->now_us;
    robot->lease.flags = 0;
    robot->session_after_estop = true;
    if (robot->state == CW_STATE_BOOT) {
        change(robot, CW_STATE_IDLE, CW_REASON_NEW_SESSION);
    }
    halt(robot, CW_REASON_NEW_SESSION);
}

bool cw_robot_accept(cw_robot *robot, uint32_t mission, uint32_t first, uint8_t count,
                     const uint8_t *records)
{
    uint8_t i;
    if (mission != robot->mission || robot->state == CW_STATE_ESTOP) {
        return true;
    }
    for (i = 0; i < count; i++, records += CW_WAYPOINT_BYTES) {
        uint32_t index = first + i;
        cw_waypoint *place = cw_queue_at(&robot->queue, robot->queue.count);
        if (index < robot->accept_next) {
            continue;
        }
        if (index > robot->accept_next || robot->ended) {
            return true;
        }
        if (robot->queue.count == CW_QUEUE_SIZE) {
            return false;
        }
        memcpy(place, records, CW_WAYPOINT_BYTES);
        robot->queue.count++;
        robot->ended = (place->flags & CW_WAYPOINT_END) != 0u;
        robot->unsummed++;
        robot->accept_next++;
    }
    return true;
}

bool cw_robot_sum(cw_robot *robot)
{
    const cw_waypoint *at = cw_queue_at(&robot->queue, (uint8_t)(robot->queue.count - robot->unsummed));
    if (robot->unsummed == 0u) {
        return false;
    }
    robot->unsummed--;
    robot->prefix_crc = cw_crc32c((const uint8_t *)at, CW_WAYPOINT_BYTES, robot->prefix_crc);
    return true;
}

/* How long ago that was, and CW_AHEAD_US more, so that what lies a little ahead is not long ago. */
static uint32_t since(const cw_robot *robot, uint32_t stamp_us)
{
    return robot->now_us - stamp_us + CW_AHEAD_US;
}

/* How long the lease was given for, and CW_AHEAD_US more. */
static uint32_t time_to_live(const cw_lease *lease)
{
    uint16_t ttl_ms = lease->ttl_ms < CW_LEASE_MAX_MS ? lease->ttl_ms : CW_LEASE_MAX_MS;
    return (uint32_t)ttl_ms * 1000u + CW_AHEAD_US;
}

CW_APART static bool lease_runs(const cw_robot *robot, const cw_lease *lease)
{
    return since(robot, lease->issued_us) < time_to_live(lease);
}

CW_APART static uint32_t pose_age_us(const cw_robot *robot)
{
    return robot->estimate.fix_recent ? robot->now_us - robot->estimate.fix_us : UINT32_MAX;
}

CW_APART static bool pose_is_stale(const cw_robot *robot)
{
    return robot->lease.pose_age_ms > CW_POSE_STALE_US / 1000u ||
           pose_age_us(robot) > CW_POSE_STALE_US;
}

static bool blind_is_allowed(const cw_robot *robot)
{
    return (robot->lease.flags & CW_LEASE_ODOMETRY) != 0u;
}

cw_result cw_robot_start(cw_robot *robot, uint32_t mission, uint32_t exec_next)
{
    if (robot->state == CW_STATE_RUN && mission == robot->mission) {
        return CW_RESULT_DONE;
    }
    if ((robot->state != CW_STATE_IDLE && robot->state != CW_STATE_HOLD) || robot->done) {
        return CW_RESULT_WRONG_STATE;
    }
    if (mission != robot->mission || mission == 0u) {
        return CW_RESULT_WRONG_MISSION;
    }
    if (exec_next != robot->exec_next) {
        return CW_RESULT_WRONG_INDEX;
    }
    if (!robot->lease_valid || (robot->lease.flags & CW_LEASE_PERMIT) == 0u) {
        return CW_RESULT_NO_LEASE;
    }
    if (!blind_is_allowed(robot) && pose_is_stale(robot)) {
        return CW_RESULT_NO_POSE;
    }
    cw_follower_begin(&robot->follower, robot->estimate.pose);
    change(robot, CW_STATE_RUN, CW_REASON_NONE);
    return CW_RESULT_DONE;
}

cw_result cw_robot_pause(cw_robot *robot)
{
    halt(robot, CW_REASON_PAUSED);
    return CW_RESULT_DONE;
}

cw_result cw_robot_clear(cw_robot *robot, uint32_t mission)
{
    if (robot->state == CW_STATE_ESTOP) {
        return CW_RESULT_WRONG_STATE;
    }
    if (mission == 0u || mission != robot->mission) {
        forget_mission(robot, mission);
        robot->state = CW_STATE_IDLE;
        robot->reason = CW_REASON_CLEARED;
    }
    return CW_RESULT_DONE;
}

cw_result cw_robot_reset_estop(cw_robot *robot)
{
    if (robot->state != CW_STATE_ESTOP) {
        return CW_RESULT_WRONG_STATE;
    }
    if (!robot->session_after_estop) {
        return CW_RESULT_SAME_SESSION;
    }
    forget_mission(robot, 0);
    change(robot, CW_STATE_IDLE, CW_REASON_ESTOP_RESET);
    return CW_RESULT_DONE;
}

bool cw_robot_lease(cw_robot *robot, const cw_lease *lease)
{
    /* the present one is younger than half a turn of the clock: the sign is right */
    if (!lease_runs(robot, lease) ||
        (robot->lease_valid && (int32_t)(lease->issued_us - robot->lease.issued_us) < 0)) {
        return false;
    }
    robot->lease = *lease;
    robot->lease_valid = true;
    cw_robot_tick(robot, robot->now_us);
    return true;
}

bool cw_robot_pose(cw_robot *robot, const int32_t seen[3], uint32_t seen_us)
{
    uint32_t age_us = since(robot, seen_us);
    if (age_us >= CW_POSE_STALE_US + CW_AHEAD_US) {
        return false;
    }
    if (age_us < CW_AHEAD_US) {
        seen_us = robot->now_us;
    }
    return cw_estimate_correct(&robot->estimate, seen, seen_us);
}

void cw_robot_emergency_stop(cw_robot *robot, cw_reason reason)
{
    robot->session_after_estop = false;
    change(robot, CW_STATE_ESTOP, reason);
    robot->follower.speed = 0;
    robot->follower.spin = 0;
    motors_off(robot);
}

void cw_robot_tick(cw_robot *robot, uint32_t now_us)
{
    robot->now_us = now_us;
    if (!lease_runs(robot, &robot->lease)) {
        robot->lease_valid = false;
    }
    if (pose_age_us(robot) >= 65535000ul) {
        robot->estimate.fix_recent = false;
    }
    if (!robot->lease_valid) {
        halt(robot, CW_REASON_LEASE_LAPSED);
    } else if ((robot->lease.flags & CW_LEASE_PERMIT) == 0u) {
        halt(robot, CW_REASON_NO_PERMIT);
    } else if (!blind_is_allowed(robot) && pose_is_stale(robot)) {
        halt(robot, CW_REASON_POSE_STALE);
    }
    if (robot->state == CW_STATE_HOLD && 
        since(robot, robot->lease.issued_us) >= CW_DISARM_US + CW_AHEAD_US) {
        change(robot, CW_STATE_IDLE, CW_REASON_DISARMED);
    }
}

static void execute(cw_robot *robot, uint8_t count)
{
    cw_queue *queue = &robot->queue;
    while (count-- > 0u) {
        const cw_waypoint *at = cw_queue_at(queue, 0);
        if (robot->unsummed == queue->count) {
            (void)cw_robot_sum(robot); /* it leaves the queue */
        }
        robot->exec_crc =
            cw_crc32c((const uint8_t *)at, CW_WAYPOINT_BYTES, robot->exec_crc);
        robot->exec_next++;
        if ((at->flags & CW_WAYPOINT_END) != 0u) {
            robot->done = true;
            robot->news = true;
            if (robot->state == CW_STATE_RUN) {
                change(robot, CW_STATE_IDLE, CW_REASON_MISSION_DONE);
            }
        }
        queue->head = (uint8_t)((queue->head + 1u) % CW_QUEUE_SIZE);
        queue->count--;
    }
}

/* Towards what the wheels did in this cycle, 30 ms smooth; 17/64 is 8 over 30. */
static void smooth(int16_t *speed, int32_t travel_um, uint16_t part)
{
    *speed = cw_clip(*speed + (travel_um * 17 >> 6) - cw_scale(*speed, (int16_t)part), INT16_MAX);
}

static void drive(cw_robot *robot, int32_t ahead_um)
{
    const int32_t *pose = robot->estimate.pose;
    cw_follower *follower = &robot->follower;
    cw_trouble trouble = CW_TROUBLE_NONE;
    if (robot->state == CW_STATE_RUN) {
        if (cw_short_size(robot->speed) >= TURNING) {
            ahead_um = CW_CLEARLY;
        }
        execute(robot, cw_follower_step(follower, pose, ahead_um, &robot->queue, &trouble));
        if (trouble != CW_TROUBLE_NONE) {
            halt(robot, trouble == CW_TROUBLE_STUCK ? CW_REASON_STUCK : CW_REASON_OFF_PATH);
        }
    } else {
        execute(robot, cw_follower_halt(follower, pose, &robot->queue));
    }
}

/* What a wheel was ordered in the last cycle and not driven. */
static void owe(cw_robot *robot)
{
    const cw_follower *follower = &robot->follower;
    int16_t left = (int16_t)(follower->speed - follower->spin - robot->wheels.left);
    int16_t right = (int16_t)(follower->speed + follower->spin - robot->wheels.right);
    robot->owed[0] += (int32_t)left * follower->dt_us;
    robot->owed[1] += (int32_t)right * follower->dt_us;
}

/* A robot that stops is not kept moving by pulses. */
static int16_t turned(const cw_robot *robot, uint8_t side, int16_t order, int16_t driven)
{
    int16_t wheel = cw_pulsed(order, driven, robot->owed[side], side == 0u);
    return robot->state == CW_STATE_RUN || wheel == order ? wheel : 0;
}

static void turn_wheels(cw_robot *robot)
{
    const cw_follower *follower = &robot->follower;
    int16_t left = (int16_t)(follower->speed - follower->spin);
    int16_t right = (int16_t)(follower->speed + follower->spin);
    if (robot->state != CW_STATE_RUN) {
        memset(robot->owed, 0, sizeof robot->owed);
    }
    robot->wheels.left = turned(robot, 0, left, robot->wheels.left);
    robot->wheels.right = turned(robot, 1, right, robot->wheels.right);
    robot->wheels.powered = left != 0 || right != 0 || robot->state == CW_STATE_RUN ||
                            robot->state == CW_STATE_HOLD;
}

void cw_robot_step(cw_robot *robot, uint32_t now_us, const int32_t travel_um[2])
{
    cw_follower *follower = &robot->follower;
    int32_t across = travel_um[1] - travel_um[0];
    int32_t ahead = travel_um[0] + (across >> 1);
    uint32_t dt_us = now_us - robot->step_us;
    uint16_t part;
    if (!robot->stepped) {
        robot->stepped = true;
        dt_us = 0;
    }
    if (dt_us > DT_MAX_US) {
        dt_us = DT_MAX_US;
    }
    follower->dt_us = (uint16_t)dt_us;
    robot->step_us = now_us;
    robot->hurry = false;
    cw_estimate_advance(&robot->estimate, ahead, (int32_t)((uint32_t)across * CW_ANGLE_PER_UM),
                        (uint16_t)(now_us >> 8));
    part = (uint16_t)dt_us < SMOOTHING_US ? cw_part((uint16_t)dt_us, 35790u) : 16384u;
    smooth(&robot->speed, ahead, part);
    smooth(&robot->spin, across >> 1, part);
    cw_robot_tick(robot, now_us);
    if (robot->state == CW_STATE_ESTOP) {
        return;
    }
    owe(robot);
    drive(robot, ahead);
    turn_wheels(robot);
}

uint8_t cw_robot_credit(const cw_robot *robot)
{
    return (uint8_t)(CW_QUEUE_SIZE - robot->queue.count);
}

uint8_t cw_robot_flags(const cw_robot *robot)
{
    uint8_t flags = 0;
    if ((uint16_t)(robot->speed + 2) > 4u || (uint16_t)(robot->spin + 2) > 4u) {
        flags |= CW_STATUS_MOVING;
    }
    if (robot->lease_valid) {
        flags |= CW_STATUS_LEASE_VALID;
        if ((robot->lease.flags & CW_LEASE_PERMIT) != 0u) {
            flags |= CW_STATUS_PERMIT;
        }
    }
    if (robot->estimate.known) {
        flags |= CW_STATUS_POSE_KNOWN;
    }
    if (robot->state == CW_STATE_RUN && robot->queue.count == 0u) {
        flags |= CW_STATUS_UNDERRUN;
    }
    if (robot->done) {
        flags |= CW_STATUS_MISSION_DONE;
    }
    return flags;
}

int16_t cw_robot_speed_mm_s(const cw_robot *robot)
{
    return (int16_t)(((int32_t)robot->speed + 4) >> 3);
}

int16_t cw_robot_turning_mrad_s(const cw_robot *robot)
{
    return cw_clip((int32_t)robot->spin * CW_TURNING_PER_SPIN >> 8, INT16_MAX);
}

uint16_t cw_robot_lease_left_ms(const cw_robot *robot)
{
    uint32_t left_us = time_to_live(&robot->lease) - since(robot, robot->lease.issued_us);
    return robot->lease_valid ? (uint16_t)((left_us + 500u) / 1000u) : 0u;
}

uint16_t cw_robot_pose_age_ms(const cw_robot *robot)
{
    uint32_t age_us = pose_age_us(robot);
    return age_us >= 65535000ul ? CW_NO_POSE_MS : (uint16_t)((age_us + 500u) / 1000u);
}
