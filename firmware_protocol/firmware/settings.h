/* What the robot is and can do. These are the reference robot's values. For another one either
 * - write a header from its configuration and name it when building:
 *       python -m navigation.loop.firmware_settings CONFIG -o my_robot.h
 *       make avr SETTINGS=/path/to/my_robot.h
 * - or define cw_robot_settings in the program, as the Arduino example does. */
#ifndef CLEARWAY_SETTINGS_H
#define CLEARWAY_SETTINGS_H

#include <stdint.h>

#ifdef CW_SETTINGS_FILE
#include CW_SETTINGS_FILE
#endif

/* Every value > 0, but the least speed, which is 0 for wheels that turn however slowly. At most: the track 1 m, speed and turning as far as they give the wheels 2 m/s
 * each, turn acceleration 15 rad/s2, accelerations 8 m/s2, looking ahead 1 m and 0.5 s, deviation
 * 2 m, the least speed 200 mm/s. */
typedef struct {
    uint32_t track_um; /* between the wheels */
    uint16_t max_speed_mm_s;
    uint16_t acceleration_mm_s2;
    uint16_t lateral_mm_s2; /* sideways acceleration in bends */
    uint16_t max_turn_mrad_s;
    uint16_t turn_acceleration_mrad_s2;
    uint16_t lookahead_mm;
    uint16_t lookahead_ms;
    uint16_t max_deviation_mm;
    uint16_t least_wheel_mm_s; /* the slowest that a wheel at rest is sure to turn */
} cw_settings;

#ifndef CW_SETTINGS
#define CW_SETTINGS {120000ul, 500u, 500u, 600u, 2500u, 8000u, 40u, 150u, 150u, 10u}
#endif

/* For a board's port: the line, the encoders, and the wheels' speed at full power. */
#ifndef CW_BAUD
#define CW_BAUD 115200ul
#endif
#ifndef CW_UM_PER_STEP
#define CW_UM_PER_STEP 250l
#endif
#ifndef CW_FULL_SPEED_MM_S
#define CW_FULL_SPEED_MM_S 800ul
#endif

/* From the time that a TIMESYNC_REPLY tells to its first byte on the line: building and checking
 * it takes an ATmega328P at 16 MHz so long, by its instructions; faster processors no time. */
#ifndef CW_ANSWER_US
#ifdef __AVR__
#define CW_ANSWER_US 240u
#else
#define CW_ANSWER_US 0u
#endif
#endif

#ifdef CW_SETTINGS_CHANGE
extern cw_settings cw_robot_settings; /* tests run robots of several kinds in one process */
#else
extern const cw_settings cw_robot_settings;
#endif

/* Binary angle that the robot turns by for a micrometre that its wheels differ by, and what
 * 256 times mrad/s it turns at for an eighth of mm/s of spin. */
#define CW_ANGLE_PER_UM                                                                          \
    ((683565276ul + cw_robot_settings.track_um / 2u) / cw_robot_settings.track_um)
#define CW_LEAST_WHEEL ((int16_t)(cw_robot_settings.least_wheel_mm_s * 8u))
#define CW_TURNING_PER_SPIN ((int16_t)(64000000ul / cw_robot_settings.track_um))

#endif
