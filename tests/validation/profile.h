// SPDX-License-Identifier: Apache-2.0
// A duty that does to the limb what the babbling experiment does: jumps like those of a PI law that chases setpoints,
// in both coils, so that each fraction goes through its loop, turns inside it, and the limb bends past 30 degrees both ways.
#pragma once

#include <vector>

#include "tests/plant/limb/one_instant.h"

namespace sinew::test {

struct Jump {
  double time_s;
  std::vector<double> duty_fraction;
};

struct Profile {
  std::vector<Jump> jumps;  // the first at 0
  double end_s;
};

// Jumps fall on multiples of 0.4 s. The law's saturation at 0.6 and its decay towards a setpoint are drawn by hand, its
// ripple is a small sawtooth.
inline Profile babbling_profile() {
  struct Stretch {
    double until_s, start, end;
    std::size_t coil;
  };
  constexpr Stretch drawn[] = {{4.8, 0.60, 0.55, A},  {8.0, 0.25, 0.12, A},  {13.6, 0.00, 0.00, A},
                               {20.0, 0.30, 0.55, B}, {24.0, 0.45, 0.40, B}, {26.8, 0.075, 0.00, B},
                               {31.6, 0.50, 0.60, A}, {33.2, 0.02, 0.00, A}, {36.0, 0.40, 0.60, B}};
  Profile profile{{}, 36.0};
  double from_s = 0.0;
  for (const Stretch& s : drawn) {
    const int count = static_cast<int>((s.until_s - from_s) / 0.4 + 0.5);
    for (int k = 0; k < count; ++k) {
      const double share = static_cast<double>(k) / count;
      std::vector<double> duty{0.0, 0.0};
      duty[s.coil] = s.start + share * (s.end - s.start) + (s.start > 0.1 ? 0.02 * (k % 3) : 0.0);
      profile.jumps.push_back({from_s + 0.4 * k, duty});
    }
    from_s = s.until_s;
  }
  return profile;
}

}  // namespace sinew::test
