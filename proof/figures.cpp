// SPDX-License-Identifier: Apache-2.0
#include "proof/figures.h"

#include <algorithm>
#include <cmath>

#include "proof/forecasts.h"
#include "proof/judged.h"
#include "report/number.h"

namespace sinew::proof {
namespace {

using enum CaseFamily;
using Cases = std::vector<Case>;

std::string percent_words(double share) { return report::compact(100.0 * share, 1) + " %"; }
Goal at_least(double share) { return {share, HUGE_VAL, "at least " + percent_words(share)}; }
Goal at_most(double share) { return {-HUGE_VAL, share, "at most " + percent_words(share)}; }

// Of the cases that count, those that are good.
template <class Counts, class Good>
Share share_of(const Cases& cases, Counts&& counts, Good&& good) {
  Share share;
  for (const Case& one : cases)
    if (counts(one)) share.add(good(one));
  return share;
}
// Cases of these families in which there is something to see, or the answer said something.
auto shown_of(std::initializer_list<CaseFamily> families) {
  return [families](const Case& one) { return is_of(one, families) && !is_rightly_unseen(one); };
}
auto all_of(std::initializer_list<CaseFamily> families) {
  return [families](const Case& one) { return is_of(one, families); };
}
auto gives_right_names(int least) {
  return [least](const Case& one) { return right_names_given(one) >= least; };
}
bool names_something(const Case& one) { return !one.reported.effects.empty(); }
bool says_unknown_or_place(const Case& one) { return one.reported.verdict == Verdict::unexplained || place_is_right(one); }
bool is_misnamed_confidently(const Case& one) { return is_named_confidently(one.reported); }

Quantity median_of(const std::vector<double>& values, bool as_percent) { return {median(values), values.size(), as_percent}; }

// One effect of the catalogue is concealed, in the catalogue's form: it is the first that is named.
Figure right_name(const Cases& cases) {
  return {"one concealed effect: right name first", share_of(cases, shown_of({catalogue}), first_is_right), at_least(0.95)};
}

// The same, of the effect for which that share is lowest.
Figure least_recognised(const Cases& cases) {
  const std::map<std::string, Share> by_effect = right_by_effect(cases);
  Share lowest;
  std::vector<std::string> effects;
  for (const auto& [effect, share] : by_effect) {
    if (effects.empty() || share.value() < lowest.value()) lowest = share, effects.clear();
    if (share.value() == lowest.value()) effects.push_back(effect);
  }
  std::string names;
  for (const std::string& effect : effects) names += (names.empty() ? "" : ", ") + effect;
  if (effects.size() > 1 && effects.size() == by_effect.size()) names = "all are alike";
  const std::string what = by_effect.empty() ? "the effect that is recognised least"
                                             : "the effect of " + std::to_string(by_effect.size()) + " that is recognised least: " + names;
  return {what, lowest, at_least(0.8)};
}

// An effect of the catalogue is concealed in another form: its name comes first.
Figure right_name_of_other_form(const Cases& cases) {
  return {"same physics in another form: right name first", share_of(cases, shown_of({other_form}), first_is_right), at_least(0.85)};
}

// Nothing is concealed, and the answer is another.
Figure false_alarms(const Cases& cases) {
  const auto alarmed = [](const Case& one) { return one.reported.verdict != Verdict::consistent; };
  return {"nothing concealed: false alarms", share_of(cases, all_of({clean}), alarmed), at_most(0.02)};
}

// What is concealed has no name in the catalogue: the answer says so, or says the equation.
Figure unknown_outside(const Cases& cases) {
  return {"outside the catalogue: said to be unknown, or right equation", share_of(cases, shown_of({outside}), says_unknown_or_place),
          at_least(0.9)};
}
Figure unknown_removed(const Cases& cases) {
  return {"taken out of the catalogue: said to be unknown, or right equation", share_of(cases, shown_of({removed}), says_unknown_or_place),
          at_least(0.9)};
}

// It has no name, and the first name is given with a half or more.
Figure misnamed_outside(const Cases& cases) {
  return {"outside the catalogue: confidently misnamed", share_of(cases, shown_of({outside}), is_misnamed_confidently), at_most(0.05)};
}
Figure misnamed_removed(const Cases& cases) {
  return {"taken out of the catalogue: confidently misnamed", share_of(cases, shown_of({removed}), is_misnamed_confidently), at_most(0.05)};
}

// It has no name, and the equation that the answer says first is right.
Figure right_entry_without_name(const Cases& cases) {
  return {"outside or taken out of the catalogue: right equation first",
          share_of(cases, shown_of({outside, removed}), first_place_is_right), at_least(0.93)};
}

// In all families: some name, or that parts are not alike, is given with so much, and is wrong.
Figure wrong_with_half(const Cases& cases) {
  const auto wrong = [](const Case& one) { return has_wrong_answer_with(one, confident); };
  return {"all cases: a wrong name with 0.5 or more",
          share_of(
              cases, [](const Case&) { return true; }, wrong),
          at_most(0.03)};
}
Figure wrong_nearly_certain(const Cases& cases) {
  const auto wrong = [](const Case& one) { return has_wrong_answer_with(one, nearly_certain); };
  return {"all cases: a wrong name with 0.9 or more",
          share_of(
              cases, [](const Case&) { return true; }, wrong),
          at_most(0.005)};
}

// Two or three effects are concealed, and so many of them are named, in any order, whatever else is.
Figure both_of_two(const Cases& cases) {
  return {"two effects: both named", share_of(cases, all_of({pair}), gives_right_names(2)), at_least(0.8)};
}
Figure one_of_two(const Cases& cases) {
  return {"two effects: one or both named", share_of(cases, all_of({pair}), gives_right_names(1)), at_least(0.97)};
}
Figure all_of_three(const Cases& cases) {
  return {"three effects: all named", share_of(cases, all_of({triple}), gives_right_names(3)), at_least(0.6)};
}
Figure two_of_three(const Cases& cases) {
  return {"three effects: two or all named", share_of(cases, all_of({triple}), gives_right_names(2)), at_least(0.9)};
}

// The truth is among what was named and what is said to be alike: one effect of the catalogue, in any form.
Figure set_contains_truth(const Cases& cases) {
  Goal goal = at_least(0.92);
  goal.words = "95 ± 3 %";
  return {"the set that the answer names contains the truth", share_of(cases, shown_of({catalogue, other_form}), set_has_the_truth), goal};
}
Figure size_of_set(const Cases& cases) {
  std::vector<double> sizes;
  for (const Case& one : cases)
    if (shown_of({catalogue, other_form})(one)) sizes.push_back(static_cast<double>(answered_set(one.reported).size()));
  return {"median size of that set", median_of(sizes, false), {-HUGE_VAL, 2.0, "one or two"}};
}

// The equation that one concealed effect enters is said, first or among those that cannot be told apart.
Figure right_place(const Cases& cases) {
  return {"equation right, or among those said to be alike",
          share_of(cases, shown_of({catalogue, other_form, outside, removed}), place_is_right), at_least(0.97)};
}

// How many places are said there, that one and those: with all of them the figure above would always be reached.
Figure number_of_places(const Cases& cases) {
  double sum = 0.0, count = 0.0;
  for (const Case& one : cases) {
    if (!shown_of({catalogue, other_form, outside, removed})(one) || one.reported.place.empty()) continue;
    sum += 1.0 + static_cast<double>(one.reported.places_alike.size());
    ++count;
  }
  return {"mean number of equations that are said there",
          Quantity{sum / count, static_cast<std::size_t>(count)},
          {-HUGE_VAL, 2.0, "one or two"}};
}

// Calls for each parameter that was fitted of an effect that is rightly named in the catalogue's own form.
template <class Visit>
void for_parameters(const Cases& cases, Visit&& visit) {
  for (const Case& one : cases) {
    if (!is_of(one, {catalogue, pair, triple})) continue;
    for (const ReportedEffect& effect : one.reported.effects)
      for (const TrueEffect& true_effect : one.truth.effects)
        if (true_effect.name == effect.name)
          for (const auto& [name, parameter] : effect.parameters)
            if (const auto value = true_effect.parameters.find(name); value != true_effect.parameters.end() && !parameter.known)
              visit(effect, name, parameter, value->second);
  }
}

// How far a strength is off, in units of its true distance from where there is nothing of the effect.
Figure strength_error(const Cases& cases) {
  std::vector<double> errors;
  for_parameters(cases, [&](const ReportedEffect& effect, const std::string& name, const ReportedParameter& parameter, double truth) {
    if (name == effect.strength && truth != effect.null_value)
      errors.push_back(std::abs(parameter.value - truth) / std::abs(truth - effect.null_value));
  });
  return {"strength: median relative error", median_of(errors, true), {-HUGE_VAL, std::nextafter(0.1, 0.0), "under 10 %"}};
}

// The true value of a parameter lies in its interval.
Figure coverage(const Cases& cases) {
  Share covered;
  for_parameters(cases, [&](const ReportedEffect&, const std::string&, const ReportedParameter& parameter, double truth) {
    covered.add(truth >= parameter.lowest && truth <= parameter.highest);
  });
  return {"95 % intervals that cover the truth", covered, {0.92, 0.98, "92 to 98 %"}};
}

// Where something is named and the catalogue has it: of the reduction that the diagnosis reaches when told the true effects.
Figure share_of_refit(const Cases& cases) {
  std::vector<double> shares;
  for (const Case& one : cases)
    if (const HeldOut& error = one.reported.held_out; names_something(one))
      if (const auto share = share_of_reduction(error.before, error.after, error.refit)) shares.push_back(*share);
  return {"held-out error: median share of the reduction an oracle reaches (true effect, fitted strength)", median_of(shares, true),
          at_least(0.95)};
}

// Whatever was answered: of the reduction that the generator's own law reaches (oracle.h).
Figure share_of_oracle(const Cases& cases, CaseFamily family, const std::string& words) {
  return {words + ": held-out error, median share of the oracle's reduction", median_of(shares_of_oracle(cases, {family}), true),
          at_least(0.8)};
}

// Something is named, and the open-loop prediction of the held-out recording is worse for it.
Figure worse_than_before(const Cases& cases) {
  const auto worse = [](const Case& one) { return is_worse_than_before(one.reported.held_out); };
  return {"held-out error worse than before", share_of(cases, names_something, worse), at_most(0.01)};
}
// Of what has no name, whatever was answered.
Figure worse_without_name(const Cases& cases) {
  const auto worse = [](const Case& one) { return is_worse_than_before(one.reported.held_out); };
  return {"outside or taken out of the catalogue: held-out error worse than before", share_of(cases, shown_of({outside, removed}), worse),
          at_most(0.01)};
}

// forecasts.h.
Figure calibration_error(const Cases& cases) {
  const std::vector<Forecast> forecasts = forecasts_of(cases);
  const double error = expected_calibration_error(equal_count_bins(forecasts));
  return {"expected calibration error of the probabilities", Quantity{error, forecasts.size()}, {-HUGE_VAL, 0.05, "at most 0.05"}};
}

// Mean squared error of the probabilities of all names in a case (brier_score_of_cases), where BIC was put to the same cases.
Figure brier_beside_bic(const Cases& cases) {
  const Cases both = with_bic_weights(cases);
  const double by_bic = brier_score_of_cases_bic(both);
  return {"Brier score of a case, where BIC weights are there",
          Quantity{brier_score_of_cases(both), both.size()},
          {-HUGE_VAL, std::nextafter(by_bic, 0.0),
           both.empty() ? "less than that of BIC weights" : "less than " + report::significant(by_bic, 3) + ", that of BIC weights"}};
}

}  // namespace

std::size_t Figure::of() const {
  if (const auto* share = std::get_if<Share>(&measured)) return static_cast<std::size_t>(share->all);
  return std::get<Quantity>(measured).of;
}

double Figure::value() const {
  if (const auto* share = std::get_if<Share>(&measured)) return share->value();
  return std::get<Quantity>(measured).value;
}

std::map<std::string, Share> right_by_effect(const Cases& cases) {
  std::map<std::string, Share> right;
  for (const Case& one : cases)
    if (shown_of({catalogue})(one)) right[one.truth.effects.front().name].add(first_is_right(one));
  return right;
}

std::vector<double> shares_of_oracle(const Cases& cases, std::initializer_list<CaseFamily> families) {
  std::vector<double> shares;
  for (const Case& one : cases) {
    const HeldOut& error = one.reported.held_out;
    if (!is_of(one, families)) continue;
    if (const auto share = share_of_reduction(error.before, error.after, error.oracle)) shares.push_back(*share);
  }
  return shares;
}

std::vector<Figure> figures_of(const Cases& cases) {
  return {right_name(cases),
          least_recognised(cases),
          right_name_of_other_form(cases),
          false_alarms(cases),
          unknown_outside(cases),
          misnamed_outside(cases),
          unknown_removed(cases),
          misnamed_removed(cases),
          right_entry_without_name(cases),
          wrong_with_half(cases),
          wrong_nearly_certain(cases),
          both_of_two(cases),
          one_of_two(cases),
          all_of_three(cases),
          two_of_three(cases),
          set_contains_truth(cases),
          size_of_set(cases),
          right_place(cases),
          number_of_places(cases),
          strength_error(cases),
          coverage(cases),
          share_of_refit(cases),
          share_of_oracle(cases, outside, "outside the catalogue"),
          share_of_oracle(cases, removed, "taken out of the catalogue"),
          share_of_oracle(cases, other_form, "same physics in another form"),
          worse_than_before(cases),
          worse_without_name(cases),
          calibration_error(cases),
          brier_beside_bic(cases)};
}

}  // namespace sinew::proof
