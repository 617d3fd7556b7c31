#include "link.h"

#include <string.h>

#include "flash.h"

const uint8_t cw_estop_frame[CW_ESTOP_BYTES] = {0x00, 0x03, 0x10, 0x2e, 0x01, 0x01, 0x01, 0x01,
                                                0x01, 0x05, 0xa2, 0x48, 0xb2, 0x50, 0x00};

bool cw_estop_match(uint8_t *matched, uint8_t byte)
{
    if (byte == cw_estop_frame[*matched]) {
        (*matched)++;
        if (*matched == CW_ESTOP_BYTES) {
            *matched = 1; /* the last zero may be the next frame's first */
            return true;
        }
        return false;
    }
    *matched = byte == 0u ? 1u : 0u;
    return false;
}

void cw_link_init(cw_link *link, cw_robot *robot, const cw_identity *identity)
{
    memset(link, 0, sizeof *link);
    link->robot = robot;
    link->identity = *identity;
    link->nonce = identity->boot_id;
}

/* Receiving. */

/* The CRC over a frame and its own check comes to this, whatever the frame. */
#define CRC_OF_SOUND 0x48674BC7ul

/* And that of the byte that is not sent: H from the host, R from the robot. */
#define CRC_OF_HOST 0x99DF1622ul
#define CRC_OF_ROBOT 0xE263F975ul

static void greet(cw_link *link, uint16_t session, const uint8_t *payload, uint8_t length)
{
    if (length != 6u) {
        link->count.rejected++;
        return;
    }
    link->hello_due = true;
    link->hello_session = session;
    if (payload[0] != CW_VERSION || cw_get_u32(payload + 2) != link->identity.schema) {
        return;
    }
    if (link->session == session) {
        return;
    }
    link->open.challenge_due = true;
    if (link->open.asked != session) {
        link->open.asked = session;
        link->nonce = cw_crc32c((const uint8_t *)&link->robot->now_us, 4, link->nonce);
    }
}

static void confirm(cw_link *link, uint16_t session, const uint8_t *payload, uint8_t length)
{
    if (length != 4u || session != link->open.asked || cw_get_u32(payload) != link->nonce) {
        link->count.session_errors++;
        return;
    }
    cw_robot_open_session(link->robot);
    link->session = session;
    memset(&link->open, 0, sizeof link->open);
}

static bool heading_is_right(const uint8_t *at, bool may_be_free)
{
    int16_t heading = (int16_t)cw_get_u16(at);
    if (heading == CW_HEADING_FREE) {
        return may_be_free;
    }
    return heading >= -CW_HALF_TURN && heading <= CW_HALF_TURN;
}

static bool waypoints_are_right(const uint8_t *payload, uint8_t length)
{
    uint8_t count, i;
    if (length < 10u) {
        return false;
    }
    count = payload[8];
    if (count < 1u || count > CW_WAYPOINTS_PER_FRAME ||
        length != 10u + CW_WAYPOINT_BYTES * count) {
        return false;
    }
    for (i = 0; i < count; i++) {
        const uint8_t *record = payload + 10u + CW_WAYPOINT_BYTES * i;
        if ((record[15] & 0xFCu) != 0u || !heading_is_right(record + 8, true) ||
            cw_get_u32(record) == 0x80000000ul || cw_get_u32(record + 4) == 0x80000000ul) {
            return false;
        }
    }
    return true;
}

/* Whether a host's message of this type has a content that makes sense. */
static bool is_sound(uint8_t type, const uint8_t *payload, uint8_t length)
{
    /* START to RESET_ESTOP, then LEASE to TIMESYNC */
    static const uint8_t lengths[7] CW_IN_FLASH = {10, 2, 6, 2, 9, 14, 4};
    uint8_t row = (uint8_t)(type - CW_START);
    if (type == CW_WAYPOINTS) {
        return waypoints_are_right(payload, length);
    }
    if (row > 3u) {
        row = (uint8_t)(type - CW_LEASE + 4u);
        if (row < 4u || row > 6u) {
            return false;
        }
    }
    if (CW_FLASH_BYTE(&lengths[row]) != length) {
        return false;
    }
    if (type == CW_LEASE) {
        return (payload[8] & 0xFCu) == 0u;
    }
    return type != CW_POSE || heading_is_right(payload + 8, false);
}

static bool is_reliable_type(uint8_t type)
{
    return type >= CW_WAYPOINTS && type <= CW_RESET_ESTOP;
}

CW_APART static void answer(cw_link *link, const uint8_t *payload, cw_result result)
{
    link->open.command = cw_get_u16(payload);
    link->open.result = (uint8_t)result;
    link->robot->news = true;
}

static bool see_pose(cw_link *link, const uint8_t *payload)
{
    int32_t seen[3];
    memcpy(seen, payload, 8);
    seen[2] = (int32_t)((uint32_t)cw_angle_of((int16_t)cw_get_u16(payload + 8)) << 16);
    return cw_robot_pose(link->robot, seen, cw_get_u32(payload + 10));
}

/* Do what a sound message says; false where it cannot be taken now. */
CW_APART static bool act(cw_link *link, uint8_t type, const uint8_t *payload)
{
    cw_robot *robot = link->robot;
    cw_lease lease;
    switch (type) {
    case CW_WAYPOINTS:
        return cw_robot_accept(robot, cw_get_u32(payload), cw_get_u32(payload + 4), payload[8],
                               payload + 10);
    case CW_START:
        answer(link, payload,
               cw_robot_start(robot, cw_get_u32(payload + 2), cw_get_u32(payload + 6)));
        break;
    case CW_PAUSE:
        answer(link, payload, cw_robot_pause(robot));
        break;
    case CW_CLEAR:
        answer(link, payload, cw_robot_clear(robot, cw_get_u32(payload + 2)));
        break;
    case CW_RESET_ESTOP:
        answer(link, payload, cw_robot_reset_estop(robot));
        break;
    case CW_LEASE:
        link->open.ack_due = true;
        memcpy(&lease, payload, CW_LEASE_BYTES);
        return cw_robot_lease(robot, &lease);
    case CW_POSE:
        return see_pose(link, payload);
    case CW_TIMESYNC:
    default:
        link->open.sync_due = true;
        link->sync_host_us = cw_get_u32(payload);
        link->sync_robot_us = robot->now_us;
        break;
    }
    return true;
}

static void take_message(cw_link *link, const uint8_t *frame, uint8_t length)
{
    bool reliable = (frame[0] & CW_FLAG_RELIABLE) != 0u;
    uint8_t type = frame[1];
    uint8_t ahead = (uint8_t)(frame[4] - link->open.expected);
    const uint8_t *payload = frame + CW_HEADER_BYTES;
    if (!is_sound(type, payload, length)) {
        link->count.rejected++;
        if (reliable && ahead == 0u) {
            /* a whole frame of nonsense will not get better by being sent again */
            link->open.expected++;
            link->open.ack_due = true;
        }
        return;
    }
    if (reliable != is_reliable_type(type)) {
        link->count.rejected++;
        return;
    }
    if (reliable) {
        link->open.ack_due = true;
        if (ahead > 128u) {
            link->count.duplicates++;
            return;
        }
        if (ahead > 0u) {
            link->count.gaps++;
            link->open.nak_due = true;
            return;
        }
    }
    if (!act(link, type, payload)) {
        link->count.rejected++;
    } else if (reliable) {
        link->open.expected++;
    }
}

static void damaged(cw_link *link, uint16_t *counter)
{
    (*counter)++;
    if (link->session != 0u) {
        link->open.nak_due = true; /* ask at once, do not wait for the host's timeout */
    }
}

/* COBS and CRC go byte by byte as the line brings them, so that a frame is answered at once. */
CW_APART static void keep(cw_link *link, uint8_t byte)
{
    link->buffer[link->filled++] = byte;
    link->crc = cw_crc32c(&byte, 1, link->crc);
}

static void take_byte(cw_link *link, uint8_t byte)
{
    if (link->encoded == CW_MAX_ENCODED) {
        link->encoded++;
        damaged(link, &link->count.format_errors);
    }
    if (link->encoded > CW_MAX_ENCODED) {
        return; /* too long: until the next zero */
    }
    if (link->encoded++ == 0u) {
        link->filled = 0;
        link->crc = CRC_OF_HOST;
        link->block = byte;
    } else if (link->block == 1u) {
        keep(link, 0);
        link->block = byte;
    } else {
        keep(link, byte);
        link->block--;
    }
}

/* A zero has ended what may be a frame. */
CW_APART static void take_frame(cw_link *link)
{
    const uint8_t *frame = link->buffer;
    uint8_t length, type;
    uint16_t session;
    if (link->block != 1u || link->filled < CW_HEADER_BYTES + CW_CHECK_BYTES) {
        damaged(link, &link->count.format_errors);
        return;
    }
    if (link->crc != CRC_OF_SOUND) {
        damaged(link, &link->count.crc_errors);
        return;
    }
    length = (uint8_t)(link->filled - CW_HEADER_BYTES - CW_CHECK_BYTES);
    type = frame[1];
    if (frame[7] != length) {
        damaged(link, &link->count.format_errors);
        return;
    }
    if ((frame[0] >> 4 != CW_VERSION || (frame[0] & 0x0Cu) != 0u) && type != CW_HELLO &&
        type != CW_HELLO_ACK) {
        damaged(link, &link->count.format_errors);
        return;
    }
    link->count.frames++;
    session = cw_get_u16(frame + 2);
    if (type == CW_ESTOP_TYPE) {
        cw_robot_emergency_stop(link->robot, CW_REASON_ESTOP_HOST);
    } else if (session == 0u) {
        link->count.session_errors++;
    } else if (type == CW_HELLO) {
        greet(link, session, frame + CW_HEADER_BYTES, length);
    } else if (type == CW_CONFIRM) {
        confirm(link, session, frame + CW_HEADER_BYTES, length);
    } else if (session != link->session) {
        link->count.session_errors++;
    } else {
        take_message(link, frame, length);
    }
}

void cw_link_receive(cw_link *link, const uint8_t *data, uint16_t length, uint32_t now_us)
{
    cw_robot_tick(link->robot, now_us);
    while (length-- > 0u) {
        uint8_t byte = *data++;
        if (byte != 0u) {
            take_byte(link, byte);
            continue;
        }
        if (link->encoded > 0u && link->encoded <= CW_MAX_ENCODED) {
            take_frame(link);
        }
        link->encoded = 0;
    }
}

/* Sending: a frame is built behind two free bytes, then encoded in place. */

static uint8_t *begin_frame(const cw_link *link, uint8_t *out, uint8_t type, uint16_t session,
                            uint8_t flags)
{
    uint8_t *at = out + 2;
    at[0] = (uint8_t)(CW_VERSION << 4 | flags);
    at[1] = type;
    (void)cw_put_u16(at + 2, session);
    at[4] = 0;
    at[5] = link->open.expected;
    at[6] = cw_robot_credit(link->robot);
    at[7] = 0;
    return at + CW_HEADER_BYTES;
}

/* Fields that lie in memory as on the wire; returns the place behind. */
static uint8_t *put(uint8_t *to, const void *from, uint8_t size)
{
    memcpy(to, from, size);
    return to + size;
}

/* `end` is the place behind the payload; returns the frame's size on the wire. */
static uint8_t end_frame(uint8_t *out, uint8_t *end)
{
    uint8_t *frame = out + 2;
    uint8_t body = (uint8_t)(end - frame);
    uint8_t code_at = 1;
    uint8_t size, i;
    frame[7] = (uint8_t)(body - CW_HEADER_BYTES);
    end = cw_put_u32(end, cw_crc32c(frame, body, CRC_OF_ROBOT));
    size = (uint8_t)(end - out);
    for (i = 2; i < size; i++) {
        if (out[i] == 0u) {
            out[code_at] = (uint8_t)(i - code_at);
            code_at = i;
        }
    }
    out[code_at] = (uint8_t)(size - code_at);
    out[0] = 0;
    out[size] = 0;
    return (uint8_t)(size + 1u);
}

static uint8_t *put_mission(cw_link *link, uint8_t *at)
{
    while (cw_robot_sum(link->robot)) {
    }
    return put(at, &link->robot->mission, 20);
}

static uint8_t send_hello_ack(cw_link *link, uint8_t *out)
{
    const cw_robot *robot = link->robot;
    uint8_t *at = begin_frame(link, out, CW_HELLO_ACK, link->hello_session, 0);
    *at++ = CW_VERSION;
    *at++ = CW_MINOR_VERSION;
    at = put(at, &link->identity, 13);
    *at++ = CW_MAX_PAYLOAD;
    at = cw_put_u16(at, CW_RX_WINDOW);
    *at++ = CW_QUEUE_SIZE;
    *at++ = robot->state;
    at = put_mission(link, at);
    return end_frame(out, at);
}

static uint8_t send_challenge(cw_link *link, uint8_t *out)
{
    uint8_t *at = begin_frame(link, out, CW_CHALLENGE, link->open.asked, 0);
    return end_frame(out, cw_put_u32(at, link->nonce));
}

static uint8_t send_ack(cw_link *link, uint8_t *out, uint8_t flags)
{
    uint8_t *at = begin_frame(link, out, CW_ACK, link->session, flags);
    return end_frame(out, cw_put_u32(at, link->robot->accept_next));
}

static uint8_t send_time(cw_link *link, uint8_t *out)
{
    uint8_t *at = begin_frame(link, out, CW_TIMESYNC_REPLY, link->session, 0);
    at = cw_put_u32(at, link->sync_host_us);
    at = cw_put_u32(at, link->sync_robot_us);
    return end_frame(out, cw_put_u32(at, link->robot->now_us + CW_ANSWER_US));
}

static uint8_t send_status(cw_link *link, uint8_t *out)
{
    const cw_robot *robot = link->robot;
    const int32_t *pose = robot->estimate.pose;
    uint8_t *at = begin_frame(link, out, CW_STATUS, link->session, 0);
    at = cw_put_u32(at, robot->now_us);
    at = cw_put_u32(at, link->identity.boot_id);
    at = put_mission(link, at);
    *at++ = robot->state;
    *at++ = cw_robot_flags(robot);
    *at++ = robot->reason;
    *at++ = link->open.result;
    at = cw_put_u16(at, link->open.command);
    at = put(at, pose, 8);
    at = cw_put_u16(at, (uint16_t)cw_heading_of((uint16_t)(pose[2] >> 16)));
    at = cw_put_u16(at, (uint16_t)cw_robot_speed_mm_s(robot));
    at = cw_put_u16(at, (uint16_t)cw_robot_turning_mrad_s(robot));
    at = cw_put_u16(at, cw_robot_pose_age_ms(robot));
    at = cw_put_u16(at, cw_robot_lease_left_ms(robot));
    at = put(at, &link->count, sizeof link->count);
    return end_frame(out, at);
}

static bool status_is_due(const cw_link *link)
{
    uint32_t waited_us = link->robot->now_us - link->status_us;
    return !link->open.status_sent || link->robot->alarm || waited_us >= CW_STATUS_INTERVAL_US ||
           (waited_us >= CW_STATUS_SPACING_US && link->robot->news);
}

uint8_t cw_link_next_frame(cw_link *link, uint8_t out_frame[CW_MAX_WIRE], uint32_t now_us)
{
    cw_robot_tick(link->robot, now_us);
    if (link->hello_due) {
        link->hello_due = false;
        return send_hello_ack(link, out_frame);
    }
    if (link->open.challenge_due) {
        link->open.challenge_due = false;
        return send_challenge(link, out_frame);
    }
    if (link->session == 0u) {
        return 0;
    }
    if (link->open.nak_due && (!link->nak_sent || now_us - link->nak_us >= CW_NAK_INTERVAL_US)) {
        link->nak_sent = true;
        link->nak_us = now_us;
        link->open.nak_due = false;
        link->open.ack_due = false;
        return send_ack(link, out_frame, CW_FLAG_NAK);
    }
    if (link->open.ack_due) {
        link->open.ack_due = false;
        return send_ack(link, out_frame, 0);
    }
    if (link->open.sync_due) {
        link->open.sync_due = false;
        return send_time(link, out_frame);
    }
    if (status_is_due(link)) {
        link->open.status_sent = true;
        link->status_us = now_us;
        link->robot->news = false;
        link->robot->alarm = false;
        return send_status(link, out_frame);
    }
    return 0;
}
