// SPDX-License-Identifier: Apache-2.0
#include "diagnose/wander.h"

#include <algorithm>
#include <cmath>

#include "plant/contains.h"
#include "sim/parallel.h"

namespace sinew::diagnose {
namespace {

constexpr double first_time_s = 30.0;  // correlation time with which all are tried
constexpr std::array other_times_s{10.0, 100.0};

bool is_upstream(const plant::System& system, std::string_view place) {
  const auto& places = system.upstream_places();
  return contains(places, place);
}

}  // namespace

std::optional<Wandering> what_wanders(const Explanation& core, const WanderSettings& settings, const ExplanationSettings& fit) {
  struct Tried {
    Varying varying;
    Explanation explanation;
    double gain = -1e300;
  };
  const auto try_it = [&](Tried& one) {
    ExplanationSettings with = fit;
    with.varying = one.varying;
    with.most_rounds = 2;
    one.explanation = explain(core.problem->centres(), core.problem->data(), core.as_guess(), with);
    if (one.explanation.usable) one.gain = one.explanation.log_evidence - core.log_evidence;
  };
  std::vector<Tried> all;
  for (const Wanderer& one : wanderers(core.model(), settings.without))
    if (is_upstream(core.system(), one.place) == settings.upstream_is_off) all.push_back({{one, first_time_s}, {}});
  if (all.empty()) return std::nullopt;
  sim::in_parallel(all.size(), settings.threads, [&](std::size_t i) { try_it(all[i]); });
  std::stable_sort(all.begin(), all.end(), [](const Tried& a, const Tried& b) { return a.gain > b.gain; });
  const Tried& leading = all.front();
  const auto elsewhere =
      std::find_if(all.begin(), all.end(), [&](const Tried& other) { return other.varying.of.place != leading.varying.of.place; });
  const double margin = leading.gain - std::max(0.0, elsewhere == all.end() ? 0.0 : elsewhere->gain);
  if (leading.gain < settings.least_gain || margin < (settings.upstream_is_off ? settings.least_margin : settings.least_margin_downstream))
    return std::nullopt;

  std::array<Tried, other_times_s.size()> again;
  sim::in_parallel(again.size(), settings.threads, [&](std::size_t i) {
    again[i].varying = {leading.varying.of, other_times_s[i]};
    try_it(again[i]);
  });
  const Tried* best = &leading;
  for (const Tried& one : again)
    if (one.gain > best->gain) best = &one;

  const Explanation& by = best->explanation;
  Wandering result{
      best->varying.of, best->varying.correlation_time_s, best->gain, share_explained(core, by), {}, {}, {}, {}, {}, 0.0, 0.0, {}};
  for (std::size_t i = 1; i < all.size(); ++i)
    if (all[i].gain > 0.0) result.others.emplace_back(all[i].varying.of, leading.gain - all[i].gain);
  Path path;
  VaryingPush push;
  if (!follow(*by.problem, by.z.data(), Want::points, path) || !varying_push(*by.problem, by.z.data(), best->varying, push))
    return std::nullopt;
  StateNoise noise(*by.problem, *by.blocks, by.z.data(), path, &push);
  noise.set(by.forcing, by.varying_size);
  const Smoothed smoothed = noise.smooth(by.residual);
  for (std::size_t b = 0; b < by.blocks->blocks().size(); ++b) {
    const auto i = static_cast<Eigen::Index>(b);
    result.recording.push_back(by.blocks->blocks()[b].recording);
    result.time_s.push_back(by.blocks->blocks()[b].time_s);
    // The residual is model - measured: what the limb has and the model has not is the opposite.
    result.value.push_back(result.of.centre - result.of.scale * smoothed.varying(i));
    result.deviation.push_back(std::abs(result.of.scale) * smoothed.varying_deviation(i));
  }
  std::vector<double> sorted = result.value;
  std::sort(sorted.begin(), sorted.end());
  result.lowest = sorted[sorted.size() / 20];
  result.highest = sorted[sorted.size() - 1 - sorted.size() / 20];
  const auto course = Eigen::Map<const Eigen::VectorXd>(result.value.data(), smoothed.varying.size());
  result.on = depends_on(by, course, {});
  return result;
}

}  // namespace sinew::diagnose
