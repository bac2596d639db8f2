// Where no effect explains a recording: what of the plant, if it were no constant but wandered, would (varying.h).
#pragma once

#include <functional>
#include <optional>

#include "diagnose/locate.h"

namespace sinew::diagnose {

struct WanderSettings {
  std::vector<std::size_t> without{};  // effects that may not be named
  // What is upstream of the temperatures moves the angle, too: where the temperatures are off, only that is asked.
  bool temperatures_are_off = true;
  int threads = 1;
  // In log evidence, over forcings of the single equations, and over the best in another place. What moves the angle
  // alone is harder to tell apart. Chosen on seeds of development (docs/diagnosis.md).
  double least_gain = 100.0, least_margin = 50.0, least_margin_of_angle = 300.0;
};

struct Wandering {
  Wanderer of;
  double correlation_time_s;
  double gain;             // of log evidence over forcings of the single equations
  double explained_share;  // of the core's misfit
  std::vector<std::pair<Wanderer, double>> others;  // the next best, and how much less log evidence they gain
  // Over the fitted blocks of all recordings: what would be added to the strength of an effect, in units of what is typical of
  // it, or relative change.
  std::vector<std::size_t> recording;
  std::vector<double> time_s, change, deviation;
  double lowest, highest;  // 5 % and 95 % of `change`
  Dependence on;
};

// Nothing where no single thing stands out.
std::optional<Wandering> what_wanders(const Explanation& core, const WanderSettings& settings,
                                      const ExplanationSettings& fit);

}  // namespace sinew::diagnose
