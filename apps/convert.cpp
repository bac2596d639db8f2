// SPDX-License-Identifier: Apache-2.0
// sinew convert: the file of any logger into a recording, by a map; without one, the limb's own logger of 21 columns. And what the
// program wrote into the formats of others: recordings into .mat and HDF5, an LSTM into ONNX.
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "apps/app.h"
#include "apps/ends_soon.h"
#include "apps/outputs.h"
#include "apps/training.h"
#include "model/hdf5_file.h"
#include "model/lstm_predictor.h"
#include "model/onnx_file.h"
#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/log_suggest.h"
#include "sim/mat_file.h"
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

enum class OutputKind { csv, mat, hdf5, onnx };

// By the ending of the name.
OutputKind kind_of_output(const std::string& path) {
  const std::string ending = sim::lower_case(std::filesystem::path(path).extension().string());
  if (ending == ".mat") return OutputKind::mat;
  if (ending == ".onnx") return OutputKind::onnx;
  if (ending == ".h5" || ending == ".hdf5") return OutputKind::hdf5;
  if (ending != "" && ending != ".csv" && ending != ".txt")
    throw sim::InputError({.file = path, .value = ending, .advice = "is no format that is written: .csv, .mat, .h5, .hdf5 or .onnx"});
  return OutputKind::csv;
}

std::string in_format(const sim::Table& table, OutputKind kind) {
  if (kind == OutputKind::csv) return sim::to_csv(table);
  if (kind == OutputKind::mat) return sim::to_mat(table);
  model::Hdf5File file;
  for (const sim::TableColumn& column : table.columns)
    file.arrays["/" + column.name] = {.extents = {column.values.size()}, .values = column.values, .single = false};
  return model::to_bytes(file);
}

sim::Table table_of(const sim::Recording& recording) {
  sim::Table table{recording.comments, {{"time_s", {}}}};
  for (const auto* columns : {&recording.columns.inputs, &recording.columns.channels})
    for (const sim::Column& column : *columns) table.columns.push_back({column.name, {}});
  for (const sim::Sample& sample : recording.samples) {
    std::size_t c = 0;
    table.columns[c++].values.push_back(sample.time_s);
    for (const auto* values : {&sample.inputs, &sample.channels})
      for (const double value : *values) table.columns[c++].values.push_back(value);
  }
  return table;
}

// A CSV that the program itself wrote, such as a recording or truth.csv: told by its first column.
std::optional<sim::Table> own_table(const std::string& path) {
  if (!std::filesystem::is_regular_file(path) || sim::kind_of_log(path) != sim::LogKind::text) return std::nullopt;
  const std::string text = sim::read_file(path);
  std::size_t at = 0;
  while (text.compare(at, 1, "#") == 0) at = std::min(text.find('\n', at), text.size() - 1) + 1;
  if (text.compare(at, 7, "time_s,") != 0) return std::nullopt;
  const sim::Log log = sim::read_log(path, {});
  sim::Table table{log.comments, {}};
  for (std::size_t c = 0; c < log.columns(); ++c) {
    table.columns.push_back({log.names[c], {}});
    for (std::size_t r = 0; r < log.rows(c); ++r) {
      const auto number = log.number(r, c);
      if (!number) log.fail_at(r, c, std::string(log.field(r, c)), "is no number");
      table.columns.back().values.push_back(*number);
    }
  }
  if (table.rows() == 0) throw sim::InputError({.file = path, .advice = "has no rows"});
  return table;
}

void say_table(const sim::Table& table, const std::string& notes, const std::string& output) {
  const std::vector<double>& time_s = table.columns.front().values;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps_s.push_back(time_s[i] - time_s[i - 1]);
  say_what_was_written(time_s.size(), sim::rounded(time_s.back() - time_s.front(), 6),
                       sim::rounded(sim::lower_median(std::move(steps_s)), 5), notes, output);
}

void convert_to_onnx(const std::string& path, const std::string& output) {
  if (!std::filesystem::exists(weights_path(path)))
    throw sim::InputError({.file = weights_path(path), .advice = "is not there; an ONNX file is made of the weights.h5 of `sinew train`"});
  const auto predictor = read_predictor_at(path);
  const auto* lstm = dynamic_cast<const model::LstmPredictor*>(predictor.get());
  if (!lstm || lstm->model().weights.shape.cell != model::Cell::lstm)
    throw sim::InputError({.file = weights_path(path),
                           .key = "predictor",
                           .value = predictor->about().kind,
                           .advice = "has no form in ONNX: must be an LSTM, published or stateful"});
  sim::write_file_whole(output, model::to_onnx(lstm->model()));
  const model::AboutPredictor& about = lstm->about();
  std::printf("%s, case %d: %s from %s\nwritten: %s\n", about.kind.c_str(), about.task.paper_case, about.task.predicted.name.c_str(),
              words_of(about.task).c_str(), output.c_str());
}

void convert_by_map(const std::string& log, const std::string& output, const std::string& map_path) {
  std::optional<EndsSoon> ends_soon(nullptr);
  const sim::LogMap map = sim::read_log_map(map_path);
  const sim::Conversion conversion = sim::convert_log(log, map);
  const std::string bytes = in_format(conversion.table, kind_of_output(output));
  ends_soon.reset();
  sim::write_file_whole(output, bytes);
  say_table(conversion.table, conversion.notes, output);
}

}  // namespace

void add_convert(CLI::App& program, int& exit_code) {
  struct Arguments {
    std::string log, recording, map, suggest;
    bool swap_sides = false, overwrite = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.add_subcommand("convert",
                             "Convert the file of any logger into a recording, recordings into .mat or HDF5, an LSTM into ONNX.");
  command->add_option("log", arguments->log,
                      "the logger's file: text, MATLAB's .mat, or HDF5; a CSV that sinew wrote; or a predictor, as `rollout` takes it");
  command->add_option("recording", arguments->recording, "the file to write: CSV, or by its ending .mat, .h5, .hdf5 or .onnx");
  command->add_option("--map", arguments->map, "what the columns mean (docs/convert.md); without it: the limb's logger of 21 columns");
  command->add_option("--suggest", arguments->suggest, "print a map to begin with for this file")->option_text("FILE");
  command->add_flag("--swap-sides", arguments->swap_sides, "without a map: pwm_1 and Tr are coil A");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n"
      "  sinew convert --suggest robot.csv > robot.map.yaml\n"
      "  sinew convert robot.csv recording.csv --map robot.map.yaml\n"
      "  sinew convert DATA_EMPS.mat emps.csv --map plant/emps/emps.map.yaml\n"
      "  sinew convert LOGGER.txt recording.csv\n"
      "  sinew convert recording.csv recording.mat\n"
      "  sinew convert results/lstm4 lstm4.onnx");
  command->callback([arguments, &exit_code] {
    const Arguments& a = *arguments;
    exit_code = 0;
    if (!a.suggest.empty()) {
      if (!a.log.empty() || !a.map.empty() || a.swap_sides) refuse("--suggest FILE", "stands alone: it prints a map, and converts nothing");
      std::fputs(sim::suggest_map(a.suggest).c_str(), stdout);
      return;
    }
    if (a.log.empty() || a.recording.empty()) refuse("sinew convert LOG RECORDING", "needs both: the logger's file, and the file to write");
    InputPaths read{.files = {a.log}};
    if (!a.map.empty()) read.files.push_back(a.map);
    check_output_file(a.recording, read, a.overwrite);
    if (kind_of_output(a.recording) == OutputKind::onnx) {
      if (!a.map.empty() || a.swap_sides) refuse("--map, --swap-sides", "are for recordings: an .onnx file is made of a predictor");
      convert_to_onnx(a.log, a.recording);
      return;
    }
    if (!a.map.empty()) {
      if (a.swap_sides) refuse("--swap-sides", "is for the limb's own logger; a map names each coil's columns");
      convert_by_map(a.log, a.recording, a.map);
      return;
    }
    const OutputKind kind = kind_of_output(a.recording);
    if (kind != OutputKind::csv)
      if (const std::optional<sim::Table> table = own_table(a.log)) {
        if (a.swap_sides) refuse("--swap-sides", "is for the limb's own logger");
        sim::write_file_whole(a.recording, in_format(*table, kind));
        say_table(*table, "", a.recording);
        return;
      }
    if (std::filesystem::is_regular_file(a.log) && sim::kind_of_log(a.log) != sim::LogKind::text)
      refuse(a.log, "is a MATLAB or HDF5 file, and needs --map MAP.yaml; `sinew convert --suggest " + a.log + "` prints one to begin with");
    const sim::Recording recording = sim::read_logger(a.log, plant::default_plant().system(), a.swap_sides);
    if (kind == OutputKind::csv)
      sim::write_recording(a.recording, recording);
    else
      sim::write_file_whole(a.recording, in_format(table_of(recording), kind));
    say_what_was_written(recording.samples.size(), sim::shortest(recording.duration_s()), sim::shortest(recording.median_period_s()),
                         recording.notes.summary(), a.recording);
  });
}

}  // namespace sinew::apps
