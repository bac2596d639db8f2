// SPDX-License-Identifier: GPL-3.0-or-later
// What is behind the pins: the plant of a scenario, or a concealed limb of the proof's generator, which shares no line with the plant.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/scenario.h"

namespace sinew::emulator {

// The limb as a session left it, from which another one goes on: what has aged, warmed or drifted stays so.
struct Left {
  std::string what;              // which limb: the plant and its file's checksum, or what is concealed
  double time_s = 0.0;           // since the first session began
  double first_session_s = 0.0;  // how long that one was to be: what begins within a recording does so within that
  std::vector<double> state;     // as the body orders it
};
std::string to_text(const Left& left);
Left read_left(const std::filesystem::path& file);  // throws sim::InputError

class Body {
 public:
  virtual ~Body() = default;
  virtual void advance_to(double time_s) = 0;  // throws std::runtime_error where it cannot be integrated
  virtual void hold(const std::vector<double>& duty_fraction) = 0;
  virtual std::vector<double> readings() const = 0;  // of the scenario's channels, in the units of files, without noise
  virtual std::vector<double> wires_degC() const = 0;
  virtual Left left() const = 0;
};

// `before`: as an earlier session left it; none: as the scenario begins. Both throw sim::InputError where that is another limb.
std::unique_ptr<Body> plant_body(const sim::Scenario& scenario, const std::optional<Left>& before = std::nullopt);

// Which limb is concealed: "KIND", of the generator's list, its seed and strength; `recording` chooses the air.
struct Concealed {
  std::string kind;
  std::uint64_t seed = 1, recording = 1;
  double strength = 1.0;
};
// Throws sim::InputError where there is no such kind, or the scenario's plant is not of two coils with thermocouples and one angle.
std::unique_ptr<Body> concealed_body(const Concealed& concealed, const sim::Scenario& scenario,
                                     const std::optional<Left>& before = std::nullopt);

}  // namespace sinew::emulator
