// SPDX-License-Identifier: Apache-2.0
// The device's supervisor, on the host: the very code that the board runs.
#include "firmware/supervisor.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace firmware_supervisor_test {

namespace {

// The 32 bits of a MAX31855 at these temperatures, in its steps.
std::uint32_t word(double temperature_degC, double junction_degC = 25.0) {
  const auto hot = static_cast<std::int32_t>(std::lround(temperature_degC * 4.0));
  const auto cold = static_cast<std::int32_t>(std::lround(junction_degC * 16.0));
  return (static_cast<std::uint32_t>(hot & 0x3fff) << 18) | (static_cast<std::uint32_t>(cold & 0xfff) << 4);
}

// A board: a tick a millisecond, a reading every 105 ms, a command every 100 ms, and two coils that warm as they should.
struct Bench {
  supervisor s{};
  std::uint32_t now_us;
  double temperature_degC[2] = {25.0, 25.0};
  std::uint16_t commanded[2] = {0, 0};
  bool commanding = true;
  std::uint32_t replaced[2] = {0, 0};  // words instead of the amplifiers' own
  bool replacing[2] = {false, false};
  bool swapped = false;
  bool welded = false;  // coil A conducts always
  bool open = false;    // coil A does not
  double junction_degC = 25.0;
  int until_reading = 105, until_command = 1;

  explicit Bench(std::uint32_t begin_us = 0) : now_us(begin_us) { supervisor_start(&s, TRIP_NONE, now_us); }

  void armed() {
    run(230);
    REQUIRE(supervisor_arm(&s, now_us) == ANSWER_DONE);
  }
  void run(int ms) {
    for (int k = 0; k < ms; ++k) {
      now_us += 1000;
      for (int j = 0; j < 2; ++j) {
        double duty = s.duty[j] / 10000.0;
        if (j == 0 && welded) duty = 1.0;
        if (j == 0 && open) duty = 0.0;
        temperature_degC[j] += 1e-3 * (duty * 49.0 / 2.5 - 0.04 * (temperature_degC[j] - 25.0)) / 0.85;
      }
      if (commanding && --until_command <= 0) {
        until_command = 100;
        command(now_us);
      }
      supervisor_tick(&s, now_us);
      if (--until_reading == 0) {
        until_reading = 105;
        std::uint32_t raw[2];
        for (int j = 0; j < 2; ++j) raw[j] = replacing[j] ? replaced[j] : word(temperature_degC[swapped ? 1 - j : j], junction_degC);
        supervisor_reading(&s, raw, now_us);
      }
    }
  }
  command_result command(std::uint32_t stamped_us, std::uint16_t live_ms = 220) {
    message_command message{};
    std::copy_n(commanded, BOARD_COILS, message.duty);
    message.time_to_live_ms = live_ms;
    return supervisor_command(&s, &message, stamped_us, now_us);
  }
  // Milliseconds until the duty is gone; -1: it stays for that long.
  int until_off(int most_ms) {
    for (int ms = 0; ms < most_ms; ++ms) {
      if (s.duty[0] == 0 && s.duty[1] == 0) return ms;
      run(1);
    }
    return -1;
  }
};

Bench heating(std::uint16_t duty_a = 6000) {
  Bench bench;
  bench.armed();
  bench.commanded[0] = duty_a;
  bench.run(1500);
  REQUIRE(bench.s.state == DEVICE_ARMED);
  REQUIRE(bench.s.duty[0] == duty_a);
  return bench;
}

}  // namespace

TEST_CASE("device supervisor: it does not arm before both thermocouples have spoken") {
  Bench bench;
  CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_SENSOR);
  bench.run(106);
  CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_DONE);
}

TEST_CASE("device supervisor: ten minutes of heating and cooling within the limits trip nothing") {
  Bench bench;
  bench.armed();
  for (int k = 0; k < 30; ++k) {
    bench.commanded[0] = k % 2 ? 0 : 6000;
    bench.commanded[1] = k % 2 ? 5000 : 0;
    bench.run(5000);
    bench.commanded[0] = bench.commanded[1] = 0;
    bench.run(15000);
  }
  CHECK(bench.s.state == DEVICE_ARMED);
}

TEST_CASE("device supervisor: full duty over the supply's tolerance does not look like a broken sensor") {
  Bench bench;
  bench.armed();
  bench.commanded[0] = 7000;
  bench.run(4000);  // to about 80 degC
  CHECK(bench.s.state == DEVICE_ARMED);
  CHECK(bench.temperature_degC[0] > 75.0);
}

TEST_CASE("device supervisor: silence takes the duty away at the command's time to live, not a period later") {
  Bench bench = heating();
  while (bench.until_command != 100) bench.run(1);  // right after a command
  bench.commanding = false;
  const int ms = bench.until_off(1000);
  CHECK(ms >= 219);
  CHECK(ms <= 221);
  CHECK(bench.s.trip_cause == TRIP_SILENCE);
}

TEST_CASE("device supervisor: a shorter time to live is kept, a longer one is not given") {
  for (const std::uint16_t asked : {50, 1000}) {
    Bench bench = heating();
    bench.commanding = false;
    bench.command(bench.now_us, asked);
    const int ms = bench.until_off(1000);
    CHECK(ms <= (asked == 50 ? 51 : 221));
    CHECK(ms >= (asked == 50 ? 49 : 219));
  }
}

TEST_CASE("device supervisor: after silence the next command does not arm it again") {
  Bench bench = heating();
  bench.commanding = false;
  bench.run(400);
  REQUIRE(bench.s.state == DEVICE_TRIPPED);
  CHECK(bench.command(bench.now_us) == COMMAND_NOT_ARMED);
  CHECK(bench.s.duty[0] == 0);
  CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_TRIPPED);
}

TEST_CASE("device supervisor: one lost command in a row of them is no silence") {
  Bench bench = heating();
  bench.until_command += 100;
  bench.run(1000);
  CHECK(bench.s.state == DEVICE_ARMED);
}

TEST_CASE("device supervisor: a command that is older than its time to live is stale, and so is one from the future") {
  Bench bench = heating();
  CHECK(bench.command(bench.now_us - 219000) == COMMAND_TAKEN);
  CHECK(bench.command(bench.now_us - 220000) == COMMAND_STALE);
  CHECK(bench.command(bench.now_us - 3000000) == COMMAND_STALE);
  CHECK(bench.command(bench.now_us + 19000) == COMMAND_TAKEN);
  CHECK(bench.command(bench.now_us + 21000) == COMMAND_STALE);
}

TEST_CASE("device supervisor: an old stamp leaves what is left of the time, a stamp ahead gives no more than all of it") {
  Bench late = heating();
  late.commanding = false;
  late.command(late.now_us - 150000);
  CHECK(std::abs(late.until_off(1000) - 70) <= 1);
  Bench ahead = heating();
  ahead.commanding = false;
  ahead.command(ahead.now_us + 15000);
  CHECK(std::abs(ahead.until_off(1000) - 220) <= 1);
}

TEST_CASE("device supervisor: more duty than the highest is dropped whole, and what was held stays") {
  Bench bench = heating(3000);
  bench.commanded[1] = 7001;
  bench.commanded[0] = 100;
  CHECK(bench.command(bench.now_us) == COMMAND_TOO_MUCH);
  CHECK(bench.s.duty[0] == 3000);
}

TEST_CASE("device supervisor: a coil that gets too hot trips it before the limit") {
  Bench bench;
  bench.armed();
  bench.commanded[0] = 3500;
  int ms = 0;
  while (bench.s.state == DEVICE_ARMED && ms < 60000) bench.run(1), ++ms;
  // Which of the two comes first depends on the duty; at this one it is the temperature.
  CHECK(bench.s.trip_cause == TRIP_OVER_TEMPERATURE);
  CHECK(bench.temperature_degC[0] < LIMIT_COIL_cdegC / 100.0);
}

TEST_CASE("device supervisor: what the amplifier says of its thermocouple trips it at the next reading") {
  struct {
    std::uint32_t raw;
    trip_cause cause;
  } const cases[] = {{word(60) | 0x00010001u, TRIP_SENSOR_OPEN},
                     {word(60) | 0x00010002u, TRIP_SENSOR_SHORT_TO_GROUND},
                     {word(60) | 0x00010004u, TRIP_SENSOR_SHORT_TO_SUPPLY},
                     {0x00000000u, TRIP_SENSOR_ZEROS},
                     {0xffffffffu, TRIP_SENSOR_ONES},
                     {word(60) | 0x00020000u, TRIP_SENSOR_GARBLED},
                     {word(60) | 0x00000008u, TRIP_SENSOR_GARBLED},
                     {word(60) | 0x00010000u, TRIP_SENSOR_GARBLED},
                     {word(-40), TRIP_SENSOR_RANGE},
                     {word(350), TRIP_SENSOR_RANGE},
                     {word(25), TRIP_SENSOR_JUMP},
                     {word(41, 70), TRIP_JUNCTION}};
  for (const auto& one : cases) {
    Bench bench = heating();
    bench.replacing[0] = true;
    bench.replaced[0] = one.raw;
    const int ms = bench.until_off(500);
    CAPTURE(one.raw);
    CHECK(bench.s.trip_cause == one.cause);
    CHECK(ms >= 0);
    CHECK(ms <= 105);
  }
}

TEST_CASE("device supervisor: a cold junction that jumps is not believed, though both readings are in range") {
  Bench bench = heating();
  bench.junction_degC = 29.0;
  CHECK(bench.until_off(500) >= 0);
  CHECK(bench.s.trip_cause == TRIP_JUNCTION);
}

TEST_CASE("device supervisor: a reading that sticks under duty trips it") {
  Bench bench = heating();
  bench.replacing[0] = true;
  bench.replaced[0] = bench.s.thermocouple[0].raw;
  const int ms = bench.until_off(5000);
  CHECK(ms >= 0);
  CHECK(ms < 1700);  // 0.8 s of full duty at 0.6, and a reading
  // From 1.5 s of heating on; 0.6 * 23 K/s * 1.7 s more.
  CHECK(bench.temperature_degC[0] < 25.0 + 3.2 * 13.8);
}

TEST_CASE("device supervisor: it sticks at low duty too, later") {
  Bench bench = heating(1500);
  bench.replacing[0] = true;
  bench.replaced[0] = bench.s.thermocouple[0].raw;
  CHECK(bench.until_off(10000) >= 0);
  CHECK(bench.s.trip_cause == TRIP_SENSOR_STUCK);
}

TEST_CASE("device supervisor: a reading that does not change without duty is a cold limb") {
  Bench bench;
  bench.armed();
  bench.run(60000);
  CHECK(bench.s.state == DEVICE_ARMED);
}

TEST_CASE("device supervisor: exchanged thermocouples are found when one coil is heated") {
  Bench bench;
  bench.swapped = true;
  bench.armed();
  bench.commanded[0] = 6000;
  const double before_degC = bench.temperature_degC[0];
  int ms = 0;
  while (bench.s.state == DEVICE_ARMED && ms < 10000) bench.run(1), ++ms;
  CHECK((bench.s.trip_cause == TRIP_NOT_FOLLOWING || bench.s.trip_cause == TRIP_UNEXPECTED_HEATING));
  CHECK(bench.temperature_degC[0] - before_degC < 25.0);
}

TEST_CASE("device supervisor: a coil that is heated and stays cold is not following") {
  Bench bench;
  bench.open = true;
  bench.armed();
  bench.commanded[0] = 6000;
  int ms = 0;
  while (bench.s.state == DEVICE_ARMED && ms < 10000) bench.run(1), ++ms;
  CHECK(bench.s.trip_cause == TRIP_NOT_FOLLOWING);
}

TEST_CASE("device supervisor: a welded switch is said, armed or not, though no software can open it") {
  Bench disarmed;
  disarmed.run(300);
  disarmed.welded = true;
  disarmed.run(1500);
  CHECK(disarmed.s.trip_cause == TRIP_UNEXPECTED_HEATING);
  Bench armed;
  armed.armed();
  armed.welded = true;
  armed.run(1500);
  CHECK(armed.s.trip_cause == TRIP_UNEXPECTED_HEATING);
}

TEST_CASE("device supervisor: too fast a rise trips it") {
  Bench bench;
  bench.armed();
  bench.commanded[0] = 7000;
  bench.run(1500);
  double shown_degC = bench.s.thermocouple[0].temperature_cdegC / 100.0;
  bench.replaced[0] = bench.s.thermocouple[0].raw;
  bench.replacing[0] = true;
  for (int k = 0; k < 12 && bench.s.state == DEVICE_ARMED; ++k) {
    bench.replaced[0] = word(shown_degC += 5.0);  // 48 K/s
    bench.run(105);
  }
  CHECK(bench.s.trip_cause == TRIP_RATE_OF_RISE);
}

TEST_CASE("device supervisor: so much duty in the window and no more") {
  Bench bench;
  bench.junction_degC = -5.0;
  bench.replacing[0] = true;  // a thermocouple that shows what is expected at least, so that only the clock can see it
  bench.replaced[0] = word(25.0, -5.0);
  bench.armed();
  double shown_degC = 25.0;
  bench.commanded[0] = 1000;
  bench.commanded[1] = 0;
  bench.run(1000);
  bench.commanded[0] = 4600;
  int ms = 0;
  while (bench.s.state == DEVICE_ARMED && ms < 40000) {
    shown_degC = std::min(130.0, shown_degC + 0.75);
    bench.replaced[0] = word(shown_degC + (ms % 2 ? 0.25 : 0.0), -5.0);
    bench.run(105);
    ms += 105;
  }
  CHECK(bench.s.trip_cause == TRIP_ON_TIME);
  CHECK(ms / 1000.0 * 0.46 < LIMIT_ON_TIME_ms / 1000.0 + 0.6);
}

TEST_CASE("device supervisor: amplifiers that are not read any more trip it") {
  Bench bench = heating();
  bench.until_reading = 100000;
  const int ms = bench.until_off(1000);
  CHECK(ms >= 0);
  CHECK(ms <= 240);
  CHECK(bench.s.trip_cause == TRIP_SENSOR_SILENT);
}

TEST_CASE("device supervisor: clearing wants the cause by name, cool coils and sensors that are believed") {
  Bench bench = heating();
  bench.run(2500);  // warm
  supervisor_trip(&bench.s, TRIP_SILENCE);
  CHECK(supervisor_clear_trip(&bench.s, TRIP_SENSOR_OPEN) == ANSWER_OTHER_CAUSE);
  CHECK(supervisor_clear_trip(&bench.s, TRIP_SILENCE) == ANSWER_HOT);
  bench.run(60000);
  bench.replacing[0] = true;
  bench.replaced[0] = 0;
  bench.run(106);
  CHECK(supervisor_clear_trip(&bench.s, TRIP_SILENCE) == ANSWER_SENSOR);
  bench.replacing[0] = false;
  bench.run(211);
  CHECK(supervisor_clear_trip(&bench.s, TRIP_SILENCE) == ANSWER_DONE);
  CHECK(bench.s.state == DEVICE_DISARMED);
  CHECK(bench.command(bench.now_us) == COMMAND_NOT_ARMED);
  CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_DONE);
  CHECK(bench.s.duty[0] == 0);
}

TEST_CASE("device supervisor: the first cause is kept") {
  Bench bench = heating();
  supervisor_trip(&bench.s, TRIP_SENSOR_OPEN);
  supervisor_trip(&bench.s, TRIP_SILENCE);
  CHECK(bench.s.trip_cause == TRIP_SENSOR_OPEN);
}

TEST_CASE("device supervisor: a latched cause is a trip from the start") {
  supervisor s{};
  supervisor_start(&s, TRIP_WATCHDOG, 0);
  CHECK(s.state == DEVICE_TRIPPED);
  CHECK(s.trip_cause == TRIP_WATCHDOG);
}

TEST_CASE("device supervisor: the clock may wrap in the middle of a session") {
  Bench bench(0xffffffffu - 3'000'000u);
  bench.armed();
  bench.commanded[0] = 5000;
  bench.run(6000);
  CHECK(bench.s.state == DEVICE_ARMED);
  CHECK(bench.now_us < 10'000'000u);
  bench.commanding = false;
  const int ms = bench.until_off(1000);
  CHECK(ms >= 0);
  CHECK(ms <= 221);
}

}  // namespace firmware_supervisor_test
