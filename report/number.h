// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sinew::report {

// Numbers as text, through std::to_chars: the same on every machine and in every locale. A plain hyphen is the
// minus sign, so that a cell can be copied into a spreadsheet. NaN is an en dash, infinities are ∞ and -∞, and
// nothing is ever "-0".

// `decimals` digits after the point.
std::string fixed(double value, int decimals);

// `digits` significant digits; trailing zeros stay, since they are a claim. An exponent is used below 1e-4 and
// from 1e7 on; in between, digits before the point are never cut.
std::string significant(double value, int digits);

// `digits` significant digits and an exponent: 1.50e-7.
std::string scientific(double value, int digits);

// As fixed, without trailing zeros; for data that a machine reads.
std::string compact(double value, int decimals);

}  // namespace sinew::report
