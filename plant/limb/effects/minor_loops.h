// SPDX-License-Identifier: Apache-2.0
// Inside the hysteresis loop the fraction does not stand still: it follows a share of the envelope's slope.
//
//   xi_cool < xi < xi_heat:   dxi/dt = mu dxi_heat/dT dT/dt while warming, mu dxi_cool/dT dT/dt while cooling
//
// Source: docs/plant.md, section 2; minor loops as in Ikuta, Tsukamoto, Hirose 1991. The term fades in over
// Smoothing::loop_edge_fraction from the edge of the loop, so that the right-hand side stays Lipschitz.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct MinorLoops {
  static constexpr std::string_view name = "minor_loops";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "inside the loop dxi/dt = mu (dxi_envelope/dT) dT/dt";
  static constexpr std::string_view words = "inside the hysteresis loop the phase goes on changing with temperature";

  S slope_share{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.slope_share, Declaration{.name = "slope_share",
                                        .symbol = "mu",
                                        .unit = units::none,
                                        .range = {0.0, 1.0},
                                        .typical = 0.2,
                                        .null_value = 0.0,
                                        .prior_deviation = 0.3,
                                        .meaning = "slope inside the loop as a share of the envelope's",
                                        .source = "minor loops of Ni-Ti coils"});
  }

  void transformation(Instant<S>& now, std::size_t coil) const {
    const S& xi = now.martensite_fraction[coil];
    const S& high = now.heating_envelope[coil];
    const S& low = now.cooling_envelope[coil];
    const S below_heating = high - xi;
    const S above_cooling = xi - low;
    const S depth = value_of(below_heating) < value_of(above_cooling) ? below_heating : above_cooling;
    if (value_of(depth) <= 0.0) return;
    const S inside = value_of(depth) < Smoothing::loop_edge_fraction ? S(depth / Smoothing::loop_edge_fraction) : S(1.0);
    now.warming_slope_1_K[coil] -= inside * slope_share * high * (1.0 - high) / now.core->heating_width_K[coil];
    now.cooling_slope_1_K[coil] -= inside * slope_share * low * (1.0 - low) / now.core->cooling_width_K[coil];
  }
};

}  // namespace sinew::plant
