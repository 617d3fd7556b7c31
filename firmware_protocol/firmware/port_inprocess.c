/* The firmware inside another process, in that process's time: for tests through ctypes.
 * The caller allocates cw_twin_size() bytes for each robot, so that any number may run. */
#include <stddef.h>
#include <string.h>

#include "link.h"

/* Here, and only here, robots of several kinds live side by side: CW_SETTINGS_CHANGE. */
cw_settings cw_robot_settings = CW_SETTINGS;

typedef struct {
    cw_robot robot;
    cw_link link;
    cw_settings settings;
    uint32_t wheels_um[2];
    bool stepped;
} cw_twin;

typedef struct {
    uint32_t mission;
    uint32_t accept_next;
    uint32_t exec_next;
    uint32_t prefix_crc;
    uint32_t exec_crc;
    int32_t x_um;
    int32_t y_um;
    int32_t heading;
    int16_t left;
    int16_t right;
    uint16_t session_errors;
    uint16_t session;
    uint8_t state;
    uint8_t reason;
    uint8_t credit;
    uint8_t powered;
    uint8_t done;
    uint8_t expected;
    uint8_t has_session;
    uint8_t phase;
} cw_view;

size_t cw_twin_size(void);
size_t cw_twin_robot_size(void);
void cw_twin_init(cw_twin *twin, uint32_t boot_id, uint8_t reset_cause, uint32_t schema,
                  const cw_settings *settings);
void cw_twin_receive(cw_twin *twin, const uint8_t *data, uint16_t length, uint32_t now_us);
uint8_t cw_twin_next_frame(cw_twin *twin, uint8_t *out_frame, uint32_t now_us);
void cw_twin_step(cw_twin *twin, uint32_t now_us, uint32_t left_um, uint32_t right_um);
void cw_twin_tick(cw_twin *twin, uint32_t now_us);
void cw_twin_estop(cw_twin *twin, uint8_t reason);
void cw_twin_view(const cw_twin *twin, cw_view *out_view);

size_t cw_twin_size(void)
{
    return sizeof(cw_twin);
}

size_t cw_twin_robot_size(void)
{
    return sizeof(cw_robot);
}

void cw_twin_init(cw_twin *twin, uint32_t boot_id, uint8_t reset_cause, uint32_t schema,
                  const cw_settings *settings)
{
    cw_identity identity;
    identity.schema = schema;
    identity.firmware = 0;
    identity.boot_id = boot_id;
    identity.reset_cause = reset_cause;
    memset(twin, 0xA5, sizeof *twin); /* init has to set every field */
    twin->settings = *settings;
    twin->stepped = false;
    cw_robot_settings = *settings;
    cw_robot_init(&twin->robot);
    cw_link_init(&twin->link, &twin->robot, &identity);
}

void cw_twin_receive(cw_twin *twin, const uint8_t *data, uint16_t length, uint32_t now_us)
{
    cw_robot_settings = twin->settings;
    cw_link_receive(&twin->link, data, length, now_us);
    while (cw_robot_sum(&twin->robot)) {
    }
}

uint8_t cw_twin_next_frame(cw_twin *twin, uint8_t *out_frame, uint32_t now_us)
{
    cw_robot_settings = twin->settings;
    return cw_link_next_frame(&twin->link, out_frame, now_us);
}

static int32_t travelled(uint32_t *total_um, uint32_t now_um)
{
    int32_t travel_um = cw_difference((int32_t)now_um, (int32_t)*total_um);
    *total_um = now_um;
    return travel_um > CW_LEAP_UM ? CW_LEAP_UM : travel_um < -CW_LEAP_UM ? -CW_LEAP_UM : travel_um;
}

void cw_twin_step(cw_twin *twin, uint32_t now_us, uint32_t left_um, uint32_t right_um)
{
    int32_t travel_um[2];
    cw_robot_settings = twin->settings;
    if (!twin->stepped) {
        twin->stepped = true;
        twin->wheels_um[0] = left_um;
        twin->wheels_um[1] = right_um;
    }
    travel_um[0] = travelled(&twin->wheels_um[0], left_um);
    travel_um[1] = travelled(&twin->wheels_um[1], right_um);
    cw_robot_step(&twin->robot, now_us, travel_um);
}

void cw_twin_tick(cw_twin *twin, uint32_t now_us)
{
    cw_robot_settings = twin->settings;
    cw_robot_tick(&twin->robot, now_us);
}

void cw_twin_estop(cw_twin *twin, uint8_t reason)
{
    cw_robot_emergency_stop(&twin->robot, (cw_reason)reason);
}

void cw_twin_view(const cw_twin *twin, cw_view *out_view)
{
    const cw_robot *robot = &twin->robot;
    out_view->mission = robot->mission;
    out_view->accept_next = robot->accept_next;
    out_view->exec_next = robot->exec_next;
    out_view->prefix_crc = robot->prefix_crc;
    out_view->exec_crc = robot->exec_crc;
    out_view->x_um = robot->estimate.pose[0];
    out_view->y_um = robot->estimate.pose[1];
    out_view->heading = robot->estimate.pose[2];
    out_view->left = robot->wheels.left;
    out_view->right = robot->wheels.right;
    out_view->session_errors = twin->link.count.session_errors;
    out_view->session = twin->link.session;
    out_view->state = robot->state;
    out_view->reason = robot->reason;
    out_view->credit = cw_robot_credit(robot);
    out_view->powered = robot->wheels.powered;
    out_view->done = robot->done;
    out_view->expected = twin->link.open.expected;
    out_view->has_session = twin->link.session != 0u;
    out_view->phase = robot->follower.phase;
}
