// SPDX-License-Identifier: Apache-2.0
// A plant in YAML: a map `parameters:` of the core's names, and a map `effects:` of names of effects, each with all of its
// parameters. What `parameters` leaves out has its default, or that of the plant that `base:` names.
//
//     base: paper_limb                    # or a file, relative to this one; left out: paper_limb
//     parameters: { ambient_temperature_degC: 22.0 }
//     effects:
//       thermocouple_lag: { time_constant_s: 1.2 }
//
// All of it walks the declarations of plant/; nothing here knows a parameter by name.
#pragma once

#include <filesystem>
#include <string>

#include "plant/limb.h"
#include "sim/yaml.h"

namespace sinew::sim {

// Throws InputError. `folder`: where a `base` with a path is looked for.
plant::Limb<double> read_plant(const YamlValue& value, const std::filesystem::path& folder);
plant::Limb<double> read_plant_file(const std::filesystem::path& file);

// Every parameter of the core, and every effect that is on with all of its parameters; `indent` spaces before each line.
// What is written reads back as the same limb, bit for bit, if it was read from a file; angles of other limbs can be off
// by a rounding.
std::string plant_to_yaml(const plant::Limb<double>& limb, int indent = 0);

// A number as it is written in a file: of the numbers around the quotient that are converted back to the same internal
// value, the one of the shortest form. Where there is none (an internal value that no file gave), the quotient.
std::string text_in_unit(double internal, double internal_per_unit);
std::string parameter_text(const plant::Limb<double>& limb, std::size_t parameter);

}  // namespace sinew::sim
