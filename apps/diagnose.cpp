// SPDX-License-Identifier: Apache-2.0
// sinew diagnose: where a plant and recordings differ, which physics is missing, the plant with it, and how much better
// that is.
#include "apps/diagnose.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "apps/app.h"
#include "apps/comparison_page.h"
#include "apps/diagnosis_json.h"
#include "apps/diagnosis_page.h"
#include "apps/diagnosis_text.h"
#include "apps/ends_soon.h"
#include "apps/ignore.h"
#include "apps/outputs.h"
#include "diagnose/calibrate.h"
#include "plant/contains.h"
#include "report/console.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct DiagnoseArguments : DiagnoseRequest {
  std::string out;
  bool json = false, overwrite = false;
};

// All files that a diagnosis may write, those that an earlier one of more recordings left here among them.
std::vector<std::string> files_of_diagnosis(const DiagnoseArguments& arguments) {
  std::vector<std::string> names{"report.html", "diagnosis.json", "plant.yaml", "run.json", "experiment.yaml", "heldout_prediction.csv"};
  const std::size_t recordings = arguments.training.size() + arguments.held_out.size();
  for (std::size_t k = 2;; ++k) {
    const std::string name = "heldout_prediction_" + std::to_string(k) + ".csv";
    if (k > recordings && !std::filesystem::exists(std::filesystem::path(arguments.out) / name)) return names;
    names.push_back(name);
  }
}

// A pause ends a recording: what follows begins with a state of its own. A part that is after --fit-until is held out.
void cut_at_pauses(std::vector<sim::Recording>& training, std::vector<sim::Recording>& held_out, double fit_until_s) {
  std::vector<sim::Recording> fitted, predicted;
  for (const sim::Recording& recording : training)
    for (sim::Recording& part : usable_parts(recording)) {
      const bool is_fitted = diagnose::samples_until(part, fit_until_s) >= least_samples;
      (is_fitted ? fitted : predicted).push_back(std::move(part));
    }
  for (const sim::Recording& recording : held_out)
    for (sim::Recording& part : usable_parts(recording)) predicted.push_back(std::move(part));
  training = std::move(fitted);
  held_out = std::move(predicted);
}

std::string wrapped(const std::string& text, std::size_t indent) {
  std::string lines = report::wrap(text, report::terminal_columns, indent);
  for (std::size_t at = 0; (at = lines.find(no_break, at)) != std::string::npos;) lines.replace(at, std::string(no_break).size(), " ");
  return lines + "\n";
}

std::string part(const std::string& heading, const std::vector<std::string>& paragraphs) {
  std::string text = "\n" + heading + "\n";
  for (const std::string& paragraph : paragraphs) text += wrapped(paragraph, 2);
  return text;
}

std::string text_of(const DiagnosisWords& words) {
  return wrapped(words.verdict, 0) + part("Where", words.where) + part("What", words.what) + part("Modelled", words.modelled) +
         part("Better", words.better) + part("What next", words.next);
}

}  // namespace

std::vector<plant::EffectId> chosen_effects(const std::vector<std::string>& names, const plant::System& system) {
  std::vector<std::string> all;
  for (const auto& effect : system.effects()) all.push_back(std::string(effect.name));
  std::vector<plant::EffectId> chosen;
  for (const std::string& name : names) {
    if (!contains(all, name)) {
      const std::string advice = "no such effect" + sim::did_you_mean(name, all);
      throw sim::InputError({.file = "", .key = "--without", .value = name, .advice = advice + "\n`sinew effects` lists all of them"});
    }
    if (const plant::EffectId e = system.effect(name); !contains(chosen, e)) chosen.push_back(e);
  }
  std::size_t names_there_are = 0, left = 0;
  for (const plant::EffectId e : system.effects().ids()) {
    if (system.effects()[e].law) continue;
    ++names_there_are;
    left += !diagnose::is_left_out(system, e, chosen);
  }
  if (!chosen.empty() && left == 0)
    throw sim::InputError({.file = "",
                           .key = "--without",
                           .value = "all " + std::to_string(names_there_are) + " effects",
                           .advice = "leaves no effect that could be named; leave out at least one"});
  return chosen;
}

Diagnosed diagnosed(const DiagnoseRequest& arguments, const plant::Plant& nominal, std::vector<sim::Recording> training,
                    std::vector<sim::Recording> held_out) {
  DiagnosisInputs inputs;
  inputs.training = arguments.training;
  inputs.held_out = arguments.held_out;
  inputs.plant = arguments.plant;
  inputs.seed = arguments.seed;
  inputs.ignored = arguments.ignored;
  diagnose::DiagnosisSettings& settings = inputs.settings;
  settings.search.without = chosen_effects(arguments.without, nominal.system());
  settings.search.seed = static_cast<std::uint64_t>(arguments.seed);
  settings.search.threads = arguments.threads;
  settings.search.fit.should_stop = arguments.should_stop;
  settings.start = arguments.at_rest ? diagnose::StartPolicy::at_rest : diagnose::StartPolicy::estimated;
  if (std::isfinite(arguments.fit_until_s)) settings.fit_until_s = arguments.fit_until_s;
  for (const sim::Recording& recording : training) check_long_enough(recording, arguments.fit_until_s);
  std::vector<sim::Recording*> all;
  for (auto* recordings : {&training, &held_out})
    for (sim::Recording& recording : *recordings) all.push_back(&recording);
  ignore(arguments.ignored, nominal.system(), all);
  if (!arguments.noise.empty())
    settings.noise = noise_of_option(arguments.noise, nominal.system(), diagnose::noise_of(nominal.system(), training.front()));
  check_keeps_back(training, arguments.fit_until_s);
  std::size_t samples = 0;
  for (const sim::Recording& recording : training) samples += diagnose::samples_until(recording, arguments.fit_until_s);
  check_fitted_samples(samples, arguments.training.front());
  // A pause ends a recording: what follows begins with a state of its own. A part that is all after --fit-until is held out.
  for (auto* recordings : {&training, &held_out})
    for (const sim::Recording& recording : *recordings) {
      std::vector<std::string> lines =
          oddities_of(nominal, recording, diagnose::noise_of(nominal.system(), recording), recordings->size() == 1);
      if (!lines.empty()) inputs.oddities.push_back({recording.name, lines});
    }
  const std::size_t given = training.size() + held_out.size();
  if (std::ranges::none_of(held_out, [](const sim::Recording& one) { return one.time_zero_s.has_value(); })) count_from_first(training);
  cut_at_pauses(training, held_out, arguments.fit_until_s);
  if (training.size() + held_out.size() > given)
    settings.start = diagnose::StartPolicy::estimated;  // at rest at most the first part begins
  std::mutex one_at_a_time;
  settings.search.progress = [&](double share, const std::string& doing) {
    const std::lock_guard lock(one_at_a_time);
    if (arguments.progress) arguments.progress(share, doing);
  };
  const diagnose::Diagnosis diagnosis = diagnose::diagnose(nominal, training, held_out, settings);

  const nlohmann::ordered_json json = diagnosis_json(diagnosis, inputs, arguments.hashes);
  std::map<std::string, std::string> files{{"diagnosis.json", json.dump(2) + "\n"},
                                           {"plant.yaml", repaired_plant_yaml(diagnosis, inputs)},
                                           {"report.html", report::to_html(diagnosis_page(diagnosis, inputs))}};
  files.merge(prediction_files(diagnosis));
  const auto* found = std::get_if<diagnose::Found>(&diagnosis.answer);
  if (found && found->experiment && found->experiment->separation > 0.0) files["experiment.yaml"] = found->experiment->scenario_yaml;
  files["run.json"] = diagnosis_run_json(diagnosis, inputs, arguments.hashes, files);
  std::string oddities;
  for (const Oddities& of : inputs.oddities) {
    oddities += of.recording + "\n";
    for (const std::string& line : of.lines) oddities += report::wrap(line, report::terminal_columns, 2) + "\n";
    oddities += "\n";
  }
  return {std::move(files), std::move(oddities), text_of(diagnosis_words(diagnosis, inputs))};
}

namespace {

int diagnose_command(const DiagnoseArguments& arguments) {
  const std::filesystem::path out = arguments.out;
  check_given_once({{"--train", arguments.training}, {"--heldout", arguments.held_out}});
  InputPaths read{.files = arguments.training, .yaml = {arguments.plant}};
  read.files.insert(read.files.end(), arguments.held_out.begin(), arguments.held_out.end());
  Outputs outputs(out, read, arguments.overwrite);
  const std::vector<std::string> names = files_of_diagnosis(arguments);
  outputs.claim(names);
  std::optional<EndsSoon> ends_soon(&outputs);

  const plant::Plant nominal = sim::read_plant_file(arguments.plant);
  // Before any recording is read: what is wrong with the options does not wait for them.
  static_cast<void>(noise_of_option(arguments.noise, nominal.system(), diagnose::per_channel(nominal.system())));
  static_cast<void>(chosen_effects(arguments.without, nominal.system()));
  std::vector<sim::Recording> training, held_out;
  for (const std::string& path : arguments.training) {
    training.push_back(read_recording_of(path, nominal));
    check_long_enough(training.back(), arguments.fit_until_s);
  }
  for (const std::string& path : arguments.held_out) held_out.push_back(read_recording_of(path, nominal));
  DiagnoseRequest request = arguments;
  request.hashes = {{arguments.plant, sim::sha256(sim::read_file(arguments.plant))}};
  for (const auto* paths : {&arguments.training, &arguments.held_out})
    for (const std::string& path : *paths) request.hashes[path] = sim::sha256(sim::read_file(path));
  request.should_stop = interrupted;
  Diagnosed result;
  {
    Progress progress("diagnose");
    request.progress = [&](double share, const std::string& doing) { progress.show(share, doing); };
    result = diagnosed(request, nominal, std::move(training), std::move(held_out));
  }
  ends_soon.reset();
  if (interrupted()) throw diagnose::Stopped{};
  for (const auto& [name, content] : result.files) {
    // Parts between pauses are predicted one by one: further files, none of which was there.
    if (!contains(names, name)) outputs.claim({name});
    outputs.stage(name, content);
  }
  outputs.commit();

  if (arguments.json) {
    std::fputs(result.files.at("diagnosis.json").c_str(), stdout);
    return 0;
  }
  std::printf("%s%s\nplant:  %s\nreport: %s\n", result.oddities.c_str(), result.words.c_str(), (out / "plant.yaml").string().c_str(),
              (out / "report.html").string().c_str());
  return 0;
}

}  // namespace

void add_diagnose(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<DiagnoseArguments>();
  arguments->threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  CLI::App* command = program.add_subcommand("diagnose", "Find the physics that a plant leaves out, from recordings of the limb.");
  command->add_option("--train", arguments->training, "recordings in CSV to learn from, one or several of the same limb")
      ->required()
      ->expected(1, 1000);
  command
      ->add_option("--heldout", arguments->held_out,
                   "recordings in CSV that are only predicted; without any, parts of the training recordings are held out")
      ->expected(1, 1000);
  command->add_option("--plant", arguments->plant, "the plant to begin from, in YAML")->required();
  command
      ->add_option(
          "--out", arguments->out,
          "folder for report.html, diagnosis.json, plant.yaml, heldout_prediction.csv, run.json, experiment.yaml where one would tell")
      ->required();
  command->add_option("--fit-until", arguments->fit_until_s, "learn up to this time [s] of each training recording; the rest is held out");
  command
      ->add_option("--noise", arguments->noise,
                   "standard deviation of each channel, in the plant's order, or NAME=VALUE for some, separated by commas; "
                   "otherwise estimated from the recordings")
      ->delimiter(',');
  add_ignore(*command, arguments->ignored);
  command->add_option("--without", arguments->without, "effects that may not be named")->delimiter(',')->expected(1, 1000);
  command->add_option("--seed", arguments->seed, "of the draws that intervals and chances come from")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "the result does not depend on it")->check(CLI::Range(1, 1024));
  command->add_flag("--at-rest", arguments->at_rest, "the recordings begin cold and at rest");
  command->add_flag("--json", arguments->json, "print diagnosis.json instead of sentences");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n"
      "  sinew diagnose --train scenarios/demo/recording.csv --plant plant/limbs/paper_limb.yaml --out "
      "results/diagnosis\n"
      "  sinew diagnose --train a.csv b.csv --heldout c.csv --plant mine.yaml --out results/mine --seed 7\n"
      "  sinew diagnose --train a.csv --fit-until 130 --plant mine.yaml --out results/mine --without input_delay "
      "fatigue");
  command->callback([arguments, &exit_code] { exit_code = diagnose_command(*arguments); });
}

}  // namespace sinew::apps
