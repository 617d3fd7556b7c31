/* ARM Cortex-M3 without an operating system: the board MPS2 with the image AN385, which
 * qemu-system-arm emulates. An example to adapt: the registers of clock, serial ports and
 * watchdog stand below, in one place each.
 *
 * The wheels are on a motor board behind the second serial port, as common controllers are, for
 * this board has no timers for PWM. Frames on that line, both of seven bytes:
 *   to the motor board    0xA5, speed left, right (int16, eighths of mm/s), power (0 or 1), sum
 *   from the motor board  0x5A, flag, steps of the encoders left, right (int16, since power on), sum
 * Numbers are little-endian; a frame's bytes sum to 0 modulo 256.
 */
#include "port.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))

/* The processor's own clock, 25 MHz. */
#define CLOCK_MHZ 25u
#define SYSTICK_CONTROL REGISTER(0xE000E010u)
#define SYSTICK_RELOAD REGISTER(0xE000E014u)
#define SYSTICK_VALUE REGISTER(0xE000E018u)
#define INTERRUPT_ENABLE REGISTER(0xE000E100u)
#define MS_CYCLES (CLOCK_MHZ * 1000u)

/* A counter that runs down from 2^32 at the processor's clock and begins again by itself (CMSDK
 * dual timer). No tick of it is lost where interrupts are late. */
#define COUNTER_VALUE REGISTER(0x40002004u)
#define COUNTER_CONTROL REGISTER(0x40002008u)
#define COUNTER_RUNS_32_BITS 0x82u

/* Serial ports (CMSDK APB UART). */
#define WIRE 0x40004000u
#define BOARD 0x40005000u
#define UART_DATA(uart) REGISTER((uart) + 0x00u)
#define UART_STATE(uart) REGISTER((uart) + 0x04u)
#define UART_CONTROL(uart) REGISTER((uart) + 0x08u)
#define UART_INTERRUPTS(uart) REGISTER((uart) + 0x0Cu)
#define UART_DIVIDER(uart) REGISTER((uart) + 0x10u)
#define STATE_SENDING 1u
#define STATE_RECEIVED 2u
#define STATE_OVERRUN 8u
#define ON_SENT 1u
#define ON_RECEIVED 2u
#define ENABLE_BOTH 0x0Fu /* send, receive, and an interrupt for each */

/* Watchdog (CMSDK): warns by NMI, and resets a period later. */
#define WATCHDOG 0x40008000u
#define WATCHDOG_LOAD REGISTER(WATCHDOG + 0x00u)
#define WATCHDOG_CONTROL REGISTER(WATCHDOG + 0x08u)
#define WATCHDOG_LOCK REGISTER(WATCHDOG + 0xC00u)
#define WATCHDOG_KEY 0x1ACCE551u
#define WATCHDOG_MS 125u /* twice until it resets */

#define RING 256u /* a power of two */
#define TO_BOARD 0xA5u
#define FROM_BOARD 0x5Au
#define BOARD_FRAME 7u
#define REPEAT_US 10000u
#define KNOWN 0xC1EA2B00u

#define BAUD_DIVIDER ((CLOCK_MHZ * 1000000u + CW_BAUD / 2u) / CW_BAUD)

void cw_on_failure(void);
void cw_on_clock(void);
void cw_on_wire_received(void);
void cw_on_wire_sent(void);
void cw_on_board_received(void);
void cw_on_board_sent(void);

static volatile uint8_t ring[RING];
static volatile uint8_t ring_in;
static uint8_t ring_out;
static volatile uint16_t lost;
static volatile bool estop_seen;
static uint8_t estop_matched;
static const uint8_t *volatile sending;
static volatile uint8_t left_to_send;

static uint8_t order[BOARD_FRAME];
static volatile uint8_t order_at = BOARD_FRAME; /* the byte to send next */
static volatile bool order_waits;
static cw_wheels ordered;
static uint8_t report[BOARD_FRAME];
static uint8_t report_at;
static volatile int16_t steps[2]; /* of the motor board's last report */
static volatile bool reported;
static int16_t counted[2]; /* of those, what has been handed on */
static bool counting;

/* Memory that survives a reset. A programmer may write the seed; boots are counted beside it. */
__attribute__((section(".seed"))) static volatile uint32_t seed;
__attribute__((section(".noinit"))) static volatile uint32_t boots;
__attribute__((section(".noinit"))) static volatile uint32_t known;
__attribute__((section(".noinit"))) static volatile uint32_t bitten;

static void lock(void)
{
    __asm volatile("cpsid i" ::: "memory");
}

static void unlock(void)
{
    __asm volatile("cpsie i" ::: "memory");
}

/* The next byte of the order under way, or the first of the one that waits. */
static void send_order(void)
{
    if (order_at == BOARD_FRAME && order_waits) {
        uint8_t sum = 0;
        uint8_t at;
        uint16_t left = (uint16_t)ordered.left;
        uint16_t right = (uint16_t)ordered.right;
        order[0] = TO_BOARD;
        order[1] = (uint8_t)left;
        order[2] = (uint8_t)(left >> 8);
        order[3] = (uint8_t)right;
        order[4] = (uint8_t)(right >> 8);
        order[5] = ordered.powered ? 1u : 0u;
        for (at = 0; at < BOARD_FRAME - 1u; at++) {
            sum = (uint8_t)(sum + order[at]);
        }
        order[BOARD_FRAME - 1u] = (uint8_t)(0u - sum);
        order_at = 0;
        order_waits = false;
    }
    if (order_at < BOARD_FRAME && (UART_STATE(BOARD) & STATE_SENDING) == 0u) {
        uint8_t at = order_at;
        order_at = (uint8_t)(at + 1u);
        UART_DATA(BOARD) = order[at];
    }
}

static void motors_off(void)
{
    ordered.left = 0;
    ordered.right = 0;
    ordered.powered = false;
    order_waits = true;
    send_order();
}

void cw_on_failure(void)
{
    bitten = KNOWN;
    lock();
    /* no interrupt may run in a fault: the order goes out byte by byte */
    motors_off();
    while (order_at < BOARD_FRAME || order_waits) {
        send_order();
    }
    for (;;) { /* the watchdog resets */
    }
}

void cw_on_clock(void)
{
    /* it only ends a wait */
}

void cw_on_wire_received(void)
{
    UART_INTERRUPTS(WIRE) = ON_RECEIVED; /* first: a byte that comes meanwhile asks again */
    while ((UART_STATE(WIRE) & STATE_RECEIVED) != 0u) {
        uint8_t byte = (uint8_t)UART_DATA(WIRE);
        uint8_t next = (uint8_t)((ring_in + 1u) % RING);
        if (cw_estop_match(&estop_matched, byte)) {
            estop_seen = true;
            motors_off();
        }
        if (next == ring_out) {
            lost++;
        } else {
            ring[ring_in] = byte;
            ring_in = next;
        }
    }
    if ((UART_STATE(WIRE) & STATE_OVERRUN) != 0u) {
        UART_STATE(WIRE) = STATE_OVERRUN;
        lost++;
    }
}

static void send_wire(void)
{
    if (left_to_send > 0u && (UART_STATE(WIRE) & STATE_SENDING) == 0u) {
        const uint8_t *at = sending;
        sending = at + 1;
        left_to_send--;
        UART_DATA(WIRE) = *at;
    }
}

void cw_on_wire_sent(void)
{
    UART_INTERRUPTS(WIRE) = ON_SENT;
    send_wire();
}

void cw_on_board_received(void)
{
    UART_INTERRUPTS(BOARD) = ON_RECEIVED;
    while ((UART_STATE(BOARD) & STATE_RECEIVED) != 0u) {
        uint8_t byte = (uint8_t)UART_DATA(BOARD);
        uint8_t sum = 0;
        uint8_t at;
        if (report_at == 0u && byte != FROM_BOARD) {
            continue;
        }
        report[report_at++] = byte;
        if (report_at < BOARD_FRAME) {
            continue;
        }
        report_at = 0;
        for (at = 0; at < BOARD_FRAME; at++) {
            sum = (uint8_t)(sum + report[at]);
        }
        if (sum == 0u) {
            steps[0] = (int16_t)(uint16_t)(report[2] | report[3] << 8);
            steps[1] = (int16_t)(uint16_t)(report[4] | report[5] << 8);
            reported = true;
        }
    }
}

void cw_on_board_sent(void)
{
    UART_INTERRUPTS(BOARD) = ON_SENT;
    send_order();
}

bool cw_port_begin(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    UART_DIVIDER(BOARD) = BAUD_DIVIDER;
    UART_DIVIDER(WIRE) = BAUD_DIVIDER;
    UART_CONTROL(BOARD) = ENABLE_BOTH;
    motors_off();
    COUNTER_CONTROL = COUNTER_RUNS_32_BITS;
    SYSTICK_RELOAD = MS_CYCLES - 1u;
    SYSTICK_VALUE = 0u;
    SYSTICK_CONTROL = 7u; /* the processor's clock, with an interrupt */
    UART_CONTROL(WIRE) = ENABLE_BOTH;
    INTERRUPT_ENABLE = 0x0Fu;
    WATCHDOG_LOCK = WATCHDOG_KEY;
    WATCHDOG_LOAD = WATCHDOG_MS * MS_CYCLES;
    WATCHDOG_CONTROL = 3u;
    unlock();
    return true;
}

void cw_port_identity(cw_identity *out_identity)
{
    bool again = known == KNOWN;
    if (!again) {
        boots = 0u;
        bitten = 0u;
    }
    known = KNOWN;
    boots++;
    out_identity->schema = CW_SCHEMA_HASH;
    out_identity->firmware = 1;
    out_identity->boot_id = seed + boots * 0x9E3779B9u;
    out_identity->reset_cause = !again ? 1u : bitten == KNOWN ? 4u : 2u;
    bitten = 0u;
}

/* To be called at least once in 171 s, which every round of the program does. */
uint32_t cw_port_now_us(void)
{
    static uint32_t now_us;
    static uint32_t counted_to; /* the counter begins with 2^32 - 1, and counts down */
    static uint32_t rest;
    uint32_t passed = ~COUNTER_VALUE - counted_to;
    counted_to += passed;
    now_us += passed / CLOCK_MHZ;
    rest += passed % CLOCK_MHZ;
    if (rest >= CLOCK_MHZ) {
        rest -= CLOCK_MHZ;
        now_us++;
    }
    return now_us;
}

uint8_t cw_port_read(uint8_t *out_data, uint8_t room)
{
    uint8_t count = 0;
    while (count < room && ring_out != ring_in) {
        out_data[count++] = ring[ring_out];
        ring_out = (uint8_t)((ring_out + 1u) % RING);
    }
    return count;
}

uint16_t cw_port_overruns(void)
{
    uint16_t count;
    lock();
    count = lost;
    lost = 0;
    unlock();
    return count;
}

bool cw_port_can_write(void)
{
    return left_to_send == 0u;
}

void cw_port_write(const uint8_t *data, uint8_t length)
{
    lock();
    sending = data;
    left_to_send = length;
    send_wire();
    unlock();
}

bool cw_port_estop_seen(void)
{
    bool seen;
    lock();
    seen = estop_seen;
    estop_seen = false;
    unlock();
    return seen;
}

void cw_port_travel(int32_t out_travel_um[2])
{
    uint8_t wheel;
    lock();
    if (reported && !counting) { /* the motor board counts since its own power on */
        counted[0] = steps[0];
        counted[1] = steps[1];
        counting = true;
    }
    for (wheel = 0; wheel < 2u; wheel++) {
        int16_t since = (int16_t)(uint16_t)((uint16_t)steps[wheel] - (uint16_t)counted[wheel]);
        counted[wheel] = steps[wheel];
        out_travel_um[wheel] = counting ? since * CW_UM_PER_STEP : 0;
    }
    unlock();
}

/* Repeated with every control cycle, so that a motor board that lost an order, or stops by itself
 * where orders fail to come, hears the next one. */
void cw_port_drive(cw_wheels wheels)
{
    static uint32_t said_us;
    uint32_t now_us = cw_port_now_us();
    lock();
    if (estop_seen) { /* since the decision */
        unlock();
        return;
    }
    if (wheels.left != ordered.left || wheels.right != ordered.right ||
        wheels.powered != ordered.powered || now_us - said_us >= REPEAT_US) {
        said_us = now_us;
        ordered = wheels;
        order_waits = true;
        send_order();
    }
    unlock();
}

bool cw_port_idle(void)
{
    WATCHDOG_LOCK = WATCHDOG_KEY;
    WATCHDOG_LOAD = WATCHDOG_MS * MS_CYCLES;
    __asm volatile("wfi"); /* until a byte or the next millisecond comes */
    return true;
}
