// SPDX-License-Identifier: Apache-2.0
// A duty that is commanded at one time acts later.
//
//   u(t) -> u(t - d)
//
// Source: serial link and controller period. Before the first command has arrived, the duty held at the start acts.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct InputDelay {
  static constexpr std::string_view name = "input_delay";
  static constexpr Place place = Place::actuation;
  static constexpr Part part = Part::supply;
  static constexpr std::string_view equation = "u(t) -> u(t - d)";
  static constexpr std::string_view words = "commands act late";

  S delay_s{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.delay_s, Declaration{.name = "delay_s",
                                    .symbol = "d",
                                    .unit = units::s,
                                    .range = {0.0, 5.0},
                                    .typical = 0.3,
                                    .null_value = 0.0,
                                    .prior_deviation = 0.3,
                                    .meaning = "time from a command to the current",
                                    .source = "serial link at 10 Hz"});
  }

  // Edges of the duty come later by this; the integrator moves them.
  S input_delay_s() const { return delay_s; }
};

}  // namespace sinew::plant
