// SPDX-License-Identifier: Apache-2.0
#include "model/set.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
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
// A part's files have the number of its first run.
std::string part_name(const SetPlan& plan, std::int64_t part) { return "runs/" + number_of(plan.runs_of(part).first); }
fs::path json_path(const SetPlan& plan, const fs::path& folder, std::int64_t part) { return folder / (part_name(plan, part) + ".json"); }
fs::path csv_path(const SetPlan& plan, const fs::path& folder, std::int64_t part) { return folder / (part_name(plan, part) + ".csv"); }

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
  throw sim::InputError({.file = manifest.string(), .advice = std::string("is no manifest of a set by this version: ") + e.what()});
}

[[noreturn]] void complain_of_hash(const fs::path& file) {
  throw sim::InputError({.file = file.string(), .advice = "is not what manifest.json has the hash of"});
}

bool is_run(std::string_view recording, const Json& run) { return sim::sha256(recording) == run.at("sha256"); }

// A run's recording in the file of its part, of which no more is read. Throws InputError where it is not there whole.
std::string recording_in(const fs::path& file, const Json& run) {
  std::string recording(run.at("bytes").get<std::size_t>(), '\0');
  std::ifstream in(file, std::ios::binary);
  in.seekg(run.at("from_byte").get<std::streamoff>());
  if (!in.read(recording.data(), std::ssize(recording)) || !is_run(recording, run)) complain_of_hash(file);
  return recording;
}

// Of the scenario that the manifest holds only the plant is read: a recording that it replays may have gone since.
std::shared_ptr<const plant::System> system_in(const Json& manifest, const fs::path& file) {
  const sim::YamlValue scenario = sim::parse_yaml(manifest.at("scenario").get<std::string>(), file.string());
  for (const auto& entry : scenario.map)
    if (entry.key == "plant") return sim::read_plant(entry.value, file.parent_path()).shared_system();
  return plant::default_plant().shared_system();
}

}  // namespace

std::string SetPlan::mark() const {
  return sim::sha256(scenario_yaml + '\0' + domain_text + '\0' + std::to_string(runs_in_part()) + '\0' + sim::code_identity())
      .substr(0, 16);
}

std::optional<SetPart> part_in(const SetPlan& plan, const fs::path& folder, std::int64_t part) {
  const fs::path about = json_path(plan, folder, part), recordings = csv_path(plan, folder, part);
  if (!fs::exists(about) || !fs::exists(recordings)) return std::nullopt;
  try {
    const std::string text = sim::read_file(about), csv = sim::read_file(recordings);
    const Json json = Json::parse(text);
    if (json.at("mark") != plan.mark() || std::ssize(json.at("runs")) != plan.runs_of(part).count) return std::nullopt;
    SetPart result{.sha256 = sim::sha256(text)};
    std::size_t from = 0;
    for (const Json& run : json.at("runs")) {
      const auto bytes = run.at("bytes").get<std::size_t>();
      if (run.at("from_byte") != from || bytes > csv.size() - from || !is_run(std::string_view(csv).substr(from, bytes), run))
        return std::nullopt;
      from += bytes;
      result.failed += run.at("status") != "finished";
    }
    if (from != csv.size()) return std::nullopt;
    return result;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::optional<SetPart> make_part(const SetPlan& plan, const fs::path& folder, std::int64_t part, const std::function<bool()>& should_stop) {
  SetPart result;
  Json about{{"mark", plan.mark()}, {"runs", Json::array()}};
  std::string csv;
  const auto [first, count] = plan.runs_of(part);
  for (std::int64_t run = first; run < first + count; ++run) {
    const DrawnRun one = drawn_run(plan.scenario, plan.domain, run);
    sim::RunOptions options;
    options.should_stop = should_stop;
    const sim::RunResult made = sim::run(one.scenario, options);
    if (made.status == sim::RunStatus::stopped) return std::nullopt;
    const bool finished = made.status == sim::RunStatus::finished;
    result.failed += !finished;
    Json json{{"run", run},
              {"seed", one.scenario.seed},
              {"status", finished ? "finished" : "failed"},
              {"from_byte", csv.size()},
              {"bytes", made.recording_csv.size()},
              {"sha256", sim::sha256(made.recording_csv)},
              {"drawn", Json::object()}};
    for (const auto& [name, value] : one.drawn) json["drawn"][name] = value;
    json["effects"] = Json::array();
    const plant::Plant& plant = one.scenario.plant;
    for (const plant::EffectId e : plant.system().effects().ids())
      if (plant.is_on(e)) json["effects"].push_back(plant.system().effects()[e].name);
    about["runs"].push_back(std::move(json));
    csv += made.recording_csv;
  }
  const std::string text = about.dump(1) + "\n";
  result.sha256 = sim::sha256(text);
  fs::create_directories(folder / "runs");
  sim::write_file_whole(json_path(plan, folder, part), text);
  sim::write_file_whole(csv_path(plan, folder, part), csv);
  return result;
}

std::string manifest_of(const SetPlan& plan, const std::vector<SetPart>& parts) {
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
            {"runs", plan.runs},
            {"runs_in_part", plan.runs_in_part()},
            {"parts", Json::array()}};
  for (std::int64_t part = 0; part < std::ssize(parts); ++part) {
    const SetPart& one = parts[static_cast<std::size_t>(part)];
    json["parts"].push_back({{"file", part_name(plan, part) + ".json"}, {"sha256", one.sha256}, {"failed", one.failed}});
  }
  return json.dump(1) + "\n";
}

std::string set_in_hdf5(const SetPlan& plan, const fs::path& folder, const std::string& manifest) {
  Hdf5File file;
  const std::vector<std::string> names = column_names(plan);
  for (std::int64_t run = 0; run < plan.runs; ++run) {
    const sim::Recording recording = sim::read_recording(csv_path(plan, folder, run), plan.scenario.plant.system());
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
  file.text_attributes["/"]["manifest"] = manifest;
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

std::int64_t visit_set(const fs::path& path, const sim::Columns& columns_of_file, std::int64_t most,
                       const std::function<void(sim::Recording)>& visit) {
  if (!fs::is_directory(path)) {
    visit(sim::read_recording(path, columns_of_file));
    return 1;
  }
  const fs::path manifest = manifest_in(path);
  std::int64_t runs = 0;
  bool any = false;
  try {
    const Json json = json_of(manifest);
    const sim::Columns columns = sim::columns_of(*system_in(json, manifest));
    runs = json.at("runs").get<std::int64_t>();
    const auto runs_in_part = json.at("runs_in_part").get<std::int64_t>();
    if (runs_in_part < 1) throw sim::InputError({.file = manifest.string(), .key = "runs_in_part", .advice = "must be at least 1"});
    const std::int64_t wanted = std::min(most, runs);
    std::int64_t read = -1;
    fs::path file;
    Json about;
    for (std::int64_t n = 0; n < wanted; ++n) {
      const std::int64_t run = n * runs / wanted;  // below 2^63: both are at most a million
      if (const std::int64_t part = run / runs_in_part; part != read) {
        const Json& one = json.at("parts").at(static_cast<std::size_t>(part));
        file = path / one.at("file").get<std::string>();
        const std::string text = sim::read_file(file);
        if (sim::sha256(text) != one.at("sha256")) complain_of_hash(file);
        about = Json::parse(text);
        file.replace_extension(".csv");
        read = part;
      }
      const Json& one = about.at("runs").at(static_cast<std::size_t>(run % runs_in_part));
      if (one.at("status") != "finished") continue;
      visit(sim::parse_recording(recording_in(file, one), runs_in_part == 1 ? file.string() : file.string() + ", run " + number_of(run),
                                 columns));
      any = true;
    }
  } catch (const Json::exception& e) {
    complain_of_manifest(manifest, e);
  }
  if (!any) throw sim::InputError({.file = manifest.string(), .advice = "has no run that finished"});
  return runs;
}

}  // namespace sinew::model
