// SPDX-License-Identifier: Apache-2.0
// One explanation of recordings: the core, and effects that are on, fitted with noise in the state.
//
// Maximises log N(r(z); 0, V) + log prior(z) over the unknowns z and the sizes of the forcings, in turns: with V held, a
// generalised least-squares problem (whitened by state_noise.h); with z held, the sizes. V is
// linearised anew along every trajectory that is reached.
//
// `log_evidence` is Laplace's: what is left after paying for every direction of z that the data pinned down. It compares
// explanations with different effects: one that has more freedom must explain more (MacKay 2003, Information Theory,
// Inference, and Learning Algorithms, chapter 28).
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "diagnose/varying.h"

namespace sinew::diagnose {

// Where a fit begins: values of unknowns by name, internal units, and sizes of forcings. What is not named begins at
// its prior's centre.
struct Guess {
  std::map<std::string, double> values;
  ForcingSize forcing{};            // empty: forcing_to_begin_with
  std::vector<bool> idle_before{};  // FitProblem::idle_before
  std::shared_ptr<const Course> course{};
};

// Where a guess is in a problem's coordinates; what it does not name at its prior's centre.
Eigen::VectorXd coordinates_of(const Guess& guess, const FitProblem& problem);

struct ExplanationSettings {
  Beginnings start;
  bool only_start = false;     // no parameters: only how the recordings begin
  bool least_squares = false;  // no forcings: sensors' noise alone, so that the path itself must fit
  plant::NumericalSettings numerics{plant::Method::rosenbrock, 1e-5};
  bool only_ordinary = false;      // forcings that are no sign of missing physics (EntryGroup::ordinary), and no others
  std::optional<Varying> varying;  // one more forcing
  int most_rounds = 6;
  int iterations_per_round = 12;
  double enough = 0.3;                // an improvement of the log posterior below this ends the fit
  std::function<bool()> should_stop;  // throws Stopped (calibrate.h) where it says so
};

struct Explanation {
  std::shared_ptr<const FitProblem> problem;
  std::shared_ptr<const Blocks> blocks;
  Eigen::VectorXd z;
  Eigen::MatrixXd covariance;  // of z
  Eigen::VectorXd residual;    // block rows, model - measured, in standard deviations of the sensors
  ForcingSize forcing;
  double varying_size = 0.0;    // deviation of the strength that varies
  double log_likelihood = 0.0;  // of the data at z and forcing
  double log_posterior = 0.0;   // with the prior of z
  double log_evidence = 0.0;
  // The data's distance from what a right model would leave, in squared standard deviations: r^T V0^-1 r - rows, with V0
  // of the sensors and surroundings that vary by as much as was found, and of what varies, if anything does.
  double misfit = 0.0;
  // 2 (log likelihood with all forcings - with the surroundings, and what varies, alone): what is still there that these do not explain.
  // 0, as `misfit`, of a fit by least squares, which has no forcings.
  double process_noise = 0.0;
  bool usable = false;

  plant::Plant model() const { return problem->plant_at(z.data()); }
  const plant::System& system() const { return problem->system(); }
  plant::Start start(std::size_t recording) const { return problem->start_at(z.data(), recording); }
  std::vector<plant::EffectId> effects() const;  // that are on
  double value(std::size_t unknown) const { return problem->value(unknown, z(static_cast<Eigen::Index>(unknown))); }
  double deviation(std::size_t unknown) const;
  std::pair<double, double> interval(std::size_t unknown, double deviations) const;  // that many to either side
  Guess as_guess() const;
};

// `centres`: what is on, and the centres of the priors. `data`: deviations are the sensors' noise.
// Not usable where the start cannot be integrated.
Explanation explain(const plant::Plant& centres, const std::vector<FitData>& data, const Guess& guess, const ExplanationSettings& settings);

// The same with the unknowns where they are and only `free` forcings re-estimated, or these up to what is ordinary: log likelihood.
double likelihood_with(const Explanation& at, const FreeForcings& free, ForcingSize* found = nullptr, bool only_ordinary = false);

// The process noise beside what is ordinary of all forcings (EntryGroup::ordinary), as air of its own at each wire. At most
// `at.process_noise`.
double process_noise_beyond_ordinary(const Explanation& at);

// What the forcings beside what is ordinary of them gain in twice the log posterior, if the unknowns are fitted again without them: the
// process noise, but for what other values of the parameters would do as well. At most `at.process_noise`.
double process_noise_after_refit(const Explanation& at, const std::vector<FitData>& data, const ExplanationSettings& settings);

// The same guess with other first values of one recording, which a fit that began at these does not feel (System::other_starts); of
// every recording that has such.
std::vector<Guess> with_other_starts(const Explanation& at);

// Share of the core's misfit that an explanation accounts for, 0 to 1.
double share_explained(const Explanation& core, const Explanation& by);

// The plant with one more effect on, at its null, its shape at what is typical.
plant::Plant with_effect(const plant::Plant& plant, plant::EffectId effect);

}  // namespace sinew::diagnose
