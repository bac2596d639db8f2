// SPDX-License-Identifier: Apache-2.0
// Limbs of other shapes than the two-coil limb, for tests: as they stand in a plant file, and as Descriptions.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "plant/limb/limb.h"
#include "sim/plant_file.h"

namespace sinew::test {

inline plant::Plant plant_of(const std::string& yaml) { return sim::read_plant(sim::parse_yaml(yaml, "p.yaml"), "."); }

// The two-coil limb, written out.
inline const std::string two_coils =
    "format: 2\n"
    "limb:\n"
    "  segments: [{name: limb, axes: 1}]\n"
    "  coils:\n"
    "    - {name: A, segment: limb, direction_deg: 0}\n"
    "    - {name: B, segment: limb, direction_deg: 180}\n"
    "  channels:\n"
    "    - {column: temperature_A_degC, thermocouple: A}\n"
    "    - {column: temperature_B_degC, thermocouple: B}\n"
    "    - {column: angle_deg, bend: limb}\n";

// Two of them in series, seen by cameras: coils A and B on the first, C and D on the second.
inline const std::string two_segments =
    "format: 2\n"
    "limb:\n"
    "  segments: [{name: base, axes: 1}, {name: tip}]\n"
    "  coils:\n"
    "    - {name: A, segment: base, direction_deg: 0}\n"
    "    - {name: B, segment: base, direction_deg: 180}\n"
    "    - {name: C, segment: tip, direction_deg: 0}\n"
    "    - {name: D, segment: tip, direction_deg: 180}\n"
    "  channels:\n"
    "    - {column: angle_base_deg, camera: base}\n"
    "    - {column: angle_tip_deg, camera: tip}\n"
    "    - {column: temperature_C_degC, thermocouple: C}\n";

// One segment with two axes and three coils around it.
inline const std::string three_coils =
    "format: 2\n"
    "limb:\n"
    "  segments: [{name: arm, axes: 2}]\n"
    "  coils:\n"
    "    - {name: A, direction_deg: 0}\n"
    "    - {name: B, direction_deg: 120}\n"
    "    - {name: C, direction_deg: 240}\n"
    "  channels:\n"
    "    - {column: angle_x_deg, bend: arm, axis: x}\n"
    "    - {column: angle_y_deg, bend: arm, axis: y}\n";

// One segment with two axes and one coil at that direction.
inline std::string one_coil_at(const std::string& direction_deg) {
  return "format: 2\nlimb:\n  segments: [{name: arm, axes: 2}]\n  coils: [{name: A, direction_deg: " + direction_deg +
         "}]\n  channels: [{column: angle_x_deg, bend: arm, axis: x}, {column: angle_y_deg, bend: arm, axis: y}]\n";
}

}  // namespace sinew::test
