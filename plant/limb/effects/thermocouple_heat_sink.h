// SPDX-License-Identifier: Apache-2.0
// The thermocouple's leads drain heat, so that the bead stays between the wire and the surroundings.
//
//   T_m = T_inf + g (T - T_inf),  g < 1      written T - (1 - g)(T - T_inf), exact at g = 1
//
// Source: stem conduction error; Doebelin, Measurement Systems, 5th ed. (2004), section 8.6.
// Leaves out that the leads take time to warm.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct ThermocoupleHeatSink {
  static constexpr std::string_view name = "thermocouple_heat_sink";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr Part part = Part::thermocouple;
  static constexpr std::string_view equation = "T_m = T_inf + g (T - T_inf)";
  static constexpr std::string_view words = "the thermocouple's leads drain heat, so that it reads too cool";
  static constexpr std::string_view argument = "temperature";

  S gain{1.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.gain, Declaration{.name = "gain",
                                 .symbol = "g",
                                 .unit = units::none,
                                 .range = {0.2, 1.0},
                                 .typical = 0.9,
                                 .null_value = 1.0,
                                 .prior_deviation = 0.1,
                                 .meaning = "share of the wire's temperature rise that the thermocouple shows",
                                 .source = "30 AWG leads in epoxy"});
  }

  void reading(Instant<S>& now, std::size_t coil) const {
    S& shown_degC = now.shown_temperature_degC[coil];
    shown_degC = shown_degC - (1.0 - gain) * (shown_degC - now.ambient_temperature_degC);
  }
};

}  // namespace sinew::plant
