// SPDX-License-Identifier: Apache-2.0
#include "diagnose/path.h"

#include <algorithm>
#include <functional>

#include "plant/padded.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

constexpr std::size_t width = plant::jet_width;
constexpr double same_time_s = 1e-9;  // as the integrator has it: an event by so little after a sample is at it
using plant::Jet;
using plant::product;
using plant::with_padded_size;

// Derivatives with respect to all states, the surroundings and any parameters, as many Jets as that takes.
class Differentiator {
 public:
  Differentiator(const plant::Plant& plant, const std::vector<plant::ParameterId>& parameters)
      : n_(plant.states().size()),
        channels_(plant.system().channels().size()),
        parameters_(parameters.size()),
        state_(n_),
        rate_(n_),
        shown_(channels_) {
    const std::optional<plant::ParameterId> surroundings = plant.system().surroundings();
    for (std::size_t first = 0; first < columns(); first += width) {
      std::vector<std::pair<plant::ParameterId, int>> seeds;
      const auto seed = [&](std::size_t column, plant::ParameterId parameter) {
        if (column >= first && column < first + width) seeds.emplace_back(parameter, static_cast<int>(column - first));
      };
      if (surroundings) seed(n_, *surroundings);
      for (std::size_t p = 0; p < parameters_; ++p) seed(n_ + 1 + p, parameters[p]);
      equations_.push_back(plant.equations_with_derivatives(seeds));
    }
  }

  // An instant at which something switches, and its derivatives with respect to the parameters.
  struct Moving {
    double value;
    Eigen::RowVectorXd derivatives;
  };
  Moving input_delay() const {
    return moving([](const plant::Equations<Jet>& equations) { return equations.input_delay_s(); });
  }
  std::vector<Moving> switches() const {
    std::vector<Moving> all;
    for (std::size_t i = 0; i < equations_.front()->switch_times_s().size(); ++i)
      all.push_back(moving([i](const plant::Equations<Jet>& equations) { return equations.switch_times_s()[i]; }));
    return all;
  }

  // rates: [n x columns], reading: [channels x columns]; null where not wanted. `value`: of the rates themselves.
  void at(const plant::Situation& given, const std::vector<double>& y, Eigen::MatrixXd* rates, Eigen::MatrixXd* reading,
          std::vector<double>* value = nullptr) {
    for (std::size_t e = 0; e < equations_.size(); ++e) {
      const std::size_t first = e * width;
      for (std::size_t i = 0; i < n_; ++i) {
        state_[i] = Jet(y[i]);
        if (i >= first && i < first + width) state_[i].v[static_cast<Eigen::Index>(i - first)] = 1.0;
      }
      equations_[e]->rates(given, state_.data(), rate_.data());
      const auto begin = static_cast<Eigen::Index>(first);
      const auto count = static_cast<Eigen::Index>(std::min(width, columns() - first));
      if (value)
        for (std::size_t i = 0; i < n_; ++i) (*value)[i] = rate_[i].a;
      if (rates)
        for (std::size_t i = 0; i < n_; ++i) rates->row(static_cast<Eigen::Index>(i)).segment(begin, count) = rate_[i].v.head(count);
      if (reading) {
        equations_[e]->readings(state_.data(), shown_.data());
        for (std::size_t c = 0; c < channels_; ++c)
          reading->row(static_cast<Eigen::Index>(c)).segment(begin, count) = shown_[c].v.head(count);
      }
    }
  }

  std::size_t states() const { return n_; }
  std::size_t channels() const { return channels_; }
  std::size_t columns() const { return n_ + 1 + parameters_; }

 private:
  template <class Get>
  Moving moving(Get&& get) const {
    Moving result{0.0, Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(parameters_))};
    for (std::size_t e = 0; e < equations_.size(); ++e) {
      const Jet instant = get(*equations_[e]);
      result.value = instant.a;
      for (std::size_t p = 0; p < parameters_; ++p)
        if ((n_ + 1 + p) / width == e)
          result.derivatives(static_cast<Eigen::Index>(p)) = instant.v[static_cast<Eigen::Index>((n_ + 1 + p) % width)];
    }
    return result;
  }

  std::size_t n_, channels_, parameters_;
  std::vector<std::unique_ptr<plant::Equations<Jet>>> equations_;
  std::vector<Jet> state_, rate_, shown_;
};

template <int Size>
using Square = Eigen::Matrix<double, Size, Size>;

// e^x and phi_1(x) = (e^x - 1)/x for a matrix, by the Pade approximant (2,2) after scaling by 8: with D its
// denominator, phi_1 is 1/D there, and phi_1(2x) = (e^x + 1) phi_1(x) / 2. Fast, strongly damped modes stay damped.
template <int Size>
SINEW_FLATTEN void exponential(const Square<Size>& x, Square<Size>& exp_x, Square<Size>& phi_1) {
  const Square<Size> one = Square<Size>::Identity(x.rows(), x.cols()), scaled = x / 8.0;
  Square<Size> square = product<Size>(scaled, scaled);
  square /= 12.0;
  phi_1 = one - 0.5 * scaled + square;
  plant::invert<Size>(phi_1);
  exp_x = product<Size>(phi_1, Square<Size>(one + 0.5 * scaled + square));
  Square<Size> twice;
  for (int i = 0; i < 3; ++i) {
    twice = product<Size>(exp_x, phi_1);
    phi_1 = 0.5 * (twice + phi_1);
    twice = product<Size>(exp_x, exp_x);
    exp_x = twice;
  }
}

// How many parts a step is crossed in, each with the derivatives of the rates in its middle: several where they change so much that
// it must hold a corner, none where they hardly change, so that the mean of both ends does: what a step carries is off by less.
constexpr int corner_parts = 6;
int parts_of(const Eigen::Ref<const Eigen::MatrixXd>& from, const Eigen::Ref<const Eigen::MatrixXd>& to, double step_s) {
  const auto change = (to - from).array().abs();
  if ((change > 0.5 * from.array().abs().max(to.array().abs()) && change * step_s > 1e-3).any()) return corner_parts;
  return change.maxCoeff() * step_s < 1e-2 ? 0 : 1;
}

// The sensitivities at the start are the integrator's own.
Eigen::MatrixXd first_sensitivity(const plant::Plant& plant, const plant::Start& start, const plant::NumericalSettings& numerics,
                                  const plant::SensitivityRequest& request) {
  if (request.columns() == 0) return Eigen::MatrixXd(static_cast<Eigen::Index>(plant.states().size()), 0);
  return plant::Integrator(plant, start, numerics, request).state_sensitivity();
}

struct Follower {
  const FitData& data;
  plant::Plant with_;
  plant::Start start;
  plant::NumericalSettings numerics;
  plant::SensitivityRequest request;
  const Eigen::MatrixXd* pushes;  // Course::pushes of the recording; null: none

  // visit(sample, reading, sensitivity of the readings [channels x columns]); points, where wanted, one a sample.
  using Visit = std::function<void(std::size_t, const std::vector<double>&, const Eigen::MatrixXd&)>;
  bool run(bool sensitivities, std::vector<PathPoint>* points, const Visit& visit) const {
    if (!sensitivities && !points) return run_plain(visit);
    return with_padded_size(with_.states().size(), [&](auto size) { return run_linearised<size.value>(sensitivities, points, visit); });
  }

 private:
  bool run_plain(const Visit& visit) const {
    const auto& samples = data.recording->samples;
    const Eigen::MatrixXd nothing;
    plant::Integrator integrator(with_, start, numerics);
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(samples[k].time_s - samples.front().time_s)) return false;
      if (pushes && k > 0) integrator.move(pushes->col(static_cast<Eigen::Index>(k) - 1));
      visit(k, integrator.readings(), nothing);
      sim::command_sample(integrator, with_.system(), samples, k);
    }
    return true;
  }

  template <int Size>
  bool run_linearised(bool sensitivities, std::vector<PathPoint>* points, const Visit& visit) const {
    const auto& samples = data.recording->samples;
    Eigen::MatrixXd shown;
    Differentiator differentiator(with_, sensitivities ? request.parameters : std::vector<plant::ParameterId>{});
    const std::unique_ptr<plant::Equations<double>> equations = with_.equations();
    plant::Integrator integrator(with_, start, numerics);
    const auto n = static_cast<Eigen::Index>(differentiator.states());
    const auto parameters = static_cast<Eigen::Index>(request.parameters.size());
    const Eigen::Index wanted = sensitivities ? static_cast<Eigen::Index>(request.columns()) : 0;
    const Eigen::Index rows = Size == Eigen::Dynamic ? n : Size;
    Eigen::Matrix<double, Size, Eigen::Dynamic> state_sensitivity = Eigen::MatrixXd::Zero(rows, wanted), next(state_sensitivity);
    if (sensitivities) state_sensitivity.topRows(n) = first_sensitivity(with_, start, numerics, request);
    Square<Size> linear = Square<Size>::Zero(rows, rows), exp_x, phi_1;
    Eigen::Matrix<double, Size, Eigen::Dynamic> moved = Eigen::MatrixXd::Zero(rows, parameters);  // rates by parameters
    // Derivatives of the rates at the beginning, in the middle and at the end of a step; of the readings at its end.
    Eigen::MatrixXd at_start(n, static_cast<Eigen::Index>(differentiator.columns())), in_middle(at_start), at_end(at_start);
    Eigen::MatrixXd seen(static_cast<Eigen::Index>(differentiator.channels()), at_start.cols());
    Eigen::Matrix<double, Eigen::Dynamic, Size, Eigen::RowMajor> seen_states = Eigen::MatrixXd::Zero(seen.rows(), rows);
    std::vector<double> y_start, y(static_cast<std::size_t>(n)), rate_start(y), rate_end(y);
    differentiator.at(integrator.situation(), integrator.state(), &at_end, &seen, &rate_end);
    if (points) points->resize(data.sample_count);

    const auto delay = differentiator.input_delay();
    const auto switches = differentiator.switches();
    struct Event {
      double time_s;
      const Eigen::RowVectorXd* moves;
    };
    std::vector<Event> events;  // still to come
    // Where the rates jump from f- to f+ at an instant that a parameter moves: dS = (f- - f+) d instant/dp.
    const auto jump = [&](const plant::Situation& before, const Eigen::RowVectorXd& moves) {
      if (!sensitivities || moves.isZero()) return;
      Eigen::VectorXd rate_before(n), rate_after(n);
      equations->rates(before, integrator.state().data(), rate_before.data());
      equations->rates(integrator.situation(), integrator.state().data(), rate_after.data());
      state_sensitivity.topLeftCorner(n, parameters).noalias() += (rate_before - rate_after) * moves;
    };
    for (const auto& moving : switches)
      if (moving.value > 0.0) events.push_back({moving.value, &moving.derivatives});

    std::vector<double> commanded = start.inputs;
    commanded.resize(with_.system().inputs().size(), 0.0);
    bool jumped = true;  // the rates have, since `at_end`
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      double time_s = samples[k].time_s - samples.front().time_s;
      if (integrator.advance_to(time_s)) return false;
      plant::Situation given = integrator.situation();
      if (sensitivities) {
        seen_states.leftCols(n) = seen.leftCols(n);
        shown = product<Size>(seen_states, state_sensitivity);
        shown.leftCols(parameters) += seen.rightCols(parameters);
      }
      visit(k, integrator.readings(), shown);
      if (points) {
        (*points)[k].reading = seen.leftCols(n);
        (*points)[k].reading_ambient = seen.col(n);
      }
      sim::command_sample(integrator, with_.system(), samples, k);
      if (samples[k].inputs != commanded) {
        commanded = samples[k].inputs;
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
          next = product<Size>(exp_x, state_sensitivity);
          next.leftCols(parameters) += product<Size>(phi_1, moved);
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
      const plant::Situation& now = integrator.situation();
      jumped = jumped || now.segment_start_s != given.segment_start_s || !now.slopes_1_s.empty();
      while (time_s < end_s) {
        auto event = events.end();
        for (auto e = events.begin(); e != events.end(); ++e)
          if (e->time_s <= end_s + same_time_s && (event == events.end() || e->time_s < event->time_s)) event = e;
        const double stop_s = event == events.end() ? end_s : std::clamp(event->time_s, time_s, end_s);
        const double step_s = stop_s - time_s;
        if (step_s > same_time_s) {
          given = integrator.situation();
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
          const int parts = parts_of(at_start.leftCols(n), at_end.leftCols(n), step_s);
          if (parts == 0) {
            in_middle = 0.5 * (at_start + at_end);
            cross(in_middle, step_s);
          }
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
      if (!pushes) continue;
      integrator.move(pushes->col(static_cast<Eigen::Index>(k)));
      differentiator.at(integrator.situation(), integrator.state(), &at_end, &seen, &rate_end);
      jumped = false;
    }
    return true;
  }
};

// The same start of a plant with other effects on: what they bring begins at rest, or has gone on for as long as the recordings' clock
// says.
plant::Start carried_over(const plant::Start& start, const plant::Plant& from, const plant::Plant& to, const sim::Recording& recording,
                          std::optional<double> counted_from_s) {
  const plant::States before = from.states(), after = to.states();
  plant::Start result{elapsed_where_it_begins(after, recording, counted_from_s), start.inputs};
  if (start.given.empty()) return result;
  for (const plant::StateId i : before.ids())
    for (const plant::StateId j : after.ids())
      if (after[j].key == before[i].key) result.given[j.index] = start.given[i.index];
  return result;
}

}  // namespace

bool follow(const FitProblem& problem, const double* z, Want want, Path& path) {
  const plant::Plant plant = problem.plant_at(z);
  const plant::System& system = problem.system();
  const std::size_t unknowns = problem.unknowns().size(), parameters = problem.parameters().size();
  path.residuals.assign(problem.rows().size(), 0.0);
  const bool derivatives = want == Want::derivatives || want == Want::everything, points = want == Want::points || want == Want::everything;
  path.jacobian.assign(derivatives ? problem.rows().size() * unknowns : 0, 0.0);
  path.points.assign(points ? problem.data().size() : 0, {});
  std::vector<double> slopes;
  for (std::size_t u = 0; u < unknowns; ++u) slopes.push_back(problem.unknowns()[u].slope_at(z[u]));
  std::size_t row = 0;
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const std::size_t first_start = problem.first_start(r), states = problem.free_states(r).size();
    const Course* course = problem.course().get();
    const Follower follower{data,
                            plant,
                            problem.start_at(z, r),
                            problem.numerics(),
                            {problem.parameters(), problem.free_states(r)},
                            course ? &course->pushes[r] : nullptr};
    const bool fine = follower.run(derivatives, points ? &path.points[r] : nullptr,
                                   [&](std::size_t k, const std::vector<double>& readings, const Eigen::MatrixXd& sensitivity) {
                                     for (const plant::ChannelId c : system.channels().ids()) {
                                       const double target = measured(data.recording->samples[k], c);
                                       if (std::isnan(target)) continue;
                                       path.residuals[row] = (shown(system, readings, c) - target) / data.deviation[c];
                                       if (course) path.residuals[row] -= course->response[row];
                                       if (!path.jacobian.empty()) {
                                         double* out = path.jacobian.data() + row * unknowns;
                                         const double weight = 1.0 / (data.deviation[c] * system.channels()[c].unit.internal_per_unit);
                                         const auto channel = static_cast<Eigen::Index>(c.index);
                                         for (std::size_t u = 0; u < parameters; ++u)
                                           out[u] = sensitivity(channel, static_cast<Eigen::Index>(u)) * weight * slopes[u];
                                         for (std::size_t i = 0; i < states; ++i)
                                           out[first_start + i] = sensitivity(channel, static_cast<Eigen::Index>(parameters + i)) * weight *
                                                                  slopes[first_start + i];
                                       }
                                       ++row;
                                     }
                                   });
    if (!fine) return false;
  }
  return std::all_of(path.residuals.begin(), path.residuals.end(), [](double r) { return std::isfinite(r); });
}

std::vector<double> response_to(const FitProblem& problem, const Path& path, const std::vector<Eigen::MatrixXd>& pushes) {
  const plant::System& system = problem.system();
  std::vector<double> response;
  response.reserve(problem.rows().size());
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(path.points[r].front().reading.cols());
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      const PathPoint& point = path.points[r][k];
      for (const plant::ChannelId c : system.channels().ids())
        if (!std::isnan(measured(data.recording->samples[k], c)))
          response.push_back(point.reading.row(static_cast<Eigen::Index>(c.index)).dot(moved) /
                             (data.deviation[c] * system.channels()[c].unit.internal_per_unit));
      if (point.transition.size() > 0) moved = (point.transition * moved + pushes[r].col(static_cast<Eigen::Index>(k))).eval();
    }
  }
  return response;
}

bool sensitivity_to(const FitProblem& problem, const double* z, const plant::Plant& with, const std::vector<plant::ParameterId>& parameters,
                    std::vector<double>& columns) {
  const plant::Plant without = problem.plant_at(z);
  // The same recordings of that plant, for the course on its states.
  std::shared_ptr<const Course> course;
  if (problem.course()) {
    FitProblem same(with, {}, problem.data(), problem.beginnings(), problem.numerics());
    same.set_course(problem.course());
    course = same.course();
  }
  const plant::System& system = problem.system();
  columns.assign(problem.rows().size() * parameters.size(), 0.0);
  std::vector<double> scale;
  for (const plant::ParameterId p : parameters) {
    const auto& declared = with.system().parameters()[p].declaration;
    scale.push_back(declared.prior_deviation > 0.0 ? declared.prior_deviation * declared.unit.internal_per_unit : 1.0);
  }
  std::size_t row = 0;
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const plant::Start start = carried_over(problem.start_at(z, r), without, with, *data.recording, problem.beginnings().counted_from_s);
    const Follower follower{data, with, start, problem.numerics(), {parameters, {}}, course ? &course->pushes[r] : nullptr};
    const bool fine = follower.run(true, nullptr, [&](std::size_t k, const std::vector<double>&, const Eigen::MatrixXd& sensitivity) {
      for (const plant::ChannelId c : system.channels().ids()) {
        if (std::isnan(measured(data.recording->samples[k], c))) continue;
        const double weight = 1.0 / (data.deviation[c] * system.channels()[c].unit.internal_per_unit);
        for (std::size_t p = 0; p < parameters.size(); ++p)
          columns[row * parameters.size() + p] =
              sensitivity(static_cast<Eigen::Index>(c.index), static_cast<Eigen::Index>(p)) * weight * scale[p];
        ++row;
      }
    });
    if (!fine) return false;
  }
  return true;
}

}  // namespace sinew::diagnose
