// SPDX-License-Identifier: Apache-2.0
#include "proof/case_file.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sinew::proof {
namespace {

using Json = nlohmann::ordered_json;
using Names = std::vector<std::string>;

constexpr std::initializer_list<Verdict> verdicts{Verdict::consistent, Verdict::missing_physics, Verdict::named_in_part,
                                                  Verdict::unexplained, Verdict::failed};

template <class Value>
Value one_of(std::initializer_list<Value> all, const std::string& text, const std::string& what) {
  const auto found = std::find_if(all.begin(), all.end(), [&](Value value) { return text_of(value) == text; });
  if (found == all.end()) throw std::runtime_error("no such " + what + ": " + text);
  return *found;
}

// null: a plant could not follow the recording to its end.
double number(const Json& value) { return value.is_null() ? std::nan("") : value.get<double>(); }

ReportedEffect read_effect(const Json& json) {
  ReportedEffect effect{.name = json.at("name"),
                        .probability = json.at("confidence"),
                        .strength = json.value("strength", ""),
                        .null_value = json.value("null", 0.0),
                        .parameters = {}};
  const Json parameters = json.value("parameters", Json::object());
  for (const auto& [name, of] : parameters.items())
    effect.parameters[name] = {number(of.at("value")), number(of.at("ci95").at(0)), number(of.at("ci95").at(1)), of.at("known")};
  return effect;
}

ReportedBaselines read_baselines(const Json& json) {
  ReportedBaselines baselines;
  const Json& bic = json.at("bic");
  baselines.bic_names = bic.at("effects").get<Names>();
  baselines.bic_weights = bic.value("weights", std::map<std::string, double>{});
  if (bic.contains("normalised_after")) baselines.bic_after = number(bic["normalised_after"]);
  for (const Json& terms : json.at("sindy").at("terms")) baselines.sindy_terms += terms.get<int>();
  baselines.sindy_after = number(json["sindy"].at("normalised_after"));
  baselines.gaussian_process_after = number(json.at("gaussian_process").at("normalised_after"));
  return baselines;
}

HeldOut read_held_out(const Json& result) {
  HeldOut error{.before = number(result.at("normalised_before")),
                .after = number(result.at("normalised_after")),
                .refit = {},
                .oracle = {}};
  if (result.contains("normalised_oracle")) error.refit = number(result["normalised_oracle"]);
  if (result.contains("oracle") && result["oracle"].contains("normalised")) error.oracle = number(result["oracle"]["normalised"]);
  return error;
}

// What the search noted on its way; nothing of it where the diagnosis failed.
void read_search(const Json& result, Reported& reported) {
  if (const auto noise = result.find("unrest"); noise != result.end()) {
    reported.process_noise_before = number(noise->at(0));
    reported.process_noise_after = number(noise->at(1));
  }
  if (const auto explanations = result.find("explanations"); explanations != result.end())
    reported.core_misfit = number(explanations->at(0).at("misfit"));
  const Json rounds = result.value("rounds", Json::array());
  for (const Json& round : rounds) reported.largest_gain = std::max(reported.largest_gain, number(round.at("gain")));
  if (!rounds.empty() && rounds[0].contains("candidates"))
    for (const Json& candidate : rounds[0]["candidates"]) reported.first_candidates.push_back({candidate.at(0), number(candidate.at(2))});
}

}  // namespace

std::string_view text_of(CaseFamily family) {
  switch (family) {
    case CaseFamily::clean:
      return "clean";
    case CaseFamily::catalogue:
      return "catalogue";
    case CaseFamily::other_form:
      return "other_form";
    case CaseFamily::pair:
      return "pair";
    case CaseFamily::triple:
      return "triple";
    case CaseFamily::outside:
      return "outside";
    case CaseFamily::removed:
      return "removed";
    case CaseFamily::unlike:
      return "unlike";
  }
  return "";
}

std::string_view text_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent:
      return "consistent";
    case Verdict::missing_physics:
      return "missing_physics";
    case Verdict::named_in_part:
      return "named_in_part";
    case Verdict::unexplained:
      return "unexplained";
    case Verdict::failed:
      return "failed";
  }
  return "";
}

Truth read_truth(const Json& answer) {
  Truth truth{.family = one_of(case_families, answer.at("family"), "family"),
              .variant = answer.at("variant"),
              .seed = answer.at("seed"),
              .effects = {}};
  for (const Json& effect : answer.at("effects"))
    truth.effects.push_back(
        {effect.at("name"), effect.at("place"), effect.at("parameters").get<std::map<std::string, double>>(), effect.value("form", "")});
  return truth;
}

Reported read_reported(const Json& result) {
  Reported reported;
  reported.verdict = one_of(verdicts, result.at("verdict"), "verdict");
  reported.why_failed = result.value("why", "");
  for (const Json& effect : result.at("effects")) reported.effects.push_back(read_effect(effect));
  reported.ambiguous_with = result.at("ambiguous_with").get<Names>();
  reported.cannot_be_seen = result.at("cannot_be_seen").get<Names>();
  for (const Json& law : result.value("laws", Json::array())) reported.laws.push_back({law.at("place"), law.at("law").at("entry")});
  for (const Json& apart : result.value("apart", Json::array()))
    reported.apart.push_back({apart.at("values").at(0).at("parameter"), apart.value("probability", 0.0)});
  reported.place = result.at("located").at("place");
  reported.places_alike = result["located"].value("or", Names{});
  if (result.contains("probability_of_nothing")) reported.probability_of_nothing = result["probability_of_nothing"].get<double>();
  reported.visibility = number(result.at("visibility"));
  reported.explained_share = number(result.value("explained_share", Json()));
  reported.objections = result.value("objections", Names{});
  reported.held_out = read_held_out(result);
  if (result.contains("baselines")) reported.baselines = read_baselines(result["baselines"]);
  reported.made_by = result.value("made_by", "");
  read_search(result, reported);
  return reported;
}

std::vector<Case> read_cases(const Json& answers, const Json& results) {
  std::vector<Case> cases;
  for (const auto& [id, answer] : answers.items())
    if (results.contains(id)) cases.push_back({id, read_truth(answer), read_reported(results[id])});
  return cases;
}

}  // namespace sinew::proof
