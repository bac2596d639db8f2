// SPDX-License-Identifier: Apache-2.0
// Every transformation cycle costs a little of the stroke.
//
//   delta_t -> delta_t (1 - kappa n_j),   n_j = integral of |dxi_j| / 2, cycles done since the start
//
// Source: functional fatigue of Ni-Ti; Eggeler et al. 2004. Leaves out that the loss slows down over thousands of cycles.
#pragma once

#include "plant/instant.h"

namespace sinew::plant {

template <class S>
struct Fatigue {
  static constexpr std::string_view name = "fatigue";
  static constexpr Place place = Place::transformation;
  static constexpr std::string_view equation = "delta_t -> delta_t (1 - kappa n), n = integral |dxi| / 2";
  static constexpr std::string_view words = "the coils lose stroke with every cycle";
  static constexpr std::array states{StateDeclaration{"cycles_A", units::none, 1.0, false},
                                     StateDeclaration{"cycles_B", units::none, 1.0, false}};

  S loss_per_cycle{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.loss_per_cycle,
          Declaration{.name = "loss_per_cycle", .symbol = "kappa", .unit = units::none, .range = {0.0, 0.1},
                      .typical = 0.003, .null_value = 0.0, .prior_deviation = 0.005,
                      .meaning = "share of the transformation stretch lost per full cycle", .source = "overloaded Flexinol"});
  }

  void rest(const Instant<S>&, S* own) const {
    for (const std::size_t j : coils) own[j] = S(0.0);
  }
  void stretch(Instant<S>& now, const S* own) const {
    for (const std::size_t j : coils)
      now.transformation_stretch_m[j] = now.transformation_stretch_m[j] * (1.0 - loss_per_cycle * own[j]);
  }
  void rates(const Instant<S>& now, const S*, S* rate) const {
    using std::abs;
    for (const std::size_t j : coils) rate[j] = 0.5 * abs(now.martensite_rate_1_s[j]);
  }
};

}  // namespace sinew::plant
