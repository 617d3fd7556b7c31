/* The firmware on any board that Arduino runs on, through Arduino's own API: ESP32, RP2040, SAMD,
 * UNO R4, Mega, Leonardo and others. A sketch says here how its robot is wired.
 *
 * On an ATmega328P (Uno, Nano) port_avr.c does the same with that processor's registers, and this
 * file is empty unless CW_USE_ARDUINO_API is defined for the whole library.
 */
#ifndef CLEARWAY_PORT_ARDUINO_H
#define CLEARWAY_PORT_ARDUINO_H

#if !defined(__AVR_ATmega328P__) || defined(CW_USE_ARDUINO_API)
#define CW_ARDUINO_API 1

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CW_NO_PIN 255u

/* One wheel: a motor driver with a PWM and a direction input, and an encoder with two outputs. */
typedef struct {
    uint8_t pwm_pin;
    uint8_t back_pin;      /* high: the wheel turns backwards */
    uint8_t encoder_a_pin; /* has to be able to interrupt */
    uint8_t encoder_b_pin;
    int32_t um_per_step; /* travel between two edges of A: half of what a full quadrature counts;
                          * negative where the encoder counts in the other direction */
} cw_arduino_wheel;

typedef struct {
    cw_arduino_wheel left;
    cw_arduino_wheel right;
    uint16_t full_speed_mm_s; /* a wheel's speed at full PWM */
    uint8_t noise_pin;        /* an analog input with nothing on it: seeds the boot id */
    uint8_t stop_pin;         /* a button to ground that stops everything, or CW_NO_PIN */
} cw_arduino_board;

/* Defined by the sketch. */
extern const cw_arduino_board cw_robot_board;

/* Overridden by a sketch whose board has them: a number that differs at every boot (a hardware
 * random number), and a watchdog to feed. */
uint32_t cw_board_noise(void);
void cw_board_feed_watchdog(void);

#ifdef __cplusplus
}
#endif

#endif
#endif
