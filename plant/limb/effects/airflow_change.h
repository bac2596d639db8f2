// SPDX-License-Identifier: Apache-2.0
// From one moment on, the air around the limb moves more (or less): a door, a fan, the air conditioning.
//
//   h -> h (1 + alpha) from time t_e on
//
// Source: forced convection; Incropera et al., 6th ed. (2007), section 7.4. Leaves out that the change takes time.
#pragma once

#include "plant/limb/instant.h"

namespace sinew::plant {

template <class S>
struct AirflowChange {
  static constexpr std::string_view name = "airflow_change";
  static constexpr Place place = Place::thermal;
  static constexpr Part part = Part::room;
  static constexpr std::string_view equation = "h -> h (1 + alpha) from time t_e on";
  static constexpr std::string_view words = "the air around the limb moves differently from one moment on";

  S relative_change{0.0};
  S onset_s{300.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.relative_change, Declaration{.name = "relative_change",
                                            .symbol = "alpha",
                                            .unit = units::none,
                                            .range = {-0.9, 10.0},
                                            .typical = 0.25,
                                            .null_value = 0.0,
                                            .prior_deviation = 0.3,
                                            .meaning = "relative change of the heat loss coefficient",
                                            .source = "a light draught"});
    visit(self.onset_s, Declaration{.name = "onset_s",
                                    .symbol = "t_e",
                                    .unit = units::s,
                                    .range = {0.0, 1.0e6},
                                    .typical = 300.0,
                                    .prior_deviation = 300.0,
                                    .meaning = "time of the change"});
  }

  void environment(Instant<S>& now, std::size_t) const {
    if (now.given->segment_start_s >= value_of(onset_s))
      for (S& heat_loss_W_K : now.heat_loss_W_K) heat_loss_W_K = heat_loss_W_K * (1.0 + relative_change);
  }
  // The right-hand side jumps here; the integrator stops and starts again.
  S switch_time_s() const { return onset_s; }
};

}  // namespace sinew::plant
