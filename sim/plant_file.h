// SPDX-License-Identifier: Apache-2.0
// A plant in YAML: its structure under the name of its System (left out: the usual one), a map `parameters:` of the core's names,
// and a map `effects:` of names of effects, each with all of its parameters. What `parameters` leaves out has its default, or that
// of the plant that `base:` names. A part may have values of its own, under its name.
//
//     base: paper_limb                    # or a file, relative to this one; left out: paper_limb
//     parameters: { ambient_temperature_degC: 22.0 }
//     effects:
//       latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } }
//
// Physics without a name stands in a list `laws:`, each a curve at an entry (plant/laws.h); `sinew diagnose` writes them:
//
//     laws:
//       - entry: moment
//         argument: angle                  # where several parts have the entry, a list: one variable each
//         times: ...                       # what the curve is a share of; left out: nothing, values are in the entry's unit
//         fading_memory_s: 20              # left out: none
//         knots: [-20, -5, 5, 20]
//         values: [0.001, 0, 0, -0.002]
//
// `format: 2` is needed where a structure, values of a part's own or laws are given. All of it walks the lists of a System; nothing
// here knows a parameter by name.
#pragma once

#include <filesystem>
#include <string>

#include "plant/systems.h"
#include "sim/yaml.h"

namespace sinew::sim {

// Throws InputError. `folder`: where a `base` with a path is looked for.
plant::Plant read_plant(const YamlValue& value, const std::filesystem::path& folder);
plant::Plant read_plant_file(const std::filesystem::path& file);

// The structure where it is not the usual one, every parameter of the core, and every effect that is on with all of its parameters;
// `indent` spaces before each line. What is written reads back as the same plant, bit for bit, if it was read from a file;
// angles of other plants can be off by a rounding.
std::string plant_to_yaml(const plant::Plant& plant, int indent = 0);
// The same as a file: with `format:` above it.
std::string plant_file_text(const plant::Plant& plant);

// A number as it is written in a file: of the numbers around the quotient that are converted back to the same internal
// value, the one of the shortest form. Where there is none (an internal value that no file gave), the quotient.
std::string text_in_unit(double internal, double internal_per_unit);
std::string parameter_text(const plant::Plant& plant, plant::ParameterId parameter);

}  // namespace sinew::sim
