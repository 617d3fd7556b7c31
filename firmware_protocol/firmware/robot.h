/* The robot's decisions: queue, states, lease, emergency stop. The manual of the C side.
 *
 * - No malloc, no clock, no I/O: the caller owns a cw_robot and passes in time and wheel travel.
 * - Times are microseconds of any free-running 32-bit clock; they may wrap.
 * - Inside: metres, radians, seconds in float. Travel comes as cumulative micrometres, modulo
 *   2^32, so that no precision is lost on long drives.
 * - cw_robot_init sets every field. Not for use from an interrupt, but for the emergency stop:
 *   set a flag there and call cw_robot_emergency_stop from the main loop, motors off at once.
 */
#ifndef CLEARWAY_ROBOT_H
#define CLEARWAY_ROBOT_H

#include <stdbool.h>
#include <stdint.h>

#include "follower.h"
#include "wire.h"

#define CW_QUEUE_SIZE 32u
#define CW_LEASE_MAX_US 500000ul
#define CW_DISARM_US 2000000ul
#define CW_POSE_STALE_US 500000ul

typedef struct {
    float left_m_s;
    float right_m_s;
    bool powered; /* false: switch the motors off */
} cw_wheels;

typedef struct cw_robot {
    uint8_t head;
    uint8_t count;
    uint8_t state;  /* cw_state */
    uint8_t reason; /* cw_reason: why the robot is not in RUN */
    bool done;      /* the waypoint with END was executed */
    bool ended;     /* the waypoint with END was accepted */
    bool session_after_estop;
    bool lease_valid;
    uint8_t lease_flags;
    uint16_t host_pose_age_ms;
    uint32_t lease_end_us;
    uint32_t leased_us;
    uint32_t mission;
    uint32_t accept_next;
    uint32_t exec_next;
    uint32_t prefix_crc;
    uint32_t exec_crc;
    cw_follower follower;
    cw_wheels wheels; /* what the motors are to do now */
    float speed_m_s;  /* measured */
    float turn_rad_s;
    bool stepped;
    uint32_t step_us;
    uint32_t left_um;
    uint32_t right_um;
    cw_estimate estimate;
    uint8_t records[CW_QUEUE_SIZE][CW_WAYPOINT_BYTES]; /* a ring of waypoints as they came */
} cw_robot;

/* Everything as after power on. `settings` is kept by reference and must live on. */
void cw_robot_init(cw_robot *robot, const cw_drive_settings *settings);

/* A host has opened a session: the old lease is void, a running robot holds. */
void cw_robot_open_session(cw_robot *robot, uint32_t now_us);

/* Queue `count` checked records from index `first` on. False where the queue is full. */
bool cw_robot_accept(cw_robot *robot, uint32_t mission, uint32_t first, uint8_t count,
                     const uint8_t *records);

cw_result cw_robot_start(cw_robot *robot, uint32_t mission, uint32_t exec_next, uint32_t now_us);
cw_result cw_robot_pause(cw_robot *robot);
cw_result cw_robot_clear(cw_robot *robot, uint32_t mission);
cw_result cw_robot_reset_estop(cw_robot *robot);

/* The control loop lives: prolong, or withdraw, the permit. */
void cw_robot_lease(cw_robot *robot, uint16_t ttl_ms, uint8_t flags, uint16_t pose_age_ms,
                    uint32_t now_us);

/* The camera saw the robot `age_us` ago. */
void cw_robot_pose(cw_robot *robot, cw_pose seen, uint32_t age_us, uint32_t now_us);

/* Wheels to zero at once, latched. */
void cw_robot_emergency_stop(cw_robot *robot, cw_reason reason);

/* One control cycle, 100 a second; the answer is in robot->wheels. */
void cw_robot_step(cw_robot *robot, uint32_t now_us, uint32_t left_um, uint32_t right_um);

/* Watch lease and pose between two steps; cheap. */
void cw_robot_tick(cw_robot *robot, uint32_t now_us);

/* What STATUS tells. */
uint8_t cw_robot_credit(const cw_robot *robot);
uint8_t cw_robot_flags(const cw_robot *robot, uint32_t now_us);
uint16_t cw_robot_lease_left_ms(const cw_robot *robot, uint32_t now_us);
uint16_t cw_robot_pose_age_ms(const cw_robot *robot, uint32_t now_us);

#endif
