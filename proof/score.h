// SPDX-License-Identifier: Apache-2.0
// The score of a proof: figures with their goals (figures.h), the reliability of the probabilities (forecasts.h), and the cases laid out
// in tables. score_text.h writes it.
#pragma once

#include "proof/figures.h"
#include "proof/forecasts.h"
#include "proof/methods.h"

namespace sinew::proof {

struct EffectScore {
  Share right;     // the name comes first
  int hidden = 0;  // cases that show nothing of it, and were answered so
};

// What was answered to the cases of a family.
struct FamilyScore {
  int right_first = 0, wrong_first = 0;  // the first name
  int unknown = 0;                       // no name, but something is missing
  int nothing = 0;                       // no name: nothing is missing
  int failed = 0;
  int wrong_confident = 0, wrong_nearly_certain = 0;  // any wrong name with a half or more, with 0.9 or more
  std::vector<double> shares_of_oracle;               // of the held-out reduction
};

struct ConfidenceClass {
  double from, to;
  Share right;  // the first name
};

struct Miss {
  std::string id, why, reason;
  double visibility;
  Verdict verdict;
  std::vector<std::string> truth, named;
};

struct Misplaced {
  std::string id, said, truth;
};

// How good the probabilities of one method are.
struct Reliability {
  std::string method;
  std::size_t forecasts = 0;
  double brier, log, calibration_error, calibration_error_by_chance;
  std::vector<ReliabilityBin> bins;
};

struct Score {
  int cases = 0, wanted = 0;  // that are there, that were asked for
  int invisible = 0;          // cases that show nothing, and were answered so
  std::optional<std::uint64_t> first_seed, first_clean_seed;
  std::vector<Figure> figures;
  std::map<std::string, EffectScore> by_effect;
  std::map<std::string, std::map<std::string, Share>> by_disturbance;  // of each: by family, right answers
  std::map<std::string, std::map<std::string, Share>> strata;          // of each family: by d', right answers
  std::map<CaseFamily, FamilyScore> by_family;
  std::map<std::string, std::map<std::string, int>> confusion;  // of what was concealed: by what was said first
  std::vector<ConfidenceClass> confidence;
  std::vector<Reliability> reliability;  // Sinew's, then those of methods that give probabilities
  Share said_nothing, said_unknown;      // answers without a probability
  std::vector<MethodRow> methods;
  std::vector<Miss> misses;
  std::vector<Misplaced> misplaced;
  std::map<std::string, int> programs;  // that made the cases
  // Parts that are not alike: of those that differ in a quantity, said so; of the cases in which all are alike, said otherwise.
  Share said_unlike, wrongly_said_unlike;
  Share place_said_first;                                      // of the equations
  int worse_for_all = 0;                                       // held-out error worse than before, and worse for an oracle, too
  int clean = 0;                                               // cases
  double largest_clean_gain = 0.0, largest_clean_noise = 0.0;  // of an effect; process noise of the core
};

inline const std::vector<std::string> visibility_strata{"d' < 5", "5 to 20", "20 to 100", "over 100"};

Score score_of(const std::vector<Case>& cases);

}  // namespace sinew::proof
