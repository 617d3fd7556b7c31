#include "robot.h"

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
    robot->head = 0;
    robot->count = 0;
    robot->mission = mission;
    robot->accept_next = 0;
    robot->exec_next = 0;
    robot->prefix_crc = mission_seed(mission);
    robot->exec_crc = robot->prefix_crc;
    robot->done = false;
    robot->ended = false;
}

static const uint8_t *record_at(const void *queue, uint8_t index)
{
    const cw_robot *robot = queue;
    return robot->records[(uint8_t)(robot->head + index) % CW_QUEUE_SIZE];
}

static void motors_off(cw_robot *robot)
{
    robot->wheels.left_m_s = 0.0f;
    robot->wheels.right_m_s = 0.0f;
    robot->wheels.powered = false;
}

void cw_robot_init(cw_robot *robot, const cw_drive_settings *settings)
{
    robot->state = CW_STATE_BOOT;
    robot->reason = CW_REASON_BOOTED;
    robot->session_after_estop = false;
    robot->lease_valid = false;
    robot->lease_flags = 0;
    robot->host_pose_age_ms = CW_NO_POSE_MS;
    robot->lease_end_us = 0;
    robot->leased_us = 0;
    forget_mission(robot, 0);
    cw_estimate_init(&robot->estimate);
    cw_follower_init(&robot->follower, settings);
    motors_off(robot);
    robot->speed_m_s = 0.0f;
    robot->turn_rad_s = 0.0f;
    robot->stepped = false;
    robot->step_us = 0;
    robot->left_um = 0;
    robot->right_um = 0;
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
        uint8_t *place;
        uint8_t k;
        if (index < robot->accept_next) {
            continue;
        }
        if (index > robot->accept_next || robot->ended) {
            return true;
        }
        if (robot->count == CW_QUEUE_SIZE) {
            return false;
        }
        place = robot->records[(uint8_t)(robot->head + robot->count) % CW_QUEUE_SIZE];
        for (k = 0; k < CW_WAYPOINT_BYTES; k++) {
            place[k] = records[k];
        }
        robot->count++;
        robot->ended = (place[15] & CW_WAYPOINT_END) != 0u;
        robot->prefix_crc = cw_crc32c(place, CW_WAYPOINT_BYTES, robot->prefix_crc);
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

void cw_robot_pose(cw_robot *robot, cw_pose seen, uint32_t age_us, uint32_t now_us)
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
    while (count-- > 0u) {
        const uint8_t *record = record_at(robot, 0);
        robot->exec_crc = cw_crc32c(record, CW_WAYPOINT_BYTES, robot->exec_crc);
        robot->exec_next++;
        if ((record[15] & CW_WAYPOINT_END) != 0u) {
            robot->done = true;
            if (robot->state == CW_STATE_RUN) {
                change(robot, CW_STATE_IDLE, CW_REASON_MISSION_DONE);
            }
        }
        robot->head = (uint8_t)((robot->head + 1u) % CW_QUEUE_SIZE);
        robot->count--;
    }
}

static void measure(cw_robot *robot, float dt_s, float left_m, float right_m)
{
    float blend = dt_s < 0.03f ? dt_s / 0.03f : 1.0f;
    float speed = (left_m + right_m) * 0.5f / dt_s;
    float turn = (right_m - left_m) / robot->follower.settings->track_m / dt_s;
    robot->speed_m_s += blend * (speed - robot->speed_m_s);
    robot->turn_rad_s += blend * (turn - robot->turn_rad_s);
    if (robot->speed_m_s < 1e-4f && robot->speed_m_s > -1e-4f && robot->turn_rad_s < 1e-3f &&
        robot->turn_rad_s > -1e-3f) {
        robot->speed_m_s = 0.0f;
        robot->turn_rad_s = 0.0f;
    }
}

static void drive(cw_robot *robot, float dt_s)
{
    cw_targets targets;
    cw_trouble trouble = CW_TROUBLE_NONE;
    targets.queue = robot;
    targets.count = robot->count;
    targets.get = record_at;
    if (robot->state == CW_STATE_RUN) {
        execute(robot, cw_follower_step(&robot->follower, dt_s, robot->estimate.pose,
                                        robot->speed_m_s, targets, &trouble));
        if (trouble == CW_TROUBLE_OFF_PATH) {
            halt(robot, CW_REASON_OFF_PATH);
        } else if (trouble == CW_TROUBLE_STUCK) {
            halt(robot, CW_REASON_STUCK);
        }
    } else {
        execute(robot, cw_follower_halt(&robot->follower, dt_s, robot->estimate.pose, targets));
    }
}

void cw_robot_step(cw_robot *robot, uint32_t now_us, uint32_t left_um, uint32_t right_um)
{
    float dt_s = 0.0f;
    float left_m = 0.0f;
    float right_m = 0.0f;
    if (robot->stepped) {
        dt_s = (float)(now_us - robot->step_us) * 1e-6f;
        left_m = (float)(int32_t)(left_um - robot->left_um) * 1e-6f;
        right_m = (float)(int32_t)(right_um - robot->right_um) * 1e-6f;
    }
    robot->stepped = true;
    robot->step_us = now_us;
    robot->left_um = left_um;
    robot->right_um = right_um;
    cw_estimate_advance(&robot->estimate, robot->follower.settings->track_m, now_us, left_m,
                        right_m);
    if (dt_s > 0.0f) {
        measure(robot, dt_s, left_m, right_m);
    }
    cw_robot_tick(robot, now_us);
    if (robot->state == CW_STATE_ESTOP) {
        return;
    }
    drive(robot, dt_s);
    {
        const cw_follower *follower = &robot->follower;
        float half = follower->turn_rad_s * follower->settings->track_m * 0.5f;
        bool moving = follower->speed_m_s < 0.0f || follower->speed_m_s > 0.0f ||
                      follower->turn_rad_s < 0.0f || follower->turn_rad_s > 0.0f;
        robot->wheels.left_m_s = follower->speed_m_s - half;
        robot->wheels.right_m_s = follower->speed_m_s + half;
        robot->wheels.powered =
            moving || robot->state == CW_STATE_RUN || robot->state == CW_STATE_HOLD;
    }
}

uint8_t cw_robot_credit(const cw_robot *robot)
{
    return (uint8_t)(CW_QUEUE_SIZE - robot->count);
}

uint8_t cw_robot_flags(const cw_robot *robot, uint32_t now_us)
{
    uint8_t flags = 0;
    if (robot->speed_m_s < 0.0f || robot->speed_m_s > 0.0f || robot->turn_rad_s < 0.0f ||
        robot->turn_rad_s > 0.0f) {
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
    if (robot->state == CW_STATE_RUN && robot->count == 0u) {
        flags |= CW_STATUS_UNDERRUN;
    }
    if (robot->done) {
        flags |= CW_STATUS_MISSION_DONE;
    }
    return flags;
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
