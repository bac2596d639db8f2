// SPDX-License-Identifier: Apache-2.0
#include "plant/limb.h"

#include <stdexcept>

namespace sinew::plant {

std::string ParameterInfo::key() const {
  return owner.empty() ? std::string(declaration.name) : std::string(owner) + "." + std::string(declaration.name);
}

const std::vector<ParameterInfo>& parameters() {
  static const std::vector<ParameterInfo> all = [] {
    std::vector<ParameterInfo> list;
    const Limb<double> limb;
    visit_parameters(limb.core, [&](const double&, const Declaration& declared) {
      list.push_back({no_effect, "", declared});
    });
    visit_effects(limb, [&](auto index, const auto& effect) {
      visit_parameters(effect, [&](const double&, const Declaration& declared) {
        list.push_back({index, effect.name, declared});
      });
    });
    return list;
  }();
  return all;
}

const std::vector<EffectInfo>& effects() {
  static const std::vector<EffectInfo> all = [] {
    std::vector<EffectInfo> list;
    const Limb<double> limb;
    visit_effects(limb, [&](auto index, const auto& effect) {
      EffectInfo info{effect.name, effect.place, effect.equation, effect.words, {}, 0};
      std::size_t strengths = 0;
      for (std::size_t p = 0; p < parameters().size(); ++p) {
        if (parameters()[p].effect != index) continue;
        info.parameters.push_back(p);
        if (parameters()[p].declaration.null_value) {
          info.strength = p;
          ++strengths;
        }
      }
      if (strengths != 1) throw std::logic_error("effect " + std::string(effect.name) + " must declare one null");
      list.push_back(std::move(info));
    });
    return list;
  }();
  return all;
}

std::size_t parameter_index(std::string_view key) {
  for (std::size_t p = 0; p < parameters().size(); ++p)
    if (parameters()[p].key() == key) return p;
  throw std::out_of_range("no such parameter: " + std::string(key));
}

std::size_t effect_index(std::string_view name) {
  for (std::size_t e = 0; e < effects().size(); ++e)
    if (effects()[e].name == name) return e;
  throw std::out_of_range("no such effect: " + std::string(name));
}

double get(const Limb<double>& limb, std::size_t parameter) {
  return *fields(const_cast<Limb<double>&>(limb)).at(parameter);  // read only
}

void set(Limb<double>& limb, std::size_t parameter, double internal_value) {
  *fields(limb).at(parameter) = internal_value;
}

double get_in_file_units(const Limb<double>& limb, std::size_t parameter) {
  return get(limb, parameter) / parameters()[parameter].declaration.unit.internal_per_unit;
}

void set_in_file_units(Limb<double>& limb, std::size_t parameter, double value) {
  set(limb, parameter, value * parameters()[parameter].declaration.unit.internal_per_unit);
}

void turn_on_by_strength(Limb<double>& limb) {
  for (std::size_t e = 0; e < effect_count; ++e) {
    const auto strength = effects()[e].strength;
    limb.on[e] = get_in_file_units(limb, strength) != *parameters()[strength].declaration.null_value;
  }
}

bool operator==(const Limb<double>& left, const Limb<double>& right) {
  for (std::size_t p = 0; p < parameters().size(); ++p)
    if (get(left, p) != get(right, p)) return false;
  return left.on == right.on;
}

}  // namespace sinew::plant
