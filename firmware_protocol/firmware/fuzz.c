/* libFuzzer's way into the firmware, in virtual time and in this process.
 *
 *     make fuzz; build/firmware/fuzz_link CORPUS    any bytes from the line
 *     build/firmware/fuzz_robot CORPUS              orders in whole frames, time, wheels, poses
 *
 * Built with ASan and UBSan; after every deed the rules of robot.h and link.h are checked. Built
 * with CW_FUZZ_REPLAY it has a main that runs files instead, for compilers without libFuzzer. */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "link.h"

const cw_settings cw_robot_settings = CW_SETTINGS;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define LONGEST_US (CW_LEASE_MAX_MS * 1000ul + CW_AHEAD_US)

static cw_robot robot;
static cw_link line;
static uint32_t now_us;
static uint32_t leased_us;
static int32_t travel_um[2];

static void require(bool holds, const char *rule)
{
    if (!holds) {
        (void)fprintf(stderr, "broken: %s\n", rule);
        abort();
    }
}

static void check(void)
{
    require(robot.state <= CW_STATE_ESTOP, "the state is one of five");
    require(robot.queue.count <= CW_QUEUE_SIZE, "the queue has 32 places");
    require(robot.accept_next - robot.exec_next == robot.queue.count,
            "what was accepted is executed or in the queue");
    require(robot.accept_next != robot.exec_next || robot.prefix_crc == robot.exec_crc,
            "all executed: the fingerprints agree");
    if (robot.state == CW_STATE_ESTOP) {
        require(!robot.wheels.powered && robot.wheels.left == 0 &&
                    robot.wheels.right == 0,
                "no power after an emergency stop");
    }
    if (robot.state == CW_STATE_RUN) {
        require(now_us - leased_us <= LONGEST_US, "no driving without a lease");
        require(robot.mission != 0u && !robot.done, "no driving without a mission");
    }
}

static void talk(void)
{
    static uint8_t frame[CW_MAX_WIRE];
    uint8_t length, i;
    while ((length = cw_link_next_frame(&line, frame, now_us)) > 0u) {
        require(length <= CW_MAX_WIRE && frame[0] == 0u && frame[length - 1u] == 0u,
                "a frame lies between zeros");
        for (i = 1; i + 1u < length; i++) {
            require(frame[i] != 0u, "no zero inside a frame");
        }
    }
}

static void begin(void)
{
    static const cw_identity identity = {CW_SCHEMA_HASH, 1, 2, 1};
    memset(&robot, 0xA5, sizeof robot); /* init has to set every field */
    memset(&line, 0xA5, sizeof line);
    cw_robot_init(&robot);
    cw_link_init(&line, &robot, &identity);
    now_us = 4294000000ul; /* the clock wraps in every run */
    leased_us = now_us - (uint32_t)(2u * LONGEST_US);
}

/* A whole frame as a host would send it. */
static void send(uint8_t type, uint8_t flags, uint8_t sequence, const uint8_t *payload,
                 uint8_t length)
{
    static const uint8_t sender = CW_SENDER_HOST;
    uint8_t wire[CW_MAX_WIRE];
    uint8_t *body = wire + 2;
    uint8_t code_at = 1, size, i;
    body[0] = (uint8_t)(CW_VERSION << 4 | (flags & 0x0Fu));
    body[1] = type;
    (void)cw_put_u16(body + 2, type == CW_ESTOP_TYPE ? 0u : 7u);
    body[4] = sequence;
    body[5] = body[6] = 0;
    body[7] = length;
    if (length > 0u) {
        memcpy(body + 8, payload, length);
    }
    (void)cw_put_u32(body + 8 + length,
                     cw_crc32c(body, (uint16_t)(8u + length), cw_crc32c(&sender, 1, 0)));
    size = (uint8_t)(length + 14u);
    for (i = 2; i < size; i++) {
        if (wire[i] == 0u) {
            wire[code_at] = (uint8_t)(i - code_at);
            code_at = i;
        }
    }
    wire[code_at] = (uint8_t)(size - code_at);
    wire[0] = wire[size] = 0;
    if (type == CW_LEASE) {
        leased_us = now_us;
    }
    cw_link_receive(&line, wire, (uint16_t)(size + 1u), now_us);
}

static void order(uint8_t type, const uint8_t *payload, uint8_t length)
{
    send(type, CW_FLAG_RELIABLE, line.open.expected, payload, length);
}

static void hello(void)
{
    uint8_t payload[6] = {CW_VERSION, CW_MINOR_VERSION};
    (void)cw_put_u32(payload + 2, CW_SCHEMA_HASH);
    send(CW_HELLO, 0, 0, payload, sizeof payload);
    (void)cw_put_u32(payload, line.nonce);
    send(CW_CONFIRM, 0, 0, payload, 4);
    require(line.session == 7u, "a session opens when the challenge was given back");
}

static void lease(uint8_t flags)
{
    uint8_t payload[CW_LEASE_BYTES] = {0, 0, 0, 0, 0xF4, 0x01, 10, 0, flags};
    (void)cw_put_u32(payload, now_us);
    send(CW_LEASE, 0, 0, payload, sizeof payload);
}

#ifndef CW_FUZZ_LINK

/* Two bytes say how old it is, in 0.1 ms. */
static void see(const uint8_t *rest, uint8_t length)
{
    uint8_t payload[14] = {0};
    if (length < 12u) {
        send(CW_POSE, 0, 0, rest, length);
        return;
    }
    memcpy(payload, rest, 10);
    (void)cw_put_u32(payload + 10, now_us - 100u * cw_get_u16(rest + 10));
    send(CW_POSE, 0, 0, payload, sizeof payload);
}

#endif

static void clear(uint8_t mission)
{
    uint8_t payload[6] = {2, 0, mission, 0, 0, 0};
    order(CW_CLEAR, payload, sizeof payload);
}

#ifdef CW_FUZZ_LINK

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    begin();
    hello();
    clear(9);
    lease(CW_LEASE_PERMIT | CW_LEASE_ODOMETRY);
    while (size > 0u) {
        uint16_t part = (uint16_t)(*data % 61u + 1u);
        if (part > size) {
            part = (uint16_t)size;
        }
        leased_us = now_us; /* a lease may be among the bytes */
        cw_link_receive(&line, data, part, now_us);
        talk();
        check();
        data += part;
        size -= part;
        now_us += 5000u;
        cw_robot_step(&robot, now_us, travel_um);
        check();
    }
    return 0;
}

#else

static void start(void)
{
    uint8_t payload[10] = {1, 0};
    (void)cw_put_u32(payload + 2, robot.mission);
    (void)cw_put_u32(payload + 6, robot.exec_next);
    lease(CW_LEASE_PERMIT | CW_LEASE_ODOMETRY);
    order(CW_START, payload, sizeof payload);
}

/* Records as the fuzzer likes them, but with the right mission and index. */
static void queue(const uint8_t *records, uint8_t count)
{
    uint8_t payload[CW_MAX_PAYLOAD];
    (void)cw_put_u32(payload, robot.mission);
    (void)cw_put_u32(payload + 4, robot.accept_next);
    payload[8] = count;
    payload[9] = 0;
    memcpy(payload + 10, records, (size_t)count * CW_WAYPOINT_BYTES);
    order(CW_WAYPOINTS, payload, (uint8_t)(10u + count * CW_WAYPOINT_BYTES));
}

static void drive(uint8_t cycles, bool obey, int16_t slip)
{
    while (cycles-- > 0u) {
        now_us += 10000u;
        if (obey) {
            /* an eighth of mm/s is 1.25 um in a hundredth of a second */
            travel_um[0] = robot.wheels.left * 5 / 4 + slip;
            travel_um[1] = robot.wheels.right * 5 / 4;
        } else {
            travel_um[0] = slip < -0x6000 ? -CW_LEAP_UM : (int32_t)slip * 32;
            travel_um[1] = -(int32_t)slip;
        }
        cw_robot_step(&robot, now_us, travel_um);
        check();
        talk();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    begin();
    hello();
    clear(9);
    while (size >= 2u) {
        uint8_t deed = data[0];
        uint8_t length = data[1];
        const uint8_t *rest = data + 2;
        size -= 2u;
        if (length > CW_MAX_PAYLOAD) {
            length = CW_MAX_PAYLOAD;
        }
        if (length > size) {
            length = (uint8_t)size;
        }
        switch (deed & 7u) {
        case 0:
            leased_us = now_us;
            cw_link_receive(&line, rest, length, now_us);
            break;
        case 1:
            send(length > 0u ? rest[0] : 0, deed >> 4, line.open.expected, rest, length);
            break;
        case 2:
            queue(rest, (uint8_t)(length / CW_WAYPOINT_BYTES % (CW_WAYPOINTS_PER_FRAME + 1u)));
            break;
        case 3:
            start();
            break;
        case 4:
            lease((uint8_t)(deed >> 6));
            drive((uint8_t)(deed >> 3 & 7u), length > 1u, length > 3u ? rest[2] : 0);
            break;
        case 5:
            drive((uint8_t)(deed >> 3), (length & 1u) != 0u,
                  length > 3u ? (int16_t)cw_get_u16(rest) : 0);
            break;
        case 6:
            see(rest, length);
            break;
        default:
            if (deed > 0xF0u) {
                send(CW_ESTOP_TYPE, 0, 0, NULL, 0);
            } else if (deed > 0xE0u) {
                clear(length);
            } else {
                now_us += (uint32_t)length << (deed >> 3 & 15u);
                cw_robot_tick(&robot, now_us);
            }
            break;
        }
        check();
        talk();
        data += 2u + length;
        size -= length;
    }
    return 0;
}

#endif

#ifdef CW_FUZZ_REPLAY

/* One input a line, in hexadecimal, on stdin. */
int main(void)
{
    static char text[16384];
    static uint8_t data[sizeof text / 2u];
    while (fgets(text, sizeof text, stdin) != NULL) {
        size_t length = strcspn(text, "\n") / 2u, i;
        for (i = 0; i < length; i++) {
            char digits[3] = {text[2u * i], text[2u * i + 1u], '\0'};
            data[i] = (uint8_t)strtoul(digits, NULL, 16);
        }
        (void)LLVMFuzzerTestOneInput(data, length);
    }
    return 0;
}

#endif
