// SPDX-License-Identifier: Apache-2.0
#include "diagnose/fit.h"

#include <algorithm>

#include "plant/wire.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

double first_measured(const FitData& data, std::size_t channel, double otherwise) {
  for (std::size_t k = 0; k < data.sample_count; ++k)
    if (const double value = measured(data.recording->samples[k], channel); !std::isnan(value)) return value;
  return otherwise;
}

}  // namespace

FitProblem::FitProblem(const plant::Limb<double>& limb, const std::vector<std::size_t>& parameters, std::vector<FitData> data,
                       StartPolicy start, const plant::NumericalSettings& numerics)
    : limb_(limb), layout_(plant::layout_of(limb.on)), parameters_(parameters), data_(std::move(data)), start_(start),
      numerics_(numerics) {
  for (const std::size_t p : parameters_) {
    const auto& info = plant::parameters()[p];
    const auto& declared = info.declaration;
    const double unit = declared.unit.internal_per_unit;
    unknowns_.push_back({info.key(), p, plant::get(limb_, p), declared.prior_deviation * unit, declared.range.lowest * unit,
                         declared.range.highest * unit, unit, declared.unit.text});
  }
  for (std::size_t i = 0; i < layout_.size() && start_ == StartPolicy::estimated; ++i)
    if (layout_.entries[i].declaration.free_at_start) free_states_.push_back(i);
  for (std::size_t r = 0; r < data_.size(); ++r) {
    if (start_ == StartPolicy::estimated) add_start_unknowns(r);
    first_row_.push_back(rows_.size());
    for (std::size_t k = 0; k < data_[r].sample_count; ++k)
      for (std::size_t c = 0; c < channel_count; ++c)
        if (!std::isnan(measured(data_[r].recording->samples[k], c))) rows_.push_back({r, k, c});
  }
}

// What is believed of a start before the fit: temperatures near what is measured first, fractions within the hysteresis
// loop there, all else within its scale of rest.
void FitProblem::add_start_unknowns(std::size_t recording) {
  const FitData& data = data_[recording];
  const std::string owner = data_.size() == 1 ? "start." : "start[" + std::to_string(recording) + "].";
  const plant::Core<double>& core = limb_.core;
  const plant::Equations<double> equations(limb_);
  std::vector<std::optional<double>> given(layout_.size());
  plant::PerCoil<double> temperature;
  for (const std::size_t j : plant::coils) {
    temperature[j] = first_measured(data, j, core.ambient_temperature_degC);
    given[plant::core_state::temperature + j] = temperature[j];
  }
  given[plant::core_state::angle] = first_measured(data, 2, 0.0) * plant::radians_per_degree - core.angle_offset_rad;
  const std::vector<double> rest = equations.rest({}, given);
  for (const std::size_t i : free_states_) {
    const auto& declared = layout_.entries[i].declaration;
    Unknown unknown{owner + layout_.entries[i].key, plant::no_effect, rest[i], 0.5 * declared.scale, -1e6, 1e6,
                    declared.unit.internal_per_unit, declared.unit.text};
    if (i < plant::core_state::martensite) {
      unknown.deviation = 5.0;
    } else if (i < plant::core_state::angle) {
      const auto envelope =
          plant::envelopes(temperature[i - plant::core_state::martensite], core.heating_midpoint_degC, core.heating_width_K,
                           core.cooling_midpoint_degC, core.cooling_width_K);
      unknown.centre = 0.5 * (envelope.heating + envelope.cooling);
      unknown.deviation = std::max(0.05, 0.5 * (envelope.heating - envelope.cooling));
      unknown.lowest = 0.0;
      unknown.highest = 1.0;
    }
    unknowns_.push_back(unknown);
  }
}

plant::Limb<double> FitProblem::limb_at(const double* z) const {
  plant::Limb<double> limb = limb_;
  // At a bound, rounding must not leave the range that a plant file may have.
  for (std::size_t u = 0; u < parameters_.size(); ++u)
    plant::set(limb, parameters_[u], std::clamp(value(u, z[u]), unknowns_[u].lowest, unknowns_[u].highest));
  return limb;
}

plant::Start FitProblem::start_at(const double* z, std::size_t recording) const {
  plant::Start start{std::vector<std::optional<double>>(layout_.size()), {}};
  if (start_ == StartPolicy::at_rest) return start;
  start.duty_fraction = data_[recording].recording->samples.front().duty_fraction;
  const std::size_t first = parameters_.size() + recording * free_states_.size();
  for (std::size_t i = 0; i < free_states_.size(); ++i) start.given[free_states_[i]] = value(first + i, z[first + i]);
  return start;
}

bool FitProblem::evaluate(const double* z, double* residuals, double* jacobian) const {
  const plant::Limb<double> limb = limb_at(z);
  const auto columns = static_cast<Eigen::Index>(unknowns_.size());
  for (std::size_t r = 0; r < data_.size(); ++r) {
    const FitData& data = data_[r];
    const std::size_t first_start = parameters_.size() + r * free_states_.size();
    plant::SensitivityRequest request;
    if (jacobian) {
      request.parameters = parameters_;
      if (start_ == StartPolicy::estimated) request.initial_states = free_states_;
    }
    const std::vector<sim::Sample>& all = data.recording->samples;
    plant::Integrator integrator(limb, start_at(z, r), numerics_, request);
    std::size_t row = first_row_[r];
    plant::Reading<double> reading;
    Eigen::Matrix<double, 3, Eigen::Dynamic> sensitivity;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(all[k].time_s - all.front().time_s)) return false;
      if (jacobian)
        integrator.reading_with_sensitivity(reading, sensitivity);
      else
        reading = integrator.reading();
      for (std::size_t c = 0; c < channel_count; ++c) {
        const double target = measured(all[k], c);
        if (std::isnan(target)) continue;
        residuals[row] = (shown(reading, c) - target) / data.deviation[c];
        if (jacobian) {
          double* out = jacobian + static_cast<Eigen::Index>(row) * columns;
          std::fill(out, out + columns, 0.0);
          const double weight = 1.0 / (data.deviation[c] * channels[c].internal_per_unit);
          const auto channel = static_cast<Eigen::Index>(c);
          for (std::size_t u = 0; u < parameters_.size(); ++u)
            out[u] = sensitivity(channel, static_cast<Eigen::Index>(u)) * weight * unknowns_[u].deviation;
          for (std::size_t i = 0; i < request.initial_states.size(); ++i)
            out[first_start + i] = sensitivity(channel, static_cast<Eigen::Index>(parameters_.size() + i)) * weight *
                                   unknowns_[first_start + i].deviation;
        }
        ++row;
      }
      integrator.hold(all[k].duty_fraction);
    }
  }
  for (std::size_t u = 0; u < unknowns_.size(); ++u) {
    residuals[rows_.size() + u] = z[u];
    if (jacobian) {
      double* out = jacobian + static_cast<Eigen::Index>(rows_.size() + u) * columns;
      std::fill(out, out + columns, 0.0);
      out[u] = 1.0;
    }
  }
  return true;
}

}  // namespace sinew::diagnose
