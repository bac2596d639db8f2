// SPDX-License-Identifier: Apache-2.0
// Every System: each folder below this one that has a system.cpp. The list is made at build time (CMakeLists.txt).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "plant/description.h"
#include "plant/system.h"

namespace sinew::plant {

struct SystemMaker {
  std::string name;  // of the folder, and the key of the structure in a plant file
  std::shared_ptr<const System> (*make)(const Description& structure, const std::vector<OwnValues>& own);
};

// In the order of their names.
const std::vector<SystemMaker>& systems();

// The plant of a scenario that names none: the limb of Sabelhaus, Mehta, Wertz, Majidi 2022 at its nominal values.
Plant default_plant();

}  // namespace sinew::plant
