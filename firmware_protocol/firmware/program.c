#include "program.h"

#include "port.h"

#define CONTROL_US 10000ul

static cw_robot robot;
static cw_link line;
static uint8_t frame[CW_MAX_WIRE];
static uint32_t stepped_us;

static void exchange(uint32_t now_us)
{
    uint8_t data[32];
    uint8_t length;
    while ((length = cw_port_read(data, sizeof data)) > 0u) {
        cw_link_receive(&line, data, length, now_us);
    }
    line.count.overruns = (uint16_t)(line.count.overruns + cw_port_overruns());
    if (cw_port_estop_seen()) {
        cw_robot_emergency_stop(&robot, CW_REASON_ESTOP_HOST);
    }
    if (cw_port_can_write()) {
        length = cw_link_next_frame(&line, frame, now_us);
        if (length > 0u) {
            cw_port_write(frame, length);
        }
    }
}

void cw_program_begin(void)
{
    cw_identity identity;
    cw_port_identity(&identity);
    cw_robot_init(&robot);
    cw_link_init(&line, &robot, &identity);
    stepped_us = cw_port_now_us();
}

void cw_program_round(void)
{
    uint32_t now_us = cw_port_now_us();
    exchange(now_us);
    cw_robot_tick(&robot, now_us);
    if (now_us - stepped_us >= CONTROL_US) {
        uint32_t left_um, right_um;
        stepped_us += CONTROL_US;
        cw_port_travel(&left_um, &right_um);
        cw_robot_step(&robot, now_us, left_um, right_um);
    }
    cw_port_drive(robot.wheels);
}
