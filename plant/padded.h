// SPDX-License-Identifier: Apache-2.0
// Small matrices in a few sizes that are known at compile time: what is smaller is padded with rows and columns of nothing, which
// stay so. No memory is taken from the heap, and loops run over whole vector registers. What is larger has matrices of its own
// size, and the library's products.
#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/LU>

namespace sinew::plant {

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

// matrix = its inverse, by Gauss-Jordan elimination with partial pivoting where the size is known: whole columns at a time, in the
// matrix's own place. A singular one becomes infinite or not a number; what is padded needs ones on the diagonal, and keeps them.
template <int Size>
void invert(Eigen::Matrix<double, Size, Size>& matrix) {
  if constexpr (Size == Eigen::Dynamic) {
    matrix = matrix.partialPivLu().inverse().eval();
  } else {
    Eigen::Vector<Eigen::Index, Size> exchanged;
    for (Eigen::Index k = 0; k < Size; ++k) {
      Eigen::Index pivot = k;
      for (Eigen::Index i = k + 1; i < Size; ++i)
        if (std::abs(matrix(i, k)) > std::abs(matrix(pivot, k))) pivot = i;
      exchanged(k) = pivot;
      if (pivot != k) matrix.row(k).swap(matrix.row(pivot));
      const double reciprocal = 1.0 / matrix(k, k);
      Eigen::Vector<double, Size> eliminated = matrix.col(k);
      eliminated(k) = 0.0;
      matrix.col(k).setZero();
      matrix(k, k) = 1.0;
      for (Eigen::Index j = 0; j < Size; ++j) {
        const double share = matrix(k, j) * reciprocal;
        matrix.col(j) -= eliminated * share;
        matrix(k, j) = share;
      }
    }
    for (Eigen::Index k = Size; k-- > 0;)
      if (exchanged(k) != k) matrix.col(k).swap(matrix.col(exchanged(k)));
  }
}

}  // namespace sinew::plant
