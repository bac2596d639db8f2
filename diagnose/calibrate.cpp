// SPDX-License-Identifier: Apache-2.0
#include "diagnose/calibrate.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "diagnose/path.h"
#include "sim/random.h"

namespace sinew::diagnose {
namespace {

// Residuals up to this many times the noise are taken for noise: its estimate is good to a few per cent.
constexpr double noise_margin = 1.1;

class AllRows : public ceres::CostFunction {
 public:
  AllRows(const FitProblem& problem, bool along_the_path) : problem_(problem), along_the_path_(along_the_path) {
    set_num_residuals(static_cast<int>(problem.residual_count()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.unknowns().size()));
  }
  // A step is asked for twice: along the bounds, and once it is chosen. What its residuals were is kept.
  bool Evaluate(double const* const* z, double* residuals, double** jacobians) const override {
    double* jacobian = jacobians ? jacobians[0] : nullptr;
    if (!jacobian && std::equal(last_z_.begin(), last_z_.end(), z[0], z[0] + problem_.unknowns().size())) {
      std::copy(last_residuals_.begin(), last_residuals_.end(), residuals);
      return true;
    }
    last_z_.clear();
    if (!(along_the_path_ ? along_the_path(z[0], residuals, jacobian) : problem_.evaluate(z[0], residuals, jacobian))) return false;
    last_z_.assign(z[0], z[0] + problem_.unknowns().size());
    last_residuals_.assign(residuals, residuals + num_residuals());
    return true;
  }

 private:
  bool along_the_path(const double* z, double* residuals, double* jacobian) const {
    Path path;
    if (!follow(problem_, z, jacobian ? Want::derivatives : Want::residuals, path)) return false;
    const std::size_t unknowns = problem_.unknowns().size();
    double* rest = std::copy(path.residuals.begin(), path.residuals.end(), residuals);
    rest = std::copy(z, z + unknowns, rest);
    FitProblem::RowMajor order_jacobian;
    const Eigen::VectorXd orders = problem_.order_residuals(z, jacobian ? &order_jacobian : nullptr);
    std::copy(orders.begin(), orders.end(), rest);
    if (!jacobian) return true;
    double* below = std::copy(path.jacobian.begin(), path.jacobian.end(), jacobian);
    std::fill(below, below + unknowns * unknowns, 0.0);
    for (std::size_t u = 0; u < unknowns; ++u) below[u * unknowns + u] = 1.0;
    std::copy(order_jacobian.data(), order_jacobian.data() + order_jacobian.size(), below + unknowns * unknowns);
    return true;
  }

  const FitProblem& problem_;
  bool along_the_path_;
  mutable std::vector<double> last_z_, last_residuals_;  // of the last point; none where it could not be integrated
};

class Watch : public ceres::IterationCallback {
 public:
  Watch(const CalibrationSettings& settings, std::function<void(int)> tell) : settings_(settings), tell_(std::move(tell)) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    tell_(summary.iteration);
    return settings_.should_stop && settings_.should_stop() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const CalibrationSettings& settings_;
  std::function<void(int)> tell_;
};

std::vector<double> lower_bounds(const FitProblem& problem) {
  std::vector<double> z;
  for (const Unknown& u : problem.unknowns()) z.push_back(u.coordinate_of(u.lowest));
  return z;
}
std::vector<double> upper_bounds(const FitProblem& problem) {
  std::vector<double> z;
  for (const Unknown& u : problem.unknowns()) z.push_back(u.coordinate_of(u.highest));
  return z;
}

// The first start is the prior's centre; the others are drawn from half the prior around it.
std::vector<double> start_coordinates(const FitProblem& problem, std::uint64_t seed, int start) {
  const std::vector<double> low = lower_bounds(problem), high = upper_bounds(problem);
  const sim::RandomStream chance(seed, "calibrate.start." + std::to_string(start));
  std::vector<double> z(problem.unknowns().size(), 0.0);
  for (std::size_t u = 0; u < z.size(); ++u) {
    if (start > 0) z[u] = 0.5 * chance.normal(u);
    const double margin = 1e-3 * std::min(1.0, high[u] - low[u]);
    z[u] = std::clamp(z[u], low[u] + margin, high[u] - margin);
  }
  return z;
}

struct Solved {
  FitProblem problem;  // with the deviations of the last pass
  std::vector<double> z;
  StartOutcome outcome;
  bool stopped = false;
};

// rms, or rms * sqrt(correlation length), of each channel's residuals, at least its noise. Empty where z cannot be
// integrated.
std::vector<PerChannel> deviations_at(const FitProblem& problem, const std::vector<double>& z, const std::vector<FitData>& noise,
                                      bool count_correlation) {
  std::vector<double> residuals(problem.residual_count());
  if (!problem.evaluate(z.data(), residuals.data(), nullptr)) return {};
  std::vector<PerChannel> deviations;
  for (std::size_t r = 0; r < noise.size(); ++r) {
    PerChannel deviation = noise[r].deviation;
    for (const plant::ChannelId c : problem.system().channels().ids()) {
      std::vector<double> of_channel;
      double squares = 0.0;
      for (std::size_t i = 0; i < problem.rows().size(); ++i) {
        if (problem.rows()[i].recording != r || problem.rows()[i].channel != c) continue;
        of_channel.push_back(residuals[i] * problem.data()[r].deviation[c]);
        squares += of_channel.back() * of_channel.back();
      }
      if (of_channel.empty()) continue;
      const double rms = std::sqrt(squares / static_cast<double>(of_channel.size()));
      // Residuals of the size of noise are taken for noise.
      if (rms > noise_margin * deviation[c]) deviation[c] = rms * (count_correlation ? std::sqrt(correlation_samples(of_channel)) : 1.0);
    }
    deviations.push_back(deviation);
  }
  return deviations;
}

void set_deviations(FitProblem& problem, const std::vector<PerChannel>& deviations) {
  for (std::size_t r = 0; r < deviations.size(); ++r)
    for (const plant::ChannelId c : problem.system().channels().ids()) problem.set_deviation(r, c, deviations[r][c]);
}

bool settled(const FitProblem& problem, const std::vector<PerChannel>& deviations) {
  for (std::size_t r = 0; r < deviations.size(); ++r)
    for (const plant::ChannelId c : problem.system().channels().ids())
      if (std::abs(std::log(deviations[r][c] / problem.data()[r].deviation[c])) > 0.1) return false;
  return true;
}

double cost_of(const FitProblem& problem, const std::vector<double>& z) {
  std::vector<double> residuals(problem.residual_count());
  if (!problem.evaluate(z.data(), residuals.data(), nullptr)) return std::numeric_limits<double>::infinity();
  double squares = 0.0;
  for (const double r : residuals) squares += r * r;
  return 0.5 * squares;
}

// Least squares with the problem's deviations, from and into solved.z.
void one_pass(Solved& solved, const CalibrationSettings& settings, const std::function<void(int)>& tell) {
  AllRows cost(solved.problem, settings.along_the_path);
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(options);
  ceres_problem.AddResidualBlock(&cost, nullptr, solved.z.data());
  const std::vector<double> low = lower_bounds(solved.problem), high = upper_bounds(solved.problem);
  for (std::size_t u = 0; u < low.size(); ++u) {
    ceres_problem.SetParameterLowerBound(solved.z.data(), static_cast<int>(u), low[u]);
    ceres_problem.SetParameterUpperBound(solved.z.data(), static_cast<int>(u), high[u]);
  }
  Watch watch(settings, [&](int iteration) { tell(solved.outcome.iterations + iteration); });
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = settings.iterations_per_pass;
  solver.function_tolerance = 1e-4;
  solver.parameter_tolerance = 1e-6;
  // A step along the bounds is judged by its cost alone; the default asks for derivatives there, too, and again once it is taken.
  solver.line_search_interpolation_type = ceres::QUADRATIC;
  solver.logging_type = ceres::SILENT;
  solver.num_threads = 1;
  solver.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  solved.stopped = summary.termination_type == ceres::USER_FAILURE;
  solved.outcome.iterations += static_cast<int>(summary.iterations.size());
  solved.outcome.usable = summary.IsSolutionUsable();
  ++solved.outcome.passes;
}

// First to the data: passes in which each channel's deviation is the rms of its residuals, only ever downwards, so that a
// channel that got worse while the others got better is not given up for it. Then to what is believed: one pass in which
// residuals that stay correlated count as the few independent ones that they are, so that a little error is not bought with
// absurd parameters.
Solved solve_from(const FitProblem& problem, const CalibrationSettings& settings, int start, const std::function<void(int)>& tell) {
  Solved solved{problem, start_coordinates(problem, settings.seed, start), {}, false};
  const auto pass = [&](bool count_correlation, bool first) {
    auto deviations = deviations_at(solved.problem, solved.z, problem.data(), count_correlation);
    if (deviations.empty()) {
      solved.outcome.usable = false;
      return false;
    }
    if (!first && !count_correlation) {
      for (std::size_t r = 0; r < deviations.size(); ++r)
        for (const plant::ChannelId c : problem.system().channels().ids())
          deviations[r][c] = std::min(deviations[r][c], solved.problem.data()[r].deviation[c]);
      if (settled(solved.problem, deviations)) return false;
    }
    set_deviations(solved.problem, deviations);
    one_pass(solved, settings, tell);
    return solved.outcome.usable && !solved.stopped;
  };
  int passes = 0;
  while (passes < settings.most_passes && pass(false, passes == 0)) ++passes;
  if (solved.outcome.usable && !solved.stopped) pass(true, false);
  return solved;
}

// Posterior covariance in scaled coordinates.
Eigen::MatrixXd covariance(const FitProblem& problem, const std::vector<double>& z) {
  const std::size_t rows = problem.residual_count(), columns = problem.unknowns().size();
  std::vector<double> residuals(rows);
  FitProblem::RowMajor jacobian(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
  if (!problem.evaluate(z.data(), residuals.data(), jacobian.data())) throw std::runtime_error("the calibrated plant cannot be integrated");
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  information.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
  const Eigen::MatrixXd full = information.selfadjointView<Eigen::Lower>();
  return full.llt().solve(Eigen::MatrixXd::Identity(full.rows(), full.cols()));
}

std::vector<Estimate> estimates_of(const FitProblem& problem, const std::vector<double>& z) {
  const Eigen::MatrixXd cov = covariance(problem, z);
  const std::vector<double> low = lower_bounds(problem), high = upper_bounds(problem);
  std::vector<Estimate> estimates;
  for (std::size_t u = 0; u < z.size(); ++u) {
    const auto i = static_cast<Eigen::Index>(u);
    const Unknown& unknown = problem.unknowns()[u];
    Estimate estimate{unknown,
                      problem.value(u, z[u]),
                      std::sqrt(cov(i, i)) * unknown.slope_at(z[u]),
                      std::sqrt(cov(i, i)),
                      std::min(z[u] - low[u], high[u] - z[u]) < 1e-4,
                      "",
                      0.0};
    for (std::size_t v = 0; v < z.size(); ++v) {
      const auto j = static_cast<Eigen::Index>(v);
      const double correlation = cov(i, j) / std::sqrt(cov(i, i) * cov(j, j));
      if (v != u && std::abs(correlation) > std::abs(estimate.partner_correlation)) {
        estimate.partner = problem.unknowns()[v].name;
        estimate.partner_correlation = correlation;
      }
    }
    estimates.push_back(std::move(estimate));
  }
  return estimates;
}

}  // namespace

std::vector<plant::ParameterId> fittable_parameters(const plant::Plant& plant) {
  std::vector<plant::ParameterId> fittable;
  const auto& all = plant.system().parameters();
  for (const plant::ParameterId p : all.ids())
    if (plant.deviation(p) > 0.0 && (!all[p].effect || plant.is_on(*all[p].effect))) fittable.push_back(p);
  return fittable;
}

plant::Plant with_signs_of(const plant::Plant& nominal, const std::vector<FitData>& data, const Beginnings& start,
                           const plant::NumericalSettings& numerics, std::vector<plant::ParameterId>& flipped) {
  plant::Plant plant = nominal;
  const auto cost = [&](const plant::Plant& candidate) {
    const FitProblem problem(candidate, {}, data, start, numerics);
    return cost_of(problem, std::vector<double>(problem.unknowns().size(), 0.0));
  };
  for (const plant::ParameterId p : nominal.system().parameters().ids()) {
    if (nominal.system().parameters()[p].declaration.kind != plant::Kind::sign) continue;
    plant::Plant other = plant;
    other.set(p, -plant.get(p));
    if (cost(other) < cost(plant)) {
      plant = other;
      flipped.push_back(p);
    }
  }
  return plant;
}

Calibration calibrate(const plant::Plant& nominal, const std::vector<FitData>& data, const CalibrationSettings& settings) {
  Calibration result;
  std::vector<plant::ParameterId> free = settings.parameters;
  if (free.empty() && !settings.only_start) free = fittable_parameters(nominal);
  const plant::Plant with_signs =
      settings.only_start ? nominal : with_signs_of(nominal, data, settings.start, settings.numerics, result.flipped_signs);
  const FitProblem problem(with_signs, free, data, settings.start, settings.numerics);
  const auto starts = static_cast<std::size_t>(std::max(1, settings.starts));
  std::vector<Solved> solved(starts, Solved{problem, {}, {}, false});
  std::vector<double> done(starts, 0.0);
  std::mutex telling;
  std::atomic<std::size_t> next{0};
  std::exception_ptr trouble;
  const auto work = [&] {
    for (std::size_t s = next++; s < starts; s = next++) {
      try {
        if (settings.should_stop && settings.should_stop()) {
          solved[s].stopped = true;
          continue;
        }
        solved[s] = solve_from(problem, settings, static_cast<int>(s), [&](int iteration) {
          // How far a fit is cannot be known; most need some 25 iterations.
          const std::scoped_lock lock(telling);
          done[s] = std::max(done[s], 1.0 - std::exp(-iteration / 12.0));
          double sum = 0.0;
          for (const double share : done) sum += share;
          if (settings.progress) settings.progress(sum / static_cast<double>(starts));
        });
        const std::scoped_lock lock(telling);
        done[s] = 1.0;
      } catch (...) {
        const std::scoped_lock lock(telling);
        trouble = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 1; t < std::min(starts, static_cast<std::size_t>(std::max(1, settings.threads))); ++t) threads.emplace_back(work);
    work();
  }
  if (trouble) std::rethrow_exception(trouble);
  for (const Solved& one : solved)
    if (one.stopped) throw Stopped{};

  // Each start ended with deviations of its own; their geometric mean is the yardstick for all.
  FitProblem yardstick = problem;
  const auto usable = std::count_if(solved.begin(), solved.end(), [](const Solved& one) { return one.outcome.usable; });
  for (std::size_t r = 0; r < data.size() && usable > 0; ++r)
    for (const plant::ChannelId c : problem.system().channels().ids()) {
      double sum = 0.0;
      for (const Solved& one : solved)
        if (one.outcome.usable) sum += std::log(one.problem.data()[r].deviation[c]);
      yardstick.set_deviation(r, c, std::exp(sum / static_cast<double>(usable)));
    }
  result.best_start = starts;
  for (std::size_t s = 0; s < starts; ++s) {
    if (solved[s].outcome.usable) solved[s].outcome.cost = cost_of(yardstick, solved[s].z);
    result.outcomes.push_back(solved[s].outcome);
    if (!solved[s].outcome.usable) continue;
    if (result.best_start == starts || solved[s].outcome.cost < solved[result.best_start].outcome.cost) result.best_start = s;
  }
  if (result.best_start == starts)
    throw std::runtime_error("no start of the calibration could be integrated; is the nominal plant near this one?");
  Solved& best = solved[result.best_start];
  set_deviations(best.problem, deviations_at(best.problem, best.z, data, true));  // for the standard errors: as they are
  for (const StartOutcome& outcome : result.outcomes)
    if (outcome.usable && outcome.cost > best.outcome.cost + 2.0) result.several_starts_agree = false;
  result.fitted = best.problem.plant_at(best.z.data());
  for (std::size_t r = 0; r < data.size(); ++r) {
    result.starts_of_recordings.push_back(best.problem.start_at(best.z.data(), r));
    result.deviation.push_back(best.problem.data()[r].deviation);
  }
  result.estimates = estimates_of(best.problem, best.z);
  return result;
}

}  // namespace sinew::diagnose
