// SPDX-License-Identifier: Apache-2.0
#include "diagnose/confidence.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sinew::diagnose {
namespace {

// Printed by tools/fit_confidence; docs/diagnosis.md says of which cases.
constexpr std::array<double, support_terms> weights{-0.59, 1.25, -4.56, -2.12};

// Of physics that was not tried, and does the same with nothing that is hard to believe. Any between 1e-4 and 1e-2 does nearly as well on
// the concealed cases in results/ (tools/fit_confidence --belief).
constexpr double odds_of_untried = 1e-3;
constexpr double most_unbelieved = 100.0;  // larger is no different, and its exponential a number

constexpr double least_left = 1e-3;  // by the formula of a form of the same physics

}  // namespace

std::array<double, support_terms> terms_of(const Support& support) {
  return {1.0, std::log10(std::clamp(support.gain, 1.0, 1e4)), std::min(support.faint, 2.0), support.law_beside ? 1.0 : 0.0};
}

double probability(const Support& support) {
  const auto terms = terms_of(support);
  const double logit = std::inner_product(terms.begin(), terms.end(), weights.begin(), 0.0);
  const double believable = 1.0 / (1.0 + odds_of_untried * std::exp(0.5 * std::min(support.unbelieved, most_unbelieved)));
  return believable * std::clamp(support.share, 0.0, 1.0) / (1.0 + std::exp(-logit));
}

std::vector<double> probabilities_of_forms(const std::vector<double>& left) {
  std::vector<double> result;
  double all = 1.0;  // physics without a name
  for (const double share : left) {
    const double density = 1.0 / (std::clamp(share, least_left, 1.0) * std::log(1.0 / least_left));
    result.push_back(density / static_cast<double>(left.size()));
    all += result.back();
  }
  for (double& p : result) p /= all;
  return result;
}

}  // namespace sinew::diagnose
