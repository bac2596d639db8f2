// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sinew::report {

// An interval of numbers on an axis; low < high once it is drawn.
struct Range {
  double low = 0.0;
  double high = 1.0;
};

// Where an axis is labelled: multiples of a step of 1, 2 or 5 times a power of ten.
struct Ticks {
  std::vector<double> values{};  // ascending, all inside the range asked for
  double step = 1.0;
  int decimals = 0;  // digits after the point that tell two ticks apart
};

// The finest such ticks of which no more than `at_most` (taken as at least 2) lie in the range.
// Rounding to the range's edge is forgiven, so [0, 0.3] has a tick at 0.3.
Ticks nice_ticks(Range range, int at_most);

// The label of one tick: fixed decimals with a true minus sign, or an exponent beyond a million
// and below a step of 1e-5.
std::string tick_label(double value, const Ticks& ticks);

// Widens `range` so that it holds every finite one of `values`; an empty range is low > high.
inline constexpr Range no_range{1.0, -1.0};
Range including(Range range, const std::vector<double>& values);
Range including(Range range, double value);
inline bool is_empty(Range range) { return !(range.low <= range.high); }

// `range` with `fraction` of its width added on either side. A single value gets room around it, an empty
// range becomes [0, 1].
Range padded(Range range, double fraction);

}  // namespace sinew::report
