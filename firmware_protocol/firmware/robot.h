/* The robot's decisions: queue, states, lease, emergency stop. The manual of the C side.
 *
 * - No malloc, no clock, no I/O: the caller owns a cw_robot and passes in time and wheel travel.
 * - Times are microseconds of any free-running 32-bit clock; they may wrap.
 * - Inside: micrometres, binary angles, mm/s times 1024; whole numbers only (fixed.h). Travel
 *   comes as cumulative micrometres, modulo 2^32.
 * - cw_robot_init sets every field. Not for use from an interrupt, but for the emergency stop:
 *   set a flag there and call cw_robot_emergency_stop from the main loop, motors off at once.
 */
#ifndef CLEARWAY_ROBOT_H
#define CLEARWAY_ROBOT_H

#include <stdbool.h>
#include <stdint.h>

#include "follower.h"
#include "wire.h"

#define CW_LEASE_MAX_US 500000ul
#define CW_DISARM_US 2000000ul
#define CW_POSE_STALE_US 500000ul

typedef struct {
    int32_t left_q10; /* speed of the wheel's rim in mm/s times 1024 */
    int32_t right_q10;
    bool powered; /* false: switch the motors off */
} cw_wheels;

typedef struct cw_robot {
    uint8_t state;  /* cw_state */
    uint8_t reason; /* cw_reason: why the robot is not in RUN */
    bool done;      /* the waypoint with END was executed */
    bool ended;     /* the waypoint with END was accepted */
    bool session_after_estop;
    bool lease_valid;
    uint8_t lease_flags;
    bool stepped;
    uint16_t host_pose_age_ms;
    /* these five in the order of STATUS and HELLO_ACK */
    uint32_t mission;
    uint32_t accept_next;
    uint32_t exec_next;
    uint32_t prefix_crc;
    uint32_t exec_crc;
    uint32_t lease_end_us;
    uint32_t leased_us;
    uint32_t step_us;
    int32_t left_um;
    int32_t right_um;
    int32_t speed_q10; /* measured */
    int32_t spin_q10;
    cw_wheels wheels; /* what the motors are to do now */
    cw_follower follower;
    cw_estimate estimate;
    cw_queue queue;
} cw_robot;

/* Everything as after power on. */
void cw_robot_init(cw_robot *robot);

/* A host has opened a session: the old lease is void, a running robot holds. */
void cw_robot_open_session(cw_robot *robot, uint32_t now_us);

/* Queue `count` checked records of 16 bytes from index `first` on. False where the queue is
 * full. */
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
void cw_robot_pose(cw_robot *robot, const cw_pose *seen, uint32_t age_us, uint32_t now_us);

/* Wheels to zero at once, latched. */
void cw_robot_emergency_stop(cw_robot *robot, cw_reason reason);

/* One control cycle, 100 a second; the answer is in robot->wheels. */
void cw_robot_step(cw_robot *robot, uint32_t now_us, uint32_t left_um, uint32_t right_um);

/* Watch lease and pose between two steps; cheap. */
void cw_robot_tick(cw_robot *robot, uint32_t now_us);

/* What STATUS tells. */
uint8_t cw_robot_credit(const cw_robot *robot);
uint8_t cw_robot_flags(const cw_robot *robot, uint32_t now_us);
int16_t cw_robot_speed_mm_s(const cw_robot *robot);
int16_t cw_robot_turning_mrad_s(const cw_robot *robot);
uint16_t cw_robot_lease_left_ms(const cw_robot *robot, uint32_t now_us);
uint16_t cw_robot_pose_age_ms(const cw_robot *robot, uint32_t now_us);

#endif
