// SPDX-License-Identifier: Apache-2.0
#include "investigate/usual_strength.h"

#include <algorithm>
#include <limits>

#include "diagnose/path.h"
#include "diagnose/projection.h"
#include "diagnose/state_noise.h"
#include "sim/parallel.h"

namespace sinew::investigate {
namespace {

using diagnose::Explanation;

constexpr double far_off = 100.0;  // nats of log posterior below the base's: no other beginning of the fit makes up for that
constexpr int most_steps = 5;

// Where the path is nearest to the base's, by Gauss-Newton with the base's derivatives and its noise. A fit that begins there is not led
// astray by large forcings, which it takes where it begins far off.
diagnose::Guess nearest_to(const Explanation& base, const diagnose::Projection& so_far, const plant::Plant& centres) {
  const diagnose::FitProblem& problem = *base.problem;
  diagnose::FitProblem with(centres, problem.parameters(), problem.data(), problem.beginnings(), problem.numerics());
  with.set_idle_before(problem.idle_before());
  with.set_course(problem.course());
  diagnose::Guess guess = base.as_guess(), nearest = guess;
  double least = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= most_steps; ++step) {
    diagnose::Path path;
    if (!follow(with, coordinates_of(guess, with).data(), diagnose::Want::residuals, path)) break;
    Eigen::MatrixXd difference = base.blocks->means(path.residuals.data(), 1);
    difference.col(0) -= base.residual;
    if (!difference.allFinite()) break;
    so_far.whiten(difference);
    if (difference.squaredNorm() >= least) break;
    least = difference.squaredNorm();
    nearest = guess;
    const Eigen::VectorXd z = coordinates_of(guess, problem) + so_far.of(difference).columns.col(0).tail(base.z.size());
    for (std::size_t u = 0; u < problem.unknowns().size(); ++u) {
      const diagnose::Unknown& unknown = problem.unknowns()[u];
      guess.values[unknown.name] = std::clamp(problem.value(u, z(static_cast<Eigen::Index>(u))), unknown.lowest, unknown.highest);
    }
  }
  return nearest;
}

std::shared_ptr<const Explanation> fitted(const Explanation& base, const diagnose::Projection& so_far, plant::EffectId effect,
                                          double strength_in_file_units, const diagnose::ExplanationSettings& settings) {
  const plant::System& system = base.system();
  const plant::ParameterId strength = system.effects()[effect].strength;
  plant::Plant centres = diagnose::with_effect(base.problem->centres(), effect);
  centres.set_in_file_units(strength, strength_in_file_units);
  centres.set_own_deviation(strength, 0.0);
  diagnose::Guess guess = base.as_guess();
  guess.forcing = diagnose::small_forcing(system);
  diagnose::ExplanationSettings shortly = settings;
  shortly.most_rounds = 1;
  Explanation best = explain(centres, base.problem->data(), guess, shortly);
  if (best.usable && best.log_posterior < base.log_posterior - far_off) return std::make_shared<const Explanation>(std::move(best));
  for (const diagnose::Guess& from : {best.usable ? best.as_guess() : guess, nearest_to(base, so_far, centres)}) {
    Explanation other = explain(centres, base.problem->data(), from, settings);
    if (other.usable && (!best.usable || other.log_posterior > best.log_posterior)) best = std::move(other);
  }
  return best.usable ? std::make_shared<const Explanation>(std::move(best)) : nullptr;
}

// Where the strength may be on either side of its null, the likelier of the two.
std::shared_ptr<const Explanation> fitted(const Explanation& base, const diagnose::Projection& so_far, plant::EffectId effect,
                                          const diagnose::ExplanationSettings& settings) {
  const plant::System& system = base.system();
  const plant::Declaration& declared = system.parameters()[system.effects()[effect].strength].declaration;
  auto one = fitted(base, so_far, effect, declared.typical, settings);
  const double other_side = 2.0 * declared.null_value.value_or(0.0) - declared.typical;
  if (!declared.null_value || other_side < declared.range.lowest || other_side > declared.range.highest) return one;
  auto other = fitted(base, so_far, effect, other_side, settings);
  return !one || (other && other->log_evidence > one->log_evidence) ? other : one;
}

}  // namespace

AtUsualStrength at_usual_strength(const Explanation& base, const std::vector<plant::EffectId>& effects,
                                  const diagnose::SearchSettings& settings) {
  diagnose::ExplanationSettings fit = settings.fit;
  fit.start = base.problem->beginnings();
  fit.numerics = base.problem->numerics();
  const diagnose::Projection so_far(base);
  AtUsualStrength result{std::vector<std::shared_ptr<const Explanation>>(effects.size()), base.log_evidence};
  sim::in_parallel(effects.size(), settings.threads, [&](std::size_t i) { result.with[i] = fitted(base, so_far, effects[i], fit); });
  const Explanation* likeliest = nullptr;
  for (const auto& one : result.with)
    if (one && (!likeliest || one->log_evidence > likeliest->log_evidence)) likeliest = one.get();
  if (likeliest && likeliest->log_evidence > base.log_evidence) {
    const Explanation again = explain(base.problem->centres(), base.problem->data(), likeliest->as_guess(), fit);
    if (again.usable) result.log_evidence_without = std::max(base.log_evidence, again.log_evidence);
  }
  return result;
}

}  // namespace sinew::investigate
