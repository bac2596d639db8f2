// SPDX-License-Identifier: Apache-2.0
// What a predictor is given of a limb, and what it is asked for: the inputs of the paper's four cases, and their scaling.
//
// Source: Sabelhaus, Mehta, Wertz, Majidi 2022 (doi 10.3389/frobt.2022.888261): X(t) = [v(t), v(t-1), angle(t-1)] with v of
//   case 1: duty A;  2: duty and temperature A;  3: both duties;  4: duty A, temperature A, duty B, temperature B.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/network.h"
#include "sim/recording.h"
#include "sim/signals.h"

namespace sinew::model {

inline constexpr double period_s = 0.1;  // of the paper's loop; nothing else is predicted

struct Channel {
  std::string name;  // the column of a recording, its unit at its end
  bool temperature;
  std::size_t coil;
};

// v of a case from 1 to 4, in order. Throws std::invalid_argument for another number.
std::vector<Channel> channels_of(int paper_case);

// One recording as a case sees it; column or entry k is the sample k.
struct Series {
  std::string name;
  double first_s = 0.0;
  Matrix<double> v;         // [channels x samples], duty as a fraction, temperature in degC
  Vector<double> angle_deg; // [samples]
  Index samples() const { return angle_deg.size(); }
};

inline constexpr double longest_held_s = 10.0;
enum class Missing {
  refused,  // an InputError names the first one
  held,     // the value before is taken, as a predictor in a loop would have to
};

// Throws InputError where a channel that the case needs is not there, a sample is missing, or the recording is not one at
// 10 Hz: a step off by more than a fifth of the period. With `held`, rows that are missing are held too, up to longest_held_s.
Series series_of(const sim::Recording& recording, int paper_case, Missing missing = Missing::refused);

// Samples from `first` on, `count` of them.
Series part_of(const Series& series, Index first, Index count);

// What one unit of a network's numbers is. Duty stays as it is; temperatures and angle go to 0 ... 1 over the training data.
struct Scaling {
  Vector<double> v_offset, v_span;
  double angle_offset_deg = 0.0, angle_span_deg = 1.0;
  double scaled_angle(double angle_deg) const { return (angle_deg - angle_offset_deg) / angle_span_deg; }
  double angle_deg(double scaled) const { return angle_offset_deg + angle_span_deg * scaled; }
};
Scaling scaling_of(const std::vector<Series>& training, int paper_case);

// A series in a network's numbers: [v(t); v(t-1)] of sample t in column t - 1, and the angle of sample t in entry t.
struct ScaledSeries {
  Matrix<float> exogenous;  // [2 channels x samples - 1]
  Vector<float> angle;      // [samples]
};
ScaledSeries scaled(const Series& series, const Scaling& scaling);

// All that a weights file holds.
struct Model {
  int paper_case = 3;
  std::string method;  // "published" or "stateful"
  Scaling scaling;
  Weights<float> weights;
  std::string trained_on;  // in words, for people
  // The published code clears the state at every step.
  bool memoryless() const { return method == "published"; }
};

}  // namespace sinew::model
