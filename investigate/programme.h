// SPDX-License-Identifier: Apache-2.0
// A programme of duty: what an experiment does to the coils, with numbers that can be optimised.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/scenario.h"

namespace sinew::investigate {

enum class Family {
  pulses_in_turn,  // on every coil, one after the other
  pulses_on_one,
  hold_in_turn,   // long and low, near where a coil neither warms nor cools
  steps,          // up and down again on each coil
  sweep_in_turn,  // slowly up and down
  together,       // pulses on all coils at once
  against,        // one coil is held, another pulses
};
std::string_view text_of(Family family);

// What can be optimised of a programme.
struct Shape {
  Family family = Family::pulses_in_turn;
  std::size_t coil = 0;  // the first one, or the one
  double level_fraction = 0.4, on_s = 5.0, off_s = 10.0, drive_s = 100.0;
};

struct Part {
  std::size_t input;
  double from_s, until_s, first, last;  // duty fractions: a step where these are the same
};

struct Programme {
  Shape shape;
  double cool_s = 0.0;  // of no duty, at the end
  std::vector<Part> parts;
  double duration_s() const { return shape.drive_s + cool_s; }
  double duty(std::size_t input, double time_s) const;
};

// The shapes that a search begins with: every family, short, middle and long, none longer than `longest_drive_s`.
std::vector<Shape> first_shapes(const plant::System& system, double longest_drive_s);
// One by chance: every family and coil alike, level and times alike in their logarithms, up to `longest_drive_s`.
Shape random_shape(const plant::System& system, double longest_drive_s, std::uint64_t seed, std::uint64_t number);
// The same shape with one number larger or smaller.
std::vector<Shape> neighbours(const Shape& shape, double longest_drive_s);

Programme programme_of(const Shape& shape, const plant::System& system);
std::string words_of(const Shape& shape, const plant::System& system);

// Rows of 0.1 s with the programme's duty and no measurement.
sim::Recording rows_of(const Programme& programme, const plant::System& system);
sim::Scenario scenario_of(const Programme& programme, const plant::Plant& plant, std::int64_t seed, std::vector<std::string> comments);

}  // namespace sinew::investigate
