// SPDX-License-Identifier: Apache-2.0
// A plant that runs beside the limb, driven by the duty that the device applied; and who says so when the limb leaves it.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "plant/integrator.h"
#include "sim/sensor.h"
#include "sim/signals.h"

namespace sinew::hil {

// A channel that left the noise for longer than chance allows.
struct Departure {
  plant::ChannelId channel;
  double onset_s, said_s;
};

class Twin {
 public:
  // `sensors`: one a channel.
  Twin(const plant::Plant& limb, const plant::Start& start, const std::vector<sim::SensorSettings>& sensors, double period_s);

  // The limb measured this at the tick; temperatures are that old, an angle is the mean over its sixteen milliseconds.
  // Returns what it has to say now, each channel once.
  std::vector<Departure> compare(const sim::Measurement& measured, double temperature_age_s, double angle_age_s);
  void applied(const std::vector<double>& duty_fraction);

  // Measured less twin, by channel, in the units of files; NaN: missing.
  const std::vector<double>& residual() const { return residual_; }
  bool failed() const { return failed_; }

 private:
  struct Moment {
    double time_s;
    std::vector<double> shown;
  };
  struct Side {  // of a two-sided cumulated sum (Page 1954), and when it last was zero
    double sum = 0.0, since_s = 0.0;
  };
  struct Watch {  // of one channel
    bool is_temperature = false;
    double noise = 0.0;
    Side above, below;
    bool said = false;
  };
  double shown_at(std::size_t channel, double time_s) const;
  void remember();
  std::shared_ptr<const plant::System> system_;
  plant::Integrator plant_;
  double period_s_;
  std::int64_t ticks_ = 0;
  std::deque<Moment> moments_;
  std::vector<double> residual_;
  std::vector<Watch> watch_;
  bool failed_ = false;
};

}  // namespace sinew::hil
