// SPDX-License-Identifier: Apache-2.0
#include "fmu/variables.h"

#include <algorithm>

#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::fmu {

std::string Variable::fault(double value) const {
  if (kind == plant::Kind::toggle && value != 0.0 && value != 1.0) return "must be 0 or 1";
  if (kind == plant::Kind::sign && value != 1.0 && value != -1.0) return "must be 1 or -1";
  if (range->contains(value))
    return value == null_value && value != start ? "turns the effect off, which the plant file alone can; export a plant without it" : "";
  const std::string unit_words = unit.text.empty() ? "" : " " + std::string(unit.text);
  return "must lie in [" + sim::shortest(range->lowest) + ", " + sim::shortest(range->highest) + "]" + unit_words;
}

namespace {

// What of the range may not be set.
std::string exceptions_words(const plant::ParameterInfo& parameter) {
  const plant::Declaration& declared = parameter.declaration;
  if (declared.kind == plant::Kind::toggle) return "; 0 or 1";
  if (declared.kind == plant::Kind::sign) return "; -1 or 1";
  return parameter.effect && declared.null_value ? "; not " + sim::shortest(*declared.null_value) + ", which turns the effect off" : "";
}

}  // namespace

std::vector<Variable> variables_of(const plant::Plant& plant) {
  const plant::System& system = plant.system();
  std::vector<Variable> all;
  for (const plant::InputId i : system.inputs().ids()) {
    const plant::InputInfo& input = system.inputs()[i];
    all.push_back({.name = input.column,
                   .words = input.words,
                   .causality = Causality::input,
                   .unit = input.unit,
                   .index = i.index,
                   .range = input.range,
                   .start = std::clamp(0.0, input.range.lowest, input.range.highest)});
  }
  for (const plant::ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& channel = system.channels()[c];
    all.push_back({.name = channel.column, .words = channel.words, .causality = Causality::output, .unit = channel.unit, .index = c.index});
  }
  const plant::States states = plant.states();
  for (const plant::StateId s : states.ids())
    all.push_back({.name = "states." + states[s].key, .causality = Causality::local, .unit = states[s].unit, .index = s.index});
  for (const plant::ParameterId p : system.parameters().ids()) {
    const plant::ParameterInfo& parameter = system.parameters()[p];
    if (parameter.effect && (!plant.is_on(*parameter.effect) || system.effects()[*parameter.effect].law)) continue;
    const plant::Declaration& declared = parameter.declaration;
    // The number that a plant file would have, which is converted back to the same internal value.
    const auto in_file = sim::parse_number(sim::parameter_text(plant, p));
    all.push_back({.name = (parameter.effect ? "effects." : "parameters.") + parameter.key(),
                   .words = std::string(declared.meaning) + exceptions_words(parameter),
                   .causality = Causality::parameter,
                   .unit = declared.unit,
                   .index = p.index,
                   .range = declared.kind == plant::Kind::toggle ? plant::Range{0.0, 1.0} : declared.range,
                   .kind = declared.kind,
                   .start = in_file ? *in_file : plant.get(p),
                   .null_value = parameter.effect ? declared.null_value : std::nullopt});
  }
  return all;
}

}  // namespace sinew::fmu
