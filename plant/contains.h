// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <iterator>

namespace sinew {

template <class Range, class Value>
bool contains(const Range& all, const Value& one) {
  return std::find(std::begin(all), std::end(all), one) != std::end(all);
}

}  // namespace sinew
