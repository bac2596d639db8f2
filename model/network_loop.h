// SPDX-License-Identifier: Apache-2.0
// The network in a loop: one step at a time, for a rollout or beside a session with the plant. A step allocates nothing.
#pragma once

#include <vector>

#include "model/series.h"

namespace sinew::model {

class NetworkLoop {
 public:
  explicit NetworkLoop(const Model& model);

  // Begins anew, nothing remembered, where `y` was measured and `v` is what the task sees of that instant, in the units of a
  // recording. v: [features].
  void begin(double y, const Eigen::Ref<const Vector<double>>& v);
  // y one step later, with what the task sees of that instant, from the y that the step before predicted.
  double open_loop(const Eigen::Ref<const Vector<double>>& v);
  // The same from a measured y of the step before.
  double one_step(const Eigen::Ref<const Vector<double>>& v, double y_before);
  // The y that the step before predicted was measured after all.
  void correct(double y);

 private:
  double step(const Eigen::Ref<const Vector<double>>& v);
  void lstm_step();  // from z_, which holds W x + b, to h_
  Weights<float> weights_;
  Scaling scaling_;
  bool memoryless_;
  Vector<float> x_, z_, q_, c_, h_, r_;
};

// y of a series as predicted [samples]; the first is the measured one. NaN nowhere.
Vector<double> rollout(const Model& model, const Series& series);
Vector<double> one_step_ahead(const Model& model, const Series& series);
// Rollouts of several series side by side, in groups of `at_once`: the weights are read once for all of a group. As `rollout`, but for the
// rounding of sums of 32-bit floats; the number of threads changes nothing.
inline constexpr std::size_t at_once = 16;
std::vector<Vector<double>> rollouts(const Model& model, const std::vector<Series>& series, int threads);

}  // namespace sinew::model
