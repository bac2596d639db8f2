// SPDX-License-Identifier: Apache-2.0
// Linear references: what a predictor must beat to be worth its weights.
//
//   static   y(t) = a v(t) + b                                                          (the paper's least squares)
//   ARX      y(t) = sum_i p_i y(t-i) + sum_i q_i v(t-i) + b,  i = 1 ... n, v also at i = 0   (Ljung, 2nd ed., 4.2)
//
// The ARX is fitted to one step ahead; its order is the one of 1, 2, 4, 8, 16 that does best in rollouts over the last 15 % of
// what it is fitted to. In a rollout, what was before the first sample is taken to be as at the first.
#pragma once

#include "model/series.h"

namespace sinew::model {

LinearModel fit_static(const std::vector<Series>& training);
LinearModel fit_arx(const std::vector<Series>& training);

// As those of predictor.h.
Vector<double> rollout(const LinearModel& model, const Series& series);
Vector<double> one_step_ahead(const LinearModel& model, const Series& series);

}  // namespace sinew::model
