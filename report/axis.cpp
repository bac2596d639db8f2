// SPDX-License-Identifier: Apache-2.0
#include "report/axis.h"

#include <algorithm>
#include <cmath>

#include "report/number.h"

namespace sinew::report {

namespace {

constexpr double edge_slack = 1e-9;  // of a step: what counts as rounding at the range's edge

// k * mantissa * 10^exponent, rounded once: 3 * 0.1 is the double that prints as 0.3.
double multiple(double k, int mantissa, int exponent) {
  const double scale = std::pow(10.0, std::abs(exponent));
  return exponent >= 0 ? k * mantissa * scale : k * mantissa / scale;
}

}  // namespace

Ticks nice_ticks(Range range, int at_most) {
  const double span = range.high - range.low;
  Ticks ticks;
  if (!std::isfinite(span) || span <= 0.0) {
    if (std::isfinite(range.low)) ticks.values = {range.low};
    return ticks;
  }
  const double limit = std::max(at_most, 2);
  int exponent = static_cast<int>(std::floor(std::log10(span / limit)));
  for (;; ++exponent) {
    for (const int mantissa : {1, 2, 5}) {
      const double step = multiple(1.0, mantissa, exponent);
      const double first = std::ceil(range.low / step - edge_slack);
      const double last = std::floor(range.high / step + edge_slack);
      if (last - first + 1.0 > limit) continue;
      ticks.step = step;
      ticks.decimals = std::max(0, -exponent);
      for (double k = first; k <= last; k += 1.0) ticks.values.push_back(multiple(k, mantissa, exponent) + 0.0);
      return ticks;
    }
  }
}

std::string tick_label(double value, const Ticks& ticks) {
  std::string label;
  if (std::abs(value) >= 1e6 || (ticks.step < 1e-5 && value != 0.0)) {
    const int digits = 1 + static_cast<int>(std::floor(std::log10(std::abs(value) / ticks.step) + edge_slack));
    label = scientific(value, std::clamp(digits, 1, 15));
  } else {
    label = fixed(value, ticks.step < 1e-5 ? 0 : ticks.decimals);
  }
  return label.starts_with('-') ? "\u2212" + label.substr(1) : label;
}

Range including(Range range, double value) {
  if (!std::isfinite(value)) return range;
  if (is_empty(range)) return {value, value};
  return {std::min(range.low, value), std::max(range.high, value)};
}

Range including(Range range, const std::vector<double>& values) {
  for (const double value : values) range = including(range, value);
  return range;
}

Range padded(Range range, double fraction) {
  if (is_empty(range)) return {};
  double room = (range.high - range.low) * fraction;
  if (!(range.high - range.low > 1e-12 * std::max(std::abs(range.low), std::abs(range.high)))) {
    room = range.low == 0.0 ? 1.0 : 0.1 * std::abs(range.low);
  }
  return {range.low - room, range.high + room};
}

}  // namespace sinew::report
