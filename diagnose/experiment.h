// SPDX-License-Identifier: Apache-2.0
// The experiment that would tell two explanations apart: which inputs, how well, in how many minutes.
#pragma once

#include <string>

#include "diagnose/explanation.h"

namespace sinew::diagnose {

struct Experiment {
  plant::EffectId effect{}, rival{};
  std::string words;  // "short pulses on all inputs in turn", by the inputs' own words
  double duration_s = 0.0;
  double largest_share = 0.0;  // of the inputs' range
  double highest = 0.0;        // of all states that must stay below a limit (StateInfo::safe_until), in either explanation
  // Standard deviations by which what one predicts differs from the nearest that the other could be fitted to.
  double separation = 0.0;
  std::string scenario_yaml;  // runs on the simulated plant and on the physical one
};

struct ExperimentLimits {
  double largest_share = 0.6;  // of the inputs' range
};

// The programme of inputs, from rest, on which the two differ most per minute. Of no duration where the System has no state with a
// limit: nothing then says what such a plant can bear.
Experiment design_experiment(const Explanation& first, const Explanation& second, const PerChannel& noise, const ExperimentLimits& limits);

}  // namespace sinew::diagnose
