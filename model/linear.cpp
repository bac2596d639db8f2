// SPDX-License-Identifier: Apache-2.0
#include "model/linear.h"

#include <Eigen/Cholesky>
#include <cmath>

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
LinearModel fit(const std::vector<Series>& training, Index order) {
  Matrix<double> squares;
  Vector<double> products;
  for (const Series& one : training)
    for (Index k = std::max(Index{1}, order); k < one.samples(); ++k) {
      const Vector<double> row = row_at(order, one.v, one.y, k);
      if (squares.size() == 0) {
        squares = Matrix<double>::Zero(row.size(), row.size());
        products = Vector<double>::Zero(row.size());
      }
      squares.selfadjointView<Eigen::Lower>().rankUpdate(row);
      products += row * one.y(k);
    }
  squares.diagonal() *= 1.0 + 1e-9;
  squares.diagonal().array() += 1e-12;
  return {order, squares.selfadjointView<Eigen::Lower>().ldlt().solve(products)};
}

}  // namespace

LinearModel fit_static(const std::vector<Series>& training) { return fit(training, 0); }

LinearModel fit_arx(const std::vector<Series>& training) {
  std::vector<Series> first, last;
  for (const Series& one : training) {
    const Index kept = one.samples() * 85 / 100;
    first.push_back(part_of(one, 0, kept));
    last.push_back(part_of(one, kept, one.samples() - kept));
  }
  Index best = 1;
  double least = HUGE_VAL;
  for (const Index order : {1, 2, 4, 8, 16}) {
    const LinearModel tried = fit(first, order);
    double sum = 0.0;
    for (const Series& one : last) sum += (rollout(tried, one) - one.y).squaredNorm();
    if (sum < least) {
      least = sum;
      best = order;
    }
  }
  return fit(training, best);
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
