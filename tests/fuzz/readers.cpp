// SPDX-License-Identifier: Apache-2.0
// Every reader of text under coverage-guided fuzzing (clang's libFuzzer). The first byte chooses the reader; a finding is a crash, a
// sanitizer's report, or an exception that is no InputError.
//
//   cmake --preset fuzz && cmake --build --preset fuzz && build/fuzz/tests/sinew_fuzz_readers -max_total_time=600 CORPUS
//
// `tests/fuzz/corpus FOLDER` writes a corpus to begin with: the files that ship with the project.
#include <cstdint>
#include <string>
#include <string_view>

#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/log_reader.h"
#include "sim/plant_file.h"
#include "sim/recording.h"
#include "sim/scenario.h"
#include "sim/yaml.h"

namespace {

using namespace sinew;

const plant::System& two_coils() {
  static const plant::Plant limb = sim::read_plant(sim::parse_yaml("format: 1\n", "limb.yaml"), ".");
  return limb.system();
}

// A map, a line of three %, and the log that it is for.
void read_with_map(std::string_view text) {
  const std::size_t cut = text.find("%%%\n");
  if (cut == std::string_view::npos) return;
  const sim::LogMap map = sim::parse_log_map(sim::parse_yaml(text.substr(0, cut), "map.yaml"));
  sim::apply_log_map(map, sim::parse_text_log(std::string(text.substr(cut + 4)), "log.csv", map.layout, map.wanted_names()));
}

void read(char reader, std::string_view text) {
  switch (reader) {
    case 'p':
      sim::read_plant(sim::parse_yaml(text, "plant.yaml"), "/nowhere");
      break;
    case 's':
      sim::parse_scenario(text, "/nowhere/scenario.yaml");
      break;
    case 'r':
      sim::parse_recording(text, "recording.csv", sim::columns_of(two_coils()));
      break;
    case 'l':
      sim::parse_logger(text, "logger.csv", two_coils());
      break;
    case 'm':
      read_with_map(text);
      break;
    default:
      break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read(static_cast<char>(data[0]), {reinterpret_cast<const char*>(data) + 1, size - 1});
  } catch (const sim::InputError&) {
  }
  return 0;
}
