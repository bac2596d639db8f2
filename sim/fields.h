// SPDX-License-Identifier: Apache-2.0
// Reading and writing plain values whose fields are declared once by `fields(self, visit)`: a scenario's, a training's.
#pragma once

#include <concepts>
#include <string>

#include "plant/integrator.h"
#include "sim/input.h"
#include "sim/text.h"
#include "sim/yaml.h"

namespace sinew::sim {

inline constexpr std::string_view method_names[] = {"cvode", "arkode", "automatic"};

// Visits fields and takes what the map gives for them.
struct Assign {
  YamlMap& map;
  const YamlValue* value(const Key& key) const { return key.required ? &map.require(key.name, key.meaning) : map.find(key.name); }
  void operator()(double& field, const Key& key) const {
    if (const auto* given = value(key)) field = given->number_in(key.range);
  }
  template <std::integral Whole>
  void operator()(Whole& field, const Key& key) const {
    if (const auto* given = value(key)) {
      const std::int64_t whole = given->whole_number();
      if (!key.range.contains(static_cast<double>(whole)))
        given->complain("must lie in [" + shortest(key.range.lowest) + ", " + shortest(key.range.highest) + "]");
      field = static_cast<Whole>(whole);
    }
  }
  void operator()(bool& field, const Key& key) const {
    if (const auto* given = value(key)) field = given->truth();
  }
  void operator()(std::string& field, const Key& key) const {
    if (const auto* given = value(key)) field = given->text();
  }
  void operator()(plant::Method& field, const Key& key) const {
    if (const auto* given = value(key)) {
      for (std::size_t m = 0; m < std::size(method_names); ++m)
        if (given->text() == method_names[m]) {
          field = static_cast<plant::Method>(m);
          return;
        }
      given->complain("must be cvode, arkode or automatic");
    }
  }
};

// Visits fields and appends a line for each.
struct Write {
  std::string& text;
  std::string margin;
  void line(const Key& key, const std::string& value) const { text += margin + key.name + ": " + value + "\n"; }
  void operator()(const double& field, const Key& key) const { line(key, shortest(field)); }
  template <std::integral Whole>
  void operator()(const Whole& field, const Key& key) const {
    line(key, std::to_string(field));
  }
  void operator()(const bool& field, const Key& key) const { line(key, field ? "true" : "false"); }
  void operator()(const std::string& field, const Key& key) const { line(key, field); }
  void operator()(const plant::Method& field, const Key& key) const {
    line(key, std::string(method_names[static_cast<std::size_t>(field)]));
  }
};

// An unknown key is complained of before a missing one, which it may be a misspelling of.
template <class Fields>
void read_fields(const YamlValue& value, Fields&& fields) {
  YamlMap map(value);
  fields([&](const auto&, const Key& key) { map.find(key.name); });
  map.finish();
  fields(Assign{map});
}
template <class One>
void read_fields_of(One& one, const YamlValue& value) {
  read_fields(value, [&](auto&& visit) { One::fields(one, visit); });
}

}  // namespace sinew::sim
