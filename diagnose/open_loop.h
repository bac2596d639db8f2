// SPDX-License-Identifier: Apache-2.0
// What a plant predicts of a recording from its duty alone, and the plant that does so best.
#pragma once

#include <cmath>

#include "diagnose/calibrate.h"
#include "diagnose/explanation.h"

namespace sinew::diagnose {

inline constexpr double guard_s = 5.0;     // between what is fitted and what is left out or held out of one recording
inline constexpr double settling_s = 5.0;  // of a held-out recording: tells how it begins, and is not scored

inline constexpr double lost = 1e200;  // square of an error where the plant cannot follow; sums stay finite
inline double square_of_error(double model, double target) {
  const double square = (model - target) * (model - target);
  return std::isfinite(square) ? square : lost;
}

// Model values at every sample, in the units of files. NaN from where the integration fails.
Series predict(const plant::Plant& plant, const plant::Start& start, const sim::Recording& recording,
               const plant::NumericalSettings& numerics);

// How a held-out recording begins, from its first seconds.
plant::Start start_of(const plant::Plant& plant, const sim::Recording& recording, const PerChannel& noise,
                      const ExplanationSettings& settings);

// A limb and how the training recordings begin, and the explanation that they are of.
struct Fitted {
  Explanation of;
  plant::Plant model;
  std::vector<plant::Start> starts;
};
Fitted fitted(const Explanation& explanation);
// As `calibrate` fits a plant. Throws std::runtime_error where nowhere could it be integrated.
Fitted calibrated(const plant::Plant& plant, const std::vector<FitData>& data, const CalibrationSettings& settings);

// How far a path is off the fitted samples of each recording and channel, at least by the sensors' noise; its size, one for all channels;
// and minus the log likelihood with that, up to a constant.
struct Spread {
  std::vector<PerChannel> rmse;       // units of files
  std::vector<PerChannel> count;      // of samples
  std::vector<PerChannel> deviation;  // error_size.h
  double log_sum = 0.0;
};
Spread spread_of(const Fitted& fitted, const std::vector<FitData>& data, const plant::NumericalSettings& numerics);

// Where an explanation leaves more than noise, its forcings carry what it lacks and the path alone may be far off.
// Least squares on the path itself, each channel weighted by how far off it is, begun there; the explanation's own path
// where that predicts the fitted samples no better.
Fitted polished(const Explanation& explanation, const std::vector<FitData>& data, const ExplanationSettings& settings);

// Samples over which each channel's error is correlated, in each recording: a part that one recording drives and another does not is off
// for a pulse in one and all along in the other.
std::vector<PerChannel> samples_alike_of(const Fitted& path, const std::vector<FitData>& data, const plant::NumericalSettings& numerics);

// The data, each channel weighted as a path fits it: by how far off it is, never less than its noise, and for how long.
std::vector<FitData> weighted_by(const Fitted& path, const std::vector<FitData>& data, const plant::NumericalSettings& numerics);

// The explanation whose values are a path's, with a covariance that takes the path's errors as they are, in size and in how long they stay
// correlated, as `calibrate` does. The explanation that the path is of, where that is what it follows.
Explanation as_fitted(const Fitted& path, const std::vector<FitData>& data, const ExplanationSettings& settings);

// Ten-fold cross-validation of a path: of each fold and channel, how far off the prediction is where the path was
// fitted to everything else, its unknowns begun where they are. A fold is a tenth of every recording's fitted samples,
// in one piece, without the seconds that tell how the recording begins; its neighbourhood is in neither part.
//
// Source: Hastie, Tibshirani, Friedman 2009, The Elements of Statistical Learning, 2nd edition, section 7.10.
struct FoldErrors {
  std::vector<PerChannel> squares;  // [fold]: sums over its samples, units of files squared
  std::vector<PerChannel> noise;    // [fold]: what the sensors alone would make of these
};
FoldErrors cross_validated(const Fitted& path, const std::vector<FitData>& data, int threads, const ExplanationSettings& settings);

// By how much the error that cross-validation finds falls: the logarithm of the root mean squares, summed over channels, and its
// standard deviation, which is the jackknife's over folds. What is below the sensors' noise counts as noise.
struct FoldGain {
  double value, deviation;
  bool beyond_chance() const { return value > 2.0 * deviation; }
};
FoldGain gain_of(const FoldErrors& before, const FoldErrors& after);

}  // namespace sinew::diagnose
