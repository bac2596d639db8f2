// SPDX-License-Identifier: Apache-2.0
// A plant that runs beside the limb, driven by the duty that the device applied; and who says so when the limb leaves it.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "hil/supervisor.h"
#include "sim/scenario.h"

namespace sinew::hil {

// A channel that left the noise for longer than chance allows.
struct Departure {
  std::size_t channel;  // 0, 1: temperature A, B; 2: angle
  double onset_s, said_s;
};
inline constexpr std::array<const char*, 3> channel_names{"temperature_A", "temperature_B", "angle"};

class Twin {
 public:
  Twin(const plant::Limb<double>& limb, const plant::Start& start, const sim::Sensors& sensors, double period_s);

  // The limb measured this at the tick; temperatures are that old, the angle is the mean over its sixteen milliseconds.
  // Returns what it has to say now, each channel once.
  std::vector<Departure> compare(const sim::Measurement& measured, double temperature_age_s, double angle_age_s);
  void applied(const plant::PerCoil<double>& duty_fraction);

  const std::array<double, 3>& residual() const { return residual_; }  // measured less twin: K, K, deg; NaN: missing
  bool failed() const { return failed_; }

 private:
  struct Moment {
    double time_s;
    std::array<double, 3> shown;
  };
  double shown_at(std::size_t channel, double time_s) const;
  void remember();
  plant::Integrator plant_;
  double period_s_;
  std::array<double, 3> noise_;
  std::int64_t ticks_ = 0;
  std::deque<Moment> moments_;
  std::array<double, 3> residual_{};
  // Two-sided cumulated sums (Page 1954) a channel, and when each last was zero.
  std::array<std::array<double, 2>, 3> sum_{};
  std::array<std::array<double, 2>, 3> since_s_{};
  std::array<bool, 3> said_{};
  std::array<std::optional<double>, 2> last_degC_;
  bool failed_ = false;
};

}  // namespace sinew::hil
