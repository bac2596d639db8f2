// SPDX-License-Identifier: Apache-2.0
// A board in memory with any number of parts, by the codec alone: it believes all that it is told, and its coils warm as they
// should. For what sessions do with counts; what a board must refuse is fake_board.h's.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "firmware_hash.h"
#include "hil/limits.h"
#include "hil/link.h"
#include "hil/message.h"

struct BoardOfAnySize : sinew::hil::Link {
  board_parts parts, said;  // the true ones, and what its hello says
  frame_decoder decoder{};
  std::uint16_t session = 0;
  std::uint32_t last_command = 0, sequence = 0;
  std::uint8_t state = DEVICE_DISARMED;
  std::uint16_t duty[BOARD_PARTS_MOST] = {};
  std::vector<double> temperature_degC;
  std::uint32_t limits;
  std::int64_t now_us = 0;
  std::uint8_t telemetry_period_ms = 20;
  std::vector<std::uint8_t> out, in;

  explicit BoardOfAnySize(const board_parts& of) : parts(of), said(of), temperature_degC(of.coils, 25.0), limits(limits_hash(of.coils)) {
    frame_decoder_start(&decoder, &parts);
  }

  std::int64_t send(std::span<const std::uint8_t> bytes) override {
    in.insert(in.end(), bytes.begin(), bytes.end());
    return now_us;
  }
  sinew::hil::Received receive_until(std::int64_t deadline_us) override {
    do {
      if (now_us < deadline_us) step();
      if (!out.empty()) return {now_us, std::exchange(out, {})};
    } while (now_us < deadline_us);
    return {now_us, {}};
  }
  void say(frame& f) {
    f.version = FRAME_VERSION;
    f.session = session;
    f.sequence = ++sequence;
    f.time_us = static_cast<std::uint32_t>(now_us);
    std::uint8_t wire[FRAME_WIRE_MOST];
    const std::uint8_t count = frame_encode(&f, wire);
    out.insert(out.end(), wire, wire + count);
  }
  void obey(const frame& f) {
    frame reply{};
    if (f.type == FRAME_HELLO_REQUEST) {
      session = f.session;
      state = DEVICE_DISARMED;
      const message_hello hello{.firmware_hash = SINEW_FIRMWARE_HASH,
                                .limits_hash = limits,
                                .reset_cause = RESET_POWER_ON,
                                .state = state,
                                .trip_cause = TRIP_NONE,
                                .parts = said,
                                .wrong_settings = 0};
      put_hello(&reply, &hello);
      say(reply);
    } else if (f.type == FRAME_COMMAND) {
      message_command command{};
      get_command(&f, &parts, &command);
      for (std::uint8_t j = 0; j < parts.coils; ++j) duty[j] = command.duty[j];
      last_command = f.sequence;
    } else {
      state = f.type == FRAME_ARM ? DEVICE_ARMED : DEVICE_DISARMED;
      const message_answer answer{f.type, ANSWER_DONE, f.sequence};
      put_answer(&reply, &answer);
      say(reply);
    }
  }
  void step() {
    now_us += 1000;
    for (std::uint8_t j = 0; j < parts.coils; ++j)
      temperature_degC[j] += 1e-3 * (duty[j] / 1e4 * 19.6 - 0.04 * (temperature_degC[j] - 25.0)) / 0.85;
    for (const std::uint8_t byte : std::exchange(in, {})) {
      frame f{};
      if (frame_decoder_take(&decoder, byte, &f) == FRAME_READY) obey(f);
    }
    if (session == 0 || now_us / 1000 % telemetry_period_ms != 0) return;
    message_telemetry telemetry{};
    telemetry.last_sequence = last_command;
    telemetry.state = state;
    for (std::uint8_t j = 0; j < parts.coils; ++j) telemetry.duty[j] = duty[j];
    for (std::uint8_t k = 0; k < parts.thermocouples; ++k) {
      const auto quarters = static_cast<std::int32_t>(std::lround(temperature_degC[k] * 4.0));
      telemetry.thermocouple_raw[k] = (static_cast<std::uint32_t>(quarters & 0x3fff) << 18) | (400u << 4);
      telemetry.temperature_cdegC[k] = quarters * 25;
    }
    for (std::uint8_t k = 0; k < parts.angles; ++k)
      telemetry.angle_raw[k] = 9000, telemetry.angle_cdeg[k] = static_cast<std::int16_t>(1000 * (k + 1));
    frame f{};
    put_telemetry(&f, &parts, &telemetry);
    say(f);
  }
};
