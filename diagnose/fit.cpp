// SPDX-License-Identifier: Apache-2.0
#include "diagnose/fit.h"

#include <algorithm>

#include "plant/contains.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

double first_measured(const FitData& data, plant::ChannelId channel) {
  for (std::size_t k = 0; k < data.sample_count; ++k)
    if (const double value = measured(data.recording->samples[k], channel); !std::isnan(value)) return value;
  return std::nan("");
}

}  // namespace

std::vector<std::optional<double>> elapsed_where_it_begins(const plant::States& states, const sim::Recording& recording,
                                                           std::optional<double> from_s) {
  // So many of the prior's deviations later, no straight line is believed any more: what has grown by then is open.
  constexpr double most_deviations = 2.0;
  std::vector<std::optional<double>> elapsed(states.size());
  const std::optional<double> begins_s = recording.begins_s();
  if (!begins_s || !from_s) return elapsed;
  const double since_s = *begins_s - *from_s;
  for (const plant::StateId i : states.ids())
    if (states[i].at_start == plant::AtStart::elapsed && std::abs(since_s) <= most_deviations * states[i].start_deviation)
      elapsed[i.index] = since_s;
  return elapsed;
}

FitProblem::FitProblem(const plant::Plant& centres, const std::vector<plant::ParameterId>& parameters, std::vector<FitData> data,
                       const Beginnings& start, const plant::NumericalSettings& numerics)
    : centres_(centres), states_(centres.states()), parameters_(parameters), data_(std::move(data)), start_(start), numerics_(numerics) {
  for (const plant::ParameterId p : parameters_) {
    const auto& info = system().parameters()[p];
    const auto& declared = info.declaration;
    const double unit = declared.unit.internal_per_unit;
    double wider = 1.0;
    for (const plant::EffectId e : system().effects().ids())
      for (const auto& [hidden, factor] : system().effects()[e].hides)
        if (hidden == p && centres_.is_on(e) && !centres_.own_deviation(p)) wider = std::max(wider, factor);
    Unknown unknown{info.key(),
                    p,
                    centres_.get(p),
                    wider * centres_.deviation(p),
                    declared.range.lowest * unit,
                    declared.range.highest * unit,
                    unit,
                    declared.unit.text};
    if (plant::is_positive(declared)) {
      const double about = centres_.own_deviation(p) ? centres_.get(p) : declared.typical * unit;
      unknown.log_deviation = wider * std::sqrt(std::log1p(std::pow(centres_.deviation(p) / about, 2)));
      unknown.deviation = unknown.centre * unknown.log_deviation;
    }
    unknowns_.push_back(unknown);
  }
  constexpr double order_share = 0.01;  // of the prior's deviation: hardly more than a bound, and smooth enough to be fitted
  for (std::size_t low = 0; low < parameters_.size(); ++low)
    for (std::size_t high = 0; high < parameters_.size(); ++high)
      if (const auto& above = system().parameters()[parameters_[low]].declaration.less_than;
          contains(above, system().parameters()[parameters_[high]].key()))
        orders_.push_back({low, high, order_share * unknowns_[low].deviation});
  if (!start_.counted_from_s && !start_.later && !data_.empty()) start_.counted_from_s = data_.front().recording->begins_s();
  for (const FitData& one : data_) elapsed_.push_back(elapsed_where_it_begins(states_, *one.recording, start_.counted_from_s));
  const std::vector<std::vector<double>> grown = grown_by_then();
  for (std::size_t r = 0; r < data_.size(); ++r) {
    add_start_unknowns(r, grown[r]);
    first_row_.push_back(rows_.size());
    for (std::size_t k = 0; k < data_[r].sample_count; ++k)
      for (const plant::ChannelId c : system().channels().ids())
        if (!std::isnan(measured(data_[r].recording->samples[k], c))) rows_.push_back({r, k, c});
  }
}

// By state, what is counted would have come to where each recording begins, if that were where the one before it ends. Where that is known
// of all, nothing.
std::vector<std::vector<double>> FitProblem::grown_by_then() const {
  std::vector<std::vector<double>> grown(data_.size(), std::vector<double>(states_.size(), 0.0));
  std::vector<plant::StateId> counted;
  for (const plant::StateId i : states_.ids())
    if (plant::grows_between_recordings(states_[i].at_start) &&
        !std::ranges::all_of(elapsed_, [&](const auto& of) { return of[i.index].has_value(); }))
      counted.push_back(i);
  for (std::size_t r = 0; !counted.empty() && r + 1 < data_.size(); ++r) {
    plant::Integrator integrator(centres_, plant::Start{}, numerics_);
    const std::vector<double> before = integrator.state();
    const bool failed = sim::replay(integrator, system(), data_[r].recording->samples, [](std::size_t) {}).has_value();
    for (const plant::StateId i : counted)
      grown[r + 1][i.index] =
          elapsed_[r][i.index].value_or(grown[r][i.index]) + (failed ? 0.0 : integrator.state()[i.index] - before[i.index]);
  }
  return grown;
}

// Where a recording begins at rest, what is counted is all that is open about it.
void FitProblem::add_start_unknowns(std::size_t recording, const std::vector<double>& grown) {
  first_start_.push_back(unknowns_.size());
  free_states_.emplace_back();
  for (const plant::StateId i : states_.ids())
    if ((states_[i].at_start == plant::AtStart::open && !at_rest()) ||
        (plant::grows_between_recordings(states_[i].at_start) && (recording > 0 || start_.later) && !elapsed_[recording][i.index]))
      free_states_[recording].push_back(i);
  if (free_states_[recording].empty()) return;
  const std::string owner = data_.size() == 1 ? "start." : "start[" + std::to_string(recording) + "].";
  std::vector<double> first;
  for (const plant::ChannelId c : system().channels().ids())
    first.push_back(first_measured(data_[recording], c) * system().channels()[c].unit.internal_per_unit);
  const std::vector<plant::StartBelief> beliefs = system().start_beliefs(centres_, first);
  for (const plant::StateId i : free_states_[recording]) {
    const plant::StartBelief& belief = beliefs[i.index];
    unknowns_.push_back({owner + states_[i].key, std::nullopt, belief.centre + grown[i.index], belief.deviation, belief.lowest,
                         belief.highest, states_[i].unit.internal_per_unit, states_[i].unit.text});
  }
}

// What it does not name is not pushed.
void FitProblem::set_course(const std::shared_ptr<const Course>& course) {
  course_ = nullptr;
  if (!course || course->response.size() != rows_.size() || course->pushes.size() != data_.size()) return;
  for (std::size_t r = 0; r < data_.size(); ++r)
    if (course->pushes[r].cols() + 1 != static_cast<Eigen::Index>(data_[r].sample_count)) return;
  Course mine{.states = {}, .pushes = {}, .response = course->response};
  for (const plant::StateInfo& state : states_) mine.states.push_back(state.key);
  if (mine.states == course->states) {
    course_ = course;
    return;
  }
  for (const Eigen::MatrixXd& pushes : course->pushes) {
    mine.pushes.emplace_back(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(mine.states.size()), pushes.cols()));
    for (std::size_t i = 0; i < mine.states.size(); ++i)
      if (const auto there = std::find(course->states.begin(), course->states.end(), mine.states[i]); there != course->states.end())
        mine.pushes.back().row(static_cast<Eigen::Index>(i)) = pushes.row(there - course->states.begin());
  }
  course_ = std::make_shared<const Course>(std::move(mine));
}

plant::Plant FitProblem::plant_at(const double* z) const {
  plant::Plant plant = centres_;
  // At a bound, rounding must not leave the range that a plant file may have.
  for (std::size_t u = 0; u < parameters_.size(); ++u)
    plant.set(parameters_[u], std::clamp(value(u, z[u]), unknowns_[u].lowest, unknowns_[u].highest));
  return plant;
}

plant::Start FitProblem::start_at(const double* z, std::size_t recording) const {
  plant::Start start{elapsed_[recording], {}};
  if (!at_rest() && (recording >= idle_before_.size() || !idle_before_[recording]))
    start.inputs = data_[recording].recording->samples.front().inputs;
  const std::size_t first = first_start_[recording];
  const std::vector<plant::StateId>& free = free_states_[recording];
  for (std::size_t i = 0; i < free.size(); ++i) start.given[free[i].index] = value(first + i, z[first + i]);
  return start;
}

Eigen::VectorXd FitProblem::order_residuals(const double* z, RowMajor* jacobian) const {
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(orders_.size()));
  if (jacobian) *jacobian = RowMajor::Zero(residuals.size(), static_cast<Eigen::Index>(unknowns_.size()));
  for (std::size_t k = 0; k < orders_.size(); ++k) {
    const auto& [low, high, scale] = orders_[k];
    const double above = value(low, z[low]) - value(high, z[high]);
    if (above <= 0.0) continue;
    const auto row = static_cast<Eigen::Index>(k);
    residuals(row) = above / scale;
    if (!jacobian) continue;
    (*jacobian)(row, static_cast<Eigen::Index>(low)) = unknowns_[low].slope_at(z[low]) / scale;
    (*jacobian)(row, static_cast<Eigen::Index>(high)) = -unknowns_[high].slope_at(z[high]) / scale;
  }
  return residuals;
}

bool FitProblem::evaluate(const double* z, double* residuals, double* jacobian) const {
  const plant::Plant plant = plant_at(z);
  const auto columns = static_cast<Eigen::Index>(unknowns_.size());
  for (std::size_t r = 0; r < data_.size(); ++r) {
    const FitData& data = data_[r];
    const std::size_t first_start = first_start_[r];
    plant::SensitivityRequest request;
    if (jacobian) {
      request.parameters = parameters_;
      request.initial_states = free_states_[r];
    }
    const std::vector<sim::Sample>& all = data.recording->samples;
    plant::Integrator integrator(plant, start_at(z, r), numerics_, request);
    std::size_t row = first_row_[r];
    std::vector<double> readings;
    Eigen::MatrixXd sensitivity;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(all[k].time_s - all.front().time_s)) return false;
      if (jacobian)
        integrator.readings_with_sensitivity(readings, sensitivity);
      else
        readings = integrator.readings();
      for (const plant::ChannelId c : system().channels().ids()) {
        const double target = measured(all[k], c);
        if (std::isnan(target)) continue;
        residuals[row] = (shown(system(), readings, c) - target) / data.deviation[c];
        if (jacobian) {
          double* out = jacobian + static_cast<Eigen::Index>(row) * columns;
          std::fill(out, out + columns, 0.0);
          const double weight = 1.0 / (data.deviation[c] * system().channels()[c].unit.internal_per_unit);
          const auto channel = static_cast<Eigen::Index>(c.index);
          for (std::size_t u = 0; u < parameters_.size(); ++u)
            out[u] = sensitivity(channel, static_cast<Eigen::Index>(u)) * weight * unknowns_[u].slope_at(z[u]);
          for (std::size_t i = 0; i < request.initial_states.size(); ++i)
            out[first_start + i] = sensitivity(channel, static_cast<Eigen::Index>(parameters_.size() + i)) * weight *
                                   unknowns_[first_start + i].slope_at(z[first_start + i]);
        }
        ++row;
      }
      sim::command_sample(integrator, system(), all, k);
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
  if (order_count() == 0) return true;
  RowMajor order_jacobian;
  const Eigen::VectorXd orders = order_residuals(z, jacobian ? &order_jacobian : nullptr);
  std::copy(orders.begin(), orders.end(), residuals + rows_.size() + unknowns_.size());
  if (jacobian)
    std::copy(order_jacobian.data(), order_jacobian.data() + order_jacobian.size(),
              jacobian + static_cast<Eigen::Index>(rows_.size() + unknowns_.size()) * columns);
  return true;
}

}  // namespace sinew::diagnose
