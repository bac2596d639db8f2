// SPDX-License-Identifier: Apache-2.0
// A limb at one instant, for tests: what the equations make of one state, without integrating anything.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plant/integrator.h"
#include "plant/limb/limb.h"
#include "plant/systems.h"

namespace sinew::test {

// The two-coil limb's coils, inputs and thermocouples, the channel of its angle, and where its core's states stand.
inline constexpr std::size_t A = 0, B = 1, angle = 2;
inline constexpr std::size_t coils[] = {A, B};
namespace core_state {
inline constexpr std::size_t temperature = 0, martensite = 2, angle = 4, angular_velocity = 5, count = 6;
}

// A value worked by hand. It differs from what the equations give by the rounding of a dozen operations, each 1e-16.
inline doctest::Approx by_hand(double value) { return doctest::Approx(value).epsilon(1e-13).scale(std::abs(value)); }

// Nothing is driven.
inline plant::Situation idle(const plant::Plant& limb) { return {.inputs = std::vector<double>(limb.system().inputs().size(), 0.0)}; }

// The lists of the two-coil limb.
inline const plant::ListOf<plant::ParameterId, plant::ParameterInfo>& parameters() { return plant::two_coil_limb()->parameters(); }
inline const plant::ListOf<plant::EffectId, plant::EffectInfo>& effects() { return plant::two_coil_limb()->effects(); }
inline plant::ParameterId parameter_id(std::string_view key) { return plant::two_coil_limb()->parameter(key); }
inline plant::EffectId effect_id(std::string_view name) { return plant::two_coil_limb()->effect(name); }

inline double get(const plant::Plant& limb, std::string_view key) { return limb.get(limb.system().parameter(key)); }
// In internal units.
inline void set(plant::Plant& limb, std::string_view key, double value) { limb.set(limb.system().parameter(key), value); }
inline void set_in_file_units(plant::Plant& limb, std::string_view key, double value) {
  limb.set_in_file_units(limb.system().parameter(key), value);
}

// Turns one effect on; values are in the units of files.
inline void turn_on(plant::Plant& limb, std::string_view effect, std::initializer_list<std::pair<std::string_view, double>> values = {}) {
  limb.turn(limb.system().effect(effect), true);
  for (const auto& [name, value] : values) set_in_file_units(limb, std::string(effect) + "." + std::string(name), value);
}

// The default limb with one effect on.
inline plant::Plant limb_with(std::string_view effect, std::initializer_list<std::pair<std::string_view, double>> values = {}) {
  plant::Plant limb = plant::default_plant();
  turn_on(limb, effect, values);
  return limb;
}

// Every parameter of an effect at its typical value, and the effect on.
inline void turn_on_typical(plant::Plant& limb, plant::EffectId effect) {
  limb.turn(effect, true);
  for (const plant::ParameterId p : limb.system().effects()[effect].parameters)
    limb.set_in_file_units(p, limb.system().parameters()[p].declaration.typical);
}

inline std::unique_ptr<plant::LimbEquations<double>> limb_equations(const plant::Plant& limb) {
  return dynamic_cast<const plant::LimbSystem&>(limb.system()).limb_equations(limb);
}

struct OneInstant {
  plant::Instant<double> now;  // its pointers are not for use here
  std::vector<double> rates;
  std::vector<double> reading;  // [channels], internal units
  double stored_heat_J;
};

// y: the core's states, then those of the effects that are on. Inputs that are not given are 0.
inline OneInstant at_one_instant(const plant::Plant& limb, plant::Situation given, const std::vector<double>& y) {
  const auto equations = limb_equations(limb);
  if (y.size() != limb.states().size()) throw std::invalid_argument("a test gives a state of the wrong length");
  if (given.inputs.empty()) given.inputs = idle(limb).inputs;
  std::vector<double> rates(y.size()), reading(limb.system().channels().size());
  equations->rates(given, y.data(), rates.data());
  equations->readings(y.data(), reading.data());
  OneInstant result{equations->instant(), rates, reading, equations->stored_heat_J(y.data())};
  result.now.core = nullptr;
  result.now.given = nullptr;
  return result;
}

// Where an integrator stands.
inline OneInstant at_one_instant(const plant::Plant& limb, const plant::Integrator& run) {
  return at_one_instant(limb, run.situation(), run.state());
}

inline std::vector<double> at_rest(const plant::Plant& limb, const std::vector<std::optional<double>>& known) {
  return limb.equations()->rest(idle(limb), known);
}
inline std::vector<double> at_rest(const plant::Plant& limb) {
  return at_rest(limb, std::vector<std::optional<double>>(limb.states().size()));
}

}  // namespace sinew::test
