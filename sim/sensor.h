// SPDX-License-Identifier: Apache-2.0
// From what a sensor would show to what it reports: bias, noise, steps, and faults. One sample a tick.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "sim/random.h"

namespace sinew::sim {

// From `from_s` until `until_s` the sensor reports what it reported last before; at the very beginning, its first value.
struct Stuck {
  double from_s = 0.0;
  double until_s = 0.0;
};

// All values are in the unit of the channel.
struct SensorSettings {
  double noise = 0.0;             // standard deviation, white
  double step = 0.0;              // quantisation; 0: none
  double bias = 0.0;              // added before noise and steps
  double dropout_fraction = 0.0;  // of samples that are missing, at random
  std::optional<Stuck> stuck{};
};

class Sensor {
 public:
  Sensor(const SensorSettings& settings, std::uint64_t seed, std::string_view channel)
      : settings_(settings), noise_(seed, std::string(channel) + ".noise"), dropout_(seed, std::string(channel) + ".dropout") {}

  // NaN where the sample is missing.
  double report(double shown, std::int64_t tick, double time_s) {
    const auto n = static_cast<std::uint64_t>(tick);
    double value = shown + settings_.bias + settings_.noise * noise_.normal(n);
    if (settings_.step > 0.0) value = std::round(value / settings_.step) * settings_.step + 0.0;  // + 0.0: never -0
    const bool is_stuck = settings_.stuck && time_s >= settings_.stuck->from_s && time_s < settings_.stuck->until_s;
    if (is_stuck && last_) value = *last_;
    if (!is_stuck || !last_) last_ = value;
    if (settings_.dropout_fraction > 0.0 && dropout_.uniform(n) < settings_.dropout_fraction)
      return std::numeric_limits<double>::quiet_NaN();
    return value;
  }

  // What it reported last while it was not stuck, or first where it has been stuck from the beginning: its only state.
  const std::optional<double>& last() const { return last_; }
  void set_last(std::optional<double> value) { last_ = value; }

 private:
  SensorSettings settings_;
  RandomStream noise_, dropout_;
  std::optional<double> last_;
};

}  // namespace sinew::sim
