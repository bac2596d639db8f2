// SPDX-License-Identifier: Apache-2.0
// The predictor in a loop: one step at a time, for a rollout or beside a session with the limb. A step allocates nothing.
#pragma once

#include "model/series.h"

namespace sinew::model {

class Predictor {
 public:
  explicit Predictor(const Model& model);

  // Begins anew, nothing remembered, where the angle was measured and `v` is what the case sees of that instant, in the units
  // of a recording. v: [channels].
  void begin(double angle_deg, const Eigen::Ref<const Vector<double>>& v);
  // The angle one step later, with what the case sees of that instant, from the angle that the step before predicted.
  double open_loop(const Eigen::Ref<const Vector<double>>& v);
  // The same from a measured angle of the step before.
  double one_step(const Eigen::Ref<const Vector<double>>& v, double angle_before_deg);

 private:
  double step(const Eigen::Ref<const Vector<double>>& v);
  Weights<float> weights_;
  Scaling scaling_;
  bool memoryless_;
  Vector<float> x_, z_, c_, h_, r_;
};

// Predicted angles of a series [samples]; the first is the measured one. NaN nowhere.
Vector<double> rollout(const Model& model, const Series& series);
Vector<double> one_step_ahead(const Model& model, const Series& series);

}  // namespace sinew::model
