// SPDX-License-Identifier: Apache-2.0
// The bend sensor shows less and less of a large bend, to either side of its zero, and never more than 1/sqrt(c).
//
//   theta_m = theta / sqrt(1 + c theta^2)
//
// Source: flexible sensors that saturate, docs/plant.md, section 2; the algebraic sigmoid, whose first term is -c theta^3 / 2.
// Leaves out a sensor that is not the same to both sides.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct AngleSensorSaturation {
  static constexpr std::string_view name = "angle_sensor_saturation";
  static constexpr Place place = Place::sensor_angle;
  static constexpr Part part = Part::bend_sensor;
  static constexpr std::string_view equation = "theta_m = theta / sqrt(1 + c theta^2)";
  static constexpr std::string_view words = "the bend sensor shows less and less of a large bend";
  static constexpr std::string_view argument = "angle";

  S saturation_1_rad2{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.saturation_1_rad2, Declaration{.name = "saturation_1_rad2",
                                              .symbol = "c",
                                              .unit = units::per_rad2,
                                              .range = {0.0, 100.0},
                                              .typical = 0.5,
                                              .null_value = 0.0,
                                              .prior_deviation = 1.0,
                                              .meaning = "how soon the reading saturates: it stays below 1/sqrt(c)",
                                              .source = "a tenth less at 40 degrees"});
  }

  void reading(Instant<S>& now, std::size_t bend) const {
    const S& shown = now.shown_angle_rad[bend];
    now.shown_angle_rad[bend] = shown / sqrt(1.0 + saturation_1_rad2 * shown * shown);
  }
};

}  // namespace sinew::plant
