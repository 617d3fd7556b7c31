/* The robot's decisions: queue, states, lease, emergency stop. The manual of the C side.
 *
 * - No malloc, no clock, no I/O: the caller owns a cw_robot and passes in time and wheel travel.
 * - Times are microseconds of any free-running 32-bit clock; they may wrap. What has passed is a
 *   difference without a sign, so that a processor that stood still for an hour finds its lease
 *   lapsed; only a clock that comes round to the same value (71.6 min) hides it. Set now_us before a call; cw_robot_step and cw_robot_tick, and the link, do so themselves.
 * - Inside: micrometres, binary angles, eighths of mm/s; whole numbers only (fixed.h). Travel
 *   comes as micrometres since the last cycle.
 * - cw_robot_init sets every field. Not for use from an interrupt, but for the emergency stop:
 *   set a flag there and call cw_robot_emergency_stop from the main loop, motors off at once.
 */
#ifndef CLEARWAY_ROBOT_H
#define CLEARWAY_ROBOT_H

#include <stdbool.h>
#include <stdint.h>

#include "follower.h"
#include "wire.h"

#define CW_LEASE_MAX_MS 500u
#define CW_DISARM_US 2000000ul
#define CW_POSE_STALE_US 500000ul
#define CW_AHEAD_US 20000ul /* a host may think the robot's clock so far ahead of what it is */
#define CW_LEAP_UM 0x100000l /* 1 m */

typedef struct {
    int16_t left; /* speed of the wheel's rim in eighths of mm/s */
    int16_t right;
    bool powered; /* false: switch the motors off */
} cw_wheels;

/* A lease as the wire has it. */
typedef struct {
    uint32_t issued_us; /* when the control loop gave it, of this robot's clock */
    uint16_t ttl_ms;
    uint16_t pose_age_ms; /* of the camera's newest pose, then */
    uint8_t flags;
} cw_lease;

#define CW_LEASE_BYTES 9u

typedef struct cw_robot {
    uint8_t state;  /* cw_state */
    uint8_t reason; /* cw_reason: why the robot is not in RUN */
    bool done;      /* the waypoint with END was executed */
    bool ended;     /* the waypoint with END was accepted */
    bool session_after_estop;
    bool lease_valid;
    bool stepped;
    bool news;  /* something that STATUS should tell soon */
    uint8_t unsummed; /* so many of the queue's last are not yet in prefix_crc */
    bool alarm; /* a stop that STATUS should tell at once */
    bool hurry; /* the same, that should not wait for the next step's turn */
    /* these five in the order of STATUS and HELLO_ACK */
    uint32_t mission;
    uint32_t accept_next;
    uint32_t exec_next;
    uint32_t prefix_crc;
    uint32_t exec_crc;
    uint32_t now_us; /* as told last */
    uint32_t step_us;
    int16_t speed; /* measured */
    int16_t spin;
    cw_wheels wheels; /* what the motors are to do now */
    int32_t owed[2]; /* what the wheels were ordered and not driven: pulses.h */
    cw_lease lease; /* the last one */
    cw_follower follower;
    cw_estimate estimate;
    cw_queue queue;
} cw_robot;

/* Everything as after power on. */
void cw_robot_init(cw_robot *robot);

/* A host has opened a session: the old lease is void, a running robot holds. */
void cw_robot_open_session(cw_robot *robot);

/* Queue `count` checked records of 16 bytes from index `first` on. False where the queue is
 * full. */
bool cw_robot_accept(cw_robot *robot, uint32_t mission, uint32_t first, uint8_t count,
                     const uint8_t *records);

cw_result cw_robot_start(cw_robot *robot, uint32_t mission, uint32_t exec_next);
cw_result cw_robot_pause(cw_robot *robot);
cw_result cw_robot_clear(cw_robot *robot, uint32_t mission);
cw_result cw_robot_reset_estop(cw_robot *robot);

/* The control loop lived when it gave the lease: prolong, or withdraw, the permit, counted from there.
 * False for one that has run out on its way, or is older than the present one. */
bool cw_robot_lease(cw_robot *robot, const cw_lease *lease);

/* The camera saw the robot at `seen_us`. False where that was not used: too old, or one that jumps. */
bool cw_robot_pose(cw_robot *robot, const int32_t seen[3], uint32_t seen_us);

/* Wheels to zero at once, latched. */
void cw_robot_emergency_stop(cw_robot *robot, cw_reason reason);

/* One control cycle, 100 a second; the answer is in robot->wheels. `travel_um`: of the wheels, left
 * and right, since the last one, each within plus and minus CW_LEAP_UM. */
void cw_robot_step(cw_robot *robot, uint32_t now_us, const int32_t travel_um[2]);

/* Watch lease and pose between two steps; cheap. The link does so by itself. */
void cw_robot_tick(cw_robot *robot, uint32_t now_us);

/* Take what was accepted into prefix_crc, one waypoint a call; false where all are. The link does
 * it before it tells of it; a program may do it in its idle time, so that the link has less to do. */
bool cw_robot_sum(cw_robot *robot);

/* What STATUS tells. */
uint8_t cw_robot_credit(const cw_robot *robot);
uint8_t cw_robot_flags(const cw_robot *robot);
int16_t cw_robot_speed_mm_s(const cw_robot *robot);
int16_t cw_robot_turning_mrad_s(const cw_robot *robot);
uint16_t cw_robot_lease_left_ms(const cw_robot *robot);
uint16_t cw_robot_pose_age_ms(const cw_robot *robot);

#endif
