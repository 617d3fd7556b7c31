/* ATmega328P at 16 MHz: UART0, Timer1 as the clock, H bridge on Timer0, encoders on
 * the pin-change interrupt. An example to adapt.
 *
 * At 16 MHz 115200 is 2.1 % off, and 250000 is exact. The pins stand below, in one place. Only for
 * this processor: on another one the file is empty, and the board brings a port of its own.
 */
#include "port.h"

#if defined(__AVR_ATmega328P__) && !defined(CW_USE_ARDUINO_API)

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

/* At double speed: the clock over 8 times the rate, to the nearest. */
#define BAUD_DIVIDER ((F_CPU + CW_BAUD * 4u) / (CW_BAUD * 8u) - 1u)
#define BAUD_MADE (F_CPU / (8u * (BAUD_DIVIDER + 1u)))
#if BAUD_MADE * 1000ul > CW_BAUD * 1025ul || BAUD_MADE * 1000ul < CW_BAUD * 975ul
#error "the processor's clock cannot make this baud rate to 2.5 %"
#endif
/* 65536 times the PWM's steps for an eighth of mm/s. */
#define DUTY_PER_SPEED ((uint16_t)(255ul * 8192u / CW_FULL_SPEED_MM_S))
#define RING 128u /* a power of two */

/* Left motor: PWM on D6 (OC0A), direction on D7. Right: PWM on D5 (OC0B), direction on D8.
 * Encoders: left A, B on C0, C1; right A, B on C2, C3. */
#define LEFT_BACK PD7
#define RIGHT_BACK PB0

/* 0 for the old bootloader of the Nano (ATmegaBOOT): it leaves the watchdog on after its reset, which
 * bites it again and again, so that the board never starts. Optiboot and a board that is programmed
 * without a bootloader need no change. */
#ifndef CW_WATCHDOG
#define CW_WATCHDOG 1
#endif

static volatile uint8_t ring[RING];
static volatile uint8_t ring_in;
static uint8_t ring_out;
static volatile uint8_t lost;
static volatile uint8_t estop_seen;
static uint8_t estop_matched;
static const uint8_t *volatile sending;
static volatile uint8_t left_to_send;
static volatile uint32_t overflows; /* of Timer1: 32.768 ms each */
static volatile int16_t ticks[2]; /* since they were asked for last */
static uint8_t pins_before;
static uint8_t reset_flags __attribute__((section(".noinit")));
static uint32_t boots __attribute__((section(".noinit")));

/* Before main: the watchdog is still on after its own reset, and would bite again. */
void cw_port_early(void) __attribute__((naked, used, section(".init3")));
void cw_port_early(void)
{
    reset_flags = MCUSR;
    MCUSR = 0;
    wdt_disable();
}

/* Overridden by a sketch, which cannot define CW_WATCHDOG. */
bool cw_board_has_watchdog(void);
__attribute__((weak)) bool cw_board_has_watchdog(void)
{
    return true;
}

static void motors_off(void)
{
    OCR0A = 0;
    OCR0B = 0;
    TCCR0A = _BV(WGM01) | _BV(WGM00);
    PORTD &= (uint8_t)~(_BV(PD5) | _BV(PD6));
}

ISR(USART_RX_vect)
{
    uint8_t status = UCSR0A;
    uint8_t byte = UDR0;
    uint8_t next = (uint8_t)((ring_in + 1u) % RING);
    if ((status & _BV(DOR0)) != 0u) {
        lost++;
    }
    if (cw_estop_match(&estop_matched, byte)) {
        estop_seen = 1;
        motors_off();
    }
    if (next == ring_out) {
        lost++;
        return;
    }
    ring[ring_in] = byte;
    ring_in = next;
}

ISR(USART_UDRE_vect)
{
    if (left_to_send == 0u) {
        UCSR0B &= (uint8_t)~_BV(UDRIE0);
        return;
    }
    UDR0 = *sending++;
    left_to_send--;
}

ISR(TIMER1_OVF_vect)
{
    overflows++;
}

/* A and B of a wheel are two bits; one step forwards makes A lead. */
ISR(PCINT1_vect)
{
    uint8_t now = PINC & 0x0Fu;
    uint8_t old = pins_before;
    uint8_t wheel;
    pins_before = now;
    for (wheel = 0; wheel < 2u; wheel++) {
        uint8_t changed = (uint8_t)(old ^ now) & 3u;
        if (changed == 1u || changed == 2u) { /* else nothing, or a step was missed */
            if ((((uint8_t)(now >> 1) ^ old) & 1u) != 0u) {
                ticks[wheel]--;
            } else {
                ticks[wheel]++;
            }
        }
        old >>= 2;
        now >>= 2;
    }
}

bool cw_port_begin(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    DDRD |= _BV(PD5) | _BV(PD6) | _BV(LEFT_BACK);
    DDRB |= _BV(RIGHT_BACK);
    motors_off();
    TCCR0B = _BV(CS01) | _BV(CS00); /* 977 Hz */
    PORTC |= 0x0Fu;                 /* pull-ups */
    pins_before = PINC & 0x0Fu;
    PCICR = _BV(PCIE1);
    PCMSK1 = 0x0Fu;
    TCCR1B = _BV(CS11); /* 2 ticks a microsecond */
    TIMSK1 = _BV(TOIE1);
    UBRR0 = BAUD_DIVIDER;
    UCSR0A = _BV(U2X0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
#if CW_WATCHDOG
    if (cw_board_has_watchdog()) {
        wdt_enable(WDTO_250MS);
    }
#endif
    sei();
    return true;
}

void cw_port_identity(cw_identity *out_identity)
{
    /* memory that survives a reset counts boots; after power on its garbage is the seed */
    boots += 0x9E3779B9ul + TCNT1;
    out_identity->schema = CW_SCHEMA_HASH;
    out_identity->firmware = 1;
    out_identity->boot_id = boots;
    out_identity->reset_cause = (reset_flags & _BV(WDRF)) != 0u    ? 4u
                                : (reset_flags & _BV(BORF)) != 0u  ? 3u
                                : (reset_flags & _BV(PORF)) != 0u  ? 1u
                                : (reset_flags & _BV(EXTRF)) != 0u ? 2u
                                                                   : 0u;
}

uint32_t cw_port_now_us(void)
{
    uint32_t high;
    uint16_t low;
    uint8_t interrupts = SREG;
    cli();
    high = overflows;
    low = TCNT1;
    if ((TIFR1 & _BV(TOV1)) != 0u && low < 0x8000u) {
        high++;
    }
    SREG = interrupts;
    return (high << 15) + (low >> 1); /* wraps at 2^32 us, as it has to */
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
    uint8_t interrupts = SREG;
    uint8_t count;
    cli();
    count = lost;
    lost = 0;
    SREG = interrupts;
    return count;
}

bool cw_port_can_write(void)
{
    return left_to_send == 0u;
}

void cw_port_write(const uint8_t *data, uint8_t length)
{
    sending = data;
    left_to_send = length;
    UCSR0B |= _BV(UDRIE0);
}

bool cw_port_estop_seen(void)
{
    if (estop_seen == 0u) {
        return false;
    }
    estop_seen = 0;
    return true;
}

void cw_port_travel(int32_t out_travel_um[2])
{
    uint8_t wheel;
    for (wheel = 0; wheel < 2u; wheel++) {
        uint8_t interrupts = SREG;
        int16_t steps;
        cli();
        steps = ticks[wheel];
        ticks[wheel] = 0;
        SREG = interrupts;
        out_travel_um[wheel] = steps * CW_UM_PER_STEP;
    }
}

/* What a step of the PWM (3.1 mm/s) is too coarse for is carried on to the next round, so that
 * slow wheels turn at all: without it the robot cannot end a turn at a stop. */
static uint8_t duty(int16_t speed, uint8_t *carry)
{
    uint32_t fine = ((uint32_t)cw_short_size(speed) * DUTY_PER_SPEED >> 8) + *carry;
    if (fine > 0xFF00u) {
        fine = 0xFF00u;
    }
    *carry = (uint8_t)fine;
    return (uint8_t)(fine >> 8);
}

void cw_port_drive(cw_wheels wheels)
{
    uint8_t interrupts = SREG;
    static uint8_t carry[2];
    uint8_t left = duty(wheels.left, &carry[0]);
    uint8_t right = duty(wheels.right, &carry[1]);
    if (!wheels.powered) {
        motors_off();
        return;
    }
    if (wheels.left < 0) {
        PORTD |= _BV(LEFT_BACK);
    } else {
        PORTD &= (uint8_t)~_BV(LEFT_BACK);
    }
    if (wheels.right < 0) {
        PORTB |= _BV(RIGHT_BACK);
    } else {
        PORTB &= (uint8_t)~_BV(RIGHT_BACK);
    }
    /* the receive interrupt may have switched off between the decision and here */
    cli();
    if (estop_seen == 0u) {
        TCCR0A = _BV(COM0A1) | _BV(COM0B1) | _BV(WGM01) | _BV(WGM00);
        OCR0A = left;
        OCR0B = right;
    }
    SREG = interrupts;
}

bool cw_port_idle(void)
{
    wdt_reset();
    return true;
}

#endif
