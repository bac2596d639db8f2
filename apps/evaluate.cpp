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
#include <array>
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

// What is said of one run or, as a mean, of a row. Errors in the unit of what is predicted; the last three are shares.
struct Figures {
  double rmse = std::nan(""), last_minute = std::nan(""), one_step = std::nan(""), hold = std::nan(""), arx = std::nan("");
  double inside = std::nan(""), inside_one_step = std::nan(""), outside = std::nan("");
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Figures, rmse, last_minute, one_step, hold, arx, inside, inside_one_step, outside)
constexpr std::array all_figures{&Figures::rmse, &Figures::last_minute, &Figures::one_step,        &Figures::hold,
                                 &Figures::arx,  &Figures::inside,      &Figures::inside_one_step, &Figures::outside};

struct Outcome {
  std::string scenario_file;
  Figures figures;
  std::string outside_words, failure;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Outcome, scenario_file, figures, outside_words, failure)

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
  Figures& figures = outcome.figures;
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
    figures.rmse = off.rmse;
    figures.last_minute = off.last_minute;
    const Baselines baselines = baselines_of(predictor, series);
    figures.hold = baselines.hold;
    figures.arx = baselines.arx.value_or(std::nan(""));
    look();
    const model::Vector<double> step = model::one_step_ahead(*own, series);
    look();
    figures.one_step = model::errors_of(step, series).rmse;
    const Trust trust = trust_in(about, series, series, 0, 0, open, step);
    if (trust.interval) {
      figures.inside = trust.interval->inside_open_loop;
      figures.inside_one_step = trust.interval->inside_one_step;
    }
    if (trust.departures) {
      figures.outside = trust.departures->share();
      if (trust.departures->outside > 0) outcome.outside_words = departure_sentence(trust, about, series.first_s);
    }
    result.plot = drift_plot(series, open, about.task, trust, stress.rows[job.row].name);
  } catch (const sim::InputError& e) {
    outcome.failure = e.advice;
  }
  return result;
}

// A row of the stress file, and what its seeds came to.
struct StressRow {
  std::string name;
  Figures mean;                 // over the seeds that finished
  double worst = std::nan("");  // of their errors in open loop
  std::size_t worst_job = 0;    // the first one where none finished
  std::int64_t counted = 0;     // seeds that finished
  std::string failure;          // of the last one that did not
};

StressRow row_of(const StressFile& stress, std::size_t r, const std::vector<Outcome>& outcomes) {
  const auto seeds = static_cast<std::size_t>(stress.seeds);
  StressRow row{.name = stress.rows[r].name, .mean = {}, .worst_job = r * seeds, .failure = {}};
  for (std::size_t j = r * seeds; j < (r + 1) * seeds; ++j) {
    const Outcome& one = outcomes[j];
    if (!one.failure.empty()) {
      row.failure = one.failure;
      continue;
    }
    for (const auto figure : all_figures) {
      double& sum = row.mean.*figure;
      sum = row.counted == 0 ? one.figures.*figure : sum + one.figures.*figure;
    }
    if (row.counted == 0 || one.figures.rmse > row.worst) {
      row.worst = one.figures.rmse;
      row.worst_job = j;
    }
    ++row.counted;
  }
  for (const auto figure : all_figures) row.mean.*figure /= static_cast<double>(row.counted);
  return row;
}

// The base first.
std::vector<StressRow> rows_of(const StressFile& stress, const std::vector<Outcome>& outcomes) {
  std::vector<StressRow> rows;
  for (std::size_t r = 0; r < stress.rows.size(); ++r) rows.push_back(row_of(stress, r, outcomes));
  return rows;
}

// Rows that did not finish last.
std::vector<StressRow> worst_first(std::vector<StressRow> rows) {
  std::stable_sort(rows.begin(), rows.end(), [](const StressRow& a, const StressRow& b) {
    return b.mean.rmse < a.mean.rmse || (std::isnan(a.mean.rmse) && !std::isnan(b.mean.rmse));
  });
  return rows;
}

std::string scenario_of(const StressRow& row, const std::vector<Outcome>& outcomes) {
  return "scenarios/" + outcomes[row.worst_job].scenario_file;
}

report::Table table_of(const std::vector<StressRow>& rows, const StressRow& base, const std::vector<Outcome>& outcomes, std::int64_t seeds,
                       const model::AboutPredictor& about) {
  const std::string unit = unit_words(about.task.predicted);
  const auto number = [](double value) { return report::significant(value, 3); };
  const auto percent = [&](double share) { return std::isnan(share) ? "–" : number(100.0 * share) + " %"; };
  report::Table table;
  table.header = {
      "stress",         "open loop / " + unit, "against no stress",   "worst seed / " + unit, "last minute / " + unit, "one step / " + unit,
      "held / " + unit, "ARX / " + unit,       "inside the interval", "outside of training",  "again: sinew run"};
  for (const StressRow& row : rows)
    table.rows.push_back(
        {{row.name, number(row.mean.rmse), number(row.mean.rmse / base.mean.rmse), number(row.worst), number(row.mean.last_minute),
          number(row.mean.one_step), number(row.mean.hold), about.arx ? number(row.mean.arx) : "–", percent(row.mean.inside),
          percent(row.mean.outside), scenario_of(row, outcomes)},
         row.name == base.name,
         row.failure});
  const model::IntervalSteps* at_first = about.intervals ? about.intervals->steps_for(model::Beginning::at_first) : nullptr;
  table.caption =
      "Root mean square error of rollouts from one measured value, mean of " + std::to_string(seeds) +
      " seeds (of those that finished), worst first. Missing samples are held. Baselines in open loop: "
      "the first value held, and a linear model (ARX) fitted to what the predictor was trained on" +
      (about.arx ? "." : ", which this weights file lacks.") +
      (at_first ? " Inside the interval: share of samples in open loop; it was made for " +
                      report::significant(100.0 * model::promised_share(*at_first), 2) + " % of rollouts without stress."
                : " This weights file has no intervals.") +
      (about.region ? " Outside of training: share of samples whose inputs, their past or the prediction were not trained on." : "");
  return table;
}

nlohmann::ordered_json json_of(const std::vector<StressRow>& rows, const std::vector<Outcome>& outcomes, const sim::Column& predicted) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const StressRow& row : rows)
    json.push_back({{"stress", row.name},
                    {key_in_unit("rollout_rmse", predicted), row.mean.rmse},
                    {key_in_unit("worst_seed", predicted), row.worst},
                    {key_in_unit("last_minute", predicted), row.mean.last_minute},
                    {key_in_unit("one_step_rmse", predicted), row.mean.one_step},
                    {key_in_unit("hold_rmse", predicted), row.mean.hold},
                    {key_in_unit("arx_rmse", predicted), row.mean.arx},
                    {"inside_interval_open_loop", row.mean.inside},
                    {"inside_interval_one_step", row.mean.inside_one_step},
                    {"outside_of_training", row.mean.outside},
                    {"outside_words", outcomes[row.worst_job].outside_words},
                    {"seeds_counted", row.counted},
                    {"failure", row.failure},
                    {"scenario", scenario_of(row, outcomes)}});
  return json;
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
  const auto should_stop = [&] { return ranks.any_interrupted(); };
  std::optional<EndsSoon> ends_soon;
  if (!ranks.under_mpirun()) ends_soon.emplace(outputs ? &*outputs : nullptr);
  std::mutex keeping;
  std::map<std::size_t, Outcome> own;  // by job
  const auto name = [&](std::size_t j) { return stress.rows[jobs[j].row].name; };
  const bool whole = ranks.share(jobs.size(), {.threads = arguments.threads, .doing = "stress", .name = name}, [&](std::size_t j) {
    try {
      Outcome outcome = judged(stress, jobs[j], *predictor, should_stop).outcome;
      const std::scoped_lock lock(keeping);
      own.emplace(j, std::move(outcome));
    } catch (const model::Stopped&) {
      return;
    }
  });
  if (!whole) return stopped(ranks, nothing_written);
  std::string bytes;
  nlohmann::json::to_cbor(nlohmann::json(own), bytes);  // keeps what is not a number, which text does not
  std::vector<Outcome> outcomes(jobs.size());
  for (const std::string& of_rank : ranks.gather(bytes))
    for (auto& [j, outcome] : nlohmann::json::from_cbor(of_rank).get<std::map<std::size_t, Outcome>>()) outcomes[j] = outcome;
  if (!ranks.first()) return 0;
  const std::vector<StressRow> in_order = rows_of(stress, outcomes), rows = worst_first(in_order);
  const StressRow& base = in_order.front();
  const report::Table table = table_of(rows, base, outcomes, stress.seeds, about);
  const nlohmann::ordered_json json{{"model", weights_path(arguments.model)},
                                    {"case", about.task.paper_case},
                                    {"method", about.kind},
                                    {"seeds", stress.seeds},
                                    {"rows", json_of(rows, outcomes, about.task.predicted)}};
  if (outputs) {
    const std::string unit = unit_words(about.task.predicted);
    report::Page page;
    page.title = "Where the predictor fails";
    page.lead = "Without stress it is " + report::significant(base.mean.rmse, 3) + unit + " off in open loop; worst under \"" +
                rows.front().name + "\", " + report::significant(rows.front().mean.rmse, 3) + unit + ".";
    page.blocks.push_back(table);
    report::Section section;
    section.heading = "The worst three, and no stress";
    page.blocks.push_back(section);
    std::vector<report::TimePlot> shown;
    const auto show = [&](const StressRow& row) {
      if (row.counted > 0) shown.push_back(judged(stress, jobs[row.worst_job], *predictor, should_stop).plot.value());
    };
    for (const StressRow& row : rows)
      if (row.name != base.name && shown.size() < 3) show(row);
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
