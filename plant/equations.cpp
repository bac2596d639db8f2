// SPDX-License-Identifier: Apache-2.0
#include "plant/equations.h"

namespace sinew::plant {

Layout layout_of(const std::array<bool, effect_count>& on) {
  Layout layout;
  const auto add = [&](std::string_view owner, const StateDeclaration& declared) {
    layout.entries.push_back(
        {owner.empty() ? std::string(declared.name) : std::string(owner) + "." + std::string(declared.name), declared});
  };
  add("", {"temperature_A_degC", units::degC, 50.0});
  add("", {"temperature_B_degC", units::degC, 50.0});
  add("", {"martensite_A_fraction", units::none, 1.0});
  add("", {"martensite_B_fraction", units::none, 1.0});
  add("", {"angle_rad", units::rad, 1.0, false});
  add("", {"angular_velocity_rad_s", units::rad_s, 1.0, false});
  const Limb<double> limb;
  visit_effects(limb, [&](auto index, const auto& effect) {
    layout.first[index] = layout.size();
    if constexpr (HasStates<std::remove_cvref_t<decltype(effect)>>)
      if (on[index])
        for (const StateDeclaration& declared : effect.states) add(effect.name, declared);
  });
  return layout;
}

template class Equations<double>;
template class Equations<Jet<8>>;
template class Equations<Jet<16>>;

}  // namespace sinew::plant
