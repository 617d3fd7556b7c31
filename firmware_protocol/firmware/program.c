#include "program.h"

#include "flash.h"
#include "port.h"

#define CONTROL_US 10000ul

static cw_robot the_robot;
static cw_link the_line;
static uint8_t frame[CW_MAX_WIRE];
static uint32_t stepped_us;

static cw_robot *our_robot(void)
{
    cw_robot *robot = &the_robot;
    CW_FORGET(robot);
    return robot;
}

static cw_link *our_line(void)
{
    cw_link *line = &the_line;
    CW_FORGET(line);
    return line;
}

static void exchange(uint32_t now_us)
{
    cw_link *line = our_line();
    uint8_t data[32];
    uint8_t length;
    while ((length = cw_port_read(data, sizeof data)) > 0u) {
        cw_link_receive(line, data, length, now_us);
    }
    line->count.overruns = (uint16_t)(line->count.overruns + cw_port_overruns());
    if (cw_port_estop_seen()) {
        cw_robot_emergency_stop(our_robot(), CW_REASON_ESTOP_HOST);
    }
    if (cw_port_can_write()) {
        length = cw_link_next_frame(line, frame, now_us);
        if (length > 0u) {
            cw_port_write(frame, length);
        }
    }
}

void cw_program_begin(void)
{
    cw_identity identity;
    cw_port_identity(&identity);
    cw_robot_init(our_robot());
    cw_link_init(our_line(), our_robot(), &identity);
    stepped_us = cw_port_now_us();
}

void cw_program_round(void)
{
    uint32_t now_us = cw_port_now_us();
    cw_robot *robot = our_robot();
    exchange(now_us);
    cw_robot_tick(robot, now_us);
    if (robot->hurry || now_us - stepped_us >= CONTROL_US) {
        int32_t travel_um[2];
        if (now_us - stepped_us >= CONTROL_US) {
            stepped_us += CONTROL_US;
        }
        cw_port_travel(travel_um);
        cw_robot_step(robot, now_us, travel_um);
    } else {
        (void)cw_robot_sum(robot);
    }
    cw_port_drive(robot->wheels);
}
