// SPDX-License-Identifier: Apache-2.0
// Large bends stretch the silicone, which then resists more.
//
//   moment -> moment - k_3 theta^3
//
// Source: first odd term after the linear one for a symmetric body; Duffing spring.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct CubicStiffening {
  static constexpr std::string_view name = "cubic_stiffening";
  static constexpr Place place = Place::mechanics;
  static constexpr Part part = Part::bend;
  static constexpr std::string_view equation = "moment -> moment - k_3 theta^3";
  static constexpr std::string_view words = "the body stiffens at large bends";
  static constexpr std::string_view argument = "angle";

  S stiffness_Nm_rad3{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_Nm_rad3, Declaration{.name = "stiffness_Nm_rad3",
                                              .symbol = "k_3",
                                              .unit = units::Nm_rad3,
                                              .range = {0.0, 10.0},
                                              .typical = 0.05,
                                              .null_value = 0.0,
                                              .prior_deviation = 0.1,
                                              .meaning = "coefficient of the cubic moment",
                                              .source = "hyperelastic bending at 1 rad"});
  }

  void moment(Instant<S>& now, std::size_t bend) const {
    const S& theta = now.angle_rad[bend];
    now.moment_Nm[bend] = now.moment_Nm[bend] - stiffness_Nm_rad3 * theta * theta * theta;
  }
};

}  // namespace sinew::plant
