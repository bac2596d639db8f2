// SPDX-License-Identifier: Apache-2.0
#include "diagnose/score.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "diagnose/projection.h"
#include "sim/parallel.h"
#include "sim/random.h"

namespace sinew::diagnose {
namespace {

using Shape = std::map<plant::ParameterId, double>;  // parameter, internal value

// Whether the effect switches at an instant that one of its parameters is; such instants are tried all over the
// recording.
bool switches(const plant::System& system, plant::EffectId effect) {
  const plant::Plant nominal(system.shared_from_this());
  return !with_effect(nominal, effect).equations()->switch_times_s().empty();
}

std::vector<double> grid_of(const plant::Declaration& declared, bool is_instant, double duration_s) {
  std::vector<double> values;
  if (is_instant) {
    for (int i = 1; i < 20; ++i) values.push_back(0.05 * i * duration_s);
  } else if (declared.typical > 0.0 && declared.range.lowest >= 0.0 && declared.prior_deviation > 0.45 * declared.typical) {
    for (const double factor : {0.04, 0.12, 0.35, 1.0, 3.0}) values.push_back(declared.typical * factor);
  } else {
    for (const double step : {-1.5, -0.75, 0.0, 0.75, 1.5}) values.push_back(declared.typical + step * declared.prior_deviation);
  }
  for (double& value : values) value = std::clamp(value, declared.range.lowest, declared.range.highest) * declared.unit.internal_per_unit;
  return values;
}

// The first shape parameter runs over its grid; every further one over its own while the first is typical.
std::vector<Shape> shapes_of(const plant::System& system, plant::EffectId effect, double duration_s) {
  const auto& info = system.effects()[effect];
  const bool instant = switches(system, effect);
  Shape typical;
  std::vector<plant::ParameterId> free;
  for (const plant::ParameterId p : info.parameters) {
    if (p == info.strength) continue;
    const auto& declared = system.parameters()[p].declaration;
    typical[p] = declared.typical * declared.unit.internal_per_unit;
    if (declared.prior_deviation > 0.0) free.push_back(p);
  }
  std::vector<Shape> shapes;
  for (std::size_t i = 0; i < free.size(); ++i)
    for (const double value : grid_of(system.parameters()[free[i]].declaration, instant, duration_s)) {
      Shape shape = typical;
      shape[free[i]] = value;
      if (i == 0 || value != typical[free[i]]) shapes.push_back(shape);
    }
  if (shapes.empty()) shapes.push_back(typical);
  return shapes;
}

// Whether physics allows the strength on both sides of its null.
bool is_two_sided(const plant::Declaration& strength) {
  return strength.null_value && strength.range.lowest < *strength.null_value && strength.range.highest > *strength.null_value;
}

struct Job {
  plant::Plant plant;
  std::vector<std::size_t> scores;  // indices into Scores::all, one a column
  bool difference = false;          // between the path with the one effect as it is in `plant` and the one without
};

// Of what calibration absorbs all but this share of, what is left is rounding, and its direction says nothing.
constexpr double absorbed_share = 1e-4;
// Of the typical strength, at which differences are taken: less than what is looked for, and far from rounding.
constexpr double difference_share = 0.5;

// Whether derivatives at the null say nothing of an effect: they are nothing, or the same whatever its shape, but for rounding.
bool says_nothing(const Scores& scores, plant::EffectId effect) {
  const Score* first = nullptr;
  bool several = false;
  for (const Score& score : scores.all) {
    if (score.effect != effect || score.column.size() == 0) continue;
    if (first && score.visible_share * (1.0 - std::pow(score.column.dot(first->column), 2)) > absorbed_share) return false;
    several = several || first;
    if (!first) first = &score;
  }
  return !first || several;
}

}  // namespace

Scores score(const Explanation& at, const std::vector<plant::EffectId>& candidates, int threads) {
  const FitProblem& problem = *at.problem;
  const plant::System& system = at.system();
  const plant::Plant fitted = at.model();
  double duration_s = 0.0;
  for (const FitData& data : problem.data())
    duration_s = std::max(duration_s, data.recording->samples[data.sample_count - 1].time_s - data.recording->samples.front().time_s);

  Scores result;
  std::vector<Job> jobs;
  // Effects share integrations: the k-th shape of each goes into the k-th job.
  std::vector<std::size_t> shared;
  for (const plant::EffectId e : candidates) {
    const auto& info = system.effects()[e];
    const auto& strength = system.parameters()[info.strength].declaration;
    const bool toggle = strength.kind == plant::Kind::toggle;
    const std::vector<Shape> shapes = shapes_of(system, e, duration_s);
    for (std::size_t k = 0; k < shapes.size(); ++k) {
      Score score;
      score.effect = e;
      score.two_sided = is_two_sided(strength);
      for (const auto& [parameter, value] : shapes[k]) score.shape[system.parameters()[parameter].key()] = value;
      std::size_t job = jobs.size();
      if (!toggle) {
        if (k >= shared.size()) {
          shared.push_back(jobs.size());
          jobs.push_back({fitted, {}, false});
        }
        job = shared[k];
      } else {
        jobs.push_back({fitted, {}, toggle});
      }
      plant::Plant& with = jobs[job].plant;
      with = with_effect(with, e);
      for (const auto& [parameter, value] : shapes[k]) with.set(parameter, value);
      jobs[job].scores.push_back(result.all.size());
      result.all.push_back(std::move(score));
    }
  }

  const Projection rest(at);

  const auto judge = [&](Score& score, const Eigen::VectorXd& s, double scale, bool difference) {
    const auto& declared = system.parameters()[system.effects()[score.effect].strength].declaration;
    const Projection::Left of = rest.of(s);
    const double whole = s.squaredNorm(), left = of.squares(0, 0), along = of.along(0);
    if (whole <= 0.0 || left < 1e-12 * whole) return;
    const double unit = declared.unit.internal_per_unit, null = declared.null_value.value_or(0.0);
    const double phi = -along / left * scale;
    const bool allowed = difference ? phi / scale > 0.0 : phi > 0.0 ? declared.range.highest > null : declared.range.lowest < null;
    score.visible_share = left / whole;
    score.smallest_seen = 5.0 / std::sqrt(left) * std::abs(scale);
    score.strength = std::clamp(null * unit + phi, declared.range.lowest * unit, declared.range.highest * unit);
    score.statistic = allowed ? along * along / left : 0.0;
    score.column = of.columns.col(0) / std::sqrt(left);
    const double sense = !difference && declared.range.highest <= null ? -1.0 : 1.0;  // the one that is allowed
    score.column *= sense;
    score.root = -along / std::sqrt(left) * sense;
    score.phi_of_root = scale / std::sqrt(left) * sense;
  };
  const auto run = [&](std::size_t j) {
    const Job& job = jobs[j];
    if (job.difference) {
      // The problem with the effect on, all else as it is.
      FitProblem with(job.plant, problem.parameters(), problem.data(), problem.beginnings(), problem.numerics());
      with.set_idle_before(problem.idle_before());
      with.set_course(problem.course());
      const Eigen::VectorXd z = coordinates_of(at.as_guess(), with);
      Path there;
      if (!follow(with, z.data(), Want::residuals, there)) return;
      Eigen::MatrixXd column = at.blocks->means(there.residuals.data(), 1);
      column.col(0) -= at.residual;
      if (!column.allFinite()) return;
      rest.whiten(column);
      Score& score = result.all[job.scores.front()];
      score.is_difference = true;
      const plant::ParameterId strength = system.effects()[score.effect].strength;
      const auto& declared = system.parameters()[strength].declaration;
      judge(score, column.col(0), job.plant.get(strength) - declared.null_value.value_or(0.0) * declared.unit.internal_per_unit, true);
      return;
    }
    std::vector<plant::ParameterId> strengths;
    for (const std::size_t s : job.scores) strengths.push_back(system.effects()[result.all[s].effect].strength);
    std::vector<double> rows;
    if (!sensitivity_to(problem, at.z.data(), job.plant, strengths, rows)) return;
    Eigen::MatrixXd columns = at.blocks->means(rows.data(), strengths.size());
    if (!columns.allFinite()) return;
    rest.whiten(columns);
    for (std::size_t k = 0; k < job.scores.size(); ++k) {
      const auto& declared = system.parameters()[strengths[k]].declaration;
      judge(result.all[job.scores[k]], columns.col(static_cast<Eigen::Index>(k)),
            declared.prior_deviation > 0.0 ? declared.prior_deviation * declared.unit.internal_per_unit : 1.0, false);
    }
  };
  sim::in_parallel(jobs.size(), threads, run);

  jobs.clear();
  for (const plant::EffectId e : candidates) {
    const plant::ParameterId strength = system.effects()[e].strength;
    const auto& declared = system.parameters()[strength].declaration;
    if (declared.kind == plant::Kind::toggle || !says_nothing(result, e)) continue;
    const std::size_t known = result.all.size();
    for (std::size_t i = 0; i < known; ++i) {
      if (result.all[i].effect != e) continue;
      // The same shape, by a difference.
      const Score shape = result.all[i];
      result.all[i] = Score();
      result.all[i].effect = e;
      result.all[i].shape = shape.shape;
      result.all[i].two_sided = shape.two_sided;
      jobs.push_back({with_effect(fitted, e), {i}, true});
      plant::Plant& with = jobs.back().plant;
      for (const auto& [key, value] : shape.shape) with.set(system.parameter(key), value);
      with.set(strength,
               (*declared.null_value + difference_share * (declared.typical - *declared.null_value)) * declared.unit.internal_per_unit);
    }
  }
  sim::in_parallel(jobs.size(), threads, run);

  for (const plant::EffectId e : candidates) {
    std::size_t best = result.all.size();
    for (std::size_t i = 0; i < result.all.size(); ++i)
      if (result.all[i].effect == e && (best == result.all.size() || result.all[i].statistic > result.all[best].statistic)) best = i;
    if (best < result.all.size()) result.best.push_back(best);
  }
  std::stable_sort(result.best.begin(), result.best.end(),
                   [&](std::size_t a, std::size_t b) { return result.all[a].statistic > result.all[b].statistic; });
  return result;
}

JointScore joint(const Score& score, const Score& other) {
  const double cosine = score.column.dot(other.column), left = 1.0 - cosine * cosine;
  if (left < 1e-6) return {};
  JointScore result;
  result.root = (score.root - cosine * other.root) / left;
  result.other_root = (other.root - cosine * score.root) / left;
  if ((result.root < 0.0 && !score.two_sided) || (result.other_root < 0.0 && !other.two_sided)) return {};
  result.statistic = result.root * score.root + result.other_root * other.root;
  return result;
}

double family_wise_probability(const Scores& scores, double statistic, std::uint64_t seed, int draws) {
  std::vector<const Score*> seen;
  for (const Score& score : scores.all)
    if (score.column.size() > 0) seen.push_back(&score);
  if (seen.empty()) return 1.0;
  const auto n = static_cast<Eigen::Index>(seen.size());
  Eigen::MatrixXd columns(seen.front()->column.size(), n);
  for (Eigen::Index i = 0; i < n; ++i) columns.col(i) = seen[static_cast<std::size_t>(i)]->column;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(columns.transpose() * columns);
  const Eigen::MatrixXd root = spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const sim::RandomStream chance(seed, "diagnose.family_wise");
  int reached = 0;
  std::uint64_t index = 0;
  for (int d = 0; d < draws; ++d) {
    Eigen::VectorXd normal(n);
    for (Eigen::Index i = 0; i < n; ++i) normal(i) = chance.normal(index++);
    const Eigen::VectorXd drawn = root * normal;
    double largest = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double value = seen[static_cast<std::size_t>(i)]->two_sided ? std::abs(drawn(i)) : std::max(0.0, drawn(i));
      largest = std::max(largest, value * value);
    }
    reached += largest >= statistic;
  }
  const double bound = std::min(1.0, static_cast<double>(n) * std::erfc(std::sqrt(std::max(0.0, statistic) / 2.0)));
  return reached > 0 ? static_cast<double>(reached) / draws : std::min(bound, 1.0 / draws);
}

}  // namespace sinew::diagnose
