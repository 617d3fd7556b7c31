/* How the robot follows its waypoints. The twin of follower.py, whose text says why; numbers and
 * arithmetic are the same. Poses as in estimate.h; lengths are counts of 64 um and end at 2 m,
 * which is further than any brake or look ahead; speeds are eighths of mm/s.
 *
 * Turning is told as half the difference of the wheels' speeds, "spin": positive turns left.
 */
#ifndef CLEARWAY_FOLLOWER_H
#define CLEARWAY_FOLLOWER_H

#include <stdbool.h>
#include <stdint.h>

#include "estimate.h"
#include "queue.h"
#include "settings.h"

typedef enum {
    CW_PHASE_TRACK,
    CW_PHASE_TURN,
    CW_PHASE_SETTLE,
    CW_PHASE_DOCK,
    CW_PHASE_ALIGN,
    CW_PHASE_DWELL
} cw_phase;

typedef enum { CW_TROUBLE_NONE, CW_TROUBLE_OFF_PATH, CW_TROUBLE_STUCK } cw_trouble;

/* The line from one waypoint to the next. */
typedef struct {
    uint16_t length;
    uint16_t direction;
} cw_leg;

typedef struct {
    int16_t speed; /* commanded */
    int16_t spin;
    int16_t bend; /* spin over speed, times 16384: as steered last */
    uint16_t dt_us; /* of this cycle */
    uint8_t phase; /* cw_phase */
    uint8_t attempts;
    bool first;
    bool docking;
    /* the way to the waypoint at the queue's head, and where the robot is on it */
    cw_leg leg;
    int16_t distance;  /* of the robot from the waypoint */
    int16_t remaining; /* along the leg; negative behind the waypoint */
    int16_t beside;    /* beside the leg, or behind its beginning */
    int32_t from[2];
    uint16_t from_speed_mm_s;
    int16_t stood_um; /* travelled while standing */
    uint32_t still_us;
    uint32_t progress_us;
    uint16_t progress[3]; /* x and y in 256 um, the angle */
} cw_follower;

#define CW_CLEARLY 2000l

void cw_follower_init(cw_follower *follower);
void cw_follower_begin(cw_follower *follower, const int32_t *pose);

/* One cycle of a stop under control; returns how many waypoints were executed. */
uint8_t cw_follower_halt(cw_follower *follower, const int32_t *pose, cw_queue *queue);

/* One cycle of driving; returns how many waypoints were executed. The wheels have travelled
 * `ahead_um` in it; CW_CLEARLY where they clearly turn. */
uint8_t cw_follower_step(cw_follower *follower, const int32_t *pose, int32_t ahead_um,
                         cw_queue *queue, cw_trouble *out_trouble);

#endif
