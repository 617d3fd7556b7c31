/* Where the robot is: wheel travel, corrected by camera poses that are already old. The twin of
 * pose_estimate.py, whose text says why. Micrometres, binary angles (fixed.h), microseconds. */
#ifndef CLEARWAY_ESTIMATE_H
#define CLEARWAY_ESTIMATE_H

#include <stdbool.h>
#include <stdint.h>

#include "fixed.h"

#define CW_HISTORY 8u

typedef struct {
    cw_place place;
    int32_t heading;
} cw_pose;

typedef struct {
    cw_pose pose;
    uint32_t time_us;
} cw_past;

typedef struct {
    cw_pose pose;
    uint8_t kept;
    uint8_t jumps;
    bool known;      /* a fix was used since boot */
    bool fix_recent; /* the last fix is younger than 65 s: fix_us means something */
    uint32_t fix_us; /* when the camera saw what was used last */
    int32_t drift;   /* binary angle per micrometre, times 1024 */
    int32_t travel_um;
    cw_past history[CW_HISTORY]; /* the newest first */
} cw_estimate;

void cw_estimate_init(cw_estimate *estimate);

/* The robot drove `travel_um` and turned by `turn` since the last call, which ends now. */
void cw_estimate_advance(cw_estimate *estimate, int32_t travel_um, int32_t turn, uint32_t now_us);

/* False where the fix was not used: too old, or one that jumps. */
bool cw_estimate_correct(cw_estimate *estimate, const cw_pose *seen, uint32_t age_us,
                         uint32_t now_us);

#endif
