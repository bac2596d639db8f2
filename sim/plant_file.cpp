// SPDX-License-Identifier: Apache-2.0
#include "sim/plant_file.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "plant/contains.h"
#include "plant/in_part.h"
#include "plant/laws.h"
#include "sim/text.h"

namespace sinew::sim {
namespace {

using plant::Declaration;
using plant::Kind;

std::string allowed(const Declaration& declared, std::string_view owner) {
  std::string text = "must lie in [" + shortest(declared.range.lowest) + ", " + shortest(declared.range.highest) + "]";
  if (!declared.unit.text.empty()) text += " " + std::string(declared.unit.text);
  if (declared.null_value && !owner.empty()) text += "; " + shortest(*declared.null_value) + " turns " + std::string(owner) + " off";
  return text;
}

double read_value(const YamlValue& value, const Declaration& declared, std::string_view owner) {
  switch (declared.kind) {
    case Kind::toggle:
      return value.truth() ? 1.0 : 0.0;
    case Kind::sign: {
      const double sign = value.number();
      if (sign != 1.0 && sign != -1.0) value.complain("must be 1 or -1");
      return sign;
    }
    case Kind::real:
      break;
  }
  const double number = value.number();
  if (!declared.range.contains(number)) value.complain(allowed(declared, owner));
  return number;
}

constexpr const char* all_effects_advice = "`sinew effects` lists all effects";

void read_core(const YamlValue& value, plant::Plant& plant) {
  YamlMap map(value);
  const auto& all = plant.system().parameters();
  for (const plant::ParameterId p : all.ids()) {
    const Declaration& declared = all[p].declaration;
    const YamlValue* given = all[p].effect ? nullptr : map.find(declared.name);
    if (!given) continue;
    if (given->kind != YamlValue::Kind::map) {
      plant.set_in_file_units(p, read_value(*given, declared, ""));
      plant.set_own_deviation(p, std::nullopt);
      continue;
    }
    if (declared.kind != Kind::real) given->complain("has no deviation: it is one of two");
    YamlMap known(*given);
    const YamlValue& about = known.require("value", std::string(declared.meaning));
    const YamlValue& deviation = known.require("deviation", "one standard deviation of what is known of it; 0: known, and not fitted");
    known.finish();
    plant.set_in_file_units(p, read_value(about, declared, ""));
    const double believed = deviation.number(), widest = declared.range.highest - declared.range.lowest;
    if (!(believed >= 0.0 && believed <= widest))
      deviation.complain("must lie in [0, " + shortest(widest) + "] " + std::string(declared.unit.text));
    plant.set_own_deviation(p, believed * declared.unit.internal_per_unit);
  }
  for (const std::string& own : plant.system().own_keys()) map.find(own);  // where none is given: for the nearest right name
  map.finish("`sinew effects --core` lists the parameters of the core");
}

// What a map gives of the parameters whose owner is this; all of them must be there.
void read_effect_values(YamlMap& map, const std::string& owner, std::string_view effect, plant::Plant& plant) {
  const auto& all = plant.system().parameters();
  for (const plant::ParameterId p : all.ids()) {
    if (all[p].owner != owner) continue;
    const Declaration& declared = all[p].declaration;
    const std::string what_for = "an effect that is named gives all its parameters; " + std::string(declared.meaning);
    plant.set_in_file_units(p, read_value(map.require(declared.name, what_for), declared, effect));
  }
}

void read_effects(const YamlValue& value, plant::Plant& plant) {
  YamlMap map(value);
  const auto& all = plant.system().parameters();
  for (const auto& effect : plant.system().effects()) {
    const YamlValue* given = effect.is_of_catalogue() ? map.find(effect.name) : nullptr;
    if (!given) continue;
    YamlMap inner(*given);
    for (const plant::ParameterId p : effect.parameters) inner.find(all[p].declaration.name);
    std::vector<std::pair<std::string, const YamlValue*>> own;
    for (const auto& entry : given->map)
      if (entry.value.kind == YamlValue::Kind::map) own.emplace_back(entry.key, inner.find(entry.key));
    inner.finish();  // before what is missing: an unknown key may be a misspelling of it
    read_effect_values(inner, std::string(effect.name), effect.name, plant);
    for (const auto& [part, values] : own) {
      YamlMap of_part(*values);
      for (const plant::ParameterId p : effect.parameters) of_part.find(all[p].declaration.name);
      of_part.finish();
      read_effect_values(of_part, std::string(effect.name) + "." + part, effect.name, plant);
    }
  }
}

std::string names_of(const auto& list, auto&& name_of) {
  std::string text;
  for (const auto& one : list) text += (text.empty() ? "" : ", ") + std::string(name_of(one));
  return text;
}

const YamlValue& list_of(const YamlValue& value, const char* what) {
  if (value.kind != YamlValue::Kind::list || value.list.empty()) value.complain(std::string("must be a list of ") + what);
  return value;
}

plant::Law read_law(const YamlValue& value, const plant::System& system) {
  YamlMap map(value);
  const YamlValue& entry = map.require("entry", "where the law enters");
  const YamlValue& argument = map.require("argument", "the variable that the law is a function of");
  const YamlValue* times = map.find("times");
  const YamlValue* memory = map.find("fading_memory_s");
  const YamlValue& knots = list_of(map.require("knots", "values of the argument, rising"), "numbers");
  const YamlValue& values = list_of(map.require("values", "the law at each knot"), "numbers");
  map.finish();

  plant::Law law;
  std::vector<std::string_view> may_be;
  std::size_t parts = 0;
  bool found = false;
  for (const plant::EntryGroupId g : system.entry_groups().ids()) {
    std::size_t count = 0;
    for (const plant::Entry& one : system.entries()) count += one.group == g && (one.state || one.channel);
    if (count == 0) continue;
    may_be.push_back(system.entry_groups()[g].name);
    if (system.entry_groups()[g].name != entry.text()) continue;
    law.entry = g, parts = count, found = true;
  }
  if (!found) entry.complain("no such entry; there are " + names_of(may_be, [](auto name) { return name; }));
  const auto variable = [&](const YamlValue& name) {
    for (const plant::VariableId v : system.variables().ids())
      if (system.variables()[v].name == name.text()) return v;
    name.complain("no such variable; there are " + names_of(system.variables(), [](const auto& info) { return info.name; }));
  };
  const auto variables = [&](const YamlValue& of) {
    std::vector<plant::VariableId> result;
    if (of.kind == YamlValue::Kind::list)
      for (const YamlValue& one : of.list) result.push_back(variable(one));
    else
      result.push_back(variable(of));
    if (result.size() != parts)
      of.complain("needs " + std::to_string(parts) + " variables in a list, one for each part that has this entry");
    return result;
  };
  law.argument = variables(argument);
  if (times) law.factor = variables(*times);
  if (memory) law.fading_memory_s = memory->number_in({1e-3, 1e6});
  for (const YamlValue& knot : knots.list) {
    law.knots.push_back(knot.number());
    if (law.knots.size() > 1 && !(law.knots.back() > law.knots[law.knots.size() - 2])) knot.complain("must be above the knot before it");
  }
  if (law.knots.size() < 2) knots.complain("needs two knots or more");
  if (values.list.size() != knots.list.size()) values.complain("needs as many values as knots: " + std::to_string(knots.list.size()));
  law.curve.resize(static_cast<Eigen::Index>(values.list.size()), 1);
  for (std::size_t k = 0; k < values.list.size(); ++k) law.curve(static_cast<Eigen::Index>(k), 0) = values.list[k].number();
  return law;
}

std::vector<plant::Law> read_laws(const YamlValue& value, const plant::System& system) {
  std::vector<plant::Law> laws;
  for (const YamlValue& one : list_of(value, "laws").list) laws.push_back(read_law(one, system));
  return laws;
}

std::string laws_to_yaml(const plant::Plant& plant, const std::string& margin) {
  const plant::System& system = plant.system();
  const auto numbers = [](const auto& values) {
    std::string text = "[";
    for (const double value : values) text += (text.size() > 1 ? ", " : "") + shortest(value);
    return text + "]";
  };
  std::string text;
  for (const plant::EffectId e : system.effects().ids()) {
    if (!system.effects()[e].law || !plant.is_on(e)) continue;
    const plant::Law& law = system.laws()[*system.effects()[e].law];
    const auto& group = system.entry_groups()[law.entry];
    const auto variables = [&](const std::vector<plant::VariableId>& of) {
      const std::string names = names_of(of, [&](plant::VariableId v) { return system.variables()[v].name; });
      return of.size() > 1 ? "[" + names + "]" : names;
    };
    if (text.empty()) text = margin + "laws:\n";
    text += margin + "  - entry: " + std::string(group.name) + (law.factor.empty() ? "  # in " + std::string(group.unit) : "") + "\n";
    text += margin + "    argument: " + variables(law.argument) + "\n";
    if (!law.factor.empty()) text += margin + "    times: " + variables(law.factor) + "\n";
    if (law.fading_memory_s > 0.0) text += margin + "    fading_memory_s: " + shortest(law.fading_memory_s) + "\n";
    text += margin + "    knots: " + numbers(law.knots) + "\n";
    text += margin + "    values: " + numbers(plant::values_of(plant, e)) + "\n";
  }
  return text;
}

plant::Description description_of(const YamlValue& value) {
  plant::Description result;
  result.path = value.path;
  result.scalar = value.scalar;
  result.kind = value.kind == YamlValue::Kind::scalar ? plant::Description::Kind::scalar
                : value.kind == YamlValue::Kind::map  ? plant::Description::Kind::map
                : value.kind == YamlValue::Kind::list ? plant::Description::Kind::list
                                                      : plant::Description::Kind::empty;
  for (const auto& entry : value.map) result.map.push_back({entry.key, description_of(entry.value)});
  for (const YamlValue& one : value.list) result.list.push_back(description_of(one));
  return result;
}

const YamlValue* value_at(const YamlValue& value, const std::string& path) {
  if (value.path == path) return &value;
  for (const auto& entry : value.map)
    if (const YamlValue* found = value_at(entry.value, path)) return found;
  for (const YamlValue& one : value.list)
    if (const YamlValue* found = value_at(one, path)) return found;
  return nullptr;
}

void check_needs(const plant::Plant& plant, const YamlValue& effects) {
  const auto at = [&](std::string_view name) -> const YamlValue& {
    const auto found = std::find_if(effects.map.begin(), effects.map.end(), [&](const auto& entry) { return entry.key == name; });
    return found != effects.map.end() ? found->value : effects;
  };
  for (const plant::EffectId e : plant.system().effects().ids()) {
    const plant::EffectInfo& effect = plant.system().effects()[e];
    if (!plant.is_on(e) || !effect.needs) continue;
    const plant::EffectInfo& needed = plant.system().effects()[*effect.needs];
    const std::string acts =
        std::string(effect.name) + " acts on what " + std::string(needed.name) + " brings, and " + std::string(needed.name) + " is off ";
    if (!plant.is_on(*effect.needs)) at(effect.name).complain(acts + "here; switch it on, too");
    for (const std::string& part : effect.parts)
      if (plant::is_on_in(plant, e, part) && !plant::is_on_in(plant, *effect.needs, part))
        at(effect.name).complain(acts + "at " + part + "; switch it on there, or " + std::string(effect.name) + " off");
  }
}

// What a System is made from: kept along the chain of bases, since a file may give a part of its base values of its own.
struct Making {
  const plant::SystemMaker* maker = nullptr;
  plant::Description structure;
  std::vector<plant::OwnValues> own;
};

plant::Plant made(const Making& from, const YamlValue& value) {
  try {
    return plant::Plant(from.maker->make(from.structure, from.own));
  } catch (const plant::DescriptionError& error) {
    const YamlValue* at = value_at(value, error.path);
    (at ? *at : value).complain(error.what());
  }
}

void carry_over(const plant::Plant& from, plant::Plant& to) {
  for (const plant::ParameterId p : from.system().parameters().ids())
    if (const auto same = to.system().find_parameter(from.system().parameters()[p].key())) {
      to.set(*same, from.get(p));
      to.set_own_deviation(*same, from.own_deviation(p));
    }
}

// `below`: the files that have this one as their base, or as the base of their base.
std::pair<plant::Plant, Making> read_plant_of(const YamlValue& value, const std::filesystem::path& folder,
                                              std::vector<std::filesystem::path> below) {
  YamlMap map(value);
  plant::Plant plant = plant::default_plant();
  Making making;
  for (const auto& maker : plant::systems())
    if (maker.name == plant.system().name()) making.maker = &maker;
  const YamlValue* format = map.find("format");
  if (format && format->whole_number() != 1 && format->whole_number() != 2)
    format->complain("must be 1 or 2, the formats that this version reads");
  const YamlValue* base = map.find("base");
  if (base && base->text() != "paper_limb") {
    const std::filesystem::path file = folder / base->text();
    if (!std::filesystem::exists(file)) base->complain("no such file; a base is paper_limb or a plant file, looked for beside this one");
    below.push_back(std::filesystem::weakly_canonical(value.file));
    if (contains(below, std::filesystem::weakly_canonical(file))) base->complain("a plant cannot be its own base");
    std::tie(plant, making) = read_plant_of(read_yaml(file), file.parent_path(), below);
  }
  const auto needs_format_2 = [&](const YamlValue& what) {
    if (format && format->whole_number() == 1) what.complain("needs `format: 2`");
  };
  bool anew = false;
  for (const auto& maker : plant::systems())
    if (const YamlValue* structure = map.find(maker.name)) {
      needs_format_2(*structure);
      if (base) structure->complain("a plant has its structure from its base; leave out one of the two");
      if (anew) structure->complain("a plant is of one system");
      making = {&maker, description_of(*structure), {}};
      anew = true;
    }
  const YamlValue* parameters = map.find("parameters");
  const YamlValue* effects = map.find("effects");
  const YamlValue* laws = map.find("laws");
  map.finish();
  if (laws) needs_format_2(*laws);
  const plant::Plant without_own = anew ? made({making.maker, making.structure, {}}, value) : plant;
  if (effects) {
    // Before a part's own values are asked for: an unknown effect may be a misspelling.
    YamlMap names(*effects);
    for (const auto& effect : without_own.system().effects())
      if (effect.is_of_catalogue()) names.find(effect.name);
    const bool old_name = std::any_of(effects->map.begin(), effects->map.end(), [](const auto& one) { return one.key == "outer_turns"; });
    names.finish(old_name ? "outer_turns is called junction now, with other parameters; `sinew effects` lists all effects"
                          : all_effects_advice);
  }
  if (parameters) {
    const std::vector<std::string>& keys = without_own.system().own_keys();
    for (const auto& entry : parameters->map) {
      if (!contains(keys, entry.key) || without_own.system().find_parameter(entry.key)) continue;
      needs_format_2(entry.value);
      making.own.push_back({entry.value.path, "", "", entry.key});
      anew = true;
    }
  }
  if (effects)
    for (const auto& effect : effects->map)
      for (const auto& entry : effect.value.map)
        if (entry.value.kind == YamlValue::Kind::map) {
          needs_format_2(entry.value);
          const bool known = std::any_of(making.own.begin(), making.own.end(),
                                         [&](const plant::OwnValues& one) { return one.effect == effect.key && one.part == entry.key; });
          if (!known) making.own.push_back({entry.value.path, effect.key, entry.key});
          anew = anew || !known;
        }
  if (anew) {
    plant::Plant again = made(making, value);
    carry_over(plant, again);
    if (again.system().name() != plant.system().name())
      again = plant::Plant(again.shared_system());
    else
      again = plant::with_laws_on(again, plant.system().laws());
    plant = again;
  }
  if (parameters) read_core(*parameters, plant);
  if (effects) read_effects(*effects, plant);
  if (laws) plant = plant::with_laws_on(plant, read_laws(*laws, plant.system()));
  plant.turn_on_by_strength();
  if (effects) check_needs(plant, *effects);
  return {plant, making};
}

}  // namespace

plant::Plant read_plant(const YamlValue& value, const std::filesystem::path& folder) { return read_plant_of(value, folder, {}).first; }

plant::Plant read_plant_file(const std::filesystem::path& file) {
  const YamlValue plant = read_yaml(file);
  if (plant.kind == YamlValue::Kind::empty)
    plant.complain("holds no plant; `format: 1` alone is the paper's limb, plant/limbs/paper_limb.yaml shows all that may stand in it");
  return read_plant(plant, file.parent_path());
}

std::string text_in_unit(double internal, double internal_per_unit) {
  const double quotient = internal / internal_per_unit;
  std::string text;
  for (const double candidate : {quotient, std::nextafter(quotient, -INFINITY), std::nextafter(quotient, INFINITY)}) {
    if (candidate * internal_per_unit != internal) continue;
    const std::string other = shortest(candidate);
    if (text.empty() || other.size() < text.size()) text = other;
  }
  return text.empty() ? shortest(quotient) : text;
}

std::string parameter_text(const plant::Plant& plant, plant::ParameterId parameter) {
  const Declaration& declared = plant.system().parameters()[parameter].declaration;
  const double internal = plant.get(parameter);
  if (declared.kind == Kind::toggle) return internal != 0.0 ? "true" : "false";
  return text_in_unit(internal, declared.unit.internal_per_unit);
}

namespace {

// Its value, with the deviation where the plant has one of its own.
std::string known_text(const plant::Plant& plant, plant::ParameterId parameter) {
  const std::string value = parameter_text(plant, parameter);
  const std::optional<double> own = plant.own_deviation(parameter);
  const double unit = plant.system().parameters()[parameter].declaration.unit.internal_per_unit;
  return own ? "{value: " + value + ", deviation: " + text_in_unit(*own, unit) + "}" : value;
}

}  // namespace

std::string plant_to_yaml(const plant::Plant& plant, int indent) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  const auto& all = plant.system().parameters();
  std::string text;
  std::string structure = plant.system().structure_yaml();
  while (!structure.empty()) {
    const std::size_t end = structure.find('\n') + 1;
    text += margin + structure.substr(0, end);
    structure.erase(0, end);
  }
  text += margin + "parameters:\n";
  for (const plant::ParameterId p : all.ids())
    if (!all[p].effect) text += margin + "  " + all[p].declaration.name + ": " + known_text(plant, p) + "\n";
  std::string effects;
  for (const plant::EffectId e : plant.system().effects().ids()) {
    if (!plant.is_on(e) || !plant.system().effects()[e].is_of_catalogue()) continue;
    const std::string name(plant.system().effects()[e].name);
    std::string owner = name;
    effects += margin + "  " + name + ":\n";
    for (const plant::ParameterId p : all.ids()) {
      if (all[p].effect != e) continue;
      const std::string more = all[p].owner == name ? "" : "  ";
      if (all[p].owner != owner) effects += margin + "    " + all[p].owner.substr(name.size() + 1) + ":\n";
      owner = all[p].owner;
      effects += margin + "    " + more + all[p].declaration.name + ": " + parameter_text(plant, p) + "\n";
    }
  }
  return text + margin + (effects.empty() ? "effects: {}\n" : "effects:\n" + effects) + laws_to_yaml(plant, margin);
}

std::string plant_file_text(const plant::Plant& plant) {
  const auto& all = plant.system().parameters();
  const std::vector<std::string>& own_keys = plant.system().own_keys();
  const bool own = std::any_of(all.begin(), all.end(), [&](const plant::ParameterInfo& info) {
    if (!info.effect) return contains(own_keys, info.key());
    return info.owner.find('.') != std::string::npos && plant.is_on(*info.effect);
  });
  return std::string("format: ") + (own || !plant.system().structure_yaml().empty() || !laws_to_yaml(plant, "").empty() ? "2" : "1") +
         "\n" + plant_to_yaml(plant);
}

}  // namespace sinew::sim
