// SPDX-License-Identifier: Apache-2.0
#include "diagnose/thinned.h"

#include <algorithm>
#include <cmath>

namespace sinew::diagnose {

Thinned thinned(const plant::System& system, const std::vector<FitData>& data) {
  const auto recordings = std::make_shared<std::vector<sim::Recording>>();
  Thinned result{recordings, data, {}};
  for (const FitData& one : data) {
    const auto& samples = one.recording->samples;
    // Rounding must not make of five samples four.
    const double per_average = system.averaging_s() / one.recording->median_period_s() * (1.0 + 1e-6);
    const std::size_t every = per_average >= 1.0 ? static_cast<std::size_t>(per_average) : 1;
    sim::Recording few = *one.recording;
    few.samples.clear();
    for (std::size_t k = 0; k < one.sample_count; ++k) {
      const auto changes_to = [&](std::size_t other) { return other < samples.size() && samples[k].inputs != samples[other].inputs; };
      const bool last = k + 1 == one.sample_count;
      if (k % every != 0 && !last && !changes_to(k - 1) && !changes_to(k + 1)) continue;
      few.samples.push_back(samples[k]);
      if (k % every != 0) mask(few.samples.back());
    }
    result.every.push_back(every);
    recordings->push_back(std::move(few));
  }
  for (std::size_t r = 0; r < data.size(); ++r) {
    result.data[r].recording = &(*recordings)[r];
    result.data[r].sample_count = (*recordings)[r].samples.size();
  }
  return result;
}

}  // namespace sinew::diagnose
