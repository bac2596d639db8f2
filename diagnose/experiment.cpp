// SPDX-License-Identifier: Apache-2.0
#include "diagnose/experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnose/calibrate.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::diagnose {
namespace {

struct Step {
  std::size_t coil;
  double from_s, until_s, height_fraction;
};
struct Programme {
  std::string words;
  double duration_s;
  std::vector<Step> steps;
};

std::vector<Programme> programmes(double most) {
  std::vector<Programme> all;
  for (const double duration_s : {120.0, 300.0}) {
    const auto add = [&](const std::string& words, double on_s, double off_s, bool in_turn, bool both, bool stairs) {
      Programme programme{words, duration_s, {}};
      int k = 0;
      for (double t = 5.0; t + on_s < duration_s; t += on_s + off_s, ++k) {
        const double height = most * (stairs ? 0.3 + 0.7 * static_cast<double>(k % 4) / 3.0 : 1.0);
        const std::size_t coil = in_turn ? static_cast<std::size_t>(k % 2) : 0;
        programme.steps.push_back({coil, t, t + on_s, height});
        if (both) programme.steps.push_back({1 - coil, t, t + on_s, height});
      }
      all.push_back(programme);
    };
    add("short pulses on both coils in turn", 4.0, 6.0, true, false, false);
    add("short pulses on coil A alone", 4.0, 8.0, false, false, false);
    add("long pulses on both coils in turn, with time to cool", 8.0, 40.0, true, false, false);
    add("pulses on both coils together", 5.0, 15.0, false, true, false);
    add("stairs of growing pulses on both coils in turn", 6.0, 14.0, true, false, true);
  }
  return all;
}

sim::Recording recording_of(const Programme& programme, double scale) {
  sim::Recording recording{"experiment", {}, {}, {}};
  for (int k = 0; 0.1 * k <= programme.duration_s; ++k) {
    sim::Sample sample{0.1 * k, {0.0, 0.0}, {0.0, 0.0}, 0.0};
    for (const Step& step : programme.steps)
      if (sample.time_s >= step.from_s - 1e-9 && sample.time_s < step.until_s - 1e-9)
        sample.duty_fraction[step.coil] += scale * step.height_fraction;
    recording.samples.push_back(sample);
  }
  return recording;
}

// Fills in what a limb would show, from rest; the hottest that a wire gets. NaN where it cannot be integrated.
double play(const plant::Limb<double>& limb, sim::Recording& recording, const plant::NumericalSettings& numerics) {
  double hottest = -300.0;
  plant::Integrator integrator(limb, plant::Start{}, numerics);
  const auto failure = sim::replay(integrator, recording.samples, [&](std::size_t k) {
    const plant::Reading<double> reading = integrator.reading();
    recording.samples[k].temperature_degC = reading.temperature_degC;
    recording.samples[k].angle_deg = reading.angle_rad / plant::radians_per_degree;
    for (const std::size_t j : plant::coils)
      hottest = std::max(hottest, integrator.state()[plant::core_state::temperature + j]);
  });
  return failure ? std::nan("") : hottest;
}

// How far what `recording` shows is from what the explanation's limb can be fitted to, to first order.
double distance(const Explanation& explanation, const sim::Recording& recording, const PerChannel& noise,
                double air_K) {
  const plant::Limb<double> limb = explanation.limb();
  const FitProblem problem(limb, fittable_parameters(limb), {{&recording, recording.samples.size(), noise}},
                           StartPolicy::at_rest, explanation.problem->numerics());
  const Blocks blocks(problem);
  const std::vector<double> z(problem.unknowns().size(), 0.0);
  Path path;
  if (!follow(problem, z.data(), Want::everything, path)) return 0.0;
  StateNoise state_noise(problem, blocks, z.data(), path);
  state_noise.set(only_air(air_K));
  Eigen::MatrixXd columns = blocks.means(path.jacobian.data(), z.size()),
                  difference = blocks.means(path.residuals.data(), 1);
  state_noise.whiten(columns);
  state_noise.whiten(difference);
  Eigen::MatrixXd information = columns.transpose() * columns;
  information.diagonal().array() += 1.0;
  const Eigen::VectorXd projected = columns.transpose() * difference.col(0);
  return std::sqrt(std::max(0.0, difference.squaredNorm() - projected.dot(information.llt().solve(projected))));
}

std::string yaml_of(const Programme& programme, double scale, const std::string& question) {
  std::string text = "# " + question + "\nformat: 1\nseed: 1\nduration_s: " + sim::shortest(programme.duration_s) +
                     "\nplant: { base: paper_limb }\ninput:\n";
  for (const std::size_t coil : plant::coils) {
    std::string steps;
    for (const Step& step : programme.steps)
      if (step.coil == coil)
        steps +=
            "    - step: { height_fraction: " + sim::shortest(std::round(1e4 * scale * step.height_fraction) / 1e4) +
            ", from_s: " + sim::shortest(step.from_s) + ", until_s: " + sim::shortest(step.until_s) + " }\n";
    if (!steps.empty()) text += std::string("  duty_") + (coil == 0 ? "A" : "B") + ":\n" + steps;
  }
  return text;
}

}  // namespace

Experiment design_experiment(const Explanation& first, const Explanation& second, const PerChannel& noise, double air_K,
                             const ExperimentLimits& limits) {
  Experiment best;
  const auto& numerics = first.problem->numerics();
  for (const Programme& programme : programmes(limits.largest_duty_fraction)) {
    double scale = 1.0, hottest = 0.0;
    sim::Recording of_second;
    for (int attempt = 0; attempt < 12; ++attempt, scale *= 0.9) {
      sim::Recording of_first = recording_of(programme, scale);
      of_second = of_first;
      hottest = std::max(play(first.limb(), of_first, numerics), play(second.limb(), of_second, numerics));
      if (hottest <= limits.hottest_degC) break;
    }
    if (!(hottest <= limits.hottest_degC)) continue;
    const double separation = distance(first, of_second, noise, air_K);
    // The square grows with time: compare per minute.
    if (best.duration_s > 0.0 &&
        separation * separation / programme.duration_s <= best.separation * best.separation / best.duration_s)
      continue;
    best.words = programme.words;
    best.duration_s = programme.duration_s;
    best.hottest_degC = hottest;
    best.largest_duty_fraction = scale * limits.largest_duty_fraction;
    best.separation = separation;
    best.scenario_yaml = yaml_of(programme, scale, "Which of the two explanations is right? " + programme.words + ".");
  }
  return best;
}

}  // namespace sinew::diagnose
