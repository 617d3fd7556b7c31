/* Where the robot is: wheel travel, corrected by camera poses that are already old. The twin of
 * estimate.py, whose text says why. Micrometres, binary angles (fixed.h), microseconds. */
#ifndef CLEARWAY_ESTIMATE_H
#define CLEARWAY_ESTIMATE_H

#include <stdbool.h>
#include <stdint.h>

#include "fixed.h"

#define CW_HISTORY 9u

/* How far the wheels had moved the robot, modulo 2^16: x and y in 256 um, the angle, and when that
 * was, in 256 us. */
typedef struct {
    uint16_t moved[3];
    uint16_t time;
} cw_past;

typedef struct {
    int32_t pose[3]; /* x and y in micrometres; the heading, 2^32 a turn */
    int32_t moved[3]; /* the same without any correction */
    int32_t drift;    /* binary angle per micrometre, times 1024 */
    int32_t travel_um;
    uint32_t fix_us; /* when the camera saw what was used last */
    bool fix_recent; /* the last fix is younger than 65 s: fix_us means something */
    bool known;      /* a fix was used since boot */
    uint8_t jumps;
    cw_past history[CW_HISTORY]; /* the newest first, which is the last step's */
} cw_estimate;

/* The robot drove `travel_um` and turned by `turn` since the last call, which ends now: in 256 us,
 * modulo 2^16. */
void cw_estimate_advance(cw_estimate *estimate, int32_t travel_um, int32_t turn, uint16_t now);

/* False where the fix was not used: too old, or one that jumps. */
bool cw_estimate_correct(cw_estimate *estimate, const int32_t seen[3], uint32_t seen_us);

#endif
