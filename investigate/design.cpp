// SPDX-License-Identifier: Apache-2.0
#include "investigate/design.h"

#include <algorithm>
#include <atomic>

#include "diagnose/calibrate.h"
#include "sim/parallel.h"

namespace sinew::investigate {
Design design(const Question& question, const DesignSettings& settings) {
  Design result;
  result.before_nat = question.entropy_nat();
  result.farthest.resize(question.alternatives.size());
  // What tells next to nothing in a short time is no experiment while another tells.
  const double enough_nat = settings.least_share * result.before_nat;
  const auto tells_more = [&](const Expected& a, const Expected& b) {
    if (a.possible != b.possible) return a.possible;
    const bool enough = a.information_nat > enough_nat;
    if (enough != (b.information_nat > enough_nat)) return enough;
    return a.per_minute() > b.per_minute();
  };
  const plant::System& system = question.alternatives.front().model.system();
  const std::vector<Shape> first = first_shapes(system, settings.longest_drive_s);
  const std::size_t in_all = first.size() + static_cast<std::size_t>(settings.rounds) * settings.varied * 8;
  std::atomic<std::size_t> done{0};
  const auto evaluate = [&](const std::vector<Shape>& shapes) {
    std::vector<Expected> expected(shapes.size());
    sim::in_parallel(shapes.size(), settings.threads, [&](std::size_t i) {
      if (settings.should_stop && settings.should_stop()) throw diagnose::Stopped{};
      expected[i] = expected_of(question, shapes[i], settings.longest_s);
      if (settings.progress) settings.progress(static_cast<double>(++done) / static_cast<double>(in_all));
    });
    for (const Expected& one : expected)
      if (one.possible) {
        for (std::size_t j = 0; j < one.from_first.size(); ++j) result.farthest[j] = std::max(result.farthest[j], one.from_first[j]);
      }
    result.tried += shapes.size();
    return expected;
  };
  std::vector<Expected> best = evaluate(first);
  std::stable_sort(best.begin(), best.end(), tells_more);
  best.resize(std::min(best.size(), settings.varied));
  for (int round = 0; round < settings.rounds; ++round) {
    std::vector<Shape> shapes;
    for (const Expected& one : best)
      if (one.possible)
        for (const Shape& shape : neighbours(one.programme.shape, settings.longest_drive_s)) shapes.push_back(shape);
    for (Expected& one : evaluate(shapes)) best.push_back(std::move(one));
    std::stable_sort(best.begin(), best.end(), tells_more);
    best.resize(std::min(best.size(), settings.varied));
  }
  if (!best.empty()) result.best = std::move(best.front());
  result.tells = result.best.possible && result.best.information_nat > enough_nat;
  return result;
}

}  // namespace sinew::investigate
