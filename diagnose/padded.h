// SPDX-License-Identifier: Apache-2.0
// Small matrices in a few sizes that are known at compile time: what is smaller is padded with rows and columns of nothing, which
// stay so. No memory is taken from the heap, and loops run over whole vector registers. What is larger has matrices of its own
// size, and the library's products.
#pragma once

#include <type_traits>
#include <utility>

#include <Eigen/Core>

namespace sinew::diagnose {

// work(size) with the least size, as a std::integral_constant, that holds so many states; Eigen::Dynamic where none does.
template <class Work>
decltype(auto) with_padded_size(std::size_t states, Work&& work) {
  if (states <= 8) return work(std::integral_constant<int, 8>{});
  if (states <= 12) return work(std::integral_constant<int, 12>{});
  if (states <= 16) return work(std::integral_constant<int, 16>{});
  return work(std::integral_constant<int, Eigen::Dynamic>{});
}

// The rows that matrices of this many states have.
inline Eigen::Index padded(std::size_t states) {
  return with_padded_size(states, [&](auto size) {
    return size.value == Eigen::Dynamic ? static_cast<Eigen::Index>(states) : static_cast<Eigen::Index>(size.value);
  });
}

// a * b: loops that the compiler unrolls where the sizes are known, else the library's blocked product.
template <int Size, class A, class B>
auto product(const A& a, const B& b) {
  if constexpr (Size == Eigen::Dynamic)
    return (a * b).eval();
  else
    return a.lazyProduct(b);
}

}  // namespace sinew::diagnose
