// Where the emulator and its firmware are: beside this program.
#pragma once

#include <string>
#include <vector>

namespace sinew::apps {

// Program and arguments. Throws sim::InputError where one is missing.
std::vector<std::string> emulator_command(const std::string& scenario, const std::vector<std::string>& faults);

}  // namespace sinew::apps
