/* The numbers of the wire, as docs/protocol.md has them. Units: micrometres, 1e-4 rad, ms. */
#ifndef CLEARWAY_WIRE_H
#define CLEARWAY_WIRE_H

#include <stdint.h>

#define CW_VERSION 1u
#define CW_MINOR_VERSION 0u
/* CRC-32C of the layouts; the Python side computes the same, a test compares both. */
#define CW_SCHEMA_HASH 0x1ffb9810ul

#define CW_HEADER_BYTES 8u
#define CW_CHECK_BYTES 4u
#define CW_MAX_PAYLOAD 112u
#define CW_MAX_DECODED (CW_HEADER_BYTES + CW_MAX_PAYLOAD + CW_CHECK_BYTES)
#define CW_MAX_ENCODED (CW_MAX_DECODED + 1u)
#define CW_MAX_WIRE (CW_MAX_ENCODED + 2u)

#define CW_FLAG_RELIABLE 0x01u
#define CW_FLAG_NAK 0x02u

#define CW_SENDER_HOST 0x48u
#define CW_SENDER_ROBOT 0x52u

/* Message types. */
#define CW_HELLO 0x01u
#define CW_CONFIRM 0x02u
#define CW_WAYPOINTS 0x10u
#define CW_START 0x11u
#define CW_PAUSE 0x12u
#define CW_CLEAR 0x13u
#define CW_RESET_ESTOP 0x14u
#define CW_LEASE 0x20u
#define CW_POSE 0x21u
#define CW_TIMESYNC 0x22u
#define CW_ESTOP_TYPE 0x2Eu
#define CW_HELLO_ACK 0x81u
#define CW_CHALLENGE 0x82u
#define CW_ACK 0x90u
#define CW_STATUS 0x91u
#define CW_TIMESYNC_REPLY 0xA2u

/* One waypoint on the wire. */
#define CW_WAYPOINT_BYTES 16u
#define CW_WAYPOINTS_PER_FRAME 6u
#define CW_WAYPOINT_STOP 0x01u
#define CW_WAYPOINT_END 0x02u
#define CW_HEADING_FREE (-32768)
#define CW_HALF_TURN 31416
#define CW_NO_POSE_MS 0xFFFFu

#define CW_LEASE_PERMIT 0x01u
#define CW_LEASE_ODOMETRY 0x02u

#define CW_STATUS_MOVING 0x01u
#define CW_STATUS_LEASE_VALID 0x02u
#define CW_STATUS_PERMIT 0x04u
#define CW_STATUS_POSE_KNOWN 0x08u
#define CW_STATUS_UNDERRUN 0x10u
#define CW_STATUS_MISSION_DONE 0x20u

typedef enum {
    CW_STATE_BOOT = 0,
    CW_STATE_IDLE = 1,
    CW_STATE_RUN = 2,
    CW_STATE_HOLD = 3,
    CW_STATE_ESTOP = 4
} cw_state;

typedef enum {
    CW_REASON_NONE = 0,
    CW_REASON_BOOTED = 1,
    CW_REASON_NEW_SESSION = 2,
    CW_REASON_PAUSED = 3,
    CW_REASON_CLEARED = 4,
    CW_REASON_MISSION_DONE = 5,
    CW_REASON_LEASE_LAPSED = 6,
    CW_REASON_NO_PERMIT = 7,
    CW_REASON_POSE_STALE = 8,
    CW_REASON_OFF_PATH = 9,
    CW_REASON_STUCK = 10,
    CW_REASON_ESTOP_HOST = 11,
    CW_REASON_ESTOP_LOCAL = 12,
    CW_REASON_DISARMED = 13,
    CW_REASON_ESTOP_RESET = 14
} cw_reason;

typedef enum {
    CW_RESULT_NONE = 0,
    CW_RESULT_DONE = 1,
    CW_RESULT_WRONG_MISSION = 2,
    CW_RESULT_WRONG_INDEX = 3,
    CW_RESULT_WRONG_STATE = 4,
    CW_RESULT_NO_LEASE = 5,
    CW_RESULT_NO_POSE = 6,
    CW_RESULT_SAME_SESSION = 7
} cw_result;

/* Little-endian reading and writing; the caller owns enough bytes. */
uint16_t cw_get_u16(const uint8_t *from);
uint32_t cw_get_u32(const uint8_t *from);
uint8_t *cw_put_u16(uint8_t *to, uint16_t value); /* returns the place behind */
uint8_t *cw_put_u32(uint8_t *to, uint32_t value);

/* Headings of the wire, 1e-4 rad, as binary angles of 2^16 a turn, and back. */
uint16_t cw_angle_of(int16_t heading);
int16_t cw_heading_of(uint16_t angle);

/* CRC-32C of `length` bytes continued from `running` (0 to begin). */
uint32_t cw_crc32c(const uint8_t *data, uint16_t length, uint32_t running);

#endif
