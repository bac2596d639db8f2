// SPDX-License-Identifier: Apache-2.0
// The limb in time by other means: the classical method of Runge and Kutta (1901) with a fixed step, on the equations but
// on nothing of plant/integrator.cpp. It stops at every jump of the duty and at every switch, which it works out itself.
//
// With a fixed step the result is as smooth in the parameters as the equations are, so that differences of two runs are
// free of the noise that a variable step makes, and may be small.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/validation/profile.h"

namespace sinew::test {

struct Sample {
  std::vector<double> state;
  std::vector<double> reading;  // [channels]
};

// States and readings at the sample times, which must increase and not be those of a jump.
inline std::vector<Sample> runge_kutta(const plant::Plant& limb, const std::vector<std::optional<double>>& given, const Profile& profile,
                                       const std::vector<double>& sample_times_s, double step_s) {
  const auto equations = limb.equations();
  const std::size_t n = limb.states().size();
  plant::Situation situation = idle(limb);
  std::vector<double> y = equations->rest(situation, given.empty() ? std::vector<std::optional<double>>(n) : given);

  const double delay_s = equations->input_delay_s();
  std::vector<double> marks = sample_times_s;
  for (const Jump& jump : profile.jumps) marks.push_back(jump.time_s + delay_s);
  for (const double switch_s : equations->switch_times_s()) marks.push_back(switch_s);
  std::sort(marks.begin(), marks.end());

  std::vector<Sample> samples;
  std::vector<double> k1(n), k2(n), k3(n), k4(n), at(n);
  const auto rates = [&](double time_s, const std::vector<double>& state, std::vector<double>& rate) {
    situation.time_s = time_s;
    equations->rates(situation, state.data(), rate.data());
  };
  double from_s = 0.0;
  for (const double to_s : marks) {
    // Rounded half-way between the whole numbers that marks on a grid give, so that the count of steps does not change
    // when a parameter moves a mark a little.
    const int count = 1 + static_cast<int>((to_s - from_s) / step_s + 0.5);
    const double h = (to_s - from_s) / count;
    situation.segment_start_s = from_s;
    for (const Jump& jump : profile.jumps)
      if (jump.time_s + delay_s <= from_s) situation.inputs = jump.duty_fraction;
    for (int s = 0; s < count && h > 0.0; ++s) {
      const double t = from_s + s * h;
      rates(t, y, k1);
      for (std::size_t i = 0; i < n; ++i) at[i] = y[i] + 0.5 * h * k1[i];
      rates(t + 0.5 * h, at, k2);
      for (std::size_t i = 0; i < n; ++i) at[i] = y[i] + 0.5 * h * k2[i];
      rates(t + 0.5 * h, at, k3);
      for (std::size_t i = 0; i < n; ++i) at[i] = y[i] + h * k3[i];
      rates(t + h, at, k4);
      for (std::size_t i = 0; i < n; ++i) y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    }
    from_s = to_s;
    if (samples.size() < sample_times_s.size() && to_s == sample_times_s[samples.size()]) {
      rates(to_s, y, k1);
      samples.push_back({y, std::vector<double>(limb.system().channels().size())});
      equations->readings(y.data(), samples.back().reading.data());
      if (samples.size() == sample_times_s.size()) break;
    }
  }
  return samples;
}

}  // namespace sinew::test
