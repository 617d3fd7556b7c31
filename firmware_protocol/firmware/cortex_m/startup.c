/* From reset to main on a Cortex-M3: memory, the table of vectors. */
#include <stdint.h>

extern uint32_t cw_data_source[], cw_data[], cw_data_end[], cw_bss[], cw_bss_end[], cw_stack_top[];

int main(int argc, char **argv);

void cw_reset(void);
void cw_on_failure(void);       /* faults and the watchdog's warning */
void cw_on_clock(void);         /* SysTick */
void cw_on_wire_received(void); /* the first serial port: Clearway's line */
void cw_on_wire_sent(void);
void cw_on_board_received(void); /* the second serial port: the motor board */
void cw_on_board_sent(void);

void cw_reset(void)
{
    uint32_t *from = cw_data_source;
    uint32_t *to;
    for (to = cw_data; to < cw_data_end; to++) {
        *to = *from++;
    }
    for (to = cw_bss; to < cw_bss_end; to++) {
        *to = 0u;
    }
    (void)main(0, 0);
    for (;;) { /* the watchdog bites */
    }
}

typedef void (*cw_handler)(void);

static void unused(void)
{
    cw_on_failure();
}

typedef struct {
    uint32_t *stack_top;
    cw_handler exceptions[15];
    cw_handler interrupts[16];
} cw_vectors;

__attribute__((section(".vectors"), used)) static const cw_vectors vectors = {
    cw_stack_top,
    /* reset, NMI, hard fault, memory, bus, usage, 4 reserved, SVC, debug, reserved, PendSV, SysTick */
    {cw_reset, cw_on_failure, cw_on_failure, unused, unused, unused, 0, 0, 0, 0, unused, unused, 0,
     unused, cw_on_clock},
    {cw_on_wire_received, cw_on_wire_sent, cw_on_board_received, cw_on_board_sent, unused, unused,
     unused, unused, unused, unused, unused, unused, unused, unused, unused, unused},
};
