// SPDX-License-Identifier: Apache-2.0
// What if something of the plant is no constant but varies?
//
// A disturbance that comes and goes, or a law of another form than the plant's, is a constant that changes from one moment
// to the next: the strength of an effect, a parameter of the core, the gain of a sensor. As one more slow forcing
// (state_noise.h) it enters where that constant does, in all parts at once and in proportion to what it multiplies;
// forcings of the single equations know none of that. Which of them carries a recording best says where to look, and its
// course in time, as a function of what.
//
// Source: Young 2011, Recursive Estimation and Time-Series Analysis, chapters 4 and 5 (parameters that vary, by fixed-interval
// smoothing); Kristensen, Madsen, Jorgensen 2004, Automatica 40:225.
#pragma once

#include <optional>
#include <string>

#include "diagnose/state_noise.h"

namespace sinew::diagnose {

struct Wanderer {
  std::string words;  // "the beam's stiffness", "the strength of supply_sag"
  std::string_view place;
  std::optional<plant::EffectId> effect;    // its strength varies ...
  std::optional<plant::Constant> constant;  // ... or this does
  // The forcing counts in units of `scale`: what is said of it is centre + scale times that, in `unit`.
  double centre = 0.0, scale = 10.0;
  std::string unit = "%";
};

// All that may vary in a plant: effects that are off there, have no states of their own, delay nothing and are not the gain
// of a sensor upstream; what the core holds for constant; the sensors' gains.
std::vector<Wanderer> wanderers(const plant::Plant& plant, const std::vector<plant::EffectId>& without);

struct Varying {
  Wanderer of;
  double correlation_time_s;
};

// Along the path through the data at z. False where the path cannot be integrated.
bool varying_push(const FitProblem& problem, const double* z, const Varying& varying, VaryingPush& push);

}  // namespace sinew::diagnose
