// SPDX-License-Identifier: Apache-2.0
// Parts that are not alike. What parts of a kind share (System::sharings()) each may have of its own; parts that were made alike
// are believed to be alike, and a recording that does not drive a part tells of it what the others tell.
//
//   value of part j = shared value * exp(w_j s)       or shared value + w_j s, where it has no natural zero;   w_j ~ N(0, 1)
//
// s is half of what is declared of the quantity (its prior's deviation, as a share of it where it has a natural zero): parts are nearer to
// each other than to what is typical of any. What a file knows of a limb is of the shared value, and says nothing of s. `with_parts_apart`
// gives a System with such weights as further effects, one for each sharing, so that whatever fits or compares plants takes them as it
// takes an effect; exactly the plant as it was where they are off, or where all weights are 0.
#pragma once

#include "plant/system.h"

namespace sinew::plant {

// `base` with one effect more for each of its sharings, all off. Its first parameters and effects are those of `base`, with the same ids;
// its states are those of `base`. `base` itself where nothing is shared, or where it has such effects already.
std::shared_ptr<const System> with_parts_apart(std::shared_ptr<const System> base);

// Whether parts of this plant may differ in it: not where the plant's file says that a value of it is known.
bool may_differ(const Plant& plant, const Sharing& sharing);

// A value that a part has of its own. Internal units.
struct ApartValue {
  ParameterId shared;
  std::size_t part;    // of Sharing::parts
  ParameterId weight;  // in which it moves
  double value;
  double by_shared, by_weight;  // its derivatives
};
// Of a plant whose effect is that of a sharing.
std::vector<ApartValue> values_apart(const Plant& plant, EffectId apart);

}  // namespace sinew::plant
