// SPDX-License-Identifier: Apache-2.0
// Takes an integrator through a profile and stops at sample times.
#pragma once

#include <doctest/doctest.h>

#include <vector>

#include "plant/integrator.h"
#include "tests/validation/profile.h"

namespace sinew::test {

inline void advance(plant::Integrator& run, double time_s) {
  const auto failure = run.advance_to(time_s);
  if (failure) FAIL(failure->reason);
}

// Commands what the profile says from where the run stands up to and including `until_s`.
inline void drive(plant::Integrator& run, const Profile& profile, double until_s) {
  const double from_s = run.time_s();
  for (const Jump& jump : profile.jumps) {
    if (jump.time_s < from_s || jump.time_s > until_s) continue;
    advance(run, jump.time_s);
    run.hold(jump.duty_fraction);
  }
  advance(run, until_s);
}

// Calls visit(k) at every sample time.
template <class Visitor>
void drive(plant::Integrator& run, const Profile& profile, const std::vector<double>& sample_times_s, Visitor&& visit) {
  for (std::size_t k = 0; k < sample_times_s.size(); ++k) {
    drive(run, profile, sample_times_s[k]);
    visit(k);
  }
}

// Between the jumps of a profile that jumps on multiples of 0.1 s, delayed by multiples of 0.1 s or not.
inline std::vector<double> sample_times_between_jumps(double end_s, double period_s = 0.2) {
  std::vector<double> times;
  for (int k = 0; 0.05 + period_s * k < end_s; ++k) times.push_back(0.05 + period_s * k);
  return times;
}

}  // namespace sinew::test
