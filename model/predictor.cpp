// SPDX-License-Identifier: Apache-2.0
#include "model/predictor.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "model/task_json.h"
#include "sim/manifest.h"
#include "sim/text.h"

namespace sinew::model {
namespace {

using Said = nlohmann::ordered_json;

// Over all that is said, the checksum itself left out.
std::string checksum_of(Said json) {
  json.erase("sha256");
  return sim::sha256(json.dump());
}

std::string all_names() {
  std::string names;
  for (const PredictorKind& kind : predictor_kinds()) names += (names.empty() ? "" : ", ") + std::string(kind.name);
  return names;
}

constexpr const char *trust_attribute = "sinew_trust", *visited_path = "/sinew_trust/visited";

// Over what the root says otherwise, and over what is said here.
std::string checksum_of_trust(const Hdf5File& file, Said json) {
  json.erase("sha256");
  std::string bytes = json.dump();
  for (const auto& [name, text] : file.text_attributes.at("/"))
    if (name != trust_attribute) bytes += name + text;
  if (const auto visited = file.arrays.find(visited_path); visited != file.arrays.end())
    for (const double value : visited->second.values) {
      const auto kept = static_cast<float>(value);
      bytes.append(reinterpret_cast<const char*>(&kept), sizeof kept);
    }
  return sim::sha256(bytes);
}

void put_trust(Hdf5File& file, const AboutPredictor& about) {
  if (!about.intervals && !about.region) return;
  Said json;
  if (about.intervals) json["intervals"] = json_of(*about.intervals);
  if (about.region) {
    json["region"] = json_of(*about.region);
    file.arrays[visited_path] = visited_of(*about.region);
  }
  json["sha256"] = checksum_of_trust(file, json);
  file.text_attributes["/"][trust_attribute] = json.dump();
}

void find_trust(const Hdf5File& file, const std::string& name, AboutPredictor& about) {
  const auto root = file.text_attributes.find("/");
  if (root == file.text_attributes.end() || !root->second.count(trust_attribute)) return;
  try {
    const Said json = Said::parse(root->second.at(trust_attribute));
    if (json.at("sha256") != checksum_of_trust(file, json))
      complain(name, trust_attribute, json.at("sha256"), "is not that of what is in the file: intervals or description were changed");
    if (json.contains("intervals")) about.intervals = intervals_of_json(json.at("intervals"), name);
    if (!json.contains("region")) return;
    const auto visited = file.arrays.find(visited_path);
    if (visited == file.arrays.end()) complain(name, visited_path, "", "is missing");
    about.region = trained_region_of_json(json.at("region"), visited->second, about.task, name);
  } catch (const Said::exception& e) {
    complain(name, trust_attribute, "", std::string("is no description of intervals: ") + e.what());
  }
}

void begin_at(Predictor& predictor, const Series& series, const Series* history) {
  predictor.begin(history ? *history : part_of(series, 0, 1));
}

}  // namespace

std::string kind_named_in(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  const auto root = file.text_attributes.find("/");
  if (root == file.text_attributes.end()) return unsaid.method;
  if (const auto kind = root->second.find("sinew_kind"); kind != root->second.end()) return kind->second;
  const auto said = root->second.find("sinew");
  if (said == root->second.end()) return unsaid.method;
  const Said json = Said::parse(said->second, nullptr, false);
  if (!json.is_object() || !json.contains("method") || !json.at("method").is_string())
    complain(name, "sinew", "", "is no description of a predictor");
  return json.at("method");
}

Vector<double> rollout(Predictor& predictor, const Series& series, const Series* history) {
  Vector<double> y(series.samples());
  y(0) = series.y(0);
  begin_at(predictor, series, history);
  for (Index k = 1; k < series.samples(); ++k) y(k) = predictor.step(series.v.col(k));
  return y;
}

Vector<double> one_step_ahead(Predictor& predictor, const Series& series, const Series* history) {
  Vector<double> y(series.samples());
  y(0) = series.y(0);
  begin_at(predictor, series, history);
  for (Index k = 1; k < series.samples(); ++k)
    y(k) = series.is_measured(k - 1) ? predictor.step(series.v.col(k), series.y(k - 1)) : predictor.step(series.v.col(k));
  return y;
}

std::vector<std::string> predictor_names() {
  std::vector<std::string> names;
  for (const PredictorKind& kind : predictor_kinds()) names.emplace_back(kind.name);
  return names;
}

const PredictorKind& predictor_kind(std::string_view name) {
  for (const PredictorKind& kind : predictor_kinds())
    if (kind.name == name) return kind;
  throw std::invalid_argument("there is no predictor " + std::string(name) + "; there are " + all_names());
}

void check_updates(const PredictorKind& kind, std::optional<Index> updates) {
  if (!updates || kind.counts_updates) return;
  throw sim::InputError({.file = "",
                         .key = "--updates",
                         .value = std::to_string(*updates),
                         .advice = "is for predictors that count updates; " + std::string(kind.name) +
                                   " counts epochs, in a file of --settings, or is not trained in steps"});
}

TrainingFile read_training(const std::filesystem::path& file) {
  const sim::YamlValue root = sim::read_yaml(file);
  sim::YamlMap map(root);
  TrainingFile result;
  for (const PredictorKind& kind : predictor_kinds())
    if (const auto* given = map.find(kind.name)) result.given.emplace(kind.name, *given);
  map.finish();
  for (const PredictorKind& kind : predictor_kinds())
    if (result.has(kind.name)) static_cast<void>(kind.settings_text(result));
  return result;
}

std::unique_ptr<Predictor> read_predictor(const std::filesystem::path& path, const Unsaid& unsaid) {
  const std::string name = path.string();
  const Hdf5File file = parse_hdf5(sim::read_file(path), name);
  const std::string kind_name = kind_named_in(file, name, unsaid);
  for (const PredictorKind& kind : predictor_kinds())
    if (kind.name == kind_name) {
      std::unique_ptr<Predictor> predictor = kind.load(file, name, unsaid);
      find_trust(file, name, predictor->about());
      return predictor;
    }
  if (!kind_name.empty()) complain(name, "sinew", kind_name, "is no kind of predictor of this version; there are " + all_names());
  return predictor_kind("published").load(file, name, unsaid);  // says what a file of Keras lacks
}

std::string bytes_of(const Predictor& predictor, Layout layout) {
  Hdf5File file = predictor.save(layout);
  put_trust(file, predictor.about());
  return to_bytes(file);
}

Hdf5File described_file(const AboutPredictor& about, const std::string& own_json) {
  Said json{{"format", 1}, {"case", about.task.paper_case}, {"method", about.kind}, {"sample_period_s", period_s}};
  json.update(json_of(about.task));
  json["trained_on"] = about.trained_on;
  if (about.arx) json["arx"] = json_of(*about.arx);
  json["predictor"] = Said::parse(own_json);
  json["made_by"] = "sinew " + sim::this_build().version;
  json["sha256"] = checksum_of(json);
  Hdf5File file;
  file.text_attributes["/"]["sinew"] = json.dump();
  return file;
}

AboutPredictor read_description(const Hdf5File& file, const std::string& name, const Unsaid& unsaid, std::string& own_json) {
  try {
    const Said json = Said::parse(file.text_attributes.at("/").at("sinew"));
    AboutPredictor about;
    about.task = task_of_json(json, name);
    about.kind = json.at("method");
    about.trained_on = json.value("trained_on", "");
    if (json.contains("arx")) about.arx = linear_of_json(json.at("arx"), about.task, name);
    own_json = json.at("predictor").dump();
    if (json.at("sha256") != checksum_of(json)) complain(name, "sha256", json.at("sha256"), "is not that of what is in the file");
    if (unsaid.task) complain_unless_same(name, about.task, *unsaid.task);
    return about;
  } catch (const Said::exception& e) {
    complain(name, "sinew", "", std::string("is no description of a predictor: ") + e.what());
  }
}

}  // namespace sinew::model
