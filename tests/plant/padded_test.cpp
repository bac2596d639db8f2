// SPDX-License-Identifier: Apache-2.0
#include "plant/padded.h"

#include <doctest/doctest.h>

#include "sim/random.h"

namespace plant_padded_test {

using namespace sinew;

namespace {

// Of `filled` rows and columns; the rest of the diagonal is one. The first column begins with nothing, so that rows must be exchanged.
template <int Size>
Eigen::Matrix<double, Size, Size> drawn(Eigen::Index filled, std::uint64_t seed) {
  const sim::RandomStream chance(seed, "padded");
  const Eigen::Index rows = Size == Eigen::Dynamic ? filled : Size;
  Eigen::Matrix<double, Size, Size> matrix = Eigen::MatrixXd::Identity(rows, rows);
  for (Eigen::Index i = 0; i < filled; ++i)
    for (Eigen::Index j = 0; j < filled; ++j) matrix(i, j) = chance.normal(static_cast<std::uint64_t>(i * filled + j));
  matrix(0, 0) = 0.0;
  return matrix;
}

template <int Size>
void check(Eigen::Index filled) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto matrix = drawn<Size>(filled, seed);
    Eigen::Matrix<double, Size, Size> inverse = matrix;
    plant::invert<Size>(inverse);
    const Eigen::MatrixXd one = matrix * inverse;
    CHECK((one - Eigen::MatrixXd::Identity(one.rows(), one.cols())).cwiseAbs().maxCoeff() < 1e-10);
    // What is padded stays so, to the last bit.
    for (Eigen::Index i = filled; i < inverse.rows(); ++i)
      for (Eigen::Index j = 0; j < inverse.cols(); ++j) {
        CHECK(inverse(i, j) == (i == j ? 1.0 : 0.0));
        CHECK(inverse(j, i) == (i == j ? 1.0 : 0.0));
      }
  }
}

}  // namespace

TEST_CASE("matrices are inverted in their place, whatever their first pivot") {
  check<8>(8);
  check<8>(5);
  check<12>(11);
  check<16>(13);
  check<Eigen::Dynamic>(21);
}

}  // namespace plant_padded_test
