// SPDX-License-Identifier: Apache-2.0
// The seam: all that a controller, a predictor or a diagnosis may ever see of a plant, and the one call that it answers.
#pragma once

#include <cstdint>
#include <vector>

namespace sinew::sim {

// In the order of the System's inputs.
struct Command {
  std::int64_t tick = 0;
  std::vector<double> inputs;
};

// In the order of the System's channels, in the units of files. NaN: the sensor gave nothing.
struct Measurement {
  std::int64_t tick = 0;
  std::vector<double> channels;
};

// A plant, simulated or physical. Time is a count of ticks of the sample period.
class Backend {
 public:
  virtual ~Backend() = default;
  // What is measured at the first tick, before any command.
  virtual Measurement begin() = 0;
  // Applies the command of this tick and returns what is measured at the next.
  virtual Measurement exchange(const Command& command) = 0;
};

}  // namespace sinew::sim
