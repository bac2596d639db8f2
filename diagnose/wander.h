// SPDX-License-Identifier: Apache-2.0
// Where no effect explains a recording: what of the plant, if it were no constant but varied, would (varying.h).
#pragma once

#include <functional>
#include <optional>

#include "diagnose/locate.h"

namespace sinew::diagnose {

struct WanderSettings {
  std::vector<plant::EffectId> without{};  // effects that may not be named
  // What is upstream of some channels moves the others, too: where those are off, only that is asked (System::upstream_kind).
  bool upstream_is_off = true;
  int threads = 1;
  // In log evidence, over forcings of the single equations, and over the best in another place. What moves the
  // last channels alone is harder to tell apart. Chosen on seeds of development (docs/diagnosis.md).
  double least_gain = 100.0, least_margin = 50.0, least_margin_downstream = 300.0;
};

struct Wandering {
  Wanderer of;
  double correlation_time_s;
  double gain;             // of log evidence over forcings of the single equations
  double explained_share;  // of the core's misfit
  // All others that gain, best first, and how much less log evidence than this one (at one correlation time).
  std::vector<std::pair<Wanderer, double>> others;
  // The estimate over the fitted blocks of all recordings, in the unit of `of`. Pushes on the single equations carry what it
  // cannot.
  std::vector<std::size_t> recording;
  std::vector<double> time_s, value, deviation;
  double lowest, highest;  // 5 % and 95 % of `value`
  Dependence on;
};

// Nothing where no single thing stands out.
std::optional<Wandering> what_wanders(const Explanation& core, const WanderSettings& settings, const ExplanationSettings& fit);

}  // namespace sinew::diagnose
