// SPDX-License-Identifier: Apache-2.0
// Parameters of a core and of a list of effects, walked once: what a System's lists, its values and its equations are made of.
//
// A core and an effect are structs of scalars with a static member function `parameters(self, visit)` that declares each field.
// An effect acts on parts of one kind (each coil, each segment); all parts share its values, unless the file gives one its own.
#pragma once

#include <array>
#include <tuple>
#include <type_traits>

#include "plant/description.h"
#include "plant/system.h"

namespace sinew::plant {

// A state that an effect has in each part. "{}" in the name becomes the part's name; "_{}" goes where a part needs none.
struct StateDeclaration {
  std::string_view name;
  Unit unit;
  double scale;
  AtStart at_start = AtStart::open;
  double start_deviation = 0.5 * scale;
};

std::string name_in_part(std::string_view pattern, std::string_view part);

template <class Effect>
concept HasStates = requires {
  Effect::states.size();
};

template <class Effect>
constexpr std::size_t states_per_part() {
  if constexpr (HasStates<Effect>) return Effect::states.size();
  return 0;
}

// An effect's values: first those that parts share, then those that a part has of its own.
template <class Effect>
struct Instances {
  std::vector<Effect> sets = std::vector<Effect>(1);
  std::vector<std::size_t> own_parts;  // of sets[1], sets[2], ...
  const Effect& of(std::size_t part) const {
    for (std::size_t k = 0; k < own_parts.size(); ++k)
      if (own_parts[k] == part) return sets[k + 1];
    return sets[0];
  }
};

template <class Tuple>
struct InstancesOf;
template <class... Effect>
struct InstancesOf<std::tuple<Effect...>> {
  using Type = std::tuple<Instances<Effect>...>;
};

// For every effect: the parts that have values of their own.
using OwnParts = std::vector<std::vector<std::size_t>>;

template <class Core, class Effects>
struct ValueSet {
  Core core;
  typename InstancesOf<Effects>::Type effects;

  ValueSet(Core initial, const OwnParts& own) : core(std::move(initial)) {
    each_effect([&](auto index, auto& instances) {
      if (own.empty()) return;
      instances.own_parts = own[index];
      instances.sets.resize(1 + own[index].size());
    });
  }

  // visit(integral constant, Instances<Effect>&), in the order of the list.
  template <class Visitor>
  void each_effect(Visitor&& visit) {
    [&]<std::size_t... i>(std::index_sequence<i...>) { (visit(std::integral_constant<std::size_t, i>{}, std::get<i>(effects)), ...); }
    (std::make_index_sequence<std::tuple_size_v<Effects>>{});
  }
  template <class Visitor>
  void each_effect(Visitor&& visit) const {
    [&]<std::size_t... i>(std::index_sequence<i...>) { (visit(std::integral_constant<std::size_t, i>{}, std::get<i>(effects)), ...); }
    (std::make_index_sequence<std::tuple_size_v<Effects>>{});
  }

  // visit(field, declaration), in the order of System::parameters().
  template <class Visitor>
  void each_field(Visitor&& visit) {
    Core::parameters(core, visit);
    each_effect([&](auto, auto& instances) {
      for (auto& one : instances.sets) std::remove_cvref_t<decltype(one)>::parameters(one, visit);
    });
  }

  template <class S>
  void assign(const std::vector<S>& values) {
    std::size_t next = 0;
    each_field([&](S& field, const Declaration&) { field = values[next++]; });
  }
};

constexpr std::string_view text_of(std::string_view place) { return place; }

// Parameters and effects, as a System lists them; an effect that needs another stands after it. `part_names(kind of part)`: names of the
// parts that an effect acts on.
template <class Values, class PartNames>
void list_parameters_and_effects(Values values, PartNames&& part_names, ListOf<ParameterId, ParameterInfo>& parameters,
                                 ListOf<EffectId, EffectInfo>& effects) {
  using Core = std::remove_cvref_t<decltype(values.core)>;
  Core::parameters(values.core, [&](const auto&, const Declaration& declared) { parameters.push_back({std::nullopt, "", declared}); });
  values.each_effect([&](auto index, auto& instances) {
    using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
    EffectInfo info;
    info.name = Effect::name;
    info.place = text_of(Effect::place);
    info.equation = Effect::equation;
    info.words = Effect::words;
    info.parts = part_names(Effect::part);
    if constexpr (requires { Effect::argument; }) info.argument = Effect::argument;
    info.begins_at_an_instant = requires(const Effect& effect) { effect.switch_time_s(); };
    if constexpr (requires { Effect::grown_words; }) {
      info.grown_words = Effect::grown_words;
      info.grown_unit = Effect::grown_unit;
    }
    if constexpr (requires { Effect::hides; })
      for (const auto& [quantity, factor] : Effect::hides)
        for (const ParameterId p : parameters.ids())
          if (!parameters[p].effect && parameters[p].declaration.name.starts_with(std::string(quantity) + "_"))
            info.hides.emplace_back(p, factor);
    if constexpr (requires { Effect::needs; })
      for (const EffectId other : effects.ids())
        if (effects[other].name == Effect::needs) info.needs = other;
    for (std::size_t set = 0; set < instances.sets.size(); ++set) {
      std::string owner(Effect::name);
      if (set > 0) owner += "." + part_names(Effect::part)[instances.own_parts[set - 1]];
      Effect::parameters(instances.sets[set], [&](const auto&, const Declaration& declared) {
        const ParameterId id{parameters.size()};
        if (set == 0) info.parameters.push_back(id);
        if (declared.null_value && set == 0) info.strength = id;
        if (declared.null_value && set > 0) info.own_strengths.push_back(id);
        parameters.push_back({EffectId{index}, owner, declared});
      });
    }
    effects.push_back(std::move(info));
  });
  values.each_effect([&](auto index, auto& instances) {
    using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
    if constexpr (requires { Effect::form_of; })
      for (const EffectId other : effects.ids())
        if (effects[other].name == Effect::form_of) effects[EffectId{index}].form_of = other;
  });
}

// The parts that have values of their own, by effect. Throws DescriptionError where effect or part is not there.
template <class Values, class PartNames>
OwnParts own_parts_of(const std::vector<OwnValues>& own, const Values& values, PartNames&& part_names) {
  OwnParts result(std::tuple_size_v<decltype(values.effects)>);
  for (const OwnValues& one : own) {
    bool found = false;
    values.each_effect([&](auto index, const auto& instances) {
      using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
      if (Effect::name != one.effect) return;
      found = true;
      const std::vector<std::string> names = part_names(Effect::part);
      std::string all;
      for (std::size_t p = 0; p < names.size(); ++p) {
        if (names[p] == one.part) return result[index].push_back(p);
        all += (p ? ", " : "") + (names[p].empty() ? "(the only one)" : names[p]);
      }
      throw DescriptionError(one.path, "no such parameter, and no part that this effect acts on; " +
                                           (all.empty() ? "there is none here" : "these are " + all));
    });
    if (!found) throw DescriptionError(one.path, "no such effect");
  }
  return result;
}

}  // namespace sinew::plant
