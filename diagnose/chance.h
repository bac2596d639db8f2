// SPDX-License-Identifier: Apache-2.0
// How large a process noise becomes by chance: parametric bootstrap of the check that something is missing.
//
// The filter is linear about one path. Surroundings that push a plant over a corner, or to where it stiffens, leave more than the filter
// expects of it, in some recordings and not in others. So the explanation itself, integrated with air that varies as much as was found and
// with the sensors' noise, is put in the recording's place, and fitted again. Steps of a sensor count as white noise of their size.
//
// Source: Davison, Hinkley, Bootstrap Methods and their Application (1997), section 4.2 (Monte Carlo tests).
#pragma once

#include "diagnose/explanation.h"

namespace sinew::diagnose {

struct ProcessNoiseByChance {
  double process_noise = 0.0;  // that was found
  double nuisance = 0.0;       // deviation of the surroundings, internal units
  std::size_t drawn = 0;       // simulations of all recordings in which nothing is missing
  std::size_t as_large = 0;    // of which have at least the process noise that was found
  double largest = 0.0;
  // Of a Monte Carlo test: (1 + as_large) / (1 + drawn); where draws ended early, no less than with all of them.
  double probability() const { return static_cast<double>(1 + as_large) / static_cast<double>(1 + drawn); }
};

// Up to 99 draws, so that the least probability is 0.01; ends after those four among which one is as large.
// Where a draw cannot be fitted it counts as as large: nothing is known of it.
// `data`: what `found` was fitted to. `process_noise`: of it, with its unknowns fitted again (explanation.h), as those of the draws are.
// Throws Stopped where settings.should_stop says so.
ProcessNoiseByChance process_noise_by_chance(const Explanation& found, double process_noise, const std::vector<FitData>& data, int threads,
                                             std::uint64_t seed, const ExplanationSettings& settings);

}  // namespace sinew::diagnose
