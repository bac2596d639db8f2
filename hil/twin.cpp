// SPDX-License-Identifier: Apache-2.0
#include "hil/twin.h"

#include <algorithm>
#include <cmath>

#include "plant/units.h"

namespace sinew::hil {
namespace {

constexpr int moments_a_period = 5;
constexpr double kept_s = 1.0;
// A residual counts as far as it is beyond one and a half standard deviations; a sum of 40 is not reached by chance: in
// noise alone the sum has a mean step of about -1.4, and exp(-2 * 1.4 * 40) is less than 1e-48.
constexpr double allowance = 1.5, alarm = 40.0;
constexpr double most_a_step = 8.0;  // one wild sample is not a departure
// What the twin cannot know: when within 10 ms a conversion ended, at up to 14 K/s, and what the ADC's steps leave.
constexpr double timing_K = 0.25, timing_deg = 0.35;

}  // namespace

Twin::Twin(const plant::Limb<double>& limb, const plant::Start& start, const sim::Sensors& sensors, double period_s)
    : plant_(limb, start, {plant::Method::automatic, 1e-6}), period_s_(period_s) {
  const auto noise = [](const sim::SensorSettings& one, double timing) {
    return std::sqrt(one.noise * one.noise + one.step * one.step / 12.0 + timing * timing);
  };
  noise_ = {noise(sensors.temperature[0], timing_K), noise(sensors.temperature[1], timing_K), noise(sensors.angle, timing_deg)};
  remember();
}

void Twin::remember() {
  const plant::Reading<double> shown = plant_.reading();
  moments_.push_back({plant_.time_s(),
                      {shown.temperature_degC[0], shown.temperature_degC[1], shown.angle_rad / plant::radians_per_degree}});
  while (moments_.front().time_s < plant_.time_s() - kept_s) moments_.pop_front();
}

double Twin::shown_at(std::size_t channel, double time_s) const {
  const auto after = std::find_if(moments_.begin(), moments_.end(), [&](const Moment& m) { return m.time_s >= time_s; });
  if (after == moments_.begin()) return moments_.front().shown[channel];
  if (after == moments_.end()) return moments_.back().shown[channel];
  const auto before = after - 1;
  const double share = (time_s - before->time_s) / (after->time_s - before->time_s);
  return before->shown[channel] + share * (after->shown[channel] - before->shown[channel]);
}

void Twin::applied(const plant::PerCoil<double>& duty_fraction) {
  if (failed_) return;
  plant_.hold(duty_fraction);
  const double begin_s = static_cast<double>(ticks_) * period_s_;
  ++ticks_;
  for (int k = 1; k <= moments_a_period; ++k) {
    if (plant_.advance_to(begin_s + period_s_ * k / moments_a_period)) {
      failed_ = true;
      return;
    }
    remember();
  }
}

std::vector<Departure> Twin::compare(const sim::Measurement& measured, double temperature_age_s, double angle_age_s) {
  std::vector<Departure> departures;
  const double now_s = static_cast<double>(ticks_) * period_s_;
  const std::array<double, 3> values{measured.temperature_degC[0], measured.temperature_degC[1], measured.angle_deg};
  for (std::size_t c = 0; c < 3; ++c) {
    const double made_s = now_s - (c < 2 ? temperature_age_s : angle_age_s);
    residual_[c] = values[c] - shown_at(c, made_s);
    if (std::isnan(residual_[c]) || failed_) continue;
    const double scaled = residual_[c] / noise_[c];
    for (int side = 0; side < 2; ++side) {
      double& sum = sum_[c][static_cast<std::size_t>(side)];
      sum = std::max(0.0, sum + std::min(most_a_step, side == 0 ? scaled : -scaled) - allowance);
      if (sum == 0.0) since_s_[c][static_cast<std::size_t>(side)] = now_s;
      if (sum > alarm && !said_[c]) {
        said_[c] = true;
        departures.push_back({c, since_s_[c][static_cast<std::size_t>(side)], now_s});
      }
    }
  }
  return departures;
}

}  // namespace sinew::hil
