/* The real AVR binary on an emulated ATmega328P, stepped by another program. Test only: it is
 * linked with simavr (GPL-3), and no part of the product.
 *
 *     avr_bridge FIRMWARE.elf [MAIN ADDRESS VALUE]
 *
 * With the three numbers, the u32 VALUE stands at the data address ADDRESS when the processor
 * first reaches the code address MAIN: so a test lets the clock begin just before it wraps.
 *
 * Lockstep on stdin and stdout, integers little-endian. Request: u32 microseconds to run, i16
 * and i16 encoder steps (left, right) to make meanwhile, u8 flags (bit 0: reset first), u16
 * count, count bytes for the UART. Answer: u8 PWM left, u8 PWM right, u8 bit 0 powered, bit 1
 * left backwards, bit 2 right backwards; u32 cycle of the last power-off, u32 cycle now;
 * u16 count, count bytes from the UART.
 * Where the environment names a file as AVR_ROUNDS, a request for no time writes there how long the
 * main loop's rounds took, from one watchdog reset to the next: microseconds / 100, and how many.
 * The UART runs at its true rate in both directions: simavr counts a parity bit that is not
 * there, so the cycles of a byte are set from here.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#define CYCLES_US 16u
#define OCR0A_AT 0x47
#define OCR0B_AT 0x48
#define TCCR0A_AT 0x44
#define WDR 0x95A8 /* the watchdog's reset instruction */

static avr_t *avr;
static avr_uart_t *uart;
static uint8_t out[65536];
static uint16_t out_count;
static uint8_t in[65536];
static uint16_t in_count, in_at;
static avr_cycle_count_t next_in, off_at;
static uint8_t phase[2];
static avr_irq_t *uart_in;
static bool was_powered;
static avr_cycle_count_t round_at;
static uint32_t rounds[1000];

static void sent(struct avr_irq_t *irq, uint32_t value, void *param)
{
    (void)irq;
    (void)param;
    if (out_count < sizeof out) {
        out[out_count++] = (uint8_t)value;
    }
}

static uint32_t byte_cycles(void)
{
    uint32_t divider = (uint32_t)(avr->data[0xC4] | (avr->data[0xC5] & 0x0F) << 8) + 1u;
    uint32_t bit = (avr->data[0xC0] & 2u) != 0u ? 8u : 16u;
    return divider * bit * 10u;
}

static void encoder_step(int wheel, int direction)
{
    static const uint8_t code[4] = {0, 1, 3, 2};
    phase[wheel] = (uint8_t)((phase[wheel] + (direction > 0 ? 1 : 3)) & 3);
    for (int bit = 0; bit < 2; bit++) {
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('C'), 2 * wheel + bit),
                      (uint32_t)(code[phase[wheel]] >> bit) & 1u);
    }
}

static bool powered(void)
{
    return (avr->data[TCCR0A_AT] & 0xA0) != 0;
}

static void count_round(void)
{
    if ((avr->flash[avr->pc] | avr->flash[avr->pc + 1u] << 8) == WDR) {
        avr_cycle_count_t bin = (avr->cycle - round_at) / (100u * CYCLES_US);
        rounds[bin < 999u ? bin : 999u]++;
        round_at = avr->cycle;
    }
}

static void run(uint32_t us, int16_t left, int16_t right)
{
    avr_cycle_count_t begin = avr->cycle, end = begin + (avr_cycle_count_t)us * CYCLES_US;
    int steps[2] = {abs(left), abs(right)}, done[2] = {0, 0};
    int way[2] = {left, right};
    while (avr->cycle < end) {
        uart->cycles_per_byte = byte_cycles();
        if (in_at < in_count && avr->cycle >= next_in) {
            avr_raise_irq(uart_in, in[in_at++]);
            next_in = (next_in > avr->cycle - 100 ? next_in : avr->cycle) + byte_cycles();
        }
        for (int wheel = 0; wheel < 2; wheel++) {
            avr_cycle_count_t due =
                begin + (end - begin) * (avr_cycle_count_t)(done[wheel] + 1) /
                            (avr_cycle_count_t)(steps[wheel] + 1);
            if (done[wheel] < steps[wheel] && avr->cycle >= due) {
                encoder_step(wheel, way[wheel]);
                done[wheel]++;
            }
        }
        count_round();
        int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "avr_bridge: the processor stopped\n");
            exit(1);
        }
        if (was_powered && !powered()) {
            off_at = avr->cycle;
        }
        was_powered = powered();
    }
}

static void begin_with(char **numbers)
{
    avr_flashaddr_t begin = (avr_flashaddr_t)strtoul(numbers[0], NULL, 0);
    uint32_t address = (uint32_t)strtoul(numbers[1], NULL, 0);
    uint32_t value = (uint32_t)strtoul(numbers[2], NULL, 0);
    while (avr->pc != begin) {
        avr_run(avr);
    }
    for (uint32_t byte = 0; byte < 4; byte++) {
        avr->data[address + byte] = (uint8_t)(value >> (8 * byte));
    }
}

static void tell_rounds(void)
{
    const char *name = getenv("AVR_ROUNDS");
    FILE *file = name == NULL ? NULL : fopen(name, "w");
    for (unsigned bin = 0; file != NULL && bin < 1000u; bin++) {
        if (rounds[bin] > 0u) {
            fprintf(file, "%u %u\n", bin, rounds[bin]);
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

static void get(void *to, size_t size)
{
    if (fread(to, 1, size, stdin) != size) {
        exit(0);
    }
}

int main(int argc, char **argv)
{
    /* simavr talks on stdout: keep that for the answers, and send its words to stderr */
    FILE *answers = fdopen(dup(STDOUT_FILENO), "wb");
    if (answers == NULL || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) {
        return 2;
    }
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    if ((argc != 2 && argc != 5) || elf_read_firmware(argv[1], &firmware) != 0) {
        fprintf(stderr, "avr_bridge: cannot read the firmware\n");
        return 2;
    }
    avr = avr_make_mcu_by_name("atmega328p");
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr->frequency = 16000000;
    avr_load_firmware(avr, &firmware);
    avr->frequency = 16000000;
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), sent, NULL);
    uart_in = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    for (avr_io_t *io = avr->io_port; io != NULL; io = io->next) {
        if (strcmp(io->kind, "uart") == 0 && ((avr_uart_t *)io)->name == '0') {
            uart = (avr_uart_t *)io;
        }
    }
    if (argc == 5) {
        begin_with(argv + 2);
    }
    for (;;) {
        struct __attribute__((packed)) {
            uint32_t us;
            int16_t left, right;
            uint8_t flags;
            uint16_t count;
        } request;
        get(&request, sizeof request);
        if (in_at == in_count) {
            in_at = in_count = 0;
        }
        get(in + in_count, request.count);
        in_count = (uint16_t)(in_count + request.count);
        if ((request.flags & 1u) != 0u) {
            avr_reset(avr);
        }
        out_count = 0;
        if (request.us == 0u) {
            tell_rounds();
        }
        run(request.us, request.left, request.right);
        uint8_t state = (uint8_t)(powered() | (avr->data[0x2B] >> 7 & 1) << 1 |
                                  (avr->data[0x25] & 1) << 2);
        uint32_t off = (uint32_t)off_at, now = (uint32_t)avr->cycle;
        uint8_t pwm[3] = {avr->data[OCR0A_AT], avr->data[OCR0B_AT], state};
        fwrite(pwm, 1, 3, answers);
        fwrite(&off, 4, 1, answers);
        fwrite(&now, 4, 1, answers);
        fwrite(&out_count, 2, 1, answers);
        fwrite(out, 1, out_count, answers);
        fflush(answers);
    }
}
