// SPDX-License-Identifier: Apache-2.0
// How far off a plant is that is not quite right: in all channels by the same share of what they show.
//
// A channel's error is that of its sensor, and a share of how far the channel moves: of the largest standard deviation among the
// channels in its unit. The share is unknown, and one for all: were each channel's size its own, a fit would come down to noise in
// one channel and give another up, from values that no limb has.
#pragma once

#include <vector>

#include "diagnose/fit.h"

namespace sinew::diagnose {

struct ErrorSize {
  double share = 0.0;
  std::vector<PerChannel> deviation;  // of each recording, at least its sensors' noise; units of files
  double log_likelihood = 0.0;        // at that share, up to a constant
};

// Sums of squared errors over the fitted samples of each recording, and how many of them there are; units of files.
struct SquaredErrors {
  std::vector<PerChannel> sum, count;
};

// Of each channel, what a share is of; units of files.
PerChannel scale_of(const plant::System& system, const std::vector<FitData>& data);

// The most likely share. `samples_alike`: over so many samples a recording's errors of a channel stay the same, and count as one.
ErrorSize error_size(const SquaredErrors& errors, const std::vector<FitData>& data, const PerChannel& scale,
                     const std::vector<PerChannel>& samples_alike);

}  // namespace sinew::diagnose
