#include "robot.h"

#include <string.h>

#define LEAP_UM 0x100000l /* 1 m; wheels travel no further in a cycle */
#define DT_MAX_US 60000ul
#define SMOOTHING_US 30000u
#define STANDING_Q10 9216u /* 9 mm/s: a late step of both encoders reads as 8.3 */

static void change(cw_robot *robot, cw_state to, cw_reason reason)
{
    if (robot->state != (uint8_t)to) {
        robot->state = (uint8_t)to;
        robot->reason = (uint8_t)reason;
    }
}

static void halt(cw_robot *robot, cw_reason reason)
{
    if (robot->state == CW_STATE_RUN) {
        change(robot, CW_STATE_HOLD, reason);
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
    robot->mission = mission;
    robot->accept_next = 0;
    robot->exec_next = 0;
    robot->prefix_crc = mission_seed(mission);
    robot->exec_crc = robot->prefix_crc;
    robot->done = false;
    robot->ended = false;
}

static void motors_off(cw_robot *robot)
{
    memset(&robot->wheels, 0, sizeof robot->wheels);
}

void cw_robot_init(cw_robot *robot)
{
    memset(robot, 0, sizeof *robot);
    robot->reason = CW_REASON_BOOTED;
    robot->host_pose_age_ms = CW_NO_POSE_MS;
    forget_mission(robot, 0);
    cw_estimate_init(&robot->estimate);
    cw_follower_init(&robot->follower);
}

void cw_robot_open_session(cw_robot *robot, uint32_t now_us)
{
    robot->lease_valid = false;
    robot->leased_us = now_us;
    robot->lease_flags = 0;
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
        robot->prefix_crc = cw_crc32c(records, CW_WAYPOINT_BYTES, robot->prefix_crc);
        robot->accept_next++;
    }
    return true;
}

static uint32_t pose_age_us(const cw_robot *robot, uint32_t now_us)
{
    int32_t age = (int32_t)(now_us - robot->estimate.fix_us);
    if (!robot->estimate.fix_recent) {
        return UINT32_MAX;
    }
    return age < 0 ? 0u : (uint32_t)age;
}

static bool pose_is_stale(const cw_robot *robot, uint32_t now_us)
{
    return (uint32_t)robot->host_pose_age_ms * 1000u > CW_POSE_STALE_US ||
           pose_age_us(robot, now_us) > CW_POSE_STALE_US;
}

static bool lease_runs(const cw_robot *robot, uint32_t now_us)
{
    return robot->lease_valid && (int32_t)(robot->lease_end_us - now_us) > 0;
}

static bool blind_is_allowed(const cw_robot *robot)
{
    return (robot->lease_flags & CW_LEASE_ODOMETRY) != 0u;
}

cw_result cw_robot_start(cw_robot *robot, uint32_t mission, uint32_t exec_next, uint32_t now_us)
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
    if (!lease_runs(robot, now_us) || (robot->lease_flags & CW_LEASE_PERMIT) == 0u) {
        return CW_RESULT_NO_LEASE;
    }
    if (!blind_is_allowed(robot) && pose_is_stale(robot, now_us)) {
        return CW_RESULT_NO_POSE;
    }
    cw_follower_begin(&robot->follower, &robot->estimate.pose);
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

void cw_robot_lease(cw_robot *robot, uint16_t ttl_ms, uint8_t flags, uint16_t pose_age_ms,
                    uint32_t now_us)
{
    uint32_t ttl_us = (uint32_t)ttl_ms * 1000u;
    robot->lease_end_us = now_us + (ttl_us < CW_LEASE_MAX_US ? ttl_us : CW_LEASE_MAX_US);
    robot->lease_valid = true;
    robot->leased_us = now_us;
    robot->lease_flags = flags;
    robot->host_pose_age_ms = pose_age_ms;
    cw_robot_tick(robot, now_us);
}

void cw_robot_pose(cw_robot *robot, const cw_pose *seen, uint32_t age_us, uint32_t now_us)
{
    (void)cw_estimate_correct(&robot->estimate, seen, age_us, now_us);
}

void cw_robot_emergency_stop(cw_robot *robot, cw_reason reason)
{
    if (robot->state != CW_STATE_ESTOP) {
        robot->session_after_estop = false;
    }
    change(robot, CW_STATE_ESTOP, reason);
    cw_follower_freeze(&robot->follower);
    motors_off(robot);
}

void cw_robot_tick(cw_robot *robot, uint32_t now_us)
{
    if (robot->lease_valid && !lease_runs(robot, now_us)) {
        robot->lease_valid = false;
    }
    if (pose_age_us(robot, now_us) >= 65535000ul) {
        robot->estimate.fix_recent = false;
    }
    if (robot->state == CW_STATE_RUN) {
        if (!robot->lease_valid) {
            halt(robot, CW_REASON_LEASE_LAPSED);
        } else if ((robot->lease_flags & CW_LEASE_PERMIT) == 0u) {
            halt(robot, CW_REASON_NO_PERMIT);
        } else if (!blind_is_allowed(robot) && pose_is_stale(robot, now_us)) {
            halt(robot, CW_REASON_POSE_STALE);
        }
    }
    if (robot->state == CW_STATE_HOLD && now_us - robot->leased_us >= CW_DISARM_US) {
        change(robot, CW_STATE_IDLE, CW_REASON_DISARMED);
    }
}

static void execute(cw_robot *robot, uint8_t count)
{
    cw_queue *queue = &robot->queue;
    while (count-- > 0u) {
        const cw_waypoint *at = cw_queue_at(queue, 0);
        robot->exec_crc =
            cw_crc32c((const uint8_t *)at, CW_WAYPOINT_BYTES, robot->exec_crc);
        robot->exec_next++;
        if ((at->flags & CW_WAYPOINT_END) != 0u) {
            robot->done = true;
            if (robot->state == CW_STATE_RUN) {
                change(robot, CW_STATE_IDLE, CW_REASON_MISSION_DONE);
            }
        }
        queue->head = (uint8_t)((queue->head + 1u) % CW_QUEUE_SIZE);
        queue->count--;
    }
}

/* Towards what the wheels did in this cycle, 30 ms smooth; 34.1 is 1.024 over 30 ms. */
static void smooth(int32_t *speed_q10, int32_t travel_um, uint16_t part)
{
    *speed_q10 += travel_um * 34 - cw_scale(*speed_q10, part);
}

static void measure(cw_robot *robot, uint16_t dt_us, int32_t ahead_um, int32_t spin_um)
{
    uint16_t part = dt_us < SMOOTHING_US ? (uint16_t)((uint32_t)dt_us * 35790u >> 14) : 0xFFFFu;
    smooth(&robot->speed_q10, ahead_um, part);
    smooth(&robot->spin_q10, spin_um, part);
    if (cw_size(robot->speed_q10) < 102u && cw_size(robot->spin_q10) < 62u) {
        robot->speed_q10 = 0; /* below 0.1 mm/s */
        robot->spin_q10 = 0;
    }
}

static void drive(cw_robot *robot, uint16_t dt_us)
{
    const cw_pose *pose = &robot->estimate.pose;
    cw_trouble trouble = CW_TROUBLE_NONE;
    if (robot->state == CW_STATE_RUN) {
        bool still = cw_size(robot->speed_q10) < STANDING_Q10;
        execute(robot, cw_follower_step(&robot->follower, dt_us, pose, still, &robot->queue,
                                        &trouble));
        if (trouble != CW_TROUBLE_NONE) {
            halt(robot, trouble == CW_TROUBLE_STUCK ? CW_REASON_STUCK : CW_REASON_OFF_PATH);
        }
    } else {
        execute(robot, cw_follower_halt(&robot->follower, dt_us, pose, &robot->queue));
    }
}

/* What a wheel travelled since the last cycle; more than a leap counts as one. */
static int32_t travelled(int32_t *total_um, uint32_t now_um)
{
    int32_t travel_um = cw_difference((int32_t)now_um, *total_um);
    *total_um = (int32_t)now_um;
    return travel_um > LEAP_UM ? LEAP_UM : travel_um < -LEAP_UM ? -LEAP_UM : travel_um;
}

void cw_robot_step(cw_robot *robot, uint32_t now_us, uint32_t left_um, uint32_t right_um)
{
    const cw_follower *follower = &robot->follower;
    int32_t left = travelled(&robot->left_um, left_um);
    int32_t right = travelled(&robot->right_um, right_um);
    uint32_t dt_us = now_us - robot->step_us;
    if (!robot->stepped) {
        robot->stepped = true;
        left = right = 0;
        dt_us = 0;
    }
    if (dt_us > DT_MAX_US) {
        dt_us = DT_MAX_US;
    }
    robot->step_us = now_us;
    cw_estimate_advance(&robot->estimate, (left + right) >> 1,
                        (int32_t)((uint32_t)(right - left) * CW_ANGLE_PER_UM), now_us);
    if (dt_us > 0u) {
        measure(robot, (uint16_t)dt_us, (left + right) >> 1, (right - left) >> 1);
    }
    cw_robot_tick(robot, now_us);
    if (robot->state == CW_STATE_ESTOP) {
        return;
    }
    drive(robot, (uint16_t)dt_us);
    robot->wheels.left_q10 = follower->speed_q10 - follower->spin_q10;
    robot->wheels.right_q10 = follower->speed_q10 + follower->spin_q10;
    robot->wheels.powered = follower->speed_q10 != 0 || follower->spin_q10 != 0 ||
                            robot->state == CW_STATE_RUN || robot->state == CW_STATE_HOLD;
}

uint8_t cw_robot_credit(const cw_robot *robot)
{
    return (uint8_t)(CW_QUEUE_SIZE - robot->queue.count);
}

uint8_t cw_robot_flags(const cw_robot *robot, uint32_t now_us)
{
    uint8_t flags = 0;
    if (robot->speed_q10 != 0 || robot->spin_q10 != 0) {
        flags |= CW_STATUS_MOVING;
    }
    if (lease_runs(robot, now_us)) {
        flags |= CW_STATUS_LEASE_VALID;
        if ((robot->lease_flags & CW_LEASE_PERMIT) != 0u) {
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

static int16_t told(int32_t value)
{
    return (int16_t)(value > 32767 ? 32767 : value < -32767 ? -32767 : value);
}

int16_t cw_robot_speed_mm_s(const cw_robot *robot)
{
    return told((robot->speed_q10 + 512) >> 10);
}

int16_t cw_robot_turning_mrad_s(const cw_robot *robot)
{
    return told(cw_scale(robot->spin_q10, CW_TURNING_PER_SPIN));
}

uint16_t cw_robot_lease_left_ms(const cw_robot *robot, uint32_t now_us)
{
    return lease_runs(robot, now_us) ? (uint16_t)((robot->lease_end_us - now_us + 500u) / 1000u)
                                     : 0u;
}

uint16_t cw_robot_pose_age_ms(const cw_robot *robot, uint32_t now_us)
{
    uint32_t age_us = pose_age_us(robot, now_us);
    return age_us >= 65535000ul ? CW_NO_POSE_MS : (uint16_t)((age_us + 500u) / 1000u);
}
