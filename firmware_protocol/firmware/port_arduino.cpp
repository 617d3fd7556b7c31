/* port.h through Arduino's API; arduino/port_arduino.h says for which boards.
 *
 * - The line is Serial, at CW_BAUD; the sketch must not use it.
 * - The emergency stop of the line is seen when the loop reads it: a few milliseconds later than
 *   by an interrupt, which Arduino's API does not offer. A button stops by interrupt.
 * - Encoders are counted on both edges of A.
 */
#include "port_arduino.h"

#ifdef CW_ARDUINO_API

#include <Arduino.h>

extern "C" {
#include "port.h"
#include "settings.h"
}

static volatile int32_t steps[2];
static volatile bool stop_pressed;
static bool off_by_button;
static uint8_t estop_matched;
static bool estop_seen;
static uint16_t carry[2];

/* Some cores have no availableForWrite(): there, as on a board that does not know, it is 0. */
template <typename Port>
static auto room_of(Port &port, int) -> decltype(static_cast<int>(port.availableForWrite()))
{
    return static_cast<int>(port.availableForWrite());
}

template <typename Port> static int room_of(Port &, long)
{
    return 0;
}

static const cw_arduino_wheel &wheel_of(uint8_t side)
{
    return side == 0u ? cw_robot_board.left : cw_robot_board.right;
}

static void motors_off()
{
    analogWrite(cw_robot_board.left.pwm_pin, 0);
    analogWrite(cw_robot_board.right.pwm_pin, 0);
}

/* A leads B when the wheel turns forwards. */
static void count(uint8_t side)
{
    const cw_arduino_wheel &wheel = wheel_of(side);
    bool forwards = digitalRead(wheel.encoder_a_pin) != digitalRead(wheel.encoder_b_pin);
    steps[side] = steps[side] + (forwards ? 1 : -1);
}

static void count_left()
{
    count(0u);
}

static void count_right()
{
    count(1u);
}

static void on_button()
{
    stop_pressed = true;
    digitalWrite(cw_robot_board.left.pwm_pin, LOW);
    digitalWrite(cw_robot_board.right.pwm_pin, LOW);
}

__attribute__((weak)) uint32_t cw_board_noise(void)
{
    uint32_t noise = cw_port_now_us();
    for (uint8_t round = 0; round < 64u; round++) {
        noise = (noise << 5 | noise >> 27) ^ static_cast<uint32_t>(analogRead(cw_robot_board.noise_pin));
        noise = noise * UINT32_C(0x9E3779B1) + cw_port_now_us();
    }
    return noise;
}

__attribute__((weak)) void cw_board_feed_watchdog(void)
{
}

static void begin_wheel(const cw_arduino_wheel &wheel, void (*counter)())
{
    pinMode(wheel.pwm_pin, OUTPUT);
    analogWrite(wheel.pwm_pin, 0);
    pinMode(wheel.back_pin, OUTPUT);
    digitalWrite(wheel.back_pin, LOW);
    pinMode(wheel.encoder_a_pin, INPUT_PULLUP);
    pinMode(wheel.encoder_b_pin, INPUT_PULLUP);
    attachInterrupt(digitalPinToInterrupt(wheel.encoder_a_pin), counter, CHANGE);
}

extern "C" bool cw_port_begin(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    begin_wheel(cw_robot_board.left, count_left);
    begin_wheel(cw_robot_board.right, count_right);
    if (cw_robot_board.stop_pin != CW_NO_PIN) {
        pinMode(cw_robot_board.stop_pin, INPUT_PULLUP);
        attachInterrupt(digitalPinToInterrupt(cw_robot_board.stop_pin), on_button, FALLING);
    }
    Serial.begin(CW_BAUD);
    return true;
}

extern "C" void cw_port_identity(cw_identity *out_identity)
{
    out_identity->schema = CW_SCHEMA_HASH;
    out_identity->firmware = 1;
    out_identity->boot_id = cw_board_noise();
    out_identity->reset_cause = 0; /* Arduino's API does not say */
}

extern "C" uint32_t cw_port_now_us(void)
{
    return static_cast<uint32_t>(micros());
}

extern "C" uint8_t cw_port_read(uint8_t *out_data, uint8_t room)
{
    uint8_t taken = 0;
    while (taken < room && Serial.available() > 0) {
        uint8_t byte = static_cast<uint8_t>(Serial.read());
        if (cw_estop_match(&estop_matched, byte)) {
            estop_seen = true;
            motors_off();
        }
        out_data[taken++] = byte;
    }
    return taken;
}

extern "C" uint16_t cw_port_overruns(void)
{
    return 0; /* Arduino's API does not count them; the frames' CRC notices */
}

extern "C" bool cw_port_can_write(void)
{
    /* a buffer that cannot hold a whole frame is written when it is empty: write() waits then for
     * less than a frame's time; a board that does not say how much room it has says 0 for ever */
    static int most;
    int room = room_of(Serial, 0);
    if (room > most) {
        most = room;
    }
    return room >= static_cast<int>(CW_MAX_WIRE) || room == most;
}

extern "C" void cw_port_write(const uint8_t *data, uint8_t length)
{
    Serial.write(data, length);
}

extern "C" bool cw_port_estop_seen(void)
{
    bool seen = estop_seen || (stop_pressed && !off_by_button);
    estop_seen = false;
    off_by_button = stop_pressed;
    if (stop_pressed && digitalRead(cw_robot_board.stop_pin) != LOW) {
        stop_pressed = false; /* released: it still needs to be re-armed */
    }
    return seen;
}

extern "C" void cw_port_travel(int32_t out_travel_um[2])
{
    for (uint8_t side = 0; side < 2u; side++) {
        noInterrupts();
        int32_t made = steps[side];
        steps[side] = 0;
        interrupts();
        out_travel_um[side] = made * wheel_of(side).um_per_step;
    }
}

/* What a step of the PWM is too coarse for is carried on to the next call. */
static void drive(uint8_t side, int16_t speed)
{
    /* 8160: 255 steps of PWM, times 256 for fractions, over eight of the speed's units a mm/s */
    const cw_arduino_wheel &wheel = wheel_of(side);
    uint32_t size = static_cast<uint32_t>(speed < 0 ? -static_cast<int32_t>(speed) : speed);
    uint32_t fine = size * UINT32_C(8160) / cw_robot_board.full_speed_mm_s + carry[side];
    if (fine > UINT32_C(0xFF00)) {
        fine = UINT32_C(0xFF00);
    }
    carry[side] = static_cast<uint16_t>(fine & 0xFFu);
    digitalWrite(wheel.back_pin, speed < 0 ? HIGH : LOW);
    analogWrite(wheel.pwm_pin, static_cast<int>(fine >> 8));
}

extern "C" void cw_port_drive(cw_wheels wheels)
{
    static uint32_t driven_us;
    uint32_t now_us = cw_port_now_us();
    if (!wheels.powered || stop_pressed || estop_seen) {
        motors_off();
        return;
    }
    /* analogWrite takes some boards tens of microseconds: as often as the wheels are decided on */
    if (now_us - driven_us >= 5000ul) {
        driven_us = now_us;
        drive(0u, wheels.left);
        drive(1u, wheels.right);
        if (stop_pressed) { /* pressed meanwhile */
            motors_off();
        }
    }
}

extern "C" bool cw_port_idle(void)
{
    cw_board_feed_watchdog();
    return true;
}

#endif
