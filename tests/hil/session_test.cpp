// SPDX-License-Identifier: Apache-2.0
#include "hil/session.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "hil/wire_log.h"
#include "sim/input_error.h"
#include "sim/recording.h"
#include "tests/hil/board_of_any_size.h"
#include "tests/hil/fake_board.h"

namespace hil_session_test {

using namespace sinew;
using namespace sinew::hil;

namespace {

sim::Scenario scenario(const std::string& input = "{ duty_A: { step: { height_fraction: 0.4, from_s: 1, until_s: 6 } } }",
                       double period_s = 0.1) {
  return sim::parse_scenario("format: 1\nduration_s: 8\nsample_period_s: " + std::to_string(period_s) + "\ninput: " + input + "\n",
                             "s.yaml");
}
std::string refusal(Link& link, const SessionSettings& settings = {}) {
  try {
    run_session(scenario(), link, settings);
  } catch (const Refused& refused) {
    return refused.what();
  }
  return "";
}

// Segments in series, each of two coils with thermocouples and a bend sensor; with an odd number of coils, the last has one.
std::string plant_of(int coils, bool thermocouples = true) {
  std::string segments, wires, channels, bends;
  const auto add = [](std::string& list, const std::string& one) { list += (list.empty() ? "" : ", ") + one; };
  for (int j = 0; j < coils; ++j) {
    const std::string segment = "s" + std::to_string(j / 2), name = "c" + std::to_string(j);
    if (j % 2 == 0) {
      add(segments, "{name: " + segment + "}");
      add(bends, "{column: angle_" + segment + "_deg, bend: " + segment + "}");
    }
    add(wires, "{name: " + name + ", segment: " + segment + ", direction_deg: " + (j % 2 ? "180" : "0") + "}");
    if (thermocouples) add(channels, "{column: temperature_" + name + "_degC, thermocouple: " + name + "}");
  }
  add(channels, bends);
  return "plant: { limb: { segments: [" + segments + "], coils: [" + wires + "], channels: [" + channels + "] } }\n";
}
sim::Scenario scenario_of(int coils, bool thermocouples = true) {
  return sim::parse_scenario("format: 1\nduration_s: 3\ninput: { duty_c" + std::to_string(coils - 1) +
                                 ": { step: { height_fraction: 0.4, from_s: 1, until_s: 2 } } }\n" + plant_of(coils, thermocouples),
                             "s.yaml");
}
std::string refusal_of(const sim::Scenario& scenario, const board_parts& parts, const board_parts* said = nullptr) {
  BoardOfAnySize board(parts);
  if (said) board.said = *said;
  try {
    run_session(scenario, board, {});
  } catch (const Refused& refused) {
    CHECK(board.state == DEVICE_DISARMED);
    return refused.what();
  }
  return "";
}

}  // namespace

TEST_CASE("session: boards of 1, 2, 4 and 8 coils run a scenario of a limb of as many; the last coil is driven and no other") {
  for (const int coils : {1, 2, 4, 8}) {
    CAPTURE(coils);
    const sim::Scenario scenario = scenario_of(coils);
    const auto bends = static_cast<std::uint8_t>((coils + 1) / 2), count = static_cast<std::uint8_t>(coils);
    BoardOfAnySize board({count, count, bends});
    LoggedLink logged(board);
    const SessionResult result = run_session(scenario, logged, {});
    CHECK(result.status == SessionStatus::finished);
    CHECK(board.state == DEVICE_DISARMED);
    const sim::Recording recording = sim::parse_recording(result.recording_csv, "recording.csv", sim::columns_of(scenario.plant.system()));
    REQUIRE(recording.samples.size() == 31);
    const sim::Sample& driven = recording.samples[15];
    for (int j = 0; j < coils; ++j) {
      CHECK(driven.inputs[static_cast<std::size_t>(j)] == (j == coils - 1 ? 0.4 : 0.0));
      CHECK((recording.samples[20].channels[static_cast<std::size_t>(j)] > 30.0) == (j == coils - 1));
    }
    for (int k = 0; k < bends; ++k) CHECK(driven.channels[static_cast<std::size_t>(coils + k)] == 10.0 * (k + 1));
    ReplayLink replay(logged.log(), "wire.bin");
    CHECK(run_session(scenario, replay, {}).recording_csv == result.recording_csv);
  }
}

TEST_CASE("session: a plant with another number of coils, thermocouples or angles than the board is refused, with both numbers") {
  CHECK(refusal_of(scenario_of(4), {2, 2, 1})
            .find("the plant has 4 coils, the board 2; the plant has 4 thermocouples, the board 2; the plant has 2 angles, the board 1") ==
        0);
  CHECK(refusal_of(scenario_of(2), {8, 2, 1}).find("the plant has 2 coils, the board 8\n") == 0);
  CHECK(refusal_of(scenario_of(2), {2, 2, 0}).find("the plant has 1 angles, the board 0\n") == 0);
  BoardOfAnySize other_limits({4, 4, 2});
  other_limits.limits = limits_hash(2);
  CHECK_THROWS_WITH_AS(run_session(scenario_of(4), other_limits, {}), doctest::Contains("limits"), Refused);
}

TEST_CASE("session: a hello of 0 or 9 coils, or of 9 thermocouples or angles, is refused with its place") {
  const board_parts none{0, 2, 1}, nine{9, 2, 1}, thermocouples{2, 9, 1}, angles{2, 2, 9};
  CHECK(refusal_of(scenario_of(2), {2, 2, 1}, &none).find("the board's hello, payload byte 11: 0 coils; must be 1 to 8\n") == 0);
  CHECK(refusal_of(scenario_of(2), {2, 2, 1}, &nine).find("the board's hello, payload byte 11: 9 coils; must be 1 to 8\n") == 0);
  CHECK(refusal_of(scenario_of(2), {2, 2, 1}, &thermocouples).find("payload byte 12: 9 thermocouples; must be 0 to 8\n") !=
        std::string::npos);
  CHECK(refusal_of(scenario_of(2), {2, 2, 1}, &angles).find("payload byte 13: 9 angles; must be 0 to 8\n") != std::string::npos);
}

TEST_CASE("session: a plant that no board can have is an error with its place") {
  const auto error = [](const sim::Scenario& scenario) -> std::string {
    try {
      parts_of(scenario.plant, "s.yaml");
    } catch (const sim::InputError& e) {
      return e.what();
    }
    return "";
  };
  CHECK(error(scenario_of(8)).empty());
  CHECK(error(scenario_of(9)) == "s.yaml: plant.limb.coils = 9\n  the wire to a board carries 1 to 8 coils");
  CHECK(error(scenario_of(2, false)).find("s.yaml: plant.limb.coils = c0\n  has no thermocouple") == 0);
}

TEST_CASE("session: a twin of another limb is an error") {
  BoardOfAnySize board({4, 4, 2});
  SessionSettings settings;
  settings.twin = scenario_of(2).plant;
  CHECK_THROWS_AS(run_session(scenario_of(4), board, settings), sim::InputError);
}

TEST_CASE("session: a scenario runs to its end, and the limb is at rest then") {
  FakeBoard board;
  const SessionResult result = run_session(scenario(), board, {});
  CHECK(result.status == SessionStatus::finished);
  CHECK(result.brought_to_rest);
  CHECK(board.s.state == DEVICE_DISARMED);
  CHECK(board.s.duty[0] == 0);
  const sim::Recording recording = sim::parse_recording(result.recording_csv, "recording.csv", sim::columns_of(scenario().plant.system()));
  REQUIRE(recording.samples.size() == 81);
  CHECK(recording.samples[9].inputs[0] == 0.0);
  CHECK(recording.samples[10].inputs[0] == 0.4);
  CHECK(recording.samples[59].inputs[0] == 0.4);
  CHECK(recording.samples[60].inputs[0] == 0.0);
  CHECK(recording.samples[60].channels[0] > 55.0);
  CHECK(recording.samples[60].channels[2] == 12.5);
  CHECK(recording.notes.summary().empty());
}

TEST_CASE("session: from 5 ms to 0.2 s a sample, the deadlines are kept and the device stays armed") {
  for (const double period_s : {0.005, 0.05, 0.2}) {
    FakeBoard board;
    const SessionResult result = run_session(scenario("{ duty_A: { constant: { value_fraction: 0.2 } } }", period_s), board, {});
    CAPTURE(period_s);
    CHECK(result.status == SessionStatus::finished);
    CHECK(result.ticks == std::llround(8.0 / period_s) + 1);
  }
}

TEST_CASE(
    "session: asked for more heat than its bound allows, the host lowers the duty, and the device does not trip; nearly all of it is "
    "used") {
  for (const double period_s : {0.005, 0.1, 0.2}) {
    FakeBoard board;
    sim::Scenario hot = scenario("{ duty_A: { constant: { value_fraction: 0.5 } } }", period_s);
    hot.duration_s = 30.0;
    SessionSettings settings;
    std::uint32_t most_uK = 0;
    settings.show = [&](const SessionView&) { most_uK = std::max(most_uK, board.s.bound_uK[0]); };
    const SessionResult result = run_session(hot, board, settings);
    CAPTURE(period_s);
    CHECK(result.status == SessionStatus::finished);
    CHECK(most_uK < LIMIT_BOUND_RISE_cK * 10'000u);
    CHECK(most_uK > (LIMIT_BOUND_RISE_cK - 300) * 10'000u);
  }
}

TEST_CASE("session: it is not armed with other firmware, other limits, a latched trip, a hot coil, a broken sensor, no answer") {
  FakeBoard firmware;
  firmware.firmware_hash ^= 1;
  CHECK(refusal(firmware).find("firmware is") != std::string::npos);
  CHECK(firmware.s.state == DEVICE_DISARMED);
  FakeBoard limits;
  limits.limits ^= 1;
  CHECK(refusal(limits).find("limits") != std::string::npos);
  FakeBoard new_chip;
  new_chip.s.wrong_settings = SETTING_BROWN_OUT | SETTING_WATCHDOG;
  CHECK(refusal(new_chip) ==
        "the board's fuses are wrong: brown-out detection is off, or not at 4.3 V; the watchdog is not always on\n"
        "  set them once, by a programmer: docs/hardware.md, Fuses");
  FakeBoard tripped;
  supervisor_trip(&tripped.s, TRIP_SILENCE);
  CHECK(refusal(tripped).find("tripped: silence") != std::string::npos);
  FakeBoard hot;
  hot.temperature_degC[1] = 60.0;
  CHECK(refusal(hot).find("not cool yet") != std::string::npos);
  FakeBoard broken;
  broken.forced_raw = 0x06410001;
  CHECK(refusal(broken).find("A sensor_open") != std::string::npos);
  struct : Link {
    std::int64_t now_us = 0;
    std::int64_t send(std::span<const std::uint8_t>) override { return now_us; }
    Received receive_until(std::int64_t deadline_us) override { return {now_us = std::max(now_us, deadline_us), {}}; }
  } nobody;
  CHECK(refusal(nobody).find("no answer") != std::string::npos);
}

TEST_CASE("session: a trip is cleared when it is asked for, and not otherwise") {
  FakeBoard board;
  supervisor_trip(&board.s, TRIP_SILENCE);
  SessionSettings settings;
  settings.clear_trip = true;
  CHECK(run_session(scenario(), board, settings).status == SessionStatus::finished);
}

TEST_CASE("session: a trip of the device ends it, with the cause, and what was recorded is kept") {
  FakeBoard board;
  SessionSettings settings;
  settings.show = [&](const SessionView& view) {
    if (view.time_s >= 4.0) board.forced_raw = 0x06410001;
  };
  const SessionResult result = run_session(scenario(), board, settings);
  CHECK(result.status == SessionStatus::tripped);
  CHECK(result.why.find("sensor_open") != std::string::npos);
  CHECK(result.ticks > 40);
  CHECK(result.ticks < 44);
  CHECK(board.s.state == DEVICE_TRIPPED);
}

TEST_CASE("session: a pulled cable ends it as a lost link, and the device's dead-man takes the duty away") {
  FakeBoard board;
  board.lost_from_us = 5'000'000;
  const SessionResult result = run_session(scenario(), board, {});
  CHECK(result.status == SessionStatus::link_lost);
  CHECK_FALSE(result.brought_to_rest);
  REQUIRE(board.s.duty[0] > 0);
  for (int ms = 0; ms < 221; ++ms) board.step();
  CHECK(board.s.duty[0] == 0);
  CHECK(board.s.trip_cause == TRIP_SILENCE);
}

TEST_CASE("session: an exception from whoever looks on leaves the device disarmed") {
  FakeBoard board;
  SessionSettings settings;
  settings.show = [](const SessionView& view) {
    if (view.time_s >= 3.0) throw std::logic_error("broken view");
  };
  CHECK_THROWS_AS(run_session(scenario(), board, settings), std::logic_error);
  CHECK(board.s.state == DEVICE_DISARMED);
  CHECK(board.s.duty[0] == 0);
}

TEST_CASE(
    "session: commands are written at a fixed time after their deadlines, whether they were computed in no time or in a millisecond") {
  struct Timed : FakeBoard {
    std::vector<std::int64_t> sent_us;
    std::int64_t send(std::span<const std::uint8_t> bytes) override {
      if (s.state == DEVICE_ARMED) sent_us.push_back(now_us);
      return FakeBoard::send(bytes);
    }
  };
  Timed board;
  SessionSettings settings;
  int asked = 0;
  settings.should_stop = [&](std::int64_t) {
    if (++asked % 3 == 0) board.step();  // its clock goes on while the session computes
    return false;
  };
  REQUIRE(run_session(scenario(), board, settings).status == SessionStatus::finished);
  REQUIRE(board.sent_us.size() > 150);
  // But for those until it said that it is armed, and those that bring it to rest.
  for (std::size_t k = 3; k + 4 < board.sent_us.size(); ++k) {
    CAPTURE(k);
    CHECK(board.sent_us[k + 1] - board.sent_us[k] == 50'000);
  }
}

TEST_CASE("session: who runs it can stop it, and the limb is at rest then") {
  FakeBoard board;
  SessionSettings settings;
  settings.should_stop = [](std::int64_t tick) { return tick == 33; };
  const SessionResult result = run_session(scenario(), board, settings);
  CHECK(result.status == SessionStatus::stopped);
  CHECK(result.ticks == 34);
  CHECK(board.s.state == DEVICE_DISARMED);
}

TEST_CASE("session: a period longer than 0.2 s, or shorter than 5 ms, is an error, and the board hears nothing") {
  for (const double period_s : {0.21, 1.0, 60.0, 0.004}) {
    FakeBoard board;
    CAPTURE(period_s);
    CHECK_THROWS_WITH_AS(run_session(scenario("{ duty_A: { constant: { value_fraction: 0.2 } } }", period_s), board, {}),
                         doctest::Contains("sample_period_s"), sim::InputError);
    CHECK(board.session == 0);
  }
}

TEST_CASE("session: who stops it in the middle of a period has zero duty at the next repetition, not at the end of the period") {
  for (const int part : {1, 2, 3}) {  // of four in 0.2 s
    FakeBoard board;
    SessionSettings settings;
    int asked = 0;
    std::int64_t stopped_us = 0;
    settings.should_stop = [&](std::int64_t tick) {
      stopped_us = board.now_us;
      return asked++ == 4 * 15 + part && tick == 15;
    };
    const SessionResult result = run_session(scenario("{ duty_A: { constant: { value_fraction: 0.3 } } }", 0.2), board, settings);
    CHECK(result.status == SessionStatus::stopped);
    CHECK(result.brought_to_rest);
    CHECK(result.ticks == 16);
    CHECK(board.last_on_us >= stopped_us);
    CHECK(board.last_on_us <= stopped_us + 2000);
    const sim::Recording recording =
        sim::parse_recording(result.recording_csv, "recording.csv", sim::columns_of(scenario().plant.system()));
    CHECK(recording.samples.back().inputs[0] == 0.3);  // of the part that was begun
  }
}

TEST_CASE("session: the host's supervisor looks at every repetition: a word that cannot be ends the duty in the middle of a period") {
  FakeBoard board;
  // The device believes what it shows (its own fault is found by the next 105 ms); the wire shows the host other bits.
  bool garbled = false;
  std::int64_t since_us = 0;
  TamperedLink link(board, nullptr, [&](Bytes wire, std::int64_t now_us) -> std::vector<Bytes> {
    frame_decoder decoder;
    frame_decoder_start(&decoder, &board.parts);
    frame in;
    for (const std::uint8_t byte : wire)
      if (frame_decoder_take(&decoder, byte, &in) == FRAME_READY && in.type == FRAME_TELEMETRY && now_us > 3'010'000) {
        message_telemetry said{};
        get_telemetry(&in, &board.parts, &said);
        said.thermocouple_raw[0] = 0xffffffffu;
        put_telemetry(&in, &board.parts, &said);
        wire.resize(FRAME_WIRE_MOST);
        wire.resize(frame_encode(&in, wire.data()));
        if (!std::exchange(garbled, true)) since_us = now_us;
      }
    return {wire};
  });
  const SessionResult result = run_session(scenario("{ duty_A: { constant: { value_fraction: 0.3 } } }", 0.2), link, {});
  CHECK(result.status == SessionStatus::objected);
  REQUIRE(since_us > 0);
  CHECK(board.last_on_us < since_us + 52'000);
}

TEST_CASE("session: a bend sensor that is unplugged ends it, or, asked to go on without, is missing in the recording") {
  for (const bool ends : {true, false}) {
    FakeBoard board;
    SessionSettings settings;
    settings.angle_faults_end = ends;
    settings.show = [&](const SessionView& view) {
      if (view.time_s >= 4.0) board.angle_raw = 0;
    };
    const SessionResult result = run_session(scenario(), board, settings);
    CAPTURE(ends);
    // Whichever of the two supervisors is first.
    CHECK((result.status == SessionStatus::finished) == !ends);
    CHECK((result.why.find("angle_range") != std::string::npos || result.why.find("a wire is off") != std::string::npos) == ends);
    CHECK(board.s.duty[0] == 0);
    const sim::Recording recording =
        sim::parse_recording(result.recording_csv, "recording.csv", sim::columns_of(scenario().plant.system()));
    CHECK(recording.samples[39].channels[2] == 12.5);
    if (!ends) CHECK(std::isnan(recording.samples[60].channels[2]));
    if (!ends) CHECK(recording.samples[60].channels[0] > 55.0);
    FakeBoard unplugged;
    unplugged.angle_raw = 0;
    if (ends) CHECK(refusal(unplugged, settings).find("bend sensor angle_range") != std::string::npos);
  }
}

TEST_CASE("session: a sample that did not come is missing in the recording, and counted") {
  FakeBoard board;
  std::int64_t frames = 0;
  TamperedLink link(board, nullptr, [&](Bytes frame, std::int64_t now_us) -> std::vector<Bytes> {
    ++frames;
    if (now_us > 4'000'000 && now_us < 4'350'000) return {};
    return {frame};
  });
  const SessionResult result = run_session(scenario(), link, {});
  CHECK(result.status == SessionStatus::finished);
  const sim::Recording recording = sim::parse_recording(result.recording_csv, "recording.csv", sim::columns_of(scenario().plant.system()));
  int missing = 0;
  for (const sim::Sample& sample : recording.samples) missing += std::isnan(sample.channels[2]);
  CHECK(missing >= 2);
  CHECK(missing <= 4);
  CHECK(result.report_json.find("\"ticks_without_telemetry\":" + std::to_string(missing)) != std::string::npos);
}

TEST_CASE("session: an overrun of a period ends it, unless that is allowed") {
  for (const bool allowed : {false, true}) {
    FakeBoard board;
    SessionSettings settings;
    settings.allow_overruns = allowed;
    settings.show = [&](const SessionView& view) {
      if (view.time_s == 3.0)
        for (int ms = 0; ms < 25; ++ms) board.step();  // at 100 Hz; less than the dead-man allows
    };
    const SessionResult result = run_session(scenario("{ duty_A: { constant: { value_fraction: 0.2 } } }", 0.01), board, settings);
    CHECK(result.status == (allowed ? SessionStatus::finished : SessionStatus::overrun));
    CHECK(board.s.state == DEVICE_DISARMED);
    CHECK(result.report_json.find("\"overruns\":1") != std::string::npos);
  }
}

TEST_CASE("session: at 10 Hz an overrun is silence to the device before it is one to the host, and ends in a trip") {
  FakeBoard board;
  SessionSettings settings;
  settings.allow_overruns = true;
  settings.show = [&](const SessionView& view) {
    if (view.time_s == 3.0)
      for (int ms = 0; ms < 210; ++ms) board.step();
  };
  const SessionResult result = run_session(scenario(), board, settings);
  CHECK(result.status == SessionStatus::tripped);
  CHECK(board.s.trip_cause == TRIP_SILENCE);
}

TEST_CASE("session: played again from its wire it gives the same recording and the same report") {
  FakeBoard board;
  LoggedLink logged(board);
  const SessionResult once = run_session(scenario(), logged, {});
  ReplayLink replay(logged.log(), "wire.bin");
  const SessionResult again = run_session(scenario(), replay, {});
  CHECK(again.recording_csv == once.recording_csv);
  CHECK(again.report_json == once.report_json);
  CHECK(replay.at_end());
  ReplayLink other(logged.log(), "wire.bin");
  CHECK_THROWS_AS(run_session(scenario("{ duty_A: { constant: { value_fraction: 0.3 } } }"), other, {}), ReplayDiffers);
}

TEST_CASE("wire log: cut off or damaged anywhere it is an error, never a crash") {
  FakeBoard board;
  LoggedLink logged(board);
  run_session(scenario("{}"), logged, {});
  const std::string log = logged.log().substr(0, 3000);
  int differs = 0, damaged = 0;
  for (std::size_t at = 0; at < log.size(); at += 7)
    for (const int kind : {0, 1}) {
      std::string bad = log;
      if (kind == 0)
        bad.resize(at);
      else
        bad[at] = static_cast<char>(bad[at] ^ (1 << at % 8));
      try {
        ReplayLink replay(bad, "wire.bin");
        run_session(scenario("{}"), replay, {});
      } catch (const ReplayDiffers&) {
        ++differs;
      } catch (const sim::InputError&) {
        ++damaged;
      } catch (const Refused&) {
        ++differs;
      } catch (const LinkLost&) {
        ++differs;
      }
    }
  CHECK(differs > 0);
  CHECK(damaged > 0);
}

TEST_CASE("clock map: a device whose crystal is 100 ppm off is followed to half a millisecond, and not stepped once it has settled") {
  ClockMap map;
  std::int64_t host_us = 5'000'000, last_us = 0;
  map.begin(0xfffff000u, host_us);
  double most_off_us = 0.0;
  std::int64_t most_step_us = 0;
  const sim::RandomStream chance(5, "latency");
  for (std::uint64_t n = 1; n < 200'000; ++n) {
    const std::int64_t device_since_us = static_cast<std::int64_t>(n) * 20'000;
    const auto made_us = static_cast<std::int64_t>(5'000'000.0 + static_cast<double>(device_since_us) * 1.0001);
    const auto late_us = static_cast<std::int64_t>(chance.uniform(n) * 2000.0);
    const std::int64_t mapped_us = map.take(static_cast<std::uint32_t>(0xfffff000u + device_since_us), made_us + late_us);
    if (n > 3000) most_off_us = std::max(most_off_us, std::abs(static_cast<double>(mapped_us - made_us)));
    if (n > 101) most_step_us = std::max(most_step_us, std::abs(mapped_us - last_us - 20'000));
    last_us = mapped_us;
  }
  CHECK(most_off_us < 1000.0);
  CHECK(most_step_us <= 60);  // of 20 ms: bent by 1000 ppm and a skew, no more
}

TEST_CASE(
    "clock map: clocks that differ by up to 1 % are followed from the first seconds on, whatever the jitter, over a minute and over five") {
  // The share of a period by which a stamp may be off: the device takes none that is 20 ms ahead, and none that is 220 ms old.
  for (const double skew : {-0.01, -0.005, -0.002, 0.002, 0.005, 0.01})
    for (const double jitter_us : {0.0, 2000.0, 16'000.0})
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        ClockMap map;
        const sim::RandomStream chance(seed, "latency");
        double most_ahead_us = 0.0, most_behind_us = 0.0;
        map.begin(0, 3000);
        for (std::uint64_t n = 1; n < 15'000; ++n) {
          const double device_us = 20'000.0 * static_cast<double>(n);
          const double arrived_us = device_us * (1.0 + skew) + chance.uniform(n) * jitter_us;
          map.take(static_cast<std::uint32_t>(device_us), static_cast<std::int64_t>(arrived_us));
          // Half a frame later, when a command is stamped.
          const double host_us = arrived_us + 10'000.0, there_us = host_us / (1.0 + skew);
          const double ahead_us = map.device_us(static_cast<std::int64_t>(host_us)) - there_us;
          most_ahead_us = std::max(most_ahead_us, ahead_us);
          most_behind_us = std::max(most_behind_us, -ahead_us);
        }
        CAPTURE(skew);
        CAPTURE(jitter_us);
        CAPTURE(seed);
        CHECK(most_ahead_us < 15'000.0);
        CHECK(most_behind_us < 25'000.0);
        CHECK(std::abs(map.skew() - skew) < 5e-4);
      }
}

TEST_CASE("session: a board whose clock is off by up to 1 % is driven for two minutes, and its stamps are neither stale nor ahead") {
  for (const double rate : {0.99, 0.995, 0.998, 1.002, 1.005, 1.01}) {
    FakeBoard board;
    board.device_rate = rate;
    sim::Scenario minutes = scenario("{ duty_A: { constant: { value_fraction: 0.0 } } }");
    minutes.duration_s = 120.0;
    const SessionResult result = run_session(minutes, board, {});
    CAPTURE(rate);
    CHECK(result.status == SessionStatus::finished);
    CHECK(board.counters[COUNT_STALE] == 0);
  }
}

TEST_CASE("clock map: neither a first frame that came late nor a line that holds frames back puts stamps ahead of the device") {
  constexpr double rate = 1.00005;  // the device's crystal against the host's
  for (const double first_late_us : {0.0, 5000.0, 16'000.0, 200'000.0})
    for (const double jitter_us : {0.0, 4000.0, 16'000.0})
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        ClockMap map;
        const sim::RandomStream chance(seed, "latency");
        std::int64_t most_ahead_us = -1'000'000;
        map.begin(0, static_cast<std::int64_t>(first_late_us));
        for (std::uint64_t n = 1; n < 3000; ++n) {
          const double device_us = 20'000.0 * static_cast<double>(n);
          const auto arrived_us = static_cast<std::int64_t>(device_us * rate + chance.uniform(n) * jitter_us);
          map.take(static_cast<std::uint32_t>(device_us), arrived_us);
          const auto there_us = static_cast<std::int64_t>(static_cast<double>(arrived_us) / rate);
          if (n > 100) most_ahead_us = std::max(most_ahead_us, static_cast<std::int64_t>(map.device_us(arrived_us)) - there_us);
        }
        CAPTURE(first_late_us);
        CAPTURE(jitter_us);
        CHECK(most_ahead_us < 1000);  // the device takes no command that is 20 ms ahead
      }
}

TEST_CASE("session: an arming whose answer is lost leaves the device disarmed") {
  FakeBoard board;
  board.swallow_answers_to = FRAME_ARM;
  CHECK_THROWS_AS(run_session(scenario(), board, {}), Refused);
  CHECK(board.s.state == DEVICE_DISARMED);
}

TEST_CASE(
    "session: a bridge that holds frames back for 50 to 80 ms each way is armed over and driven over, and tells nothing of it in time to "
    "live") {
  for (const auto& latency : {LatentLink::Latency{0, 80'000}, LatentLink::Latency{50'000, 80'000}})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      FakeBoard board;
      LatentLink link(board, latency, seed);
      const SessionResult result = run_session(scenario(), link, {});
      CAPTURE(latency.least_us);
      CAPTURE(seed);
      CHECK(result.status == SessionStatus::finished);
      CHECK(result.brought_to_rest);
      CHECK(board.s.state == DEVICE_DISARMED);
    }
}

TEST_CASE("session: a trip that comes with the last command is how the session ended") {
  FakeBoard board;
  board.trip_on_disarm = TRIP_SILENCE;
  const SessionResult result = run_session(scenario(), board, {});
  CHECK(result.status == SessionStatus::tripped);
}

TEST_CASE("session: the line's echo of what the host says is no word of the device") {
  FakeBoard board;
  board.echoes = true;
  const SessionResult result = run_session(scenario(), board, {});
  CHECK(result.status == SessionStatus::finished);
  CHECK(result.report_json.find("\"frames_missing\":0,") != std::string::npos);
}

}  // namespace hil_session_test
