// SPDX-License-Identifier: Apache-2.0
#include "plant/systems.h"

#include "plant/limb/limb.h"

namespace sinew::plant {

std::shared_ptr<const System> make_limb(const Description& structure, const std::vector<OwnValues>& own) {
  if (structure.kind == Description::Kind::empty && own.empty()) return two_coil_limb();
  return std::make_shared<LimbSystem>(structure.kind == Description::Kind::empty ? two_coil_shape() : shape_of(structure), own);
}

Plant default_plant() { return Plant(two_coil_limb()); }

}  // namespace sinew::plant
