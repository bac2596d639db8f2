// SPDX-License-Identifier: Apache-2.0
#include "proof/methods.h"

#include <algorithm>

#include "plant/contains.h"
#include "proof/forecasts.h"
#include "proof/judged.h"

namespace sinew::proof {
namespace {

using enum CaseFamily;
using Cases = std::vector<Case>;

// What one method made of one case.
struct Answered {
  std::vector<std::string> names;
  bool is_confident = false;  // of the first name; a method without probabilities is always
  std::optional<double> after;
};

Answered by_sinew(const Case& one) {
  Answered answered{{}, is_named_confidently(one.reported), one.reported.held_out.after};
  for (const ReportedEffect& effect : one.reported.effects) answered.names.push_back(effect.name);
  return answered;
}
// Where BIC's fit cannot be used, nothing is gained by it.
Answered by_bic(const Case& one) {
  const ReportedBaselines& baselines = *one.reported.baselines;
  return {baselines.bic_names, true, baselines.bic_after.value_or(one.reported.held_out.before)};
}

std::optional<double> value_of(const Share& share) { return share.all > 0 ? std::optional(share.value()) : std::nullopt; }

// Of the cases of these families, those of which `good` is true.
template <class Good>
std::optional<double> share_of(const Cases& cases, std::initializer_list<CaseFamily> families, Good&& good) {
  Share share;
  for (const Case& one : cases)
    if (is_of(one, families) && !has_nothing_to_see(one)) share.add(good(one));
  return value_of(share);
}

// A reference that is hardly better than the plant as given makes any share.
template <class After>
std::optional<double> median_reduction(const Cases& cases, After&& after) {
  constexpr double least_ratio = 1.1;
  std::vector<double> shares;
  for (const Case& one : cases) {
    const HeldOut& error = one.reported.held_out;
    if (!error.refit || !(error.before > least_ratio * *error.refit)) continue;
    if (const auto share = share_of_reduction(error.before, after(one), error.refit)) shares.push_back(*share);
  }
  return shares.empty() ? std::nullopt : std::optional(median(shares));
}

using By = Answered (*)(const Case&);

bool is_first_right(By by, const Case& one) {
  const Answered answered = by(one);
  return !answered.names.empty() && answered.names.front() == one.truth.effects.front().name;
}
bool is_misnamed(By by, const Case& one) {
  const Answered answered = by(one);
  return answered.is_confident && !answered.names.empty();
}
bool are_all_named(By by, const Case& one) {
  const Answered answered = by(one);
  return std::all_of(one.truth.effects.begin(), one.truth.effects.end(),
                     [&](const TrueEffect& effect) { return contains(answered.names, effect.name); });
}

using Methods = std::map<std::string, std::optional<double>>;

// Methods that name effects.
template <class Of>
Methods by_naming(Of&& of) {
  return {{std::string(sinew_method), of(by_sinew)}, {"BIC", of(by_bic)}, {"SINDy", {}}, {"Gaussian process", {}}};
}

MethodRow first_right_row(const Cases& cases, const std::string& what, CaseFamily family) {
  return {what, by_naming([&](By by) { return share_of(cases, {family}, [by](const Case& one) { return is_first_right(by, one); }); })};
}

MethodRow alarms_row(const Cases& cases) {
  MethodRow row{"nothing concealed: false alarms",
                by_naming([&](By by) { return share_of(cases, {clean}, [by](const Case& one) { return !by(one).names.empty(); }); })};
  row.by_method["SINDy"] = share_of(cases, {clean}, [](const Case& one) { return one.reported.baselines->sindy_terms > 0; });
  return row;
}

MethodRow misnamed_row(const Cases& cases) {
  return {"outside or taken out of the catalogue: misnamed", by_naming([&](By by) {
            return share_of(cases, {outside, removed}, [by](const Case& one) { return is_misnamed(by, one); });
          })};
}

MethodRow all_named_row(const Cases& cases) {
  return {"two effects: both named", by_naming([&](By by) {
            Share share;  // whatever d' is
            for (const Case& one : cases)
              if (one.truth.family == pair) share.add(are_all_named(by, one));
            return value_of(share);
          })};
}

MethodRow reductions_row(const Cases& cases) {
  const auto of = [&](auto&& after) { return median_reduction(cases, after); };
  return {"held-out error: median share of the reduction that an oracle reaches",
          {{std::string(sinew_method), of([](const Case& one) { return *by_sinew(one).after; })},
           {"BIC", of([](const Case& one) { return *by_bic(one).after; })},
           {"SINDy", of([](const Case& one) { return one.reported.baselines->sindy_after; })},
           {"Gaussian process", of([](const Case& one) { return one.reported.baselines->gaussian_process_after; })}}};
}

// Of cases that have BIC weights.
MethodRow brier_row(const Cases& weighted) {
  MethodRow row{"Brier score of a case (all names)", by_naming([](By) { return std::optional<double>(); }), false};
  row.by_method[std::string(sinew_method)] = brier_score_of_cases(weighted);
  row.by_method["BIC"] = brier_score_of_cases_bic(weighted);
  return row;
}

}  // namespace

std::vector<MethodRow> methods_of(const Cases& cases) {
  Cases put_to_all;
  for (const Case& one : cases)
    if (one.reported.baselines) put_to_all.push_back(one);
  if (put_to_all.empty()) return {};
  std::vector<MethodRow> rows{first_right_row(put_to_all, "one concealed effect: right name first", catalogue),
                              first_right_row(put_to_all, "same physics in another form: right name first", other_form),
                              alarms_row(put_to_all),
                              misnamed_row(put_to_all),
                              all_named_row(put_to_all),
                              reductions_row(put_to_all)};
  if (const Cases weighted = with_bic_weights(put_to_all); !weighted.empty()) rows.push_back(brier_row(weighted));
  return rows;
}

}  // namespace sinew::proof
