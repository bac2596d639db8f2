// SPDX-License-Identifier: Apache-2.0
// Which free law (plant/laws.h) would account for what an explanation leaves, and what it would look like: every entry against every
// variable that it may depend on, and that less its slow part, by one linearised fit each.
//
//   log BF(f) = 1/2 b^T (G + 1/f^2)^-1 b - 1/2 log |1 + f^2 G|,   G = S^T P S,   b = S^T P r
//
// with S the whitened columns of the law's weights at nothing, P what the fit of everything else leaves of them (score.h), and f how
// large a law is believed to be, in the typical sizes of its entry: the one of a few that has most evidence. A curve has 24 knots,
// half-way between the quantiles of its variable and even steps, and a Gaussian prior that is smooth over a fifth of them.
//
// Source: MacKay 2003, Information Theory, Inference, and Learning Algorithms, chapter 28; Rasmussen, Williams 2006, Gaussian Processes for
// Machine Learning, section 2.7 (curves with a Gaussian prior beside parameters that are fitted).
#pragma once

#include "diagnose/explanation.h"
#include "plant/laws.h"

namespace sinew::diagnose {

// A law that is sought, its prior's size chosen; `weights` are those of the linearised fit.
struct LawCandidate {
  plant::Law law;
  double gain = 0.0;  // of log evidence, linearised
  Eigen::VectorXd weights;
};

// Every cell, or those that are wanted, by falling gain. A law of time is none: it would not come again. Those that the plant has are left
// out. `threads` do not change the result.
std::vector<LawCandidate> screen_laws(const Explanation& at, int threads, const std::function<bool(const plant::Law&)>& wanted = {});

// A law that an explanation has, with its knots where the explanation says that the data are, and nearly the same curve: what was begun
// from another path may have them elsewhere. No weights where it cannot be followed.
LawCandidate where_the_data_are(const Explanation& at, plant::EffectId law);

// A simple form that lies within a curve's band: at every knot within two deviations, which are never taken for less than a fiftieth of
// the curve's span (what is linear between knots is no closer to a smooth form).
struct ClosedForm {
  std::string words;  // "a line", "a parabola"
  double error;       // root mean square over the knots, as a share of the curve's span
};
// Of a constant and an amplitude times: x, x^2, x^3, |x|, and with a midpoint and a width or rate of their own tanh, softplus, exp, a step.
// By rising error.
std::vector<ClosedForm> forms_within(const std::vector<double>& knots, const std::vector<double>& values,
                                     const std::vector<double>& deviation);

}  // namespace sinew::diagnose
