// SPDX-License-Identifier: Apache-2.0
#include "proof/oracle.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "prove/generator_effects.h"

namespace sinew::proof {
namespace {

using prove::Sample;

// A number that is fitted. z = 0 is where the fit begins; a step of 1 is about what the generator's draws differ by.
struct Unknown {
  std::size_t effect;  // number_of_core: the core
  std::string name;
  double start, unit;
  bool by_factor;       // start * exp(unit z) rather than start + unit z
  double prior_centre;  // of z; NaN: no prior
  double value(double z) const { return by_factor ? start * std::exp(unit * z) : start + unit * z; }
};
constexpr auto number_of_core = static_cast<std::size_t>(-1);

// Standard deviation of what is drawn evenly within so much of the middle.
double deviation_of_range(double half) { return half / std::numbers::sqrt3; }

double half_range(const prove::CoreNumber& number, const CoreSpread& spread) {
  switch (number.spread) {
    case prove::Spread::known:
      return 0.0;
    case prove::Spread::relative:
      return spread.relative * std::abs(prove::Physics{}.*number.field);
    case prove::Spread::kelvins:
      return spread.kelvins;
    case prove::Spread::offset:
      return spread.offset;
  }
  return 0.0;
}

void add_core(std::vector<Unknown>& unknowns, const std::map<std::string, double>& core, const CoreSpread& spread) {
  for (const prove::CoreNumber& number : prove::core_numbers()) {
    const double half = half_range(number, spread), nominal = prove::Physics{}.*number.field;
    const auto found = core.find(std::string(number.name));
    if (half == 0.0 || found == core.end()) continue;
    const double unit = deviation_of_range(half), off = nominal - found->second;
    unknowns.push_back({number_of_core, found->first, found->second, unit, false, std::abs(off) <= half ? off / unit : std::nan("")});
  }
}

void add_effect(std::vector<Unknown>& unknowns, std::size_t index, const prove::TruthEffect& effect) {
  const std::string key = effect.form.empty() ? effect.name : effect.name + "." + effect.form;
  for (const prove::Number& number : prove::effect_of_key(key).numbers) {
    const auto found = effect.parameters.find(std::string(number.name));
    if (number.role == prove::Role::fixed || found == effect.parameters.end() || found->second == 0.0) continue;
    unknowns.push_back({index, found->first, found->second, deviation_of_range(number.variation), true, std::nan("")});
  }
}

double shown(const Sample& sample, std::size_t channel) {
  return channel < sample.temperature_degC.size() ? sample.temperature_degC[channel] : sample.angle_deg;
}

// Residuals and their derivatives by forward differences: of every measurement, then of every prior.
class Misfit : public ceres::CostFunction {
 public:
  Misfit(OracleFit start, std::vector<Unknown> unknowns, const std::vector<Sample>& training, const OracleSettings& settings)
      : start_(std::move(start)), unknowns_(std::move(unknowns)), training_(training), settings_(settings) {
    int rows = 0;
    for (const Sample& sample : training_)
      for (std::size_t c = 0; c < oracle_channels; ++c) rows += !std::isnan(shown(sample, c));
    for (const Unknown& unknown : unknowns_) rows += !std::isnan(unknown.prior_centre);
    set_num_residuals(rows);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns_.size()));
  }

  OracleFit at(const std::vector<double>& z) const {
    OracleFit fit = start_;
    for (std::size_t u = 0; u < unknowns_.size(); ++u) {
      const Unknown& unknown = unknowns_[u];
      auto& parameters = unknown.effect == number_of_core ? fit.core_parameters : fit.effects[unknown.effect].parameters;
      parameters[unknown.name] = unknown.value(z[u]);
    }
    return fit;
  }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    std::vector<double> z(parameters[0], parameters[0] + unknowns_.size());
    const std::size_t rows = static_cast<std::size_t>(num_residuals());
    if (!residuals_at(z, residuals)) return false;
    if (!jacobians || !jacobians[0]) return true;
    // Far above rounding, which a simulation adds up, and far below what a draw differs by.
    constexpr double step = 1e-3;
    std::vector<double> moved(rows);
    for (std::size_t u = 0; u < z.size(); ++u) {
      const double was = z[u];
      z[u] = was + step;
      if (!residuals_at(z, moved.data())) return false;
      z[u] = was;
      for (std::size_t r = 0; r < rows; ++r) jacobians[0][r * z.size() + u] = (moved[r] - residuals[r]) / step;
    }
    return true;
  }

 private:
  // False where the limb cannot be simulated with these values, or where the fit should stop.
  bool residuals_at(const std::vector<double>& z, double* residuals) const {
    if (settings_.should_stop && settings_.should_stop()) return false;
    const OracleFit fit = at(z);
    const std::vector<Sample> model = prove::simulate(fit.core_parameters, fit.effects, training_);
    double* next = residuals;
    for (std::size_t k = 0; k < training_.size(); ++k)
      for (std::size_t c = 0; c < oracle_channels; ++c)
        if (const double measured = shown(training_[k], c); !std::isnan(measured))
          *next++ = (shown(model[k], c) - measured) / settings_.noise[c];
    for (std::size_t u = 0; u < unknowns_.size(); ++u)
      if (!std::isnan(unknowns_[u].prior_centre)) *next++ = z[u] - unknowns_[u].prior_centre;
    return std::all_of(residuals, next, [](double residual) { return std::isfinite(residual); });
  }

  OracleFit start_;
  std::vector<Unknown> unknowns_;
  const std::vector<Sample>& training_;
  const OracleSettings& settings_;
};

}  // namespace

OracleFit fit_oracle(const std::map<std::string, double>& core_parameters, const std::vector<prove::TruthEffect>& effects,
                     const std::vector<Sample>& training, const OracleSettings& settings) {
  std::vector<Unknown> unknowns;
  add_core(unknowns, core_parameters, settings.spread);
  for (std::size_t e = 0; e < effects.size(); ++e) add_effect(unknowns, e, effects[e]);
  std::vector<double> z(unknowns.size(), 0.0);
  auto misfit = std::make_unique<Misfit>(OracleFit{core_parameters, effects}, std::move(unknowns), training, settings);
  const Misfit& model = *misfit;
  ceres::Problem problem;
  problem.AddResidualBlock(misfit.release(), nullptr, z.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = settings.most_iterations;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  OracleFit fit = model.at(z);
  fit.stopped = settings.should_stop && settings.should_stop();
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  return fit;
}

OracleChannels open_loop_rmse(const OracleFit& fit, const std::vector<Sample>& samples) {
  const std::vector<Sample> model = prove::simulate(fit.core_parameters, fit.effects, samples);
  OracleChannels sum{}, count{};
  for (std::size_t k = 0; k < samples.size(); ++k)
    for (std::size_t c = 0; c < oracle_channels; ++c)
      if (const double measured = shown(samples[k], c); !std::isnan(measured))
        sum[c] += std::pow(shown(model[k], c) - measured, 2), ++count[c];
  OracleChannels rmse;
  for (std::size_t c = 0; c < oracle_channels; ++c) rmse[c] = std::sqrt(sum[c] / count[c]);
  return rmse;
}

}  // namespace sinew::proof
