// SPDX-License-Identifier: Apache-2.0
// An effect of the catalogue beside an explanation of recordings, at its usual strength, and all else fitted again: would they look like
// this if it were there?
//
// To first order (diagnose/score.h) that is asked at no strength, where an effect that the other parameters nearly imitate seems to be
// hundreds of standard deviations away at its usual one, though with it they fit as well or better. So it is fitted.
#pragma once

#include <memory>
#include <vector>

#include "diagnose/diagnosis.h"

namespace sinew::investigate {

struct AtUsualStrength {
  std::vector<std::shared_ptr<const diagnose::Explanation>> with;  // each effect; null where the plant cannot be integrated with it
  // Of the base, fitted again from where the likeliest of these ended: so that what only a better fit gains is no effect's gain.
  double log_evidence_without = 0.0;
};
AtUsualStrength at_usual_strength(const diagnose::Explanation& base, const std::vector<plant::EffectId>& effects,
                                  const diagnose::SearchSettings& settings);

}  // namespace sinew::investigate
