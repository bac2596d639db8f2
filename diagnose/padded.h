// SPDX-License-Identifier: Apache-2.0
// Small matrices in a few sizes that are known at compile time: what is smaller is padded with rows and columns of nothing, which
// stay so. No memory is taken from the heap, and loops run over whole vector registers.
#pragma once

#include <type_traits>
#include <utility>

#include "plant/equations.h"

namespace sinew::diagnose {

// work(size) with the least size, as a std::integral_constant, that holds so many states of a limb.
template <class Work>
decltype(auto) with_padded_size(std::size_t states, Work&& work) {
  if (states <= 8) return work(std::integral_constant<int, 8>{});
  if (states <= 12) return work(std::integral_constant<int, 12>{});
  if (states <= 16) return work(std::integral_constant<int, 16>{});
  return work(std::integral_constant<int, (static_cast<int>(plant::largest_state_count) + 3) / 4 * 4>{});
}

}  // namespace sinew::diagnose
