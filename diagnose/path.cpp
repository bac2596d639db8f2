// SPDX-License-Identifier: Apache-2.0
#include "diagnose/path.h"

#include <Eigen/LU>
#include <algorithm>

#include "diagnose/padded.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

constexpr std::size_t width = 16;
using Jet = plant::Jet<static_cast<int>(width)>;

// Derivatives with respect to all states, the ambient temperature and any parameters, as many Jets as that takes.
class Differentiator {
 public:
  Differentiator(const plant::Limb<double>& limb, const std::vector<std::size_t>& parameters)
      : n_(plant::layout_of(limb.on).size()), parameters_(parameters.size()) {
    for (std::size_t first = 0; first < columns(); first += width) {
      plant::Limb<Jet> lifted = plant::lift<Jet>(limb);
      const auto all = plant::fields(lifted);
      const auto seed = [&](std::size_t column, Jet& field) {
        if (column >= first && column < first + width) field.v[static_cast<Eigen::Index>(column - first)] = 1.0;
      };
      seed(n_, lifted.core.ambient_temperature_degC);
      for (std::size_t p = 0; p < parameters_; ++p) seed(n_ + 1 + p, *all[parameters[p]]);
      equations_.emplace_back(lifted);
    }
  }

  // An instant at which something switches, and its derivatives with respect to the parameters.
  struct Moving {
    double value;
    Eigen::RowVectorXd derivatives;
  };
  Moving command_delay() const {
    return moving([](const plant::Equations<Jet>& equations) { return equations.command_delay_s(); });
  }
  std::vector<Moving> switches() const {
    std::vector<Moving> all;
    for (std::size_t i = 0; i < equations_.front().switch_times_s().size(); ++i)
      all.push_back(moving([i](const plant::Equations<Jet>& equations) { return equations.switch_times_s()[i]; }));
    return all;
  }

  // rates: [n x columns], reading: [3 x columns]; null where not wanted. `value`: of the rates themselves.
  void at(const plant::Situation& given, const std::vector<double>& y, Eigen::MatrixXd* rates, Eigen::MatrixXd* reading,
          std::vector<double>* value = nullptr) {
    for (std::size_t e = 0; e < equations_.size(); ++e) {
      const std::size_t first = e * width;
      for (std::size_t i = 0; i < n_; ++i) {
        state_[i] = Jet(y[i]);
        if (i >= first && i < first + width) state_[i].v[static_cast<Eigen::Index>(i - first)] = 1.0;
      }
      equations_[e].evaluate(given, state_.data(), now_, rate_.data());
      const auto begin = static_cast<Eigen::Index>(first);
      const auto count = static_cast<Eigen::Index>(std::min(width, columns() - first));
      if (value)
        for (std::size_t i = 0; i < n_; ++i) (*value)[i] = rate_[i].a;
      if (rates)
        for (std::size_t i = 0; i < n_; ++i)
          rates->row(static_cast<Eigen::Index>(i)).segment(begin, count) = rate_[i].v.head(count);
      if (reading) {
        const plant::Reading<Jet> shown = equations_[e].reading(now_, state_.data());
        reading->row(0).segment(begin, count) = shown.temperature_degC[0].v.head(count);
        reading->row(1).segment(begin, count) = shown.temperature_degC[1].v.head(count);
        reading->row(2).segment(begin, count) = shown.angle_rad.v.head(count);
      }
    }
  }

  std::size_t states() const { return n_; }
  std::size_t columns() const { return n_ + 1 + parameters_; }

 private:
  template <class Get>
  Moving moving(Get&& get) const {
    Moving result{0.0, Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(parameters_))};
    for (std::size_t e = 0; e < equations_.size(); ++e) {
      const Jet instant = get(equations_[e]);
      result.value = instant.a;
      for (std::size_t p = 0; p < parameters_; ++p)
        if ((n_ + 1 + p) / width == e)
          result.derivatives(static_cast<Eigen::Index>(p)) = instant.v[static_cast<Eigen::Index>((n_ + 1 + p) % width)];
    }
    return result;
  }

  std::size_t n_, parameters_;
  std::vector<plant::Equations<Jet>> equations_;
  std::array<Jet, plant::largest_state_count> state_, rate_;
  plant::Instant<Jet> now_;
};

template <int Size>
using Square = Eigen::Matrix<double, Size, Size>;

// e^x and phi_1(x) = (e^x - 1)/x for a matrix, by the Pade approximant (2,2) after scaling by 8: with D its
// denominator, phi_1 is 1/D there, and phi_1(2x) = (e^x + 1) phi_1(x) / 2. Fast, strongly damped modes stay damped.
template <int Size>
[[gnu::flatten]] void exponential(const Square<Size>& x, Square<Size>& exp_x, Square<Size>& phi_1) {
  const Square<Size> one = Square<Size>::Identity(), scaled = x / 8.0;
  Square<Size> square = scaled.lazyProduct(scaled);
  square /= 12.0;
  phi_1 = Square<Size>(one - 0.5 * scaled + square).partialPivLu().inverse();
  exp_x = phi_1.lazyProduct(Square<Size>(one + 0.5 * scaled + square));
  Square<Size> product;
  for (int i = 0; i < 3; ++i) {
    product = exp_x.lazyProduct(phi_1);
    phi_1 = 0.5 * (product + phi_1);
    product = exp_x.lazyProduct(exp_x);
    exp_x = product;
  }
}

// Whether the derivatives of the rates change so much within a step that it must hold a corner of the hysteresis.
constexpr int corner_parts = 6;
bool has_corner(const Eigen::Ref<const Eigen::MatrixXd>& from, const Eigen::Ref<const Eigen::MatrixXd>& to,
                double step_s) {
  const auto change = (to - from).array().abs();
  return (change > 0.5 * from.array().abs().max(to.array().abs()) && change * step_s > 1e-3).any();
}

// The sensitivities at the start are the integrator's own.
Eigen::MatrixXd first_sensitivity(const plant::Limb<double>& limb, const plant::Start& start,
                                  const plant::NumericalSettings& numerics, const plant::SensitivityRequest& request) {
  if (request.columns() == 0) return Eigen::MatrixXd(static_cast<Eigen::Index>(plant::layout_of(limb.on).size()), 0);
  return plant::Integrator(limb, start, numerics, request).state_sensitivity();
}

struct Follower {
  const FitData& data;
  plant::Limb<double> limb;
  plant::Start start;
  plant::NumericalSettings numerics;
  plant::SensitivityRequest request;

  // visit(sample, reading, sensitivity of the reading [3 x columns]); points, where wanted, one a sample.
  template <class Visit>
  bool run(bool sensitivities, std::vector<PathPoint>* points, Visit&& visit) const {
    if (!sensitivities && !points) return run_plain(visit);
    return with_padded_size(plant::layout_of(limb.on).size(),
                            [&](auto size) { return run_linearised<size.value>(sensitivities, points, visit); });
  }

 private:
  template <class Visit>
  bool run_plain(Visit&& visit) const {
    const auto& samples = data.recording->samples;
    const Eigen::Matrix<double, 3, Eigen::Dynamic> nothing;
    plant::Integrator integrator(limb, start, numerics);
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(samples[k].time_s - samples.front().time_s)) return false;
      visit(k, integrator.reading(), nothing);
      integrator.hold(samples[k].duty_fraction);
    }
    return true;
  }

  template <int Size, class Visit>
  bool run_linearised(bool sensitivities, std::vector<PathPoint>* points, Visit&& visit) const {
    const auto& samples = data.recording->samples;
    Eigen::Matrix<double, 3, Eigen::Dynamic> shown;
    Differentiator differentiator(limb, sensitivities ? request.parameters : std::vector<std::size_t>{});
    const plant::Equations<double> equations(limb);
    plant::Integrator integrator(limb, start, numerics);
    const auto n = static_cast<Eigen::Index>(differentiator.states());
    const auto parameters = static_cast<Eigen::Index>(request.parameters.size());
    const Eigen::Index wanted = sensitivities ? static_cast<Eigen::Index>(request.columns()) : 0;
    Eigen::Matrix<double, Size, Eigen::Dynamic> state_sensitivity = Eigen::MatrixXd::Zero(Size, wanted), next(state_sensitivity);
    if (sensitivities) state_sensitivity.topRows(n) = first_sensitivity(limb, start, numerics, request);
    Square<Size> linear = Square<Size>::Zero(), exp_x, phi_1;
    Eigen::Matrix<double, Size, Eigen::Dynamic> moved = Eigen::MatrixXd::Zero(Size, parameters);  // rates by parameters
    // Derivatives of the rates at the beginning, in the middle and at the end of a step; of the readings at its end.
    Eigen::MatrixXd at_start(n, static_cast<Eigen::Index>(differentiator.columns())), in_middle(at_start),
        at_end(at_start);
    Eigen::MatrixXd seen(3, at_start.cols());
    std::vector<double> y_start, y(static_cast<std::size_t>(n)), rate_start(y), rate_end(y);
    differentiator.at(integrator.instant().given, integrator.state(), &at_end, &seen, &rate_end);
    if (points) points->resize(data.sample_count);

    const auto delay = differentiator.command_delay();
    const auto switches = differentiator.switches();
    struct Event {
      double time_s;
      const Eigen::RowVectorXd* moves;
    };
    std::vector<Event> events;  // still to come
    // Where the rates jump from f- to f+ at an instant that a parameter moves: dS = (f- - f+) d instant/dp.
    const auto jump = [&](const plant::Situation& before, const Eigen::RowVectorXd& moves) {
      if (!sensitivities || moves.isZero()) return;
      plant::Instant<double> now;
      Eigen::VectorXd rate_before(n), rate_after(n);
      equations.evaluate(before, integrator.state().data(), now, rate_before.data());
      equations.evaluate(integrator.instant().given, integrator.state().data(), now, rate_after.data());
      state_sensitivity.topLeftCorner(n, parameters).noalias() += (rate_before - rate_after) * moves;
    };
    for (const auto& moving : switches)
      if (moving.value > 0.0) events.push_back({moving.value, &moving.derivatives});

    plant::PerCoil<double> commanded = start.duty_fraction;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      double time_s = samples[k].time_s - samples.front().time_s;
      if (integrator.advance_to(time_s)) return false;
      plant::Situation given = integrator.instant().given;
      if (sensitivities) {
        shown = seen.leftCols(n).lazyProduct(state_sensitivity.topRows(n));
        shown.leftCols(parameters) += seen.rightCols(parameters);
      }
      visit(k, integrator.reading(), shown);
      if (points) {
        (*points)[k].reading = seen.leftCols(n);
        (*points)[k].reading_ambient = seen.col(n);
      }
      integrator.hold(samples[k].duty_fraction);
      if (samples[k].duty_fraction != commanded) {
        commanded = samples[k].duty_fraction;
        if (delay.value > 0.0)
          events.push_back({time_s + delay.value, &delay.derivatives});
        else
          jump(given, delay.derivatives);
      }
      if (k + 1 == data.sample_count) break;
      // To the next sample, stopping at events on the way.
      const double end_s = samples[k + 1].time_s - samples.front().time_s;
      bool first = true;
      const auto cross = [&](const Eigen::MatrixXd& rates, double step_s) {
        linear.topLeftCorner(n, n) = rates.leftCols(n) * step_s;
        exponential<Size>(linear, exp_x, phi_1);
        phi_1 *= step_s;
        if (sensitivities) {
          moved.topRows(n) = rates.rightCols(parameters);
          next = exp_x.lazyProduct(state_sensitivity);
          next.leftCols(parameters) += phi_1.lazyProduct(moved);
          state_sensitivity.swap(next);
        }
        if (points) {
          PathPoint& point = (*points)[k];
          const auto transition = exp_x.topLeftCorner(n, n), integral = phi_1.topLeftCorner(n, n);
          point.integral = first ? Eigen::MatrixXd(integral) : Eigen::MatrixXd(transition * point.integral + integral);
          point.transition = first ? Eigen::MatrixXd(transition) : Eigen::MatrixXd(transition * point.transition);
          point.ambient = rates.col(n);
          first = false;
        }
      };
      bool jumped = true;  // the rates have, since `at_end`
      while (time_s < end_s) {
        auto event = events.end();
        for (auto e = events.begin(); e != events.end(); ++e)
          if (e->time_s <= end_s && (event == events.end() || e->time_s < event->time_s)) event = e;
        const double stop_s = event == events.end() ? end_s : std::max(time_s, event->time_s);
        const double step_s = stop_s - time_s;
        if (step_s > 1e-9) {
          given = integrator.instant().given;
          y_start = integrator.state();
          if (jumped) {
            differentiator.at(given, y_start, &at_start, nullptr, &rate_start);
          } else {
            at_start.swap(at_end);
            rate_start.swap(rate_end);
          }
          if (integrator.advance_to(stop_s)) return false;
          const std::vector<double>& y_end = integrator.state();
          given.time_s = stop_s;
          differentiator.at(given, y_end, &at_end, &seen, &rate_end);
          jumped = false;
          // In between the states follow the cubic through both ends and their rates.
          const int parts = has_corner(at_start.leftCols(n), at_end.leftCols(n), step_s) ? corner_parts : 1;
          for (int part = 0; part < parts; ++part) {
            const double x = (part + 0.5) / parts;
            for (std::size_t i = 0; i < y.size(); ++i)
              y[i] = y_start[i] + x * x * (3.0 - 2.0 * x) * (y_end[i] - y_start[i]) +
                     step_s * x * (1.0 - x) * ((1.0 - x) * rate_start[i] - x * rate_end[i]);
            given.time_s = time_s + x * step_s;
            differentiator.at(given, y, &in_middle, nullptr);
            cross(in_middle, step_s / parts);
          }
        }
        if (event != events.end()) {
          given.time_s = stop_s;
          jump(given, *event->moves);
          events.erase(event);
          jumped = true;
        }
        time_s = stop_s;
      }
    }
    return true;
  }
};

// The same start of a limb with other effects on: what they bring begins at rest.
plant::Start carried_over(const plant::Start& start, const plant::Limb<double>& from, const plant::Limb<double>& to) {
  const plant::Layout before = plant::layout_of(from.on), after = plant::layout_of(to.on);
  plant::Start result{std::vector<std::optional<double>>(after.size()), start.duty_fraction};
  for (std::size_t i = 0; i < before.size() && !start.given.empty(); ++i)
    for (std::size_t j = 0; j < after.size(); ++j)
      if (after.entries[j].key == before.entries[i].key) result.given[j] = start.given[i];
  return result;
}

}  // namespace

bool follow(const FitProblem& problem, const double* z, Want want, Path& path) {
  const plant::Limb<double> limb = problem.limb_at(z);
  const std::size_t unknowns = problem.unknowns().size(), parameters = problem.parameters().size();
  const std::size_t states = problem.free_states().size();
  path.residuals.assign(problem.rows().size(), 0.0);
  path.jacobian.assign(want == Want::everything ? problem.rows().size() * unknowns : 0, 0.0);
  path.points.assign(want == Want::residuals ? 0 : problem.data().size(), {});
  std::size_t row = 0;
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const std::size_t first_start = parameters + r * states;
    const Follower follower{
        data, limb, problem.start_at(z, r), problem.numerics(), {problem.parameters(), problem.free_states()}};
    const bool fine = follower.run(
        want == Want::everything, want == Want::residuals ? nullptr : &path.points[r],
        [&](std::size_t k, const plant::Reading<double>& reading,
            const Eigen::Matrix<double, 3, Eigen::Dynamic>& sensitivity) {
          for (std::size_t c = 0; c < channel_count; ++c) {
            const double target = measured(data.recording->samples[k], c);
            if (std::isnan(target)) continue;
            path.residuals[row] = (shown(reading, c) - target) / data.deviation[c];
            if (!path.jacobian.empty()) {
              double* out = path.jacobian.data() + row * unknowns;
              const double weight = 1.0 / (data.deviation[c] * channels[c].internal_per_unit);
              const auto channel = static_cast<Eigen::Index>(c);
              for (std::size_t u = 0; u < parameters; ++u)
                out[u] = sensitivity(channel, static_cast<Eigen::Index>(u)) * weight * problem.unknowns()[u].deviation;
              for (std::size_t i = 0; i < states; ++i)
                out[first_start + i] = sensitivity(channel, static_cast<Eigen::Index>(parameters + i)) * weight *
                                       problem.unknowns()[first_start + i].deviation;
            }
            ++row;
          }
        });
    if (!fine) return false;
  }
  return std::all_of(path.residuals.begin(), path.residuals.end(), [](double r) { return std::isfinite(r); });
}

bool sensitivity_to(const FitProblem& problem, const double* z, const plant::Limb<double>& limb,
                    const std::vector<std::size_t>& parameters, std::vector<double>& columns) {
  const plant::Limb<double> without = problem.limb_at(z);
  columns.assign(problem.rows().size() * parameters.size(), 0.0);
  std::vector<double> scale;
  for (const std::size_t p : parameters) {
    const auto& declared = plant::parameters()[p].declaration;
    scale.push_back(declared.prior_deviation > 0.0 ? declared.prior_deviation * declared.unit.internal_per_unit : 1.0);
  }
  std::size_t row = 0;
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const plant::Start start = carried_over(problem.start_at(z, r), without, limb);
    const Follower follower{data, limb, start, problem.numerics(), {parameters, {}}};
    const bool fine = follower.run(
        true, nullptr,
        [&](std::size_t k, const plant::Reading<double>&, const Eigen::Matrix<double, 3, Eigen::Dynamic>& sensitivity) {
          for (std::size_t c = 0; c < channel_count; ++c) {
            if (std::isnan(measured(data.recording->samples[k], c))) continue;
            const double weight = 1.0 / (data.deviation[c] * channels[c].internal_per_unit);
            for (std::size_t p = 0; p < parameters.size(); ++p)
              columns[row * parameters.size() + p] =
                  sensitivity(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(p)) * weight * scale[p];
            ++row;
          }
        });
    if (!fine) return false;
  }
  return true;
}

}  // namespace sinew::diagnose
