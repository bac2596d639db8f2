// SPDX-License-Identifier: Apache-2.0
// A plant's equations along a series of inputs, one step of 0.1 s after the other: in open loop, at rest where the series begins.
#pragma once

#include <optional>
#include <string>

#include "model/series.h"
#include "plant/integrator.h"

namespace sinew::model {

class PlantPath {
 public:
  // Throws InputError, naming `file`, where the plant lacks what the task needs.
  PlantPath(const plant::Plant& plant, const Task& task, double relative_tolerance, const std::string& file);

  void begin(const Eigen::Ref<const Vector<double>>& v);
  // A period later, where the inputs become `v` [features]. Everything is NaN from where the integrator gives up.
  void step(const Eigen::Ref<const Vector<double>>& v);

  double y() const { return y_; }                           // of the channel that is predicted, in the unit of a recording
  const Vector<double>& states() const { return states_; }  // as plant::Plant::states lists them, internal units
  const plant::Plant& plant() const { return plant_; }
  double relative_tolerance() const { return numerics_.relative_tolerance; }

 private:
  void see();
  void hold(const Eigen::Ref<const Vector<double>>& v);

  plant::Plant plant_;
  plant::NumericalSettings numerics_;
  Places places_;
  std::vector<double> inputs_;
  double y_ = 0.0;
  Vector<double> states_;
  std::optional<plant::Integrator> integrator_;
  std::int64_t steps_ = 0;
};

}  // namespace sinew::model
