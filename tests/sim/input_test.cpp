// SPDX-License-Identifier: Apache-2.0
#include "sim/input.h"

#include "plant/limb/limb.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace sim_input_test {

using namespace sinew::sim;

namespace {

// The two-coil limb's coils, inputs and thermocouples, and the channel of its angle.
constexpr std::size_t A = 0, B = 1, angle = 2;

const sinew::plant::System& system_of_two_coils() { return *sinew::plant::two_coil_limb(); }

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

// A number worked by hand differs from the program's by a few roundings.
doctest::Approx by_hand(double value) { return doctest::Approx(value).epsilon(1e-14); }

Command command_at(Driver& driver, std::int64_t tick, double angle_deg = 0.0) {
  return driver.command({tick, {25.0, 25.0, angle_deg}}, static_cast<double>(tick) / 10.0);
}

// A babbler whose setpoint is always the same: the range of angles is one angle.
BabbleInput towards(double setpoint_deg) {
  BabbleInput input;
  input.lowest_deg = input.highest_deg = setpoint_deg;
  return input;
}

template <class One>
double at(const One& signal, double time_s) {
  return signal.at(time_s, RandomStream(1, "duty_A"));
}

Sample sample(double time_s, double a, double b) { return {time_s, {a, b}, {20.0, 20.0, 0.0}}; }

}  // namespace

TEST_CASE("babble: the PI law, by hand") {
  const Input input = towards(30.0);
  Driver driver(system_of_two_coils(), input, 1, 0.1);
  // e = 30 - 25 = 5 deg; sum of e dt = 0.5 deg s; u = 0.06 * 5 + 1e-5 * 0.5.
  CHECK(command_at(driver, 0, 25.0).inputs[A] == by_hand(0.300005));
  // e = 2; sum = 0.5 + 0.2; u = 0.12 + 0.7e-5.
  CHECK(command_at(driver, 1, 28.0).inputs[A] == by_hand(0.120007));
  // e = -4; sum = 0.3; u = -0.24 + 0.3e-5.
  const Command past = command_at(driver, 2, 34.0);
  CHECK(past.inputs[A] == 0.0);
  CHECK(past.inputs[B] == by_hand(0.239997));
  CHECK(driver.state().following[0].error_integral == by_hand(0.3));
}

TEST_CASE("babble: the integral counts in time, not in samples") {
  BabbleInput gains = towards(10.0);
  gains.proportional_gain_1_deg = 0.0;
  gains.integral_gain_1_deg_s = 0.01;
  const Input input = gains;
  Driver slow(system_of_two_coils(), input, 1, 0.5), fast(system_of_two_coils(), input, 1, 0.1);
  // After one second at an error of 10 deg: 0.01 * 10 * 1 = 0.1.
  Command last;
  for (int k = 0; k < 2; ++k) last = slow.command({k, {missing, missing, 0.0}}, 0.5 * k);
  CHECK(last.inputs[A] == by_hand(0.1));
  for (int k = 0; k < 10; ++k) last = fast.command({k, {missing, missing, 0.0}}, 0.1 * k);
  CHECK(last.inputs[A] == by_hand(0.1));
}

TEST_CASE("babble: u is cut to one, the duty to its limit, and the integral goes on") {
  BabbleInput free = towards(45.0);
  free.duty_limit_fraction = 1.0;
  const Input input = free, limited = towards(45.0);
  Driver driver(system_of_two_coils(), input, 1, 0.1), limited_driver(system_of_two_coils(), limited, 1, 0.1);
  // u = 0.06 * 45 = 2.7.
  CHECK(command_at(driver, 0).inputs[A] == 1.0);
  CHECK(command_at(limited_driver, 0).inputs[A] == 0.6);
  // u = 0.06 * 10.1 = 0.606 is cut to 0.6, u = 0.06 * 9 = 0.54 (and a little) is not.
  CHECK(command_at(limited_driver, 1, 34.9).inputs[A] == 0.6);
  CHECK(command_at(limited_driver, 2, 36.0).inputs[A] == by_hand(0.54 + 1e-5 * (4.5 + 1.01 + 0.9)));
  CHECK(limited_driver.state().following[0].error_integral == by_hand(4.5 + 1.01 + 0.9));
}

TEST_CASE("babble: positive u drives one coil, negative u the other, never both") {
  BabbleInput reversed = towards(0.0);
  reversed.positive_drives = "B";
  const Input usual = towards(0.0), other = reversed;
  Driver driver(system_of_two_coils(), usual, 1, 0.1), reversed_driver(system_of_two_coils(), other, 1, 0.1);
  CHECK(command_at(driver, 0, -20.0).inputs == std::vector<double>{0.6, 0.0});
  CHECK(command_at(driver, 1, 20.0).inputs == std::vector<double>{0.0, 0.6});
  CHECK(command_at(reversed_driver, 0, -20.0).inputs == std::vector<double>{0.0, 0.6});
  CHECK(command_at(reversed_driver, 1, 20.0).inputs == std::vector<double>{0.6, 0.0});
}

TEST_CASE("babble: at no error there is no duty") {
  const Input input = towards(12.0);
  Driver driver(system_of_two_coils(), input, 1, 0.1);
  CHECK(command_at(driver, 0, 12.0).inputs == std::vector<double>{0.0, 0.0});
}

TEST_CASE("babble: with one coil the other is never driven") {
  for (const auto driven : {A, B}) {
    BabbleInput one = towards(10.0);
    one.both_sides = false;
    one.positive_drives = driven == A ? "A" : "B";
    const Input input = one;
    Driver driver(system_of_two_coils(), input, 1, 0.1);
    for (std::int64_t tick = 0; tick < 200; ++tick) {
      const double angle_deg = 30.0 * std::sin(0.1 * static_cast<double>(tick));
      const Command command = command_at(driver, tick, angle_deg);
      CHECK(command.inputs[driven == A ? B : A] == 0.0);
      if (angle_deg < 9.0) CHECK(command.inputs[driven] > 0.0);
      if (angle_deg > 11.0) CHECK(command.inputs[driven] == 0.0);
    }
  }
}

TEST_CASE("babble: a missing angle is the last one that was there") {
  const Input input = towards(20.0);
  Driver driver(system_of_two_coils(), input, 1, 0.1), first_missing(system_of_two_coils(), input, 1, 0.1);
  CHECK(command_at(driver, 0, 15.0).inputs[A] == by_hand(0.300005));
  // e is 5 again; the sum goes on to 1.0.
  CHECK(command_at(driver, 1, missing).inputs[A] == by_hand(0.30001));
  // Before there was any, the limb is taken for straight: u = 0.06 * 20 is past the limit.
  CHECK(command_at(first_missing, 0, missing).inputs[A] == 0.6);
  CHECK_FALSE(std::isnan(first_missing.state().following[0].error_integral));
}

TEST_CASE("babble: setpoints are uniform in their range and held for times uniform in theirs") {
  const Input input = BabbleInput{};
  Driver driver(system_of_two_coils(), input, 11, 0.1);
  std::vector<double> setpoints, holds_s, observed_holds_s;
  std::optional<double> setpoint, drawn_until_s;
  double since_s = 0.0;
  constexpr std::int64_t ticks = 620000;  // about 4000 setpoints of 15.5 s
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    const double time_s = static_cast<double>(tick) / 10.0;
    command_at(driver, tick, 5.0);
    if (driver.state().following[0].setpoint == setpoint) continue;
    if (setpoint) observed_holds_s.push_back(time_s - since_s);
    setpoint = driver.state().following[0].setpoint;
    since_s = time_s;
    setpoints.push_back(*setpoint);
    holds_s.push_back(driver.state().following[0].next_setpoint_s - drawn_until_s.value_or(0.0));
    drawn_until_s = driver.state().following[0].next_setpoint_s;
  }
  const auto n = static_cast<double>(setpoints.size());
  CHECK(n == doctest::Approx(4000.0).epsilon(0.05));
  CHECK(static_cast<std::int64_t>(setpoints.size()) == driver.state().following[0].setpoints_drawn);
  const auto in = [](const std::vector<double>& values, double low, double high) {
    return std::all_of(values.begin(), values.end(), [&](double v) { return v >= low && v <= high; });
  };
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double v : values) sum += v;
    return sum / static_cast<double>(values.size());
  };
  CHECK(in(setpoints, -45.0, 45.0));
  CHECK(in(holds_s, 1.0 - 1e-9, 30.0 + 1e-9));  // differences of sums: rounding
  // A setpoint changes at the first tick that is due, so that what is seen is off by less than a period.
  CHECK(in(observed_holds_s, 1.0 - 0.1, 30.0 + 0.1));
  // Four deviations of the mean of n uniform numbers: width / sqrt(12 n).
  CHECK(std::abs(mean(setpoints)) < 4.0 * 90.0 / std::sqrt(12.0 * n));
  CHECK(std::abs(mean(holds_s) - 15.5) < 4.0 * 29.0 / std::sqrt(12.0 * n));
  // The ends are reached: among 4000, the outermost is within a hundredth of the width of the end.
  CHECK(*std::min_element(setpoints.begin(), setpoints.end()) < -44.1);
  CHECK(*std::max_element(setpoints.begin(), setpoints.end()) > 44.1);
  CHECK(*std::min_element(holds_s.begin(), holds_s.end()) < 1.3);
  CHECK(*std::max_element(holds_s.begin(), holds_s.end()) > 29.7);
}

TEST_CASE("babble: setpoints depend on the seed alone, not on what is measured") {
  const Input input = BabbleInput{};
  Driver one(system_of_two_coils(), input, 5, 0.1), other(system_of_two_coils(), input, 5, 0.1),
      another_seed(system_of_two_coils(), input, 6, 0.1);
  bool same = true, different = false;
  for (std::int64_t tick = 0; tick < 2000; ++tick) {
    command_at(one, tick, 0.0);
    command_at(other, tick, 40.0 * std::sin(static_cast<double>(tick)));
    command_at(another_seed, tick, 0.0);
    same = same && one.state().following[0].setpoint == other.state().following[0].setpoint;
    different = different || one.state().following[0].setpoint != another_seed.state().following[0].setpoint;
  }
  CHECK(same);
  CHECK(different);
}

TEST_CASE("driver: goes on from its state as if it had not stopped") {
  const Input input = BabbleInput{};
  Driver whole(system_of_two_coils(), input, 5, 0.1), first(system_of_two_coils(), input, 5, 0.1),
      second(system_of_two_coils(), input, 5, 0.1);
  for (std::int64_t tick = 0; tick < 1000; ++tick) {
    const double angle_deg = 40.0 * std::sin(0.05 * static_cast<double>(tick));
    const Command expected = command_at(whole, tick, angle_deg);
    if (tick == 400) second.set_state(first.state());
    CHECK(command_at(tick < 400 ? first : second, tick, angle_deg).inputs == expected.inputs);
  }
}

TEST_CASE("signals: a constant is there at all times") {
  CHECK(at(ConstantSignal{0.3}, 0.0) == 0.3);
  CHECK(at(ConstantSignal{0.3}, 1e5) == 0.3);
}

TEST_CASE("signals: a step begins at its first moment and is over at its last") {
  const StepSignal step{0.5, 1.0, 5.0};
  CHECK(at(step, 0.9) == 0.0);
  CHECK(at(step, 1.0) == 0.5);
  CHECK(at(step, 4.9) == 0.5);
  CHECK(at(step, 5.0) == 0.0);
}

TEST_CASE("signals: a ramp is a straight line, and zero outside") {
  const RampSignal ramp{0.2, 0.8, 10.0, 20.0};
  CHECK(at(ramp, 9.9) == 0.0);
  CHECK(at(ramp, 10.0) == 0.2);
  CHECK(at(ramp, 12.5) == by_hand(0.35));
  CHECK(at(ramp, 15.0) == by_hand(0.5));
  CHECK(at(ramp, 20.0) == 0.0);
  CHECK(at(RampSignal{0.8, 0.2, 0.0, 10.0}, 5.0) == by_hand(0.5));
}

TEST_CASE("signals: a sine begins at its mean, rising") {
  const SineSignal sine{0.3, 0.2, 8.0, 2.0, 18.0};
  CHECK(at(sine, 1.9) == 0.0);
  CHECK(at(sine, 2.0) == 0.3);
  CHECK(at(sine, 3.0) == by_hand(0.3 + 0.2 * std::sqrt(0.5)));  // an eighth of the period
  CHECK(at(sine, 4.0) == by_hand(0.5));                         // a quarter
  CHECK(at(sine, 6.0) == by_hand(0.3));
  CHECK(at(sine, 8.0) == by_hand(0.1));
  CHECK(at(sine, 18.0) == 0.0);
}

TEST_CASE("signals: the frequency of a chirp grows steadily from its first to its last") {
  const ChirpSignal chirp{0.5, 0.4, 0.0, 1.0, 10.0, 18.0};
  // The phase in turns is f1 s + (f2 - f1) s^2 / (2 * 8) = s^2/16: after 2 s a quarter, after 4 s a whole, after
  // sqrt(12) s three quarters of one.
  CHECK(at(chirp, 9.9) == 0.0);
  CHECK(at(chirp, 10.0) == 0.5);
  CHECK(at(chirp, 12.0) == by_hand(0.9));
  CHECK(at(chirp, 14.0) == by_hand(0.5));
  CHECK(at(chirp, 10.0 + std::sqrt(12.0)) == by_hand(0.1));
  CHECK(at(chirp, 18.0) == 0.0);
  // A chirp of one frequency is a sine: at 0.25 Hz, after 1 s, a quarter.
  CHECK(at(ChirpSignal{0.5, 0.4, 0.25, 0.25, 0.0, 10.0}, 1.0) == by_hand(0.9));
}

TEST_CASE("signals: a pseudo-random sequence has two values, each held, each half of the time") {
  const PrbsSignal prbs{0.1, 0.3, 0.5, 10.0, 5010.0};
  const RandomStream chance(1, "duty_A");
  CHECK(prbs.at(9.9, chance) == 0.0);
  CHECK(prbs.at(5010.0, chance) == 0.0);
  double high = 0.0, changes = 0.0;
  constexpr int draws = 10000;
  for (int draw = 0; draw < draws; ++draw) {
    const auto value = [&](int tick) { return prbs.at(static_cast<double>(100 + 5 * draw + tick) / 10.0, chance); };
    const double first = value(0);
    CHECK((first == 0.1 || first == 0.3));
    for (int tick = 1; tick < 5; ++tick) CHECK(value(tick) == first);
    high += first == 0.3;
    if (draw > 0) changes += value(-1) != first;
  }
  // Binomial: a half, with deviation 0.5 / sqrt(draws); four of them.
  CHECK(std::abs(high / draws - 0.5) < 4.0 * 0.5 / std::sqrt(draws));
  CHECK(std::abs(changes / (draws - 1) - 0.5) < 4.0 * 0.5 / std::sqrt(draws));
}

TEST_CASE("open loop: signals of a coil are added and cut to [0, 1]; coils do not mix") {
  OpenLoopInput open_loop{.signals = {{}, {}}};
  open_loop.signals[A] = {ConstantSignal{0.4}, StepSignal{0.5, 1.0, 3.0}, StepSignal{0.3, 2.0, 4.0}};
  open_loop.signals[B] = {SineSignal{-0.2, 0.1, 4.0, 0.0, 10.0}};
  const Input input = open_loop;
  Driver driver(system_of_two_coils(), input, 1, 0.1);
  CHECK(command_at(driver, 0).inputs == std::vector<double>{0.4, 0.0});
  CHECK(command_at(driver, 10).inputs[A] == 0.9);
  CHECK(command_at(driver, 20).inputs[A] == 1.0);  // 1.2
  CHECK(command_at(driver, 30).inputs[A] == by_hand(0.7));
  CHECK(command_at(driver, 40).inputs[A] == 0.4);
  CHECK(command_at(driver, 10).inputs[B] == 0.0);  // -0.1
  CHECK(command_at(driver, 7).tick == 7);
}

TEST_CASE("open loop: a coil without signals is off, and what is measured does not matter") {
  const Input input = OpenLoopInput{};
  Driver driver(system_of_two_coils(), input, 1, 0.1);
  CHECK(command_at(driver, 3, 40.0).inputs == std::vector<double>{0.0, 0.0});
}

TEST_CASE("open loop: the pseudo-random sequences of the two coils are two sequences, and go with the seed") {
  OpenLoopInput open_loop{.signals = {{}, {}}};
  open_loop.signals[A] = open_loop.signals[B] = {PrbsSignal{0.0, 1.0, 0.1, 0.0, 1000.0}};
  const Input input = open_loop;
  Driver driver(system_of_two_coils(), input, 1, 0.1), again(system_of_two_coils(), input, 1, 0.1),
      other(system_of_two_coils(), input, 2, 0.1);
  int equal = 0, equal_to_other = 0;
  constexpr int ticks = 1000;
  for (int tick = 0; tick < ticks; ++tick) {
    const auto duty = command_at(driver, tick).inputs;
    CHECK(command_at(again, tick).inputs == duty);
    equal += duty[A] == duty[B];
    equal_to_other += command_at(other, tick).inputs[A] == duty[A];
  }
  // Equal by chance half of the time, +- 4 deviations of 0.5 / sqrt(1000).
  CHECK(std::abs(equal - 500) < 64);
  CHECK(std::abs(equal_to_other - 500) < 64);
}

TEST_CASE("replay: each duty of a recording is held until the next, whatever the times") {
  ReplayInput replay;
  // Begins at 100 s; steps of 0.1, 0.25, 0.05 and 1.6 s.
  replay.recording.samples = {sample(100.0, 0.1, 0.0), sample(100.1, 0.2, 0.5), sample(100.35, 0.3, 0.0), sample(100.4, 0.4, 0.0),
                              sample(102.0, 0.5, 0.25)};
  const Input input = replay;
  Driver driver(system_of_two_coils(), input, 1, 0.1);
  const std::vector<double> expected{0.1, 0.2, 0.2, 0.2, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4,
                                     0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.5, 0.5, 0.5};
  for (std::size_t tick = 0; tick < expected.size(); ++tick) {
    CAPTURE(tick);
    const Command command = command_at(driver, static_cast<std::int64_t>(tick));
    CHECK(command.inputs[A] == expected[tick]);
    CHECK(command.inputs[B] == (expected[tick] == 0.2 ? 0.5 : expected[tick] == 0.5 ? 0.25 : 0.0));
  }
}

TEST_CASE("replay: a sample that is due at a tick acts at that tick, whatever the rounding") {
  ReplayInput replay;
  for (int k = 0; k < 1000; ++k) replay.recording.samples.push_back(sample(17.3 + 0.1 * k, k / 1000.0, 0.0));
  const Input input = replay;
  Driver driver(system_of_two_coils(), input, 1, 0.1);
  for (int k = 0; k < 1000; ++k) CHECK(command_at(driver, k).inputs[A] == k / 1000.0);
}

namespace {

sinew::plant::Plant plant_of(const std::string& structure) { return read_plant(parse_yaml("limb:\n" + structure, "p.yaml"), "."); }

// One axis, coils at 0, 120 and 240 degrees around it.
const std::string three_coils_one_axis =
    "  segments: [{name: arm}]\n"
    "  coils: [{name: A, direction_deg: 0}, {name: B, direction_deg: 120}, {name: C, direction_deg: 240}]\n"
    "  channels: [{column: temperature_B_degC, thermocouple: B}, {column: angle_deg, bend: arm}]\n";
const std::string three_coils_two_axes =
    "  segments: [{name: arm, axes: 2}]\n"
    "  coils: [{name: A, direction_deg: 0}, {name: B, direction_deg: 120}, {name: C, direction_deg: 240}]\n"
    "  channels: [{column: angle_x_deg, bend: arm, axis: x}, {column: angle_y_deg, bend: arm, axis: y}]\n";

}  // namespace

TEST_CASE("babble: of three coils around one axis, those drive that bend it the way it should go, each by its share") {
  const sinew::plant::Plant limb = plant_of(three_coils_one_axis);
  const Input input = towards(0.0);
  Driver driver(limb.system(), input, 1, 0.1);
  // u = 0.06 * 5 and 1e-5 * 0.5 more; then back: u = -0.06 * 4 + 1e-5 * 0.1.
  CHECK(driver.command({0, {25.0, -5.0}}, 0.0).inputs == std::vector<double>{0.06 * 5.0 + 1e-5 * 0.5, 0.0, 0.0});
  const Command back = driver.command({1, {25.0, 4.0}}, 0.1);
  CHECK(back.inputs[0] == 0.0);
  CHECK(back.inputs[1] == by_hand(0.5 * (0.24 - 1e-5 * 0.1)));
  CHECK(back.inputs[2] == back.inputs[1]);
  // The limit is each coil's.
  CHECK(driver.command({2, {25.0, -50.0}}, 0.2).inputs == std::vector<double>{0.6, 0.0, 0.0});
  CHECK(driver.command({3, {25.0, 50.0}}, 0.3).inputs == std::vector<double>{0.0, 0.5, 0.5});
}

TEST_CASE("babble: a coil that is said to drive upwards takes those that work with it along") {
  const sinew::plant::Plant limb = plant_of(three_coils_one_axis);
  BabbleInput turned = towards(0.0);
  turned.positive_drives = "C";
  const Input input = turned;
  Driver driver(limb.system(), input, 1, 0.1);
  CHECK(driver.command({0, {25.0, -50.0}}, 0.0).inputs == std::vector<double>{0.0, 0.5, 0.5});
  CHECK(driver.command({1, {25.0, 50.0}}, 0.1).inputs == std::vector<double>{0.6, 0.0, 0.0});
  turned.positive_drives = "A";
  turned.both_sides = false;
  const Input one_sided = turned;
  Driver half(limb.system(), one_sided, 1, 0.1);
  CHECK(half.command({0, {25.0, -50.0}}, 0.0).inputs == std::vector<double>{0.6, 0.0, 0.0});
  CHECK(half.command({1, {25.0, 50.0}}, 0.1).inputs == std::vector<double>{0.0, 0.0, 0.0});
}

TEST_CASE("babble: about two axes, each has setpoints of its own and a coil gets the sum of its shares") {
  const sinew::plant::Plant limb = plant_of(three_coils_two_axes);
  const Input input = towards(0.0);
  Driver driver(limb.system(), input, 1, 0.1);
  // u_x = 0.06 * 2, u_y = 0.06 * 3, and 1e-5 of the sums 0.2 and 0.3.
  const double u_x = 0.120002, u_y = 0.180003, s = std::sqrt(0.75);
  const Command command = driver.command({0, {-2.0, -3.0}}, 0.0);
  CHECK(command.inputs[0] == by_hand(u_x));
  CHECK(command.inputs[1] == by_hand(-0.5 * u_x + s * u_y));
  CHECK(command.inputs[2] == 0.0);  // -0.5 u_x - s u_y
  CHECK(driver.state().following.size() == 2);
  const Input random = BabbleInput{};
  Driver babbling(limb.system(), random, 5, 0.1);
  int different = 0;
  for (std::int64_t tick = 0; tick < 5000; ++tick) {
    babbling.command({tick, {0.0, 0.0}}, static_cast<double>(tick) / 10.0);
    different += babbling.state().following[0].setpoint != babbling.state().following[1].setpoint;
  }
  CHECK(different == 5000);
  CHECK(babbling.state().following[0].setpoints_drawn > 10);
  CHECK(babbling.state().following[1].setpoints_drawn > 10);
}

TEST_CASE("babble: the setpoints of the first channel are those of a limb that has no other") {
  const sinew::plant::Plant one = plant_of(three_coils_one_axis), two = plant_of(three_coils_two_axes);
  const Input input = BabbleInput{};
  Driver alone(one.system(), input, 5, 0.1), both(two.system(), input, 5, 0.1);
  bool same = true;
  for (std::int64_t tick = 0; tick < 2000; ++tick) {
    alone.command({tick, {25.0, 0.0}}, static_cast<double>(tick) / 10.0);
    both.command({tick, {0.0, 0.0}}, static_cast<double>(tick) / 10.0);
    same = same && alone.state().following[0].setpoint == both.state().following[0].setpoint;
  }
  CHECK(same);
}

TEST_CASE("babble: towards a setpoint, a simulated limb of three coils about two axes goes there") {
  const sinew::plant::Plant limb = plant_of(three_coils_two_axes);
  BabbleInput aim = towards(10.0);
  aim.proportional_gain_1_deg = 0.1;
  Scenario scenario;
  scenario.plant = limb;
  scenario.duration_s = 60.0;
  scenario.input = aim;
  scenario.sensors = usual_sensors(limb.system());
  const RunResult result = run(scenario);
  REQUIRE(result.status == RunStatus::finished);
  const Recording recording = parse_recording(result.recording_csv, "r", columns_of(limb.system()));
  CHECK(recording.columns.inputs.size() == 3);
  for (const double angle_deg : recording.samples.back().channels) CHECK(std::abs(angle_deg - 10.0) < 5.0);
}

}  // namespace sim_input_test
