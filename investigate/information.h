// SPDX-License-Identifier: Apache-2.0
// What a programme of duty is expected to tell about the answers that are still possible.
//
// Every answer i predicts the readings as normal: mean m_i from its own simulation, covariance V + A_i C_i A_i^T, where V is what sensors,
// moving air and the process noise found so far do along the path (diagnose/state_noise.h), C_i the covariance of its parameters after all
// recordings so far and of how the experiment begins, as little as is known of that before, A_i its sensitivities. Two answers are then
//
//   d_ij^2 = (m_i - m_j)^T (V + (A_i C_i A_i^T + A_j C_j A_j^T) / 2)^-1 (m_i - m_j)
//
// apart, and the expected fall of the entropy is, from below,
//
//   I = - sum_i p_i log sum_j p_j exp(-d_ij^2 / 8 k)
//
// with Bhattacharyya's distance for equal covariances, and k of belief.h. An effect that no recording could have shown is an answer, too:
// the most probable plant with it at its usual strength, and all else fitted again beside it. So the same number asks what would make
// visible what this limb may have. Where "something else" is probable, effects of the catalogue stand in for it, equally likely: what would
// show many of them shows more of what is in none.
//
// Source: Kolchinsky, Tracey 2017, Entropy 19:361 (the bound); Box, Hill 1967, Technometrics 9:57 (experiments that discriminate).
#pragma once

#include "investigate/belief.h"
#include "investigate/programme.h"

namespace sinew::investigate {

struct Alternative {
  std::string key;
  double probability = 0.0;
  plant::Plant model;
  std::shared_ptr<const diagnose::Explanation> fitted;
  Eigen::VectorXd z;       // of its parameters, where the fit ended
  Eigen::MatrixXd spread;  // a factor of their covariance there
};

struct Question {
  std::vector<Alternative> alternatives;  // the first is the most probable of those that the diagnosis fitted
  diagnose::ForcingSize forcing;
  diagnose::PerChannel noise;
  plant::NumericalSettings numerics;
  double exaggeration = 1.0;
  double mass = 0.0;  // probability of all alternatives
  // On the recordings' clock, when the first one began and the last one ended: the experiment begins no earlier. None: they say no times.
  std::optional<double> counted_from_s, begins_s;
  double entropy_nat() const;  // of the alternatives, times `mass`
};

// `diagnosis` must outlive it. At most so many alternatives, the most probable ones.
Question question_of(const diagnose::Diagnosis& diagnosis, const Belief& belief, const diagnose::DiagnosisSettings& settings,
                     std::size_t most_alternatives = 8);

inline constexpr double longest_cooling_s = 150.0;  // at the end of a programme

// What a limb that is heated may bear: limits.h of hil/, and the states' own.
struct Expected {
  bool possible = false;           // within the limits, after the level was lowered where it must be
  Programme programme;             // with that level, and time to cool
  double information_nat = 0.0;    // expected fall of the entropy
  double highest_degC = 0.0;       // of all coils in all alternatives, with two standard deviations of what is not known of the parameters
  std::string apart, from;         // the two alternatives that it separates most, weighted by their probabilities
  double separation = 0.0;         // d_ij of these
  std::vector<double> from_first;  // d_0j of all alternatives
  double per_minute() const { return programme.duration_s() > 0.0 ? 60.0 * information_nat / programme.duration_s() : 0.0; }
};

Expected expected_of(const Question& question, const Shape& shape, double longest_s);

// Whether the device's bound of the heat and the on-time of every coil stay below what the host allows (hil/limits.h), from rest.
bool within_device_limits(const Programme& programme, const plant::System& system);

}  // namespace sinew::investigate
