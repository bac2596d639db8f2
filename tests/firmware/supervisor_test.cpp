// SPDX-License-Identifier: Apache-2.0
// The device's supervisor, on the host: the very code that the board runs.
#include "firmware/supervisor.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hil/heat_bound.h"
#include "sim/random.h"

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
  double power = 1.0;  // against the nominal one: (supply / 7 V)^2
  double lag_s = 0.0;  // of both thermocouples
  double lagged_degC[2] = {25.0, 25.0};
  double loss = 1.0;         // of heat, against the nominal one
  double shown_share = 1.0;  // of the rise, by both thermocouples
  double noise_K = 0.0;      // of every reading, white
  std::uint64_t reading = 0;
  int angle_raw = -1;  // -1: a limb that bends as coil A gets warm and back as B does
  bool dividers = false;
  double supply_V = 7.0;
  int stuck_tenths = 0;  // of each PWM period, coil B's gate is on, whatever its pin says
  bool blind = false;    // the converter stands still
  int away_ms = 0;       // of every 10 ms the main loop is away for so long, and finds the samples afterwards
  board_drain shown[BOARD_COILS] = {};
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
        temperature_degC[j] += 1e-3 * (power * duty * 49.0 / 2.5 - loss * 0.04 * (temperature_degC[j] - 25.0)) / 0.85;
      }
      for (int j = 0; j < 2; ++j) lagged_degC[j] += (temperature_degC[j] - lagged_degC[j]) * (lag_s > 0.0 ? 1e-3 / lag_s : 1.0);
      if (commanding && --until_command <= 0) {
        until_command = 100;
        command(now_us);
      }
      supervisor_tick(&s, now_us);
      if (dividers) look_at_drains();
      if (--until_reading == 0) {
        until_reading = 105;
        std::uint32_t raw[2];
        for (int j = 0; j < 2; ++j) {
          const double noise = noise_K * sinew::sim::RandomStream(7, j == 0 ? "A" : "B").normal(reading);
          raw[j] = replacing[j] ? replaced[j] : word(shown_degC(swapped ? 1 - j : j) + noise, junction_degC);
        }
        ++reading;
        supervisor_reading(&s, raw, now_us);
        const auto bent = static_cast<int>(8184 + 100.0 * (temperature_degC[0] - temperature_degC[1]));
        const auto angle = static_cast<std::uint16_t>(angle_raw >= 0 ? angle_raw : std::clamp(bent, 500, 15'000));
        supervisor_angles(&s, &angle);
      }
    }
  }
  // PWM of 100 Hz that begins with its gate on.
  void look_at_drains() {
    const int tenth = static_cast<int>(now_us / 1000 % 10);
    for (int j = 0; j < 2; ++j) {
      const bool on = j == 1 && stuck_tenths > 0 ? tenth < stuck_tenths : tenth * 1000 < s.duty[j];
      const bool low = on || (j == 0 && (welded || open));
      shown[j].samples = static_cast<std::uint8_t>(shown[j].samples + !blind);
      shown[j].low = static_cast<std::uint8_t>(shown[j].low + (low && !blind));
      if (!low && !blind) shown[j].highest_cV = static_cast<std::uint16_t>(std::lround(supply_V * 100.0));
    }
    if (tenth < away_ms) return;
    supervisor_drains(&s, shown);
    std::fill_n(shown, BOARD_COILS, board_drain{});
  }
  double shown_degC(int coil) const { return 25.0 + shown_share * (lagged_degC[coil] - 25.0); }
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

TEST_CASE("device supervisor: it does not arm a board whose brown-out level or watchdog is wrong, tripped or not") {
  for (const std::uint8_t wrong : {SETTING_BROWN_OUT, SETTING_WATCHDOG}) {
    Bench bench;
    bench.s.wrong_settings = wrong;
    bench.run(230);
    CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_SETTINGS);
    CHECK(bench.s.state == DEVICE_DISARMED);
    supervisor_trip(&bench.s, TRIP_SILENCE);
    CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_SETTINGS);
    CHECK(supervisor_clear_trip(&bench.s, TRIP_SILENCE) == ANSWER_DONE);
    bench.s.wrong_settings = 0;
    CHECK(supervisor_arm(&bench.s, bench.now_us) == ANSWER_DONE);
  }
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
  CHECK(bench.s.trip_cause == TRIP_NONE);
  CHECK(bench.s.state == DEVICE_ARMED);
}

TEST_CASE("device supervisor: noise of 3 K trips nothing in twenty minutes of heating, holding and cooling") {
  for (const double noise_K : {1.5, 3.0}) {
    Bench bench;
    bench.noise_K = noise_K;
    bench.armed();
    for (int k = 0; k < 20; ++k) {
      bench.commanded[k % 2] = 4500;
      bench.run(5000);
      bench.commanded[k % 2] = 1200;
      bench.run(25'000);
      bench.commanded[k % 2] = 0;
      bench.run(30'000);
    }
    CAPTURE(noise_K);
    CHECK(bench.s.state == DEVICE_ARMED);
    CHECK(bench.s.trip_cause == TRIP_NONE);
  }
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
  bench.power = 1.8;  // more than the bound of the coil's heat allows for: 9.4 V
  bench.armed();
  bench.commanded[0] = 2000;
  int ms = 0;
  while (bench.s.state == DEVICE_ARMED && ms < 60000) bench.run(1), ++ms;
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
                     {word(80), TRIP_SENSOR_JUMP},
                     {word(10), TRIP_SENSOR_JUMP},
                     {word(41, 70), TRIP_JUNCTION},
                     {word(41, -11), TRIP_JUNCTION}};
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
  for (const double junction_degC : {21.0, 29.0}) {
    Bench bench = heating();
    bench.junction_degC = junction_degC;
    CHECK(bench.until_off(500) >= 0);
    CHECK(bench.s.trip_cause == TRIP_JUNCTION);
  }
}

TEST_CASE("device supervisor: two readings at one moment are no division by zero, and trip nothing") {
  Bench bench;
  bench.armed();
  const std::uint32_t raw[BOARD_COILS] = {word(25.0), word(25.0)};
  supervisor_reading(&bench.s, raw, bench.now_us);
  supervisor_reading(&bench.s, raw, bench.now_us);
  CHECK(bench.s.state == DEVICE_ARMED);
}

TEST_CASE("device supervisor: a reading at the limit trips though its line falls: hotter than the limit is too hot") {
  Bench bench;
  bench.armed();
  for (const double shown_degC : {290.0, 276.0, 262.0, 248.0, 234.0, 220.0, 206.0, 192.0, 178.0, 164.0, 151.0}) {
    bench.s.state = DEVICE_ARMED;  // as if nobody had tripped before
    const std::uint32_t raw[BOARD_COILS] = {word(shown_degC), word(25.0)};
    bench.now_us += 105'000;
    supervisor_reading(&bench.s, raw, bench.now_us);
    CAPTURE(shown_degC);
    CHECK(bench.s.state == DEVICE_TRIPPED);
  }
}

TEST_CASE("device supervisor: a main loop that was away for a second has all the heat of it in its bound, and half a second of its loss") {
  Bench bench = heating(5000);
  const double before_K = bench.s.bound_uK[0] / 1e6;
  bench.now_us += 1'000'000;
  supervisor_tick(&bench.s, bench.now_us);
  // By hand: 0.5 * 30.1 K/s over a second, less 0.045 1/s of what was there over half of one.
  CHECK(bench.s.bound_uK[0] / 1e6 == doctest::Approx(before_K + 15.05 - 0.5 * 0.045 * before_K).epsilon(0.01));
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

TEST_CASE(
    "device supervisor: a coil held in equilibrium for an hour, without noise, is no stuck reading; nor with other losses or a heat sink") {
  for (const double loss : {0.8, 1.0, 1.4})
    for (const double shown_share : {0.7, 1.0})
      for (const std::uint16_t duty : {200, 500, 1000, 1500}) {
        if (shown_share / loss < 0.65) continue;  // beyond what is allowed for
        Bench bench;
        bench.loss = loss;
        bench.shown_share = shown_share;
        bench.armed();
        bench.commanded[0] = duty;
        bench.run(duty == 1000 ? 3'600'000 : 400'000);
        CAPTURE(loss);
        CAPTURE(shown_share);
        CAPTURE(duty);
        CHECK(bench.s.state == DEVICE_ARMED);
      }
}

TEST_CASE("device supervisor: thermocouples that lag by up to 2 s are followed through duty that goes on and off, and trip nothing") {
  for (const double lag_s : {0.5, 1.0, 2.0})
    for (const std::uint16_t duty : {500, 1500, 4500, 7000}) {
      Bench bench;
      bench.lag_s = lag_s;
      bench.armed();
      const int on_ms = static_cast<int>(4000.0 * 4500.0 / std::max<double>(duty, 4500.0));
      for (int k = 0; k < 30 && bench.s.state == DEVICE_ARMED; ++k) {
        bench.commanded[0] = k % 2 ? std::uint16_t{0} : duty;
        bench.run(k % 2 ? 20'000 : on_ms);
      }
      CAPTURE(lag_s);
      CAPTURE(duty);
      CHECK(bench.s.state == DEVICE_ARMED);
      CHECK(bench.s.trip_cause == TRIP_NONE);
    }
}

TEST_CASE("device supervisor: exchanged thermocouples are found when one coil is heated") {
  Bench bench;
  bench.swapped = true;
  bench.armed();
  bench.commanded[0] = 6000;
  const double before_degC = bench.temperature_degC[0];
  int ms = 0;
  while (bench.s.state == DEVICE_ARMED && ms < 10000) bench.run(1), ++ms;
  // Which of the three depends on noise, of which there is none here.
  CHECK((bench.s.trip_cause == TRIP_NOT_FOLLOWING || bench.s.trip_cause == TRIP_UNEXPECTED_HEATING ||
         bench.s.trip_cause == TRIP_SENSOR_STUCK));
  CHECK(bench.temperature_degC[0] - before_degC < 25.0);
}

TEST_CASE("device supervisor: a coil that is heated and stays cold is not following") {
  Bench bench;
  bench.open = true;
  bench.armed();
  bench.commanded[0] = 6000;
  int ms = 0;
  for (; bench.s.state == DEVICE_ARMED && ms < 10000; ++ms) {
    bench.temperature_degC[0] = ms / 105 % 2 ? 25.25 : 25.0;  // noise: it does not stick
    bench.run(1);
  }
  CHECK(bench.s.trip_cause == TRIP_NOT_FOLLOWING);
}

TEST_CASE("device supervisor: a welded switch is said, armed or not, though no software can open it") {
  Bench disarmed;
  disarmed.run(300);
  disarmed.welded = true;
  disarmed.run(1900);
  CHECK(disarmed.s.trip_cause == TRIP_UNEXPECTED_HEATING);
  Bench armed;
  armed.armed();
  armed.welded = true;
  armed.run(1900);
  CHECK(armed.s.trip_cause == TRIP_UNEXPECTED_HEATING);
}

TEST_CASE(
    "device supervisor: two errors that hide each other, too much power and readings that are too low, heat no coil beyond its limit") {
  struct {
    double power, shown_share;
  } const pairs[] = {{64.0 / 49.0, 0.8}, {1.3, 0.7}, {1.3, 0.65}, {1.3, 0.6}, {1.3, 0.3}};
  for (const auto& [power, shown_share] : pairs)
    for (const std::uint16_t duty : {2500, 4500, 7000}) {
      Bench bench;
      bench.power = power;
      bench.shown_share = shown_share;
      bench.armed();
      double hottest_degC = 0.0;
      // A host that holds what is shown at its own limit, by on and off; a trip ends it.
      for (int ms = 0; ms < 120'000 && bench.s.state == DEVICE_ARMED; ++ms) {
        bench.commanded[0] = bench.shown_degC(0) < LIMIT_HOST_cdegC / 100.0 ? duty : std::uint16_t{0};
        bench.run(1);
        hottest_degC = std::max(hottest_degC, bench.temperature_degC[0]);
      }
      CAPTURE(power);
      CAPTURE(shown_share);
      CAPTURE(duty);
      CHECK(hottest_degC < LIMIT_COIL_cdegC / 100.0);
    }
}

TEST_CASE("device supervisor: the bound of a coil's heat is above the warmest coil that is allowed for, at every moment, and near it") {
  Bench bench;
  bench.power = 64.0 / 49.0;
  bench.run(60'000);  // disarmed: what it begins with goes away
  bench.armed();
  double least_K = 1e9, most_K = 0.0;
  for (int ms = 0; ms < 40'000; ++ms) {
    bench.commanded[0] = ms < 7000 || ms > 30'000 ? 3000 : 0;
    bench.run(1);
    REQUIRE(bench.s.state == DEVICE_ARMED);
    const double above_K = bench.s.bound_uK[0] / 1e6 - (bench.temperature_degC[0] - 25.0);
    least_K = std::min(least_K, above_K);
    most_K = std::max(most_K, above_K);
  }
  // The bound is brought up to date every 10 ms: at duty 0.3 that is 0.09 K.
  CHECK(least_K > -0.1);
  CHECK(most_K < 10.0);
}

TEST_CASE("device supervisor: the bound at its limit is a trip, whatever is shown, and cools while nothing is known to be on") {
  Bench bench;
  bench.armed();
  bench.commanded[0] = 2600;
  bench.shown_share = 0.5;
  for (int ms = 0; bench.s.state == DEVICE_ARMED && ms < 60'000; ++ms) bench.run(1);
  CHECK(bench.s.trip_cause == TRIP_HEAT_BOUND);
  const std::uint32_t then_uK = bench.s.bound_uK[0];
  CHECK(then_uK > 125'000'000u);
  CHECK(then_uK < 125'200'000u);
  bench.run(22'222);  // 1 / (0.045 1/s): by hand, exp(-1) of it is left
  CHECK(bench.s.bound_uK[0] / 1e6 == doctest::Approx(then_uK / 1e6 * std::exp(-1.0)).epsilon(0.001));
}

TEST_CASE(
    "device supervisor: a bend sensor at 0 or 5 V trips it at the next reading, and does not let it arm; asked not to, it says so only") {
  for (const int raw : {0, 159, 16'209, 16'368}) {
    CAPTURE(raw);
    Bench bench = heating();
    bench.angle_raw = raw;
    const int ms = bench.until_off(500);
    CHECK(bench.s.trip_cause == TRIP_ANGLE_RANGE);
    CHECK(ms >= 0);
    CHECK(ms <= 105);
    Bench before;
    before.angle_raw = raw;
    before.run(230);
    CHECK(supervisor_arm(&before.s, before.now_us) == ANSWER_SENSOR);
    before.s.angle_faults_trip = 0;
    CHECK(supervisor_arm(&before.s, before.now_us) == ANSWER_DONE);
    before.run(2000);
    CHECK(before.s.state == DEVICE_ARMED);
    CHECK(before.s.angle[0].fault == TRIP_ANGLE_RANGE);
  }
}

TEST_CASE("device supervisor: a bend sensor that stays where heat must have moved it trips; where both coils are warm it may stay") {
  Bench stuck;
  stuck.armed();
  stuck.commanded[0] = 4500;
  stuck.angle_raw = 8184;
  int ms = 0;
  for (; stuck.s.state == DEVICE_ARMED && ms < 20'000; ++ms) {
    stuck.angle_raw = 8184 + ms % 20;  // noise of the converter
    stuck.run(1);
  }
  CHECK(stuck.s.trip_cause == TRIP_ANGLE_STUCK);
  CHECK(stuck.temperature_degC[0] < 25.0 + 60.0 + 3.0);
  Bench held;
  held.armed();
  held.commanded[0] = held.commanded[1] = 4500;
  held.angle_raw = 8184;
  held.run(7000);
  CHECK(held.temperature_degC[0] > 25.0 + 60.0);
  CHECK(held.s.state == DEVICE_ARMED);
  Bench against;  // the other is warm by less, and may hold it too
  against.armed();
  against.commanded[0] = 4500;
  against.commanded[1] = 1700;
  against.angle_raw = 8184;
  against.run(7000);
  CHECK(against.temperature_degC[0] > 25.0 + 60.0);
  CHECK(against.temperature_degC[1] < 25.0 + 60.0);
  CHECK(against.s.state == DEVICE_ARMED);
}

TEST_CASE("heat bound: against the exact solution, over steps of 10, 50 and 320 ms, it is never below by more than the loss of a step") {
  // dT/dt = u H - c T by hand: T = u H / c (1 - exp(-c t)); H = 30.1 K/s, c = 0.045 1/s, u = 0.2: 133.8 K at the end.
  for (const std::uint16_t step_ms : {10, 50, 320}) {
    std::uint32_t rise_uK = 0;
    for (std::uint32_t k = 1; k * step_ms <= 64'000; ++k) {
      rise_uK = heat_bound_after(rise_uK, 2000u * step_ms, step_ms);
      const double exact_K = 0.2 * 30.1 / 0.045 * (1.0 - std::exp(-0.045 * k * step_ms / 1e3));
      CAPTURE(step_ms);
      REQUIRE(rise_uK / 1e6 > exact_K - 0.01);
      REQUIRE(rise_uK / 1e6 < exact_K + 0.01 + 0.2 * 30.1 * step_ms / 1e3);
    }
  }
  CHECK(heat_bound_after(0, 10'000u * 500u, 500) == 15'050'000u);    // full duty for half a second
  CHECK(heat_bound_after(4'000'000'000u, 0, 500) < 4'000'000'000u);  // no wrap in what a bound can reach
  CHECK(heat_bound_cK(1) == 1);
  CHECK(heat_bound_cK(125'000'000u) == 12500);
  CHECK(heat_bound_cK(4'000'000'000u) == 65535);
}

TEST_CASE(
    "device supervisor, dividers: whatever the duty, a limb that is well trips nothing, though the main loop is away for 5 ms of 10") {
  for (const int away_ms : {0, 5}) {
    Bench bench;
    bench.dividers = true;
    bench.away_ms = away_ms;
    bench.armed();
    for (const int duty : {0, 100, 7000, 1000, 0, 6900, 4500, 50, 0}) {
      CAPTURE(duty);
      for (int j = 0; j < 2; ++j) bench.commanded[j] = static_cast<std::uint16_t>(duty);
      bench.run(437);
      REQUIRE(bench.s.state == DEVICE_ARMED);
      for (int j = 0; j < 2; ++j) bench.commanded[j] = 0;
      bench.run(5000);
      REQUIRE(bench.s.state == DEVICE_ARMED);
    }
  }
}

TEST_CASE(
    "device supervisor, dividers: a switch that never opens, a coil or a supply that is not there trips within 60 ms, with duty or "
    "without") {
  for (const int duty : {0, 1000, 6000, 7000}) {
    for (const int what : {0, 1, 2}) {
      CAPTURE(duty);
      CAPTURE(what);
      Bench bench = heating(static_cast<std::uint16_t>(duty));
      bench.dividers = true;
      bench.run(500);
      REQUIRE(bench.s.state == DEVICE_ARMED);
      if (what == 0) bench.welded = true;
      if (what == 1) bench.open = true;
      if (what == 2) bench.blind = true;
      int ms = 0;
      for (; bench.s.state == DEVICE_ARMED && ms < 200; ++ms) bench.run(1);
      CHECK(bench.s.trip_cause == TRIP_DRAIN_LOW);
      CHECK(ms <= 60);
    }
  }
}

TEST_CASE(
    "device supervisor, dividers: a gate that is on for 0.2 and more of the time without duty trips; that of 0.1 heats no coil beyond 80 "
    "degC") {
  for (const int tenths : {1, 2, 3, 7}) {
    CAPTURE(tenths);
    Bench bench = heating();
    bench.dividers = true;
    bench.run(500);
    bench.stuck_tenths = tenths;
    bench.run(200);
    CHECK((bench.s.trip_cause == TRIP_DRAIN_LOW) == (tenths > 1));
  }
}

TEST_CASE(
    "device supervisor, dividers: a supply above 8.5 V trips within 20 ms, one of 8.4 V does not; what is seen while the relay closes "
    "counts for nothing") {
  for (const double supply_V : {8.4, 8.6, 12.0}) {
    CAPTURE(supply_V);
    Bench bench = heating(5000);
    bench.dividers = true;
    bench.run(500);
    bench.supply_V = supply_V;
    bench.run(20);
    CHECK(bench.s.trip_cause == (supply_V > 8.5 ? TRIP_SUPPLY_HIGH : TRIP_NONE));
  }
  Bench closing;
  closing.dividers = true;
  closing.open = true;
  closing.armed();
  closing.run(LIMIT_DRAIN_SETTLING_ms - 10);
  closing.open = false;
  closing.run(1000);
  CHECK(closing.s.state == DEVICE_ARMED);
  Bench missing;
  missing.dividers = true;
  missing.open = true;
  missing.armed();
  missing.run(LIMIT_DRAIN_SETTLING_ms + LIMIT_DRAIN_LOW_ms + 2);
  CHECK(missing.s.trip_cause == TRIP_DRAIN_LOW);
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
    bench.s.bound_uK[0] = 0;  // which comes before it at any duty, as does the next where the coil cannot be hotter
    bench.s.thermocouple[0].lagged_mK = 0;
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
