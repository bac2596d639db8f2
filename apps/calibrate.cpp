// SPDX-License-Identifier: Apache-2.0
// sinew calibrate: fits a plant to recordings, and says which parameters the data tells.
#include "apps/calibrate.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "apps/app.h"
#include "apps/comparison_page.h"
#include "apps/ends_soon.h"
#include "apps/ignore.h"
#include "apps/outputs.h"
#include "diagnose/calibrate.h"
#include "report/console.h"
#include "report/number.h"
#include "report/svg.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct CalibrateArguments : CalibrateRequest {
  std::string out;
  bool json = false, overwrite = false;
};

double in_file_units(const diagnose::Estimate& estimate, double internal) { return internal / estimate.unknown.internal_per_unit; }

bool is_parameter(const diagnose::Estimate& estimate) { return estimate.unknown.parameter.has_value(); }

std::vector<plant::ParameterId> chosen_parameters(const std::vector<std::string>& names, const plant::Plant& plant) {
  std::vector<plant::ParameterId> chosen;
  std::vector<std::string> all;
  for (const plant::ParameterId p : diagnose::fittable_parameters(plant)) all.push_back(plant.system().parameters()[p].key());
  for (const std::string& name : names) {
    const auto found = std::find(all.begin(), all.end(), name);
    if (found == all.end()) {
      const auto there = plant.system().find_parameter(name);
      const auto effect = there ? plant.system().parameters()[*there].effect : std::nullopt;
      const std::string why = effect && !plant.is_on(*effect) ? ": its effect is not on in the plant"
                              : there ? ": it is known, with a deviation of 0; the plant may give it as {value: ..., deviation: ...}"
                                      : sim::did_you_mean(name, all);
      const std::string advice = "no such parameter that can be fitted" + why;
      throw sim::InputError({.file = "",
                             .key = "--fit",
                             .value = name,
                             .advice = advice + "\n`sinew effects --core` lists the core's; an effect's must be on in the plant"});
    }
    chosen.push_back(plant.system().parameter(name));
  }
  return chosen;
}

report::Table parameter_table(const diagnose::Calibration& calibration, bool parameters) {
  report::Table table;
  table.header = {parameters ? "parameter" : "first value", "unit", "before", "fitted", "± standard error", "of prior", "told"};
  for (const auto& e : calibration.estimates) {
    if (is_parameter(e) != parameters) continue;
    report::Row row;
    const double error = in_file_units(e, e.standard_error);
    row.cells = {e.unknown.name,
                 std::string(e.unknown.unit),
                 report::significant(in_file_units(e, e.unknown.centre), 4),
                 report::significant(in_file_units(e, e.value), 4),
                 report::significant(error, 2),
                 report::fixed(100.0 * e.share_of_prior, 0) + " %",
                 e.told() ? "yes" : "no"};
    if (e.at_bound)
      row.note = "at the bound of what is allowed: the model is probably missing something";
    else if (std::abs(e.surprise()) > 3.0)
      row.note = report::significant(e.surprise(), 2) + " prior deviations from where it began: the model is probably missing something";
    else if (!e.told() && std::abs(e.partner_correlation) > 0.5)
      row.note = "trades off with " + e.partner + " (correlation " + report::significant(e.partner_correlation, 2) + ")";
    table.rows.push_back(row);
  }
  table.align = {report::Align::left,  report::Align::left,  report::Align::right, report::Align::right,
                 report::Align::right, report::Align::right, report::Align::left};
  table.caption = "Of prior: the standard error as a share of what was uncertain before the data. Above 70 % the data cannot tell.";
  return table;
}

std::string untold_sentence(const diagnose::Calibration& calibration) {
  std::string names;
  for (const auto& e : calibration.estimates)
    if (is_parameter(e) && !e.told()) names += (names.empty() ? "" : ", ") + e.unknown.name;
  if (names.empty()) return "The data tells every parameter that was fitted.";
  return "The data cannot tell these; their values are mostly what was believed before: " + names + ".";
}

std::string signs_sentence(const diagnose::Calibration& calibration) {
  std::string text;
  for (const plant::ParameterId p : calibration.flipped_signs)
    text += "The recording says that " + calibration.fitted.system().parameters()[p].key() + " is " +
            sim::parameter_text(calibration.fitted, p) + ", the other way than in the nominal plant, and that was used. ";
  return text;
}

std::string starts_sentence(const diagnose::Calibration& calibration) {
  int usable = 0;
  for (const auto& outcome : calibration.outcomes) usable += outcome.usable;
  if (calibration.outcomes.size() == 1) return "There was one start alone: whether another finds the same optimum is not known.";
  std::string text = std::to_string(usable) + " of " + std::to_string(calibration.outcomes.size()) + " starts could be used; ";
  return text + (calibration.several_starts_agree
                     ? "all found the same optimum."
                     : "they did NOT find the same optimum: the best one is reported, and may not be the best there is.");
}

// How a part that was not fitted begins, from its first minute, with the plant as it is.
plant::Start start_of_part(const plant::Plant& plant, const sim::Recording& part, const diagnose::PerChannel& noise,
                           std::optional<double> counted_from_s, const std::function<bool()>& should_stop) {
  constexpr double settling_s = 60.0;
  diagnose::CalibrationSettings settings;
  settings.only_start = true;
  settings.start = {diagnose::StartPolicy::estimated, counted_from_s, true};
  settings.should_stop = should_stop;
  const std::size_t count = diagnose::samples_until(part, part.samples.front().time_s + settling_s);
  return diagnose::calibrate(plant, {{&part, std::max<std::size_t>(2, count), noise}}, settings).starts_of_recordings.front();
}

nlohmann::ordered_json calibration_json(const CalibrateRequest& arguments, const diagnose::Calibration& calibration,
                                        const std::vector<diagnose::Comparison>& comparisons,
                                        const std::vector<std::vector<std::string>>& oddities) {
  nlohmann::ordered_json json;
  json["program"] = "sinew " + sim::this_build().version;
  json["commit"] = sim::this_build().commit;
  if (comparisons.size() == 1) json["recording"] = arguments.recordings.front();
  json["plant"] = arguments.plant;
  if (std::isfinite(arguments.fit_until_s)) json["fit_until_s"] = arguments.fit_until_s;
  json["seed"] = arguments.seed;
  for (const plant::ParameterId p : calibration.flipped_signs)
    json["flipped_signs"].push_back(calibration.fitted.system().parameters()[p].key());
  json["doubts"] = nlohmann::ordered_json::array();
  for (std::size_t r = 0; r < oddities.size(); ++r)
    if (!oddities[r].empty()) json["doubts"].push_back({{"recording", arguments.recordings[r]}, {"lines", oddities[r]}});
  json["starts_agree"] = calibration.several_starts_agree;
  for (const auto& outcome : calibration.outcomes)
    json["starts"].push_back(
        {{"usable", outcome.usable}, {"cost", outcome.cost}, {"passes", outcome.passes}, {"iterations", outcome.iterations}});
  for (const auto& e : calibration.estimates) {
    nlohmann::ordered_json one{{"name", e.unknown.name},
                               {"unit", e.unknown.unit},
                               {"before", in_file_units(e, e.unknown.centre)},
                               {"value", in_file_units(e, e.value)},
                               {"standard_error", in_file_units(e, e.standard_error)},
                               {"share_of_prior", e.share_of_prior},
                               {"told", e.told()},
                               {"at_bound", e.at_bound}};
    if (!e.told()) one["trades_off_with"] = {{"name", e.partner}, {"correlation", e.partner_correlation}};
    json[is_parameter(e) ? "parameters" : "first_values"].push_back(one);
  }
  if (comparisons.size() == 1) {
    json["channels"] = channels_json(comparisons.front());
    return json;
  }
  for (std::size_t r = 0; r < comparisons.size(); ++r)
    json["recordings"].push_back({{"recording", arguments.recordings[r]}, {"channels", channels_json(comparisons[r])}});
  return json;
}

}  // namespace

std::vector<std::string> files_of_calibration() { return {"report.html", "figure.svg", "calibration.json", "plant.yaml"}; }

Calibrated calibrated(const CalibrateRequest& arguments, const plant::Plant& nominal, std::vector<sim::Recording> recordings) {
  const plant::System& system = nominal.system();
  std::vector<sim::Recording*> all;
  for (sim::Recording& recording : recordings) all.push_back(&recording);
  ignore(arguments.ignored, system, all);
  count_from_first(recordings);
  // Each part between pauses begins with a state of its own, as each recording does.
  std::vector<std::vector<sim::Recording>> parts;
  std::vector<std::vector<std::string>> odd;  // about each recording
  for (sim::Recording& recording : recordings) {
    odd.push_back(oddities_of(nominal, recording, diagnose::noise_of(system, recording), recordings.size() == 1));
    parts.push_back(usable_parts(recording));
    recording = joined(recording, parts.back());
  }
  const bool has_pauses = std::any_of(parts.begin(), parts.end(), [](const auto& of_one) { return of_one.size() > 1; });
  std::vector<diagnose::FitData> data;
  std::vector<diagnose::PerChannel> noise;                                         // of each recording
  std::vector<std::vector<std::optional<std::size_t>>> fitted(recordings.size());  // which of `data` a part is; none: held out
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const sim::Recording& recording = recordings[r];
    noise.push_back(noise_of_option(arguments.noise, system, diagnose::noise_of(system, recording)));
    const std::size_t count = diagnose::samples_until(recording, arguments.fit_until_s);
    check_long_enough(recording, arguments.fit_until_s);
    for (const sim::Recording& part : parts[r]) {
      const std::size_t of_part = diagnose::samples_until(part, arguments.fit_until_s);
      const bool is_fitted = of_part >= std::min(least_samples, count);
      fitted[r].push_back(is_fitted ? std::optional(data.size()) : std::nullopt);
      if (is_fitted) data.push_back({&part, of_part, noise[r]});
    }
  }
  check_keeps_back(recordings, arguments.fit_until_s);
  std::size_t samples = 0;
  for (const diagnose::FitData& one : data) samples += one.sample_count;
  check_fitted_samples(samples, recordings.front().name);
  diagnose::CalibrationSettings settings;
  settings.parameters = chosen_parameters(arguments.fit, nominal);
  settings.start = arguments.at_rest && !has_pauses ? diagnose::StartPolicy::at_rest : diagnose::StartPolicy::estimated;
  settings.starts = arguments.starts;
  settings.seed = static_cast<std::uint64_t>(arguments.seed);
  settings.threads = arguments.threads;
  settings.should_stop = arguments.should_stop;
  settings.progress = arguments.progress;
  const diagnose::Calibration calibration = diagnose::calibrate(nominal, data, settings);
  std::vector<diagnose::Comparison> comparisons;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    std::vector<plant::Start> starts;
    for (std::size_t p = 0; p < parts[r].size(); ++p)
      starts.push_back(fitted[r][p] ? calibration.starts_of_recordings[*fitted[r][p]]
                                    : start_of_part(calibration.fitted, parts[r][p], noise[r], data.front().recording->begins_s(),
                                                    arguments.should_stop));
    comparisons.push_back(
        diagnose::compare(calibration.fitted, starts, parts[r], noise[r], arguments.fit_until_s, {plant::Method::automatic, 1e-7}));
  }
  const report::Table parameters = parameter_table(calibration, true), first_values = parameter_table(calibration, false);
  const auto name_of = [](const std::string& file) { return std::filesystem::path(file).filename().string(); };
  const std::string names =
      name_of(recordings.front().name) + (recordings.size() > 1 ? " and " + std::to_string(recordings.size() - 1) + " more" : "");

  std::string yaml = "# Calibrated by `sinew calibrate` on " + names + ", from " + name_of(arguments.plant) + ".\n";
  for (const auto& e : calibration.estimates)
    if (is_parameter(e))
      yaml += "#   " + e.unknown.name + " +- " + report::significant(in_file_units(e, e.standard_error), 2) +
              (e.told() ? "\n" : ", which the data cannot tell\n");
  yaml += sim::plant_file_text(calibration.fitted);
  const nlohmann::ordered_json json = calibration_json(arguments, calibration, comparisons, odd);

  report::Page page;
  page.title = "Calibration on " + names;
  const std::vector<std::string> first_findings = findings(comparisons.front());
  page.lead = first_findings.empty() ? "The recording has no measurements." : first_findings.back();
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const std::string of = recordings.size() > 1 ? ": " + name_of(recordings[r].name) : "";
    report::Section off;
    off.heading = "How far off" + of;
    off.items = findings(comparisons[r]);
    page.blocks.push_back(off);
    page.blocks.push_back(error_table(comparisons[r]));
    for (auto& block : comparison_blocks(comparisons[r], recordings[r])) {
      if (auto* part = std::get_if<report::Section>(&block); part && r > 0) part->depth = 3;
      page.blocks.push_back(std::move(block));
    }
  }
  report::Section told;
  told.heading = "Parameters";
  told.text = signs_sentence(calibration) + untold_sentence(calibration) + " " + starts_sentence(calibration) +
              "\n\nA standard error here takes the residuals as they are, in size and in how long they stay correlated.";
  page.blocks.push_back(told);
  page.blocks.push_back(parameters);
  if (!first_values.rows.empty()) {
    report::Section start;
    start.heading = "How the recording begins";
    start.text = "A recording may begin in mid-motion; what " + std::string(system.words()) + " was doing then is estimated with the rest.";
    page.blocks.push_back(start);
    page.blocks.push_back(first_values);
  }
  std::string oddities;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!odd[r].empty() && recordings.size() > 1) oddities += name_of(recordings[r].name) + ":\n";
    for (const std::string& line : odd[r]) oddities += line + "\n";
  }
  if (!oddities.empty()) {
    report::Section section;
    section.heading = "What was odd about the recording";
    section.text = oddities;
    page.blocks.push_back(section);
  }
  for (const std::string& file : arguments.recordings) page.footer.push_back("recording: " + file);
  page.footer.push_back("nominal plant: " + arguments.plant);
  page.footer.push_back("seed " + std::to_string(arguments.seed) + ", " + std::to_string(arguments.starts) + " starts");
  page.footer.push_back("sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")");
  Calibrated result;
  result.files = {{"report.html", report::to_html(page)},
                  {"figure.svg", report::stacked_svg(paper_figure(comparisons.front(), recordings.front()), 720, 640)},
                  {"plant.yaml", yaml},
                  {"calibration.json", json.dump(2) + "\n"}};
  result.words = oddities;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (recordings.size() > 1) result.words += (r ? "\n" : "") + recordings[r].name + "\n";
    result.words += report::to_text(error_table(comparisons[r]));
    for (const std::string& line : findings(comparisons[r])) result.words += report::wrap(line) + "\n";
  }
  result.words += "\n" + report::to_text(parameters) + "\n" + report::wrap(signs_sentence(calibration) + untold_sentence(calibration)) +
                  "\n" + report::wrap(starts_sentence(calibration)) + "\n";
  return result;
}

namespace {

int calibrate_command(const CalibrateArguments& arguments) {
  Outputs outputs(arguments.out, {.files = arguments.recordings, .yaml = {arguments.plant}}, arguments.overwrite);
  outputs.claim(files_of_calibration());
  std::optional<EndsSoon> ends_soon(&outputs);
  const plant::Plant nominal = sim::read_plant_file(arguments.plant);
  const plant::System& system = nominal.system();
  static_cast<void>(noise_of_option(arguments.noise, system, diagnose::per_channel(system)));  // before any recording is read
  std::vector<sim::Recording> recordings;
  check_given_once({{"RECORDING", arguments.recordings}});
  for (const std::string& file : arguments.recordings) recordings.push_back(read_recording_of(file, nominal));
  Calibrated result;
  {
    Progress progress("calibrate");
    CalibrateRequest request = arguments;
    request.should_stop = interrupted;
    request.progress = [&](double share) { progress.show(share); };
    result = calibrated(request, nominal, std::move(recordings));
  }
  ends_soon.reset();
  for (const auto& [name, content] : result.files) outputs.stage(name, content);
  outputs.commit();

  if (arguments.json) {
    std::fputs(result.files.at("calibration.json").c_str(), stdout);
    return 0;
  }
  const std::filesystem::path out = arguments.out;
  std::printf("%splant:  %s\nreport: %s\n", result.words.c_str(), (out / "plant.yaml").string().c_str(),
              (out / "report.html").string().c_str());
  return 0;
}

}  // namespace

void add_calibrate(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<CalibrateArguments>();
  arguments->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  CLI::App* command = program.add_subcommand("calibrate", "Fit a plant to recordings.");
  command->add_option("recordings", arguments->recordings, "recordings in CSV")->required();
  command->add_option("--plant", arguments->plant, "the plant to begin from, in YAML")->required();
  command->add_option("--out", arguments->out, "folder for plant.yaml, calibration.json, report.html, figure.svg")->required();
  command->add_option("--fit-until", arguments->fit_until_s, "fit up to this time [s] of each recording; the rest is held out");
  command->add_option("--fit", arguments->fit, "parameters to fit, separated by commas; otherwise all that have a prior")->delimiter(',');
  add_ignore(*command, arguments->ignored);
  command
      ->add_option("--noise", arguments->noise,
                   "standard deviation of each channel, in the plant's order, or NAME=VALUE for some, separated by commas; "
                   "otherwise estimated from the recording")
      ->delimiter(',');
  command->add_option("--starts", arguments->starts, "number of seeded starts")->check(CLI::Range(1, 1000))->capture_default_str();
  command->add_option("--seed", arguments->seed, "of the starts")->check(CLI::NonNegativeNumber)->capture_default_str();
  command->add_option("--threads", arguments->threads, "the result does not depend on it")->check(CLI::Range(1, 1024));
  command->add_flag("--at-rest", arguments->at_rest, "the recording begins cold and at rest");
  command->add_flag("--json", arguments->json, "print calibration.json instead of tables");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n"
      "  sinew calibrate recording.csv --plant plant/limbs/paper_limb.yaml --fit-until 120 --out results/mine\n"
      "  sinew calibrate recording.csv --plant mine.yaml --fit heat_loss_A_W_K,heat_loss_B_W_K --out /tmp/fit");
  command->callback([arguments, &exit_code] { exit_code = calibrate_command(*arguments); });
}

}  // namespace sinew::apps
