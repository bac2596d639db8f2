// SPDX-License-Identifier: Apache-2.0
#include "firmware/supervisor.h"

#include <string.h>

#include "hil/heat_bound.h"

static int32_t since_us(uint32_t now_us, uint32_t then_us) { return (int32_t)(now_us - then_us); }

void supervisor_start(struct supervisor* s, uint8_t latched, uint32_t now_us) {
  uint8_t j;
  memset(s, 0, sizeof *s);
  s->last_tick_us = s->last_reading_us = s->bucket_us = s->bound_us = now_us;
  for (j = 0; j < BOARD_COILS; ++j) s->thermocouple[j].fault = TRIP_SENSOR_SILENT;
  for (j = 0; j < BOARD_COILS; ++j) s->bound_uK[j] = (uint32_t)LIMIT_BOUND_START_cK * 10000u;
  s->angle_faults_trip = 1;
  if (latched != TRIP_NONE) supervisor_trip(s, latched);
}

static void all_off(struct supervisor* s) { memset(s->duty, 0, sizeof s->duty); }

void supervisor_disarm(struct supervisor* s) {
  all_off(s);
  if (s->state == DEVICE_ARMED) s->state = DEVICE_DISARMED;
}

/* The first cause is the one that is kept: what follows is often its consequence. */
void supervisor_trip(struct supervisor* s, uint8_t cause) {
  all_off(s);
  if (s->state != DEVICE_TRIPPED) s->trip_cause = cause;
  s->state = DEVICE_TRIPPED;
}

static enum answer cool_and_believed(const struct supervisor* s) {
  uint8_t j;
  for (j = 0; j < BOARD_COILS; ++j)
    if (s->thermocouple[j].fault != TRIP_NONE) return ANSWER_SENSOR;
  for (j = 0; j < BOARD_ANGLES; ++j)
    if (s->angle_faults_trip && s->angle[j].fault != TRIP_NONE) return ANSWER_SENSOR;
  for (j = 0; j < BOARD_COILS; ++j)
    if (s->thermocouple[j].temperature_cdegC >= LIMIT_COOL_cdegC) return ANSWER_HOT;
  return ANSWER_DONE;
}

enum answer supervisor_arm(struct supervisor* s, uint32_t now_us) {
  enum answer answer;
  if (s->wrong_settings != 0) return ANSWER_SETTINGS;
  if (s->state == DEVICE_TRIPPED) return ANSWER_TRIPPED;
  answer = cool_and_believed(s);
  if (answer != ANSWER_DONE) return answer;
  all_off(s);
  s->state = DEVICE_ARMED;
  s->valid_until_us = now_us + LIMIT_DEAD_MAN_ms * 1000ul;
  s->drains_settle_ms = LIMIT_DRAIN_SETTLING_ms;
  return ANSWER_DONE;
}

enum answer supervisor_clear_trip(struct supervisor* s, uint8_t cause) {
  enum answer answer;
  if (s->state != DEVICE_TRIPPED) return ANSWER_DONE;
  if (cause != s->trip_cause) return ANSWER_OTHER_CAUSE;
  answer = cool_and_believed(s);
  if (answer != ANSWER_DONE) return answer;
  s->state = DEVICE_DISARMED;
  s->trip_cause = TRIP_NONE;
  return ANSWER_DONE;
}

enum command_result supervisor_command(struct supervisor* s, const struct message_command* command, uint32_t stamped_us, uint32_t now_us) {
  uint32_t live_us = (command->time_to_live_ms < LIMIT_DEAD_MAN_ms ? command->time_to_live_ms : LIMIT_DEAD_MAN_ms) * 1000ul;
  const int32_t age_us = since_us(now_us, stamped_us);
  uint8_t j;
  if (s->state != DEVICE_ARMED) return COMMAND_NOT_ARMED;
  /* The host's estimate of this clock may be off by some milliseconds, not by more. */
  if (age_us < -20000 || age_us >= (int32_t)live_us) return COMMAND_STALE;
  for (j = 0; j < BOARD_COILS; ++j)
    if (command->duty[j] > LIMIT_HIGHEST_DUTY) return COMMAND_TOO_MUCH;
  for (j = 0; j < BOARD_COILS; ++j) s->duty[j] = command->duty[j];
  /* A stamp ahead of time must not lengthen the life. */
  s->valid_until_us = (age_us < 0 ? now_us : stamped_us) + live_us;
  return COMMAND_TAKEN;
}

static uint32_t on_time_ms(const struct supervisor* s, uint8_t j) {
  uint32_t sum = ON_us(s->bucket_on[j]) / 1000u;
  uint8_t i;
  for (i = 0; i < LIMIT_ON_TIME_WINDOW_s; ++i) sum += s->on_ms[j][i];
  return sum;
}

/* What flowed while disarmed counts too, and what the sensors say does not. */
static void bound_heat(struct supervisor* s, uint32_t now_us) {
  const int32_t since_ms = since_us(now_us, s->bound_us) / 1000;
  uint16_t step_ms;
  uint8_t j;
  if (since_ms < (int32_t)SUPERVISOR_BOUND_STEP_ms) return;
  step_ms = since_ms < 500 ? (uint16_t)since_ms : 500u; /* of a longer one all heat counts, and this much loss */
  s->bound_us += (uint32_t)since_ms * 1000u;
  for (j = 0; j < BOARD_COILS; ++j) {
    const uint32_t duty_ms = (s->bound_on[j] + 1000u / BOUND_STEP_us - 1u) / (1000u / BOUND_STEP_us);
    s->bound_on[j] = 0;
    s->bound_uK[j] = heat_bound_after(s->bound_uK[j], duty_ms, step_ms);
    if (s->state == DEVICE_ARMED && s->bound_uK[j] > (uint32_t)LIMIT_BOUND_RISE_cK * 10000u) supervisor_trip(s, TRIP_HEAT_BOUND);
  }
}

void supervisor_tick(struct supervisor* s, uint32_t now_us) {
  const uint32_t step_us = now_us - s->last_tick_us;
  uint8_t j;
  s->last_tick_us = now_us;
  for (j = 0; j < BOARD_COILS; ++j) {
    const uint32_t on = step_us / ON_STEP_us * s->duty[j];
    s->thermocouple[j].on += on;
    s->bucket_on[j] += on;
    s->bound_on[j] += (step_us + BOUND_STEP_us - 1u) / BOUND_STEP_us * s->duty[j];
  }
  bound_heat(s, now_us);
  if (since_us(now_us, s->bucket_us) >= 1000000) {
    s->bucket_us += 1000000u;
    for (j = 0; j < BOARD_COILS; ++j) {
      s->on_ms[j][s->bucket] = (uint16_t)(ON_us(s->bucket_on[j]) / 1000u);
      s->bucket_on[j] = 0;
    }
    s->bucket = (uint8_t)((s->bucket + 1u) % LIMIT_ON_TIME_WINDOW_s);
    for (j = 0; j < BOARD_COILS; ++j)
      if (s->state == DEVICE_ARMED && on_time_ms(s, j) > LIMIT_ON_TIME_ms) supervisor_trip(s, TRIP_ON_TIME);
  }
  if (s->state != DEVICE_ARMED) return;
  if (since_us(now_us, s->valid_until_us) >= 0) supervisor_trip(s, TRIP_SILENCE);
  if (since_us(now_us, s->last_reading_us) >= (int32_t)(LIMIT_READING_SILENCE_ms * 1000ul)) supervisor_trip(s, TRIP_SENSOR_SILENT);
}

/* What the 32 bits say of themselves; MAX31855 data sheet (Maxim 19-5793, rev 5), table 2. */
static uint8_t fault_of(uint32_t raw) {
  if (raw == 0) return TRIP_SENSOR_ZEROS;
  if (raw == 0xffffffffu) return TRIP_SENSOR_ONES;
  if (raw & 0x00020008u) return TRIP_SENSOR_GARBLED;
  if (raw & 1u) return TRIP_SENSOR_OPEN;
  if (raw & 2u) return TRIP_SENSOR_SHORT_TO_GROUND;
  if (raw & 4u) return TRIP_SENSOR_SHORT_TO_SUPPLY;
  if (raw & 0x00010000u) return TRIP_SENSOR_GARBLED; /* a fault without a kind */
  return TRIP_NONE;
}

/* Reads one amplifier; returns why it is not to be believed. */
static uint8_t read_thermocouple(struct thermocouple* t, uint32_t raw, int32_t period_ms) {
  const uint8_t fault = fault_of(raw);
  const uint32_t changed = (raw ^ t->raw) >> 18;
  const int32_t was_cdegC = t->temperature_cdegC, junction_was_cdegC = t->junction_cdegC;
  const uint8_t believed_before = t->fault == TRIP_NONE;
  int32_t heat_mK_s, loss_mK_s, sure_mK_s, due_mK;
  uint8_t i;
  t->raw = raw;
  if (fault != TRIP_NONE) return fault;
  /* Steps of a quarter and of a sixteenth of a degree, signed. */
  t->temperature_cdegC = ((int32_t)raw >> 18) * 25;
  t->junction_cdegC = ((int32_t)(raw << 16) >> 20) * 25 / 4;
  if (t->temperature_cdegC < LIMIT_COLDEST_cdegC || t->temperature_cdegC > 2 * LIMIT_COIL_cdegC) return TRIP_SENSOR_RANGE;
  if (t->junction_cdegC < LIMIT_JUNCTION_COLDEST_cdegC || t->junction_cdegC > LIMIT_JUNCTION_HOTTEST_cdegC) return TRIP_JUNCTION;

  if (!believed_before) { /* begins anew */
    t->readings = 0;
    t->warmed_mK = t->expected_mK = t->lagged_mK = t->should_have_moved_mK = 0;
    t->not_following = t->unexpected = 0;
    t->on = 0;
  }
  for (i = SUPERVISOR_READINGS - 1u; i > 0; --i) t->last_cdegC[i] = t->last_cdegC[i - 1u];
  t->last_cdegC[0] = t->temperature_cdegC;
  if (t->readings < SUPERVISOR_READINGS) ++t->readings;
  if (t->readings < 2) return TRIP_NONE;

  if (t->junction_cdegC - junction_was_cdegC > LIMIT_JUNCTION_JUMP_cK || junction_was_cdegC - t->junction_cdegC > LIMIT_JUNCTION_JUMP_cK)
    return TRIP_JUNCTION;
  if (t->temperature_cdegC - was_cdegC > LIMIT_JUMP_cK || was_cdegC - t->temperature_cdegC > LIMIT_JUMP_cK) return TRIP_SENSOR_JUMP;

  heat_mK_s = (int32_t)(ON_us(t->on) / 100u) * (LIMIT_HEATING_mK_s / 10) / period_ms;
  loss_mK_s = (t->temperature_cdegC - t->junction_cdegC) * LIMIT_COOLING_1_ks / 100;
  t->on = 0;
  /* By what must have come of the duty and not by the duty: a coil in equilibrium stays where it is, and a reading without noise with it.
   */
  sure_mK_s = (heat_mK_s - LIMIT_HEATING_mK_s / 100 * LIMIT_STUCK_DEADBAND / 100) * LIMIT_STUCK_SURE_100 / 100;
  if (loss_mK_s > 0) sure_mK_s -= loss_mK_s;
  if (changed) t->should_have_moved_mK = 0;
  if (sure_mK_s > 0) t->should_have_moved_mK += sure_mK_s * period_ms / 1000;
  if (t->should_have_moved_mK > LIMIT_STUCK_mK) return TRIP_SENSOR_STUCK;

  t->expected_mK += (heat_mK_s - loss_mK_s) * period_ms / 1000 - t->expected_mK * period_ms / LIMIT_FOLLOW_WINDOW_ms;
  t->lagged_mK += (t->expected_mK - t->lagged_mK) * period_ms / LIMIT_FOLLOW_LAG_ms;
  t->warmed_mK += (t->temperature_cdegC - was_cdegC) * 10 - t->warmed_mK * period_ms / LIMIT_FOLLOW_WINDOW_ms;
  /* Of a thermocouple with the longest lag and of one without any, the lesser. */
  due_mK = t->lagged_mK < t->expected_mK ? t->lagged_mK : t->expected_mK;
  if (t->not_following >= LIMIT_FOLLOW_READINGS) t->not_following = LIMIT_FOLLOW_READINGS - 1u;
  t->not_following = due_mK > LIMIT_FOLLOW_EXPECTED_mK && t->warmed_mK < due_mK / 4 ? (uint8_t)(t->not_following + 1u) : 0;
  return t->not_following >= LIMIT_FOLLOW_READINGS ? TRIP_NOT_FOLLOWING : TRIP_NONE;
}

/* The line of least squares through the last SUPERVISOR_READINGS: its rise from one reading to the next in 1 / LINE_ONE of 0.01 K, and what
 * it will show a quarter of a second after the newest. Noise is less in it than in a reading, and a coil that warms steadily is not late.
 */
#define LINE_HALF ((int32_t)(SUPERVISOR_READINGS / 2u))
#define LINE_ONE (LINE_HALF * (LINE_HALF + 1) * (2 * LINE_HALF + 1) / 3)
#define QUARTER_SECOND_ms 250
static int32_t line_of(const struct thermocouple* t, int32_t period_ms, int32_t* ahead_cdegC) {
  int32_t sum = 0, moment = 0;
  int8_t i;
  for (i = 0; i < (int8_t)SUPERVISOR_READINGS; ++i) {
    sum += t->last_cdegC[i];
    moment += (LINE_HALF - i) * t->last_cdegC[i];
  }
  *ahead_cdegC = sum / (int32_t)SUPERVISOR_READINGS + moment * LINE_HALF / LINE_ONE + moment / LINE_ONE * QUARTER_SECOND_ms / period_ms;
  return moment;
}

void supervisor_reading(struct supervisor* s, const uint32_t raw[BOARD_COILS], uint32_t now_us) {
  int32_t period_ms = since_us(now_us, s->last_reading_us) / 1000;
  uint8_t j;
  if (period_ms < 1) period_ms = 1;
  s->last_reading_us = now_us;
  for (j = 0; j < BOARD_COILS; ++j) {
    struct thermocouple* const t = &s->thermocouple[j];
    int32_t expected_mK, ahead_cdegC, moment = 0;
    t->fault = read_thermocouple(t, raw[j], period_ms);
    if (t->fault != TRIP_NONE) {
      if (s->state == DEVICE_ARMED) supervisor_trip(s, t->fault);
      continue;
    }
    ahead_cdegC = t->temperature_cdegC;
    if (t->readings == SUPERVISOR_READINGS) moment = line_of(t, period_ms, &ahead_cdegC);
    /* Heat is spoken of while disarmed too: then the switch does not obey, and whoever looks should know. */
    if (ahead_cdegC >= LIMIT_TRIP_cdegC || t->temperature_cdegC >= LIMIT_COIL_cdegC) supervisor_trip(s, TRIP_OVER_TEMPERATURE);
    if (s->state == DEVICE_ARMED && moment / LINE_ONE * 1000 / period_ms > LIMIT_RISE_cK_s) supervisor_trip(s, TRIP_RATE_OF_RISE);
    /* After the duty a thermocouple with a lag still warms. */
    expected_mK = t->expected_mK > t->lagged_mK ? t->expected_mK : t->lagged_mK;
    t->unexpected = t->warmed_mK > LIMIT_UNEXPECTED_mK + (expected_mK > 0 ? 2 * expected_mK : 0) ? (uint8_t)(t->unexpected + 1u) : 0;
    if (t->unexpected >= LIMIT_UNEXPECTED_READINGS) {
      t->unexpected = LIMIT_UNEXPECTED_READINGS;
      supervisor_trip(s, TRIP_UNEXPECTED_HEATING);
    }
  }
}

static uint8_t read_angle(const struct supervisor* s, struct angle* a, uint16_t raw) {
  uint8_t j, alone = 0, others = 0;
  if (raw < LIMIT_ANGLE_LEAST_raw || raw > LIMIT_ANGLE_MOST_raw) {
    a->begun = 0;
    return TRIP_ANGLE_RANGE;
  }
  if (!a->begun || raw > a->raw + LIMIT_ANGLE_MOVED_raw || a->raw > raw + LIMIT_ANGLE_MOVED_raw) {
    a->begun = 1;
    a->raw = raw;
    for (j = 0; j < BOARD_COILS; ++j) a->coldest_cdegC[j] = a->hottest_cdegC[j] = s->thermocouple[j].temperature_cdegC;
    return TRIP_NONE;
  }
  for (j = 0; j < BOARD_COILS; ++j) {
    const struct thermocouple* const t = &s->thermocouple[j];
    int32_t range_cK;
    if (t->fault != TRIP_NONE) continue; /* that is its own trip */
    if (t->temperature_cdegC < a->coldest_cdegC[j]) a->coldest_cdegC[j] = t->temperature_cdegC;
    if (t->temperature_cdegC > a->hottest_cdegC[j]) a->hottest_cdegC[j] = t->temperature_cdegC;
    range_cK = a->hottest_cdegC[j] - a->coldest_cdegC[j];
    if (range_cK > LIMIT_ANGLE_RANGE_cK) {
      ++alone;
    } else if (range_cK > LIMIT_ANGLE_OTHERS_cK) {
      ++others; /* two coils may hold each other */
    }
  }
  return alone == 1 && others == 0 ? TRIP_ANGLE_STUCK : TRIP_NONE;
}

void supervisor_angles(struct supervisor* s, const uint16_t raw[BOARD_ANGLES]) {
  uint8_t g;
  for (g = 0; g < BOARD_ANGLES; ++g) {
    s->angle[g].fault = read_angle(s, &s->angle[g], raw[g]);
    if (s->angle[g].fault != TRIP_NONE && s->angle_faults_trip && s->state == DEVICE_ARMED) supervisor_trip(s, s->angle[g].fault);
  }
}

/* Of the supply; of low samples without duty one in eight may be a disturbance. */
#define DRAIN_HIGH_SAMPLES 5u
#define DRAIN_IDLE_SAMPLES 20u
#define DRAIN_UNASKED 8u

static uint8_t up_to_255(uint16_t value) { return value < 255u ? (uint8_t)value : 255u; }

/* With duty, a switch that opens in each period shows it: one that never does is welded, whatever the thermocouple says. */
static uint8_t read_drain(struct drain* d, const struct board_drain* shown, uint16_t duty) {
  const uint8_t high = (uint8_t)(shown->samples - shown->low);
  /* No sample is none that is high. */
  d->low = high ? 0 : up_to_255((uint16_t)(d->low + (shown->low ? shown->low : 1u)));
  d->idle = duty ? 0 : up_to_255((uint16_t)(d->idle + shown->samples));
  if (d->idle < DRAIN_IDLE_SAMPLES) {
    d->low_unasked = 0;
  } else {
    d->low_unasked = up_to_255((uint16_t)(d->low_unasked + DRAIN_UNASKED * shown->low));
    d->low_unasked = d->low_unasked > high ? (uint8_t)(d->low_unasked - high) : 0;
  }
  if (shown->highest_cV > LIMIT_SUPPLY_cV) {
    d->high = up_to_255((uint16_t)(d->high + 1u));
  } else if (high) {
    d->high = 0;
  }
  if (d->high >= DRAIN_HIGH_SAMPLES) return TRIP_SUPPLY_HIGH;
  return d->low >= LIMIT_DRAIN_LOW_ms || d->low_unasked >= 3u * DRAIN_UNASKED ? TRIP_DRAIN_LOW : TRIP_NONE;
}

void supervisor_drains(struct supervisor* s, const struct board_drain shown[BOARD_COILS]) {
  uint8_t j;
  if (s->state != DEVICE_ARMED || s->drains_settle_ms > 0) {
    memset(s->drain, 0, sizeof s->drain);
    if (s->drains_settle_ms > 0) --s->drains_settle_ms;
    return;
  }
  for (j = 0; j < BOARD_COILS; ++j) {
    const uint8_t cause = read_drain(&s->drain[j], &shown[j], s->duty[j]);
    if (cause != TRIP_NONE) supervisor_trip(s, cause);
  }
}
