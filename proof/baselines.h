// SPDX-License-Identifier: Apache-2.0
// What simpler methods make of the same concealed cases, so that the proof's figures stand beside something.
//
// Forward selection by BIC: least squares with the sensors' noise alone; of the three effects that the score test ranks
// highest and those it is blind for, the one whose fit has the lowest BIC is added, as long as BIC falls (Schwarz 1978,
// Ann. Stat. 6:461); its weights are each effect's share of exp(-BIC / 2) over all the fits that were made. SINDy on the residual: what the
// calibrated core leaves of each channel as a sparse sum of products, up to second degree, of duties and the core's own temperatures and
// angle, by sequentially thresholded least squares; the threshold by BIC (Brunton, Proctor, Kutz 2016, PNAS 113:3932; Kaheman et al. 2019,
// arXiv 1909.08574). Gaussian process on the residual: the same residual as a smooth function of the same five quantities, squared
// exponential, 300 points, length and noise by marginal likelihood on a grid (Rasmussen, Williams 2006, chapters 2 and
// 5). It names nothing.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnose/diagnosis.h"

namespace sinew::proof {

// RMSE of three channels in units of their noise, as one number.
double normalised(const diagnose::PerChannel& rmse, const diagnose::PerChannel& noise);

// {"bic": {"effects": [names], "weights": {name: 0 to 1}, "normalised_after"}, "sindy": {"terms": {channel: count}, "normalised_after"},
//  "gaussian_process": {"normalised_after"}}, of a diagnosis of one training and one held-out recording.
nlohmann::ordered_json baselines(const diagnose::Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings);

}  // namespace sinew::proof
