// SPDX-License-Identifier: Apache-2.0
#include "diagnose/experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnose/calibrate.h"
#include "plant/laws.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::diagnose {
namespace {

struct Step {
  std::size_t input;
  double from_s, until_s, share;  // of the input's range
};
struct Programme {
  std::string words;
  double duration_s;
  std::vector<Step> steps;
};

std::vector<Programme> programmes(const plant::System& system, double most) {
  const std::size_t inputs = system.inputs().size();
  const std::string all_of_them = (inputs == 2 ? "both " : "all ") + std::string(system.parts_word());
  std::vector<Programme> all;
  for (const double duration_s : {120.0, 300.0}) {
    const auto add = [&](const std::string& words, double on_s, double off_s, bool in_turn, bool together, bool stairs) {
      Programme programme{words, duration_s, {}};
      std::size_t k = 0;
      for (double t = 5.0; t + on_s < duration_s; t += on_s + off_s, ++k) {
        const double share = most * (stairs ? 0.3 + 0.7 * static_cast<double>(k % 4) / 3.0 : 1.0);
        const std::size_t first = in_turn ? k % inputs : 0;
        for (std::size_t i = 0; i < (together ? inputs : 1); ++i) programme.steps.push_back({(first + i) % inputs, t, t + on_s, share});
      }
      all.push_back(programme);
    };
    add("short pulses on " + all_of_them + " in turn", 4.0, 6.0, true, false, false);
    add("short pulses on " + system.inputs()[plant::InputId{0}].part + " alone", 4.0, 8.0, false, false, false);
    add("long pulses on " + all_of_them + " in turn, with time to cool", 8.0, 40.0, true, false, false);
    add("pulses on " + all_of_them + " together", 5.0, 15.0, false, true, false);
    add("stairs of growing pulses on " + all_of_them + " in turn", 6.0, 14.0, true, false, true);
  }
  return all;
}

double value_of(const plant::System& system, const Step& step, double scale) {
  return scale * step.share * system.inputs()[plant::InputId{step.input}].range.highest;
}

sim::Recording recording_of(const plant::System& system, const Programme& programme, double scale) {
  sim::Recording recording{.name = "experiment", .columns = sim::columns_of(system)};
  for (int k = 0; 0.1 * k <= programme.duration_s; ++k) {
    sim::Sample sample{0.1 * k, std::vector<double>(system.inputs().size(), 0.0), std::vector<double>(system.channels().size(), 0.0)};
    for (const Step& step : programme.steps)
      if (sample.time_s >= step.from_s - 1e-9 && sample.time_s < step.until_s - 1e-9)
        sample.inputs[step.input] += value_of(system, step, scale);
    recording.samples.push_back(sample);
  }
  return recording;
}

struct Played {
  double highest = -std::numeric_limits<double>::infinity();  // of all states that have a limit
  bool is_safe = true;                                        // and could be integrated
};

// Fills in what a plant would show, from rest.
Played play(const plant::Plant& plant, sim::Recording& recording, const plant::NumericalSettings& numerics) {
  Played played;
  const plant::System& system = plant.system();
  plant::Integrator integrator(plant, plant::Start{}, numerics);
  const plant::States states = integrator.states();
  const auto failure = sim::replay(integrator, system, recording.samples, [&](std::size_t k) {
    recording.samples[k].channels = sim::in_file_units(system, integrator.readings());
    for (const plant::StateId i : states.ids()) {
      if (!std::isfinite(states[i].safe_until)) continue;
      const double value = integrator.state()[i.index];
      played.highest = std::max(played.highest, value);
      played.is_safe = played.is_safe && value <= states[i].safe_until;
    }
  });
  played.is_safe = played.is_safe && !failure;
  return played;
}

// How far what `recording` shows is from what the explanation's plant can be fitted to, to first order.
double distance(const Explanation& explanation, const sim::Recording& recording, const PerChannel& noise) {
  const plant::Plant plant = explanation.model();
  const FitProblem problem(plant, fittable_parameters(plant), {{&recording, recording.samples.size(), noise}}, StartPolicy::at_rest,
                           explanation.problem->numerics());
  const Blocks blocks(problem);
  const std::vector<double> z(problem.unknowns().size(), 0.0);
  Path path;
  if (!follow(problem, z.data(), Want::everything, path)) return 0.0;
  StateNoise state_noise(problem, blocks, z.data(), path);
  ForcingSize surroundings = no_forcing(plant.system());
  for (const plant::EntryGroupId g : surroundings.ids())
    if (const plant::EntryGroup& group = plant.system().entry_groups()[g]; group.is_nuisance) surroundings[g] = group.typical;
  state_noise.set(surroundings);
  Eigen::MatrixXd columns = blocks.means(path.jacobian.data(), z.size()), difference = blocks.means(path.residuals.data(), 1);
  state_noise.whiten(columns);
  state_noise.whiten(difference);
  Eigen::MatrixXd information = columns.transpose() * columns;
  information.diagonal().array() += 1.0;
  const Eigen::VectorXd projected = columns.transpose() * difference.col(0);
  return std::sqrt(std::max(0.0, difference.squaredNorm() - projected.dot(information.llt().solve(projected))));
}

std::string yaml_of(const plant::Plant& plant, const Programme& programme, double scale, const std::string& question) {
  const plant::System& system = plant.system();
  std::string text = "# " + question + "\nformat: 1\nseed: 1\nduration_s: " + sim::shortest(programme.duration_s) + "\nplant:";
  text += system.structure_yaml().empty() ? " { base: paper_limb }\n" : "\n" + sim::plant_to_yaml(plant::as_in_file(plant), 2);
  text += "input:\n";
  for (const plant::InputId i : system.inputs().ids()) {
    const std::string unit = system.inputs()[i].unit.text.empty() ? "fraction" : std::string(system.inputs()[i].unit.text);
    std::string steps;
    for (const Step& step : programme.steps)
      if (step.input == i.index)
        steps += "    - step: { height_" + unit + ": " + sim::shortest(std::round(1e4 * value_of(system, step, scale)) / 1e4) +
                 ", from_s: " + sim::shortest(step.from_s) + ", until_s: " + sim::shortest(step.until_s) + " }\n";
    if (!steps.empty()) text += "  " + system.inputs()[i].column + ":\n" + steps;
  }
  return text;
}

}  // namespace

Experiment design_experiment(const Explanation& first, const Explanation& second, const PerChannel& noise, const ExperimentLimits& limits) {
  Experiment best;
  const plant::System& system = first.system();
  const plant::States states = first.model().states();
  if (std::none_of(states.begin(), states.end(), [](const plant::StateInfo& state) { return std::isfinite(state.safe_until); }))
    return best;
  const auto& numerics = first.problem->numerics();
  for (const Programme& programme : programmes(system, limits.largest_share)) {
    double scale = 1.0;
    Played of_either;
    sim::Recording of_second;
    for (int attempt = 0; attempt < 12; ++attempt, scale *= 0.9) {
      sim::Recording of_first = recording_of(system, programme, scale);
      of_second = of_first;
      const Played one = play(first.model(), of_first, numerics), other = play(second.model(), of_second, numerics);
      of_either = {std::max(one.highest, other.highest), one.is_safe && other.is_safe};
      if (of_either.is_safe) break;
    }
    if (!of_either.is_safe) continue;
    const double separation = distance(first, of_second, noise);
    // The square grows with time: compare per minute.
    if (best.duration_s > 0.0 && separation * separation / programme.duration_s <= best.separation * best.separation / best.duration_s)
      continue;
    best.words = programme.words;
    best.duration_s = programme.duration_s;
    best.highest = of_either.highest;
    best.largest_share = scale * limits.largest_share;
    best.separation = separation;
    best.scenario_yaml = yaml_of(first.model(), programme, scale, "Which of the two explanations is right? " + programme.words + ".");
  }
  return best;
}

}  // namespace sinew::diagnose
