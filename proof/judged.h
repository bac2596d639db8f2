// SPDX-License-Identifier: Apache-2.0
// What one case's answer is worth: each question that a figure asks of a case, answered once.
#pragma once

#include "proof/case_record.h"

namespace sinew::proof {

// Below this d' a recording shows nothing: to say so is right.
inline constexpr double invisible_below = 5.0;
// A name that is given with less than this is no confident answer.
inline constexpr double confident = 0.5;
inline constexpr double nearly_certain = 0.9;

inline bool is_of(const Case& one, std::initializer_list<CaseFamily> families) {
  for (const CaseFamily family : families)
    if (one.truth.family == family) return true;
  return false;
}

// The names that would be right. None where the catalogue has no such name: outside, removed.
std::vector<std::string> right_names(const Truth& truth);
bool is_right_name(const Case& one, const std::string& name);
// Of the names that were given, how many are right.
int right_names_given(const Case& one);

// In what parts are not alike; nothing where they are.
std::vector<std::string> unlike_in(const Truth& truth);

// "(nothing)", "(unknown)", or the first name that was given.
std::string first_said(const Reported& reported);
bool first_is_right(const Case& one);
bool is_named_confidently(const Reported& reported);  // the first name is given with a half or more
bool is_said_unlike(const Reported& reported, const std::string& quantity);
// Any name, or that parts are not alike.
bool has_wrong_answer_with(const Case& one, double least_probability);
// What was named, and what cannot be told from it.
std::vector<std::string> answered_set(const Reported& reported);
bool set_has_the_truth(const Case& one);

// Something is concealed, but shows nothing: d' is small, or calibration absorbs the effect and the answer lists it by name as one that
// this recording cannot show.
bool has_nothing_to_see(const Case& one);
// And the answer was that nothing is missing: right, and no case for the figures that count names.
bool is_rightly_unseen(const Case& one);

// The equation, of the first of the concealed effects.
bool first_place_is_right(const Case& one);
bool place_is_right(const Case& one);  // said first, or among those said to be alike

// Of the reduction of the held-out error that `reference` reaches, how much the answer reaches; nothing where it reaches none.
std::optional<double> share_of_reduction(double before, double after, std::optional<double> reference);
bool is_worse_than_before(const HeldOut& error);

// Whether the answer counts as right in its family: strata and misses go by this.
bool is_right(const Case& one);
// What was wrong in words; empty of a right answer.
std::string miss_of(const Case& one);
// What the numbers of a missed case say of why.
std::string reason_of(const Case& one);

}  // namespace sinew::proof
