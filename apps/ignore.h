// SPDX-License-Identifier: Apache-2.0
// --ignore: rows of a recording that are not to be trusted, channel by channel.
#pragma once

#include <string>
#include <vector>

#include "apps/app.h"
#include "plant/system.h"
#include "sim/recording.h"

namespace sinew::apps {

void add_ignore(CLI::App& command, std::vector<std::string>& ignored);

// Each of `ignored` is CHANNEL:FROM-TO in seconds of the recordings' own time; a star in CHANNEL stands for any letters. What they name
// becomes missing. Throws InputError where one is misspelt, names no channel, or lies in none of the recordings, and where fewer
// than 20 samples of a channel are left.
void ignore(const std::vector<std::string>& ignored, const plant::System& system, const std::vector<sim::Recording*>& recordings);

}  // namespace sinew::apps
