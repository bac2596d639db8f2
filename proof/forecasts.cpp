// SPDX-License-Identifier: Apache-2.0
#include "proof/forecasts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "plant/contains.h"
#include "proof/judged.h"

namespace sinew::proof {
namespace {

using Probabilities = std::map<std::string, double>;  // of the names that were given

Probabilities given_by_answer(const Case& one) {
  Probabilities given;
  for (const ReportedEffect& effect : one.reported.effects) given[effect.name] = effect.probability;
  return given;
}

// A name that BIC chose has been tried, so it has a weight.
Probabilities given_by_bic(const Case& one) {
  Probabilities given;
  for (const std::string& name : one.reported.baselines->bic_names) given[name] = one.reported.baselines->bic_weights.at(name);
  return given;
}

bool is_nothing(const Case& one) { return one.truth.family == CaseFamily::clean || has_nothing_to_see(one); }

void add_names(std::vector<Forecast>& forecasts, const Case& one, const Probabilities& given) {
  for (const auto& [name, probability] : given) forecasts.push_back({probability, is_right_name(one, name)});
}

double squared(double x) { return x * x; }

double brier_score_of_case(const Case& one, const Probabilities& given) {
  double sum = 0.0;
  for (const auto& [name, probability] : given) sum += squared(probability - (is_right_name(one, name) ? 1.0 : 0.0));
  for (const std::string& name : right_names(one.truth)) sum += given.contains(name) ? 0.0 : 1.0;
  return sum;
}

// Over a range that may be empty.
template <class Range, class Of>
double mean(const Range& all, Of&& of) {
  double sum = 0.0;
  for (const auto& one : all) sum += of(one);
  return all.empty() ? std::nan("") : sum / static_cast<double>(all.size());
}

// Mean over bins, weighted by their forecasts.
template <class Of>
double mean_of_bins(const std::vector<ReliabilityBin>& bins, Of&& of) {
  double sum = 0.0, all = 0.0;
  for (const ReliabilityBin& bin : bins) sum += bin.came_true.all * of(bin), all += bin.came_true.all;
  return sum / all;
}

ReliabilityBin bin_of(std::vector<Forecast>::const_iterator first, std::vector<Forecast>::const_iterator last) {
  const auto n = static_cast<double>(last - first);
  ReliabilityBin bin{first->probability, (last - 1)->probability, 0.0, 0.0, {}};
  for (; first != last; ++first) {
    bin.mean_probability += first->probability / n;
    bin.variance += first->probability * (1.0 - first->probability) / squared(n);
    bin.came_true.add(first->came_true);
  }
  return bin;
}

}  // namespace

std::vector<Forecast> forecasts_of(const std::vector<Case>& cases) {
  std::vector<Forecast> forecasts;
  for (const Case& one : cases) {
    add_names(forecasts, one, given_by_answer(one));
    const std::vector<std::string> differ = unlike_in(one.truth);
    for (const ReportedApart& apart : one.reported.apart)
      if (apart.probability > 0.0) forecasts.push_back({apart.probability, contains(differ, apart.quantity)});
    if (one.reported.verdict == Verdict::consistent && one.reported.probability_of_nothing)
      forecasts.push_back({*one.reported.probability_of_nothing, is_nothing(one)});
  }
  return forecasts;
}

std::vector<Forecast> forecasts_of_bic(const std::vector<Case>& cases) {
  std::vector<Forecast> forecasts;
  for (const Case& one : with_bic_weights(cases)) add_names(forecasts, one, given_by_bic(one));
  return forecasts;
}

Share said_nothing(const std::vector<Case>& cases) {
  Share right;
  for (const Case& one : cases)
    if (one.reported.verdict == Verdict::consistent) right.add(is_nothing(one));
  return right;
}

Share said_unknown(const std::vector<Case>& cases) {
  Share right;
  for (const Case& one : cases)
    if (one.reported.verdict == Verdict::unexplained && one.reported.effects.empty())
      right.add(is_of(one, {CaseFamily::outside, CaseFamily::removed}));
  return right;
}

double brier_score(const std::vector<Forecast>& forecasts) {
  return mean(forecasts, [](const Forecast& one) { return squared(one.probability - (one.came_true ? 1.0 : 0.0)); });
}

double log_score(const std::vector<Forecast>& forecasts) {
  return mean(forecasts, [](const Forecast& one) { return -std::log(one.came_true ? one.probability : 1.0 - one.probability); });
}

double brier_score_of_cases(const std::vector<Case>& cases) {
  return mean(cases, [](const Case& one) { return brier_score_of_case(one, given_by_answer(one)); });
}

double brier_score_of_cases_bic(const std::vector<Case>& cases) {
  return mean(with_bic_weights(cases), [](const Case& one) { return brier_score_of_case(one, given_by_bic(one)); });
}

std::vector<Case> with_bic_weights(const std::vector<Case>& cases) {
  std::vector<Case> with;
  for (const Case& one : cases)
    if (one.reported.baselines && !one.reported.baselines->bic_weights.empty()) with.push_back(one);
  return with;
}

std::vector<ReliabilityBin> equal_count_bins(std::vector<Forecast> forecasts, std::size_t bins) {
  std::sort(forecasts.begin(), forecasts.end(), [](const Forecast& a, const Forecast& b) { return a.probability < b.probability; });
  std::vector<ReliabilityBin> made;
  for (auto first = forecasts.cbegin(); first != forecasts.cend();) {
    const std::size_t left = static_cast<std::size_t>(forecasts.cend() - first), bins_left = std::max(bins, made.size() + 1) - made.size();
    auto last = first + static_cast<std::ptrdiff_t>((left + bins_left - 1) / bins_left);
    while (last != forecasts.cend() && last->probability == (last - 1)->probability) ++last;
    made.push_back(bin_of(first, last));
    first = last;
  }
  return made;
}

double expected_calibration_error(const std::vector<ReliabilityBin>& bins) {
  return mean_of_bins(bins, [](const ReliabilityBin& bin) { return std::abs(bin.mean_probability - bin.came_true.value()); });
}

double calibration_error_by_chance(const std::vector<ReliabilityBin>& bins) {
  // Mean distance of a normal deviate from its mean, for each bin's share.
  return mean_of_bins(bins, [](const ReliabilityBin& bin) { return std::sqrt(2.0 / std::numbers::pi * bin.variance); });
}

}  // namespace sinew::proof
