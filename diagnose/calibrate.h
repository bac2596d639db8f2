// SPDX-License-Identifier: Apache-2.0
// Calibration: the parameters with which a plant explains recordings best, how sure each is, and which cannot be told.
//
// Least squares with weak priors and bounds (fit.h), by Ceres Solver's Levenberg-Marquardt from several seeded starts; the
// same seed gives the same bytes whatever the number of threads.
//
// Where the model is right, each channel is weighted by its sensor's noise. Where it is not, its residuals are larger than
// noise and stay correlated over many samples, and to weight them as independent noise would buy a little error with
// absurd parameters. So the fit is repeated: a channel's deviation becomes the rms of its residuals, never less than the
// noise, until that settles; and in a last pass rms * sqrt(correlation length in samples). A right model ends with the noise
// itself. The standard errors take residuals in the same way, as they are. A parameter of which the data leaves
// more than `untold_share` of the prior's deviation is one that the data cannot tell.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diagnose/fit.h"

namespace sinew::diagnose {

struct CalibrationSettings {
  std::vector<plant::ParameterId> parameters;  // empty: fittable_parameters(plant)
  bool only_start = false;                     // no parameters: only how the recordings begin
  Beginnings start;
  int starts = 3;
  std::uint64_t seed = 1;
  int threads = 2;
  int most_passes = 8;
  int iterations_per_pass = 40;
  bool along_the_path = false;  // steer by the derivatives of path.h, good to about a per cent, in a fraction of the time
  // Accurate to a few thousandths of a degree, far below the sensors' noise (bench/methods).
  plant::NumericalSettings numerics{plant::Method::automatic, 1e-5};
  std::function<bool()> should_stop;                // asked between iterations; a stopped calibration throws Stopped
  std::function<void(double done_share)> progress;  // called from one thread at a time
};

struct Stopped {};

inline constexpr double untold_share = 0.7;

struct Estimate {
  Unknown unknown;
  double value;           // internal units
  double standard_error;  // internal units
  double share_of_prior;  // standard error over the prior's deviation
  bool told() const { return share_of_prior < untold_share; }
  bool at_bound = false;
  double surprise() const { return unknown.coordinate_of(value); }  // in prior deviations
  // Where it cannot be told: the unknown with which it trades off most, and their correlation.
  std::string partner;
  double partner_correlation = 0.0;
};

struct StartOutcome {
  double cost = 0.0;  // half the sum of squares, with deviations that are the same for all starts
  int passes = 0, iterations = 0;
  bool usable = false;
};

struct Calibration {
  plant::Plant fitted;
  std::vector<plant::Start> starts_of_recordings;
  std::vector<Estimate> estimates;  // parameters first, then first values
  std::vector<StartOutcome> outcomes;
  std::size_t best_start = 0;
  bool several_starts_agree = true;   // whether the cost of all usable starts is within 2 of the best
  std::vector<PerChannel> deviation;  // of each recording, at the end
  // Sign parameters that the recordings say are the other way than in the nominal plant.
  std::vector<plant::ParameterId> flipped_signs;
};

// Every parameter with a prior: of the core, and of the effects that are on.
std::vector<plant::ParameterId> fittable_parameters(const plant::Plant& plant);

// The plant with each sign as the recordings say, judged by the cost at the nominal values. `flipped`: those that are now the
// other way.
plant::Plant with_signs_of(const plant::Plant& nominal, const std::vector<FitData>& data, const Beginnings& start,
                           const plant::NumericalSettings& numerics, std::vector<plant::ParameterId>& flipped);

// Throws std::runtime_error where no start could be integrated, Stopped when asked to stop.
// `data`: deviations are the sensors' noise.
Calibration calibrate(const plant::Plant& nominal, const std::vector<FitData>& data, const CalibrationSettings& settings);

}  // namespace sinew::diagnose
