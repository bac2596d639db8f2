// How small an effect would have been seen, where the score test cannot say.
//
// At the null of some effects (a body that stores heat, and is given none) first order sees only what calibration imitates,
// whatever their shape: what they do comes with the square of their strength. So what the effect would change, at some strength,
// is added to the recording, and that is explained without the effect: what the search would have gained by it is what the
// explanation loses.
#pragma once

#include "diagnose/explanation.h"

namespace sinew::diagnose {

// |strength - null|, internal units, at which an effect that is off in `at` would gain `least_gain` in twice the log posterior;
// 0 where none does. Strengths from 1/64 to 8 times what is typical are tried, within the range that a plant file may have; the
// shape is typical.
double smallest_seen(const Explanation& at, std::size_t effect, double least_gain, const ExplanationSettings& settings);

}  // namespace sinew::diagnose
