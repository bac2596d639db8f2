// SPDX-License-Identifier: Apache-2.0
// The right-hand side: from the limb's state to its rate of change and to what its sensors would show.
//
// State vector: T_A, T_B [degC], xi_A, xi_B, theta [rad], omega [rad/s], then the states of every effect that is on, in
// the order of effects.h. One code for numbers and for their derivatives: S is double or a Jet.
#pragma once

#include <concepts>

#include "plant/beam.h"
#include "plant/coil.h"
#include "plant/limb.h"
#include "plant/wire.h"

namespace sinew::plant {

namespace core_state {
inline constexpr std::size_t temperature = 0, martensite = 2, angle = 4, angular_velocity = 5, count = 6;
}

// Names, units and scales of all states of a limb, and where each effect's begin.
struct Layout {
  struct Entry {
    std::string key;  // "temperature_A_degC", "viscoelastic_creep.angle_rad"
    StateDeclaration declaration;
  };
  std::vector<Entry> entries;
  std::array<std::size_t, effect_count> first{};
  std::size_t size() const { return entries.size(); }
};
Layout layout_of(const std::array<bool, effect_count>& on);

template <class Effect>
concept HasStates = requires { Effect::states.size(); };

inline constexpr std::size_t largest_state_count = [] {
  std::size_t count = core_state::count;
  [&]<class... E>(std::type_identity<std::tuple<E...>>) {
    ((count += [] {
       if constexpr (HasStates<E>) return E::states.size();
       return std::size_t{0};
     }()),
     ...);
  }(std::type_identity<Effects<double>>{});
  return count;
}();

template <class S>
class Equations {
 public:
  explicit Equations(const Limb<S>& limb) : limb_(limb), layout_(layout_of(limb.on)) {
    for (const bool on : limb_.on) any_on_ = any_on_ || on;
  }

  const Limb<S>& limb() const { return limb_; }
  Limb<S>& limb() { return limb_; }  // values may change; what is on may not
  const Layout& layout() const { return layout_; }

  // rates: dy/dt, as long as y.
  void evaluate(const Situation& given, const S* y, Instant<S>& now, S* rates) const;

  // After `evaluate` of the same instant.
  Reading<S> reading(const Instant<S>& now, const S* y) const;

  // Heat held by the wires and by every effect that stores heat, up to a constant.
  S stored_heat_J(const Instant<S>& now, const S* y) const;

  // Sum of what delays commands, and the moments at which an effect switches.
  S command_delay_s() const;
  std::vector<S> switch_times_s() const;

  // The state at rest: wires at ambient temperature unless `given` has their entries, their fractions on the cooling
  // envelope unless given, effects at rest unless given, and the beam in static balance unless its angle is given.
  // `given` has one entry a state, each possibly empty.
  std::vector<S> rest(const Situation& situation, const std::vector<std::optional<S>>& given) const;

 private:
  template <class Visitor>
  void each_on(Visitor&& visit) const {
    if (!any_on_) return;
    visit_effects(limb_, [&](auto index, const auto& effect) {
      if (limb_.on[index]) visit(effect, layout_.first[index]);
    });
  }

  Limb<S> limb_;
  Layout layout_;
  bool any_on_ = false;
};

// Calls the member function of that name on every effect that has it, with its own states where it wants them.
#define SINEW_STAGE(stage)                                                                        \
  each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {                           \
    if constexpr (requires { effect.stage(now); })                                                \
      effect.stage(now);                                                                          \
    else if constexpr (requires { effect.stage(now, y); })                                        \
      effect.stage(now, y + first);                                                               \
  })

// Flattened: a Jet's operators cost more as calls than the arithmetic in them.
template <class S>
[[gnu::flatten]] void Equations<S>::evaluate(const Situation& given, const S* y, Instant<S>& now, S* rates) const {
  const Core<S>& core = limb_.core;
  now.given = given;
  now.core = &core;
  for (const std::size_t j : coils) {
    now.temperature_degC[j] = y[core_state::temperature + j];
    now.martensite_fraction[j] = y[core_state::martensite + j];
  }
  now.angle_rad = y[core_state::angle];
  now.angular_velocity_rad_s = y[core_state::angular_velocity];

  now.ambient_temperature_degC = core.ambient_temperature_degC;
  now.heat_loss_W_K = core.heat_loss_W_K;
  SINEW_STAGE(environment);

  for (const std::size_t j : coils) {
    now.stretch_m[j] = coil_stretch_m(j, core, now.angle_rad);
    now.longer_share[j] = now.martensite_fraction[j];
    now.transformation_stretch_m[j] = core.transformation_stretch_m;
  }
  SINEW_STAGE(stretch);

  for (const std::size_t j : coils)
    now.tension_N[j] =
        coil_tension_N(coil_stiffness_N_m(now.martensite_fraction[j], core.austenite_stiffness_N_m,
                                          core.martensite_stiffness_N_m),
                       now.stretch_m[j], now.longer_share[j], now.transformation_stretch_m[j]);
  SINEW_STAGE(tension);

  for (const std::size_t j : coils) {
    now.heating_midpoint_degC[j] = core.heating_midpoint_degC;
    now.cooling_midpoint_degC[j] = core.cooling_midpoint_degC;
  }
  SINEW_STAGE(envelopes);

  for (const std::size_t j : coils) {
    const Envelopes<S> envelope =
        envelopes(now.temperature_degC[j], now.heating_midpoint_degC[j], core.heating_width_K,
                  now.cooling_midpoint_degC[j], core.cooling_width_K);
    now.heating_envelope[j] = envelope.heating;
    now.cooling_envelope[j] = envelope.cooling;
    now.pull_1_s[j] = pull_to_envelopes_1_s(now.martensite_fraction[j], envelope, core.transformation_time_s);
    now.warming_slope_1_K[j] = S(0.0);
    now.cooling_slope_1_K[j] = S(0.0);
  }
  SINEW_STAGE(transformation);

  for (const std::size_t j : coils) now.duty_fraction[j] = S(given.duty_fraction[j]);
  now.resistance_Ohm = core.resistance_Ohm;
  now.supply_voltage_V = core.supply_voltage_V;
  SINEW_STAGE(electrics);

  const S voltage_squared = now.supply_voltage_V * now.supply_voltage_V;
  now.heat_to_surroundings_W = S(0.0);
  for (const std::size_t j : coils) {
    now.joule_heat_W[j] = now.duty_fraction[j] * voltage_squared / now.resistance_Ohm[j];
    const S loss_W = now.heat_loss_W_K[j] * (now.temperature_degC[j] - now.ambient_temperature_degC);
    now.heat_to_surroundings_W += loss_W;
    now.heat_W[j] = now.joule_heat_W[j] - loss_W;
    now.latent_heat_J[j] = S(0.0);
  }
  SINEW_STAGE(heat);

  // Heat balance C dT/dt = q + L dxi/dt and dxi/dt = pull + slope dT/dt, solved together. The denominator is positive
  // (slopes are not), so dT/dt has the sign of the numerator, which says which slope holds.
  for (const std::size_t j : coils) {
    const S numerator = now.heat_W[j] + now.latent_heat_J[j] * now.pull_1_s[j];
    const S& slope = value_of(numerator) > 0.0 ? now.warming_slope_1_K[j] : now.cooling_slope_1_K[j];
    now.temperature_rate_K_s[j] = numerator / (core.heat_capacity_J_K[j] - now.latent_heat_J[j] * slope);
    now.martensite_rate_1_s[j] = now.pull_1_s[j] + slope * now.temperature_rate_K_s[j];
  }

  now.moment_Nm = beam_moment_Nm(core, now.tension_N, now.angle_rad, now.angular_velocity_rad_s);
  SINEW_STAGE(moment);

  for (const std::size_t j : coils) {
    rates[core_state::temperature + j] = now.temperature_rate_K_s[j];
    rates[core_state::martensite + j] = now.martensite_rate_1_s[j];
  }
  rates[core_state::angle] = now.angular_velocity_rad_s;
  rates[core_state::angular_velocity] = now.moment_Nm / core.beam_inertia_kgm2;
  each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {
    if constexpr (HasStates<std::remove_cvref_t<decltype(effect)>>) effect.rates(now, y + first, rates + first);
  });
}

template <class S>
Reading<S> Equations<S>::reading(const Instant<S>& now, const S* y) const {
  Reading<S> shown{now.temperature_degC, now.angle_rad};
  each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {
    if constexpr (requires { effect.reading(now, shown); })
      effect.reading(now, shown);
    else if constexpr (requires { effect.reading(now, y, shown); })
      effect.reading(now, y + first, shown);
  });
  shown.angle_rad = shown.angle_rad + limb_.core.angle_offset_rad;
  return shown;
}

template <class S>
S Equations<S>::stored_heat_J(const Instant<S>& now, const S* y) const {
  S stored(0.0);
  for (const std::size_t j : coils) stored += limb_.core.heat_capacity_J_K[j] * now.temperature_degC[j];
  each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {
    if constexpr (requires { effect.stored_heat_J(now); })
      stored += effect.stored_heat_J(now);
    else if constexpr (requires { effect.stored_heat_J(now, y); })
      stored += effect.stored_heat_J(now, y + first);
  });
  return stored;
}

template <class S>
S Equations<S>::command_delay_s() const {
  S delay(0.0);
  each_on([&](const auto& effect, std::size_t) {
    if constexpr (requires { effect.command_delay_s(); }) delay += effect.command_delay_s();
  });
  return delay;
}

template <class S>
std::vector<S> Equations<S>::switch_times_s() const {
  std::vector<S> times;
  each_on([&](const auto& effect, std::size_t) {
    if constexpr (requires { effect.switch_time_s(); }) times.push_back(effect.switch_time_s());
  });
  return times;
}

template <class S>
std::vector<S> Equations<S>::rest(const Situation& situation, const std::vector<std::optional<S>>& given) const {
  const std::size_t n = layout_.size();
  std::vector<S> y(n, S(0.0)), rates(n, S(0.0));
  const auto given_or = [&](std::size_t i, const S& otherwise) { return given[i] ? *given[i] : otherwise; };

  y[core_state::angle] = given_or(core_state::angle, S(0.0));
  Instant<S> now;
  // What depends on what: fractions on tension (where stress moves the envelopes), tension on angle and fractions, angle on
  // all. Each pass is a contraction, in the derivatives too; the Newton step for the angle has a slope from differences,
  // which slows the derivatives' convergence only by the slope's relative error.
  // Derivatives follow the values a few passes later.
  constexpr int most_passes = 400, settled_passes = 8;
  for (const std::size_t j : coils) {
    y[core_state::temperature + j] = given_or(core_state::temperature + j, limb_.core.ambient_temperature_degC);
    y[core_state::martensite + j] = given_or(core_state::martensite + j, S(1.0));
  }
  const auto settle_effects = [&] {
    each_on([&](const auto& effect, [[maybe_unused]] std::size_t first) {
      using Effect = std::remove_cvref_t<decltype(effect)>;
      if constexpr (HasStates<Effect>) {
        effect.rest(now, y.data() + first);
        for (std::size_t i = 0; i < Effect::states.size(); ++i)
          if (given[first + i]) y[first + i] = *given[first + i];
      }
    });
  };
  const auto evaluate_here = [&] { evaluate(situation, y.data(), now, rates.data()); };
  std::vector<double> before(n);
  double relaxation = 1.0, last_change = 1e300;
  for (int pass = 0, settled = 0; pass < most_passes && settled < settled_passes; ++pass) {
    for (std::size_t i = 0; i < n; ++i) before[i] = value_of(y[i]);
    evaluate_here();
    for (const std::size_t j : coils) {
      if (!given[core_state::temperature + j]) y[core_state::temperature + j] = now.ambient_temperature_degC;
      S& xi = y[core_state::martensite + j];
      if (!given[core_state::martensite + j]) xi = xi + relaxation * (now.cooling_envelope[j] - xi);
    }
    evaluate_here();
    settle_effects();
    if (!given[core_state::angle]) {
      evaluate_here();
      const S moment = now.moment_Nm;
      const S angle = y[core_state::angle];
      constexpr double difference_rad = 1e-6;
      y[core_state::angle] = angle + difference_rad;
      evaluate_here();
      settle_effects();
      evaluate_here();
      const double slope = (value_of(now.moment_Nm) - value_of(moment)) / difference_rad;
      // A stable balance has a negative slope; elsewhere move down the moment with the beam's own stiffness.
      const double used_slope = slope < 0.0 ? slope : -value_of(limb_.core.beam_stiffness_Nm_rad);
      const S step = -1.0 * moment / used_slope;
      constexpr double longest_step_rad = 0.5;
      y[core_state::angle] =
          angle + (std::abs(value_of(step)) > longest_step_rad ? S(std::copysign(longest_step_rad, value_of(step))) : step);
    }
    double change = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      change = std::max(change, std::abs(value_of(y[i]) - before[i]) / layout_.entries[i].declaration.scale);
    settled = change < 1e-13 ? settled + 1 : 0;
    // Where stress moves the envelopes far, whole steps overshoot.
    if (settled == 0 && change > 0.9 * last_change) relaxation = std::max(0.05, 0.7 * relaxation);
    last_change = change;
  }
  evaluate_here();
  settle_effects();
  y[core_state::angular_velocity] = given_or(core_state::angular_velocity, S(0.0));
  return y;
}

#undef SINEW_STAGE

extern template class Equations<double>;
extern template class Equations<Jet<8>>;
extern template class Equations<Jet<16>>;

}  // namespace sinew::plant
