// SPDX-License-Identifier: Apache-2.0
#include "proof/judged.h"

#include <algorithm>
#include <cmath>

#include "plant/contains.h"
#include "report/number.h"

namespace sinew::proof {
namespace {

constexpr std::string_view unlike_effect = "unlike";

std::vector<std::string> names_given(const Reported& reported) {
  std::vector<std::string> names;
  for (const ReportedEffect& effect : reported.effects) names.push_back(effect.name);
  return names;
}

std::string percent(double share) { return report::fixed(100.0 * share, 1) + " %"; }

// How much of the calibrated core's misfit an effect alone explains, as the first round of the search fitted it.
std::string explained_alone(const Reported& reported, const std::string& effect) {
  for (const Candidate& candidate : reported.first_candidates)
    if (candidate.name == effect && reported.core_misfit > 0.0)
      return effect + " alone explains " + percent(1.0 - std::max(0.0, candidate.misfit) / reported.core_misfit);
  return effect + " was not among the effects that were fitted";
}

std::string explained_by_names(const Reported& reported) {
  std::string text;
  for (const std::string& name : names_given(reported)) text += (text.empty() ? "" : " and ") + name;
  text += reported.effects.size() > 1 ? " explain " : " explains ";
  if (reported.explained_share > 0.995) return text + "all that can be seen in this recording";
  return text + percent(reported.explained_share) + " of the misfit, process noise of " +
         report::significant(reported.process_noise_after, 3) + " is left";
}

std::vector<std::string> why_without_name(const Reported& reported) {
  if (reported.objections.empty())
    return {"no name holds, process noise of " + report::significant(reported.process_noise_after, 3) + " is left"};
  std::vector<std::string> reasons;
  for (const std::string& objection : reported.objections) reasons.push_back("against what was found: " + objection);
  return reasons;
}

// The most probable of what is wrong and given with so much; empty if nothing is.
std::string wrong_answer_with(const Case& one, double least_probability) {
  std::string what;
  double most = 0.0;
  const auto ask = [&](const std::string& words, double probability, bool right) {
    if (right || probability < least_probability || probability <= most) return;
    what = words;
    most = probability;
  };
  for (const ReportedEffect& effect : one.reported.effects) ask(effect.name, effect.probability, is_right_name(one, effect.name));
  for (const ReportedApart& apart : one.reported.apart)
    ask("parts that differ in " + apart.quantity, apart.probability, contains(unlike_in(one.truth), apart.quantity));
  return what.empty() ? "" : what + " (" + report::fixed(most, 2) + ")";
}

std::string probability_of_first(const Reported& reported) {
  return reported.effects.empty() ? "" : " (" + report::fixed(reported.effects.front().probability, 2) + ")";
}

}  // namespace

std::vector<std::string> right_names(const Truth& truth) {
  std::vector<std::string> names;
  if (truth.family == CaseFamily::outside || truth.family == CaseFamily::removed) return names;
  for (const TrueEffect& effect : truth.effects)
    if (effect.name != unlike_effect) names.push_back(effect.name);
  return names;
}

std::vector<std::string> unlike_in(const Truth& truth) {
  std::vector<std::string> quantities;
  for (const TrueEffect& effect : truth.effects)
    if (effect.name == unlike_effect) quantities.push_back(effect.form);
  return quantities;
}

bool is_right_name(const Case& one, const std::string& name) { return contains(right_names(one.truth), name); }

int right_names_given(const Case& one) {
  const std::vector<std::string> given = names_given(one.reported);
  int right = 0;
  for (const std::string& name : right_names(one.truth)) right += contains(given, name);
  return right;
}

std::string first_said(const Reported& reported) {
  if (!reported.effects.empty()) return reported.effects.front().name;
  return reported.verdict == Verdict::consistent ? "(nothing)" : "(unknown)";
}

bool first_is_right(const Case& one) {
  const std::vector<std::string> right = right_names(one.truth);
  // Of several concealed effects any may come first.
  return contains(right, first_said(one.reported));
}

bool is_named_confidently(const Reported& reported) {
  return !reported.effects.empty() && reported.effects.front().probability >= confident;
}

bool is_said_unlike(const Reported& reported, const std::string& quantity) {
  return std::any_of(reported.apart.begin(), reported.apart.end(), [&](const ReportedApart& apart) { return apart.quantity == quantity; });
}

bool has_wrong_answer_with(const Case& one, double least_probability) { return !wrong_answer_with(one, least_probability).empty(); }

std::vector<std::string> answered_set(const Reported& reported) {
  std::vector<std::string> set = names_given(reported);
  set.insert(set.end(), reported.ambiguous_with.begin(), reported.ambiguous_with.end());
  return set;
}

bool set_has_the_truth(const Case& one) { return contains(answered_set(one.reported), one.truth.effects.front().name); }

bool has_nothing_to_see(const Case& one) {
  if (one.truth.family == CaseFamily::clean) return false;
  const bool said_by_name = one.reported.verdict == Verdict::consistent && one.truth.effects.size() == 1 &&
                            contains(one.reported.cannot_be_seen, one.truth.effects.front().name);
  return one.reported.visibility < invisible_below || said_by_name;
}

bool is_rightly_unseen(const Case& one) {
  return is_of(one, {CaseFamily::catalogue, CaseFamily::other_form, CaseFamily::outside, CaseFamily::removed, CaseFamily::unlike}) &&
         has_nothing_to_see(one) && one.reported.verdict == Verdict::consistent && one.reported.effects.empty();
}

bool first_place_is_right(const Case& one) { return one.reported.place == one.truth.effects.front().place; }

bool place_is_right(const Case& one) {
  return first_place_is_right(one) || contains(one.reported.places_alike, one.truth.effects.front().place);
}

std::optional<double> share_of_reduction(double before, double after, std::optional<double> reference) {
  if (!reference || !(before > *reference)) return std::nullopt;
  if (std::isnan(after)) return -HUGE_VAL;  // could not follow the recording: worse than any
  return (before - after) / (before - *reference);
}

bool is_worse_than_before(const HeldOut& error) { return !std::isnan(error.before) && !(error.after <= error.before); }

bool is_right(const Case& one) { return miss_of(one).empty(); }

std::string miss_of(const Case& one) {
  const Reported& reported = one.reported;
  const std::string first = first_said(reported), sure = probability_of_first(reported);
  if (is_rightly_unseen(one)) return "";
  const std::string wrong = wrong_answer_with(one, confident);
  switch (one.truth.family) {
    case CaseFamily::clean:
      return reported.verdict == Verdict::consistent ? "" : "false alarm";
    case CaseFamily::catalogue:
    case CaseFamily::other_form:
      if (!first_is_right(one)) return "named " + first + sure;
      return wrong.empty() ? "" : "confidently misnamed " + wrong;
    case CaseFamily::pair:
    case CaseFamily::triple: {
      const auto of = one.truth.effects.size();
      const int hits = right_names_given(one);
      return hits == static_cast<int>(of) ? "" : "found " + std::to_string(hits) + " of " + std::to_string(of) + ", first " + first;
    }
    case CaseFamily::unlike: {
      for (const std::string& quantity : unlike_in(one.truth))
        if (!is_said_unlike(reported, quantity)) return "not said that parts differ in " + quantity + ": " + first + sure;
      if (!wrong.empty()) return "confidently misnamed " + wrong;
      const auto names = right_names(one.truth);
      return right_names_given(one) == static_cast<int>(names.size()) ? "" : "not named " + names.front();
    }
    case CaseFamily::outside:
    case CaseFamily::removed:
      if (!wrong.empty()) return "confidently misnamed " + wrong;
      if (reported.verdict == Verdict::unexplained || place_is_right(one)) return "";
      return "neither unknown nor in the right place: " + first + sure;
  }
  return "";
}

std::string reason_of(const Case& one) {
  const Reported& reported = one.reported;
  if (reported.verdict == Verdict::failed) return reported.why_failed;
  std::vector<std::string> reasons;
  if (!reported.effects.empty()) reasons.push_back(explained_by_names(reported));
  const std::vector<std::string> given = names_given(reported);
  for (const std::string& name : right_names(one.truth)) {
    if (contains(given, name)) continue;
    reasons.push_back(explained_alone(reported, name));
    if (contains(answered_set(reported), name)) reasons.push_back("it is in the set of those that cannot be told apart");
  }
  if (!is_of(one, {CaseFamily::pair, CaseFamily::triple}) && given.empty() && reported.verdict == Verdict::unexplained)
    for (const std::string& reason : why_without_name(reported)) reasons.push_back(reason);
  std::string text;
  for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
  return text;
}

}  // namespace sinew::proof
