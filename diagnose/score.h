// SPDX-License-Identifier: Apache-2.0
// The score test: what would each effect of the catalogue do to the residual, if it were raised from its null?
//
//   P = V^-1 - V^-1 J (J^T V^-1 J + 1)^-1 J^T V^-1,   S = (s^T P r)^2 / (s^T P s),   phi = -s^T P r / (s^T P s)
//
// with s = dy/dphi at phi = 0, J the columns of everything that is fitted, and P what remains of a column after the fit
// has absorbed what it can. One integration along the path gives the columns of many effects at once. Where an
// effect has a shape that vanishes at the null (a time constant, a threshold), s is made on a grid of it (Davies 1987,
// Biometrika 74:33). Where the derivative says nothing of an effect, the column is a difference: between the path with the effect at
// half its typical strength (or there at all) and the one without. So it is with effects that are either there or not, whose first
// derivative is nothing (a lag that a held input passes), and whose shape does not matter to first order (a body that stores heat).
#pragma once

#include "diagnose/explanation.h"

namespace sinew::diagnose {

struct Score {
  plant::EffectId effect{};
  std::map<std::string, double> shape;  // of its parameters but the strength, by key, internal units
  double statistic = 0.0;               // S, 0 where the sign is one that physics forbids
  double strength = 0.0;                // null + phi, internal units
  double root = 0.0;                    // of S with the sign of phi, in the sense of `column`
  double phi_of_root = 0.0;             // phi, internal units, for a root of 1
  double visible_share = 0.0;           // s^T P s / s^T V^-1 s: what calibration cannot absorb, 0 to 1
  double smallest_seen = 0.0;           // |phi| at which S would be 25 on average, internal units
  bool two_sided = false;               // physics allows the strength on both sides of its null
  bool is_difference = false;           // the derivative at the null says nothing
  Eigen::VectorXd column;               // P^(1/2) s of length 1, in the sense that physics allows: what only it does to the data
};

struct Scores {
  std::vector<Score> all;         // every effect with every shape, in the catalogue's order
  std::vector<std::size_t> best;  // index of the best shape of each candidate, by falling statistic
};

// Scores of `candidates` (effects that are off) at an explanation. `threads` do not change the result.
Scores score(const Explanation& at, const std::vector<plant::EffectId>& candidates, int threads);

// The largest statistic that two scores have together, each in a sense that physics allows, and their roots then.
struct JointScore {
  double statistic = 0.0, root = 0.0, other_root = 0.0;
};
JointScore joint(const Score& score, const Score& other);

// Probability that the largest statistic among all of these would reach `statistic` if no effect were there, the
// columns being as correlated as they are: Monte Carlo under the linearised null, by `draws` draws of a seeded stream;
// beyond their reach, Bonferroni's bound with the chi-squared tail.
double family_wise_probability(const Scores& scores, double statistic, std::uint64_t seed, int draws = 2000);

}  // namespace sinew::diagnose
