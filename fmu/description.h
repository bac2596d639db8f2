// SPDX-License-Identifier: Apache-2.0
// modelDescription.xml of a plant, by FMI 2.0, section 2.2 and 4.3.
#pragma once

#include <string>

#include "plant/system.h"

namespace sinew::fmu {

struct Identity {
  std::string name;  // an identifier of C
  std::string guid;  // of the plant file beside it: whoever has another one has another plant
  std::string tool;  // "Sinew 0.1.0"
};

// The name of the shared object's copy in an FMU, and of the plant file, which resolves every base.
std::string binary_path(const std::string& name);
inline constexpr const char* plant_path = "resources/plant.yaml";
// How the line of the plant file begins that repeats the guid.
inline constexpr const char* guid_line = "# guid: ";

std::string model_description(const plant::Plant& plant, const Identity& identity);

}  // namespace sinew::fmu
