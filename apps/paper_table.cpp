// SPDX-License-Identifier: Apache-2.0
// sinew paper-table: the table of Sabelhaus et al. 2022 on the simulated limb: four cases, both methods, several seeds.
//
// Of each seed: 28 minutes of babbling to train on (the first 67 %), 10 minutes of another session to test on; one coil for cases
// 1 and 2, both for 3 and 4. Seeds of data and weights are the same number.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>

#include "apps/app.h"
#include "apps/outputs.h"
#include "apps/training.h"
#include "model/linear.h"
#include "model/predictor.h"
#include "model/weights_file.h"
#include "report/console.h"
#include "report/markdown.h"
#include "report/number.h"
#include "sim/fields.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

using Json = nlohmann::ordered_json;

struct PaperArguments {
  std::string out, settings, one_coil = "scenarios/babble_unidirectional.yaml", two_coils = "scenarios/babble_bidirectional.yaml";
  int seeds = 3, first_seed = 1;
  std::vector<int> cases{1, 2, 3, 4};
  std::vector<std::string> methods{"published", "stateful", "least squares", "ARX"};
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool overwrite = false;
};

constexpr double training_s = 28.0 * 60.0, test_s = 600.0;
constexpr double paper_training_fraction = 0.67;

model::Series session(const std::string& file, const model::Task& task, std::int64_t seed, double duration_s) {
  sim::Scenario scenario = sim::read_scenario(file);
  scenario.seed = seed;
  scenario.duration_s = duration_s;
  const sim::RunResult result = sim::run(scenario);
  if (result.failure) throw std::runtime_error(file + ": " + result.failure->reason);
  return model::series_of(sim::parse_recording(result.recording_csv, file + ", seed " + std::to_string(seed),
                                               sim::columns_of(scenario.plant.system())),
                          task);
}

Json json_of(const model::Vector<double>& open, const model::Vector<double>& step, const model::Series& test) {
  const model::Errors off = model::errors_of(open, test);
  return {{"rollout_deg", off.rmse},
          {"second_minute_deg", off.second_minute},
          {"last_minute_deg", off.last_minute},
          {"one_step_deg", model::errors_of(step, test).rmse}};
}

std::string case_words(int paper_case) {
  static const char* const words[] = {"one coil, duty", "one coil, duty and temperature", "both coils, duty",
                                      "both coils, duty and temperature"};
  return words[paper_case - 1];
}

struct Spread {
  double mean = std::nan(""), deviation = 0.0;
};
Spread spread(const std::vector<double>& values) {
  Spread s;
  if (values.empty()) return s;
  s.mean = 0.0;
  for (const double v : values) s.mean += v / static_cast<double>(values.size());
  for (const double v : values) s.deviation += std::pow(v - s.mean, 2) / std::max(1.0, static_cast<double>(values.size()) - 1.0);
  s.deviation = std::sqrt(s.deviation);
  return s;
}
std::string text_of(const Spread& s) { return report::significant(s.mean, 3) + " ± " + report::significant(s.deviation, 2); }

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
  return cell.value("settings", "") == settings_mark && cell.value("version", "") == sim::this_build().version;
}

// Whether table.json is one that this command wrote.
bool holds_table(const std::filesystem::path& out) {
  const std::filesystem::path file = out / "table.json";
  const Json table = std::filesystem::exists(file) ? Json::parse(sim::read_file(file), nullptr, false) : Json();
  return table.is_array() && !table.empty() && table.front().is_object() && table.front().contains("settings");
}

int paper_command(const PaperArguments& arguments) {
  const std::filesystem::path out = arguments.out;
  Outputs outputs(out, {.yaml = {arguments.settings, arguments.one_coil, arguments.two_coils}}, arguments.overwrite);
  outputs.claim({"README.md", "table.json"}, holds_table(out));
  outputs.claim_in_parts("cells");
  Json cells = Json::array();
  // Cells of other settings or scenarios are made again. All settings count, defaults too.
  model::TrainingFile settings;
  if (!arguments.settings.empty()) settings = model::read_training(arguments.settings);
  std::string all_settings;
  model::PublishedSettings published = settings.published.value_or(model::PublishedSettings{});
  model::StatefulSettings stateful = settings.stateful.value_or(model::StatefulSettings{});
  model::PublishedSettings::fields(published, sim::Write{all_settings, ""});
  model::StatefulSettings::fields(stateful, sim::Write{all_settings, ""});
  std::vector<int> cases = arguments.cases;
  std::sort(cases.begin(), cases.end());
  cases.erase(std::unique(cases.begin(), cases.end()), cases.end());
  std::vector<std::string> methods;
  for (const std::string& method : arguments.methods)
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) methods.push_back(method);
  for (const int paper_case : cases)
    all_settings += sim::to_yaml(sim::read_scenario(paper_case <= 2 ? arguments.one_coil : arguments.two_coils));
  const std::string settings_mark = sim::sha256(all_settings).substr(0, 8);
  if (!arguments.overwrite)
    for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.seeds; ++seed)
      for (const int paper_case : cases)
        for (const std::string& method : methods) {
          const std::filesystem::path file = out / "cells" / (cell_name(paper_case, method, seed) + ".json");
          if (const Json cell = read_cell(file); !cell.is_null() && !is_of(cell, settings_mark))
            throw sim::InputError({.file = file.string(),
                                   .key = "--out",
                                   .value = out.string(),
                                   .advice = "other settings, scenarios, cases or another version of this program made this cell\n"
                                             "give another folder, or make the cells again with --overwrite"});
        }
  std::filesystem::create_directories(out / "cells");
  Progress progress("paper table");
  const std::size_t all = cases.size() * methods.size() * static_cast<std::size_t>(arguments.seeds);
  std::size_t done = 0;
  for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.seeds; ++seed)
    for (const int paper_case : cases) {
      const std::string& scenario = paper_case <= 2 ? arguments.one_coil : arguments.two_coils;
      const model::Task task = model::task_of(sim::read_scenario(scenario).plant.system(), paper_case);
      std::optional<model::Series> training, test;
      for (const std::string& method : methods) {
        const std::string id = cell_name(paper_case, method, seed);
        const std::filesystem::path cell_file = out / "cells" / (id + ".json");
        ++done;
        if (const Json there = read_cell(cell_file); !there.is_null() && is_of(there, settings_mark)) {
          cells.push_back(there);
          continue;
        }
        if (!training) {
          training = session(scenario, task, seed, training_s);
          test = session(scenario, task, 1000 + seed, test_s);
        }
        progress.show(static_cast<double>(done - 1) / static_cast<double>(all), id);
        Json cell{
            {"case", paper_case}, {"method", method}, {"seed", seed}, {"settings", settings_mark}, {"version", sim::this_build().version}};
        if (method == "published" || method == "stateful") {
          model::TrainingRun run;
          run.task = task;
          run.seed = static_cast<std::uint64_t>(seed);
          run.threads = arguments.threads;
          run.should_stop = interrupted;
          const model::Trained trained = train_by(method, training_settings(method, arguments.settings), {*training}, run);
          cell.update(json_of(model::rollout(trained.model, *test), model::one_step_ahead(trained.model, *test), *test));
          cell["updates"] = trained.best_update;
        } else {
          const auto used =
              model::part_of(*training, 0, static_cast<model::Index>(paper_training_fraction * static_cast<double>(training->samples())));
          const model::LinearModel linear = method == "ARX" ? model::fit_arx({used}) : model::fit_static({used});
          cell.update(json_of(model::rollout(linear, *test), model::one_step_ahead(linear, *test), *test));
          if (method == "ARX") cell["order"] = linear.order;
        }
        sim::write_file_whole(cell_file, cell.dump(1) + "\n");
        cells.push_back(cell);
      }
    }
  report::Table table;
  table.header = {"case", "method", "open loop / °", "second minute / °", "last minute / °", "last over second", "one step / °"};
  bool beats = true, holds = true;
  std::size_t compared = 0, looked_at = 0;
  for (const int paper_case : cases) {
    std::map<std::string, std::vector<double>> open;
    for (const std::string& method : methods) {
      std::map<std::string, std::vector<double>> values;
      for (const Json& cell : cells)
        if (cell.at("case") == paper_case && cell.at("method") == method)
          for (const char* key : {"rollout_deg", "second_minute_deg", "last_minute_deg", "one_step_deg"})
            values[key].push_back(cell.at(key));
      open[method] = values["rollout_deg"];
      const double drift = spread(values["last_minute_deg"]).mean / spread(values["second_minute_deg"]).mean;
      if (method == "stateful") {
        holds = holds && drift <= 1.1;
        ++looked_at;
      }
      table.rows.push_back({{std::to_string(paper_case) + ", " + case_words(paper_case), method, text_of(spread(values["rollout_deg"])),
                             text_of(spread(values["second_minute_deg"])), text_of(spread(values["last_minute_deg"])),
                             report::significant(drift, 3), text_of(spread(values["one_step_deg"]))}});
    }
    if (open.count("published") && open.count("stateful"))
      for (std::size_t s = 0; s < open["published"].size(); ++s, ++compared) beats = beats && open["stateful"][s] < open["published"][s];
  }
  std::string options;
  const PaperArguments usual;
  const auto listed = [](const auto& list, auto&& text) {
    std::string joined;
    for (const auto& one : list) joined += (joined.empty() ? "" : ",") + text(one);
    return joined;
  };
  if (arguments.first_seed != usual.first_seed) options += " --first-seed " + std::to_string(arguments.first_seed);
  if (cases != usual.cases) options += " --cases " + listed(cases, [](int c) { return std::to_string(c); });
  if (methods != usual.methods) options += " --methods '" + listed(methods, [](const std::string& m) { return m; }) + "'";
  if (arguments.one_coil != usual.one_coil) options += " --one-coil " + arguments.one_coil;
  if (arguments.two_coils != usual.two_coils) options += " --two-coils " + arguments.two_coils;
  if (!arguments.settings.empty()) options += " --settings " + arguments.settings;
  std::string markdown = "# The paper's table on the simulated limb\n\nMade by `sinew paper-table --seeds " +
                         std::to_string(arguments.seeds) + options + " --out " + arguments.out + "`, " + sim::this_build().version +
                         ". Mean ± standard deviation over seeds; root mean square errors of the bend angle on ten "
                         "minutes of a session that was not trained on.\n\n" +
                         report::to_markdown(table) + "\n";
  if (compared > 0)
    markdown += "Stateful beats published in every rollout (" + std::to_string(compared) + "): " + (beats ? "yes" : "**no**") + ". ";
  if (looked_at > 0)
    markdown += "The last minute of stateful is at most 1.1 times as far off as the second, mean over seeds, in every case: " +
                std::string(holds ? "yes" : "**no**") + ".";
  markdown +=
      "\n\nThe paper's figures for the physical limb: one step 0.209° (case 1) to 2.613° (case 4); open loop 6.296° (case 1), 6.151° "
      "(case 3), 5.350° (case 4); least squares 19.01° (case 3), 6.372° (case 4).\n";
  outputs.stage("README.md", markdown);
  outputs.stage("table.json", cells.dump(1) + "\n");
  outputs.commit();
  std::fputs(report::to_text(table).c_str(), stdout);
  std::printf("written: %s/{README.md, table.json, cells/}\n", out.string().c_str());
  return 0;
}

}  // namespace

void add_paper_table(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<PaperArguments>();
  CLI::App* command =
      program.add_subcommand("paper-table", "The paper's table on the simulated limb: four cases, both methods, several seeds.");
  command->add_option("--out", arguments->out, "folder for README.md, table.json, cells/")->required();
  command->add_option("--seeds", arguments->seeds, "how many")->check(CLI::Range(1, 1000))->capture_default_str();
  command->add_option("--first-seed", arguments->first_seed, "seeds from here on")->check(CLI::Range(1, 1000000))->capture_default_str();
  command->add_option("--cases", arguments->cases, "only these")->delimiter(',')->check(CLI::Range(1, 4));
  command->add_option("--methods", arguments->methods, "only these")
      ->delimiter(',')
      ->check(CLI::IsMember({"published", "stateful", "least squares", "ARX"}));
  command->add_option("--settings", arguments->settings, "of the training, in YAML");
  command->add_option("--one-coil", arguments->one_coil, "scenario of cases 1 and 2")->capture_default_str();
  command->add_option("--two-coils", arguments->two_coils, "scenario of cases 3 and 4")->capture_default_str();
  command->add_option("--threads", arguments->threads, "changes no number")->check(CLI::Range(1, 1024))->capture_default_str();
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Ctrl-C keeps the cells that are done; the same command goes on from there.\n\nExample:\n  sinew paper-table --out "
      "results/paper_table");
  command->callback([arguments, &exit_code] { exit_code = paper_command(*arguments); });
}

}  // namespace sinew::apps
