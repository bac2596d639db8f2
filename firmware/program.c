// SPDX-License-Identifier: Apache-2.0
#include "firmware/program.h"

#include "firmware/board.h"
#include "firmware/latch.h"
#include "firmware/supervisor.h"
#include "firmware_hash.h"
#include "hil/frame.h"
#include "hil/heat_bound.h"
#include "hil/message.h"

/* Kept through a reset: whether a trip is owed, and the bounds of the coils' heat, each with its complement, for a reset must not make hot
 * coils cool. Power-on leaves chance in them, and a supply that sags turns bits: hence words of 32 bits. A word that is neither the mark
 * nor zero was damaged, and counts as set. */
#define ARMED_MARK 0x5a17c3e9ul
#define KEPT_ARMED 0u
#define KEPT_BOUND(coil) (1u + 2u * (coil))

static const struct board_parts parts = {BOARD_COILS, BOARD_THERMOCOUPLES, BOARD_ANGLES};
static struct supervisor supervisor;
static struct frame_decoder decoder;
static struct frame frame; /* received, then reused for what is sent */
static uint16_t session, counters[DEVICE_COUNTERS - FRAME_FAULTS];
static uint32_t last_sequence, last_command, sequence, last_ms;
static uint16_t angle_raw[BOARD_ANGLES], reading_in_ms;
static uint8_t telemetry_period_ms, telemetry_in_ms, stored_cause, stored_bytes;

/* Nothing is sent in parts: a frame for which there is no room is left out; the next telemetry is not far. A zero goes before
 * it too, so that what was cut off or garbled ahead of it ends there. */
static void send_frame(uint32_t time_us) {
  uint8_t wire[1u + FRAME_WIRE_MOST], length;
  frame.version = FRAME_VERSION;
  frame.session = session;
  frame.sequence = ++sequence;
  frame.time_us = time_us;
  wire[0] = 0;
  length = (uint8_t)(1u + frame_encode(&frame, wire + 1));
  if (board_send_room() >= length) board_send(wire, length);
}

static void send_hello(uint32_t time_us) {
  const struct message_hello hello = {.firmware_hash = SINEW_FIRMWARE_HASH,
                                      .limits_hash = limits_hash(BOARD_COILS),
                                      .reset_cause = board_reset_cause(),
                                      .state = supervisor.state,
                                      .trip_cause = supervisor.trip_cause,
                                      .parts = parts,
                                      .wrong_settings = supervisor.wrong_settings};
  put_hello(&frame, &hello);
  send_frame(time_us);
}

static void send_answer(uint8_t type, uint8_t answer, uint32_t to, uint32_t time_us) {
  const struct message_answer message = {type, answer, to};
  put_answer(&frame, &message);
  send_frame(time_us);
}

/* A function of its own for the compiler too: what it says needs 190 bytes of stack, and writing it to the wire 400 more. */
static __attribute__((noinline)) void put_telemetry_of_now(uint32_t time_us) {
  struct message_telemetry telemetry;
  uint8_t j;
  telemetry.last_sequence = last_command;
  telemetry.state = supervisor.state;
  telemetry.trip_cause = supervisor.trip_cause;
  for (j = 0; j < BOARD_COILS; ++j) {
    const struct thermocouple* const t = &supervisor.thermocouple[j];
    telemetry.sensor[j] = t->fault;
    telemetry.duty[j] = supervisor.duty[j];
    telemetry.thermocouple_raw[j] = t->raw;
    telemetry.temperature_cdegC[j] = t->temperature_cdegC;
    telemetry.bound_rise_cK[j] = heat_bound_cK(supervisor.bound_uK[j]);
  }
  telemetry.temperature_age_ms = (uint16_t)((time_us - supervisor.last_reading_us) / 1000u);
  for (j = 0; j < BOARD_ANGLES; ++j) {
    telemetry.angle_raw[j] = angle_raw[j];
    telemetry.angle_fault[j] = supervisor.angle[j].fault;
    /* 16 conversions of 1023 over 180 degrees, zero in the middle; each is cut off, not rounded: half a step, 8 in all. */
    telemetry.angle_cdeg[j] = (int16_t)(((int32_t)angle_raw[j] + 8 - 8184) * 18000 / 16368);
  }
  for (j = 0; j < FRAME_FAULTS; ++j) telemetry.counters[j] = decoder.refused[j];
  for (; j < DEVICE_COUNTERS; ++j) telemetry.counters[j] = counters[j - FRAME_FAULTS];
  telemetry.counters[COUNT_LOST_BYTES] = board_lost_bytes();
  put_telemetry(&frame, &parts, &telemetry);
}

static void keep_bounds(void) {
  volatile uint32_t* const kept = board_kept();
  uint8_t j;
  for (j = 0; j < BOARD_COILS; ++j) {
    kept[KEPT_BOUND(j)] = supervisor.bound_uK[j];
    kept[KEPT_BOUND(j) + 1u] = ~supervisor.bound_uK[j];
  }
}

/* After power-on, or a reset in the middle of keeping them, the supervisor's own beginning holds. */
static void take_kept_bounds(void) {
  const volatile uint32_t* const kept = board_kept();
  uint8_t j;
  if (board_reset_cause() == RESET_POWER_ON) return;
  for (j = 0; j < BOARD_COILS; ++j) {
    const uint32_t bound_uK = kept[KEPT_BOUND(j)];
    if (bound_uK == ~kept[KEPT_BOUND(j) + 1u]) supervisor.bound_uK[j] = bound_uK;
  }
}

static void count(uint8_t counter) {
  if (counters[counter - FRAME_FAULTS] != 0xffffu) ++counters[counter - FRAME_FAULTS];
}

static uint8_t latch_is_stored(void) { return supervisor.trip_cause == stored_cause && stored_bytes == LATCH_BYTES && board_store_ready(); }

static void set_pins(void) {
  board_gates(supervisor.duty);
  if (supervisor.state != DEVICE_ARMED) board_relay(0);
  /* Until a trip is stored, a reset must still find that there was one: a cell reads as erased while it is written. */
  board_kept()[KEPT_ARMED] =
      supervisor.state == DEVICE_ARMED || (supervisor.state == DEVICE_TRIPPED && !latch_is_stored()) ? ARMED_MARK : 0;
}

static void obey_arm(uint32_t heard, uint32_t time_us) {
  struct message_arm arm;
  enum answer answer;
  get_arm(&frame, &arm);
  /* One that lay somewhere on its way is of a host that may be gone. */
  if ((int32_t)(time_us - frame.time_us) >= (int32_t)(LIMIT_DEAD_MAN_ms * 1000ul)) {
    count(COUNT_STALE);
    return;
  }
  if (arm.firmware_hash != SINEW_FIRMWARE_HASH) {
    answer = ANSWER_WRONG_FIRMWARE;
  } else if (arm.limits_hash != limits_hash(BOARD_COILS)) {
    answer = ANSWER_WRONG_LIMITS;
  } else {
    supervisor.angle_faults_trip = arm.flags & ARM_ANGLE_FAULTS_TRIP;
    answer = supervisor_arm(&supervisor, time_us);
  }
  send_answer(FRAME_ARM, (uint8_t)answer, heard, time_us);
}

static void obey_command(uint32_t heard, uint32_t time_us) {
  struct message_command command;
  get_command(&frame, &parts, &command);
  switch (supervisor_command(&supervisor, &command, frame.time_us, time_us)) {
    case COMMAND_TAKEN:
      last_command = heard;
      break;
    case COMMAND_STALE:
      count(COUNT_STALE);
      break;
    case COMMAND_NOT_ARMED:
      count(COUNT_NOT_ARMED);
      break;
    case COMMAND_TOO_MUCH:
      count(COUNT_TOO_MUCH_DUTY);
      break;
  }
}

static void obey(uint32_t time_us) {
  const uint32_t heard = frame.sequence;
  const uint8_t type = frame.type;
  if (type >= FRAME_HELLO) { /* a device's frame: an echo on the line */
    count(COUNT_OTHER_SESSION);
    return;
  }
  if (type == FRAME_HELLO_REQUEST) {
    struct message_hello_request request;
    get_hello_request(&frame, &request);
    supervisor_disarm(&supervisor);
    set_pins();
    session = frame.session;
    last_sequence = heard;
    last_command = 0;
    telemetry_period_ms = request.telemetry_period_ms < 3u ? 3u : request.telemetry_period_ms;
    send_hello(time_us);
    return;
  }
  if (session == 0 || frame.session != session) {
    count(COUNT_OTHER_SESSION);
    return;
  }
  if ((int32_t)(heard - last_sequence) <= 0) {
    count(COUNT_OUT_OF_ORDER);
    return;
  }
  last_sequence = heard;
  if (type == FRAME_COMMAND) {
    obey_command(heard, time_us);
  } else if (type == FRAME_ARM) {
    obey_arm(heard, time_us);
  } else if (type == FRAME_DISARM) {
    supervisor_disarm(&supervisor);
    set_pins();
    send_answer(type, ANSWER_DONE, heard, time_us);
  } else if (type == FRAME_CLEAR_TRIP) {
    struct message_clear_trip clear;
    get_clear_trip(&frame, &clear);
    send_answer(type, (uint8_t)supervisor_clear_trip(&supervisor, clear.cause), heard, time_us);
  }
}

/* One byte a round, and only when the store is ready: a write takes 3.4 ms in an EEPROM and must not hold up the loop. */
static void store_latch(void) {
  if (supervisor.trip_cause != stored_cause) {
    stored_cause = supervisor.trip_cause;
    stored_bytes = 0;
  }
  if (stored_bytes < LATCH_BYTES && board_store_ready()) {
    board_store(stored_bytes, latch_byte(stored_cause, stored_bytes));
    ++stored_bytes;
  }
}

static uint8_t cause_at_start(void) {
  const uint8_t reset = board_reset_cause();
  const uint8_t was_armed = board_kept()[KEPT_ARMED] != 0 && reset != RESET_POWER_ON;
  const uint8_t latched = latch_cause(board_stored(0), board_stored(1));
  uint8_t cause = latched;
  if (cause == TRIP_NONE) {
    if (board_hung() && reset != RESET_POWER_ON) {
      cause = TRIP_MAIN_LOOP;
    } else if (reset == RESET_WATCHDOG) {
      cause = TRIP_WATCHDOG;
    } else if (was_armed) {
      cause = reset == RESET_BROWN_OUT ? TRIP_BROWN_OUT : TRIP_RESET_WHILE_ARMED;
    }
  }
  /* The next reset may come before this trip is stored. */
  board_kept()[KEPT_ARMED] = cause == TRIP_NONE ? 0 : ARMED_MARK;
  board_forget_hung();
  stored_cause = latched;
  stored_bytes = LATCH_BYTES;
  return cause;
}

void program_start(void) {
  frame_decoder_start(&decoder, &parts);
  supervisor_start(&supervisor, cause_at_start(), 0);
  take_kept_bounds();
  supervisor.wrong_settings = board_wrong_settings();
  last_ms = 0;
  reading_in_ms = LIMIT_READING_PERIOD_ms; /* the first conversion needs its time */
  telemetry_in_ms = telemetry_period_ms = 20;
}

static void look_at_drains(void) {
  struct board_drain drains[BOARD_COILS];
  if (board_drains(drains)) supervisor_drains(&supervisor, drains);
}

static void each_millisecond(uint8_t passed) {
  if (board_hung()) supervisor_trip(&supervisor, TRIP_MAIN_LOOP); /* came round after all, too late */
  supervisor_tick(&supervisor, board_us());
  look_at_drains();
  keep_bounds();
  set_pins();
  if (reading_in_ms <= passed) {
    uint32_t raw[BOARD_THERMOCOUPLES];
    board_amplifiers(raw);
    supervisor_reading(&supervisor, raw, board_us());
    supervisor_angles(&supervisor, angle_raw);
    set_pins();
    reading_in_ms = LIMIT_READING_PERIOD_ms;
  } else {
    reading_in_ms = (uint16_t)(reading_in_ms - passed);
  }
  board_angles(angle_raw);
  if (telemetry_in_ms <= passed) {
    if (session != 0) {
      const uint32_t time_us = board_us();
      put_telemetry_of_now(time_us);
      send_frame(time_us);
    }
    telemetry_in_ms = telemetry_period_ms;
  } else {
    telemetry_in_ms = (uint8_t)(telemetry_in_ms - passed);
  }
  if (supervisor.state == DEVICE_ARMED) board_relay(1);
  store_latch();
  if (supervisor.state == DEVICE_TRIPPED && latch_is_stored()) board_forget_hung();
  board_round_done();
}

void program_round(void) {
  int16_t byte;
  uint32_t ms;
  while ((byte = board_receive()) >= 0) {
    if (frame_decoder_take(&decoder, (uint8_t)byte, &frame) == FRAME_READY) obey(board_us());
  }
  ms = board_ms();
  if (ms != last_ms) {
    const uint8_t passed = (uint8_t)(ms - last_ms);
    last_ms = ms;
    each_millisecond(passed);
  }
}
