// SPDX-License-Identifier: Apache-2.0
// sinew convert: the logger's own format into a recording.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/app.h"
#include "apps/outputs.h"
#include "sim/recording.h"
#include "sim/text.h"

namespace sinew::apps {

void add_convert(CLI::App& program, int& exit_code) {
  struct Arguments {
    std::string logger, recording;
    bool swap_sides = false, overwrite = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("convert", "Convert a file of the limb's logger into a recording.");
  command->add_option("logger", arguments->logger, "the logger's file, 21 columns")->required();
  command->add_option("recording", arguments->recording, "the CSV to write")->required();
  command->add_flag("--swap-sides", arguments->swap_sides, "pwm_1 and Tr are coil A");
  add_overwrite(*command, arguments->overwrite);
  command->footer("Example:\n  sinew convert LOGGER.txt recording.csv");
  command->callback([arguments, &exit_code] {
    check_output_file(arguments->recording, {.files = {arguments->logger}}, arguments->overwrite);
    sim::Recording recording = sim::read_logger(arguments->logger, arguments->swap_sides);
    sim::write_recording(arguments->recording, recording);
    std::printf("%zu samples over %s s, one every %s s in the median\n%swritten: %s\n", recording.samples.size(),
                sim::shortest(recording.duration_s()).c_str(), sim::shortest(recording.median_period_s()).c_str(),
                recording.notes.summary().c_str(), arguments->recording.c_str());
    exit_code = 0;
  });
}

}  // namespace sinew::apps
