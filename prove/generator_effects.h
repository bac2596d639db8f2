// SPDX-License-Identifier: Apache-2.0
// What can be concealed in a limb: names, places, parameters with their plain values, and where each number goes.
#pragma once

#include <cstdint>
#include <map>
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
};

struct Effect {
  std::string_view name;
  std::string_view form;  // empty: the catalogue's own, or outside the catalogue
  std::string_view place;
  bool in_catalogue;
  std::string_view words;
  std::vector<Number> numbers;
};
// The catalogue in its order, then other forms, then what is outside.
const std::vector<Effect>& effects();

std::string key_of(const Effect& effect);           // "name" or "name.form"
const Effect& effect_of_key(std::string_view key);  // throws std::invalid_argument

Physics physics_of(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& truth);

struct Draw {
  std::uint64_t seed;
  std::string kind;  // every kind draws its own numbers
  double strength, training_s, heldout_s, reach_deg;
};
TruthEffect drawn(const Effect& effect, const Draw& draw);

}  // namespace sinew::prove
