// SPDX-License-Identifier: Apache-2.0
#include "hil/replay.h"

#include <nlohmann/json.hpp>

#include "hil/wire_log.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::hil {

Replayed replay_session(const std::filesystem::path& folder) {
  const std::filesystem::path json_file = folder / "session.json";
  Replayed replayed;
  const std::string json_text = sim::read_file(json_file);
  nlohmann::json json;
  SessionSettings settings;
  std::string limb;
  std::int64_t ticks = 0, stops_at = 0;  // the question whether to stop; 0: not written, by versions before
  bool stopped = false;
  try {
    json = nlohmann::json::parse(json_text);
    settings.session = json.at("session");
    settings.clear_trip = json.at("clear_trip");
    settings.allow_overruns = json.at("allow_overruns");
    settings.real_time_priority = json.value("real_time_priority", false);
    if (json.contains("time_zero_s")) settings.time_zero_s = json["time_zero_s"].get<double>();
    limb = json.at("limb");
    ticks = json.at("ticks");
    stopped = json.at("status") == "stopped";
    stops_at = json.value("asked_to_stop", std::int64_t{0});
    for (const auto& [name, hash] : json.at("sha256").items()) {
      if (name.find('/') != std::string::npos)
        throw sim::InputError({.file = json_file.string(), .key = name, .advice = "names a file elsewhere"});
      replayed.stored[name] = sim::read_file(folder / name);
      if (sim::sha256(replayed.stored[name]) != hash.get<std::string>())
        throw sim::InputError(
            {.file = (folder / name).string(), .advice = "is not as the session wrote it: its hash in session.json is another"});
    }
    if (!replayed.stored.contains("wire.bin") || !replayed.stored.contains("scenario.yaml") || !replayed.stored.contains("recording.csv"))
      throw sim::InputError({.file = json_file.string(), .key = "sha256", .advice = "must name wire.bin, scenario.yaml and recording.csv"});
  } catch (const nlohmann::json::exception& e) {
    throw sim::InputError({.file = json_file.string(), .advice = std::string("is no session.json of `sinew hil`: ") + e.what()});
  }
  const sim::Scenario scenario = sim::parse_scenario(replayed.stored["scenario.yaml"], folder / "scenario.yaml");
  if (replayed.stored.contains("twin.yaml")) settings.twin = sim::read_plant_file(folder / "twin.yaml");
  std::int64_t asked = 0;
  if (stopped) settings.should_stop = [&](std::int64_t tick) { return stops_at > 0 ? ++asked >= stops_at : tick + 1 >= ticks; };
  ReplayLink link(replayed.stored["wire.bin"], (folder / "wire.bin").string());
  replayed.result = run_session(scenario, link, settings);
  if (!link.at_end()) throw ReplayDiffers(folder.string() + ": the session ended before its log");
  replayed.files = replayed.stored;
  replayed.files["recording.csv"] = replayed.result.recording_csv;
  if (replayed.stored.contains("timed.csv")) replayed.files["timed.csv"] = sim::to_csv(replayed.result.timed);
  replayed.files["session.json"] = session_json(scenario, settings, replayed.result, limb, replayed.files);
  replayed.stored["session.json"] = json_text;
  return replayed;
}

}  // namespace sinew::hil
