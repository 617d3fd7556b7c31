/* The robot's end of the link: bytes in, decisions through cw_robot, frames out.
 *
 * - Feed cw_link_receive with what has arrived, in any portion; it acts on whole frames at once.
 * - Ask cw_link_next_frame whenever the transmitter is free; it hands out one frame, by urgency.
 * - No malloc, no clock, no I/O; the caller owns both structures. Microseconds, may wrap.
 * - Any byte stream is safe: nothing is read or written outside the structures.
 * A receive interrupt may match cw_estop_frame by itself (cw_estop_match) and switch the motors
 * off before the main loop sees the frame.
 */
#ifndef CLEARWAY_LINK_H
#define CLEARWAY_LINK_H

#include <stdbool.h>
#include <stdint.h>

#include "robot.h"
#include "wire.h"

#define CW_RX_WINDOW 248u
#define CW_STATUS_INTERVAL_US 50000ul
#define CW_STATUS_SPACING_US 10000ul
#define CW_NAK_INTERVAL_US 3000ul

#define CW_ESTOP_BYTES 15u
extern const uint8_t cw_estop_frame[CW_ESTOP_BYTES];

/* Who the robot is. boot_id has to differ from boot to boot: the challenges are made from it. */
typedef struct { /* in the order of HELLO_ACK */
    uint32_t schema; /* CW_SCHEMA_HASH */
    uint32_t firmware;
    uint32_t boot_id;
    uint8_t reset_cause; /* 0 unknown, 1 power on, 2 external, 3 brown-out, 4 watchdog */
} cw_identity;

/* Counted modulo 2^16, told in STATUS. */
typedef struct {
    uint16_t frames;
    uint16_t crc_errors; /* echoes among them */
    uint16_t format_errors;
    uint16_t overruns; /* the board counts: bytes lost before cw_link_receive */
    uint16_t session_errors;
    uint16_t gaps;
    uint16_t duplicates;
    uint16_t rejected;
} cw_counters;

/* Of the present session: all 0 when it opens. */
typedef struct {
    uint16_t asked; /* another session that a host has asked for and not confirmed; 0: none */
    uint16_t command;
    uint8_t result; /* cw_result */
    uint8_t expected; /* sequence number */
    bool challenge_due;
    bool ack_due;
    bool nak_due;
    bool sync_due;
    bool status_sent;
} cw_open;

typedef struct {
    cw_robot *robot;
    cw_identity identity;
    cw_counters count;
    uint8_t encoded; /* bytes since the last zero; one more than fit: too long */
    uint8_t block;   /* the byte after so many begins the next block of COBS */
    uint8_t filled;
    uint32_t crc;
    uint16_t session; /* 0: none */
    uint32_t nonce;   /* of the last challenge: made from boot and clocks, one after another */
    cw_open open;
    bool hello_due;
    uint16_t hello_session;
    bool nak_sent;
    uint32_t nak_us;
    uint32_t sync_host_us;
    uint32_t sync_robot_us;
    uint32_t status_us;
    uint8_t buffer[CW_MAX_DECODED]; /* the frame that is arriving, decoded */
} cw_link;

/* Everything as after power on. `robot` is kept by reference and has to live on. */
void cw_link_init(cw_link *link, cw_robot *robot, const cw_identity *identity);

/* Take `length` bytes from the line. */
void cw_link_receive(cw_link *link, const uint8_t *data, uint16_t length, uint32_t now_us);

/* Write the most urgent frame that is due; returns its size, 0 where none is. */
uint8_t cw_link_next_frame(cw_link *link, uint8_t out_frame[CW_MAX_WIRE], uint32_t now_us);

/* Match the emergency stop byte by byte, in a receive interrupt: keep `*matched` (0 at first)
 * between calls; true when the last byte of the frame has come. */
bool cw_estop_match(uint8_t *matched, uint8_t byte);

#endif
