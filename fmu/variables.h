// SPDX-License-Identifier: Apache-2.0
// The variables of a plant in an FMU. Each list of its System makes some; the place in this list is the variable's value reference.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plant/system.h"

namespace sinew::fmu {

enum class Causality { input, output, local, parameter };

struct Variable {
  // An input and a channel as in a recording, "duty_A"; a state as in truth.csv, "states.temperature_A_degC"; a parameter as in a plant
  // file, "parameters.heat_loss_A_W_K", "effects.latent_heat.A.latent_heat_J".
  std::string name;
  std::string words = "";
  Causality causality;
  plant::Unit unit;
  std::size_t index;  // of the InputId, ChannelId, StateId or ParameterId
  // Of inputs and parameters, in `unit`.
  std::optional<plant::Range> range = std::nullopt;
  plant::Kind kind = plant::Kind::real;
  double start = 0.0;  // of an input: 0, or what of its range is nearest
  // At this value an effect would be off, and have no states: whether it is on is the plant file's business.
  std::optional<double> null_value = std::nullopt;

  // Empty where the value may be set; otherwise what would be right: "must lie in [0, 1]".
  std::string fault(double value) const;
};

// Inputs, channels, states, then the parameters of the core and of every effect that is on, in the order of their lists. Curves of laws are
// no parameters.
std::vector<Variable> variables_of(const plant::Plant& plant);

}  // namespace sinew::fmu
