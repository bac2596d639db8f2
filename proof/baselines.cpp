// SPDX-License-Identifier: Apache-2.0
#include "proof/baselines.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "diagnose/proposals.h"
#include "diagnose/score.h"

namespace sinew::proof {
namespace {

using Json = nlohmann::ordered_json;
using diagnose::Prediction;

// What the core says at every sample, and what it leaves: [samples x 5] features in units of their spread, [samples]
// residuals.
struct Residual {
  Eigen::MatrixXd features;
  plant::ListOf<plant::ChannelId, Eigen::VectorXd> left;  // measured - core; NaN where it is not to be used
};

Residual residual_of(const Prediction& prediction, const diagnose::PerChannel& spreads, bool held_out) {
  const auto& samples = prediction.recording->samples;
  const auto n = static_cast<Eigen::Index>(samples.size());
  const auto& channels = prediction.measured;
  const std::size_t inputs = samples.front().inputs.size();
  Residual result{Eigen::MatrixXd(n, static_cast<Eigen::Index>(inputs + channels.size())),
                  {channels.size(), Eigen::VectorXd::Constant(n, std::nan(""))}};
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto& core = prediction.fitted;
    for (std::size_t u = 0; u < inputs; ++u) result.features(k, static_cast<Eigen::Index>(u)) = samples[i].inputs[u];
    for (const plant::ChannelId c : channels.ids())
      result.features(k, static_cast<Eigen::Index>(inputs + c.index)) = core[c][i] / spreads[c];
    for (const plant::ChannelId c : channels.ids())
      if (prediction.held_out[i] == held_out) result.left[c](k) = prediction.measured[c][i] - core[c][i];
  }
  return result;
}

std::vector<Eigen::Index> present(const Eigen::VectorXd& left) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < left.size(); ++k)
    if (!std::isnan(left(k))) rows.push_back(k);
  return rows;
}

double rms_after(const Residual& held_out, plant::ChannelId channel, const Eigen::VectorXd& correction) {
  double sum = 0.0;
  const std::vector<Eigen::Index> rows = present(held_out.left[channel]);
  for (const Eigen::Index k : rows) sum += std::pow(held_out.left[channel](k) - correction(k), 2);
  return std::sqrt(sum / static_cast<double>(rows.size()));
}

// 1, the features, and their products two by two.
Eigen::MatrixXd library(const Eigen::MatrixXd& features) {
  const Eigen::Index feature_count = features.cols();
  Eigen::MatrixXd terms(features.rows(), 1 + feature_count + feature_count * (feature_count + 1) / 2);
  terms.col(0).setOnes();
  terms.middleCols(1, feature_count) = features;
  Eigen::Index next = 1 + feature_count;
  for (Eigen::Index i = 0; i < feature_count; ++i)
    for (Eigen::Index j = i; j < feature_count; ++j) terms.col(next++) = features.col(i).cwiseProduct(features.col(j));
  return terms;
}

struct Sparse {
  Eigen::VectorXd coefficients;
  int terms = 0;
};

Sparse sparse_fit(const Eigen::MatrixXd& terms, const Eigen::VectorXd& left) {
  const double n = static_cast<double>(left.size()), whole = left.norm();
  Sparse best{Eigen::VectorXd::Zero(terms.cols()), 0};
  double best_bic = n * std::log(left.squaredNorm() / n);
  for (const double threshold : {0.05, 0.1, 0.2, 0.4, 0.8}) {
    std::vector<Eigen::Index> kept(static_cast<std::size_t>(terms.cols()));
    for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = static_cast<Eigen::Index>(i);
    Eigen::VectorXd coefficients;
    for (bool changed = true; changed && !kept.empty();) {
      coefficients = terms(Eigen::all, kept).colPivHouseholderQr().solve(left);
      std::vector<Eigen::Index> next;
      for (std::size_t i = 0; i < kept.size(); ++i)  // a term counts by what it contributes, whatever its unit
        if (std::abs(coefficients(static_cast<Eigen::Index>(i))) * terms.col(kept[i]).norm() >= threshold * whole) next.push_back(kept[i]);
      changed = next.size() < kept.size();
      kept = next;
    }
    if (kept.empty()) continue;
    const double bic =
        n * std::log((left - terms(Eigen::all, kept) * coefficients).squaredNorm() / n) + static_cast<double>(kept.size()) * std::log(n);
    if (bic >= best_bic) continue;
    best_bic = bic;
    best.coefficients.setZero();
    best.coefficients(kept) = coefficients;
    best.terms = static_cast<int>(kept.size());
  }
  return best;
}

Eigen::VectorXd process_fit(const Eigen::MatrixXd& from, const Eigen::VectorXd& left, const Eigen::MatrixXd& to) {
  const auto distance = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {  // squared, of each row from each
    Eigen::MatrixXd squares = -2.0 * a * b.transpose();
    squares.colwise() += a.rowwise().squaredNorm();
    squares.rowwise() += b.rowwise().squaredNorm().transpose();
    return squares;
  };
  const Eigen::MatrixXd apart = distance(from, from), across = distance(to, from);
  const double n = static_cast<double>(left.size());
  double best = 1e300;
  Eigen::VectorXd result = Eigen::VectorXd::Zero(to.rows());
  for (const double length : {0.3, 0.6, 1.2, 2.4})
    for (const double noise : {0.03, 0.1, 0.3, 1.0}) {  // variance, as a share of the function's
      Eigen::MatrixXd covariance = (apart / (-2.0 * length * length)).array().exp();
      covariance.diagonal().array() += noise;
      const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
      const Eigen::VectorXd weights = factor.solve(left);
      const double scale = left.dot(weights) / n;  // the function's variance that is most likely
      const double cost = n * std::log(scale) + 2.0 * factor.matrixLLT().diagonal().array().log().sum();
      if (!(cost < best)) continue;
      best = cost;
      result = (across / (-2.0 * length * length)).array().exp().matrix() * weights;
    }
  return result;
}

// A fit that was made on the way, with what it has added.
struct Weighed {
  std::vector<std::string_view> names;
  double bic;
};

// Each effect's share of exp(-BIC / 2) over all fits (Burnham, Anderson 2004, Sociol. Methods Res. 33:261).
Json weights_of(const std::vector<Weighed>& fits) {
  double lowest = HUGE_VAL, sum = 0.0;
  for (const Weighed& fit : fits) lowest = std::min(lowest, fit.bic);
  std::map<std::string_view, double> weights;
  for (const Weighed& fit : fits) {
    const double weight = std::exp(-0.5 * (fit.bic - lowest));
    sum += weight;
    for (const std::string_view name : fit.names) weights[name] += weight;
  }
  Json result = Json::object();
  for (const auto& [name, weight] : weights) result[std::string(name)] = weight / sum;
  return result;
}

Json select_by_bic(const diagnose::Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings) {
  diagnose::ExplanationSettings least_squares = settings.search.fit;
  least_squares.start = settings.start;
  least_squares.least_squares = true;
  least_squares.most_rounds = 1;
  least_squares.iterations_per_round = 8;
  const std::vector<diagnose::FitData>& data = diagnosis.search.core.problem->data();
  const auto bic = [](const diagnose::Explanation& explanation) {
    return -2.0 * explanation.log_likelihood +
           static_cast<double>(explanation.problem->parameters().size()) * std::log(static_cast<double>(explanation.blocks->rows().size()));
  };
  diagnose::Explanation best =
      diagnose::explain(diagnosis.search.core.problem->centres(), data, diagnosis.search.core.as_guess(), least_squares);
  std::vector<std::string_view> names;
  std::vector<Weighed> weighed;
  if (best.usable) weighed.push_back({{}, bic(best)});
  while (best.usable && names.size() < settings.search.most_effects) {
    const std::vector<plant::EffectId> candidates = diagnose::addable(best.problem->centres(), settings.search.without);
    const diagnose::Scores scores = diagnose::score(best, candidates, 1);
    diagnose::Explanation better;
    std::size_t tried = 0;
    plant::EffectId added;
    for (const std::size_t s : scores.best) {
      const diagnose::Score& score = scores.all[s];
      if (tried++ >= 3) continue;
      const diagnose::Explanation with = diagnose::explain(diagnose::with_effect(best.problem->centres(), score.effect), data,
                                                           diagnose::guess_with(best, score), least_squares);
      if (!with.usable) continue;
      weighed.push_back({names, bic(with)});
      weighed.back().names.push_back(best.system().effects()[plant::family_of(best.system().effects(), score.effect)].name);
      if (better.usable && bic(with) >= bic(better)) continue;
      better = with;
      added = score.effect;
    }
    if (!better.usable || bic(better) >= bic(best)) break;
    best = better;
    names.push_back(best.system().effects()[plant::family_of(best.system().effects(), added)].name);
  }
  Json result{{"effects", names}, {"weights", weights_of(weighed)}};
  for (const Prediction& prediction : diagnosis.predictions) {
    if (prediction.training || !best.usable) continue;
    const auto& numerics = settings.search.fit.numerics;
    const diagnose::Series model =
        diagnose::predict(best.model(), diagnose::start_of(best.model(), *prediction.recording, data.front().deviation, least_squares),
                          *prediction.recording, numerics);
    diagnose::PerChannel rmse = diagnose::per_channel(best.system());
    for (const plant::ChannelId c : rmse.ids()) {
      double sum = 0.0, count = 0.0;
      for (std::size_t k = 0; k < model[c].size(); ++k)
        if (prediction.held_out[k] && !std::isnan(prediction.measured[c][k]))
          sum += std::pow(model[c][k] - prediction.measured[c][k], 2), ++count;
      rmse[c] = std::sqrt(sum / count);
    }
    result["normalised_after"] = normalised(rmse, diagnosis.held_out.noise);
  }
  return result;
}

}  // namespace

double normalised(const diagnose::PerChannel& rmse, const diagnose::PerChannel& noise) {
  double sum = 0.0;
  for (const plant::ChannelId c : rmse.ids()) sum += std::pow(rmse[c] / noise[c], 2);
  return std::sqrt(sum / static_cast<double>(rmse.size()));
}

Json baselines(const diagnose::Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings) {
  Json result;
  result["bic"] = select_by_bic(diagnosis, settings);
  const plant::System& system = diagnosis.repaired.system();
  diagnose::PerChannel spreads;
  for (const plant::ChannelInfo& channel : system.channels()) spreads.push_back(channel.kind == system.upstream_kind() ? 50.0 : 20.0);
  const Residual training = residual_of(diagnosis.predictions.front(), spreads, false),
                 held_out = residual_of(diagnosis.predictions.back(), spreads, true);
  const Eigen::MatrixXd terms = library(training.features), terms_there = library(held_out.features);
  diagnose::PerChannel by_terms = diagnose::per_channel(system), by_process = by_terms;
  constexpr std::size_t points = 300;
  for (const plant::ChannelId c : by_terms.ids()) {
    const std::vector<Eigen::Index> rows = present(training.left[c]);
    const Sparse found = sparse_fit(terms(rows, Eigen::all), training.left[c](rows));
    result["sindy"]["terms"][system.channels()[c].column] = found.terms;
    by_terms[c] = rms_after(held_out, c, terms_there * found.coefficients);
    std::vector<Eigen::Index> some;
    for (std::size_t i = 0; i < points; ++i) some.push_back(rows[i * rows.size() / points]);
    by_process[c] = rms_after(held_out, c, process_fit(training.features(some, Eigen::all), training.left[c](some), held_out.features));
  }
  result["sindy"]["normalised_after"] = normalised(by_terms, diagnosis.held_out.noise);
  result["gaussian_process"]["normalised_after"] = normalised(by_process, diagnosis.held_out.noise);
  return result;
}

}  // namespace sinew::proof
