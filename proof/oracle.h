// SPDX-License-Identifier: Apache-2.0
// What one would reach who knows the law that is concealed, and only has to fit its values: least squares of the training recording with
// the generator as the model, then its open-loop prediction of the held-out one. It exists for every family, since it asks nothing of the
// catalogue.
//
// Minimised: squared errors in units of the sensors' noise, plus squared distances of the core's parameters from their nominal values in
// units of the generator's spread. Effects have no prior. The model begins cold and at rest, in still air: it is no oracle of a recording
// that begins in mid-motion, and the air's own motion stays in its errors.
#pragma once

#include <functional>

#include "prove/generator.h"

namespace sinew::proof {

// Half the range within which the generator draws a core parameter (generator.h); the prior has the deviation of that range.
struct CoreSpread {
  double relative = 0.08, kelvins = 3.0, offset = 1.0;
};

inline constexpr std::size_t oracle_channels = 3;  // of prove::Sample, in the order of its fields
using OracleChannels = std::array<double, oracle_channels>;

struct OracleSettings {
  OracleChannels noise;  // deviation of each sensor
  CoreSpread spread;
  int most_iterations = 30;
  std::function<bool()> should_stop;  // asked before each simulation; empty: never
};

struct OracleFit {
  std::map<std::string, double> core_parameters;
  std::vector<prove::TruthEffect> effects;
  bool stopped = false;  // by should_stop
  bool converged = false;
};

// From these values on. A core parameter that begins outside its spread is one that its kind draws elsewhere, and has no prior. Effects
// keep their signs, and values that are 0 stay. Measurements that are NaN are left out. Throws std::invalid_argument as prove::simulate.
OracleFit fit_oracle(const std::map<std::string, double>& core_parameters, const std::vector<prove::TruthEffect>& effects,
                     const std::vector<prove::Sample>& training, const OracleSettings& settings);

// RMSE of each channel, open loop; NaN of a channel without a measurement.
OracleChannels open_loop_rmse(const OracleFit& fit, const std::vector<prove::Sample>& samples);

}  // namespace sinew::proof
