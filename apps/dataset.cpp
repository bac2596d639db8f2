// SPDX-License-Identifier: Apache-2.0
// sinew dataset: many runs of one scenario, each on a plant of its own.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "apps/app.h"
#include "apps/outputs.h"
#include "apps/ranks.h"
#include "model/set.h"
#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct DatasetArguments {
  std::string scenario, randomise, out;
  std::int64_t runs = 16, seed = -1;
  int threads = usual_threads();
  bool overwrite = false;
};

nlohmann::json json_of(const std::filesystem::path& file) { return nlohmann::json::parse(sim::read_file(file), nullptr, false); }

// The files of runs/ that a set has: a number, .csv or .json.
std::vector<std::filesystem::path> part_files(const std::filesystem::path& out) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(out / "runs")) return files;
  for (const auto& entry : std::filesystem::directory_iterator(out / "runs")) {
    const std::string name = entry.path().filename().string();
    const std::size_t end = name.find_first_not_of("0123456789");
    if (end != 0 && end != std::string::npos && (name.substr(end) == ".csv" || name.substr(end) == ".json")) files.push_back(entry.path());
  }
  return files;
}

// Whether all that is in the folder is of this set, as far as it has come; then it can go on. A JSON that cannot be read is a part that was
// damaged.
bool goes_on(const model::SetPlan& plan, const std::filesystem::path& out) {
  const auto files = part_files(out);
  if (std::filesystem::exists(out / "manifest.json")) {
    const auto manifest = json_of(out / "manifest.json");
    if (!manifest.is_object() || manifest.value("mark", nlohmann::json()) != plan.mark()) return false;
    const auto runs = manifest.find("runs");
    if (runs == manifest.end() || !runs->is_number_integer() || runs->get<std::int64_t>() > plan.runs) return false;
  } else if (std::filesystem::exists(out / "set.h5") && files.empty()) {
    return false;
  }
  for (std::filesystem::path file : files) {
    if (!std::filesystem::exists(file.replace_extension(".json"))) return false;
    const auto about = json_of(file);
    if (!about.is_discarded() && (!about.is_object() || about.value("mark", nlohmann::json()) != plan.mark())) return false;
  }
  return true;
}

// The manifest first: without it nothing takes the rest for a set.
void remove_set(const std::filesystem::path& out) {
  std::filesystem::remove(out / "manifest.json");
  std::filesystem::remove(out / "set.h5");
  for (const auto& file : part_files(out)) std::filesystem::remove(file);
}

void prepare(Outputs& outputs, const model::SetPlan& plan) {
  outputs.claim_in_parts("runs");
  const bool same = goes_on(plan, outputs.folder());
  if (!same && !outputs.overwrite())
    throw sim::InputError({.file = "",
                           .key = "--out",
                           .value = outputs.folder().string(),
                           .advice = "holds another set, or a larger one: another scenario, seed, randomisation, number of runs in a file "
                                     "or code of this program made it\ngive another folder, or replace the set with --overwrite"});
  outputs.claim({"set.h5", "manifest.json"}, same);
  if (!same) remove_set(outputs.folder());
}

// How many parts a thread takes at a time: so few that all end together, so many that short runs do not wait for the counter.
std::size_t chunk_of(std::size_t parts, const Ranks& ranks, int threads) {
  constexpr std::size_t parts_of_a_thread = 64, longest = 64;
  return std::clamp<std::size_t>(parts / (parts_of_a_thread * static_cast<std::size_t>(ranks.size() * threads)), 1, longest);
}

using Parts = std::map<std::int64_t, model::SetPart>;

// Every rank: those of `parts` that `find` makes or finds, in the first rank. Nothing after an interrupt.
std::optional<Parts> shared(Ranks& ranks, const std::vector<std::int64_t>& parts, int threads, const std::string& doing,
                            const std::function<std::optional<model::SetPart>(std::int64_t)>& find) {
  nlohmann::json own = nlohmann::json::array();
  std::mutex keeping;
  const bool whole =
      ranks.share(parts.size(), {.threads = threads, .chunk = chunk_of(parts.size(), ranks, threads), .doing = doing}, [&](std::size_t i) {
        const auto found = find(parts[i]);
        const std::scoped_lock lock(keeping);
        if (found) own.push_back({parts[i], found->sha256, found->failed});
      });
  if (!whole) return std::nullopt;
  Parts all;
  for (const std::string& of_rank : ranks.gather(own.dump()))
    for (const auto& one : nlohmann::json::parse(of_rank)) all[one[0]] = {one[1], one[2]};
  return all;
}

// Every rank. Nothing after an interrupt.
std::optional<Parts> all_parts(Ranks& ranks, const model::SetPlan& plan, const std::filesystem::path& out, int threads) {
  std::vector<std::int64_t> parts(static_cast<std::size_t>(plan.parts())), open;
  std::iota(parts.begin(), parts.end(), 0);
  auto there =
      shared(ranks, parts, threads, "looking at what is there", [&](std::int64_t part) { return model::part_in(plan, out, part); });
  if (!there) return std::nullopt;
  std::int64_t runs_there = 0;
  for (const std::int64_t part : parts)
    if (there->count(part))
      runs_there += plan.runs_of(part).count;
    else
      open.push_back(part);
  open = nlohmann::json::parse(ranks.from_first(nlohmann::json(open).dump())).get<std::vector<std::int64_t>>();
  if (ranks.first() && runs_there > 0) std::fprintf(stderr, "%lld runs are there already\n", static_cast<long long>(runs_there));
  auto made = shared(ranks, open, threads, "dataset",
                     [&](std::int64_t part) { return model::make_part(plan, out, part, [&] { return ranks.any_interrupted(); }); });
  if (!made) return std::nullopt;
  there->merge(*made);
  return there;
}

model::SetPlan plan_of(const DatasetArguments& arguments) {
  model::SetPlan plan;
  plan.scenario = sim::read_scenario(arguments.scenario);
  if (arguments.seed >= 0) plan.scenario.seed = arguments.seed;
  plan.scenario_yaml = sim::to_yaml(plan.scenario);
  if (!arguments.randomise.empty()) {
    plan.domain = model::read_domain(std::filesystem::path(arguments.randomise), plan.scenario.plant.system());
    plan.domain_text = sim::read_file(arguments.randomise);
    if (!plan.domain.input.empty() && !std::holds_alternative<sim::BabbleInput>(plan.scenario.input))
      throw sim::InputError({.file = arguments.randomise,
                             .key = "input",
                             .advice = "can be drawn for a babbling scenario alone, which " + arguments.scenario + " is not"});
  }
  plan.runs = arguments.runs;
  return plan;
}

int dataset_command(const DatasetArguments& arguments, Ranks& ranks) {
  const std::filesystem::path out = arguments.out;
  std::optional<Outputs> outputs;
  const bool uninterrupted = ranks.first_alone([&] {
    const model::SetPlan plan = plan_of(arguments);  // what is wrong with it is said once
    outputs.emplace(out, InputPaths{.yaml = {arguments.scenario, arguments.randomise}}, arguments.overwrite);
    prepare(*outputs, plan);
  });
  if (!uninterrupted) return stopped(ranks, "the same command goes on");
  const model::SetPlan plan = plan_of(arguments);
  const auto parts = all_parts(ranks, plan, out, arguments.threads);
  if (!parts) return stopped(ranks, "what is done is kept, the same command goes on");
  if (!ranks.first()) return 0;
  std::vector<model::SetPart> in_order;
  std::int64_t failed = 0;
  for (const auto& [number, part] : *parts) {
    in_order.push_back(part);
    failed += part.failed;
  }
  const std::string manifest = model::manifest_of(plan, in_order);
  const bool in_hdf5 = plan.runs_in_part() == 1;
  if (in_hdf5) outputs->stage("set.h5", model::set_in_hdf5(plan, out, manifest));
  outputs->stage("manifest.json", manifest);
  outputs->commit();
  if (failed > 0)
    std::fprintf(stderr, "%lld of the runs failed; the JSON files of runs/ say which, and they are not trained on\n",
                 static_cast<long long>(failed));
  std::printf("%lld runs of %s s\nwritten: %s/{runs/, %smanifest.json}\n", static_cast<long long>(plan.runs),
              sim::shortest(plan.scenario.duration_s).c_str(), out.string().c_str(), in_hdf5 ? "set.h5, " : "");
  return 0;
}

}  // namespace

void add_dataset(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<DatasetArguments>();
  CLI::App* command = program.add_subcommand("dataset", "Make many runs of a scenario, each on a limb of its own, to train on.");
  command->add_option("scenario", arguments->scenario, "scenario in YAML")->required();
  command->add_option("--runs", arguments->runs, "how many")->check(CLI::Range(1, 1000000))->capture_default_str();
  command->add_option("--randomise", arguments->randomise, "what differs from run to run, in YAML");
  command->add_option("--out", arguments->out, "folder for runs/, set.h5, manifest.json")->required();
  command->add_option("--seed", arguments->seed, "instead of the scenario's own")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1000000000}));
  command->add_option("--threads", arguments->threads, "runs at a time; changes no byte")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Ctrl-C keeps the runs that are whole; the same command goes on from there, under mpirun too.\n\nExamples:\n"
      "  sinew dataset scenarios/babble_bidirectional.yaml --runs 64 --randomise scenarios/domain.yaml --out results/set\n"
      "  mpirun -n 4 sinew dataset scenarios/babble_bidirectional.yaml --runs 4096 --threads 1 --out /scratch/set");
  command->callback(
      [arguments, &exit_code] { exit_code = in_all_ranks([&](Ranks& ranks) { return dataset_command(*arguments, ranks); }); });
}

}  // namespace sinew::apps
