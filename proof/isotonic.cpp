// SPDX-License-Identifier: Apache-2.0
#include "proof/isotonic.h"

#include <algorithm>
#include <cmath>

namespace sinew::proof {
namespace {

double log_odds_of(double probability) { return std::log(probability) - std::log1p(-probability); }

struct Pool {
  double lowest, highest;  // log odds
  Share came_true;
};

// Those of equal probability are one pool from the start.
std::vector<Pool> pools_of_equals(std::vector<Forecast> forecasts) {
  std::sort(forecasts.begin(), forecasts.end(), [](const Forecast& a, const Forecast& b) { return a.probability < b.probability; });
  std::vector<Pool> pools;
  for (const Forecast& one : forecasts) {
    const double at = log_odds_of(one.probability);
    if (pools.empty() || pools.back().highest != at) pools.push_back({at, at, {}});
    pools.back().came_true.add(one.came_true);
  }
  return pools;
}

Pool merged(const Pool& lower, const Pool& upper) {
  return {lower.lowest, upper.highest, {lower.came_true.good + upper.came_true.good, lower.came_true.all + upper.came_true.all}};
}

// Where in the stretch, 0 to 1. A finite place is infinitely nearer to a finite end than to an infinite one.
double share_of_way(double at, double from, double to) {
  if (std::isinf(from) && std::isinf(to)) return 0.5;
  if (std::isinf(from)) return 1.0;
  return (at - from) / (to - from);
}

}  // namespace

double MonotoneMap::operator()(double probability) const {
  if (log_odds.empty()) return std::nan("");
  const double at = log_odds_of(probability);
  const auto above = static_cast<std::size_t>(std::lower_bound(log_odds.begin(), log_odds.end(), at) - log_odds.begin());
  if (above == log_odds.size()) return frequency.back();
  if (above == 0 || log_odds[above] == at) return frequency[above];
  const double way = share_of_way(at, log_odds[above - 1], log_odds[above]);
  return frequency[above - 1] + way * (frequency[above] - frequency[above - 1]);
}

MonotoneMap isotonic(std::vector<Forecast> forecasts) {
  std::vector<Pool> pools;
  for (Pool next : pools_of_equals(std::move(forecasts))) {
    while (!pools.empty() && pools.back().came_true.value() >= next.came_true.value()) {
      next = merged(pools.back(), next);
      pools.pop_back();
    }
    pools.push_back(next);
  }
  MonotoneMap map;
  for (const Pool& pool : pools)
    for (const double at : {pool.lowest, pool.highest}) {
      if (!map.log_odds.empty() && map.log_odds.back() == at) continue;  // a pool of one probability
      map.log_odds.push_back(at);
      map.frequency.push_back(pool.came_true.value());
    }
  return map;
}

}  // namespace sinew::proof
