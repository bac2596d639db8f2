// SPDX-License-Identifier: Apache-2.0
// What may stand in a plant file or a scenario, as JSON Schema (draft 7), for editors and for other programs. All of it walks what the
// readers walk: the Systems' lists and the fields of a scenario.
//
// A schema knows each System as its usual structure has it. Of a limb of another structure, and of a plant with a file as its base, it
// knows the effects of all Systems, and takes any number for a parameter and any input for an input; `system`, where it is given, stands
// for all such plants. It cannot say what a reader says of two values together (`from_s` before `until_s`), nor of other files.
#pragma once

#include <nlohmann/json.hpp>

#include "plant/system.h"

namespace sinew::sim {

nlohmann::ordered_json plant_schema(const plant::System* system = nullptr);
nlohmann::ordered_json scenario_schema(const plant::System* system = nullptr);

}  // namespace sinew::sim
