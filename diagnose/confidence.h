// SPDX-License-Identifier: Apache-2.0
// How probable a find is, a name or that parts are not alike: its share of what was tried, times how often finds with such support are
// right.
//
//   p = share q / (1 + e exp(d²/2)),   log q/(1-q) = a_0 + a_1 log10(gain) + a_2 faint + a_3 (a law stands beside it)
//
// What a search finds is the best of what it tried: shares of the posterior say nothing of physics that was not tried, nor of what a
// linearised likelihood takes for certain. How often a find is right, concealed cases say, whose answer is known: q is a logistic map,
// fitted to these. An effect that stands in for physics that was not tried is seldom as strong as where it acts itself: so `faint`; and it
// seldom does all of the work: what it leaves takes a law without a name. And it may take values that no one believes: physics that was not
// tried, and would explain as much by values that are believed, has the odds e before the recording and e exp(d²/2) after it.
//
// Source: Platt 1999, Probabilistic outputs for support vector machines (logistic map of a score).
#pragma once

#include <array>
#include <vector>

namespace sinew::diagnose {

struct Support {
  double share = 0.0;       // of the posterior, among what was tried in its place, times the share of the misfit that the answer explains
  double gain = 0.0;        // 2 log posterior ratio
  double faint = 0.0;       // decades by which it is weaker than is typical of it; 0 where it is not, or has no strength that is known
  bool law_beside = false;  // in the answer, that is no form of it
  double unbelieved = 0.0;  // d²: squares of its quantities' deviations from what is believed of them; without its strength
};

inline constexpr std::size_t support_terms = 4;
// 1, log10(gain), faint, law_beside; gain within 1 and 10,000, faint at most 2.
std::array<double, support_terms> terms_of(const Support& support);
double probability(const Support& support);
inline constexpr double doubtful_below = 0.5;  // a name is not stated as a fact

// Of each of the names whose form a law could be, that it is; the rest is that it is physics without a name. As likely as not before
// anything is known, and all names alike. `left`: of the misfit, the share that the formula of the catalogue leaves alone, at most 1. A
// form of the same physics is near it, any order of magnitude alike, down to a thousandth; the formula of other physics leaves any share
// alike.
std::vector<double> probabilities_of_forms(const std::vector<double>& left);

}  // namespace sinew::diagnose
