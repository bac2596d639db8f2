// SPDX-License-Identifier: Apache-2.0
#include "hil/timed_recording.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::hil {
namespace {

// Two rows may have one reading; its age is in whole milliseconds, and the clocks drift.
constexpr double same_reading_s = 0.003;

}  // namespace

TimedRecording::TimedRecording(const plant::Plant& limb)
    : limb_(limb), parts_(parts_of(limb)), readings_(limb.system().channels().size()) {}

void TimedRecording::add(const SessionView& view) {
  rows_.push_back({view.time_s, view.duty_fraction, {}});
  const auto put = [&](plant::ChannelId channel, double made_s) {
    std::vector<Reading>& readings = readings_[channel.index];
    const double value = view.measured.channels[channel.index];
    if (std::isnan(value) || (!readings.empty() && made_s < readings.back().made_s + same_reading_s)) return;
    readings.push_back({made_s, value});
  };
  for (const plant::ChannelId c : parts_.thermocouples) put(c, view.time_s - view.temperature_age_s);
  for (const plant::ChannelId c : parts_.angles) put(c, view.time_s - view.angle_age_s);
}

sim::Recording TimedRecording::recording() const {
  sim::Recording result{.name = "", .columns = sim::columns_of(limb_.system()), .samples = rows_};
  for (sim::Sample& row : result.samples) {
    for (const std::vector<Reading>& readings : readings_) {
      const auto after =
          std::lower_bound(readings.begin(), readings.end(), row.time_s, [](const Reading& r, double t) { return r.made_s < t; });
      double value = std::numeric_limits<double>::quiet_NaN();
      if (after != readings.end() && after != readings.begin() && after->made_s - std::prev(after)->made_s <= longest_gap_s) {
        const Reading &a = *std::prev(after), &b = *after;
        value = a.value + (b.value - a.value) * (row.time_s - a.made_s) / (b.made_s - a.made_s);
      }
      row.channels.push_back(value);
    }
  }
  return result;
}

}  // namespace sinew::hil
