// SPDX-License-Identifier: Apache-2.0
#include "model/linear.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "model/errors.h"
#include "model/train.h"

namespace sinew::model {
namespace {

// Row of the regression at sample k, with the values before taken from `y`.
Vector<double> row_at(Index order, const Matrix<double>& v, const Vector<double>& y, Index k) {
  const Index K = v.rows();
  Vector<double> row(order + K * (order + 1) + 1);
  for (Index i = 1; i <= order; ++i) row(i - 1) = y(std::max(Index{0}, k - i));
  for (Index i = 0; i <= order; ++i) row.segment(order + i * K, K) = v.col(std::max(Index{0}, k - i));
  row(row.size() - 1) = 1.0;
  return row;
}

// Least squares by the normal equations, with a ridge of 1e-9 of their diagonal: lags of a smooth signal are nearly the same.
// Coefficients are NaN where no stretch of `order` + 1 samples is measured.
LinearModel fit(const std::vector<Series>& training, Index order) {
  const Index size = order + training.front().v.rows() * (order + 1) + 1;
  Matrix<double> squares = Matrix<double>::Zero(size, size);
  Vector<double> products = Vector<double>::Zero(size);
  bool any = false;
  for (const Series& one : training)
    for (Index k = std::max(Index{1}, order); k < one.samples(); ++k) {
      bool all_measured = true;
      for (Index i = 0; i <= order; ++i) all_measured = all_measured && one.is_measured(k - i);
      if (!all_measured) continue;
      any = true;
      const Vector<double> row = row_at(order, one.v, one.y, k);
      squares.selfadjointView<Eigen::Lower>().rankUpdate(row);
      products += row * one.y(k);
    }
  if (!any) return {order, Vector<double>::Constant(size, std::nan(""))};
  squares.diagonal() *= 1.0 + 1e-9;
  squares.diagonal().array() += 1e-12;
  return {order, squares.selfadjointView<Eigen::Lower>().ldlt().solve(products)};
}

// Sum of squares of a rollout's errors; with `squares` and `products`, its Gauss-Newton matrix and the gradient's negative half.
double simulation_error(const LinearModel& model, const std::vector<Series>& training, Matrix<double>* squares, Vector<double>* products) {
  const Index n = model.order, size = model.coefficients.size();
  double sum = 0.0;
  if (squares) {
    squares->setZero(size, size);
    products->setZero(size);
  }
  // Columns are the derivatives of the n values before, the latest at k modulo n; and many are added to the matrix at a time.
  constexpr Index block = 256;
  Matrix<double> before(size, n), many(size, block);
  for (const Series& one : training) {
    Vector<double> y(one.samples()), row;
    y(0) = one.y(0);
    before.setZero();
    Index held = 0;
    for (Index k = 1; k < one.samples(); ++k) {
      row = row_at(n, one.v, y, k);
      y(k) = model.coefficients.dot(row);
      const double error = one.is_measured(k) ? one.y(k) - y(k) : 0.0;
      sum += error * error;
      if (!std::isfinite(sum)) return HUGE_VAL;
      if (!squares) continue;
      // What came before the first sample is as at the first, which is given: no derivative.
      for (Index i = 1; i <= std::min(n, k - 1); ++i) row += model.coefficients(i - 1) * before.col((k - i) % n);
      before.col(k % n) = row;
      if (one.is_measured(k)) {
        *products += error * row;
        many.col(held++) = row;
      }
      if (held == block || k + 1 == one.samples()) {
        squares->selfadjointView<Eigen::Lower>().rankUpdate(many.leftCols(held));
        held = 0;
      }
    }
  }
  return sum;
}

// Whether what was before fades: all roots of z^n - p_1 z^(n-1) - ... - p_n inside the unit circle, by the recursion of Schur and Cohn
// (Oppenheim and Schafer, 3rd ed., 11.5: all reflection coefficients below 1).
bool is_stable(const LinearModel& model) {
  Vector<double> a = -model.coefficients.head(model.order);
  for (Index m = model.order; m > 0; --m) {
    const double reflection = a(m - 1);
    if (!(std::abs(reflection) < 1.0)) return false;
    const Vector<double> before = a;
    for (Index i = 0; i + 1 < m; ++i) a(i) = (before(i) - reflection * before(m - 2 - i)) / (1.0 - reflection * reflection);
  }
  return true;
}

// From a model on, downhill in the error of rollouts, among those that are stable: over stretches of minutes one that is not can fit
// well, and be beyond all bounds after ten.
LinearModel descend(LinearModel model, const std::vector<Series>& training, const std::function<bool()>& should_stop) {
  constexpr int most_passes = 60;
  constexpr double enough = 1e-5;
  Matrix<double> squares;
  Vector<double> products;
  double error = simulation_error(model, training, &squares, &products), damping = 1e-3;
  for (int pass = 0; pass < most_passes && damping < 1e8; ++pass) {
    if (should_stop && should_stop()) throw Stopped{};
    Matrix<double> damped = squares;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-12;
    LinearModel tried = model;
    tried.coefficients += damped.selfadjointView<Eigen::Lower>().ldlt().solve(products);
    const double there = is_stable(tried) ? simulation_error(tried, training, nullptr, nullptr) : HUGE_VAL;
    if (there < error) {
      const bool little = error - there < enough * error;
      model = tried;
      error = simulation_error(model, training, &squares, &products);
      if (little) break;
      damping *= 0.1;
    } else {
      damping *= 10.0;
    }
  }
  return model;
}

// The fit to one step may be unstable; least squares on v alone never is.
LinearModel fit_simulation(const std::vector<Series>& training, Index order, const std::function<bool()>& should_stop) {
  const LinearModel still = fit(training, 0);
  LinearModel one_step = fit(training, order), from_static{order, Vector<double>::Zero(one_step.coefficients.size())};
  const Index K = training.front().v.rows();
  from_static.coefficients.segment(order, K) = still.coefficients.head(K);
  from_static.coefficients(from_static.coefficients.size() - 1) = still.coefficients(K);
  const bool usable = is_stable(one_step);
  const LinearModel a = descend(usable ? one_step : from_static, training, should_stop);
  if (!usable) return a;
  const LinearModel b = descend(from_static, training, should_stop);
  return simulation_error(b, training, nullptr, nullptr) < simulation_error(a, training, nullptr, nullptr) ? b : a;
}

// Stretches of two minutes, each of which begins where y was measured: a rollout may begin anywhere, and one long one would leave what
// comes of its beginning unseen.
std::vector<Series> stretches_of(const std::vector<Series>& training) {
  constexpr Index length = 1200, least = 100;
  std::vector<Series> stretches;
  for (const Series& one : training)
    for (Index from = 0; from + least <= one.samples(); from += length) {
      Index begin = from;
      while (begin < one.samples() && !one.is_measured(begin)) ++begin;
      if (const Index end = std::min(one.samples(), from + length); begin + least <= end)
        stretches.push_back(part_of(one, begin, end - begin));
    }
  return stretches;
}

using Predict = Vector<double>(const LinearModel&, const Series&);

// The order that does best over the last 15 %, fitted to all.
template <class Fit>
LinearModel best_order(const std::vector<Series>& training, const std::vector<Index>& orders, Fit&& fit_by, Predict* predict = rollout) {
  std::vector<Series> first, last;
  for (const Series& one : training) {
    const Index kept = one.samples() * 85 / 100;
    first.push_back(part_of(one, 0, kept));
    last.push_back(part_of(one, kept, one.samples() - kept));
  }
  Index best = 1;
  double least = HUGE_VAL;
  for (const Index order : orders) {
    const LinearModel tried = fit_by(first, order);
    double sum = 0.0;
    for (const Series& one : last) sum += squared_error(predict(tried, one), one, 0, one.samples()).sum;
    if (sum < least) {
      least = sum;
      best = order;
    }
  }
  return fit_by(training, best);
}

}  // namespace

LinearModel fit_static(const std::vector<Series>& training) { return fit(training, 0); }

LinearModel fit_arx(const std::vector<Series>& training) { return best_order(training, {1, 2, 4, 8, 16}, fit); }

LinearModel fit_arx_one_step(const std::vector<Series>& training) { return best_order(training, {1, 2, 4, 8, 16}, fit, one_step_ahead); }

LinearModel fit_arx_simulation(const std::vector<Series>& training, const std::function<bool()>& should_stop) {
  return best_order(training, {1, 2, 4, 8}, [&](const std::vector<Series>& data, Index order) {
    const std::vector<Series> stretches = stretches_of(data);
    return fit_simulation(stretches.empty() ? data : stretches, order, should_stop);
  });
}

Vector<double> rollout(const LinearModel& model, const Series& series) {
  Vector<double> y(series.samples());
  y(0) = series.y(0);
  for (Index k = 1; k < series.samples(); ++k) y(k) = model.coefficients.dot(row_at(model.order, series.v, y, k));
  return y;
}

Vector<double> one_step_ahead(const LinearModel& model, const Series& series) {
  Vector<double> y(series.samples());
  y(0) = series.y(0);
  for (Index k = 1; k < series.samples(); ++k) y(k) = model.coefficients.dot(row_at(model.order, series.v, series.y, k));
  return y;
}

}  // namespace sinew::model
