// SPDX-License-Identifier: Apache-2.0
// A coil can pull but not push: it goes slack.
//
//   F -> max(0, F)
//
// Source: docs/plant.md, section 2. Either there or not: it has no strength to fit.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct CoilSlack {
  static constexpr std::string_view name = "coil_slack";
  static constexpr Place place = Place::mechanics;
  static constexpr Part part = Part::coil;
  static constexpr std::string_view equation = "F -> max(0, F)";
  static constexpr std::string_view words = "a coil goes slack instead of pushing";

  S enabled{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.enabled, Declaration{.name = "enabled",
                                    .symbol = "on",
                                    .unit = units::none,
                                    .kind = Kind::toggle,
                                    .range = {0.0, 1.0},
                                    .typical = 1.0,
                                    .null_value = 0.0,
                                    .meaning = "whether a coil can go slack"});
  }

  void tension(Instant<S>& now, std::size_t coil) const {
    if (value_of(enabled) != 0.0) now.tension_N[coil] = positive_part(now.tension_N[coil]);
  }
};

}  // namespace sinew::plant
