// SPDX-License-Identifier: Apache-2.0
#include "hil/clock_map.h"

#include <algorithm>
#include <cmath>

namespace sinew::hil {
namespace {

constexpr double bucket_us = 250'000.0, window_us = 10e6;
constexpr double least_span_us = 500'000.0;  // less tells nothing of the skew
constexpr double most_skew = 0.012;
constexpr double fastest_bend = 2e-3;
constexpr std::int64_t settling_us = 2'000'000;

}  // namespace

void ClockMap::begin(std::uint32_t device_us, std::int64_t host_us) {
  last_device_us_ = device_us;
  device_us_ = 0;
  host_0_us_ = host_us_ = static_cast<double>(host_us);
  skew_ = 0.0;
  earliest_.assign(1, {0.0, 0.0});
}

void ClockMap::keep(const Frame& frame) {
  Frame& last = earliest_.back();
  if (std::floor(frame.device_us / bucket_us) > std::floor(last.device_us / bucket_us))
    earliest_.push_back(frame);
  else if (frame.late_us - skew_ * (frame.device_us - last.device_us) < last.late_us)
    last = frame;
  while (earliest_.front().device_us < frame.device_us - window_us) earliest_.pop_front();
}

double ClockMap::fit() {
  // The lower convex hull, from left to right.
  hull_.clear();
  for (const Frame& frame : earliest_) {
    while (hull_.size() >= 2) {
      const Frame &a = hull_[hull_.size() - 2], &b = hull_.back();
      if ((b.late_us - a.late_us) * (frame.device_us - a.device_us) < (frame.late_us - a.late_us) * (b.device_us - a.device_us)) break;
      hull_.pop_back();
    }
    hull_.push_back(frame);
  }
  const double begin_us = hull_.front().device_us, span_us = hull_.back().device_us - begin_us;
  if (span_us >= least_span_us) {
    const auto slope_at = [&](double share) {
      std::size_t k = 1;
      while (k + 1 < hull_.size() && hull_[k].device_us < begin_us + share * span_us) ++k;
      return (hull_[k].late_us - hull_[k - 1].late_us) / (hull_[k].device_us - hull_[k - 1].device_us);
    };
    // Slopes of a convex hull grow from left to right.
    skew_ = std::clamp(0.0, std::max(slope_at(0.25), -most_skew), std::max(-most_skew, slope_at(0.75)));
    skew_ = std::min(skew_, most_skew);
  }
  double late_us = HUGE_VAL;
  for (const Frame& frame : hull_) late_us = std::min(late_us, frame.late_us + skew_ * (static_cast<double>(device_us_) - frame.device_us));
  return late_us;
}

std::int64_t ClockMap::take(std::uint32_t device_us, std::int64_t arrived_us) {
  const auto passed_us = static_cast<double>(static_cast<std::int32_t>(device_us - last_device_us_));
  if (passed_us > 0.0) {
    last_device_us_ = device_us;
    device_us_ += static_cast<std::int64_t>(passed_us);
    const auto now_us = static_cast<double>(device_us_);
    keep({now_us, static_cast<double>(arrived_us) - host_0_us_ - now_us});
    const double line_us = host_0_us_ + now_us + fit();
    host_us_ += passed_us * (1.0 + skew_);
    const double most = device_us_ < settling_us ? HUGE_VAL : fastest_bend * passed_us;
    host_us_ += std::clamp(line_us - host_us_, -most, most);
  }
  return static_cast<std::int64_t>(host_us_);
}

std::uint32_t ClockMap::device_us(std::int64_t host_us) const {
  const double since = (static_cast<double>(host_us) - host_us_) / (1.0 + skew_);
  return last_device_us_ + static_cast<std::uint32_t>(static_cast<std::int64_t>(since));
}

}  // namespace sinew::hil
