// SPDX-License-Identifier: Apache-2.0
#include "diagnose/explanation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnose/calibrate.h"

namespace sinew::diagnose {
namespace {

// Linear equations about a path without forcings miss that these may push the plant over a corner. Where an explanation is off by more
// than so many deviations of what it should be, it is asked whether they did; unless each reading is off by so much, in squared
// deviations: no air does that.
constexpr double surely_off = 3.0;
constexpr double most_off = 10.0;
constexpr int most_courses = 4;

// W times columns of block rows, in place.
using Whiten = std::function<void(Eigen::Ref<Eigen::MatrixXd> columns)>;

// By the sensors' noise alone, a mean of so many samples: to the bit what the filter does that has no forcing.
void whiten_by_count(const Blocks& blocks, Eigen::Ref<Eigen::MatrixXd> columns) {
  for (std::size_t i = 0; i < blocks.rows().size(); ++i)
    columns.row(static_cast<Eigen::Index>(i)) /= std::sqrt(1.0 / blocks.rows()[i].count);
}

// Levenberg-Marquardt for 1/2 |W r(z)|^2 + 1/2 |z|^2 within bounds, W held. Ours because the bounded solver of the
// library evaluates the Jacobian, which is all the cost here, three times an iteration. Unknowns at a bound that the
// gradient pushes against it are held for that step; a step is cut off at the bounds.
class Fit {
 public:
  // `want`: what is followed at each step, with the Jacobian.
  Fit(FitProblem& problem, const Blocks& blocks, Want want) : problem_(problem), blocks_(blocks), want_(want) {
    for (const Unknown& u : problem.unknowns()) {
      low_.push_back(u.coordinate_of(u.lowest));
      high_.push_back(u.coordinate_of(u.highest));
    }
  }

  Eigen::VectorXd clamped(Eigen::VectorXd z, double margin) const {
    for (Eigen::Index u = 0; u < z.size(); ++u) {
      const double low = low_[static_cast<std::size_t>(u)], high = high_[static_cast<std::size_t>(u)];
      const double inside = margin * std::min(1.0, high - low);
      z(u) = std::clamp(z(u), low + inside, high - inside);
    }
    return z;
  }

  // Moves to z, with derivatives. False where it cannot be integrated.
  bool begin(const Eigen::VectorXd& z) {
    z_ = z;
    damping_ = 1e-3;
    if (!follow(problem_, z_.data(), want_, path_)) return false;
    linearise();
    return true;
  }

  // What the course does to the residuals, along the path as it is now.
  void linearise() {
    const auto& course = problem_.course();
    if (!course) return;
    auto now = std::make_shared<Course>(Course{course->states, course->pushes, response_to(problem_, path_, course->pushes)});
    for (std::size_t i = 0; i < path_.residuals.size(); ++i) path_.residuals[i] += course->response[i] - now->response[i];
    problem_.set_course(std::move(now));
  }

  const Eigen::VectorXd& z() const { return z_; }
  const Path& path() const { return path_; }
  Eigen::VectorXd residual() const { return blocks_.means(path_.residuals.data(), 1).col(0); }
  Eigen::MatrixXd jacobian() const { return blocks_.means(path_.jacobian.data(), problem_.unknowns().size()); }

  // Up to `most` steps; returns when one improves the cost by less than `enough`.
  void improve(const Whiten& whiten, int most, double enough, const std::function<bool()>& should_stop) {
    double cost = cost_of(path_, z_, whiten);
    for (int iteration = 0; iteration < most; ++iteration) {
      if (should_stop && should_stop()) throw Stopped{};
      Eigen::MatrixXd jacobian = this->jacobian();
      whiten(jacobian);
      Eigen::MatrixXd residual = this->residual();
      whiten(residual);
      Eigen::VectorXd gradient = jacobian.transpose() * residual.col(0) + z_;
      Eigen::MatrixXd information = jacobian.transpose() * jacobian;
      information.diagonal().array() += 1.0;
      FitProblem::RowMajor order_jacobian;
      if (const Eigen::VectorXd orders = problem_.order_residuals(z_.data(), &order_jacobian); orders.any()) {
        gradient += order_jacobian.transpose() * orders;
        information += order_jacobian.transpose() * order_jacobian;
      }
      bool moved = false;
      double gained = 0.0;
      for (int attempt = 0; attempt < 6 && !moved; ++attempt) {
        const Eigen::VectorXd tried = clamped(z_ + step(information, gradient), 0.0);
        // Most first attempts succeed, and with their derivatives at hand the next step can be taken.
        Path path;
        bool fine = follow(problem_, tried.data(), attempt == 0 ? want_ : Want::residuals, path);
        double tried_cost = fine ? cost_of(path, tried, whiten) : 1e300;
        if (attempt > 0 && tried_cost < cost) {
          fine = follow(problem_, tried.data(), want_, path);
          tried_cost = fine ? cost_of(path, tried, whiten) : 1e300;
        }
        if (tried_cost < cost) {
          moved = true;
          gained = cost - tried_cost;
          z_ = tried;
          path_ = std::move(path);
          cost = tried_cost;
          damping_ = std::max(1e-9, damping_ * 0.1);
        } else {
          damping_ = std::max(1e-4, damping_ * 10.0);
        }
      }
      if (!moved || gained < enough) return;
    }
  }

 private:
  Eigen::VectorXd step(const Eigen::MatrixXd& information, const Eigen::VectorXd& gradient) const {
    Eigen::MatrixXd damped = information;
    damped.diagonal() *= 1.0 + damping_;
    Eigen::VectorXd right = -gradient;
    for (Eigen::Index u = 0; u < z_.size(); ++u) {
      const auto i = static_cast<std::size_t>(u);
      const bool held = (z_(u) <= low_[i] && gradient(u) > 0.0) || (z_(u) >= high_[i] && gradient(u) < 0.0);
      if (!held) continue;
      damped.row(u).setZero();
      damped.col(u).setZero();
      damped(u, u) = 1.0;
      right(u) = 0.0;
    }
    return damped.ldlt().solve(right);
  }

  double cost_of(const Path& path, const Eigen::VectorXd& z, const Whiten& whiten) const {
    Eigen::MatrixXd residual = blocks_.means(path.residuals.data(), 1);
    whiten(residual);
    return 0.5 * (residual.squaredNorm() + z.squaredNorm()) + 0.5 * problem_.order_residuals(z.data(), nullptr).squaredNorm();
  }

  FitProblem& problem_;
  const Blocks& blocks_;
  Want want_;
  std::vector<double> low_, high_;
  Eigen::VectorXd z_;
  Path path_;
  double damping_ = 1e-3;
};

}  // namespace

std::vector<plant::EffectId> Explanation::effects() const {
  std::vector<plant::EffectId> on;
  for (const plant::EffectId e : system().effects().ids())
    if (problem->centres().is_on(e)) on.push_back(e);
  return on;
}

double Explanation::deviation(std::size_t unknown) const {
  const auto i = static_cast<Eigen::Index>(unknown);
  return std::sqrt(covariance(i, i)) * problem->unknowns()[unknown].slope_at(z(i));
}

std::pair<double, double> Explanation::interval(std::size_t unknown, double deviations) const {
  const auto i = static_cast<Eigen::Index>(unknown);
  const double error = deviations * std::sqrt(covariance(i, i));
  return {problem->value(unknown, z(i) - error), problem->value(unknown, z(i) + error)};
}

Guess Explanation::as_guess() const {
  Guess guess;
  for (std::size_t u = 0; u < problem->unknowns().size(); ++u) guess.values[problem->unknowns()[u].name] = value(u);
  guess.forcing = forcing;
  guess.idle_before = problem->idle_before();
  guess.course = problem->course();
  return guess;
}

namespace {

Explanation explain_as_begun(const plant::Plant& centres, const std::vector<FitData>& data, const Guess& guess,
                             const ExplanationSettings& settings);

// Where inputs act late, and a recording begins with a command in mid-motion, that command was held before or none was: as fits better.
void ask_what_was_before(Explanation& given, const std::vector<FitData>& data, const ExplanationSettings& settings) {
  if (!given.usable || given.problem->at_rest() || given.model().equations()->input_delay_s() <= 0.0) return;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const std::vector<double>& first = data[r].recording->samples.front().inputs;
    if (std::all_of(first.begin(), first.end(), [](double input) { return input == 0.0; })) continue;
    Guess guess = given.as_guess();
    guess.idle_before.resize(data.size(), false);
    guess.idle_before[r] = !guess.idle_before[r];
    Explanation other = explain_as_begun(given.problem->centres(), data, guess, settings);
    if (other.usable && other.log_posterior > given.log_posterior) given = std::move(other);
  }
}

// What is free, as it was found, but not less than what a search for the size of the surroundings can begin with.
ForcingSize sizes_to_begin_with(const Explanation& at, const FreeForcings& free) {
  ForcingSize size = no_forcing(at.system());
  for (const plant::EntryGroupId g : size.ids())
    if (const plant::EntryGroup& group = at.system().entry_groups()[g]; free[g]) size[g] = std::max(at.forcing[g], group.least);
  return size;
}

}  // namespace

Eigen::VectorXd coordinates_of(const Guess& guess, const FitProblem& problem) {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.unknowns().size()));
  for (std::size_t u = 0; u < problem.unknowns().size(); ++u)
    if (const auto given = guess.values.find(problem.unknowns()[u].name); given != guess.values.end())
      z(static_cast<Eigen::Index>(u)) = problem.unknowns()[u].coordinate_of(given->second);
  return z;
}

double process_noise_beyond_ordinary(const Explanation& at) {
  return std::min(at.process_noise, 2.0 * (at.log_likelihood - likelihood_with(at, ordinary_free(at.system()), nullptr, true)));
}

double process_noise_after_refit(const Explanation& at, const std::vector<FitData>& data, const ExplanationSettings& settings) {
  ExplanationSettings ordinary = settings;
  ordinary.only_ordinary = true;
  Guess guess = at.as_guess();
  guess.forcing = sizes_to_begin_with(at, ordinary_free(at.system()));
  const Explanation again = explain(at.problem->centres(), data, guess, ordinary);
  return again.usable ? std::min(at.process_noise, 2.0 * (at.log_posterior - again.log_posterior)) : at.process_noise;
}

std::vector<Guess> with_other_starts(const Explanation& at) {
  std::vector<Guess> guesses;
  const plant::Plant model = at.model();
  const plant::States states = model.states();
  const std::size_t recordings = at.problem->data().size();
  for (std::size_t r = 0; r < recordings; ++r) {
    const std::string owner = recordings == 1 ? "start." : "start[" + std::to_string(r) + "].";
    for (const auto& other : at.system().other_starts(model, at.start(r).given)) {
      Guess guess = at.as_guess();
      for (const auto& [state, value] : other) guess.values[owner + states[state].key] = value;
      guesses.push_back(guess);
    }
  }
  return guesses;
}

double share_explained(const Explanation& core, const Explanation& by) {
  if (core.misfit <= 0.0) return by.misfit <= core.misfit ? 1.0 : 0.0;
  return std::clamp(1.0 - std::max(0.0, by.misfit) / core.misfit, 0.0, 1.0);
}

plant::Plant with_effect(const plant::Plant& plant, plant::EffectId effect) {
  const auto& needs = plant.system().effects()[effect].needs;
  plant::Plant result = needs && !plant.is_on(*needs) ? with_effect(plant, *needs) : plant;
  result.turn(effect, true);
  for (const plant::ParameterId p : plant.system().effects()[effect].parameters) {
    const auto& declared = plant.system().parameters()[p].declaration;
    const bool toggle = declared.kind == plant::Kind::toggle;
    result.set_in_file_units(p, declared.null_value && !toggle ? *declared.null_value : declared.typical);
  }
  return result;
}

double likelihood_with(const Explanation& at, const FreeForcings& free, ForcingSize* found, bool only_ordinary) {
  Path path;
  follow(*at.problem, at.z.data(), Want::points, path);
  StateNoise noise(*at.problem, *at.blocks, at.z.data(), path, nullptr, free);
  ForcingSize begin = no_forcing(at.system());
  for (const plant::EntryGroupId g : begin.ids())
    if (free[g]) begin[g] = std::max(at.forcing[g], 0.1 * at.system().entry_groups()[g].typical);
  const ForcingSize size = noise.maximise(at.residual, begin, free, 1.3, only_ordinary);
  if (found) *found = size;
  return noise.log_likelihood(at.residual);
}

Explanation explain(const plant::Plant& centres, const std::vector<FitData>& data, const Guess& guess,
                    const ExplanationSettings& settings) {
  Explanation result = explain_as_begun(centres, data, guess, settings);
  ask_what_was_before(result, data, settings);
  return result;
}

namespace {

// One explanation in the making.
class Explainer {
 public:
  Explainer(const plant::Plant& centres, const std::vector<FitData>& data, const Guess& guess, const ExplanationSettings& settings)
      : settings_(settings),
        problem_(std::make_shared<FitProblem>(centres,
                                              settings.only_start ? std::vector<plant::ParameterId>{} : fittable_parameters(centres), data,
                                              settings.start, settings.numerics)),
        blocks_(std::make_shared<Blocks>(*problem_)),
        fit_(*problem_, *blocks_, settings.least_squares ? Want::derivatives : Want::everything),
        free_(settings.only_ordinary ? ordinary_free(centres.system()) : all_free(centres.system())),
        size_(settings.least_squares  ? no_forcing(centres.system())
              : guess.forcing.empty() ? forcing_to_begin_with(centres.system())
                                      : guess.forcing) {
    problem_->set_idle_before(guess.idle_before);
    if (!settings.least_squares) problem_->set_course(guess.course);
    for (const plant::EntryGroupId g : size_.ids())
      if (!free_[g]) size_[g] = 0.0;
    found_.of.problem = problem_;
    found_.of.blocks = blocks_;
    found_.of.log_posterior = none;
  }

  Explanation run(const Guess& guess) {
    const Eigen::VectorXd z = fit_.clamped(coordinates_of(guess, *problem_), 1e-3);
    if (!fit_again_from(z) && !(problem_->course() && fit_about_no_course(z))) return found_.of;
    if (found_.noise && !settings_.varying) {
      // A guess's course is that of another explanation: where it leads to none of its own, there is none.
      if (found_.course) {
        const Found begun = found_;
        if (!fit_along(StateNoise::Of::surroundings) || !settle_along_the_surroundings()) {
          size_ = begun.of.forcing;
          if (!fit_about_no_course(begun.of.z)) return found_.of;
        }
      }
      const auto rows = static_cast<double>(blocks_->rows().size());
      if (!found_.course && found_.of.misfit > surely_off * std::sqrt(2.0 * rows) && found_.of.misfit < most_off * rows) follow_courses();
    }
    problem_->set_course(found_.course);
    weigh_freedom();
    return std::move(found_.of);
  }

 private:
  static constexpr double none = -1e300;  // log posterior of no explanation

  // An explanation, and what belongs to it.
  struct Found {
    Explanation of;
    bool finely = false;       // sizes of forcings were found to the last
    Eigen::MatrixXd jacobian;  // of the block rows
    std::shared_ptr<StateNoise> noise;
    std::shared_ptr<const Course> course;  // along which it holds
  };

  void whiten(Eigen::Ref<Eigen::MatrixXd> columns) const { noise_ ? noise_->whiten(columns) : whiten_by_count(*blocks_, columns); }

  // Unknowns and sizes of forcings in turn, from where the fit is; what is likelier than what was found replaces it. Sizes are found
  // coarsely until that gains no more, then finely.
  void fit() {
    const Whiten by_noise = [this](Eigen::Ref<Eigen::MatrixXd> columns) { whiten(columns); };
    bool finely = settings_.least_squares;
    for (int round = 0; round <= settings_.most_rounds; ++round) {
      if (!settings_.least_squares) {
        VaryingPush push;
        if (settings_.varying && !varying_push(*problem_, fit_.z().data(), *settings_.varying, push)) break;
        noise_ =
            std::make_shared<StateNoise>(*problem_, *blocks_, fit_.z().data(), fit_.path(), settings_.varying ? &push : nullptr, free_);
        if (found_.noise && settings_.varying) noise_->set(size_, found_.of.varying_size);
      }
      finely = finely || round == settings_.most_rounds;
      double gained = gain_here(finely);
      if (gained < settings_.enough && !finely) {
        finely = true;
        gained = gain_here(finely);
      }
      if (gained < settings_.enough || round == settings_.most_rounds) break;
      fit_.improve(by_noise, settings_.iterations_per_round, settings_.enough, settings_.should_stop);
      fit_.linearise();
    }
    if (found_.noise && !found_.finely) {
      Explanation& of = found_.of;
      found_.noise->set(of.forcing, of.varying_size);
      of.forcing = found_.noise->maximise(of.residual, of.forcing, free_, 1.3, settings_.only_ordinary);
      of.varying_size = found_.noise->varying_size();
      const double likelihood = found_.noise->log_likelihood(of.residual);
      of.log_posterior += likelihood - of.log_likelihood;
      of.log_likelihood = likelihood;
      found_.finely = true;
    }
  }

  // How much likelier than what was found the best sizes are where the fit is.
  double gain_here(bool finely) {
    const Eigen::VectorXd residual = fit_.residual();
    if (noise_) size_ = noise_->maximise(residual, size_, free_, finely ? 1.3 : 1.6, settings_.only_ordinary);
    Eigen::MatrixXd whitened = residual;
    whiten(whitened);
    const double likelihood = -0.5 * (whitened.squaredNorm() + (noise_ ? noise_->log_determinant() : 0.0));
    const double posterior =
        likelihood - 0.5 * fit_.z().squaredNorm() - 0.5 * problem_->order_residuals(fit_.z().data(), nullptr).squaredNorm();
    const double gained = posterior - found_.of.log_posterior;
    if (gained > 0.0) {
      found_.of.z = fit_.z();
      found_.of.residual = residual;
      found_.of.forcing = size_;
      found_.of.varying_size = noise_ ? noise_->varying_size() : 0.0;
      found_.of.log_likelihood = likelihood;
      found_.of.log_posterior = posterior;
      found_.jacobian = fit_.jacobian();
      found_.finely = finely;
      found_.noise = noise_;
      found_.course = problem_->course();
    }
    return gained;
  }

  void weigh_by_surroundings() {
    if (!found_.noise) return;
    Explanation& of = found_.of;
    const FreeForcings surroundings = nuisance_free(of.system());
    static_cast<void>(found_.noise->maximise(of.residual, sizes_to_begin_with(of, surroundings), surroundings, 1.3));
    of.process_noise = 2.0 * (of.log_likelihood - found_.noise->log_likelihood(of.residual));
    Eigen::MatrixXd whitened = of.residual;
    found_.noise->whiten(whitened);
    of.misfit = whitened.squaredNorm() - static_cast<double>(blocks_->rows().size());
  }

  // Along the likeliest course of all forcings, which takes it off a corner, and from there along that of the surroundings alone.
  void follow_courses() {
    if (!problem_->system().surroundings()) return;
    const Found without = found_;
    if (!fit_along(StateNoise::Of::all) || !fit_along(StateNoise::Of::surroundings) || !settle_along_the_surroundings() ||
        found_.of.log_posterior < without.of.log_posterior)
      found_ = without;
  }

  bool fit_about_no_course(const Eigen::VectorXd& z) {
    problem_->set_course(nullptr);
    return fit_again_from(z);
  }

  // The path follows the likeliest course of the surroundings, the equations are linear about that, and it is fitted again: until that
  // changes nothing. Measures that are linear do not hold as far away as the next course may be; an explanation that is less likely along
  // its own course than it seemed to be is none. Where the courses come to no end, the likeliest of the others was found; false where
  // there is none.
  bool settle_along_the_surroundings() {
    std::optional<Found> likeliest;
    for (int k = 0; k < most_courses; ++k) {
      const Found before = found_;
      if (!fit_along(StateNoise::Of::surroundings)) break;
      const double gained = found_.of.log_posterior - before.of.log_posterior;
      if (gained < -settings_.enough) continue;
      const bool settled = gained < settings_.enough;
      if (settled || !likeliest || before.of.log_posterior > likeliest->of.log_posterior) likeliest = settled ? found_ : before;
      if (settled) break;
    }
    if (likeliest) found_ = std::move(*likeliest);
    return likeliest.has_value();
  }

  // False where it cannot be integrated, as the two that follow.
  bool fit_again_from(const Eigen::VectorXd& z) {
    found_.of.log_posterior = none;
    if (!fit_.begin(z)) return false;
    fit();
    if (found_.of.log_posterior == none) return false;
    weigh_by_surroundings();
    return true;
  }

  bool fit_along(StateNoise::Of which) {
    size_ = found_.of.forcing;
    return move_to_course(which) && fit_again_from(Eigen::VectorXd(found_.of.z));
  }

  bool move_to_course(StateNoise::Of which) {
    problem_->set_course(found_.course);
    const double* z = found_.of.z.data();
    Path path;
    if (!follow(*problem_, z, Want::points, path)) return false;
    found_.noise->set(found_.of.forcing);
    Course next{.states = {},
                .pushes = found_.noise->pushes(found_.of.residual, *problem_, z, path, which),
                .response = std::vector<double>(problem_->rows().size(), 0.0)};
    for (const plant::StateInfo& state : problem_->centres().states()) next.states.push_back(state.key);
    const bool moves = std::any_of(next.pushes.begin(), next.pushes.end(), [](const Eigen::MatrixXd& push) { return !push.isZero(0.0); });
    problem_->set_course(moves ? std::make_shared<const Course>(std::move(next)) : nullptr);
    return true;
  }

  // Laplace.
  void weigh_freedom() {
    Explanation& of = found_.of;
    const auto n = static_cast<Eigen::Index>(problem_->unknowns().size());
    Eigen::MatrixXd& sensitivity = found_.jacobian;
    if (found_.noise) {
      found_.noise->set(of.forcing, of.varying_size);
      found_.noise->whiten(sensitivity);
    } else {
      whiten_by_count(*blocks_, sensitivity);
    }
    Eigen::MatrixXd information = sensitivity.transpose() * sensitivity + Eigen::MatrixXd::Identity(n, n);
    FitProblem::RowMajor order_jacobian;
    if (problem_->order_residuals(of.z.data(), &order_jacobian).any()) information += order_jacobian.transpose() * order_jacobian;
    const Eigen::LLT<Eigen::MatrixXd> factor(information);
    of.covariance = factor.solve(Eigen::MatrixXd::Identity(n, n));
    double log_determinant = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) log_determinant += 2.0 * std::log(factor.matrixL()(i, i));
    of.log_evidence = of.log_posterior - 0.5 * log_determinant;
    of.usable = std::isfinite(of.log_evidence);
  }

  const ExplanationSettings& settings_;
  const std::shared_ptr<FitProblem> problem_;
  const std::shared_ptr<Blocks> blocks_;
  Fit fit_;
  const FreeForcings free_;
  ForcingSize size_;
  std::shared_ptr<StateNoise> noise_;  // along the fit's path; null in least squares
  Found found_;
};

Explanation explain_as_begun(const plant::Plant& centres, const std::vector<FitData>& data, const Guess& guess,
                             const ExplanationSettings& settings) {
  return Explainer(centres, data, guess, settings).run(guess);
}

}  // namespace

}  // namespace sinew::diagnose
