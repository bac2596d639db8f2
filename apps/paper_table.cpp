// SPDX-License-Identifier: Apache-2.0
// sinew paper-table: the table of Sabelhaus et al. 2022 on the simulated limb: four cases, their method and others, several seeds.
//
// As in their notebook, one session is trained on up to 67 %, and its last third is predicted, from its second 15 on to the end, from
// one value measured in mid-motion. It is as long as their 169 batches of 100 samples a pass need. One coil for cases 1 and 2, both
// for 3 and 4. Seeds of data and weights are the same number.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "apps/app.h"
#include "apps/outputs.h"
#include "apps/ranks.h"
#include "apps/training.h"
#include "hil/limits.h"
#include "model/drift.h"
#include "plant/contains.h"
#include "report/console.h"
#include "report/markdown.h"
#include "report/number.h"
#include "sim/code.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/parallel.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

using Json = nlohmann::ordered_json;

// A row of the table: a predictor, and what of its settings is not as usual.
struct Method {
  std::string name, predictor, settings, words;
  bool keeps_drift = false;  // whether its drift is measured
};
const std::vector<Method>& all_methods() {
  static const std::vector<Method> all{
      {"published", "published", "",
       "as in the notebook: in order, one scaler over all columns, fitted to all data, the test's too; rate 0.01"},
      {"published 1e-3", "published", "rate: 1.0e-3", "with the rate of the text"},
      {"published clean", "published", "scaler_sees_all: false", "with a scaler fitted to the training part alone"},
      {"published shuffled", "published", "shuffle: true", "with samples in random order, Keras's default"},
      {"stateful", "stateful", "", "with memory, trained in open loop", true},
      {"corrected", "corrected", "", "the same weights, and what their last errors say of the next"},
      {"ARX", "arx", "", "linear, fitted to one step"},
      {"ARX simulation", "arx_simulation", "", "linear, fitted to the error of its rollout", true},
      {"least squares", "least_squares", "", "on the inputs of the instant"}};
  return all;
}
std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  return names;
}
const Method& method_named(const std::string& name) {
  return *std::find_if(all_methods().begin(), all_methods().end(), [&](const Method& one) { return one.name == name; });
}

struct PaperArguments {
  std::string out, settings, one_coil = "scenarios/babble_unidirectional.yaml", two_coils = "scenarios/babble_bidirectional.yaml";
  int seeds = 5, first_seed = 1, drift_sessions = 100;
  double thermostat_degC = 0.01 * LIMIT_HOST_cdegC;
  std::vector<int> cases{1, 2, 3, 4};
  std::vector<std::string> methods = method_names();
  int threads = usual_threads();
  bool overwrite = false;
};

// 169 batches of 100 samples in the first 67 %, as in the notebook; a session's first sample has none before it.
constexpr double paper_training_fraction = 0.67, test_begins_s = 15.0, drift_session_s = 600.0;
constexpr model::Index paper_samples = 25226;
static_assert(static_cast<int>(paper_training_fraction * paper_samples) == 169 * 100 + 1);
constexpr std::int64_t first_drift_seed = 2001;

// A session of a babbling controller with the limb's thermostat: whoever drives a part whose sensor reads more than the limit waits.
model::Series session(const std::string& file, const model::Task& task, std::int64_t seed, model::Index samples, double thermostat_degC,
                      const std::function<bool()>& should_stop) {
  sim::Scenario scenario = sim::read_scenario(file);
  scenario.seed = seed;
  const plant::System& system = scenario.plant.system();
  sim::SimulatedBackend limb(scenario);
  sim::Driver driver(system, scenario.input, static_cast<std::uint64_t>(seed), scenario.sample_period_s);
  sim::Recording recording;
  recording.name = file + ", seed " + std::to_string(seed);
  recording.columns = sim::columns_of(system);
  sim::Measurement measured = limb.begin();
  for (model::Index k = 0;; ++k) {
    if (should_stop()) throw model::Stopped{};
    if (limb.failure()) throw std::runtime_error(file + ": " + limb.failure()->reason);
    sim::Command command = driver.command(measured, scenario.time_s(measured.tick));
    for (const plant::ChannelId c : system.channels().ids())
      if (const auto driven_by = system.channels()[c].driven_by; driven_by && measured.channels[c.index] > thermostat_degC)
        command.inputs[driven_by->index] = 0.0;
    recording.samples.push_back({scenario.time_s(measured.tick), command.inputs, measured.channels});
    if (k + 1 == samples) break;
    measured = limb.exchange(command);
  }
  return model::series_of(recording, task);
}

std::string case_words(int paper_case) {
  static const char* const words[] = {"one coil, duty", "one coil, duty and temperature", "both coils, duty",
                                      "both coils, duty and temperature"};
  return words[paper_case - 1];
}

// Median, lowest and highest: a mean of few seeds of which one diverges says nothing of the others.
struct Spread {
  double median = std::nan(""), lowest = std::nan(""), highest = std::nan("");
};
Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {0.5 * (values[(n - 1) / 2] + values[n / 2]), values.front(), values.back()};
}
std::string text_of(const Spread& s) {
  return report::significant(s.median, 3) + " (" + report::significant(s.lowest, 3) + " to " + report::significant(s.highest, 3) + ")";
}

std::string cell_name(int paper_case, const std::string& method, int seed) {
  std::string id = std::to_string(paper_case) + "-" + method + "-" + std::to_string(seed);
  std::replace(id.begin(), id.end(), ' ', '_');
  return id;
}

// Nothing where there is none, or a damaged one.
Json read_cell(const std::filesystem::path& file) {
  const Json cell = std::filesystem::exists(file) ? Json::parse(sim::read_file(file), nullptr, false) : Json();
  return cell.is_object() ? cell : Json();
}
bool is_of(const Json& cell, const std::string& settings_mark) {
  return cell.value("settings", "") == settings_mark && cell.value("code", "") == sim::code_identity();
}

// Whether table.json is one that this command wrote.
bool holds_table(const std::filesystem::path& out) {
  const std::filesystem::path file = out / "table.json";
  const Json table = std::filesystem::exists(file) ? Json::parse(sim::read_file(file), nullptr, false) : Json();
  return table.is_array() && !table.empty() && table.front().is_object() && table.front().contains("settings");
}

// The settings of a file, with those of the method over them.
model::TrainingFile settings_for(const Method& method, const std::string& file) {
  model::TrainingFile settings;
  if (!file.empty()) settings = model::read_training(file);
  if (method.settings.empty()) return settings;
  sim::YamlValue own = sim::parse_yaml(method.settings, "paper-table, " + method.name);
  const auto found = settings.given.find(method.predictor);
  if (found == settings.given.end()) {
    settings.given.emplace(method.predictor, std::move(own));
  } else {
    for (auto& entry : own.map) {
      std::erase_if(found->second.map, [&](const auto& one) { return one.key == entry.key; });
      found->second.map.push_back(std::move(entry));
    }
  }
  return settings;
}

std::string csv_of(const model::Series& test, const model::Vector<double>& open, const model::Vector<double>& step) {
  std::string csv = "# by `sinew paper-table`: measured, in open loop, one step ahead\ntime_s,measured,rollout,one_step\n";
  for (model::Index k = 0; k < test.samples(); ++k) {
    for (const double value : {test.first_s + static_cast<double>(k) * model::period_s, test.y(k), open(k), step(k)}) {
      if (csv.back() != '\n') csv += ',';
      sim::append_shortest(csv, value);
    }
    csv += '\n';
  }
  return csv;
}

// A cell of the table: a method's figures on the session of a case and a seed.
struct Cell {
  int paper_case;
  const Method* method;
  int seed;
  std::string id() const { return cell_name(paper_case, method->name, seed); }
};

// The table's cells on disk: each is made once, and kept with its weights and its rollout.
class Cells {
 public:
  explicit Cells(const PaperArguments& arguments) : arguments_(arguments), out_(arguments.out) {
    cases_ = arguments.cases;
    std::sort(cases_.begin(), cases_.end());
    cases_.erase(std::unique(cases_.begin(), cases_.end()), cases_.end());
    for (const Method& method : all_methods())
      if (contains(arguments.methods, method.name)) methods_.push_back(&method);
    for (const int paper_case : cases_)
      for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.seeds; ++seed)
        for (const Method* method : methods_) all_.push_back({paper_case, method, seed});
  }
  const std::vector<int>& cases() const { return cases_; }
  const std::vector<const Method*>& methods() const { return methods_; }
  const std::vector<Cell>& all() const { return all_; }

  // Throws InputError where a cell that is there is another's, and where something cannot be read.
  void check() const {
    for (const Cell& cell : all_) {
      const std::string mark = mark_of(cell);
      if (const Json there = read_cell(file_of(cell)); !arguments_.overwrite && !there.is_null() && !is_of(there, mark))
        throw sim::InputError({.file = file_of(cell).string(),
                               .key = "--out",
                               .value = out_.string(),
                               .advice = "other settings, scenarios or sessions, or other code of plant, sim and model, made this cell\n"
                                         "give another folder, or make the cells again with --overwrite"});
    }
  }

  // What is asked for in one go: corrected takes the weights of the stateful cell before it, and whoever trains that has them.
  std::vector<std::vector<Cell>> shares() const {
    std::vector<std::vector<Cell>> shares;
    for (const Cell& cell : all_)
      if (cell.method->predictor == "corrected" && !shares.empty() && shares.back().back().method->predictor == "stateful")
        shares.back().push_back(cell);
      else
        shares.push_back({cell});
    return shares;
  }

  // Null where there is none of these settings and this code.
  Json there(const Cell& cell) const {
    const Json kept = read_cell(file_of(cell));
    return !kept.is_null() && is_of(kept, mark_of(cell)) ? kept : Json();
  }

  // Throws Stopped.
  Json make(const Cell& cell, const std::function<bool()>& should_stop) {
    const Method& method = *cell.method;
    const std::string& scenario = scenario_of(cell.paper_case);
    const model::Task task = model::task_of(sim::read_scenario(scenario).plant.system(), cell.paper_case);
    const model::Series& whole = training_session(cell, task, should_stop);
    model::TrainingRun run;
    run.task = task;
    run.seed = static_cast<std::uint64_t>(cell.seed);
    run.threads = arguments_.threads;
    run.should_stop = should_stop;
    std::unique_ptr<model::Predictor> from;
    const Cell stateful{cell.paper_case, &method_named("stateful"), cell.seed};
    if (method.predictor == "corrected" && std::filesystem::exists(weights_of(stateful)) && !there(stateful).is_null())
      from = model::read_predictor(weights_of(stateful));
    const model::TrainingFile settings = settings_for(method, arguments_.settings);
    const model::TrainedPredictor trained = model::predictor_kind(method.predictor).train({{whole}, settings, run, from.get(), nullptr});
    const model::Index begin = whole.samples() * 2 / 3 + static_cast<model::Index>(std::lround(test_begins_s / model::period_s));
    const model::Series test = model::part_of(whole, begin, whole.samples() - begin);
    const model::Vector<double> open = model::rollout(*trained.predictor, test), step = model::one_step_ahead(*trained.predictor, test);
    const model::Errors off = model::errors_of(open, test);
    Json made{{"case", cell.paper_case},
              {"method", method.name},
              {"seed", cell.seed},
              {"settings", mark_of(cell)},
              {"version", sim::this_build().version},
              {"code", sim::code_identity()},
              {"rollout_deg", off.rmse},
              {"largest_deg", off.largest},
              {"one_step_deg", model::errors_of(step, test).rmse}};
    if (!trained.curve.empty()) {
      made["updates"] = trained.best_update;
      made["last_update"] = trained.curve.back().update;
    }
    if (method.keeps_drift && arguments_.drift_sessions > 0) {
      const std::vector<model::Series>& sessions = drift_sessions(cell.paper_case, task, should_stop);
      std::vector<double> slopes(sessions.size()), squares(sessions.size());
      sim::in_parallel(sessions.size(), arguments_.threads, [&](std::size_t i) {
        const auto own = trained.predictor->copy();
        const model::Vector<double> error = model::rollout(*own, sessions[i]) - sessions[i].y;
        slopes[i] = model::squared_error_slope_1_min(error);
        squares[i] = error.tail(error.size() - model::drift_from).squaredNorm() / static_cast<double>(error.size() - model::drift_from);
      });
      made["session_slope_deg2_min"] = slopes;
      made["session_mean_square_deg2"] = squares;
    }
    trained.predictor->about().trained_on = whole.name;
    sim::write_file_whole(weights_of(cell), model::bytes_of(*trained.predictor));
    sim::write_file_whole(out_ / "rollouts" / (cell.id() + ".csv"), csv_of(test, open, step));
    sim::write_file_whole(file_of(cell), made.dump(1) + "\n");
    return made;
  }

 private:
  const std::string& scenario_of(int paper_case) const { return paper_case <= 2 ? arguments_.one_coil : arguments_.two_coils; }
  std::filesystem::path file_of(const Cell& cell) const { return out_ / "cells" / (cell.id() + ".json"); }
  std::filesystem::path weights_of(const Cell& cell) const { return out_ / "weights" / (cell.id() + ".h5"); }

  // A cell of other settings, scenario or sessions is made again. All settings count, defaults too.
  std::string mark_of(const Cell& cell) const {
    const Method& method = *cell.method;
    const model::TrainingFile settings = settings_for(method, arguments_.settings);
    std::string all = model::predictor_kind(method.predictor).settings_text(settings);
    if (method.predictor == "corrected") all += model::predictor_kind("stateful").settings_text(settings);
    all += sim::to_yaml(sim::read_scenario(scenario_of(cell.paper_case)));
    all += sim::shortest(arguments_.thermostat_degC) + " " + std::to_string(method.keeps_drift ? arguments_.drift_sessions : 0);
    return sim::sha256(all).substr(0, 8);
  }

  // The last one is kept: all methods have the same.
  const model::Series& training_session(const Cell& cell, const model::Task& task, const std::function<bool()>& should_stop) {
    const std::pair which{cell.paper_case, cell.seed};
    if (!last_session_ || last_session_->first != which)
      last_session_.emplace(which,
                            session(scenario_of(cell.paper_case), task, cell.seed, paper_samples, arguments_.thermostat_degC, should_stop));
    return last_session_->second;
  }

  // Made where a case's first cell needs them.
  const std::vector<model::Series>& drift_sessions(int paper_case, const model::Task& task, const std::function<bool()>& should_stop) {
    std::vector<model::Series>& sessions = drift_sessions_[paper_case];
    if (!sessions.empty()) return sessions;
    std::vector<model::Series> made(static_cast<std::size_t>(arguments_.drift_sessions));
    sim::in_parallel(made.size(), arguments_.threads, [&](std::size_t i) {
      made[i] = session(scenario_of(paper_case), task, first_drift_seed + static_cast<std::int64_t>(i),
                        static_cast<model::Index>(drift_session_s / model::period_s) + 1, arguments_.thermostat_degC, should_stop);
    });
    return sessions = std::move(made);
  }

  const PaperArguments& arguments_;
  const std::filesystem::path out_;
  std::vector<int> cases_;
  std::vector<const Method*> methods_;
  std::vector<Cell> all_;
  std::optional<std::pair<std::pair<int, int>, model::Series>> last_session_;  // case and seed
  std::map<int, std::vector<model::Series>> drift_sessions_;                   // by case
};

// What the cells come to.
struct Tables {
  report::Table errors, drift;
  std::size_t seeds_compared = 0, seeds_beaten = 0;  // stateful at most half as far off as published
};
Tables tables_of(const Cells& cells, const std::map<std::string, Json>& by_id) {
  Tables tables;
  tables.errors.header = {"case", "method", "open loop / °", "one step / °"};
  tables.drift.header = {
      "case",          "method", "open loop / °, from the second minute on", "slope of the squared error, % of its mean a minute",
      "95 % interval", "drifts"};
  const auto error_in = [](const Json& cell, const char* key) { return cell.at(key).is_null() ? HUGE_VAL : cell.at(key).get<double>(); };
  for (const int paper_case : cells.cases()) {
    std::map<std::string, std::vector<double>> open;
    for (const Method* method : cells.methods()) {
      std::vector<double> step;
      std::vector<std::vector<double>> slopes, squares;
      for (const Cell& one : cells.all()) {
        if (one.paper_case != paper_case || one.method != method) continue;
        const Json& cell = by_id.at(one.id());
        open[method->name].push_back(error_in(cell, "rollout_deg"));
        step.push_back(error_in(cell, "one_step_deg"));
        if (cell.contains("session_slope_deg2_min")) {
          slopes.push_back(cell.at("session_slope_deg2_min"));
          squares.push_back(cell.at("session_mean_square_deg2"));
        }
      }
      const std::string which = std::to_string(paper_case) + ", " + case_words(paper_case);
      tables.errors.rows.push_back({{which, method->name, text_of(spread(open[method->name])), text_of(spread(step))}});
      if (slopes.empty()) continue;
      const model::Drift drift = model::drift_of(slopes, squares);
      tables.drift.rows.push_back(
          {{which, method->name, report::significant(drift.rmse, 3), report::significant(100.0 * drift.relative_slope_1_min, 2),
            report::significant(100.0 * drift.lowest, 2) + " to " + report::significant(100.0 * drift.highest, 2),
            drift.lowest > 0.0 ? "yes" : "no"}});
    }
    if (open.count("published") && open.count("stateful"))
      for (std::size_t s = 0; s < open["published"].size(); ++s, ++tables.seeds_compared)
        tables.seeds_beaten += open["stateful"][s] <= 0.5 * open["published"][s];
  }
  return tables;
}

// The command that makes this table again.
std::string command_of(const PaperArguments& arguments, const Cells& cells) {
  const PaperArguments usual;
  const auto listed = [](const auto& list, auto&& text) {
    std::string joined;
    for (const auto& one : list) joined += (joined.empty() ? "" : ",") + text(one);
    return joined;
  };
  std::string command = "sinew paper-table --seeds " + std::to_string(arguments.seeds);
  if (arguments.first_seed != usual.first_seed) command += " --first-seed " + std::to_string(arguments.first_seed);
  if (cells.cases() != usual.cases) command += " --cases " + listed(cells.cases(), [](int c) { return std::to_string(c); });
  if (const auto& methods = cells.methods(); methods.size() != all_methods().size())
    command += " --methods '" + listed(methods, [](const Method* m) { return m->name; }) + "'";
  if (arguments.drift_sessions != usual.drift_sessions) command += " --drift-sessions " + std::to_string(arguments.drift_sessions);
  if (arguments.thermostat_degC != usual.thermostat_degC) command += " --thermostat " + sim::shortest(arguments.thermostat_degC);
  if (arguments.one_coil != usual.one_coil) command += " --one-coil " + arguments.one_coil;
  if (arguments.two_coils != usual.two_coils) command += " --two-coils " + arguments.two_coils;
  if (!arguments.settings.empty()) command += " --settings " + arguments.settings;
  return command + " --out " + arguments.out;
}

std::string markdown_of(const PaperArguments& arguments, const Cells& cells, const Tables& tables) {
  std::string markdown = "# The paper's table on the simulated limb\n\nMade by `" + command_of(arguments, cells) + "`, " +
                         sim::this_build().version +
                         ". Root mean square errors of the bend angle; median, lowest and highest of the seeds. A session of 42 minutes is "
                         "trained on up to 67 % and predicted over its last third, from second 15 of that on, from one value measured in "
                         "mid-motion. A coil that reads above " +
                         sim::shortest(arguments.thermostat_degC) + " °C is not driven.\n\n" + report::to_markdown(tables.errors) + "\n";
  for (const Method* method : cells.methods()) markdown += "- " + method->name + ": " + method->words + ".\n";
  if (tables.seeds_compared > 0)
    markdown += "\nStateful is at most half as far off in open loop as published, seed by seed: " + std::to_string(tables.seeds_beaten) +
                " of " + std::to_string(tables.seeds_compared) + ".\n";
  if (!tables.drift.rows.empty())
    markdown +=
        "\n## Does the error grow?\n\n" + std::to_string(arguments.drift_sessions) +
        " other sessions of ten minutes, from rest, each rolled out by the weights of every seed. The slope is that of least squares "
        "through the squared error from the second minute on; its interval is of a bootstrap over sessions, and a predictor drifts "
        "where all of the interval lies above 0.\n\n" +
        report::to_markdown(tables.drift);
  return markdown +
         "\nThe paper's figures for the physical limb: one step 0.209° (case 1) to 2.613° (case 4); open loop 6.296° (case 1), 6.151° "
         "(case 3), 5.350° (case 4); least squares 19.01° (case 3), 6.372° (case 4).\n";
}

int paper_command(const PaperArguments& arguments, Ranks& ranks) {
  Cells cells(arguments);
  const std::filesystem::path out = arguments.out;
  std::optional<Outputs> outputs;
  const bool uninterrupted = ranks.first_alone([&] {
    outputs.emplace(out, InputPaths{.yaml = {arguments.settings, arguments.one_coil, arguments.two_coils}}, arguments.overwrite);
    outputs->claim({"README.md", "table.json"}, holds_table(out));
    for (const char* part : {"cells", "weights", "rollouts"}) outputs->claim_in_parts(part);
    cells.check();
    for (const char* part : {"cells", "weights", "rollouts"}) std::filesystem::create_directories(out / part);
  });
  if (!uninterrupted) return stopped(ranks, "the same command goes on");
  const auto shares = cells.shares();
  std::map<std::string, Json> own;
  const auto name = [&](std::size_t i) { return shares[i].back().id(); };
  const bool whole = ranks.share(shares.size(), {.doing = "paper table", .name = name}, [&](std::size_t i) {
    for (const Cell& cell : shares[i]) {
      Json made = cells.there(cell);
      try {
        if (made.is_null()) made = cells.make(cell, [&] { return ranks.any_interrupted(); });
      } catch (const model::Stopped&) {
        return;
      }
      own.emplace(cell.id(), std::move(made));
    }
  });
  if (!whole) return stopped(ranks, "the cells that are done are kept, the same command goes on");
  std::map<std::string, Json> by_id;
  for (const std::string& of_rank : ranks.gather(Json(own).dump())) by_id.merge(Json::parse(of_rank).get<std::map<std::string, Json>>());
  if (!ranks.first()) return 0;
  const Tables tables = tables_of(cells, by_id);
  Json json = Json::array();
  for (const Cell& cell : cells.all()) json.push_back(by_id.at(cell.id()));
  outputs->stage("README.md", markdown_of(arguments, cells, tables));
  outputs->stage("table.json", json.dump(1) + "\n");
  outputs->commit();
  std::fputs(report::to_text(tables.errors).c_str(), stdout);
  if (!tables.drift.rows.empty()) std::fputs(report::to_text(tables.drift).c_str(), stdout);
  std::printf("written: %s/{README.md, table.json, cells/, weights/, rollouts/}\n", out.string().c_str());
  return 0;
}

}  // namespace

void add_paper_table(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<PaperArguments>();
  CLI::App* command =
      program.add_subcommand("paper-table", "The paper's table on the simulated limb: four cases, its method and others, several seeds.");
  command->add_option("--out", arguments->out, "folder for README.md, table.json, cells/, weights/, rollouts/")->required();
  command->add_option("--seeds", arguments->seeds, "how many")->check(CLI::Range(1, 1000))->capture_default_str();
  command->add_option("--first-seed", arguments->first_seed, "seeds from here on")->check(CLI::Range(1, 1000000))->capture_default_str();
  command->add_option("--cases", arguments->cases, "only these")->delimiter(',')->check(CLI::Range(1, 4));
  command->add_option("--methods", arguments->methods, "only these")->delimiter(',')->check(CLI::IsMember(method_names()));
  command->add_option("--drift-sessions", arguments->drift_sessions, "sessions over which drift is measured; 0: none")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  command->add_option("--thermostat", arguments->thermostat_degC, "a part that reads more is not driven [degC]")->capture_default_str();
  command->add_option("--settings", arguments->settings, "of the training, in YAML");
  command->add_option("--one-coil", arguments->one_coil, "scenario of cases 1 and 2")->capture_default_str();
  command->add_option("--two-coils", arguments->two_coils, "scenario of cases 3 and 4")->capture_default_str();
  command->add_option("--threads", arguments->threads, "changes no number")->check(CLI::Range(1, 1024))->capture_default_str();
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Ctrl-C keeps the cells that are done; the same command goes on from there, under mpirun too.\n\nExamples:\n"
      "  sinew paper-table --out results/paper_table\n"
      "  mpirun -n 8 sinew paper-table --threads 1 --out /scratch/paper_table");
  command->callback([arguments, &exit_code] { exit_code = in_all_ranks([&](Ranks& ranks) { return paper_command(*arguments, ranks); }); });
}

}  // namespace sinew::apps
