// SPDX-License-Identifier: GPL-3.0-or-later
// What is behind the pins: the plant of a scenario, or a concealed limb of the proof's generator, which shares no line with the plant.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/scenario.h"

namespace sinew::emulator {

class Body {
 public:
  virtual ~Body() = default;
  virtual void advance_to(double time_s) = 0;  // throws std::runtime_error where it cannot be integrated
  virtual void hold(const std::vector<double>& duty_fraction) = 0;
  virtual std::vector<double> readings() const = 0;  // of the scenario's channels, in the units of files, without noise
  virtual std::vector<double> wires_degC() const = 0;
};

std::unique_ptr<Body> plant_body(const sim::Scenario& scenario);

// Which limb is concealed: "KIND", of the generator's list, its seed and strength; `recording` chooses the air.
struct Concealed {
  std::string kind;
  std::uint64_t seed = 1, recording = 1;
  double strength = 1.0;
};
// Throws sim::InputError where there is no such kind, or the scenario's plant is not of two coils with thermocouples and one angle.
std::unique_ptr<Body> concealed_body(const Concealed& concealed, const sim::Scenario& scenario);

}  // namespace sinew::emulator
