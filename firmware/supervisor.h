// SPDX-License-Identifier: Apache-2.0
/* The device's supervisor: it alone decides what duty reaches the pins. It trusts neither the host nor the sensors.
 *
 * Plain C without hardware, so that the host's tests run the very code that the board runs. Time comes in as the device's
 * clock in microseconds, which wraps; nothing here is compared but by difference.
 *
 * A trip takes the duty away at once and stays until it is cleared by name with cool coils. It is for the caller to
 * store trip_cause where a reset does not reach it. */
#pragma once

#include <stdint.h>

#include "firmware/board.h"
#include "hil/limits.h"
#include "hil/message.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SUPERVISOR_READINGS 11u /* of which the line is taken: odd */

/* Duty times time is summed in ten-thousandths of 8 us, so that a millisecond costs a product and no division. */
#define ON_STEP_us 8u
#define SUPERVISOR_BOUND_STEP_ms 10u
#define BOUND_STEP_us 4u /* that of the board's clock, so that no duty is lost in rounding */
#define ON_us(sum) ((sum) / (DUTY_ONE / ON_STEP_us))

struct thermocouple {
  uint32_t raw;
  int32_t temperature_cdegC;
  int32_t junction_cdegC;
  uint8_t fault;                           /* a trip_cause; TRIP_SENSOR_SILENT before the first reading */
  uint8_t readings;                        /* how many of `last_cdegC` are there */
  int32_t last_cdegC[SUPERVISOR_READINGS]; /* newest first */
  uint32_t on;                             /* duty times time since the last reading, in ON_us */
  int32_t should_have_moved_mK;            /* since the reading changed last, at the least */
  int32_t warmed_mK, expected_mK;          /* both through the same high pass */
  uint8_t not_following, unexpected;       /* readings, one after the other, that say so */
  int32_t lagged_mK;                       /* what is expected of a thermocouple with the longest lag */
};

struct angle {
  uint8_t fault; /* a trip_cause */
  uint8_t begun;
  uint16_t raw;                                                   /* where it was when it moved last */
  int32_t coldest_cdegC[BOARD_COILS], hottest_cdegC[BOARD_COILS]; /* since then */
};

struct drain {
  uint8_t low;         /* samples in a row */
  uint8_t idle;        /* samples since there was duty */
  uint8_t low_unasked; /* grows by each low one without duty, and falls by each high one */
  uint8_t high;        /* samples above the limit of the supply */
};

struct supervisor {
  uint8_t state, trip_cause;
  uint8_t wrong_settings; /* bits of board_setting, as the board found them when it started: while there is one, no arming */
  uint16_t duty[BOARD_COILS];
  uint32_t valid_until_us; /* of the duty */
  uint32_t last_tick_us, last_reading_us;
  struct thermocouple thermocouple[BOARD_COILS];       /* on each coil */
  uint16_t on_ms[BOARD_COILS][LIMIT_ON_TIME_WINDOW_s]; /* duty times time, a bucket a second */
  uint32_t bucket_us;                                  /* when the current one began */
  uint32_t bucket_on[BOARD_COILS];
  uint8_t bucket;
  struct angle angle[BOARD_ANGLES];
  uint8_t angle_faults_trip; /* as the arming asked */
  struct drain drain[BOARD_COILS];
  uint16_t drains_settle_ms;                /* this much longer nothing is said of them */
  uint32_t bound_uK[BOARD_COILS];           /* heat_bound.h: each coil's rise at the most, whatever its thermocouple says */
  uint32_t bound_on[BOARD_COILS], bound_us; /* duty times time since it was brought up to date, and when that was */
};

/* `latched`: the cause that was stored; TRIP_NONE: none. The bounds of the coils' heat begin at LIMIT_BOUND_START; a caller that kept
 * those of before a reset puts them into bound_uK, and what the board found wrong with itself goes into wrong_settings. */
void supervisor_start(struct supervisor* s, uint8_t latched, uint32_t now_us);

/* A session begins or ends: zero duty, disarmed. A trip stays. */
void supervisor_disarm(struct supervisor* s);
enum answer supervisor_arm(struct supervisor* s, uint32_t now_us);
enum answer supervisor_clear_trip(struct supervisor* s, uint8_t cause);
void supervisor_trip(struct supervisor* s, uint8_t cause);

enum command_result { COMMAND_TAKEN, COMMAND_STALE, COMMAND_NOT_ARMED, COMMAND_TOO_MUCH };
/* `stamped_us`: the device's time at which the host sent it, as the host estimates it. */
enum command_result supervisor_command(struct supervisor* s, const struct message_command* command, uint32_t stamped_us, uint32_t now_us);

/* Every millisecond or so. */
void supervisor_tick(struct supervisor* s, uint32_t now_us);
/* Every LIMIT_READING_PERIOD_ms: the 32 bits of each amplifier. */
void supervisor_reading(struct supervisor* s, const uint32_t raw[BOARD_COILS], uint32_t now_us);
/* After each reading: the sums of 16 ADC conversions. */
void supervisor_angles(struct supervisor* s, const uint16_t raw[BOARD_ANGLES]);
/* Every millisecond or so, where the board has dividers at the drains. */
void supervisor_drains(struct supervisor* s, const struct board_drain shown[BOARD_COILS]);

#ifdef __cplusplus
}
#endif
