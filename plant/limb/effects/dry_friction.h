// SPDX-License-Identifier: Apache-2.0
// A coil rubs in its channel.
//
//   moment -> moment - M_f tanh(omega / omega_s)
//
// Source: smoothed Coulomb friction; Olsson et al. 1998. Leaves out sticking: below omega_s the limb creeps.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct DryFriction {
  static constexpr std::string_view name = "dry_friction";
  static constexpr Place place = Place::mechanics;
  static constexpr Part part = Part::bend;
  static constexpr std::string_view equation = "moment -> moment - M_f tanh(omega / omega_s)";
  static constexpr std::string_view words = "the coils rub in their channels (dry friction)";
  static constexpr std::string_view argument = "angular velocity";

  S moment_Nm{0.0};
  S smoothing_rad_s{0.05};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.moment_Nm, Declaration{.name = "moment_Nm",
                                      .symbol = "M_f",
                                      .unit = units::Nm,
                                      .range = {0.0, 0.5},
                                      .typical = 0.003,
                                      .null_value = 0.0,
                                      .prior_deviation = 0.004,
                                      .meaning = "moment of friction",
                                      .source = "a few per cent of the coils' moment"});
    visit(self.smoothing_rad_s, Declaration{.name = "smoothing_rad_s",
                                            .symbol = "omega_s",
                                            .unit = units::rad_s,
                                            .range = {0.001, 10.0},
                                            .typical = 0.05,
                                            .prior_deviation = 0.5,
                                            .meaning = "angular velocity at which it is nearly full",
                                            .source = "no quantity of a limb: how sharp the edge is, in any decade alike"});
  }

  void moment(Instant<S>& now, std::size_t bend) const {
    using std::tanh;
    now.moment_Nm[bend] = now.moment_Nm[bend] - moment_Nm * tanh(now.angular_velocity_rad_s[bend] / smoothing_rad_s);
  }
};

}  // namespace sinew::plant
