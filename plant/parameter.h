// SPDX-License-Identifier: Apache-2.0
// What is declared, once, about a parameter: everything that reads, writes, checks, documents or fits it walks this.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plant/units.h"

namespace sinew::plant {

struct Range {
  double lowest;
  double highest;
  constexpr bool contains(double value) const { return value >= lowest && value <= highest; }
};

enum class Kind {
  real,    // any number in the range
  toggle,  // false or true, kept as 0 or 1; never fitted
  sign,    // -1 or +1; never fitted
};

// All numbers here are in `unit`, the unit of files; see `Unit::internal_per_unit`.
struct Declaration {
  std::string name;    // the key in YAML; ends in its unit
  std::string symbol;  // the letter of docs/plant.md
  Unit unit;
  Kind kind = Kind::real;
  Range range;
  // Core: the default. Effect: a value that a real limb could have, where a fit of the effect starts.
  double typical;
  // The value at which the effect vanishes exactly. Only the parameter that carries an effect's strength has one.
  std::optional<double> null_value = std::nullopt;
  // One standard deviation of what is believed before any recording is seen; 0 for what is known and not fitted.
  double prior_deviation = 0.0;
  // Keys of quantities, in the same unit, that physics puts above this one: what is believed of the two says so.
  std::vector<std::string> less_than = {};
  std::string_view meaning;
  std::string_view source = "";
};

// Whether it is never negative and zero of it is none of it: a half or a double of such a quantity means something, as of no offset and no
// temperature in degC.
inline bool has_natural_zero(const Declaration& declared) {
  return declared.range.lowest >= 0.0 && declared.typical > 0.0 && declared.unit.text != units::degC.text;
}

// A quantity that a limb, or an effect where it acts, cannot be without. What is believed of it is log-normal.
inline bool is_positive(const Declaration& declared) {
  return has_natural_zero(declared) && declared.range.lowest > 0.0 && !declared.null_value;
}

}  // namespace sinew::plant
