// SPDX-License-Identifier: Apache-2.0
// Recordings with fewer samples, for fits of open-loop simulations.
//
// What a wrong plant's simulation is off by stays so for seconds, so that samples closer to each other than the System's averaging time say
// the same, and an integrator that need not stop at each of them takes longer steps. Kept are one of a channel's
// readings in so many, and every sample at which an input changes or is about to: the inputs stay exactly as they were.
#pragma once

#include <memory>
#include <vector>

#include "diagnose/fit.h"

namespace sinew::diagnose {

// Of the states' scales: far below what a wrong plant is off by.
inline constexpr double coarse_tolerance = 1e-4;

struct Thinned {
  std::shared_ptr<const std::vector<sim::Recording>> recordings;  // that `data` points to
  std::vector<FitData> data;                                      // of the recordings' fitted samples, nothing after them
  // Of each recording: one measured sample of a channel in so many is kept.
  std::vector<plant::ListOf<plant::ChannelId, std::size_t>> every;
};

// One reading of each channel per System::averaging_s; all of them where the System has none, or a recording no more than that.
Thinned thinned(const plant::System& system, const std::vector<FitData>& data);

}  // namespace sinew::diagnose
