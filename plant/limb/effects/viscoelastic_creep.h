// SPDX-License-Identifier: Apache-2.0
// The silicone resists a fast bend more than a slow one, and creeps back: a Maxwell branch beside the beam's spring.
//
//   moment -> moment - k_v (theta - theta_v),   dtheta_v/dt = (theta - theta_v) / tau_v
//
// Source: standard linear solid; Ferry, Viscoelastic Properties of Polymers, 3rd ed. (1980), chapter 1.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct ViscoelasticCreep {
  static constexpr std::string_view name = "viscoelastic_creep";
  static constexpr Place place = Place::mechanics;
  static constexpr Part part = Part::bend;
  static constexpr std::string_view equation = "moment -> moment - k_v (theta - theta_v), dtheta_v/dt = (theta - theta_v)/tau_v";
  static constexpr std::string_view words = "the silicone creeps (viscoelasticity)";
  static constexpr std::string_view argument = "memory of angle";
  static constexpr std::array states{StateDeclaration{"angle_{}_rad", units::rad, 0.3}};

  S stiffness_Nm_rad{0.0};
  S time_constant_s{20.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.stiffness_Nm_rad, Declaration{.name = "stiffness_Nm_rad",
                                             .symbol = "k_v",
                                             .unit = units::Nm_rad,
                                             .range = {0.0, 1.0},
                                             .typical = 0.015,
                                             .null_value = 0.0,
                                             .prior_deviation = 0.03,
                                             .meaning = "stiffness of the branch that relaxes",
                                             .source = "a fraction of the beam's own stiffness"});
    visit(self.time_constant_s, Declaration{.name = "time_constant_s",
                                            .symbol = "tau_v",
                                            .unit = units::s,
                                            .range = {0.05, 5000.0},
                                            .typical = 20.0,
                                            .prior_deviation = 30.0,
                                            .meaning = "time in which it relaxes",
                                            .source = "seconds to minutes for silicone"});
  }

  void rest(const Instant<S>& now, std::size_t bend, S* own) const { own[0] = now.angle_rad[bend]; }
  void moment(Instant<S>& now, std::size_t bend, const S* own) const {
    now.moment_Nm[bend] = now.moment_Nm[bend] - stiffness_Nm_rad * (now.angle_rad[bend] - own[0]);
  }
  void rates(const Instant<S>& now, std::size_t bend, const S* own, S* rate) const {
    rate[0] = (now.angle_rad[bend] - own[0]) / time_constant_s;
  }
};

}  // namespace sinew::plant
