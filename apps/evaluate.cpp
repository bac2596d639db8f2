// SPDX-License-Identifier: Apache-2.0
// sinew evaluate: where a predictor fails, one stress at a time.
//
//     format: 1
//     base: babble_bidirectional.yaml        # relative to this file
//     every_effect: true                     # a row for each effect of the catalogue, as strong as is typical
//     rows:
//       - { name: hot room, parameters: { ambient_temperature_degC: 40 } }
//
// A row is a domain (model/dataset.h): what it draws or sets. Each is run with `seeds` seeds.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/app.h"
#include "apps/ends_soon.h"
#include "apps/outputs.h"
#include "apps/ranks.h"
#include "apps/training.h"
#include "model/dataset.h"
#include "model/predictor.h"
#include "model/train.h"
#include "model/weights_file.h"
#include "report/console.h"
#include "report/markdown.h"
#include "report/number.h"
#include "report/svg.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct EvaluateArguments {
  std::string model, stress, out;
  int threads = usual_threads();
  bool json = false, overwrite = false;
};

// Beyond the runs that a set can have, so that no stress is a session that was trained on.
constexpr std::int64_t first_run = 1000000;

struct Stress {
  std::string name;
  model::Domain domain;
};
struct StressFile {
  sim::Scenario base;
  std::int64_t seeds = 2;
  std::vector<Stress> rows;  // the first is the base itself
};

std::string file_name(const std::string& name, std::int64_t seed) {
  std::string text;
  for (const char c : name) text += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return text + "-" + std::to_string(seed) + ".yaml";
}

StressFile read_stress(const std::filesystem::path& path) {
  const sim::YamlValue root = sim::read_yaml(path);
  sim::YamlMap map(root);
  if (const auto* format = map.find("format"); format && format->whole_number() != 1)
    format->complain("must be 1, the format that this version reads");
  StressFile file;
  const sim::YamlValue& base = map.require("base", "a scenario, looked for beside this file");
  file.base = sim::read_scenario(path.parent_path() / base.text());
  if (const auto* seeds = map.find("seeds")) {
    file.seeds = seeds->whole_number();
    if (file.seeds < 1 || file.seeds > 1000) seeds->complain("must lie in [1, 1000]");
  }
  const auto* every = map.find("every_effect");
  const auto* rows = map.find("rows");
  map.finish();
  const plant::System& system = file.base.plant.system();
  file.rows.push_back({"nothing: the limb of the base", {}});
  if (every && every->truth())
    for (const plant::EffectId e : system.effects().ids()) {
      Stress stress{.name = std::string(system.effects()[e].name), .domain = {.effects = {{.effect = e}}}};
      if (const auto& needs = system.effects()[e].needs) stress.domain.effects.push_back({.effect = *needs});
      file.rows.push_back(std::move(stress));
    }
  if (rows && rows->kind != sim::YamlValue::Kind::list) rows->complain("must be a list, one stress an entry");
  if (rows)
    for (const sim::YamlValue& row : rows->list) {
      Stress stress;
      sim::YamlValue rest = row;
      std::erase_if(rest.map, [&](const auto& entry) {
        if (entry.key == "name") stress.name = entry.value.text();
        return entry.key == "name";
      });
      if (stress.name.empty()) row.complain("each row needs a name");
      stress.domain = model::read_domain(rest, system);
      for (const Stress& other : file.rows)
        if (file_name(other.name, 0) == file_name(stress.name, 0)) row.complain("there is a row of this name already: " + other.name);
      file.rows.push_back(std::move(stress));
    }
  return file;
}

struct Outcome {
  std::string name, scenario_file;
  double rmse = std::nan(""), one_step = std::nan(""), last_minute = std::nan(""), hold = std::nan(""), arx = std::nan("");
  double inside = std::nan(""), inside_one_step = std::nan(""), outside = std::nan("");  // shares: of the interval, of training
  std::string outside_words, failure;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Outcome, name, scenario_file, rmse, one_step, last_minute, hold, arx, inside, inside_one_step, outside,
                                   outside_words, failure)

report::TimePlot drift_plot(const model::Series& series, const model::Vector<double>& predicted, const model::Task& task,
                            const Trust& trust, const std::string& name) {
  report::TimePlot plot = std::get<report::TimePlot>(rollout_blocks(series, predicted, task, &trust).front());
  plot.title = name;
  plot.time_axis = "";
  return plot;
}

struct Job {
  std::size_t row;
  std::int64_t seed;
};
std::vector<Job> jobs_of(const StressFile& stress) {
  std::vector<Job> jobs;
  for (std::size_t r = 0; r < stress.rows.size(); ++r)
    for (std::int64_t seed = 0; seed < stress.seeds; ++seed) jobs.push_back({r, seed});
  return jobs;
}
model::DrawnRun drawn_job(const StressFile& stress, const Job& job) {
  return model::drawn_run(stress.base, stress.rows[job.row].domain, first_run + job.seed);
}
std::string scenario_file(const StressFile& stress, const Job& job) {
  return file_name(stress.rows[job.row].name, drawn_job(stress, job).scenario.seed);
}

struct Judged {
  Outcome outcome;
  std::optional<report::TimePlot> plot;  // none where it failed
};
// Throws Stopped.
Judged judged(const StressFile& stress, const Job& job, const model::Predictor& predictor, const std::function<bool()>& should_stop) {
  const model::AboutPredictor& about = predictor.about();
  const model::DrawnRun one = drawn_job(stress, job);
  Judged result;
  Outcome& outcome = result.outcome;
  outcome.name = stress.rows[job.row].name;
  outcome.scenario_file = scenario_file(stress, job);
  sim::RunOptions options;
  options.should_stop = should_stop;
  const sim::RunResult run = sim::run(one.scenario, options);
  const auto look = [&] {
    if (should_stop()) throw model::Stopped{};
  };
  look();
  if (run.failure) {
    outcome.failure = "the simulation failed: " + run.failure->reason;
    return result;
  }
  try {
    const sim::Columns columns = sim::columns_of(stress.base.plant.system());
    const model::Series series =
        model::series_of(sim::parse_recording(run.recording_csv, outcome.scenario_file, columns), about.task, model::Missing::held);
    const auto own = predictor.copy();
    const model::Vector<double> open = model::rollout(*own, series);
    look();
    const model::Errors off = model::errors_of(open, series);
    outcome.rmse = off.rmse;
    outcome.last_minute = off.last_minute;
    const Baselines baselines = baselines_of(predictor, series);
    outcome.hold = baselines.hold;
    outcome.arx = baselines.arx.value_or(std::nan(""));
    look();
    const model::Vector<double> step = model::one_step_ahead(*own, series);
    look();
    outcome.one_step = model::errors_of(step, series).rmse;
    const Trust trust = trust_in(about, series, series, 0, 0, open, step);
    if (trust.interval) {
      outcome.inside = trust.interval->inside_open_loop;
      outcome.inside_one_step = trust.interval->inside_one_step;
    }
    if (trust.departures) {
      outcome.outside = trust.departures->share();
      if (trust.departures->outside > 0) outcome.outside_words = departure_sentence(trust, about, series.first_s);
    }
    result.plot = drift_plot(series, open, about.task, trust, outcome.name);
  } catch (const sim::InputError& e) {
    outcome.failure = e.advice;
  }
  return result;
}

int evaluate_command(const EvaluateArguments& arguments, Ranks& ranks) {
  std::optional<Outputs> outputs;
  const bool uninterrupted = ranks.first_alone([&] {
    const InputPaths read{.files = {arguments.model}, .yaml = {arguments.stress}};
    if (arguments.out.empty())
      finish_interrupted(read);
    else
      outputs.emplace(arguments.out, read, arguments.overwrite);
    const StressFile stress = read_stress(arguments.stress);
    std::vector<std::string> names{"README.md", "stress.svg", "report.html", "stress.json"};
    for (const Job& job : jobs_of(stress)) names.push_back("scenarios/" + scenario_file(stress, job));
    if (outputs) outputs->claim(names);
    read_predictor_at(arguments.model);  // what is wrong with it is said once
  });
  const char* const nothing_written = "nothing was written";
  if (!uninterrupted) return stopped(ranks, nothing_written);
  const StressFile stress = read_stress(arguments.stress);
  const std::vector<Job> jobs = jobs_of(stress);
  const auto predictor = read_predictor_at(arguments.model);
  const model::AboutPredictor& about = predictor->about();
  const sim::Column& predicted = about.task.predicted;
  const std::string unit = unit_words(predicted);
  const auto should_stop = [&] { return ranks.any_interrupted(); };
  std::optional<EndsSoon> ends_soon;
  if (!ranks.under_mpirun()) ends_soon.emplace(outputs ? &*outputs : nullptr);
  std::mutex keeping;
  std::map<std::size_t, Outcome> own;  // by job
  const auto name = [&](std::size_t j) { return stress.rows[jobs[j].row].name; };
  const bool whole = ranks.share(jobs.size(), {.threads = arguments.threads, .doing = "stress", .name = name}, [&](std::size_t j) {
    Outcome outcome;
    try {
      outcome = judged(stress, jobs[j], *predictor, should_stop).outcome;
    } catch (const model::Stopped&) {
      return;
    }
    const std::scoped_lock lock(keeping);
    own.emplace(j, std::move(outcome));
  });
  if (!whole) return stopped(ranks, nothing_written);
  std::string bytes;
  nlohmann::json::to_cbor(nlohmann::json(own), bytes);  // keeps what is not a number, which text does not
  std::vector<Outcome> outcomes(jobs.size());
  for (const std::string& of_rank : ranks.gather(bytes))
    for (auto& [j, outcome] : nlohmann::json::from_cbor(of_rank).get<std::map<std::size_t, Outcome>>()) outcomes[j] = outcome;
  if (!ranks.first()) return 0;
  struct Row {
    std::string name;
    double mean = 0.0, worst = 0.0, one_step = 0.0, last = 0.0, hold = 0.0, arx = 0.0, inside = 0.0, inside_one_step = 0.0, outside = 0.0;
    std::size_t worst_job = 0;
    std::int64_t counted = 0;
    std::string failure;
  };
  std::vector<Row> rows;
  for (std::size_t r = 0; r < stress.rows.size(); ++r) {
    Row row{.name = stress.rows[r].name, .worst_job = r * static_cast<std::size_t>(stress.seeds), .failure = {}};
    std::int64_t count = 0;
    for (std::size_t j = 0; j < jobs.size(); ++j) {
      if (jobs[j].row != r) continue;
      if (!outcomes[j].failure.empty()) {
        row.failure = outcomes[j].failure;
        continue;
      }
      ++count;
      row.mean += outcomes[j].rmse;
      row.one_step += outcomes[j].one_step;
      row.last += outcomes[j].last_minute;
      row.hold += outcomes[j].hold;
      row.arx += outcomes[j].arx;
      row.inside += outcomes[j].inside;
      row.inside_one_step += outcomes[j].inside_one_step;
      row.outside += outcomes[j].outside;
      if (outcomes[j].rmse > row.worst) {
        row.worst = outcomes[j].rmse;
        row.worst_job = j;
      }
    }
    const double n = static_cast<double>(count);
    row.mean /= n;
    row.one_step /= n;
    row.last /= n;
    row.hold /= n;
    row.arx /= n;
    row.inside /= n;
    row.inside_one_step /= n;
    row.outside /= n;
    row.counted = count;
    if (count == 0) row.worst = std::nan("");
    rows.push_back(row);
  }
  const Row base = rows.front();
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return b.mean < a.mean || (std::isnan(a.mean) && !std::isnan(b.mean)); });
  report::Table table;
  table.header = {
      "stress",         "open loop / " + unit, "against no stress",   "worst seed / " + unit, "last minute / " + unit, "one step / " + unit,
      "held / " + unit, "ARX / " + unit,       "inside the interval", "outside of training",  "again: sinew run"};
  const auto percent = [](double share) { return std::isnan(share) ? "–" : report::significant(100.0 * share, 3) + " %"; };
  nlohmann::ordered_json json{{"model", weights_path(arguments.model)},
                              {"case", about.task.paper_case},
                              {"method", about.kind},
                              {"seeds", stress.seeds},
                              {"rows", nlohmann::ordered_json::array()}};
  for (const Row& row : rows) {
    table.rows.push_back({{row.name, report::significant(row.mean, 3), report::significant(row.mean / base.mean, 3),
                           report::significant(row.worst, 3), report::significant(row.last, 3), report::significant(row.one_step, 3),
                           report::significant(row.hold, 3), about.arx ? report::significant(row.arx, 3) : "–", percent(row.inside),
                           percent(row.outside), "scenarios/" + outcomes[row.worst_job].scenario_file},
                          row.name == base.name,
                          row.failure});
    json["rows"].push_back({{"stress", row.name},
                            {key_in_unit("rollout_rmse", predicted), row.mean},
                            {key_in_unit("worst_seed", predicted), row.worst},
                            {key_in_unit("last_minute", predicted), row.last},
                            {key_in_unit("one_step_rmse", predicted), row.one_step},
                            {key_in_unit("hold_rmse", predicted), row.hold},
                            {key_in_unit("arx_rmse", predicted), row.arx},
                            {"inside_interval_open_loop", row.inside},
                            {"inside_interval_one_step", row.inside_one_step},
                            {"outside_of_training", row.outside},
                            {"outside_words", outcomes[row.worst_job].outside_words},
                            {"seeds_counted", row.counted},
                            {"failure", row.failure},
                            {"scenario", "scenarios/" + outcomes[row.worst_job].scenario_file}});
  }
  const model::IntervalSteps* at_first = about.intervals ? about.intervals->steps_for(model::Beginning::at_first) : nullptr;
  table.caption =
      "Root mean square error of rollouts from one measured value, mean of " + std::to_string(stress.seeds) +
      " seeds (of those that finished), worst first. Missing samples are held. Baselines in open loop: "
      "the first value held, and a linear model (ARX) fitted to what the predictor was trained on" +
      (about.arx ? "." : ", which this weights file lacks.") +
      (at_first ? " Inside the interval: share of samples in open loop; it was made for " +
                      report::significant(100.0 * model::promised_share(*at_first), 2) + " % of rollouts without stress."
                : " This weights file has no intervals.") +
      (about.region ? " Outside of training: share of samples whose inputs, their past or the prediction were not trained on." : "");
  if (outputs) {
    report::Page page;
    page.title = "Where the predictor fails";
    page.lead = "Without stress it is " + report::significant(base.mean, 3) + unit + " off in open loop; worst under \"" +
                rows.front().name + "\", " + report::significant(rows.front().mean, 3) + unit + ".";
    page.blocks.push_back(table);
    report::Section section;
    section.heading = "The worst three, and no stress";
    page.blocks.push_back(section);
    std::vector<report::TimePlot> shown;
    const auto show = [&](const Row& row) {
      if (row.counted == 0) return;
      if (const auto plot = judged(stress, jobs[row.worst_job], *predictor, should_stop).plot) shown.push_back(*plot);
    };
    for (std::size_t r = 0; r < rows.size() && shown.size() < 3; ++r) show(rows[r]);
    show(base);
    for (const report::TimePlot& plot : shown) page.blocks.push_back(plot);
    ends_soon.reset();
    page.footer = {"weights: " + weights_path(arguments.model) + ", trained on " + about.trained_on, "stress: " + arguments.stress,
                   "sinew " + sim::this_build().version + " (" + sim::this_build().commit + ")"};
    const std::string html = report::to_html(page);
    for (const Job& job : jobs)
      outputs->stage("scenarios/" + scenario_file(stress, job),
                     "# Stress on a predictor: " + stress.rows[job.row].name + ".\n" + sim::to_yaml(drawn_job(stress, job).scenario));
    outputs->stage("README.md", "# Where the predictor fails\n\nMade by `sinew evaluate " + arguments.model + " --stress " +
                                    arguments.stress + " --out " + arguments.out + "`. " + page.lead + " " + table.caption +
                                    "\n\n![worst three, and no stress](stress.svg)\n\n" + report::to_markdown(table));
    outputs->stage("stress.svg", report::stacked_svg(shown, 720, 160 * static_cast<int>(shown.size())));
    outputs->stage("report.html", html);
    outputs->stage("stress.json", json.dump(1) + "\n");
    outputs->commit();
  }
  if (arguments.json) {
    std::printf("%s\n", json.dump(1).c_str());
  } else {
    std::fputs(report::to_text(table).c_str(), stdout);
    if (!arguments.out.empty())
      std::printf("written: %s/{report.html, README.md, stress.svg, stress.json, scenarios/}\n", arguments.out.c_str());
  }
  return 0;
}

}  // namespace

void add_evaluate(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* command = program.add_subcommand("evaluate", "Put a predictor under stress: effects, faults, other limbs. Worst cases first.");
  command->add_option("model", arguments->model, "weights.h5, or the folder that `sinew train` wrote")->required();
  command->add_option("--stress", arguments->stress, "stresses in YAML")->required();
  command->add_option("--out", arguments->out, "folder for report.html, README.md, stress.svg, stress.json, scenarios/");
  command->add_option("--threads", arguments->threads, "simulations at a time")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_flag("--json", arguments->json, "print JSON");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n"
      "  sinew evaluate results/lstm4 --stress scenarios/stress.yaml --out results/stress4\n"
      "  mpirun -n 8 sinew evaluate results/lstm4 --stress scenarios/stress.yaml --threads 1 --out /scratch/stress4");
  command->callback(
      [arguments, &exit_code] { exit_code = in_all_ranks([&](Ranks& ranks) { return evaluate_command(*arguments, ranks); }); });
}

}  // namespace sinew::apps
