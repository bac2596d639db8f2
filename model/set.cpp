// SPDX-License-Identifier: Apache-2.0
#include "model/set.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "model/hdf5_file.h"
#include "sim/code.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

std::string number_of(std::int64_t run) {
  char text[24];
  std::snprintf(text, sizeof text, "%04lld", static_cast<long long>(run));
  return text;
}
fs::path stem_of(const fs::path& folder, std::int64_t run) { return folder / "runs" / number_of(run); }

Json json_of(const fs::path& file) {
  try {
    return Json::parse(sim::read_file(file));
  } catch (const Json::exception& e) {
    throw sim::InputError({.file = file.string(), .advice = std::string("is no JSON: ") + e.what()});
  }
}

// The time's column, then those of the plant.
std::vector<std::string> column_names(const SetPlan& plan) {
  const sim::Columns columns = sim::columns_of(plan.scenario.plant.system());
  std::vector<std::string> names{"time_s"};
  for (const auto* some : {&columns.inputs, &columns.channels})
    for (const sim::Column& column : *some) names.push_back(column.name);
  return names;
}

fs::path manifest_in(const fs::path& folder) {
  const fs::path manifest = folder / "manifest.json";
  if (!fs::exists(manifest))
    throw sim::InputError(
        {.file = folder.string(), .advice = "has no manifest.json: no set by `sinew dataset`, or one that is not finished"});
  return manifest;
}
[[noreturn]] void complain_of_manifest(const fs::path& manifest, const Json::exception& e) {
  throw sim::InputError({.file = manifest.string(), .advice = std::string("is no manifest of a set: ") + e.what()});
}

// Of the scenario that the manifest holds only the plant is read: a recording that it replays may have gone since.
std::shared_ptr<const plant::System> system_in(const Json& manifest, const fs::path& file) {
  const sim::YamlValue scenario = sim::parse_yaml(manifest.at("scenario").get<std::string>(), file.string());
  for (const auto& entry : scenario.map)
    if (entry.key == "plant") return sim::read_plant(entry.value, file.parent_path()).shared_system();
  return plant::default_plant().shared_system();
}

}  // namespace

std::string SetPlan::mark() const { return sim::sha256(scenario_yaml + '\0' + domain_text + '\0' + sim::code_identity()).substr(0, 16); }

bool is_there(const SetPlan& plan, const fs::path& folder, std::int64_t run) {
  const fs::path stem = stem_of(folder, run), about = stem.string() + ".json", recording = stem.string() + ".csv";
  if (!fs::exists(about) || !fs::exists(recording)) return false;
  try {
    const Json json = Json::parse(sim::read_file(about));
    return json.at("mark") == plan.mark() && json.at("sha256") == sim::sha256(sim::read_file(recording));
  } catch (const Json::exception&) {
    return false;
  }
}

void make_run(const SetPlan& plan, const fs::path& folder, std::int64_t run, const std::function<bool()>& should_stop) {
  const DrawnRun one = drawn_run(plan.scenario, plan.domain, run);
  sim::RunOptions options;
  options.should_stop = should_stop;
  const sim::RunResult result = sim::run(one.scenario, options);
  if (result.status == sim::RunStatus::stopped) return;
  Json json{{"mark", plan.mark()},
            {"run", run},
            {"seed", one.scenario.seed},
            {"status", result.status == sim::RunStatus::finished ? "finished" : "failed"},
            {"sha256", sim::sha256(result.recording_csv)},
            {"drawn", Json::object()}};
  for (const auto& [name, value] : one.drawn) json["drawn"][name] = value;
  json["effects"] = Json::array();
  const plant::Plant& plant = one.scenario.plant;
  for (const plant::EffectId e : plant.system().effects().ids())
    if (plant.is_on(e)) json["effects"].push_back(plant.system().effects()[e].name);
  fs::create_directories(folder / "runs");
  sim::write_file_whole(stem_of(folder, run).string() + ".json", json.dump(1) + "\n");
  sim::write_file_whole(stem_of(folder, run).string() + ".csv", result.recording_csv);
}

std::string manifest_of(const SetPlan& plan, const fs::path& folder) {
  std::string column_list;
  for (const std::string& name : column_names(plan)) column_list += (column_list.empty() ? "" : ", ") + name;
  Json json{{"what", "a set of runs by `sinew dataset`"},
            {"version", sim::this_build().version},
            {"mark", plan.mark()},
            {"sample_period_s", plan.scenario.sample_period_s},
            {"duration_s", plan.scenario.duration_s},
            {"columns", column_list},
            {"scenario", plan.scenario_yaml},
            {"domain", plan.domain_text},
            {"runs", Json::array()}};
  for (std::int64_t run = 0; run < plan.runs; ++run) {
    Json one = json_of(stem_of(folder, run).string() + ".json");
    one.erase("mark");
    one["file"] = "runs/" + number_of(run) + ".csv";
    json["runs"].push_back(one);
  }
  return json.dump(1) + "\n";
}

std::int64_t failed_runs(const SetPlan& plan, const fs::path& folder) {
  std::int64_t failed = 0;
  for (std::int64_t run = 0; run < plan.runs; ++run) failed += json_of(stem_of(folder, run).string() + ".json").at("status") != "finished";
  return failed;
}

std::string set_in_hdf5(const SetPlan& plan, const fs::path& folder) {
  Hdf5File file;
  const std::vector<std::string> names = column_names(plan);
  for (std::int64_t run = 0; run < plan.runs; ++run) {
    const sim::Recording recording = sim::read_recording(stem_of(folder, run).string() + ".csv", plan.scenario.plant.system());
    Hdf5Array& array = file.arrays["/runs/" + number_of(run)];
    array.single = false;
    array.extents = {recording.samples.size(), names.size()};
    for (const sim::Sample& s : recording.samples) {
      array.values.push_back(s.time_s);
      array.values.insert(array.values.end(), s.inputs.begin(), s.inputs.end());
      array.values.insert(array.values.end(), s.channels.begin(), s.channels.end());
    }
  }
  file.list_attributes["/"]["columns"] = names;
  file.text_attributes["/"]["manifest"] = manifest_of(plan, folder);
  return to_bytes(file);
}

std::shared_ptr<const plant::System> system_of_set(const fs::path& path) {
  if (!fs::is_directory(path)) return nullptr;
  const fs::path manifest = manifest_in(path);
  try {
    return system_in(json_of(manifest), manifest);
  } catch (const Json::exception& e) {
    complain_of_manifest(manifest, e);
  }
}

std::vector<sim::Recording> read_set(const fs::path& path, const sim::Columns& columns_of_file) {
  if (!fs::is_directory(path)) return {sim::read_recording(path, columns_of_file)};
  const fs::path manifest = manifest_in(path);
  std::vector<sim::Recording> recordings;
  try {
    const Json json = json_of(manifest);
    const sim::Columns columns = sim::columns_of(*system_in(json, manifest));
    for (const Json& run : json.at("runs")) {
      if (run.at("status") != "finished") continue;
      const fs::path file = path / run.at("file").get<std::string>();
      const std::string bytes = sim::read_file(file);
      if (sim::sha256(bytes) != run.at("sha256"))
        throw sim::InputError({.file = file.string(), .advice = "is not the run that manifest.json has the hash of"});
      recordings.push_back(sim::parse_recording(bytes, file.string(), columns));
    }
  } catch (const Json::exception& e) {
    complain_of_manifest(manifest, e);
  }
  if (recordings.empty()) throw sim::InputError({.file = manifest.string(), .advice = "has no run that finished"});
  return recordings;
}

}  // namespace sinew::model
