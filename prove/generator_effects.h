// SPDX-License-Identifier: Apache-2.0
// What can be concealed in a limb: names, places, parameters with their plain values, and where each number goes.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "prove/generator.h"
#include "prove/generator_limb.h"

namespace sinew::prove {

// How a core parameter's true value is drawn.
enum class Spread { known, relative, kelvins, offset };

struct CoreNumber {
  std::string_view name;
  Spread spread;
  double Physics::*field;  // its default is that of Physics
};
const std::vector<CoreNumber>& core_numbers();

// How an effect's true value is drawn from its plain one. `signed_strength` draws a sign, too.
enum class Role {
  strength,
  signed_strength,
  from_one,          // 1 - (1 - plain) * strength, as a gain
  root_of_strength,  // plain * sqrt(strength): what enters squared
  shape,
  power_share,  // plain * strength: of the current heat; drawn: over the share of the heat capacity that the number before it gives
  signed_shape,
  fixed,
  onset,        // in the middle third of the training recording, and where it can be within the held-out one
  within_reach  // an angle, plain times the largest that the limb reaches
};

struct Number {
  std::string_view name;
  double plain;
  Role role;
  double Physics::*field;
  double variation = 0.25;  // of the plain value, either way; within_reach has its own
};

struct Effect {
  std::string_view name;
  std::string_view form;  // empty: the catalogue's own, or outside the catalogue
  std::string_view place;
  bool in_catalogue;
  std::string_view words;
  std::vector<Number> numbers;
};
// The catalogue in its order, then other forms, then what is outside; then the body under the thermocouple and the layer around it; then
// further forms, and more that is outside; then the forms that came last.
const std::vector<Effect>& effects();

std::string key_of(const Effect& effect);           // "name" or "name.form"
const Effect& effect_of_key(std::string_view key);  // throws std::invalid_argument
std::string drawn_as(std::string_view name);        // what the draws of a kind, effect or number are named after: its first name

Physics physics_of(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& truth);

struct Draw {
  std::uint64_t seed;
  std::string kind;  // every kind draws its own numbers; `drawn_as`
  double strength, training_s, heldout_s, reach_deg;
  double wire_J_K;  // heat capacity, the mean of the two
};
TruthEffect drawn(const Effect& effect, const Draw& draw);

// The limb that `conceal` makes, in the air of a recording of that name and length: at rest, or as it was left.
Run concealed_run(const Kind& kind, std::uint64_t seed, const Settings& settings, const std::string& recording, double duration_s,
                  const std::optional<Run::Left>& left = std::nullopt);

}  // namespace sinew::prove
