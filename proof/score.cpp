// SPDX-License-Identifier: Apache-2.0
#include "proof/score.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "proof/judged.h"

namespace sinew::proof {
namespace {

using enum CaseFamily;
using Cases = std::vector<Case>;

std::vector<std::string> names_of(const auto& effects) {
  std::vector<std::string> names;
  for (const auto& effect : effects) names.push_back(effect.name);
  return names;
}

bool has_one_effect(const Case& one) { return is_of(one, {catalogue, other_form, outside, removed}); }

std::map<std::string, EffectScore> by_effect(const Cases& cases) {
  std::map<std::string, EffectScore> effects;
  for (const auto& [effect, right] : right_by_effect(cases)) effects[effect].right = right;
  for (const Case& one : cases)
    if (one.truth.family == catalogue && is_rightly_unseen(one)) ++effects[one.truth.effects.front().name].hidden;
  return effects;
}

std::map<std::string, std::map<std::string, Share>> by_disturbance(const Cases& cases) {
  std::map<std::string, std::map<std::string, Share>> disturbances;
  for (const Case& one : cases)
    if (is_of(one, {clean, catalogue}) && !is_rightly_unseen(one))
      disturbances[one.truth.variant][std::string(text_of(one.truth.family))].add(is_right(one));
  return disturbances;
}

std::string stratum_of(double visibility) {
  constexpr std::array<double, 3> bounds{invisible_below, 20.0, 100.0};
  std::size_t at = 0;
  while (at < bounds.size() && visibility >= bounds[at]) ++at;
  return visibility_strata[at];
}

// Of what has no name: not confidently misnamed. Of one effect: it comes first.
std::map<std::string, std::map<std::string, Share>> strata(const Cases& cases) {
  std::map<std::string, std::map<std::string, Share>> families;
  for (const Case& one : cases) {
    if (one.truth.family == clean) continue;
    const bool right = is_of(one, {outside, removed})        ? !is_named_confidently(one.reported)
                       : is_of(one, {catalogue, other_form}) ? first_is_right(one)
                                                             : is_right(one);
    families[std::string(text_of(one.truth.family))][stratum_of(one.reported.visibility)].add(is_rightly_unseen(one) || right);
  }
  return families;
}

void add_answer(FamilyScore& score, const Case& one) {
  const Reported& reported = one.reported;
  if (reported.verdict == Verdict::failed)
    ++score.failed;
  else if (reported.effects.empty())
    ++(reported.verdict == Verdict::consistent ? score.nothing : score.unknown);
  else
    ++(first_is_right(one) ? score.right_first : score.wrong_first);
  score.wrong_confident += has_wrong_answer_with(one, confident);
  score.wrong_nearly_certain += has_wrong_answer_with(one, nearly_certain);
}

std::map<CaseFamily, FamilyScore> by_family(const Cases& cases) {
  std::map<CaseFamily, FamilyScore> families;
  for (const Case& one : cases) add_answer(families[one.truth.family], one);
  for (auto& [family, score] : families) score.shares_of_oracle = shares_of_oracle(cases, {family});
  return families;
}

std::string concealed_in(const Case& one) {
  switch (one.truth.family) {
    case clean:
      return "(nothing)";
    case other_form:
      return "other form: " + one.truth.effects.front().name;
    case outside:
      return "outside: " + one.truth.effects.front().name;
    case removed:
      return "removed: " + one.truth.effects.front().name;
    case unlike:
      return "unlike in " + one.truth.effects.front().form;
    default:
      return one.truth.effects.front().name;
  }
}

std::map<std::string, std::map<std::string, int>> confusion(const Cases& cases) {
  std::map<std::string, std::map<std::string, int>> said;
  for (const Case& one : cases)
    if (one.truth.family == clean || has_one_effect(one)) ++said[concealed_in(one)][first_said(one.reported)];
  return said;
}

std::vector<ConfidenceClass> confidence(const Cases& cases) {
  std::vector<ConfidenceClass> classes{{0.0, confident, {}}, {confident, 0.8, {}}, {0.8, 0.95, {}}, {0.95, 1.0, {}}};
  for (const Case& one : cases) {
    if (one.reported.effects.empty()) continue;
    std::size_t at = 0;
    while (at + 1 < classes.size() && one.reported.effects.front().probability >= classes[at].to) ++at;
    classes[at].right.add(first_is_right(one));
  }
  return classes;
}

Reliability reliability_of(const std::string& method, const std::vector<Forecast>& forecasts) {
  const std::vector<ReliabilityBin> bins = equal_count_bins(forecasts);
  return {.method = method,
          .forecasts = forecasts.size(),
          .brier = brier_score(forecasts),
          .log = log_score(forecasts),
          .calibration_error = expected_calibration_error(bins),
          .calibration_error_by_chance = calibration_error_by_chance(bins),
          .bins = bins};
}

// Beside BIC's weights Sinew's probabilities of the same cases.
std::vector<Reliability> reliability(const Cases& cases) {
  std::vector<Reliability> methods{reliability_of("Sinew", forecasts_of(cases))};
  const Cases both = with_bic_weights(cases);
  if (both.empty()) return methods;
  methods.push_back(reliability_of("Sinew, where BIC weights are there", forecasts_of(both)));
  methods.push_back(reliability_of("BIC weights", forecasts_of_bic(both)));
  return methods;
}

std::vector<Miss> misses(const Cases& cases) {
  std::vector<Miss> all;
  for (const Case& one : cases)
    if (!is_right(one))
      all.push_back({one.id, miss_of(one), reason_of(one), one.reported.visibility, one.reported.verdict, names_of(one.truth.effects),
                     names_of(one.reported.effects)});
  return all;
}

std::vector<Misplaced> misplaced(const Cases& cases) {
  std::vector<Misplaced> all;
  for (const Case& one : cases)
    if (has_one_effect(one) && !is_rightly_unseen(one) && !place_is_right(one))
      all.push_back({one.id, one.reported.place, one.truth.effects.front().place});
  return all;
}

Share place_said_first(const Cases& cases) {
  Share right;
  for (const Case& one : cases)
    if (has_one_effect(one) && !is_rightly_unseen(one)) right.add(first_place_is_right(one));
  return right;
}

int worse_for_all(const Cases& cases) {
  return static_cast<int>(std::count_if(cases.begin(), cases.end(), [](const Case& one) {
    const HeldOut& error = one.reported.held_out;
    return !one.reported.effects.empty() && !(error.after <= error.before) && error.refit && *error.refit > error.before;
  }));
}

void add_clean(Score& score, const Case& one) {
  ++score.clean;
  if (one.reported.verdict == Verdict::failed) return;
  score.largest_clean_gain = std::max(score.largest_clean_gain, one.reported.largest_gain);
  score.largest_clean_noise = std::max(score.largest_clean_noise, one.reported.process_noise_before);
}

void add_unlike(Score& score, const Case& one) {
  if (is_rightly_unseen(one)) return;
  const std::vector<std::string> differ = unlike_in(one.truth);
  for (const std::string& quantity : differ) score.said_unlike.add(is_said_unlike(one.reported, quantity));
  if (differ.empty()) score.wrongly_said_unlike.add(!one.reported.apart.empty());
}

void take_smaller(std::optional<std::uint64_t>& first, std::uint64_t seed) { first = std::min(first.value_or(seed), seed); }

}  // namespace

Score score_of(const Cases& cases) {
  Score score;
  score.cases = score.wanted = static_cast<int>(cases.size());
  for (const Case& one : cases) {
    score.invisible += is_rightly_unseen(one);
    ++score.programs[one.reported.made_by];
    take_smaller(one.truth.family == clean ? score.first_clean_seed : score.first_seed, one.truth.seed);
    if (one.truth.family == clean) add_clean(score, one);
    add_unlike(score, one);
  }
  score.figures = figures_of(cases);
  score.by_effect = by_effect(cases);
  score.by_disturbance = by_disturbance(cases);
  score.strata = strata(cases);
  score.by_family = by_family(cases);
  score.confusion = confusion(cases);
  score.confidence = confidence(cases);
  score.reliability = reliability(cases);
  score.said_nothing = said_nothing(cases);
  score.said_unknown = said_unknown(cases);
  score.methods = methods_of(cases);
  score.misses = misses(cases);
  score.misplaced = misplaced(cases);
  score.place_said_first = place_said_first(cases);
  score.worse_for_all = worse_for_all(cases);
  return score;
}

}  // namespace sinew::proof
