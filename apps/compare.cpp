// SPDX-License-Identifier: Apache-2.0
// sinew compare: a plant against a recording, in open loop.
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/app.h"
#include "apps/comparison_page.h"
#include "apps/ends_soon.h"
#include "apps/ignore.h"
#include "apps/outputs.h"
#include "diagnose/calibrate.h"
#include "report/console.h"
#include "report/svg.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct CompareArguments {
  std::string recording, plant, out;
  std::vector<std::string> ignored;
  double start_from_s = 60.0, fit_until_s = std::numeric_limits<double>::infinity();
  bool at_rest = false, json = false, overwrite = false;
};

int compare_command(const CompareArguments& arguments) {
  std::optional<Outputs> outputs;
  const InputPaths read{.files = {arguments.recording}, .yaml = {arguments.plant}};
  if (arguments.out.empty()) {
    finish_interrupted(read);
  } else {
    outputs.emplace(arguments.out, read, arguments.overwrite);
    outputs->claim({"comparison.html", "comparison.svg"});
  }
  std::optional<EndsSoon> ends_soon(outputs ? &*outputs : nullptr);
  const plant::Plant plant = sim::read_plant_file(arguments.plant);
  sim::Recording recording = read_recording_of(arguments.recording, plant);
  ignore(arguments.ignored, plant.system(), {&recording});
  check_keeps_back({recording}, arguments.fit_until_s);
  const diagnose::PerChannel noise = diagnose::noise_of(plant.system(), recording);
  const plant::NumericalSettings numerics{plant::Method::automatic, 1e-7};

  // What the plant was doing when the recording began is found from its first minute, with the plant as it is.
  const std::vector<std::string> doubts = doubts_of(plant, recording, noise);
  if (!recording.time_zero_s) recording.time_zero_s = 0.0;  // of one recording its own time is clock enough
  const std::vector<sim::Recording> parts = usable_parts(recording);
  recording = joined(recording, parts);
  std::vector<plant::Start> starts(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (arguments.at_rest && p == 0) continue;  // after a pause nobody knows
    const double from_s = parts[p].samples.front().time_s, until_s = from_s + arguments.start_from_s;
    const bool is_fitted = from_s < arguments.fit_until_s;
    const std::size_t count =
        std::max<std::size_t>(2, diagnose::samples_until(parts[p], is_fitted ? std::min(until_s, arguments.fit_until_s) : until_s));
    diagnose::CalibrationSettings settings;
    settings.only_start = true;
    settings.start = {diagnose::StartPolicy::estimated, parts.front().begins_s(), p > 0};
    settings.should_stop = interrupted;
    starts[p] = diagnose::calibrate(plant, {{&parts[p], count, noise}}, settings).starts_of_recordings.front();
  }
  const diagnose::Comparison comparison = diagnose::compare(plant, starts, parts, noise, arguments.fit_until_s, numerics);
  ends_soon.reset();
  if (arguments.json) {
    nlohmann::ordered_json json;
    json["recording"] = arguments.recording;
    json["plant"] = arguments.plant;
    json["doubts"] = doubts;
    json["channels"] = channels_json(comparison);
    std::printf("%s\n", json.dump(2).c_str());
  } else {
    std::fputs(recording.notes.summary().c_str(), stdout);
    for (const std::string& line : doubts) std::printf("%s\n", report::wrap(line).c_str());
    std::fputs(report::to_text(error_table(comparison)).c_str(), stdout);
    for (const std::string& line : findings(comparison)) std::printf("%s\n", report::wrap(line).c_str());
  }
  if (outputs) {
    report::Page page;
    page.title = "Comparison with a recording";
    page.lead = findings(comparison).empty() ? "The recording has no measurements." : findings(comparison).back();
    if (!doubts.empty()) {
      report::Section odd;
      odd.heading = "What is odd about the recording";
      odd.items = doubts;
      page.blocks.push_back(odd);
    }
    report::Section section;
    section.heading = "How far off";
    section.items = findings(comparison);
    page.blocks.push_back(section);
    page.blocks.push_back(error_table(comparison));
    for (auto& block : comparison_blocks(comparison, recording)) page.blocks.push_back(std::move(block));
    page.footer = {"recording: " + arguments.recording, "plant: " + arguments.plant,
                   arguments.at_rest ? std::string("start: cold and at rest")
                                     : "start: estimated from the first " + sim::shortest(arguments.start_from_s) + " s",
                   "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
    outputs->stage("comparison.svg", report::stacked_svg(paper_figure(comparison, recording), 720, 640));
    outputs->stage("comparison.html", report::to_html(page));
    outputs->commit();
    if (!arguments.json) std::printf("report: %s\n", (outputs->folder() / "comparison.html").string().c_str());
  }
  return 0;
}

}  // namespace

void add_compare(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = program.add_subcommand("compare", "Compare a plant with a recording, in open loop from its inputs.");
  command->add_option("recording", arguments->recording, "recording in CSV")->required();
  command->add_option("--plant", arguments->plant, "plant in YAML")->required();
  command->add_option("--out", arguments->out, "folder for comparison.html and comparison.svg");
  command->add_option("--start-from", arguments->start_from_s, "estimate the first state from so many seconds")
      ->check(positive_number())
      ->capture_default_str();
  command->add_option("--fit-until", arguments->fit_until_s, "the plant was fitted until here [s]: what comes later is counted apart")
      ->check(positive_number());
  add_ignore(*command, arguments->ignored);
  command->add_flag("--at-rest", arguments->at_rest, "the recording begins cold and at rest");
  command->add_flag("--json", arguments->json, "print JSON");
  add_overwrite(*command, arguments->overwrite);
  command->footer("Example:\n  sinew compare recording.csv --plant results/mine/plant.yaml --out results/mine");
  command->callback([arguments, &exit_code] { exit_code = compare_command(*arguments); });
}

}  // namespace sinew::apps
