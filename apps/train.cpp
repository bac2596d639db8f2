// SPDX-License-Identifier: Apache-2.0
// sinew train: a predictor of a channel from recordings.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <thread>

#include "apps/app.h"
#include "apps/ends_soon.h"
#include "apps/outputs.h"
#include "apps/training.h"
#include "model/weights_file.h"
#include "report/console.h"
#include "report/number.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct TrainArguments {
  std::vector<std::string> data, intervals;
  std::string predictor = "stateful", method, settings, out, from, layout = "keras2", plant, predict;
  int paper_case = 3;
  double until_s = std::numeric_limits<double>::infinity();
  std::int64_t seed = 1, updates = 0, most_runs = usual_most_runs;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool hold_missing = false, resample = false, overwrite = false;
};

// Over what follows the training part of each recording, all parts together.
struct AfterTraining {
  double rollout = std::nan(""), one_step = std::nan("");
};
AfterTraining errors_after_training(model::Predictor& predictor, const std::vector<model::Series>& data, double training_fraction) {
  model::SquaredError open, step;
  for (const model::Series& one : data) {
    const model::Index first = model::training_samples(one, training_fraction);
    if (one.samples() - first < 2) continue;
    const model::Series rest = model::part_of(one, first, one.samples() - first), before = model::part_of(one, 0, first + 1);
    const model::SquaredError off = model::squared_error(model::rollout(predictor, rest, &before), rest, 1, rest.samples() - 1),
                              off_step = model::squared_error(model::one_step_ahead(predictor, rest, &before), rest, 1, rest.samples() - 1);
    open = {open.sum + off.sum, open.count + off.count};
    step = {step.sum + off_step.sum, step.count + off_step.count};
  }
  return {open.root_mean(), step.root_mean()};
}

// What intervals are taken from: what was named for it, else what follows the training part of each recording.
std::vector<model::SetAside> set_aside(const std::vector<model::Series>& data, double training_fraction,
                                       const std::vector<model::Series>& named) {
  std::vector<model::SetAside> aside;
  for (const model::Series& one : named) aside.push_back({one, 0});
  if (!named.empty() || training_fraction >= 1.0) return aside;
  for (const model::Series& one : data) aside.push_back({one, model::training_samples(one, training_fraction)});
  return aside;
}

// "±1.2° in open loop after a minute, ±0.1° one step ahead"
std::string interval_words(const model::Intervals& intervals, const std::string& unit) {
  constexpr model::Index after = 601;
  std::string words;
  for (const model::Beginning beginning : {model::Beginning::at_first, model::Beginning::after_history, model::Beginning::in_motion}) {
    const auto& steps = intervals.by_beginning[static_cast<std::size_t>(beginning)];
    if (!steps) continue;
    const auto width = [&](bool one_step) { return report::significant(model::half_widths(*steps, one_step, after)(after - 1), 3) + unit; };
    const double share = model::promised_share(*steps);
    const model::Index fewest = *std::min_element(steps->units.begin(), steps->units.end());
    const std::string units = std::to_string(fewest) + (intervals.unit_is_recording ? " recording" : " minute") + (fewest == 1 ? "" : "s") +
                              " of what was set aside";
    return report::significant(100.0 * share, 2) + " % of samples are expected within " + width(false) +
           " in open loop after a minute, and within " + width(true) + " one step ahead, by " + units +
           (share < model::interval_share ? "; for " + report::significant(100.0 * model::interval_share, 2) + " % it takes 19." : ".");
  }
  return "No intervals: too little is left that was not trained on. `--intervals DATA` names more.";
}

int train_command(const TrainArguments& arguments) {
  if (!arguments.method.empty() && arguments.method != arguments.predictor && arguments.predictor != TrainArguments{}.predictor)
    throw sim::InputError(
        {.file = "", .key = "--method", .value = arguments.method, .advice = "is the former name of --predictor; give one of them"});
  const std::string name = arguments.method.empty() ? arguments.predictor : arguments.method;
  const model::PredictorKind& kind = model::predictor_kind(name);
  InputPaths read{.files = arguments.data, .yaml = {arguments.settings}};
  read.files.insert(read.files.end(), arguments.intervals.begin(), arguments.intervals.end());
  read.files.push_back(arguments.from);
  if (!arguments.plant.empty()) read.yaml.push_back(arguments.plant);
  Outputs outputs(arguments.out, read, arguments.overwrite);
  outputs.claim({"weights.h5", "training.json", "report.html"});
  std::optional<EndsSoon> ends_soon(&outputs);
  const model::TrainingFile settings = training_settings(name, arguments.settings);
  model::TrainingRun run;
  if (arguments.updates > 0) run.updates = arguments.updates;
  model::check_updates(kind, run.updates);
  if (!arguments.from.empty() && !kind.goes_on)
    throw sim::InputError({.file = "", .key = "--from", .value = arguments.from, .advice = name + " goes on from nothing; leave it out"});
  const auto system = system_for(arguments.plant, arguments.data);
  const model::Task task = model::task_of(*system, arguments.paper_case, channel_named(*system, arguments.predict));
  const std::string unit = unit_words(task.predicted);
  const auto data = series_of_paths(arguments.data, sim::columns_of(*system), task, arguments.until_s,
                                    missing_by(arguments.hold_missing, arguments.resample), arguments.plant, arguments.most_runs);
  const auto for_intervals = series_of_paths(arguments.intervals, sim::columns_of(*system), task, arguments.until_s,
                                             missing_by(arguments.hold_missing, arguments.resample), arguments.plant, arguments.most_runs);
  for (const model::Series& one : for_intervals)
    for (const model::Series& other : data)
      if (one.v.cols() == other.v.cols() && one.v == other.v && one.y == other.y)
        throw sim::InputError({.file = one.name,
                               .key = "--intervals",
                               .advice = "was trained on, as " + other.name + ": its errors are too small to tell of other recordings"});
  std::unique_ptr<model::Predictor> from;
  if (!arguments.from.empty()) from = read_predictor_at(arguments.from, {.task = task, .method = {}, .lowest = {}, .highest = {}});
  std::optional<plant::Plant> plant;
  if (!arguments.plant.empty()) plant = sim::read_plant_file(arguments.plant);
  run.task = task;
  run.seed = static_cast<std::uint64_t>(arguments.seed);
  run.threads = arguments.threads;
  run.should_stop = interrupted;
  Progress progress("training");
  run.progress = [&](double done, const model::CurvePoint& point) {
    progress.show(done, report::fixed(point.training_error, 2) + unit + " training, " + report::fixed(point.validation_error, 2) + unit +
                            " set aside");
  };
  const model::TrainedPredictor trained = kind.train({data, settings, run, from.get(), plant ? &*plant : nullptr});
  model::AboutPredictor& about = trained.predictor->about();
  if (model::LinearModel arx = arx_beside(trained.training_fraction, data); arx.coefficients.allFinite()) about.arx = std::move(arx);
  about.trained_on.clear();
  for (const std::string& path : arguments.data) about.trained_on += (about.trained_on.empty() ? "" : "; ") + path;
  about.region = model::trained_region_of(model::training_parts(data, trained.training_fraction));
  about.intervals =
      model::intervals_from(*trained.predictor, set_aside(data, trained.training_fraction, for_intervals), arguments.threads, interrupted);
  for (const std::string& path : arguments.intervals)
    about.intervals->taken_from += (about.intervals->taken_from.empty() ? "" : "; ") + path;
  if (arguments.intervals.empty())
    about.intervals->taken_from = "what follows the training part of each recording";
  else if (!about.intervals->any())
    throw sim::InputError({.file = "",
                           .key = "--intervals",
                           .value = about.intervals->taken_from,
                           .advice = "gives none: recordings of " + report::significant(model::shortest_for_intervals_s, 2) +
                                     " s or more are needed, over which the prediction stays within bounds"});
  const AfterTraining after = errors_after_training(*trained.predictor, data, trained.training_fraction);

  nlohmann::ordered_json json{
      {"case", arguments.paper_case}, {"method", name}, {"seed", arguments.seed}, {"data", arguments.data}, {"recordings", data.size()}};
  report::Page page;
  page.title = "Training, case " + std::to_string(arguments.paper_case) + ", " + name;
  if (!trained.curve.empty()) {
    const model::CurvePoint* best = &trained.curve.front();
    for (const auto& point : trained.curve)
      if (point.update == trained.best_update) best = &point;
    json["best_update"] = trained.best_update;
    json[key_in_unit("training", task.predicted)] = best->training_error;
    json[key_in_unit("validation", task.predicted)] = best->validation_error;
    page.lead = "The weights kept are those after " + std::to_string(trained.best_update) +
                " updates: " + report::fixed(best->validation_error, 2) + unit + " " + trained.validated_by + ".";
    page.blocks = curve_blocks(trained.curve, trained.validated_by, task);
  }
  if (std::isfinite(after.one_step)) {
    json[key_in_unit("rollout_after_training", task.predicted)] = after.rollout;
    json[key_in_unit("one_step_after_training", task.predicted)] = after.one_step;
    page.lead += (page.lead.empty() ? "" : " ") + std::string("On what follows the training part of each recording: ") +
                 report::significant(after.rollout, 3) + unit + " in open loop, " + report::significant(after.one_step, 3) + unit +
                 " one step ahead.";
  }
  if (page.lead.empty()) page.lead = "Made from the whole of each recording: nothing is left to judge it by.";
  page.lead += " " + interval_words(*about.intervals, unit);
  json["intervals"] = model::json_of(*about.intervals);
  json["version"] = sim::this_build().version;
  json["commit"] = sim::this_build().commit;
  for (const auto& point : trained.curve) json["curve"].push_back({point.update, point.training_error, point.validation_error});
  page.footer = {"case " + std::to_string(arguments.paper_case) + ": " + words_of(task),
                 std::string(kind.words) + ", seed " + std::to_string(arguments.seed),
                 "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
  const std::string html = report::to_html(page);
  ends_soon.reset();
  outputs.stage("weights.h5",
                model::bytes_of(*trained.predictor, arguments.layout == "keras3" ? model::Layout::keras3 : model::Layout::keras2));
  outputs.stage("report.html", html);
  outputs.stage("training.json", json.dump(1) + "\n");
  outputs.commit();
  std::printf("%s\nwritten: %s/{weights.h5, training.json, report.html}\n", report::wrap(page.lead).c_str(), arguments.out.c_str());
  return 0;
}

}  // namespace

void add_train(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* command = program.add_subcommand("train", "Train a predictor of a channel, such as the bend angle (Sabelhaus et al. 2022).");
  command->add_option("data", arguments->data, "sets by `sinew dataset`, or recordings in CSV")->required();
  command
      ->add_option(
          "--case", arguments->paper_case,
          "inputs: 1 the first one; 2 and what is measured there; 3 all; 4 and what is measured there (duties and temperatures of a limb)")
      ->check(CLI::Range(1, 4))
      ->capture_default_str();
  command->add_option("--plant", arguments->plant,
                      "a plant file of the kind that the recordings are of; left out: of the set, or the paper's limb");
  command->add_option("--predict", arguments->predict, "the channel, by its column; left out: the first that inputs drive");
  std::string kinds;
  for (const model::PredictorKind& kind : model::predictor_kinds())
    kinds += (kinds.empty() ? "" : "; ") + std::string(kind.name) + ": " + std::string(kind.words);
  command->add_option("--predictor", arguments->predictor, kinds)->check(CLI::IsMember(model::predictor_names()))->capture_default_str();
  command->add_option("--method", arguments->method, "the former name of --predictor")->check(CLI::IsMember(model::predictor_names()));
  command->add_option("--settings", arguments->settings, "of the training, in YAML (scenarios/train.yaml has all of them)");
  command->add_option("--updates", arguments->updates, "at most so many, instead of the 3000 of stateful or those of --settings")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{10000000}));
  command->add_option("--from", arguments->from, "go on from these weights (fine-tuning); for corrected: the predictor inside");
  command->add_option("--intervals", arguments->intervals,
                      "sets or recordings that were not trained on, to take the prediction intervals from; left out: what follows the "
                      "training part of each recording");
  command
      ->add_option("--most-runs", arguments->most_runs,
                   "of each set at most so many, spread evenly over it: all that is read is held in memory")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000}))
      ->capture_default_str();
  command->add_option("--until", arguments->until_s, "leave out what comes later in each recording [s]")->check(positive_number());
  command->add_option("--seed", arguments->seed, "of weights and order")->check(CLI::NonNegativeNumber)->capture_default_str();
  command->add_option("--threads", arguments->threads, "changes no bit of the weights")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_option("--layout", arguments->layout, "of weights.h5")->check(CLI::IsMember({"keras2", "keras3"}))->capture_default_str();
  command->add_flag("--hold-missing", arguments->hold_missing, "take the value before where a sample is missing");
  add_resample(*command, arguments->resample);
  command->add_option("--out", arguments->out, "folder for weights.h5, training.json, report.html")->required();
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n  sinew train results/set --case 4 --predictor stateful --out results/lstm4\n"
      "  sinew train results/set --case 3 --updates 300 --out results/first_try\n"
      "  sinew train results/set --case 4 --intervals results/another_set --out results/lstm4\n"
      "  sinew train recording.csv --until 130 --from results/lstm3 --out results/tuned");
  command->callback([arguments, &exit_code] { exit_code = train_command(*arguments); });
}

}  // namespace sinew::apps
