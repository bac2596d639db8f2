// SPDX-License-Identifier: Apache-2.0
#include "proof/score_files.h"

namespace sinew::proof {
namespace {

using Json = nlohmann::ordered_json;

Json right_of(const Share& share) { return {{"right", share.good}, {"of", share.all}}; }
Json interval_json(const Share& share) { return {share.interval().lowest, share.interval().highest}; }

Json figure_json(const Figure& figure) {
  Json json{{"what", figure.what}};
  if (const auto* share = std::get_if<Share>(&figure.measured)) {
    json["good"] = share->good;
    json["of"] = share->all;
    json["share"] = share->all > 0 ? Json(share->value()) : Json();
    json["interval"] = interval_json(*share);
  } else {
    json["value"] = figure.value();
    json["of"] = figure.of();
  }
  json["goal"] = figure.goal.words;
  json["reached"] = figure.reached();
  return json;
}

Json family_json(const FamilyScore& family) {
  Json json{{"right_first", family.right_first},
            {"wrong_first", family.wrong_first},
            {"unknown", family.unknown},
            {"nothing", family.nothing},
            {"failed", family.failed},
            {"wrong_confident", family.wrong_confident},
            {"wrong_nearly_certain", family.wrong_nearly_certain}};
  json["oracle_share"] = family.shares_of_oracle.empty() ? Json() : Json(median(family.shares_of_oracle));
  json["oracle_of"] = family.shares_of_oracle.size();
  return json;
}

Json reliability_json(const Reliability& one) {
  Json json{{"method", one.method},
            {"forecasts", one.forecasts},
            {"brier", one.brier},
            {"log", one.log},
            {"calibration_error", one.calibration_error},
            {"calibration_error_by_chance", one.calibration_error_by_chance},
            {"bins", Json::array()}};
  for (const ReliabilityBin& bin : one.bins)
    json["bins"].push_back({{"from", bin.lowest},
                            {"to", bin.highest},
                            {"mean_probability", bin.mean_probability},
                            {"came_true", bin.came_true.good},
                            {"of", bin.came_true.all},
                            {"interval", interval_json(bin.came_true)}});
  return json;
}

Json method_json(const MethodRow& row) {
  const auto value = [](const std::optional<double>& of) { return of ? Json(*of) : Json(); };
  const std::string sinew(sinew_method);
  Json json{{"what", row.what}, {sinew, value(row.by_method.at(sinew))}};
  for (const auto& [method, of] : row.by_method)
    if (method != sinew) json[method] = value(of);
  return json;
}

void add_tables(Json& json, const Score& score) {
  for (const char* part : {"by_effect", "by_disturbance", "strata", "by_family", "confusion"}) json[part] = Json::object();
  for (const bool shown : {true, false})  // those that never show come last
    for (const auto& [effect, of] : score.by_effect)
      if ((of.right.all > 0) == shown) json["by_effect"][effect] = {{"right", of.right.good}, {"of", of.right.all}, {"hidden", of.hidden}};
  for (const auto& [variant, families] : score.by_disturbance)
    for (const auto& [family, share] : families) json["by_disturbance"][variant][family] = right_of(share);
  for (const auto& [family, levels] : score.strata)
    for (const auto& [level, share] : levels) json["strata"][family][level] = {share.good, share.all};
  for (const auto& [family, of] : score.by_family) json["by_family"][std::string(text_of(family))] = family_json(of);
  for (const auto& [truth, given] : score.confusion)
    for (const auto& [answer, count] : given) json["confusion"][truth][answer] = count;
}

void add_probabilities(Json& json, const Score& score) {
  for (const char* part : {"confidence", "reliability"}) json[part] = Json::array();
  for (const ConfidenceClass& one : score.confidence)
    json["confidence"].push_back({{"from", one.from}, {"to", one.to}, {"right", one.right.good}, {"of", one.right.all}});
  for (const Reliability& one : score.reliability) json["reliability"].push_back(reliability_json(one));
  json["said_nothing"] = right_of(score.said_nothing);
  json["said_unknown"] = right_of(score.said_unknown);
}

void add_lists(Json& json, const Score& score) {
  for (const char* part : {"misses", "misplaced"}) json[part] = Json::array();
  for (const Miss& miss : score.misses)
    json["misses"].push_back({{"id", miss.id},
                              {"why", miss.why},
                              {"reason", miss.reason},
                              {"visibility", miss.visibility},
                              {"verdict", text_of(miss.verdict)},
                              {"truth", miss.truth},
                              {"named", miss.named}});
  for (const Misplaced& one : score.misplaced) json["misplaced"].push_back({{"id", one.id}, {"said", one.said}, {"truth", one.truth}});
}

}  // namespace

Json score_json(const Score& score) {
  Json json{{"cases", score.cases}, {"invisible", score.invisible}};
  add_tables(json, score);
  json["figures"] = Json::array();
  for (const Figure& figure : score.figures) json["figures"].push_back(figure_json(figure));
  add_probabilities(json, score);
  json["worse_for_all"] = score.worse_for_all;
  json["place_said_first"] = right_of(score.place_said_first);
  add_lists(json, score);
  json["programs"] = score.programs;
  json["clean"] = {{"cases", score.clean}, {"largest_gain", score.largest_clean_gain}, {"largest_unrest", score.largest_clean_noise}};
  json["baselines"] = Json::array();
  for (const MethodRow& row : score.methods) json["baselines"].push_back(method_json(row));
  if (score.first_clean_seed) json["first_clean_seed"] = *score.first_clean_seed;
  if (score.first_seed) json["first_seed"] = *score.first_seed;
  json["wanted"] = score.wanted;
  return json;
}

}  // namespace sinew::proof
