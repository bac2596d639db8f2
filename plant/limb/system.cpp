// SPDX-License-Identifier: Apache-2.0
#include "plant/systems.h"

#include "plant/limb/limb.h"

namespace sinew::plant {

std::shared_ptr<const System> make_limb(const Description& structure, const std::vector<OwnValues>& own) {
  const bool is_described = !structure.path.empty();
  if (!is_described && own.empty()) return two_coil_limb();
  return std::make_shared<LimbSystem>(is_described ? shape_of(structure) : two_coil_shape(), own);
}

Plant default_plant() { return Plant(two_coil_limb()); }

}  // namespace sinew::plant
