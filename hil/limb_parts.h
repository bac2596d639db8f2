// SPDX-License-Identifier: Apache-2.0
// Which entry of a plant's lists is what on the board: the coils that it drives, the thermocouples and bend sensors that it
// reads, each in the order in which the wire has them.
#pragma once

#include <string>
#include <vector>

#include "plant/system.h"

namespace sinew::hil {

struct Coil {
  std::string name;
  plant::InputId input;
  plant::StateId temperature;
  plant::ChannelId shown;    // by its thermocouple, which is
  std::size_t thermocouple;  // this one of the wire
};

struct LimbParts {
  std::vector<Coil> coils;                      // in the order of the plant's inputs
  std::vector<plant::ChannelId> thermocouples;  // in the order of its channels
  std::vector<plant::ChannelId> angles;
  plant::ParameterId ambient_temperature;
};

// `file`: where the plant stands, for errors. Throws sim::InputError: a plant that is no limb, one with more than the wire carries, a
// coil without a thermocouple (both supervisors watch a coil by its thermocouple), a channel that no board measures.
LimbParts parts_of(const plant::Plant& plant, const std::string& file = "");

}  // namespace sinew::hil
