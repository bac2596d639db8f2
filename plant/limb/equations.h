// SPDX-License-Identifier: Apache-2.0
// The right-hand side of a limb: from its state to its rate of change and to what its sensors would show.
//
// State vector: temperatures of the coils [degC], their martensite fractions, angles of the bends [rad], angular velocities
// [rad/s], then the states of every effect that is on, in the order of effects.h. One code for numbers and for their derivatives:
// S is double or a Jet.
#pragma once

#include <algorithm>

#include "plant/limb/beam.h"
#include "plant/limb/coil.h"
#include "plant/limb/effects.h"
#include "plant/limb/wire.h"

namespace sinew::plant {

template <class S>
using LimbValues = ValueSet<Core<S>, Effects<S>>;

// Where the core's states begin in the state vector.
struct CoreStates {
  explicit CoreStates(const Shape& shape)
      : martensite(shape.coils.size()),
        angle(2 * martensite),
        angular_velocity(angle + shape.bends.size()),
        count(angular_velocity + shape.bends.size()) {}
  std::size_t temperature = 0, martensite, angle, angular_velocity, count;
};

std::size_t part_count(const Shape& shape, Part part);
// What an effect's `part` argument is, for the k-th part of its kind.
inline std::size_t part_of(const Shape& shape, Part part, std::size_t k) {
  if (part == Part::thermocouple) return shape.thermocouple_coils[k];
  if (part == Part::bend_sensor) return shape.sensor_bends[k];
  return k;
}
// Names of the parts of a kind, as they stand in keys: "" where there is one that needs none.
std::vector<std::string> part_names(const Shape& shape, Part part);

template <class S>
class LimbEquations final : public Equations<S> {
 public:
  // `shape` must outlive this, by `alive` or otherwise.
  LimbEquations(std::shared_ptr<const System> alive, const Shape& shape, const OwnParts& own, const std::vector<S>& values,
                const EffectsOn& on, const States& states);
  LimbEquations(const LimbEquations&) = delete;

  void rates(const Situation& given, const S* y, S* rates) override;
  void readings(const S* y, S* readings) override;
  std::vector<S> rest(const Situation& given, const std::vector<std::optional<S>>& known) override;
  S input_delay_s() const override;
  std::vector<S> switch_times_s() const override;
  void variables(const S* y, S* values) const override;

  // After `rates` of the same instant.
  const Instant<S>& instant() const { return now_; }
  // Heat held by the wires and by every effect that stores heat, up to a constant.
  S stored_heat_J(const S* y) const;

 private:
  // visit(effect, part, index of its first own state), for every part of every effect that is on.
  template <class Visitor>
  void each_on(Visitor&& visit) const {
    if (!any_on_) return;
    values_.each_effect([&](auto index, const auto& instances) {
      if (!on_[index]) return;
      using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
      const std::size_t parts = part_counts_[index];
      for (std::size_t k = 0; k < parts; ++k)
        visit(instances.of(k), part_of(shape_, Effect::part, k), first_[index] + k * states_per_part<Effect>());
    });
  }

  std::shared_ptr<const System> alive_;
  const Shape& shape_;
  CoreStates at_;
  LimbValues<S> values_;
  EffectsOn on_;
  States states_;
  std::array<std::size_t, std::tuple_size_v<Effects<S>>> first_{}, part_counts_{};
  bool any_on_ = false;
  Situation rest_situation_;
  Instant<S> now_;
};

// Calls the member function of that name on every effect that has it, with its own states where it wants them.
#define SINEW_STAGE(stage)                                                                \
  each_on([&](const auto& effect, std::size_t part, [[maybe_unused]] std::size_t first) { \
    if constexpr (requires { effect.stage(now, part); })                                  \
      effect.stage(now, part);                                                            \
    else if constexpr (requires { effect.stage(now, part, y); })                          \
      effect.stage(now, part, y + first);                                                 \
  })

template <class S>
LimbEquations<S>::LimbEquations(std::shared_ptr<const System> alive, const Shape& shape, const OwnParts& own, const std::vector<S>& values,
                                const EffectsOn& on, const States& states)
    : alive_(std::move(alive)), shape_(shape), at_(shape), values_(Core<S>(shape), own), on_(on), states_(states), now_(values_.core) {
  values_.assign(values);
  const std::vector<S>& heat_capacity_J_K = values_.core.heat_capacity_J_K;
  S sum_J_K(0.0);
  for (const S& one_J_K : heat_capacity_J_K) sum_J_K += one_J_K;
  now_.mean_heat_capacity_J_K = sum_J_K / static_cast<double>(heat_capacity_J_K.size());
  std::size_t next = at_.count;
  values_.each_effect([&](auto index, const auto& instances) {
    using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
    any_on_ = any_on_ || on_[index];
    first_[index] = next;
    part_counts_[index] = part_count(shape_, Effect::part);
    if (on_[index]) next += part_counts_[index] * states_per_part<Effect>();
  });
}

template <class S>
SINEW_FLATTEN void LimbEquations<S>::rates(const Situation& given, const S* y, S* rates) {
  const Core<S>& core = values_.core;
  Instant<S>& now = now_;
  const std::size_t coils = shape_.coils.size(), bends = shape_.bends.size();
  now.given = &given;
  for (std::size_t j = 0; j < coils; ++j) {
    now.temperature_degC[j] = y[at_.temperature + j];
    now.martensite_fraction[j] = y[at_.martensite + j];
  }
  for (std::size_t b = 0; b < bends; ++b) {
    now.angle_rad[b] = y[at_.angle + b];
    now.angular_velocity_rad_s[b] = y[at_.angular_velocity + b];
  }

  now.ambient_temperature_degC = core.ambient_temperature_degC;
  for (std::size_t j = 0; j < coils; ++j) {
    now.heat_loss_W_K[j] = core.heat_loss_W_K[j];
    now.heat_capacity_J_K[j] = core.heat_capacity_J_K[j];
  }
  SINEW_STAGE(environment);

  stretch_coils(now);
  for (std::size_t j = 0; j < coils; ++j) {
    now.longer_share[j] = now.martensite_fraction[j];
    now.transformation_stretch_m[j] = core.transformation_stretch_m[j];
  }
  SINEW_STAGE(stretch);

  for (std::size_t j = 0; j < coils; ++j)
    now.tension_N[j] =
        coil_tension_N(coil_stiffness_N_m(now.martensite_fraction[j], core.austenite_stiffness_N_m[j], core.martensite_stiffness_N_m[j]),
                       now.stretch_m[j], now.longer_share[j], now.transformation_stretch_m[j]);
  SINEW_STAGE(tension);

  for (std::size_t j = 0; j < coils; ++j) {
    now.heating_midpoint_degC[j] = core.heating_midpoint_degC[j];
    now.cooling_midpoint_degC[j] = core.cooling_midpoint_degC[j];
  }
  SINEW_STAGE(envelopes);

  for (std::size_t j = 0; j < coils; ++j) {
    const Envelopes<S> envelope = envelopes(now.temperature_degC[j], now.heating_midpoint_degC[j], core.heating_width_K[j],
                                            now.cooling_midpoint_degC[j], core.cooling_width_K[j]);
    now.heating_envelope[j] = envelope.heating;
    now.cooling_envelope[j] = envelope.cooling;
    now.pull_1_s[j] = pull_to_envelopes_1_s(now.martensite_fraction[j], envelope, core.transformation_time_s[j]);
    now.warming_slope_1_K[j] = S(0.0);
    now.cooling_slope_1_K[j] = S(0.0);
  }
  SINEW_STAGE(transformation);

  for (std::size_t j = 0; j < coils; ++j) {
    now.duty_fraction[j] = S(given.input(j));
    now.resistance_Ohm[j] = core.resistance_Ohm[j];
  }
  now.supply_voltage_V = core.supply_voltage_V;
  SINEW_STAGE(electrics);

  const S voltage_squared = now.supply_voltage_V * now.supply_voltage_V;
  now.heat_to_surroundings_W = S(0.0);
  for (std::size_t j = 0; j < coils; ++j) {
    now.joule_heat_W[j] = now.duty_fraction[j] * voltage_squared / now.resistance_Ohm[j];
    const S loss_W = now.heat_loss_W_K[j] * (now.temperature_degC[j] - now.ambient_temperature_degC);
    now.heat_to_surroundings_W += loss_W;
    now.heat_W[j] = now.joule_heat_W[j] - loss_W;
    now.latent_heat_J[j] = S(0.0);
  }
  SINEW_STAGE(heat);

  // Heat balance C dT/dt = q + L dxi/dt and dxi/dt = pull + slope dT/dt, solved together. The denominator is positive
  // (slopes are not), so dT/dt has the sign of the numerator, which says which slope holds.
  for (std::size_t j = 0; j < coils; ++j) {
    const S numerator = now.heat_W[j] + now.latent_heat_J[j] * now.pull_1_s[j];
    const S& slope = value_of(numerator) > 0.0 ? now.warming_slope_1_K[j] : now.cooling_slope_1_K[j];
    now.temperature_rate_K_s[j] = numerator / (now.heat_capacity_J_K[j] - now.latent_heat_J[j] * slope);
    now.martensite_rate_1_s[j] = now.pull_1_s[j] + slope * now.temperature_rate_K_s[j];
  }
  SINEW_STAGE(sensor_body);

  bend_beams(now);
  SINEW_STAGE(moment);

  for (std::size_t j = 0; j < coils; ++j) {
    rates[at_.temperature + j] = now.temperature_rate_K_s[j];
    rates[at_.martensite + j] = now.martensite_rate_1_s[j];
  }
  for (std::size_t b = 0; b < bends; ++b) {
    rates[at_.angle + b] = now.angular_velocity_rad_s[b];
    rates[at_.angular_velocity + b] = now.moment_Nm[b] / core.beam_inertia_kgm2[shape_.bends[b].segment];
  }
  each_on([&](const auto& effect, std::size_t part, [[maybe_unused]] std::size_t first) {
    if constexpr (HasStates<std::remove_cvref_t<decltype(effect)>>) effect.rates(now, part, y + first, rates + first);
  });
}

template <class S>
void LimbEquations<S>::readings(const S* y, S* readings) {
  Instant<S>& now = now_;
  for (std::size_t j = 0; j < shape_.coils.size(); ++j) now.shown_temperature_degC[j] = now.temperature_degC[j];
  for (std::size_t b = 0; b < shape_.bends.size(); ++b) now.shown_angle_rad[b] = now.angle_rad[b];
  SINEW_STAGE(reading);
  for (std::size_t c = 0; c < shape_.sensors.size(); ++c) {
    const auto& [column, kind, part] = shape_.sensors[c];
    if (kind == Sensing::thermocouple)
      readings[c] = now.shown_temperature_degC[part];
    else
      readings[c] = (kind == Sensing::bend ? now.shown_angle_rad : now.angle_rad)[part] + values_.core.angle_offset_rad[part];
  }
}

template <class S>
S LimbEquations<S>::stored_heat_J(const S* y) const {
  const Instant<S>& now = now_;
  S stored(0.0);
  for (std::size_t j = 0; j < shape_.coils.size(); ++j) stored += values_.core.heat_capacity_J_K[j] * now.temperature_degC[j];
  each_on([&](const auto& effect, std::size_t part, [[maybe_unused]] std::size_t first) {
    if constexpr (requires { effect.stored_heat_J(now, part); })
      stored += effect.stored_heat_J(now, part);
    else if constexpr (requires { effect.stored_heat_J(now, part, y); })
      stored += effect.stored_heat_J(now, part, y + first);
  });
  return stored;
}

template <class S>
S LimbEquations<S>::input_delay_s() const {
  S delay(0.0);
  each_on([&](const auto& effect, std::size_t, std::size_t) {
    if constexpr (requires { effect.input_delay_s(); }) delay += effect.input_delay_s();
  });
  return delay;
}

template <class S>
std::vector<S> LimbEquations<S>::switch_times_s() const {
  std::vector<S> times;
  each_on([&](const auto& effect, std::size_t, std::size_t) {
    if constexpr (requires { effect.switch_time_s(); }) times.push_back(effect.switch_time_s());
  });
  return times;
}

// Order of LimbSystem's variables.
template <class S>
void LimbEquations<S>::variables(const S*, S* values) const {
  const Instant<S>& now = now_;
  using std::abs;
  const auto put = [&](const S& value) { *values++ = value; };
  for (std::size_t j = 0; j < shape_.coils.size(); ++j) {
    put(now.temperature_degC[j]);
    put(now.temperature_rate_K_s[j]);
    put(now.martensite_fraction[j]);
    put(now.duty_fraction[j]);
  }
  for (std::size_t b = 0; b < shape_.bends.size(); ++b) {
    const S speed = now.angular_velocity_rad_s[b] / radians_per_degree;
    put(now.angle_rad[b] / radians_per_degree);
    put(speed);
    put(abs(speed));
  }
  put(S(now.given->time_s));
  for (std::size_t j = 0; j < shape_.coils.size(); ++j) {
    put(now.heat_loss_W_K[j] * (now.ambient_temperature_degC - now.temperature_degC[j]));
    put(now.joule_heat_W[j]);
  }
}

// Wires at ambient temperature, their fractions on the cooling envelope, effects at rest, and the beams in static balance,
// each unless it is known.
template <class S>
std::vector<S> LimbEquations<S>::rest(const Situation& situation, const std::vector<std::optional<S>>& known) {
  const std::size_t n = states_.size(), coils = shape_.coils.size(), bends = shape_.bends.size();
  const Instant<S>& now = now_;
  rest_situation_ = situation;
  std::vector<S> y(n, S(0.0)), rate(n, S(0.0));
  const auto known_or = [&](std::size_t i, const S& otherwise) { return known[i] ? *known[i] : otherwise; };

  for (std::size_t b = 0; b < bends; ++b) y[at_.angle + b] = known_or(at_.angle + b, S(0.0));
  // What depends on what: fractions on tension (where stress moves the envelopes), tension on angle and fractions, angle on
  // all. Each pass is a contraction, in the derivatives too; the Newton step for the angle has a slope from differences,
  // which slows the derivatives' convergence only by the slope's relative error.
  // Derivatives follow the values a few passes later.
  constexpr int most_passes = 400, settled_passes = 8;
  for (std::size_t j = 0; j < coils; ++j) {
    y[at_.temperature + j] = known_or(at_.temperature + j, values_.core.ambient_temperature_degC);
    y[at_.martensite + j] = known_or(at_.martensite + j, S(1.0));
  }
  const auto settle_effects = [&] {
    each_on([&](const auto& effect, std::size_t part, [[maybe_unused]] std::size_t first) {
      using Effect = std::remove_cvref_t<decltype(effect)>;
      if constexpr (HasStates<Effect>) {
        effect.rest(now, part, y.data() + first);
        for (std::size_t i = 0; i < Effect::states.size(); ++i)
          if (known[first + i]) y[first + i] = *known[first + i];
      }
    });
  };
  const auto evaluate_here = [&] { rates(rest_situation_, y.data(), rate.data()); };
  std::vector<double> before(n);
  double relaxation = 1.0, last_change = 1e300;
  for (int pass = 0, settled = 0; pass < most_passes && settled < settled_passes; ++pass) {
    for (std::size_t i = 0; i < n; ++i) before[i] = value_of(y[i]);
    evaluate_here();
    for (std::size_t j = 0; j < coils; ++j) {
      if (!known[at_.temperature + j]) y[at_.temperature + j] = now.ambient_temperature_degC;
      S& xi = y[at_.martensite + j];
      if (!known[at_.martensite + j]) xi = xi + relaxation * (now.cooling_envelope[j] - xi);
    }
    evaluate_here();
    settle_effects();
    for (std::size_t b = 0; b < bends; ++b) {
      if (known[at_.angle + b]) continue;
      evaluate_here();
      const S moment = now.moment_Nm[b];
      const S angle = y[at_.angle + b];
      constexpr double difference_rad = 1e-6;
      y[at_.angle + b] = angle + difference_rad;
      evaluate_here();
      settle_effects();
      evaluate_here();
      const double slope = (value_of(now.moment_Nm[b]) - value_of(moment)) / difference_rad;
      // A stable balance has a negative slope; elsewhere move down the moment with the beam's own stiffness.
      const double used_slope = slope < 0.0 ? slope : -value_of(values_.core.beam_stiffness_Nm_rad[shape_.bends[b].segment]);
      const S step = -1.0 * moment / used_slope;
      constexpr double longest_step_rad = 0.5;
      y[at_.angle + b] = angle + (std::abs(value_of(step)) > longest_step_rad ? S(std::copysign(longest_step_rad, value_of(step))) : step);
    }
    double change = 0.0;
    for (std::size_t i = 0; i < n; ++i) change = std::max(change, std::abs(value_of(y[i]) - before[i]) / states_.values()[i].scale);
    settled = change < 1e-13 ? settled + 1 : 0;
    // Where stress moves the envelopes far, whole steps overshoot.
    if (settled == 0 && change > 0.9 * last_change) relaxation = std::max(0.05, 0.7 * relaxation);
    last_change = change;
  }
  evaluate_here();
  settle_effects();
  for (std::size_t b = 0; b < bends; ++b) y[at_.angular_velocity + b] = known_or(at_.angular_velocity + b, S(0.0));
  return y;
}

#undef SINEW_STAGE

}  // namespace sinew::plant
