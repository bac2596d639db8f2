// SPDX-License-Identifier: Apache-2.0
// What every block bootstrap here has in common: stretches of a recording are drawn with replacement, and the middle 95 % of what
// the draws give is the interval.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace sinew::diagnose {

inline constexpr double bootstrap_block_s = 20.0;  // longest stretch: what the air does is forgotten after it
inline constexpr std::size_t bootstrap_draws = 400;

// Lowest and highest of the middle 95 % of `bootstrap_draws` values, in any order.
inline std::pair<double, double> middle_95(std::vector<double> draws) {
  std::sort(draws.begin(), draws.end());
  return {draws[bootstrap_draws / 40], draws[bootstrap_draws - 1 - bootstrap_draws / 40]};
}

}  // namespace sinew::diagnose
