// SPDX-License-Identifier: Apache-2.0
// Whether probabilities mean what they say: of a hundred names given with 0.8, about eighty should be right.
//
// What counts as a forecast, and when it comes true:
// - each name that is given, with its probability: it comes true where that effect is one of those that are concealed, in whatever form.
//   Where what is concealed has no name in the catalogue (outside, removed) no name comes true;
// - "nothing is missing", where that is the answer and a probability is given with it: it comes true where nothing is concealed, or
//   where what is concealed shows nothing in this recording (judged.h). Given without a probability it is no forecast, and is counted
//   as a share of right answers (said_nothing in figures of their own);
// - "something is missing, and it has no name here" is what the names given leave over of 1, no forecast of its own: it would come
//   true exactly where they do not. Without any name it is counted as a share of right answers, too.
#pragma once

#include "proof/case_record.h"
#include "proof/share.h"

namespace sinew::proof {

struct Forecast {
  double probability;
  bool came_true;
};

std::vector<Forecast> forecasts_of(const std::vector<Case>& cases);
// Of the names that forward selection by BIC gives, each with its BIC weight; of the cases that were put to it.
std::vector<Forecast> forecasts_of_bic(const std::vector<Case>& cases);

// Answers without a probability: "nothing is missing", and "something is missing" without a name. Right: see above; of the second, where
// what is concealed has no name in the catalogue.
Share said_nothing(const std::vector<Case>& cases);
Share said_unknown(const std::vector<Case>& cases);

// Mean squared distance of the probability from what came true (1) or did not (0). All of these are NaN of no forecast.
double brier_score(const std::vector<Forecast>& forecasts);
// Mean of -ln of the probability given to what happened; infinite where a certainty was wrong.
double log_score(const std::vector<Forecast>& forecasts);

// The Brier score that also asks about what was not said: per case, the squared distances of all names together, a name that is not given
// having probability 0. Two methods that name different numbers of effects can be compared by this one; NaN of no case.
double brier_score_of_cases(const std::vector<Case>& cases);
double brier_score_of_cases_bic(const std::vector<Case>& cases);  // of the cases that have BIC weights
std::vector<Case> with_bic_weights(const std::vector<Case>& cases);

// Forecasts of about the same probability: what they said on average, and how often they came true.
struct ReliabilityBin {
  double lowest, highest, mean_probability;
  double variance;  // of the share that comes true by chance, if every probability means what it says
  Share came_true;
};

// As many bins as are usual (Naeini, Cooper, Hauskrecht 2015, AAAI 29), of equal count as near as equal probabilities, which are never
// parted, allow.
inline constexpr std::size_t usual_bins = 10;
std::vector<ReliabilityBin> equal_count_bins(std::vector<Forecast> forecasts, std::size_t bins = usual_bins);

// Mean distance of the bins' mean probability from the share that came true, each bin weighted by its forecasts.
double expected_calibration_error(const std::vector<ReliabilityBin>& bins);
// What that comes to, on average, by chance, if every probability means what it says: few forecasts cannot show less.
double calibration_error_by_chance(const std::vector<ReliabilityBin>& bins);

}  // namespace sinew::proof
