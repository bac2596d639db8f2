// SPDX-License-Identifier: Apache-2.0
#include "sim/schema.h"

#include <algorithm>

#include "plant/systems.h"
#include "sim/scenario_fields.h"

namespace sinew::sim {
namespace {

using nlohmann::ordered_json;

// What is in a map of such keys and no others.
ordered_json closed(const ordered_json& properties, const ordered_json& required = ordered_json::array()) {
  ordered_json schema{{"type", {"object", "null"}}, {"properties", properties}, {"additionalProperties", false}};
  if (required.empty()) return schema;
  schema["type"] = "object";
  schema["required"] = required;
  return schema;
}

ordered_json number_in(const plant::Range& range, const std::string& meaning) {
  return {{"type", "number"}, {"minimum", range.lowest}, {"maximum", range.highest}, {"description", meaning}};
}

// Visits the fields of a scenario.
struct Describe {
  ordered_json &properties, &required;
  void add(const Key& key, ordered_json schema) const {
    schema["description"] = key.meaning;
    properties[key.name] = std::move(schema);
    if (key.required) required.push_back(key.name);
  }
  void operator()(const double&, const Key& key) const { add(key, number_in(key.range, key.meaning)); }
  void operator()(const bool&, const Key& key) const { add(key, {{"type", "boolean"}}); }
  void operator()(const std::string&, const Key& key) const { add(key, {{"type", "string"}}); }
  void operator()(const plant::Method&, const Key& key) const { add(key, {{"enum", method_names}}); }
};

template <class Fields>
ordered_json map_of(Fields&& fields, ordered_json further = ordered_json::object()) {
  ordered_json properties = ordered_json::object(), required = ordered_json::array();
  fields(Describe{properties, required});
  properties.update(further);
  return closed(properties, required);
}

ordered_json value_schema(const plant::Declaration& declared) {
  std::string meaning(declared.meaning);
  if (!declared.unit.text.empty()) meaning += " [" + std::string(declared.unit.text) + "]";
  switch (declared.kind) {
    case plant::Kind::toggle:
      return {{"type", "boolean"}, {"description", meaning}};
    case plant::Kind::sign:
      return {{"enum", {-1, 1}}, {"description", meaning}};
    case plant::Kind::real:
      break;
  }
  ordered_json schema = number_in(declared.range, meaning);
  schema["default"] = declared.null_value.value_or(declared.typical);
  return schema;
}

// A value, or a value with one standard deviation of what is known of it.
ordered_json known_schema(const plant::Declaration& declared) {
  ordered_json schema = value_schema(declared);
  if (declared.kind != plant::Kind::real) return schema;
  schema["anyOf"] = {{{"type", "number"}}, {{"$ref", "#/definitions/known"}}};
  schema.erase("type");
  return schema;
}

ordered_json parameters_schema(const plant::System& system) {
  ordered_json properties = ordered_json::object();
  for (const auto& info : system.parameters())
    if (!info.effect) properties[info.declaration.name] = known_schema(info.declaration);
  for (const std::string& own : system.own_keys())
    if (!properties.contains(own))
      properties[own] = {{"anyOf", {{{"type", "number"}}, {{"$ref", "#/definitions/known"}}}},
                         {"description", "of one part; else it is shared"}};
  return closed(properties);
}

// An effect that is named gives all its parameters; a part may have values of its own, under its name.
ordered_json effects_schema(const plant::System& system) {
  ordered_json properties = ordered_json::object();
  for (const plant::EffectInfo& effect : system.effects()) {
    if (effect.law) continue;
    ordered_json values = ordered_json::object(), required = ordered_json::array();
    for (const plant::ParameterId p : effect.parameters) {
      const plant::Declaration& declared = system.parameters()[p].declaration;
      values[declared.name] = value_schema(declared);
      required.push_back(declared.name);
    }
    ordered_json schema = closed(values, required);
    schema["additionalProperties"] = schema;
    schema["description"] = effect.words;
    properties[std::string(effect.name)] = schema;
  }
  return closed(properties);
}

// Of a plant of which only its base knows the System.
ordered_json effects_of_all_systems() {
  ordered_json properties = ordered_json::object();
  for (const auto& maker : plant::systems()) {
    const ordered_json of_one = effects_schema(*maker.make({}, {}));
    for (const auto& [name, schema] : of_one["properties"].items()) {
      if (properties.contains(name))
        properties[name]["anyOf"].push_back(schema);
      else
        properties[name] = {{"anyOf", ordered_json::array({schema})}};
    }
  }
  return closed(properties);
}

ordered_json laws_schema() {
  const ordered_json numbers{{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 2}};
  const ordered_json variables{{"anyOf", {{{"type", "string"}}, {{"type", "array"}, {"items", {{"type", "string"}}}}}}};
  ordered_json law = closed({{"entry", {{"type", "string"}}},
                             {"argument", variables},
                             {"times", variables},
                             {"fading_memory_s", number_in({1e-3, 1e6}, "of the argument")},
                             {"knots", numbers},
                             {"values", numbers}},
                            {"entry", "argument", "knots", "values"});
  return {{"type", "array"}, {"items", law}, {"minItems", 1}};
}

std::string signal_of(const plant::InputInfo& input) {
  std::string name = "signal_" + std::string(input.unit.text.empty() ? "fraction" : input.unit.text);
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

// One signal, a map with one key, or a list of those that are added.
ordered_json signal_schema(const plant::InputInfo& input) {
  ordered_json properties = ordered_json::object();
  const auto add = [&]<class One>(std::type_identity<One>) {
    properties[std::string(One::name)] = map_of([&](auto&& visit) {
      One one;
      One::fields(one, [&](const auto& field, const Key& key) { visit(field, key_for(input, key)); });
    });
  };
  [&]<class... All>(std::type_identity<std::variant<All...>>) { (add(std::type_identity<All>{}), ...); }(std::type_identity<Signal>{});
  ordered_json one = closed(properties);
  one["type"] = "object";
  one["minProperties"] = one["maxProperties"] = 1;
  return {{"anyOf", {one, {{"type", "array"}, {"items", one}, {"minItems", 1}}}}};
}

ordered_json input_schema(const plant::System& system, bool others) {
  BabbleInput babble;
  ordered_json properties{{std::string(BabbleInput::name), map_of([&](auto&& visit) { BabbleInput::fields(babble, visit); })},
                          {std::string(ReplayInput::name),
                           closed({{"recording", {{"type", "string"}, {"description", "looked for beside this file"}}}}, {"recording"})}};
  for (const plant::InputInfo& input : system.inputs()) properties[input.column] = {{"$ref", "#/definitions/" + signal_of(input)}};
  ordered_json schema = closed(properties);
  if (others) schema["additionalProperties"] = {{"$ref", "#/definitions/signal_fraction"}};
  return schema;
}

ordered_json sensors_schema(const plant::System& system, bool others) {
  ordered_json properties = ordered_json::object();
  for (const plant::ChannelInfo& channel : system.channels()) {
    SensorSettings settings;
    Stuck stuck;
    properties[channel.short_name] = map_of([&](auto&& visit) { sensor_fields(settings, std::string(channel.unit.text), visit); },
                                            {{"stuck", map_of([&](auto&& visit) { stuck_fields(stuck, visit); })}});
  }
  ordered_json schema = closed(properties);
  if (others) schema["additionalProperties"] = {{"type", "object"}};
  return schema;
}

ordered_json start_schema(const plant::System& system, bool others) {
  ordered_json properties = ordered_json::object();
  for (const auto& state : system.states(plant::EffectsOn(system.effects().size(), true)))
    properties[start_key(state)] = number_in(start_range(state), "at the begin; left out: at rest");
  ordered_json schema = closed(properties);
  if (others) schema["additionalProperties"] = {{"type", "number"}};
  return schema;
}

// A System by its usual structure, and the condition on a plant by which it is told. None: all other plants, which come last; before them
// the plant of a scenario that names none.
struct Known {
  std::shared_ptr<const plant::System> system;
  ordered_json condition;
};

ordered_json not_of(const ordered_json& schema) { return {{"not", schema}}; }
ordered_json has(const std::string& key) { return {{"type", "object"}, {"required", {key}}}; }

std::vector<Known> known_systems() {
  const std::shared_ptr<const plant::System> usual = plant::default_plant().shared_system();
  std::vector<Known> known;
  ordered_json named = ordered_json::array(), anything_else = ordered_json::array();
  for (const auto& maker : plant::systems()) {
    named.push_back(has(maker.name));
    if (maker.name == usual->name()) continue;
    known.push_back({maker.make({}, {}), has(maker.name)});
    anything_else.push_back(has(maker.name));
  }
  const ordered_json base_is_usual{{"properties", {{"base", {{"const", "paper_limb"}}}}}};
  named.push_back(not_of(base_is_usual));
  known.push_back({usual, not_of({{"anyOf", named}})});
  // A limb of another structure, or a base that is a file.
  anything_else.push_back(known.back().condition);
  known.push_back({nullptr, not_of({{"anyOf", anything_else}})});
  return known;
}

ordered_json plant_properties() {
  ordered_json properties{{"format", {{"enum", {1, 2}}}},
                          {"base", {{"type", "string"}, {"description", "paper_limb, or a plant file, looked for beside this one"}}}};
  const std::string of_parts{plant::default_plant().system().name()};  // a limb is nothing without its parts
  for (const auto& maker : plant::systems()) {
    const ordered_json type = maker.name == of_parts ? ordered_json("object") : ordered_json{"object", "null"};
    properties[maker.name] = {{"type", type}, {"description", "the structure of a plant of this kind"}};
  }
  properties["parameters"] = properties["effects"] = {{"type", {"object", "null"}}};
  properties["laws"] = laws_schema();
  return properties;
}

ordered_json plant_of_any_system(const plant::System* system) {
  ordered_json schema = closed(plant_properties());
  schema["allOf"] = ordered_json::array();
  for (const Known& one : known_systems()) {
    const plant::System* of = one.system ? one.system.get() : system;
    ordered_json then{{"parameters",
                       of ? parameters_schema(*of) : ordered_json{{"additionalProperties", {{"type", {"number", "boolean", "object"}}}}}},
                      {"effects", of ? effects_schema(*of) : effects_of_all_systems()}};
    schema["allOf"].push_back({{"if", one.condition}, {"then", {{"properties", then}}}});
  }
  return schema;
}

ordered_json document(const char* title, ordered_json schema) {
  const ordered_json deviation{{"type", "number"},
                               {"minimum", 0},
                               {"description", "one standard deviation of what is known of it; 0: known"}};
  const ordered_json known = closed({{"value", {{"type", "number"}}}, {"deviation", deviation}}, {"value", "deviation"});
  ordered_json result{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", title}, {"definitions", {{"known", known}}}};
  result.update(schema);
  return result;
}

}  // namespace

ordered_json plant_schema(const plant::System* system) {
  ordered_json schema = plant_of_any_system(system);
  schema["type"] = "object";
  return document("A plant of sinew", schema);
}

ordered_json scenario_schema(const plant::System* system) {
  ordered_json properties{{"format", {{"const", 1}}},
                          {"seed", {{"type", "integer"}, {"minimum", 0}, {"description", "of all that is drawn by chance"}}},
                          {"duration_s", number_in(durations_s, "how long the scenario lasts")},
                          {"sample_period_s", number_in(sample_periods_s, "from sample to sample")},
                          {"plant", {{"$ref", "#/definitions/plant"}}},
                          {"start", true},
                          {"input", true},
                          {"sensors", true}};
  Scenario scenario;
  properties["numerics"] = map_of([&](auto&& visit) { numerics_fields(scenario, visit); });
  ordered_json schema = closed(properties, {"format", "duration_s"});
  schema["definitions"] = {{"plant", plant_of_any_system(system)}};
  schema["allOf"] = ordered_json::array();
  const std::shared_ptr<const plant::System> usual = plant::default_plant().shared_system();
  const std::vector<Known> known = known_systems();
  for (const Known& one : known) {
    const bool others = !one.system && !system;
    const plant::System& of = one.system ? *one.system : system ? *system : *usual;
    for (const plant::InputInfo& input : of.inputs()) schema["definitions"][signal_of(input)] = signal_schema(input);
    ordered_json is_one{{"properties", {{"plant", one.condition}}}};
    if (one.system != known[known.size() - 2].system) is_one["required"] = {"plant"};  // where no plant is named it is the usual one
    schema["allOf"].push_back(
        {{"if", is_one},
         {"then",
          {{"properties",
            {{"start", start_schema(of, others)}, {"input", input_schema(of, others)}, {"sensors", sensors_schema(of, others)}}}}}});
  }
  return document("A scenario of sinew", schema);
}

}  // namespace sinew::sim
