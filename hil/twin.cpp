// SPDX-License-Identifier: Apache-2.0
#include "hil/twin.h"

#include <algorithm>
#include <cmath>

#include "sim/simulation.h"

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

Twin::Twin(const plant::Plant& limb, const plant::Start& start, const std::vector<sim::SensorSettings>& sensors, double period_s)
    : system_(limb.shared_system()), plant_(limb, start, {plant::Method::automatic, 1e-6}), period_s_(period_s) {
  for (const plant::ChannelId c : system_->channels().ids()) {
    const sim::SensorSettings& one = sensors.at(c.index);
    Watch watch;
    watch.is_temperature = system_->channels()[c].kind == "temperature";
    const double timing = watch.is_temperature ? timing_K : timing_deg;
    watch.noise = std::sqrt(one.noise * one.noise + one.step * one.step / 12.0 + timing * timing);
    watch_.push_back(watch);
  }
  residual_.assign(watch_.size(), 0.0);
  remember();
}

void Twin::remember() {
  moments_.push_back({plant_.time_s(), sim::in_file_units(*system_, plant_.readings())});
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

void Twin::applied(const std::vector<double>& duty_fraction) {
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
  for (std::size_t c = 0; c < watch_.size(); ++c) {
    Watch& watch = watch_[c];
    const double made_s = now_s - (watch.is_temperature ? temperature_age_s : angle_age_s);
    residual_[c] = measured.channels[c] - shown_at(c, made_s);
    if (std::isnan(residual_[c]) || failed_) continue;
    const double scaled = residual_[c] / watch.noise;
    for (Side* side : {&watch.above, &watch.below}) {
      side->sum = std::max(0.0, side->sum + std::min(most_a_step, side == &watch.above ? scaled : -scaled) - allowance);
      if (side->sum == 0.0) side->since_s = now_s;
      if (side->sum > alarm && !watch.said) {
        watch.said = true;
        departures.push_back({plant::ChannelId{c}, side->since_s, now_s});
      }
    }
  }
  return departures;
}

}  // namespace sinew::hil
