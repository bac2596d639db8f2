// SPDX-License-Identifier: Apache-2.0
// The switch's rise time swallows the start of every pulse.
//
//   u -> max(0, u - u_0)
//
// Source: MOSFET switching delay. At null the duty is taken as it is (it is never negative).
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct DutyDeadband {
  static constexpr std::string_view name = "duty_deadband";
  static constexpr Place place = Place::actuation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "u -> max(0, u - u_0)";
  static constexpr std::string_view words = "the first part of every duty cycle has no effect";
  static constexpr std::string_view argument = "duty";

  S threshold_fraction{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.threshold_fraction, Declaration{.name = "threshold_fraction",
                                               .symbol = "u_0",
                                               .unit = units::none,
                                               .range = {0.0, 1.0},
                                               .typical = 0.05,
                                               .null_value = 0.0,
                                               .prior_deviation = 0.05,
                                               .meaning = "duty below which nothing flows",
                                               .source = "MOSFET and driver"});
  }

  void electrics(Instant<S>& now, std::size_t coil) const {
    now.duty_fraction[coil] = positive_part(S(now.duty_fraction[coil] - threshold_fraction));
  }
};

}  // namespace sinew::plant
