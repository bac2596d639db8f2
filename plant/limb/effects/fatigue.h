// SPDX-License-Identifier: Apache-2.0
// Every transformation cycle costs a little of the stroke.
//
//   delta_t -> delta_t (1 - kappa n_j),   n_j = integral of |dxi_j| / 2, cycles done since the start
//
// Source: functional fatigue of Ni-Ti; Eggeler et al. 2004. Leaves out that the loss slows down over thousands of cycles.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct Fatigue {
  static constexpr std::string_view name = "fatigue";
  static constexpr Place place = Place::transformation;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "delta_t -> delta_t (1 - kappa n), n = integral |dxi| / 2";
  static constexpr std::string_view words = "the coils lose stroke with every cycle";
  static constexpr std::array states{StateDeclaration{"cycles_{}", units::none, 1.0, AtStart::counted, 30.0}};

  S loss_per_cycle{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.loss_per_cycle, Declaration{.name = "loss_per_cycle",
                                           .symbol = "kappa",
                                           .unit = units::none,
                                           .range = {0.0, 0.1},
                                           .typical = 0.003,
                                           .null_value = 0.0,
                                           .prior_deviation = 0.005,
                                           .meaning = "share of the transformation stretch lost per full cycle",
                                           .source = "overloaded Flexinol"});
  }

  void rest(const Instant<S>&, std::size_t, S* own) const { own[0] = S(0.0); }
  void stretch(Instant<S>& now, std::size_t coil, const S* own) const {
    now.transformation_stretch_m[coil] = now.transformation_stretch_m[coil] * (1.0 - loss_per_cycle * own[0]);
  }
  void rates(const Instant<S>& now, std::size_t coil, const S*, S* rate) const {
    using std::abs;
    rate[0] = 0.5 * abs(now.martensite_rate_1_s[coil]);
  }
};

}  // namespace sinew::plant
