// SPDX-License-Identifier: Apache-2.0
// The experiment that is expected to tell most per minute, cooling included, among those that tell enough to be worth while.
#pragma once

#include <functional>

#include "investigate/information.h"

namespace sinew::investigate {

struct DesignSettings {
  double longest_drive_s = 160.0;
  double longest_s = 300.0;  // with cooling; what is left of the budget
  double least_share = 0.0;  // of the entropy, from which on a programme tells
  int rounds = 2;            // in which the best are varied in shape
  std::size_t varied = 2;    // so many of them
  int threads = 2;
  std::function<bool()> should_stop;  // throws diagnose::Stopped where it says so
  std::function<void(double done_share)> progress;
};

struct Design {
  Expected best;       // not possible where nothing is
  bool tells = false;  // it does, and more than the least share
  double before_nat = 0.0;
  std::size_t tried = 0;
  // Of each alternative, the farthest that any programme that was tried sets it apart from the first.
  std::vector<double> farthest;
};

Design design(const Question& question, const DesignSettings& settings);

}  // namespace sinew::investigate
