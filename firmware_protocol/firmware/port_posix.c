/* The firmware as a Linux process: its serial port is a new pseudo-terminal, whose path it
 * prints, or the one named on the command line; its motors are a simple model.
 *
 *     robot [PATH]
 *
 * Ends with SIGINT or SIGTERM. Needs _XOPEN_SOURCE 600. */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "port.h"

#define BYTE_US 87u /* ten bits at 115200 */
#define MOTOR_LAG_S 0.05f
#define EIGHTHS_PER_M 8000.0f

static int line = -1;
static int keep_open = -1; /* the other end, so that the line outlives its user */
static uint32_t written_us;
static uint32_t writing_us; /* how long what was written takes, from written_us on */
static cw_wheels wanted;
static float speed[2];
static double travel_um[2];
static uint32_t moved_us;
static volatile sig_atomic_t stopped;

static void stop(int signal_number)
{
    (void)signal_number;
    stopped = 1;
}

static bool make_raw(int fd)
{
    struct termios mode;
    if (tcgetattr(fd, &mode) != 0) {
        return false;
    }
    mode.c_iflag = 0;
    mode.c_oflag = 0;
    mode.c_lflag = 0;
    mode.c_cflag = CS8 | CREAD | CLOCAL;
    mode.c_cc[VMIN] = 0;
    mode.c_cc[VTIME] = 0;
    return cfsetispeed(&mode, B115200) == 0 && cfsetospeed(&mode, B115200) == 0 &&
           tcsetattr(fd, TCSANOW, &mode) == 0;
}

static bool open_pair(void)
{
    const char *name;
    line = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (line < 0 || grantpt(line) != 0 || unlockpt(line) != 0) {
        return false;
    }
    name = ptsname(line);
    if (name == NULL) {
        return false;
    }
    keep_open = open(name, O_RDWR | O_NOCTTY);
    if (keep_open < 0 || !make_raw(keep_open)) {
        return false;
    }
    (void)printf("%s\n", name);
    (void)fflush(stdout);
    return true;
}

bool cw_port_begin(int argc, char **argv)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = stop;
    if (sigaction(SIGINT, &action, NULL) != 0 || sigaction(SIGTERM, &action, NULL) != 0) {
        return false;
    }
    if (argc > 1) {
        line = open(argv[1], O_RDWR | O_NOCTTY | O_NONBLOCK);
        if (line < 0 || !make_raw(line)) {
            (void)fprintf(stderr, "robot: %s: %s\n", argv[1], strerror(errno));
            return false;
        }
    } else if (!open_pair()) {
        (void)fprintf(stderr, "robot: no pseudo-terminal: %s\n", strerror(errno));
        return false;
    }
    moved_us = cw_port_now_us();
    return true;
}

void cw_port_identity(cw_identity *out_identity)
{
    struct timespec now = {0, 0};
    (void)clock_gettime(CLOCK_REALTIME, &now);
    out_identity->schema = CW_SCHEMA_HASH;
    out_identity->firmware = 1;
    out_identity->boot_id =
        (uint32_t)now.tv_sec ^ (uint32_t)now.tv_nsec ^ ((uint32_t)getpid() << 16);
    out_identity->reset_cause = 1;
}

uint32_t cw_port_now_us(void)
{
    struct timespec now = {0, 0};
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint32_t)((uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u);
}

uint8_t cw_port_read(uint8_t *out_data, uint8_t room)
{
    ssize_t got = read(line, out_data, room);
    return got > 0 ? (uint8_t)got : 0u;
}

uint16_t cw_port_overruns(void)
{
    return 0;
}

bool cw_port_can_write(void)
{
    if (cw_port_now_us() - written_us >= writing_us) {
        writing_us = 0;
    }
    return writing_us == 0u;
}

void cw_port_write(const uint8_t *data, uint8_t length)
{
    /* where nobody reads, the bytes are lost, as on a cable */
    ssize_t written = write(line, data, length);
    (void)written;
    written_us = cw_port_now_us();
    writing_us = BYTE_US * length;
}

bool cw_port_estop_seen(void)
{
    return false; /* the main loop sees the frame soon enough here */
}

void cw_port_travel(int32_t out_travel_um[2])
{
    uint32_t now_us = cw_port_now_us();
    float dt_s = (float)(now_us - moved_us) * 1e-6f;
    float blend = dt_s / (MOTOR_LAG_S + dt_s);
    int side;
    moved_us = now_us;
    speed[0] += blend * ((wanted.powered ? (float)wanted.left / EIGHTHS_PER_M : 0.0f) - speed[0]);
    speed[1] += blend * ((wanted.powered ? (float)wanted.right / EIGHTHS_PER_M : 0.0f) - speed[1]);
    for (side = 0; side < 2; side++) {
        travel_um[side] += (double)(speed[side] * dt_s) * 1e6;
        out_travel_um[side] = (int32_t)travel_um[side];
        travel_um[side] -= out_travel_um[side];
    }
}

void cw_port_drive(cw_wheels wheels)
{
    wanted = wheels;
}

bool cw_port_idle(void)
{
    struct pollfd watched;
    watched.fd = line;
    watched.events = POLLIN;
    watched.revents = 0;
    if (poll(&watched, 1, 1) > 0 && (watched.revents & POLLIN) == 0) {
        (void)poll(NULL, 0, 1); /* hung up: do not spin until somebody opens it again */
    }
    return stopped == 0;
}
