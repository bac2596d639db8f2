// SPDX-License-Identifier: Apache-2.0
// sinew train: a predictor of a channel from recordings.
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
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct TrainArguments {
  std::vector<std::string> data;
  std::string method = "stateful", settings, out, from, layout = "keras2", plant, predict;
  int paper_case = 3;
  double until_s = std::numeric_limits<double>::infinity();
  std::int64_t seed = 1, updates = 0;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool hold_missing = false, overwrite = false;
};

int train_command(const TrainArguments& arguments) {
  InputPaths read{.files = arguments.data, .yaml = {arguments.settings}};
  read.files.push_back(arguments.from);
  if (!arguments.plant.empty()) read.yaml.push_back(arguments.plant);
  Outputs outputs(arguments.out, read, arguments.overwrite);
  outputs.claim({"weights.h5", "training.json", "report.html"});
  std::optional<EndsSoon> ends_soon(&outputs);
  const model::TrainingFile settings = training_settings(arguments.method, arguments.settings, arguments.updates);
  const auto system = system_for(arguments.plant, arguments.data);
  const model::Task task = model::task_of(*system, arguments.paper_case, channel_named(*system, arguments.predict));
  const std::string unit = unit_words(task.predicted);
  const auto data = series_of_paths(arguments.data, sim::columns_of(*system), task, arguments.until_s,
                                    arguments.hold_missing ? model::Missing::held : model::Missing::refused);
  std::optional<model::Model> from;
  if (!arguments.from.empty()) {
    from = model::read_model(weights_path(arguments.from), {.task = task, .method = {}, .lowest = {}, .highest = {}});
    if (from->method != arguments.method)
      throw sim::InputError(
          {.file = weights_path(arguments.from), .key = "method", .value = from->method, .advice = "cannot go on as " + arguments.method});
  }
  model::TrainingRun run;
  run.task = task;
  run.seed = static_cast<std::uint64_t>(arguments.seed);
  run.threads = arguments.threads;
  run.from = from ? &*from : nullptr;
  run.should_stop = interrupted;
  Progress progress("training");
  run.progress = [&](double done, const model::CurvePoint& point) {
    progress.show(done, report::fixed(point.training_error, 2) + unit + " training, " + report::fixed(point.validation_error, 2) + unit +
                            " set aside");
  };
  model::Trained trained = train_by(arguments.method, settings, data, run);
  if (model::LinearModel arx = arx_beside(arguments.method, settings, data); arx.coefficients.allFinite())
    trained.model.arx = std::move(arx);
  for (const std::string& path : arguments.data) trained.model.trained_on += (trained.model.trained_on.empty() ? "" : "; ") + path;

  const model::CurvePoint* best = &trained.curve.front();
  for (const auto& point : trained.curve)
    if (point.update == trained.best_update) best = &point;
  nlohmann::ordered_json json{{"case", arguments.paper_case},
                              {"method", arguments.method},
                              {"seed", arguments.seed},
                              {"data", arguments.data},
                              {"recordings", data.size()},
                              {"best_update", trained.best_update},
                              {key_in_unit("training", task.predicted), best->training_error},
                              {key_in_unit("validation", task.predicted), best->validation_error},
                              {"version", sim::this_build().version},
                              {"commit", sim::this_build().commit}};
  for (const auto& point : trained.curve) json["curve"].push_back({point.update, point.training_error, point.validation_error});
  const auto& shape = trained.model.weights.shape;
  report::Page page;
  page.title = "Training, case " + std::to_string(arguments.paper_case) + ", " + arguments.method;
  page.lead =
      "The weights kept are those after " + std::to_string(trained.best_update) + " updates: " + report::fixed(best->validation_error, 2) +
      unit +
      (arguments.method == "published" ? " one step ahead on what follows the training part." : " in open loop on what was set aside.");
  page.blocks = curve_blocks(trained.curve, arguments.method, task);
  page.footer = {"case " + std::to_string(arguments.paper_case) + ": " + words_of(task),
                 "LSTM " + std::to_string(shape.hidden) + ", dense " + std::to_string(shape.dense) + ", seed " +
                     std::to_string(arguments.seed),
                 "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
  const std::string html = report::to_html(page);
  ends_soon.reset();
  outputs.stage("weights.h5", model::to_hdf5(trained.model, arguments.layout == "keras3" ? model::Layout::keras3 : model::Layout::keras2));
  outputs.stage("report.html", html);
  outputs.stage("training.json", json.dump(1) + "\n");
  outputs.commit();
  std::printf("%s\nwritten: %s/{weights.h5, training.json, report.html}\n", report::wrap(page.lead).c_str(), arguments.out.c_str());
  return 0;
}

}  // namespace

void add_train(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* command =
      program.add_subcommand("train", "Train an LSTM predictor of a channel, such as the bend angle (Sabelhaus et al. 2022).");
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
  command->add_option("--method", arguments->method, "as published, or with memory")
      ->check(CLI::IsMember({"published", "stateful"}))
      ->capture_default_str();
  command->add_option("--settings", arguments->settings, "of the training, in YAML (scenarios/train.yaml has all of them)");
  command->add_option("--updates", arguments->updates, "at most so many, instead of the 3000 of the stateful method or those of --settings")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{10000000}));
  command->add_option("--from", arguments->from, "go on from these weights (fine-tuning)");
  command->add_option("--until", arguments->until_s, "leave out what comes later in each recording [s]")->check(positive_number());
  command->add_option("--seed", arguments->seed, "of weights and order")->check(CLI::NonNegativeNumber)->capture_default_str();
  command->add_option("--threads", arguments->threads, "changes no bit of the weights")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_option("--layout", arguments->layout, "of weights.h5")->check(CLI::IsMember({"keras2", "keras3"}))->capture_default_str();
  command->add_flag("--hold-missing", arguments->hold_missing, "take the value before where a sample is missing");
  command->add_option("--out", arguments->out, "folder for weights.h5, training.json, report.html")->required();
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n  sinew train results/set --case 4 --method stateful --out results/lstm4\n"
      "  sinew train results/set --case 3 --updates 300 --out results/first_try\n"
      "  sinew train recording.csv --until 130 --from results/lstm3 --out results/tuned");
  command->callback([arguments, &exit_code] { exit_code = train_command(*arguments); });
}

}  // namespace sinew::apps
