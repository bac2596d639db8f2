// SPDX-License-Identifier: Apache-2.0
// Linear references: what a predictor must beat to be worth its weights.
//
//   static   y(t) = a v(t) + b                                                          (the paper's least squares)
//   ARX      y(t) = sum_i p_i y(t-i) + sum_i q_i v(t-i) + b,  i = 1 ... n, v also at i = 0   (Ljung, 2nd ed., 4.2)
//
// The ARX is fitted to one step ahead, or to the error of its own rollout (simulation error, Ljung, 2nd ed., 7.2, by the method of
// Levenberg and Marquardt from the fit to one step, over stretches of two minutes that begin in mid-motion). Its order is the one of 1, 2,
// 4, 8, 16 (simulation error: of 1, 2, 4, 8) that does best in rollouts over the last 15 % of what it is fitted to. In a rollout, what was
// before the first sample is taken to be as at the first.
#pragma once

#include <functional>

#include "model/series.h"

namespace sinew::model {

LinearModel fit_static(const std::vector<Series>& training);
LinearModel fit_arx(const std::vector<Series>& training);
// The order is the one that is best one step ahead instead.
LinearModel fit_arx_one_step(const std::vector<Series>& training);
// `should_stop` is asked at every pass over the data; throws Stopped (train.h).
LinearModel fit_arx_simulation(const std::vector<Series>& training, const std::function<bool()>& should_stop = {});

// As those of network_loop.h.
Vector<double> rollout(const LinearModel& model, const Series& series);
Vector<double> one_step_ahead(const LinearModel& model, const Series& series);

}  // namespace sinew::model
