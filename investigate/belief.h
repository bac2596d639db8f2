// SPDX-License-Identifier: Apache-2.0
// What is believed of a limb after a diagnosis: the answers that are still possible, and their probabilities.
//
// The diagnosis gives a verdict, the effects it names with a confidence each, and what fits in their place with a loss of log evidence.
// Here that becomes one list whose probabilities sum to 1:
//
// - the named answer, with the smallest confidence of its effects;
// - each rival, with that probability times exp(-loss);
// - "something else", not in the catalogue or in another form, with what is left.
//
// Where nothing is named and nothing is left over, the list is "nothing is missing" and every effect of the catalogue that may be there at
// its usual strength though it was not found. One effect in so many is expected beforehand, each with 1 / their number; the score test
// says how a limb with it would have looked. Let r be the root of its statistic that usual strength would bring on average, z the one that
// was found: the likelihood ratio is exp((r z - r^2 / 2) / k), 1 where the recordings could not have shown it. The k is by how much
// the diagnosis holds gains to be exaggerated: it takes one below SearchSettings::least_gain for chance, where independent normal errors
// would bring 2 log(effects).
#pragma once

#include <string>
#include <vector>

#include "diagnose/diagnosis.h"

namespace sinew::investigate {

enum class Kind {
  nothing,         // the plant as given, calibrated
  named,           // effects that an explanation was fitted with
  unseen,          // an effect that the recordings could not have shown well enough to be excluded
  something_else,  // no explanation at hand
};
std::string_view text_of(Kind kind);

struct Hypothesis {
  Kind kind = Kind::nothing;
  std::vector<plant::EffectId> effects;  // beyond the plant as given
  std::string key;                       // "nothing", "latent_heat", "latent_heat+dry_friction", "something else"
  double probability = 0.0;
};

struct Belief {
  std::vector<Hypothesis> all;  // most probable first
  diagnose::Verdict verdict = diagnose::Verdict::consistent;
  std::vector<plant::EffectId> unseen;  // at usual strength these would have gone unnoticed
  std::vector<plant::EffectId> never;   // of these, what other parameters imitate: no duty shows it to the sensors that there are
  double entropy_bit() const;
  const Hypothesis& first() const { return all.front(); }
  // Of the unseen ones, those that duty may yet show.
  std::vector<plant::EffectId> not_yet_seen() const;
};

Belief belief_of(const diagnose::Diagnosis& diagnosis, const diagnose::DiagnosisSettings& settings);

// What the likelihood ratios above are divided by, in their logarithm.
double exaggeration(const diagnose::DiagnosisSettings& settings, std::size_t effects);

}  // namespace sinew::investigate
