// SPDX-License-Identifier: Apache-2.0
// Laws: physics without a name, as a curve. A law is a term at an entry of a System (System::entries()) that is a function of one
// variable, by its values at knots: linear between them, held beyond.
//
//   equations   c ds/dt = ... + g(a)      with c the value of Entry::divided_by, or 1
//   readings    m = ... + g(a)
//
// or g(a) times a variable that the entry knows as one of its parts (Entry::factors): the curve is then by what share that part changes.
//
// a is a variable of the System, or that less its own low-pass, which is a memory that fades:
//
//   a = v - v_slow,   dv_slow/dt = (v - v_slow) / fading_memory_s
//
// Every part that has the entry has the same curve, of a variable of its own. `with_laws` gives a System with its laws as further effects,
// so that whatever runs, fits or compares plants takes them as it takes an effect; exactly nothing where they are off. A System's laws
// and its catalogue share one list, the laws last.
//
// Leaves out: where a law moves an equation, the plant at rest is that without it, and a run begins by settling.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "plant/system.h"

namespace sinew::plant {

struct Law {
  EntryGroupId entry;
  std::vector<VariableId> argument;  // of each entry of the group, in the order of System::entries()
  std::vector<VariableId> factor;    // the same; empty: none
  double fading_memory_s = 0.0;      // 0: none
  std::vector<double> knots;         // rising, at least two; in the variable's unit
  // [knots x weights]: the values at the knots, in the unit of the entry's group (an internal unit), or shares of the factor, are curve *
  // weights. A law that is known has one column, its values, whose weight is 1; of one that is sought each weight is an unknown with the
  // prior N(0, 1).
  Eigen::MatrixXd curve;
  bool is_sought = false;
  std::string name = "";  // "law_1"; with_laws gives it where it is empty
  friend bool operator==(const Law& left, const Law& right);
};

// `base` with these laws, all off. Its first states, parameters, effects are those of `base`, with the same ids. `base` itself may have
// laws. Throws std::invalid_argument where a law does not fit it.
std::shared_ptr<const System> with_laws(std::shared_ptr<const System> base, std::vector<Law> laws);

// The plant in a System of more laws, which are off: same values, same effects.
Plant carried_into(const Plant& plant, const std::shared_ptr<const System>& with_more_laws);

// "heat of temperature A", "heat from the air A times a law of speed of bending, less its slow part": in the words of the first part.
std::string law_words(const System& system, const Law& law);

// Values at the knots of a law of a plant, in internal units of its entry.
Eigen::VectorXd values_of(const Plant& plant, EffectId law);

// The plant in a System of these laws beside those that it has; they are on.
Plant with_laws_on(const Plant& plant, std::vector<Law> laws);

// What a file keeps of a plant: those of its laws that are on, as they are known, and where parts are apart (apart.h), values of their own.
Plant as_in_file(const Plant& plant);

}  // namespace sinew::plant
