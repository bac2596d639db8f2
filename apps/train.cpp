// SPDX-License-Identifier: Apache-2.0
// sinew train: a predictor of the bend angle from recordings.
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <thread>

#include "apps/app.h"
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
  std::string method = "stateful", settings, out, from, layout = "keras2";
  int paper_case = 3;
  double until_s = std::numeric_limits<double>::infinity();
  std::int64_t seed = 1;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool hold_missing = false, overwrite = false;
};

int train_command(const TrainArguments& arguments) {
  InputPaths read{.files = arguments.data, .yaml = {arguments.settings}};
  read.files.push_back(arguments.from);
  Outputs outputs(arguments.out, read, arguments.overwrite);
  outputs.claim({"weights.h5", "training.json", "report.html"});
  const auto data = series_of_paths(arguments.data, arguments.paper_case, arguments.until_s,
                                    arguments.hold_missing ? model::Missing::held : model::Missing::refused);
  std::optional<model::Model> from;
  if (!arguments.from.empty()) {
    from = model::read_model(weights_path(arguments.from), {.paper_case = arguments.paper_case, .method = {}, .lowest_deg = {}, .highest_deg = {}});
    if (from->method != arguments.method)
      throw sim::InputError({.file = weights_path(arguments.from), .key = "method", .value = from->method, .advice = "cannot go on as " + arguments.method});
  }
  model::TrainingRun run;
  run.paper_case = arguments.paper_case;
  run.seed = static_cast<std::uint64_t>(arguments.seed);
  run.threads = arguments.threads;
  run.from = from ? &*from : nullptr;
  run.should_stop = interrupted;
  Progress progress("training");
  run.progress = [&](double done, const model::CurvePoint& point) {
    progress.show(done, report::fixed(point.training_deg, 2) + "° training, " + report::fixed(point.validation_deg, 2) + "° set aside");
  };
  model::Trained trained = train_by(arguments.method, arguments.settings, data, run);
  for (const std::string& path : arguments.data) trained.model.trained_on += (trained.model.trained_on.empty() ? "" : "; ") + path;

  const model::CurvePoint* best = &trained.curve.front();
  for (const auto& point : trained.curve)
    if (point.update == trained.best_update) best = &point;
  nlohmann::ordered_json json{{"case", arguments.paper_case}, {"method", arguments.method}, {"seed", arguments.seed},
                              {"data", arguments.data}, {"recordings", data.size()}, {"best_update", trained.best_update},
                              {"training_deg", best->training_deg}, {"validation_deg", best->validation_deg},
                              {"version", sim::this_build().version}, {"commit", sim::this_build().commit}};
  for (const auto& point : trained.curve) json["curve"].push_back({point.update, point.training_deg, point.validation_deg});
  const auto& shape = trained.model.weights.shape;
  report::Page page;
  page.title = "Training, case " + std::to_string(arguments.paper_case) + ", " + arguments.method;
  page.lead = "The weights kept are those after " + std::to_string(trained.best_update) + " updates: " + report::fixed(best->validation_deg, 2) +
              (arguments.method == "published" ? "° one step ahead on what follows the training part."
                                               : "° in open loop on what was set aside.");
  page.blocks = curve_blocks(trained.curve, arguments.method);
  page.footer = {"case " + std::to_string(arguments.paper_case) + ": " + case_words(arguments.paper_case),
                 "LSTM " + std::to_string(shape.hidden) + ", dense " + std::to_string(shape.dense) + ", seed " + std::to_string(arguments.seed),
                 "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
  const std::string html = report::to_html(page);
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
  CLI::App* command = program.add_subcommand("train", "Train an LSTM predictor of the bend angle (Sabelhaus et al. 2022).");
  command->add_option("data", arguments->data, "sets by `sinew dataset`, or recordings in CSV")->required();
  command->add_option("--case", arguments->paper_case, "inputs: 1 duty A; 2 and temperature A; 3 both duties; 4 and both temperatures")
      ->check(CLI::Range(1, 4))->capture_default_str();
  command->add_option("--method", arguments->method, "as published, or with memory")->check(CLI::IsMember({"published", "stateful"}))->capture_default_str();
  command->add_option("--settings", arguments->settings, "of the training, in YAML (scenarios/train.yaml has all of them)");
  command->add_option("--from", arguments->from, "go on from these weights (fine-tuning)");
  command->add_option("--until", arguments->until_s, "leave out what comes later in each recording [s]")->check(positive_number());
  command->add_option("--seed", arguments->seed, "of weights and order")->check(CLI::NonNegativeNumber)->capture_default_str();
  command->add_option("--threads", arguments->threads, "changes no bit of the weights")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_option("--layout", arguments->layout, "of weights.h5")->check(CLI::IsMember({"keras2", "keras3"}))->capture_default_str();
  command->add_flag("--hold-missing", arguments->hold_missing, "take the value before where a sample is missing");
  command->add_option("--out", arguments->out, "folder for weights.h5, training.json, report.html")->required();
  add_overwrite(*command, arguments->overwrite);
  command->footer("Examples:\n  sinew train results/set --case 4 --method stateful --out results/lstm4\n"
                  "  sinew train recording.csv --until 130 --from results/lstm3 --out results/tuned");
  command->callback([arguments, &exit_code] { exit_code = train_command(*arguments); });
}

}  // namespace sinew::apps
