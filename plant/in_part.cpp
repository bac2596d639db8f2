// SPDX-License-Identifier: Apache-2.0
#include "plant/in_part.h"

#include <algorithm>

namespace sinew::plant {

bool is_on_in(const Plant& plant, EffectId effect, const std::string& part) {
  const System& system = plant.system();
  const EffectInfo& info = system.effects()[effect];
  if (info.own_strengths.empty()) return plant.is_on(effect);
  const Declaration& strength = system.parameters()[info.strength].declaration;
  const auto own = system.find_parameter(std::string(info.name) + "." + part + "." + strength.name);
  return plant.is_on(effect) && plant.get_in_file_units(own.value_or(info.strength)) != *strength.null_value;
}

bool is_on_everywhere(const Plant& plant, EffectId effect) {
  const auto& parts = plant.system().effects()[effect].parts;
  return plant.is_on(effect) &&
         std::all_of(parts.begin(), parts.end(), [&](const std::string& part) { return is_on_in(plant, effect, part); });
}

}  // namespace sinew::plant
