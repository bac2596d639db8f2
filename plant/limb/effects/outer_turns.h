// SPDX-License-Identifier: Apache-2.0
// The thermocouples sit on turns of the coils that lie outside the body. They carry the same current as the turns that bend
// the limb, but nothing covers them as the body covers those, so they warm and cool at another rate.
//
//   C_j dE_j/dt = q P_j - h_j (T_j - T_inf) - (1 + b) h_j E_j,   reading: T_j + b E_j
//
// with P_j the wire's Joule heat. b E is the balance of a turn that loses (1 + b) and gains (1 + q b) times as much heat for its heat
// capacity as the turns inside, less the balance of these; q = 1: it has less around it, and both go faster.
//
// Source: lumped heat balance; Incropera et al., 6th ed. (2007), section 5.1. Asked for by the physical limb, whose
// thermocouples are fixed on two or three turns behind the base (Sabelhaus et al. 2022, methods; results/paper_limb).
// Leaves out that turns outside do not transform; what other effects do to the heat balance they share with those inside.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct OuterTurns {
  static constexpr std::string_view name = "outer_turns";
  static constexpr Place place = Place::sensor_temperature;
  static constexpr Part part = Part::thermocouple;
  static constexpr std::string_view equation = "C_j dE_j/dt = q P_j - h_j (T_j - T_inf) - (1 + b) h_j E_j, T_m,j = T_j + b E_j";
  static constexpr std::string_view words = "the thermocouple sits on turns outside the body, which warm and cool unlike those inside";
  static constexpr std::array states{StateDeclaration{"excess_{}_K", units::K, 20.0}};

  S relative_heat_loss{0.0};
  S power_share{1.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.relative_heat_loss, Declaration{.name = "relative_heat_loss",
                                               .symbol = "b",
                                               .unit = units::none,
                                               .range = {-0.9, 5.0},
                                               .typical = 0.5,
                                               .null_value = 0.0,
                                               .prior_deviation = 0.5,
                                               .meaning = "by what share more than inside a turn outside loses heat, for its heat capacity",
                                               .source = "wire in air against wire in silicone"});
    visit(self.power_share, Declaration{.name = "power_share",
                                        .symbol = "q",
                                        .unit = units::none,
                                        .range = {-5.0, 5.0},
                                        .typical = 1.0,
                                        .prior_deviation = 1.0,
                                        .meaning = "how much of that share it is heated more, too; 1 where it only has less around it",
                                        .source = "epoxy on the turns outside, silicone around those inside"});
  }

  void rest(const Instant<S>&, std::size_t, S* own) const { own[0] = S(0.0); }
  void rates(const Instant<S>& now, std::size_t coil, const S* own, S* rate) const {
    rate[0] = (power_share * now.joule_heat_W[coil] - now.heat_loss_W_K[coil] * (now.temperature_degC[coil] - now.ambient_temperature_degC +
                                                                                 (1.0 + relative_heat_loss) * own[0])) /
              now.core->heat_capacity_J_K[coil];
  }
  void reading(Instant<S>& now, std::size_t coil, const S* own) const {
    now.shown_temperature_degC[coil] = now.shown_temperature_degC[coil] + relative_heat_loss * own[0];
  }
};

}  // namespace sinew::plant
