// SPDX-License-Identifier: Apache-2.0
#include "sim/plant_file.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/text.h"

namespace sinew::sim {
namespace {

using plant::Declaration;
using plant::Kind;

std::string allowed(const Declaration& declared, std::string_view owner) {
  std::string text = "must lie in [" + shortest(declared.range.lowest) + ", " + shortest(declared.range.highest) + "]";
  if (!declared.unit.text.empty()) text += " " + std::string(declared.unit.text);
  if (declared.null_value && !owner.empty())
    text += "; " + shortest(*declared.null_value) + " turns " + std::string(owner) + " off";
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

void read_core(const YamlValue& value, plant::Limb<double>& limb) {
  YamlMap map(value);
  for (std::size_t p = 0; p < plant::parameters().size(); ++p) {
    const auto& info = plant::parameters()[p];
    if (info.effect != plant::no_effect) continue;
    if (const YamlValue* given = map.find(info.declaration.name))
      plant::set_in_file_units(limb, p, read_value(*given, info.declaration, ""));
  }
  map.finish("`sinew effects --core` lists the parameters of the core");
}

void read_effects(const YamlValue& value, plant::Limb<double>& limb) {
  YamlMap map(value);
  for (const auto& effect : plant::effects()) {
    const YamlValue* given = map.find(effect.name);
    if (!given) continue;
    YamlMap inner(*given);
    for (const std::size_t p : effect.parameters) inner.find(plant::parameters()[p].declaration.name);
    inner.finish();  // before what is missing: an unknown key may be a misspelling of it
    for (const std::size_t p : effect.parameters) {
      const Declaration& declared = plant::parameters()[p].declaration;
      const std::string what_for = "an effect that is named gives all its parameters; " + std::string(declared.meaning);
      plant::set_in_file_units(limb, p, read_value(inner.require(declared.name, what_for), declared, effect.name));
    }
  }
  map.finish("`sinew effects` lists all effects");
}

// `below`: the files that have this one as their base, or as the base of their base.
plant::Limb<double> read_plant_of(const YamlValue& value, const std::filesystem::path& folder,
                                  std::vector<std::filesystem::path> below) {
  YamlMap map(value);
  plant::Limb<double> limb;
  if (const YamlValue* format = map.find("format"); format && format->whole_number() != 1)
    format->complain("must be 1, the format that this version reads");
  if (const YamlValue* base = map.find("base"); base && base->text() != "paper_limb") {
    const std::filesystem::path file = folder / base->text();
    if (!std::filesystem::exists(file))
      base->complain("no such file; a base is paper_limb or a plant file, looked for beside this one");
    below.push_back(std::filesystem::weakly_canonical(value.file));
    if (std::find(below.begin(), below.end(), std::filesystem::weakly_canonical(file)) != below.end())
      base->complain("a plant cannot be its own base");
    limb = read_plant_of(read_yaml(file), file.parent_path(), below);
  }
  if (const YamlValue* parameters = map.find("parameters")) read_core(*parameters, limb);
  if (const YamlValue* effects = map.find("effects")) read_effects(*effects, limb);
  map.finish();
  plant::turn_on_by_strength(limb);
  return limb;
}

}  // namespace

plant::Limb<double> read_plant(const YamlValue& value, const std::filesystem::path& folder) {
  return read_plant_of(value, folder, {});
}

plant::Limb<double> read_plant_file(const std::filesystem::path& file) {
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

std::string parameter_text(const plant::Limb<double>& limb, std::size_t parameter) {
  const Declaration& declared = plant::parameters()[parameter].declaration;
  const double internal = plant::get(limb, parameter);
  if (declared.kind == Kind::toggle) return internal != 0.0 ? "true" : "false";
  return text_in_unit(internal, declared.unit.internal_per_unit);
}

std::string plant_to_yaml(const plant::Limb<double>& limb, int indent) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  std::string text = margin + "parameters:\n";
  for (std::size_t p = 0; p < plant::parameters().size(); ++p) {
    const auto& info = plant::parameters()[p];
    if (info.effect == plant::no_effect)
      text += margin + "  " + std::string(info.declaration.name) + ": " + parameter_text(limb, p) + "\n";
  }
  std::string effects;
  for (std::size_t e = 0; e < plant::effects().size(); ++e) {
    if (!limb.on[e]) continue;
    effects += margin + "  " + std::string(plant::effects()[e].name) + ":\n";
    for (const std::size_t p : plant::effects()[e].parameters)
      effects += margin + "    " + std::string(plant::parameters()[p].declaration.name) + ": " + parameter_text(limb, p) + "\n";
  }
  return text + margin + (effects.empty() ? "effects: {}\n" : "effects:\n" + effects);
}

}  // namespace sinew::sim
