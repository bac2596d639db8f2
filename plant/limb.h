// SPDX-License-Identifier: Apache-2.0
// The limb: the core's parameters, the effects, and which of these are on. Plain values that copy and compare.
//
// An effect is on when a plant file names it with a value other than its null, or when someone turns it on to ask what
// it would do. An effect that is off takes no part at all: it has no states and costs nothing.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "plant/effects.h"

namespace sinew::plant {

template <class S>
struct Limb {
  Core<S> core;
  Effects<S> effects;
  std::array<bool, effect_count> on{};
};

// Calls visit(index, effect) for every effect of the list, in its order; index is a std::integral_constant.
template <class LimbType, class Visitor>
void visit_effects(LimbType& limb, Visitor&& visit) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (visit(std::integral_constant<std::size_t, i>{}, std::get<i>(limb.effects)), ...);
  }(std::make_index_sequence<effect_count>{});
}

inline constexpr std::size_t no_effect = static_cast<std::size_t>(-1);

// One parameter among all there are: first the core's, then each effect's, in the order of their lists.
struct ParameterInfo {
  std::size_t effect = no_effect;  // no_effect: the core's
  std::string_view owner;          // name of the effect; empty for the core
  Declaration declaration;
  std::string key() const;  // "heat_loss_A_W_K", "thermocouple_lag.time_constant_s"
};

struct EffectInfo {
  std::string_view name;
  Place place;
  std::string_view equation;
  std::string_view words;
  std::vector<std::size_t> parameters;  // indices into parameters()
  std::size_t strength;                 // the one among them that has a null
};

const std::vector<ParameterInfo>& parameters();
const std::vector<EffectInfo>& effects();

// Index of the parameter with that key or of the effect with that name; throws std::out_of_range where there is none.
std::size_t parameter_index(std::string_view key);
std::size_t effect_index(std::string_view name);

// Addresses of all parameters of a limb, in the order of parameters(); values are internal (SI, radians, degC).
template <class S>
std::vector<S*> fields(Limb<S>& limb) {
  std::vector<S*> all;
  auto collect = [&](S& field, const Declaration&) { all.push_back(&field); };
  visit_parameters(limb.core, collect);
  visit_effects(limb, [&](auto, auto& effect) { visit_parameters(effect, collect); });
  return all;
}

double get(const Limb<double>& limb, std::size_t parameter);                 // internal units
void set(Limb<double>& limb, std::size_t parameter, double internal_value);  // does not check the range
double get_in_file_units(const Limb<double>& limb, std::size_t parameter);
void set_in_file_units(Limb<double>& limb, std::size_t parameter, double value);

// Turns on every effect whose strength is not at its null, and all others off.
void turn_on_by_strength(Limb<double>& limb);

// The same limb in another scalar, all derivatives zero.
template <class S>
Limb<S> lift(const Limb<double>& limb) {
  Limb<S> lifted;
  const auto to = fields(lifted);
  for (std::size_t i = 0; i < to.size(); ++i) *to[i] = S(get(limb, i));
  lifted.on = limb.on;
  return lifted;
}

bool operator==(const Limb<double>& left, const Limb<double>& right);

}  // namespace sinew::plant
