// SPDX-License-Identifier: Apache-2.0
#include "apps/limb_link.h"

#include <filesystem>

#include "sim/input_error.h"

namespace sinew::apps {

std::vector<std::string> emulator_command(const std::string& scenario, const std::vector<std::string>& faults) {
  // Beside the program, or where it is installed.
  const std::filesystem::path bin = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  std::filesystem::path here = bin;
  const std::filesystem::path installed = bin.parent_path() / "lib/sinew";
  if (!std::filesystem::exists(bin / "sinew-emulator") && std::filesystem::exists(installed)) here = installed;
  for (const char* name : {"sinew-emulator", "firmware.elf"})
    if (!std::filesystem::exists(here / name))
      throw sim::InputError(
          {.file = (here / name).string(), .advice = "is not there; it is built where gcc-avr, avr-libc and libsimavr-dev are installed"});
  std::vector<std::string> command{here / "sinew-emulator", scenario, "--firmware", here / "firmware.elf"};
  for (const std::string& fault : faults) command.insert(command.end(), {"--fault", fault});
  return command;
}

}  // namespace sinew::apps
