// SPDX-License-Identifier: Apache-2.0
// A map to begin with, from a look at a logger's file: `sinew convert --suggest`.
#pragma once

#include <filesystem>
#include <string>

#include "sim/log_reader.h"

namespace sinew::sim {

// YAML that parse_log_map accepts wherever a column looks like time: the columns that look like duty, temperature, angle, PWM counts or
// followed points are mapped, the others are listed as comments with their ranges.
std::string suggest_map(const std::filesystem::path& path);
// The same of a text, for how it is laid out.
std::string suggest_text_map(const std::string& text, const std::string& file);

}  // namespace sinew::sim
