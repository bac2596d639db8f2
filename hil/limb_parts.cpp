// SPDX-License-Identifier: Apache-2.0
#include "hil/limb_parts.h"

#include <algorithm>

#include "hil/frame.h"
#include "sim/input_error.h"

namespace sinew::hil {

LimbParts parts_of(const plant::Plant& plant, const std::string& file) {
  const plant::System& system = plant.system();
  const plant::States states = plant.states();
  const auto fail = [&](const std::string& key, const std::string& value, const std::string& advice) {
    throw sim::InputError({.file = file, .key = key, .value = value, .advice = advice});
  };
  if (system.name() != "limb") fail("plant", std::string(system.name()), "must be a limb: the board drives coils");
  LimbParts parts;
  parts.ambient_temperature = system.parameter("ambient_temperature_degC");
  for (const plant::ChannelId c : system.channels().ids()) {
    const plant::ChannelInfo& channel = system.channels()[c];
    if (channel.kind == "temperature")
      parts.thermocouples.push_back(c);
    else if (channel.kind == "angle")
      parts.angles.push_back(c);
    else
      fail("plant.limb.channels", channel.column, "the board measures temperatures and angles alone");
  }
  const auto carried = [&](const std::string& key, const char* what, std::size_t count, std::size_t least) {
    if (count < least || count > BOARD_PARTS_MOST)
      fail(key, std::to_string(count),
           "the wire to a board carries " + std::to_string(least) + " to " + std::to_string(BOARD_PARTS_MOST) + " " + what);
  };
  carried("plant.limb.coils", "coils", system.inputs().size(), 1);
  carried("plant.limb.channels", "thermocouples", parts.thermocouples.size(), 0);
  carried("plant.limb.channels", "angles", parts.angles.size(), 0);
  for (const plant::InputId i : system.inputs().ids()) {
    const std::string& name = system.inputs()[i].name;
    Coil coil{.name = name, .input = i, .temperature = {}, .shown = {}, .thermocouple = 0};
    const auto wire = std::find_if(states.begin(), states.end(),
                                   [&](const plant::StateInfo& state) { return state.key == "temperature_" + name + "_degC"; });
    coil.temperature = plant::StateId{static_cast<std::size_t>(wire - states.begin())};
    const auto on_it = std::find_if(parts.thermocouples.begin(), parts.thermocouples.end(),
                                    [&](plant::ChannelId c) { return system.channels()[c].driven_by == i; });
    if (on_it == parts.thermocouples.end())
      fail("plant.limb.coils", name,
           "has no thermocouple; a coil is not driven on hardware without one, for both supervisors watch it by that");
    coil.shown = *on_it;
    coil.thermocouple = static_cast<std::size_t>(on_it - parts.thermocouples.begin());
    parts.coils.push_back(std::move(coil));
  }
  return parts;
}

}  // namespace sinew::hil
