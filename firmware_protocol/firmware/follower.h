/* How the robot follows its waypoints. The twin of follower.py, whose text says why; numbers and
 * arithmetic are the same. Micrometres, binary angles and speeds in mm/s times 1024 (fixed.h).
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

typedef struct {
    uint8_t phase; /* cw_phase */
    uint8_t attempts;
    bool first;
    bool docking;
    int32_t speed_q10; /* commanded */
    int32_t spin_q10;
    int32_t bend; /* spin over speed, times 16384: as steered last */
    cw_place from;
    uint16_t from_speed_mm_s;
    uint32_t still_us;
    uint32_t progress_us;
    cw_pose progress;
} cw_follower;

void cw_follower_init(cw_follower *follower);
void cw_follower_begin(cw_follower *follower, const cw_pose *pose);
void cw_follower_freeze(cw_follower *follower);

/* One cycle of a stop under control; returns how many waypoints were executed. */
uint8_t cw_follower_halt(cw_follower *follower, uint16_t dt_us, const cw_pose *pose,
                         cw_queue *queue);

/* One cycle of driving; returns how many waypoints were executed. `still`: the wheels stand. */
uint8_t cw_follower_step(cw_follower *follower, uint16_t dt_us, const cw_pose *pose, bool still,
                         cw_queue *queue, cw_trouble *out_trouble);

#endif
