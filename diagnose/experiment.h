// SPDX-License-Identifier: Apache-2.0
// The experiment that would tell two explanations apart: which duty, how well, in how many minutes.
#pragma once

#include <string>

#include "diagnose/explanation.h"

namespace sinew::diagnose {

struct Experiment {
  std::size_t effect = plant::no_effect, rival = plant::no_effect;
  std::string words;             // "short pulses on both coils in turn"
  double duration_s = 0.0;
  double largest_duty_fraction = 0.0;
  double hottest_degC = 0.0;     // of either wire, in either explanation
  // Standard deviations by which what one predicts differs from the nearest that the other could be fitted to.
  double separation = 0.0;
  std::string scenario_yaml;     // runs on the plant and on the limb
};

struct ExperimentLimits {
  double largest_duty_fraction = 0.6;
  double hottest_degC = 110.0;
};

// The programme among a fixed set (steps, pulses, stairs, both coils together and in turn, of two and five minutes; duty is
// lowered until the limits hold) that separates `first` from `second` most per minute. `noise`: of the sensors; air
// wanders by `air_K`.
Experiment design_experiment(const Explanation& first, const Explanation& second, const PerChannel& noise, double air_K,
                             const ExperimentLimits& limits);

}  // namespace sinew::diagnose
