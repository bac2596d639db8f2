// SPDX-License-Identifier: Apache-2.0
// sinew convert: the file of any logger into a recording, by a map; without one, the limb's own logger of 21 columns.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/app.h"
#include "apps/ends_soon.h"
#include "apps/outputs.h"
#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/log_suggest.h"
#include "sim/recording.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

void say_what_was_written(std::size_t samples, const std::string& duration_s, const std::string& period_s, const std::string& notes,
                          const std::string& path) {
  std::printf("%zu samples over %s s, one every %s s in the median\n%swritten: %s\n", samples, duration_s.c_str(), period_s.c_str(),
              notes.c_str(), path.c_str());
}

void refuse(std::string key, std::string advice) { throw sim::InputError({.key = std::move(key), .advice = std::move(advice)}); }

void convert_by_map(const std::string& log, const std::string& output, const std::string& map_path) {
  std::optional<EndsSoon> ends_soon(nullptr);
  const sim::LogMap map = sim::read_log_map(map_path);
  const sim::Conversion conversion = sim::convert_log(log, map);
  const std::string csv = sim::to_csv(conversion.table);
  ends_soon.reset();
  sim::write_file_whole(output, csv);
  const std::vector<double>& time_s = conversion.table.columns.front().values;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps_s.push_back(time_s[i] - time_s[i - 1]);
  say_what_was_written(time_s.size(), sim::rounded(time_s.back() - time_s.front(), 6),
                       sim::rounded(sim::lower_median(std::move(steps_s)), 5), conversion.notes, output);
}

}  // namespace

void add_convert(CLI::App& program, int& exit_code) {
  struct Arguments {
    std::string log, recording, map, suggest;
    bool swap_sides = false, overwrite = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("convert", "Convert the file of any logger into a recording.");
  command->add_option("log", arguments->log, "the logger's file: text, MATLAB's .mat, or HDF5");
  command->add_option("recording", arguments->recording, "the CSV to write");
  command->add_option("--map", arguments->map, "what the columns mean (docs/convert.md); without it: the limb's logger of 21 columns");
  command->add_option("--suggest", arguments->suggest, "print a map to begin with for this file")->option_text("FILE");
  command->add_flag("--swap-sides", arguments->swap_sides, "without a map: pwm_1 and Tr are coil A");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n"
      "  sinew convert --suggest robot.csv > robot.map.yaml\n"
      "  sinew convert robot.csv recording.csv --map robot.map.yaml\n"
      "  sinew convert DATA_EMPS.mat emps.csv --map plant/emps/emps.map.yaml\n"
      "  sinew convert LOGGER.txt recording.csv");
  command->callback([arguments, &exit_code] {
    const Arguments& a = *arguments;
    exit_code = 0;
    if (!a.suggest.empty()) {
      if (!a.log.empty() || !a.map.empty() || a.swap_sides) refuse("--suggest FILE", "stands alone: it prints a map, and converts nothing");
      std::fputs(sim::suggest_map(a.suggest).c_str(), stdout);
      return;
    }
    if (a.log.empty() || a.recording.empty()) refuse("sinew convert LOG RECORDING", "needs both: the logger's file, and the CSV to write");
    InputPaths read{.files = {a.log}};
    if (!a.map.empty()) read.files.push_back(a.map);
    check_output_file(a.recording, read, a.overwrite);
    if (!a.map.empty()) {
      if (a.swap_sides) refuse("--swap-sides", "is for the limb's own logger; a map names each coil's columns");
      convert_by_map(a.log, a.recording, a.map);
      return;
    }
    if (std::filesystem::is_regular_file(a.log) && sim::kind_of_log(a.log) != sim::LogKind::text)
      refuse(a.log, "is a MATLAB or HDF5 file, and needs --map MAP.yaml; `sinew convert --suggest " + a.log + "` prints one to begin with");
    sim::Recording recording = sim::read_logger(a.log, plant::default_plant().system(), a.swap_sides);
    sim::write_recording(a.recording, recording);
    say_what_was_written(recording.samples.size(), sim::shortest(recording.duration_s()), sim::shortest(recording.median_period_s()),
                         recording.notes.summary(), a.recording);
  });
}

}  // namespace sinew::apps
