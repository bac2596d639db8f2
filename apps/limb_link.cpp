// SPDX-License-Identifier: Apache-2.0
#include "apps/limb_link.h"

#include <filesystem>

#include "sim/input_error.h"

namespace sinew::apps {

std::vector<std::string> emulator_command(const std::string& scenario, const std::vector<std::string>& faults) {
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  for (const char* name : {"sinew-emulator", "firmware.elf"})
    if (!std::filesystem::exists(here / name))
      throw sim::InputError(
          {.file = (here / name).string(), .advice = "is not there; it is built where gcc-avr, avr-libc and libsimavr-dev are installed"});
  std::vector<std::string> command{here / "sinew-emulator", scenario, "--firmware", here / "firmware.elf"};
  for (const std::string& fault : faults) command.insert(command.end(), {"--fault", fault});
  return command;
}

}  // namespace sinew::apps
