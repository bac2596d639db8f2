// SPDX-License-Identifier: Apache-2.0
// How probable a name is: its share of what was tried, times how often finds with such support are right.
//
//   p = share q,   log q/(1-q) = a_0 + a_1 log10(gain) + a_2 discrepancy_remains + a_3 open_loop + a_4 surrogate
//
// What a search finds is the best of what it tried: shares of the posterior say nothing of physics that was not tried, nor of what a
// linearised likelihood takes for certain. How often a find is right, concealed cases say, whose answer is known: q is a logistic map,
// fitted to these.
//
// Source: Platt 1999, Probabilistic outputs for support vector machines (logistic map of a score).
#pragma once

#include <array>

namespace sinew::diagnose {

struct Support {
  double share = 0.0;  // of the posterior, among what was tried in its place, times the share of the misfit that the answer explains
  double gain = 0.0;   // 2 log posterior ratio
  bool discrepancy_remains = false;  // the plant with all that was found still misses the recording by more than noise
  bool open_loop = false;            // found by open-loop simulation, or no constant
  bool surrogate = false;            // Parsimony: may stand in for physics in another form
};

inline constexpr std::size_t support_terms = 5;
// 1, log10(gain), and the three of yes or no as 1 and 0; gain within 1 and 10,000.
std::array<double, support_terms> terms_of(const Support& support);
double probability(const Support& support);

}  // namespace sinew::diagnose
