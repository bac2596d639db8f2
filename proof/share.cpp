// SPDX-License-Identifier: Apache-2.0
#include "proof/share.h"

#include <algorithm>
#include <cmath>

namespace sinew::proof {

double Share::value() const { return all > 0 ? static_cast<double>(good) / all : std::nan(""); }

Interval Share::interval() const {
  if (all == 0) return {std::nan(""), std::nan("")};
  constexpr double z = 1.959964;
  const double n = all, p = value(), middle = p + z * z / (2 * n), half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {(middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

}  // namespace sinew::proof
