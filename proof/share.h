// SPDX-License-Identifier: Apache-2.0
// How many of how many, with how sure that is; and the median.
#pragma once

#include <vector>

namespace sinew::proof {

struct Interval {
  double lowest, highest;
};

struct Share {
  int good = 0, all = 0;
  void add(bool is_good) { good += is_good, ++all; }
  double value() const;  // NaN of none
  // Wilson's, 95 % (1927, J. Am. Stat. Assoc. 22:209). NaN of none.
  Interval interval() const;
};

// NaN of none.
double median(std::vector<double> values);

}  // namespace sinew::proof
