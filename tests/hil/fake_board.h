// SPDX-License-Identifier: Apache-2.0
// A board in memory, of BOARD_COILS coils: the device's own codec and supervisor, two coils that warm as they should, time that goes on as
// asked. What firmware/program.c does, again and with ways to be wrong; that the two agree is for the emulator's tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "firmware/supervisor.h"
#include "firmware_hash.h"
#include "hil/heat_bound.h"
#include "hil/link.h"
#include "hil/message.h"

struct FakeBoard : sinew::hil::Link {
  supervisor s{};
  frame_decoder decoder{};
  std::uint16_t session = 0;
  std::uint32_t last_sequence = 0, last_command = 0, sequence = 0;
  std::uint16_t counters[DEVICE_COUNTERS] = {};
  std::uint8_t telemetry_period_ms = 20;
  std::int64_t now_us = 0;
  double temperature_degC[BOARD_COILS] = {25.0, 25.0};
  std::uint32_t forced_raw = 0x12345;  // instead of A's word, unless it is this
  std::uint32_t firmware_hash = SINEW_FIRMWARE_HASH, limits = limits_hash(BOARD_COILS);
  board_parts parts{BOARD_COILS, BOARD_THERMOCOUPLES, BOARD_ANGLES};  // as its hello says
  double device_rate = 1.0;                                           // its crystal, against the host's
  std::int64_t lost_from_us = -1;
  std::int64_t last_on_us = -1;             // the last millisecond with duty on any coil
  int swallow_answers_to = -1;              // a frame type
  std::uint8_t trip_on_disarm = TRIP_NONE;  // just before it
  bool echoes = false;                      // the line gives back what is sent
  bool arms_for_anybody = false;            // whatever the hashes and however old
  bool takes_again = false;                 // frames whatever their sequence numbers
  bool swallows_all = false;                // nobody is there
  bool never_silent = false;                // no dead-man
  bool says_nothing = false;                // answers, and no telemetry
  std::vector<std::uint8_t> out, in;
  int angle_raw = -1;  // what the supervisor is shown of the bend sensor; -1: one that moves with A's heat
  int until_reading = 105, until_telemetry = 20;

  FakeBoard() {
    frame_decoder_start(&decoder, &parts);
    supervisor_start(&s, TRIP_NONE, 0);
  }
  std::uint32_t device_us() const {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(static_cast<double>(now_us) * device_rate));
  }

  std::int64_t send(std::span<const std::uint8_t> bytes) override {
    if (lost_from_us >= 0 && now_us >= lost_from_us) throw sinew::hil::LinkLost("pulled");
    if (swallows_all) return now_us;
    in.insert(in.end(), bytes.begin(), bytes.end());
    if (echoes) out.insert(out.end(), bytes.begin(), bytes.end());
    return now_us;
  }
  sinew::hil::Received receive_until(std::int64_t deadline_us) override {
    do {
      if (lost_from_us >= 0 && now_us >= lost_from_us) throw sinew::hil::LinkLost("pulled");
      if (now_us < deadline_us) step();
      if (!out.empty()) return {now_us, std::exchange(out, {})};
    } while (now_us < deadline_us);
    return {now_us, {}};
  }

  void say(frame& f) {
    f.version = FRAME_VERSION;
    f.session = session;
    f.sequence = ++sequence;
    f.time_us = device_us();
    std::uint8_t wire[FRAME_WIRE_MOST];
    const std::uint8_t count = frame_encode(&f, wire);
    out.insert(out.end(), wire, wire + count);
  }
  void answer_to(const frame& f, std::uint8_t answer) {
    if (f.type == swallow_answers_to) return;
    frame reply{};
    const message_answer message{f.type, answer, f.sequence};
    put_answer(&reply, &message);
    say(reply);
  }
  void obey(const frame& f) {
    if (f.type >= FRAME_HELLO) return void(++counters[COUNT_OTHER_SESSION]);
    if (f.type == FRAME_HELLO_REQUEST) {
      message_hello_request request;
      get_hello_request(&f, &request);
      supervisor_disarm(&s);
      session = f.session;
      last_sequence = f.sequence;
      telemetry_period_ms = request.telemetry_period_ms;
      frame reply{};
      const message_hello hello{firmware_hash, limits, RESET_POWER_ON, s.state, s.trip_cause, parts, s.wrong_settings};
      put_hello(&reply, &hello);
      say(reply);
      return;
    }
    if (f.session != session) return void(++counters[COUNT_OTHER_SESSION]);
    if (static_cast<std::int32_t>(f.sequence - last_sequence) <= 0 && !takes_again) return void(++counters[COUNT_OUT_OF_ORDER]);
    last_sequence = f.sequence;
    if (f.type == FRAME_COMMAND) {
      message_command command;
      get_command(&f, &decoder.parts, &command);
      switch (supervisor_command(&s, &command, f.time_us, device_us())) {
        case COMMAND_TAKEN:
          last_command = f.sequence;
          break;
        case COMMAND_STALE:
          ++counters[COUNT_STALE];
          break;
        case COMMAND_NOT_ARMED:
          ++counters[COUNT_NOT_ARMED];
          break;
        case COMMAND_TOO_MUCH:
          ++counters[COUNT_TOO_MUCH_DUTY];
          break;
      }
    } else if (f.type == FRAME_ARM) {
      message_arm arm;
      get_arm(&f, &arm);
      if (!arms_for_anybody) {
        if (static_cast<std::int32_t>(device_us() - f.time_us) >= static_cast<std::int32_t>(LIMIT_DEAD_MAN_ms * 1000))
          return void(++counters[COUNT_STALE]);
        if (arm.firmware_hash != firmware_hash) return answer_to(f, ANSWER_WRONG_FIRMWARE);
        if (arm.limits_hash != limits) return answer_to(f, ANSWER_WRONG_LIMITS);
      }
      s.angle_faults_trip = arm.flags & ARM_ANGLE_FAULTS_TRIP;
      answer_to(f, static_cast<std::uint8_t>(supervisor_arm(&s, device_us())));
    } else if (f.type == FRAME_DISARM) {
      if (trip_on_disarm != TRIP_NONE) supervisor_trip(&s, trip_on_disarm);
      supervisor_disarm(&s);
      answer_to(f, ANSWER_DONE);
    } else if (f.type == FRAME_CLEAR_TRIP) {
      message_clear_trip clear;
      get_clear_trip(&f, &clear);
      answer_to(f, static_cast<std::uint8_t>(supervisor_clear_trip(&s, clear.cause)));
    }
  }
  void step() {
    now_us += 1000;
    for (std::size_t j = 0; j < BOARD_COILS; ++j)
      temperature_degC[j] += 1e-3 * (s.duty[j] / 1e4 * 19.6 - 0.04 * (temperature_degC[j] - 25.0)) / 0.85;
    if (std::any_of(s.duty, s.duty + BOARD_COILS, [](std::uint16_t duty) { return duty > 0; })) last_on_us = now_us;
    for (const std::uint8_t byte : std::exchange(in, {})) {
      frame f{};
      if (frame_decoder_take(&decoder, byte, &f) == FRAME_READY) obey(f);
    }
    if (never_silent) s.valid_until_us = device_us() + 100'000;
    supervisor_tick(&s, device_us());
    if (--until_reading == 0) {
      until_reading = 105;
      std::uint32_t raw[BOARD_COILS];
      for (std::size_t j = 0; j < BOARD_COILS; ++j)
        raw[j] = (static_cast<std::uint32_t>(std::lround(temperature_degC[j] * 4.0) & 0x3fff) << 18) | (400u << 4);
      if (forced_raw != 0x12345) raw[0] = forced_raw;
      supervisor_reading(&s, raw, device_us());
      const auto shown = static_cast<std::uint16_t>(angle_raw >= 0 ? angle_raw : 9000 + std::lround(20.0 * (temperature_degC[0] - 25.0)));
      supervisor_angles(&s, &shown);
    }
    if (--until_telemetry == 0) {
      until_telemetry = telemetry_period_ms;
      if (session == 0 || says_nothing) return;
      message_telemetry t{};
      t.last_sequence = last_command;
      t.state = s.state;
      t.trip_cause = s.trip_cause;
      for (std::size_t j = 0; j < BOARD_COILS; ++j) {
        t.sensor[j] = s.thermocouple[j].fault;
        t.duty[j] = s.duty[j];
        t.thermocouple_raw[j] = s.thermocouple[j].raw;
        t.temperature_cdegC[j] = s.thermocouple[j].temperature_cdegC;
        t.bound_rise_cK[j] = heat_bound_cK(s.bound_uK[j]);
      }
      t.angle_cdeg[0] = 1250;
      t.angle_raw[0] = static_cast<std::uint16_t>(angle_raw >= 0 ? angle_raw : 9321);
      t.angle_fault[0] = s.angle[0].fault;
      t.temperature_age_ms = static_cast<std::uint16_t>((device_us() - s.last_reading_us) / 1000);
      std::copy(counters, counters + DEVICE_COUNTERS, t.counters);
      std::copy(decoder.refused, decoder.refused + FRAME_FAULTS, t.counters);
      frame f{};
      put_telemetry(&f, &decoder.parts, &t);
      say(f);
    }
  }
};
