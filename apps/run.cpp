// SPDX-License-Identifier: Apache-2.0
// sinew run: a scenario on the simulated limb.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/app.h"
#include "apps/outputs.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct RunArguments {
  std::string scenario, out;
  std::int64_t seed = -1;
  double stop_at_s = 0.0;
  bool resume = false, overwrite = false;
};

int run_command(const RunArguments& arguments) {
  Outputs outputs(arguments.out, {.yaml = {arguments.scenario}}, arguments.overwrite);
  outputs.claim_in_parts("checkpoint.json");
  sim::Scenario scenario = sim::read_scenario(arguments.scenario);
  if (arguments.seed >= 0) scenario.seed = arguments.seed;
  const std::filesystem::path out = arguments.out;
  const std::string scenario_yaml = sim::to_yaml(scenario);
  const std::filesystem::path checkpoint_file = out / "checkpoint.json";

  sim::RunOptions options;
  if (std::filesystem::exists(checkpoint_file) && (arguments.resume || !arguments.overwrite)) {
    if (!arguments.resume)
      throw sim::InputError(
          {.file = checkpoint_file.string(), .advice = "an earlier run stopped here; go on with --resume, or start anew with --overwrite"});
    options.resume = sim::checkpoint_from_json(sim::read_file(checkpoint_file), checkpoint_file.string(), scenario_yaml);
  } else if (arguments.resume) {
    throw sim::InputError({.file = checkpoint_file.string(), .advice = "no checkpoint to go on from"});
  }
  outputs.claim({"recording.csv", "truth.csv", "scenario.yaml", "run.json"});
  double reached_s = 0.0;
  Progress progress("run");
  options.progress = [&](double time_s) {
    reached_s = time_s;
    progress.show(time_s / scenario.duration_s);
  };
  options.should_stop = [&] { return interrupted() || (arguments.stop_at_s > 0.0 && reached_s >= arguments.stop_at_s); };
  const sim::RunResult result = sim::run(scenario, options);
  if (result.status == sim::RunStatus::stopped) {
    sim::write_file_whole(checkpoint_file, sim::to_json(*result.checkpoint, scenario_yaml));
    std::fprintf(stderr, "stopped at %s s; go on with: sinew run %s --out %s --seed %s%s --resume\n", sim::shortest(reached_s).c_str(),
                 arguments.scenario.c_str(), arguments.out.c_str(), std::to_string(scenario.seed).c_str(),
                 arguments.overwrite ? " --overwrite" : "");
    return interrupted_exit_code;
  }
  const std::map<std::string, std::string> files{{"recording.csv", result.recording_csv},
                                                 {"truth.csv", result.truth_csv},
                                                 {"scenario.yaml", scenario_yaml}};
  for (const auto& [name, content] : files) outputs.stage(name, content);
  outputs.stage("run.json", sim::run_json(scenario, result, files));
  outputs.discard("checkpoint.json");
  outputs.commit();
  if (result.failure) {
    std::fprintf(stderr, "the integration failed at %s s: %s\n", sim::shortest(result.failure->time_s).c_str(),
                 result.failure->reason.c_str());
    return 1;
  }
  std::printf("%lld samples over %s s, seed %lld; %lld integrator steps\nwritten: %s/{recording.csv, truth.csv, scenario.yaml, run.json}\n",
              static_cast<long long>(scenario.ticks()), sim::shortest(scenario.duration_s).c_str(), static_cast<long long>(scenario.seed),
              static_cast<long long>(result.counters.steps), out.string().c_str());
  return 0;
}

}  // namespace

void add_run(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = program.add_subcommand("run", "Run a scenario on the simulated limb.");
  command->add_option("scenario", arguments->scenario, "scenario in YAML")->required();
  command->add_option("--out", arguments->out, "folder for recording.csv, truth.csv, scenario.yaml, run.json")->required();
  command->add_option("--seed", arguments->seed, "instead of the scenario's own")->check(CLI::NonNegativeNumber);
  command->add_flag("--resume", arguments->resume, "go on from the checkpoint that an interrupted run left");
  command->add_option("--stop-at", arguments->stop_at_s, "stop at the first checkpoint at or after this time [s], as Ctrl-C would")
      ->check(positive_number());
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n  sinew run scenarios/babble_bidirectional.yaml --out results/babble --seed 7\n"
      "  sinew run scenarios/step.yaml --out /tmp/step");
  command->callback([arguments, &exit_code] { exit_code = run_command(*arguments); });
}

}  // namespace sinew::apps
