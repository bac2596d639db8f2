// SPDX-License-Identifier: Apache-2.0
#include "diagnose/thinned.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::diagnose {

Thinned thinned(const plant::System& system, const std::vector<FitData>& data) {
  const auto recordings = std::make_shared<std::vector<sim::Recording>>();
  Thinned result{recordings, data, {}};
  for (const FitData& one : data) {
    const auto& samples = one.recording->samples;
    sim::Recording few = *one.recording;
    plant::ListOf<plant::ChannelId, std::size_t> every;
    for (const plant::ChannelId c : system.channels().ids()) {
      const auto [rows, period_s] = measured_rows(*one.recording, c);
      // Rounding must not make of five samples four.
      const double per_average = system.averaging_s() / period_s * (1.0 + 1e-6);
      every.push_back(per_average >= 1.0 ? static_cast<std::size_t>(per_average) : 1);
      for (std::size_t i = 0; i < rows.size(); ++i)
        if (i % every[c] != 0) measured(few.samples[rows[i]], c) = std::numeric_limits<double>::quiet_NaN();
    }
    std::vector<sim::Sample> kept;
    for (std::size_t k = 0; k < one.sample_count; ++k) {
      const auto changes_to = [&](std::size_t other) { return other < samples.size() && samples[k].inputs != samples[other].inputs; };
      const bool last = k + 1 == one.sample_count;
      const bool shows = !std::ranges::all_of(few.samples[k].channels, [](double value) { return std::isnan(value); });
      if (k == 0 || shows || last || changes_to(k - 1) || changes_to(k + 1)) kept.push_back(few.samples[k]);
    }
    few.samples = std::move(kept);
    result.every.push_back(std::move(every));
    recordings->push_back(std::move(few));
  }
  for (std::size_t r = 0; r < data.size(); ++r) {
    result.data[r].recording = &(*recordings)[r];
    result.data[r].sample_count = (*recordings)[r].samples.size();
  }
  return result;
}

}  // namespace sinew::diagnose
