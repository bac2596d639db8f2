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

#include "plant/equations.h"

namespace sinew::test {

// A value worked by hand. It differs from what the equations give by the rounding of a dozen operations, each 1e-16.
inline doctest::Approx by_hand(double value) { return doctest::Approx(value).epsilon(1e-13).scale(std::abs(value)); }

// The default core with one effect on; values are in the units of files.
inline void turn_on(plant::Limb<double>& limb, std::string_view effect,
                    std::initializer_list<std::pair<std::string_view, double>> values = {}) {
  limb.on[plant::effect_index(effect)] = true;
  for (const auto& [name, value] : values)
    plant::set_in_file_units(limb, plant::parameter_index(std::string(effect) + "." + std::string(name)), value);
}

inline plant::Limb<double> limb_with(std::string_view effect,
                                     std::initializer_list<std::pair<std::string_view, double>> values = {}) {
  plant::Limb<double> limb;
  turn_on(limb, effect, values);
  return limb;
}

// Every parameter of an effect at its typical value, and the effect on.
inline void turn_on_typical(plant::Limb<double>& limb, std::size_t effect) {
  limb.on[effect] = true;
  for (const std::size_t p : plant::effects()[effect].parameters)
    plant::set_in_file_units(limb, p, plant::parameters()[p].declaration.typical);
}

struct OneInstant {
  plant::Instant<double> now;  // its pointer `core` is not for use here
  std::vector<double> rates;
  plant::Reading<double> reading;
  double stored_heat_J;
};

// y: the core's six states, then those of the effects that are on.
inline OneInstant at_one_instant(const plant::Limb<double>& limb, const plant::Situation& given,
                                 const std::vector<double>& y) {
  const plant::Equations<double> equations(limb);
  OneInstant result;
  result.rates.resize(equations.layout().size());
  if (y.size() != result.rates.size()) throw std::invalid_argument("a test gives a state of the wrong length");
  equations.evaluate(given, y.data(), result.now, result.rates.data());
  result.reading = equations.reading(result.now, y.data());
  result.stored_heat_J = equations.stored_heat_J(result.now, y.data());
  result.now.core = nullptr;
  return result;
}

}  // namespace sinew::test
