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
  sim::Recording result{.name = "", .columns = sim::columns_of(limb_.system()), .samples = {}};
  if (rows_.empty()) return result;
  const std::vector<double> none(readings_.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<sim::Sample> all = rows_;
  for (sim::Sample& tick : all) tick.channels = none;
  for (std::size_t c = 0; c < readings_.size(); ++c)
    for (const Reading& reading : readings_[c]) {
      if (reading.made_s < rows_.front().time_s) continue;
      all.push_back({reading.made_s, {}, none});
      all.back().channels[c] = reading.value;
    }
  std::ranges::stable_sort(all, {}, &sim::Sample::time_s);  // a tick before what was read at its time
  for (sim::Sample& row : all) {
    std::vector<sim::Sample>& done = result.samples;
    if (row.inputs.empty()) row.inputs = done.back().inputs;
    if (done.empty() || done.back().time_s != row.time_s) {
      done.push_back(std::move(row));
      continue;
    }
    for (std::size_t c = 0; c < row.channels.size(); ++c)
      if (!std::isnan(row.channels[c])) done.back().channels[c] = row.channels[c];
  }
  return result;
}

}  // namespace sinew::hil
