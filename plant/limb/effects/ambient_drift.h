// SPDX-License-Identifier: Apache-2.0
// The room warms or cools, during a recording and until the next.
//
//   T_inf -> T_inf + s t,  t since the first recording began
//
// A recording that is made later may begin in a room that is warmer by then: t is a state. Source: docs/plant.md, section 2. Leaves out
// everything but a straight line.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct AmbientDrift {
  static constexpr std::string_view name = "ambient_drift";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::room;
  static constexpr std::string_view equation = "T_inf -> T_inf + s t";
  static constexpr std::string_view words = "the surroundings warm or cool during the recording";

  static constexpr std::array states{StateDeclaration{"elapsed_s", units::s, 100.0, AtStart::elapsed, 1800.0}};

  static constexpr std::string_view grown_words = "the temperature of the surroundings", grown_unit = "K";

  S rate_K_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.rate_K_s, Declaration{.name = "rate_K_s",
                                     .symbol = "s",
                                     .unit = units::K_s,
                                     .range = {-1.0, 1.0},
                                     .typical = 0.005,
                                     .null_value = 0.0,
                                     .prior_deviation = 0.01,
                                     .meaning = "rate at which the surroundings warm",
                                     .source = "a few kelvin in ten minutes"});
  }

  void rest(const Instant<S>&, std::size_t, S* own) const { own[0] = S(0.0); }
  void environment(Instant<S>& now, std::size_t, const S* own) const {
    now.ambient_temperature_degC = now.ambient_temperature_degC + rate_K_s * own[0];
  }
  void rates(const Instant<S>&, std::size_t, const S*, S* rate) const { rate[0] = S(1.0); }
};

}  // namespace sinew::plant
