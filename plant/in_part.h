// SPDX-License-Identifier: Apache-2.0
// Effects in one part of a plant: a part whose strength is its own, and at its null, is without an effect that the others have.
#pragma once

#include <string>

#include "plant/system.h"

namespace sinew::plant {

// Whether an effect that is on acts in one of EffectInfo::parts: where parts have strengths of their own, by the one that holds there.
bool is_on_in(const Plant& plant, EffectId effect, const std::string& part);

// On in all of them, and on at all where it has no parts.
bool is_on_everywhere(const Plant& plant, EffectId effect);

}  // namespace sinew::plant
