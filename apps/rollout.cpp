// SPDX-License-Identifier: Apache-2.0
// sinew rollout: a predictor over a recording, from one measured value.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "apps/app.h"
#include "apps/ends_soon.h"
#include "apps/outputs.h"
#include "apps/training.h"
#include "model/predictor.h"
#include "model/weights_file.h"
#include "report/console.h"
#include "report/number.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct RolloutArguments {
  std::string model, recording, out, method, plant, predict;
  double horizon_s = 600.0, from_s = 0.0, history_s = 0.0;
  int paper_case = 0;
  std::vector<double> range, windows;
  bool report = false, json = false, hold_missing = false, resample = false, overwrite = false;
};

int rollout_command(const RolloutArguments& arguments) {
  std::optional<Outputs> outputs;
  const InputPaths read{.files = {arguments.model, arguments.recording}};
  if (arguments.out.empty() && !arguments.report) {
    finish_interrupted(read);
  } else {
    const std::filesystem::path out = arguments.out.empty() ? std::filesystem::path(arguments.recording).replace_extension("rollout")
                                                            : std::filesystem::path(arguments.out);
    outputs.emplace(out, read, arguments.overwrite);
    outputs->claim({"rollout.csv", "report.html"});
  }
  std::optional<EndsSoon> ends_soon(outputs ? &*outputs : nullptr);
  model::Unsaid unsaid{{}, arguments.method, {}, {}};
  if (!arguments.predict.empty() && !arguments.paper_case)
    throw sim::InputError({.file = "",
                           .key = "--predict",
                           .value = arguments.predict,
                           .advice = "goes with --case; without it, the weights say which channel they predict"});
  if (arguments.paper_case) {
    const auto system = system_for(arguments.plant);
    unsaid.task = model::task_of(*system, arguments.paper_case, channel_named(*system, arguments.predict));
  }
  if (arguments.range.size() == 2) {
    if (!(arguments.range[0] < arguments.range[1]))
      throw sim::InputError({.file = "",
                             .key = "--range",
                             .value = sim::shortest(arguments.range[0]) + "," + sim::shortest(arguments.range[1]),
                             .advice = "must be the lower value, then the higher one"});
    unsaid.lowest = arguments.range[0];
    unsaid.highest = arguments.range[1];
  }
  const auto predictor = read_predictor_at(arguments.model, unsaid, system_for(arguments.plant));
  const model::AboutPredictor& about = predictor->about();
  if (std::filesystem::is_directory(arguments.recording))
    throw sim::InputError(
        {.file = arguments.recording, .key = "--recording", .advice = "is a folder; name one recording, of a set one of its runs/"});
  const sim::Columns columns = arguments.plant.empty() ? columns_for(about.task) : sim::columns_of(*system_for(arguments.plant));
  const sim::Column& predicted = about.task.predicted;
  const std::string unit = unit_words(predicted);
  const model::Series whole = series_of_paths({arguments.recording}, columns, about.task, HUGE_VAL,
                                              missing_by(arguments.hold_missing, arguments.resample), arguments.plant)
                                  .front();
  // Samples from the first one to a time, never more than there are.
  const auto samples_in = [&](double duration_s) {
    return static_cast<model::Index>(std::lround(std::clamp(duration_s / model::period_s, 0.0, static_cast<double>(whole.samples()))));
  };
  model::Index first = samples_in(arguments.from_s - whole.first_s);
  while (first < whole.samples() && !whole.is_measured(first)) ++first;  // it begins where something was measured
  if (!std::isfinite(arguments.from_s) || first + 2 > whole.samples())
    throw sim::InputError(
        {.file = arguments.recording, .key = "--from", .value = sim::shortest(arguments.from_s), .advice = "the recording ends before"});
  const model::Index count = std::min(whole.samples() - first, samples_in(arguments.horizon_s) + 1);
  if (!std::isfinite(arguments.horizon_s) || count < 2)
    throw sim::InputError({.file = "",
                           .key = "--horizon",
                           .value = sim::shortest(arguments.horizon_s),
                           .advice = "must be a time of at least one step, 0.1 s"});
  const model::Series series = model::part_of(whole, first, count);
  const auto past = std::min(first, samples_in(arguments.history_s));
  const std::string begins = past == 0 ? "from one measured value"
                                       : "after " + report::significant(static_cast<double>(past) * model::period_s, 3) + " s of history";
  const std::string asked = past < samples_in(arguments.history_s)
                                ? " Of the " + sim::shortest(arguments.history_s) + " s of history that were asked for, " +
                                      (past == 0 ? "none" : report::significant(static_cast<double>(past) * model::period_s, 3) + " s") +
                                      " are there."
                                : "";
  const model::Series history = model::part_of(whole, first - past, past + 1);
  const model::Vector<double> open = model::rollout(*predictor, series, &history),
                              step = model::one_step_ahead(*predictor, series, &history);
  if (!open.allFinite() || !step.allFinite())
    throw std::runtime_error(weights_path(arguments.model) + ": the prediction goes beyond all bounds");
  const model::Errors off = model::errors_of(open, series), off_step = model::errors_of(step, series);

  const Trust trust = trust_in(about, series, whole, first, past, open, step);
  const std::string of_trust = interval_sentence(trust, about) + " " + departure_sentence(trust, about, series.first_s) + asked;

  const Baselines baselines = baselines_of(*predictor, series);
  nlohmann::ordered_json json{{"case", about.task.paper_case},
                              {"method", about.kind},
                              {"from_s", series.first_s},
                              {"samples", series.samples()},
                              {key_in_unit("rollout_rmse", predicted), off.rmse},
                              {key_in_unit("one_step_rmse", predicted), off_step.rmse},
                              {key_in_unit("largest", predicted), off.largest},
                              {key_in_unit("hold_rmse", predicted), baselines.hold}};
  if (baselines.arx) json[key_in_unit("arx_rmse", predicted)] = *baselines.arx;
  report::Table table;
  table.header = {"prediction", "RMSE / " + unit, "largest / " + unit};
  table.rows = {{{"open loop, " + begins, report::significant(off.rmse, 4), report::significant(off.largest, 3)}},
                {{"one step ahead", report::significant(off_step.rmse, 4), report::significant(off_step.largest, 3)}}};
  table.rows.push_back({{"baseline: the first value held", report::significant(baselines.hold, 4), ""}});
  if (baselines.arx)
    table.rows.push_back({{"baseline: ARX, fitted to the same data, open loop",
                           std::isnan(*baselines.arx) ? "diverges" : report::significant(*baselines.arx, 4), ""}});
  if (std::isfinite(off.last_minute)) {
    json[key_in_unit("second_minute", predicted)] = off.second_minute;
    json[key_in_unit("last_minute", predicted)] = off.last_minute;
    table.rows.push_back({{"open loop, second minute", report::significant(off.second_minute, 4), ""}});
    table.rows.push_back({{"open loop, last minute", report::significant(off.last_minute, 4), ""}});
  }
  if (arguments.windows.size() == 2) {
    const auto a = samples_in(arguments.windows[0] - series.first_s);
    const auto b = std::min(series.samples(), samples_in(arguments.windows[1] - series.first_s) + 1);
    if (a < 1 || b <= a)
      throw sim::InputError({.file = arguments.recording,
                             .key = "--count",
                             .value = sim::shortest(arguments.windows[0]) + "," + sim::shortest(arguments.windows[1]),
                             .advice = "must lie inside the rollout"});
    json[key_in_unit("counted_rmse", predicted)] = model::root_mean_square_error(open, series, a, b - a);
    table.rows.push_back({{"open loop, " + sim::shortest(arguments.windows[0]) + " to " + sim::shortest(arguments.windows[1]) + " s",
                           report::significant(model::root_mean_square_error(open, series, a, b - a), 4), ""}});
  }
  put_trust(json, trust, about, series.first_s);
  table.title = "Case " + std::to_string(about.task.paper_case) + ", " + about.kind + ": " + words_of(about.task);
  ends_soon.reset();
  if (outputs) {
    const std::string stem = predicted.unit.empty() ? predicted.name : predicted.name.substr(0, predicted.name.rfind("_" + predicted.unit));
    std::string csv = "# open-loop prediction " + begins + ", by `sinew rollout`\ntime_s," + predicted.name + "," +
                      key_in_unit(stem + "_rollout", predicted) + "," + key_in_unit(stem + "_one_step", predicted);
    if (trust.interval)
      for (const char* const of : {"_rollout_lowest", "_rollout_highest", "_one_step_lowest", "_one_step_highest"})
        csv += "," + key_in_unit(stem + of, predicted);
    csv += trust.departures ? ",outside\n" : "\n";
    for (model::Index k = 0; k < series.samples(); ++k) {
      std::vector<double> row{series.first_s + static_cast<double>(k) * model::period_s, series.measured(k), open(k), step(k)};
      if (trust.interval) {
        const double wide = trust.interval->open_loop(k), wide_step = trust.interval->one_step(k);
        row.insert(row.end(), {open(k) - wide, open(k) + wide, step(k) - wide_step, step(k) + wide_step});
      }
      if (trust.departures) row.push_back(trust.departures->is_outside[static_cast<std::size_t>(k)] ? 1.0 : 0.0);
      for (const double value : row) {
        if (csv.back() != '\n') csv += ',';
        if (!std::isnan(value)) sim::append_shortest(csv, value);  // a cell is left empty where nothing was measured
      }
      csv += '\n';
    }
    report::Page page;
    page.title = "Rollout of a predictor";
    page.lead = std::string(past == 0 ? "From" : "A") + begins.substr(past == 0 ? 4 : 1) + ", the prediction is " +
                report::significant(off.rmse, 3) + unit + " off (root mean square) over " +
                report::fixed(static_cast<double>(series.samples() - 1) * model::period_s, 0) + " s. " + baseline_sentence(baselines, unit);
    page.blocks.push_back(
        report::Paragraph{of_trust, leaves_training(trust, about) ? report::Paragraph::Tone::caution : report::Paragraph::Tone::plain});
    page.blocks.push_back(table);
    for (auto& block : rollout_blocks(series, open, about.task, &trust)) page.blocks.push_back(std::move(block));
    page.footer = {"weights: " + weights_path(arguments.model) + ", trained on " + about.trained_on, "recording: " + arguments.recording,
                   "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
    const std::string html = report::to_html(page);
    outputs->stage("rollout.csv", csv);
    outputs->stage("report.html", html);
    outputs->commit();
    if (!arguments.json) std::printf("written: %s/{rollout.csv, report.html}\n", outputs->folder().c_str());
  }
  if (arguments.json)
    std::printf("%s\n", json.dump(1).c_str());
  else
    std::printf("%s%s\n", report::to_text(table).c_str(), report::wrap(baseline_sentence(baselines, unit) + " " + of_trust).c_str());
  return 0;
}

}  // namespace

void add_rollout(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<RolloutArguments>();
  CLI::App* command =
      program.add_subcommand("rollout", "Predict a channel over a recording, such as the bend angle, from one measured value.");
  command->add_option("model", arguments->model, "weights.h5, or the folder that `sinew train` wrote")->required();
  command->add_option("--recording", arguments->recording, "recording in CSV")->required();
  command->add_option("--horizon", arguments->horizon_s, "at most so long [s]")->check(positive_number())->capture_default_str();
  command->add_option("--from", arguments->from_s, "begins at this time of the recording [s]")->check(CLI::NonNegativeNumber);
  command
      ->add_option("--history", arguments->history_s,
                   "so much of the recording before --from is given to the predictor to begin with; 0: one measured value [s]")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--count", arguments->windows, "also give the error from this time to that, as 130,190 [s]")
      ->delimiter(',')
      ->expected(2);
  command->add_option("--case", arguments->paper_case, "the case that the weights must be of")->check(CLI::Range(1, 4));
  command->add_option("--plant", arguments->plant,
                      "a plant file of the kind that the recording is of; left out: by the weights, or the paper's limb");
  command->add_option("--predict", arguments->predict, "with --case: the channel, by its column; left out: the first that inputs drive");
  command->add_option("--method", arguments->method, "of a file that Keras wrote")->check(CLI::IsMember({"published", "stateful"}));
  command->add_option("--range,--angle-range", arguments->range, "of a file that Keras wrote: the values that are 0 and 1, as -60,60 [deg]")
      ->delimiter(',')
      ->expected(2);
  command->add_option("--out", arguments->out, "folder for rollout.csv and report.html");
  command->add_flag("--report", arguments->report, "write them beside the recording where --out is not given");
  command->add_flag("--hold-missing", arguments->hold_missing, "take the value before where a sample is missing");
  add_resample(*command, arguments->resample);
  command->add_flag("--json", arguments->json, "print JSON");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n  sinew rollout results/lstm4 --recording c.csv --horizon 600 --report\n"
      "  sinew rollout model.h5 --case 3 --method published --range -60,60 --recording c.csv");
  command->callback([arguments, &exit_code] { exit_code = rollout_command(*arguments); });
}

}  // namespace sinew::apps
