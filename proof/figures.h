// SPDX-License-Identifier: Apache-2.0
// The figures of the proof: each is one function in figures.cpp, with its definition and its goal.
#pragma once

#include <variant>

#include "proof/case_record.h"
#include "proof/share.h"

namespace sinew::proof {

struct Goal {
  double least, most;
  std::string words;
  bool reached_by(double value) const { return value >= least && value <= most; }  // not by NaN
};

// A median, a mean, or an error: of so many.
struct Quantity {
  double value;
  std::size_t of;
  bool as_percent = false;
};

struct Figure {
  std::string what;
  std::variant<Share, Quantity> measured;
  Goal goal;

  std::size_t of() const;  // 0: not measured
  double value() const;
  bool reached() const { return of() > 0 && goal.reached_by(value()); }
};

std::vector<Figure> figures_of(const std::vector<Case>& cases);

// Right names of each effect of the catalogue, where it shows.
std::map<std::string, Share> right_by_effect(const std::vector<Case>& cases);

// Shares of the held-out reduction that an oracle reaches (HeldOut::oracle), where it reaches any.
std::vector<double> shares_of_oracle(const std::vector<Case>& cases, std::initializer_list<CaseFamily> families);

}  // namespace sinew::proof
