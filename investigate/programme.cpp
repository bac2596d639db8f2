// SPDX-License-Identifier: Apache-2.0
#include "investigate/programme.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "plant/contains.h"
#include "sim/random.h"
#include "sim/text.h"

namespace sinew::investigate {
namespace {

constexpr double begin_s = 2.0;  // at rest first, so that what the sensors show of the room is in the recording
constexpr double period_s = 0.1;
constexpr double least_level = 0.04, most_level = 0.6;

double on_grid(double time_s) { return std::round(time_s / period_s) / std::round(1.0 / period_s); }
double rounded(double level) { return std::round(level * 1000.0) / 1000.0; }

Shape rounded(Shape shape, double longest_drive_s) {
  shape.level_fraction = rounded(std::clamp(shape.level_fraction, least_level, most_level));
  shape.on_s = on_grid(std::clamp(shape.on_s, 0.5, 120.0));
  shape.off_s = on_grid(std::clamp(shape.off_s, 1.0, 120.0));
  shape.drive_s = on_grid(std::clamp(shape.drive_s, 20.0, longest_drive_s));
  return shape;
}

// That are driven, in the order in which each comes first.
std::vector<std::size_t> inputs_of(const Programme& programme) {
  std::vector<std::size_t> inputs;
  for (const Part& part : programme.parts)
    if (!contains(inputs, part.input)) inputs.push_back(part.input);
  return inputs;
}

}  // namespace

std::string_view text_of(Family family) {
  switch (family) {
    case Family::pulses_in_turn:
      return "pulses_in_turn";
    case Family::pulses_on_one:
      return "pulses_on_one";
    case Family::hold_in_turn:
      return "hold_in_turn";
    case Family::steps:
      return "steps";
    case Family::sweep_in_turn:
      return "sweep_in_turn";
    case Family::together:
      return "together";
    case Family::against:
      return "against";
  }
  return "";
}

double Programme::duty(std::size_t input, double time_s) const {
  double sum = 0.0;
  for (const Part& part : parts)
    if (part.input == input && time_s >= part.from_s && time_s < part.until_s)
      sum += part.first + (part.last - part.first) * (time_s - part.from_s) / (part.until_s - part.from_s);
  return std::clamp(sum, 0.0, 1.0);
}

std::vector<Shape> first_shapes(const plant::System& system, double longest_drive_s) {
  std::vector<Shape> all;
  const auto add = [&](Family family, std::size_t coil, double level, double on_s, double off_s, double drive_s) {
    if (drive_s > longest_drive_s * 1.001) drive_s = longest_drive_s;
    all.push_back(rounded({family, coil, level, on_s, off_s, drive_s}, longest_drive_s));
  };
  const std::size_t coils = system.inputs().size();
  // What has no time for all coils is begun at each that the one before did not reach.
  const auto add_in_turn = [&](Family family, double level, double on_s, double off_s, double drive_s) {
    for (std::size_t coil = 0; coil < coils;) {
      add(family, coil, level, on_s, off_s, drive_s);
      coil += std::max<std::size_t>(1, inputs_of(programme_of(all.back(), system)).size());
    }
  };
  add_in_turn(Family::pulses_in_turn, 0.5, 3.0, 7.0, 60.0);
  add_in_turn(Family::pulses_in_turn, 0.45, 6.0, 14.0, 100.0);
  add_in_turn(Family::pulses_in_turn, 0.4, 9.0, 35.0, 150.0);
  for (std::size_t coil = 0; coil < coils; ++coil) {
    add(Family::pulses_on_one, coil, 0.45, 5.0, 12.0, 70.0);
    add(Family::pulses_on_one, coil, 0.18, 40.0, 40.0, 110.0);
    if (coils > 1) add(Family::against, coil, 0.12, 6.0, 12.0, 100.0);
  }
  add_in_turn(Family::hold_in_turn, 0.15, 40.0, 20.0, 130.0);
  add_in_turn(Family::hold_in_turn, 0.1, 25.0, 10.0, 80.0);
  add_in_turn(Family::steps, 0.2, 12.0, 15.0, 120.0);
  add_in_turn(Family::sweep_in_turn, 0.22, 30.0, 10.0, 90.0);
  add_in_turn(Family::sweep_in_turn, 0.2, 60.0, 15.0, 160.0);
  add(Family::together, 0, 0.4, 5.0, 15.0, 80.0);
  add(Family::together, 0, 0.14, 40.0, 30.0, 110.0);
  return all;
}

Shape random_shape(const plant::System& system, double longest_drive_s, std::uint64_t seed, std::uint64_t number) {
  constexpr std::array families{Family::pulses_in_turn, Family::pulses_on_one, Family::hold_in_turn, Family::steps,
                                Family::sweep_in_turn,  Family::together,      Family::against};
  constexpr double shortest_drive_s = 40.0;
  const sim::RandomStream chance(seed, "random programme " + std::to_string(number));
  const auto one_of = [&](std::uint64_t n, std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(chance.uniform(n) * static_cast<double>(count)));
  };
  const auto between = [&](std::uint64_t n, double least, double most) { return least * std::pow(most / least, chance.uniform(n)); };
  const std::size_t possible = families.size() - (system.inputs().size() > 1 ? 0 : 1);  // the last one takes two coils
  return rounded({families[one_of(0, possible)], one_of(1, system.inputs().size()), between(2, 0.08, most_level), between(3, 2.0, 40.0),
                  between(4, 4.0, 40.0), between(5, shortest_drive_s, std::max(shortest_drive_s, longest_drive_s))},
                 longest_drive_s);
}

std::vector<Shape> neighbours(const Shape& shape, double longest_drive_s) {
  std::vector<Shape> all;
  const auto add = [&](double Shape::*field, double factor) {
    Shape other = shape;
    other.*field *= factor;
    all.push_back(rounded(other, longest_drive_s));
  };
  for (double Shape::*field : {&Shape::level_fraction, &Shape::on_s, &Shape::off_s, &Shape::drive_s})
    for (const double factor : {1.5, 1.0 / 1.5}) add(field, factor);
  return all;
}

Programme programme_of(const Shape& shape, const plant::System& system) {
  Programme programme{shape, 0.0, {}};
  const std::size_t inputs = system.inputs().size();
  const double level = shape.level_fraction, end_s = shape.drive_s;
  const auto part = [&](std::size_t input, double from_s, double until_s, double first, double last) {
    until_s = std::min(on_grid(until_s), end_s);
    from_s = on_grid(from_s);
    if (until_s > from_s) programme.parts.push_back({input % inputs, from_s, until_s, first, last});
  };
  double t = begin_s;
  switch (shape.family) {
    case Family::pulses_in_turn:
    case Family::hold_in_turn:
      for (std::size_t k = 0; t < end_s; ++k, t += shape.on_s + shape.off_s) part(shape.coil + k, t, t + shape.on_s, level, level);
      break;
    case Family::pulses_on_one:
      for (; t < end_s; t += shape.on_s + shape.off_s) part(shape.coil, t, t + shape.on_s, level, level);
      break;
    case Family::steps:
      for (std::size_t k = 0; t < end_s; ++k, t += 3.0 * shape.on_s + shape.off_s)
        for (const auto& [step, share] : {std::pair{0, 0.5}, {1, 1.0}, {2, 0.5}})
          part(shape.coil + k, t + step * shape.on_s, t + (step + 1) * shape.on_s, rounded(share * level), rounded(share * level));
      break;
    case Family::sweep_in_turn:
      for (std::size_t k = 0; t + 2.0 * shape.on_s <= end_s + 1e-9 || k == 0; ++k, t += 2.0 * shape.on_s + shape.off_s) {
        part(shape.coil + k, t, t + shape.on_s, 0.0, level);
        part(shape.coil + k, t + shape.on_s, t + 2.0 * shape.on_s, level, 0.0);
      }
      break;
    case Family::together:
      for (; t < end_s; t += shape.on_s + shape.off_s)
        for (std::size_t i = 0; i < inputs; ++i) part(i, t, t + shape.on_s, level, level);
      break;
    case Family::against:
      part(shape.coil, t, end_s, level, level);
      for (t += 15.0; t < end_s; t += shape.on_s + shape.off_s)
        part(shape.coil + 1, t, t + shape.on_s, rounded(std::min(most_level, 3.0 * level)), rounded(std::min(most_level, 3.0 * level)));
      break;
  }
  return programme;
}

std::string words_of(const Shape& shape, const plant::System& system) {
  const auto part = [&](std::size_t input) { return std::string(system.inputs()[plant::InputId{input}].part); };
  const std::vector<std::size_t> driven = inputs_of(programme_of(shape, system));
  std::string all = (system.inputs().size() == 2 ? "both " : "all ") + std::string(system.parts_word());
  if (driven.size() < system.inputs().size()) {
    all.clear();
    for (const std::size_t input : driven) all += (all.empty() ? "" : ", ") + part(input);
  }
  const std::string in_turn = driven.size() > 1 ? " in turn" : "";
  const std::string one = part(shape.coil);
  const auto s = [](double value) { return sim::shortest(value) + " s"; };
  const std::string level = "duty " + sim::shortest(shape.level_fraction);
  const std::string pulses = "pulses of " + s(shape.on_s) + " at " + level + ", " + s(shape.off_s) + " apart, ";
  switch (shape.family) {
    case Family::pulses_in_turn:
      return pulses + "on " + all + in_turn;
    case Family::pulses_on_one:
      return pulses + "on " + one + " alone";
    case Family::hold_in_turn:
      return "holds of " + s(shape.on_s) + " at " + level + ", " + s(shape.off_s) + " apart, on " + all + in_turn;
    case Family::steps:
      return "steps up to " + level + " and down, " + s(shape.on_s) + " each, on " + all + in_turn;
    case Family::sweep_in_turn:
      return "slow sweeps up to " + level + " and down, " + s(shape.on_s) + " each way, on " + all + in_turn;
    case Family::together:
      return pulses + "on " + all + " together";
    case Family::against:
      return one + " held at " + level + " while " + (driven.size() > 1 ? part(driven[1]) : "nothing else") + " pulses for " +
             s(shape.on_s) + ", " + s(shape.off_s) + " apart";
  }
  return "";
}

sim::Recording rows_of(const Programme& programme, const plant::System& system) {
  sim::Recording recording{.name = "programme", .columns = sim::columns_of(system)};
  const auto rows = static_cast<int>(std::lround(programme.duration_s() / period_s));
  for (int k = 0; k <= rows; ++k) {
    sim::Sample sample{k / std::round(1.0 / period_s), {}, std::vector<double>(system.channels().size(), 0.0)};
    for (std::size_t i = 0; i < system.inputs().size(); ++i) sample.inputs.push_back(programme.duty(i, sample.time_s));
    recording.samples.push_back(std::move(sample));
  }
  return recording;
}

sim::Scenario scenario_of(const Programme& programme, const plant::Plant& plant, std::int64_t seed, std::vector<std::string> comments) {
  sim::Scenario scenario;
  scenario.comments = std::move(comments);
  scenario.seed = seed;
  scenario.duration_s = programme.duration_s();
  scenario.sample_period_s = period_s;
  scenario.plant = plant;
  scenario.sensors = sim::usual_sensors(plant.system());
  scenario.start.assign(plant.states().size(), std::nullopt);
  sim::OpenLoopInput input;
  input.signals.resize(plant.system().inputs().size());
  for (const Part& part : programme.parts) {
    if (part.first == part.last)
      input.signals[part.input].push_back(sim::StepSignal{part.first, part.from_s, part.until_s});
    else
      input.signals[part.input].push_back(sim::RampSignal{part.first, part.last, part.from_s, part.until_s});
  }
  scenario.input = input;
  return scenario;
}

}  // namespace sinew::investigate
