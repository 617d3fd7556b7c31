/* Where the robot is, and how it follows its waypoints. The twin of pose_estimate.py and
 * follower.py, whose texts say why; the numbers are the same. Metres, radians, seconds. */
#ifndef CLEARWAY_FOLLOWER_H
#define CLEARWAY_FOLLOWER_H

#include <stdbool.h>
#include <stdint.h>

#define CW_HISTORY 8u

typedef struct {
    float x_m;
    float y_m;
    float heading_rad;
} cw_pose;

typedef struct {
    uint32_t time_us;
    cw_pose pose;
} cw_past;

typedef struct {
    cw_pose pose;
    uint8_t oldest;
    uint8_t kept;
    uint8_t jumps;
    bool known;      /* a fix was used since boot */
    bool fix_recent; /* the last fix is younger than 65 s: fix_us means something */
    uint32_t fix_us; /* when the camera saw what was used last */
    float drift_rad_per_m;
    float travel_m;
    cw_past history[CW_HISTORY]; /* a ring, the oldest at `oldest` */
} cw_estimate;

/* What the robot is and can do; every value > 0. */
typedef struct {
    float track_m;
    float max_speed_m_s;
    float acceleration_m_s2;
    float lateral_m_s2;
    float max_turn_rad_s;
    float turn_acceleration_rad_s2;
    float lookahead_m;
    float lookahead_s;
    float max_deviation_m;
} cw_drive_settings;

/* The settings that the Python twin has as defaults. */
extern const cw_drive_settings cw_default_settings;

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
    const cw_drive_settings *settings;
    uint8_t phase; /* cw_phase */
    uint8_t attempts;
    bool first;
    bool docking;
    float speed_m_s; /* commanded */
    float turn_rad_s;
    float from_x_m;
    float from_y_m;
    float from_speed_m_s;
    float still_s;
    float progress_s;
    cw_pose progress_pose;
} cw_follower;

/* The queue as the follower sees it: `get` gives record `index` counted from the head. */
typedef struct {
    const void *queue;
    uint8_t count;
    const uint8_t *(*get)(const void *queue, uint8_t index);
} cw_targets;

/* The same angle in [-pi, pi]. */
float cw_wrap_angle(float angle_rad);

void cw_estimate_init(cw_estimate *estimate);
void cw_estimate_advance(cw_estimate *estimate, float track_m, uint32_t now_us, float left_m,
                         float right_m);
/* False where the fix was not used: too old, or one that jumps. */
bool cw_estimate_correct(cw_estimate *estimate, cw_pose seen, uint32_t age_us, uint32_t now_us);

void cw_follower_init(cw_follower *follower, const cw_drive_settings *settings);
void cw_follower_begin(cw_follower *follower, cw_pose pose);
void cw_follower_freeze(cw_follower *follower);
/* One cycle of a stop under control; returns how many waypoints were executed. */
uint8_t cw_follower_halt(cw_follower *follower, float dt_s, cw_pose pose, cw_targets targets);
/* One cycle of driving; returns how many waypoints were executed. */
uint8_t cw_follower_step(cw_follower *follower, float dt_s, cw_pose pose, float measured_m_s,
                         cw_targets targets, cw_trouble *out_trouble);

#endif
