/* ATmega328P at 16 MHz: UART0, Timer1 as the clock, H bridge on Timer0, encoders on
 * the pin-change interrupt. An example to adapt.
 *
 * At 16 MHz 115200 is 2.1 % off, and 250000 is exact. The pins stand below, in one place. Only for
 * this processor: on another one the file is empty, and the board brings a port of its own.
 */
#ifdef __AVR_ATmega328P__

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

#include "port.h"

/* At double speed: the clock over 8 times the rate, to the nearest. */
#define BAUD_DIVIDER ((F_CPU + CW_BAUD * 4u) / (CW_BAUD * 8u) - 1u)
#define BAUD_MADE (F_CPU / (8u * (BAUD_DIVIDER + 1u)))
#if BAUD_MADE * 1000ul > CW_BAUD * 1025ul || BAUD_MADE * 1000ul < CW_BAUD * 975ul
#error "the processor's clock cannot make this baud rate to 2.5 %"
#endif
#define RING 128u /* a power of two */

/* Left motor: PWM on D6 (OC0A), direction on D7. Right: PWM on D5 (OC0B), direction on D8.
 * Encoders: left A, B on C0, C1; right A, B on C2, C3. */
#define LEFT_BACK PD7
#define RIGHT_BACK PB0

static volatile uint8_t ring[RING];
static volatile uint8_t ring_in;
static uint8_t ring_out;
static volatile uint8_t lost;
static volatile uint8_t estop_seen;
static uint8_t estop_matched;
static const uint8_t *volatile sending;
static volatile uint8_t left_to_send;
static volatile uint32_t overflows; /* of Timer1: 32.768 ms each */
static volatile int32_t ticks[2];
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

/* One step from the old and the new A (bit 0) and B (bit 1) of a wheel; forwards A leads. */
static int8_t quadrature(uint8_t old, uint8_t now)
{
    uint8_t changed = (uint8_t)(old ^ now);
    if (changed == 0u || changed == 3u) {
        return 0; /* nothing, or a step was missed */
    }
    return ((old & 1u) ^ (now >> 1)) != 0u ? -1 : 1;
}

ISR(PCINT1_vect)
{
    uint8_t pins = PINC;
    ticks[0] += quadrature(pins_before & 3u, pins & 3u);
    ticks[1] += quadrature((pins_before >> 2) & 3u, (pins >> 2) & 3u);
    pins_before = pins;
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
    pins_before = PINC;
    PCICR = _BV(PCIE1);
    PCMSK1 = 0x0Fu;
    TCCR1B = _BV(CS11); /* 2 ticks a microsecond */
    TIMSK1 = _BV(TOIE1);
    UBRR0 = BAUD_DIVIDER;
    UCSR0A = _BV(U2X0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
    wdt_enable(WDTO_250MS);
    sei();
    return true;
}

void cw_port_identity(cw_identity *out_identity)
{
    /* memory that survives a reset counts boots; after power on its garbage is the seed */
    boots = boots * 1664525ul + 1013904223ul + TCNT1;
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

void cw_port_travel(uint32_t *out_left_um, uint32_t *out_right_um)
{
    uint8_t interrupts = SREG;
    int32_t left, right;
    cli();
    left = ticks[0];
    right = ticks[1];
    SREG = interrupts;
    *out_left_um = (uint32_t)(left * CW_UM_PER_STEP);
    *out_right_um = (uint32_t)(right * CW_UM_PER_STEP);
}

/* What a step of the PWM (3.1 mm/s) is too coarse for is carried on to the next round, so that
 * slow wheels turn at all: without it the robot cannot end a turn at a stop. */
static uint8_t duty(int32_t speed_q10, uint8_t *carry)
{
    uint32_t part = cw_size(speed_q10) * 255u / (CW_FULL_SPEED_MM_S * 4u);
    uint16_t fine = (uint16_t)((part > 0xFF00u ? 0xFF00u : (uint16_t)part) + *carry);
    *carry = (uint8_t)(fine & 0xFFu);
    return (uint8_t)(fine >> 8);
}

void cw_port_drive(cw_wheels wheels)
{
    uint8_t interrupts = SREG;
    static uint8_t carry[2];
    uint8_t left = duty(wheels.left_q10, &carry[0]);
    uint8_t right = duty(wheels.right_q10, &carry[1]);
    if (!wheels.powered) {
        motors_off();
        return;
    }
    if (wheels.left_q10 < 0) {
        PORTD |= _BV(LEFT_BACK);
    } else {
        PORTD &= (uint8_t)~_BV(LEFT_BACK);
    }
    if (wheels.right_q10 < 0) {
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
