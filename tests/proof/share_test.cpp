// SPDX-License-Identifier: Apache-2.0
#include "proof/share.h"

#include <doctest/doctest.h>

#include <cmath>

namespace share_test {

using namespace sinew::proof;
using doctest::Approx;

TEST_CASE("share: Wilson's interval of none of ten, and of nine of ten") {
  // By z = 1.959964: 0 of 10 is z^2 / (10 + z^2) at most. 9 of 10: Newcombe 1998, Stat. Med. 17:857, method 3, by hand.
  CHECK(Share{0, 10}.interval().lowest == Approx(0.0).epsilon(1e-12));
  CHECK(Share{0, 10}.interval().highest == Approx(0.277533).epsilon(1e-5));
  CHECK(Share{9, 10}.interval().lowest == Approx(0.595850).epsilon(1e-5));
  CHECK(Share{9, 10}.interval().highest == Approx(0.982124).epsilon(1e-5));
}

TEST_CASE("share: of none is not a number") {
  CHECK(std::isnan(Share{}.value()));
  CHECK(std::isnan(Share{}.interval().lowest));
}

TEST_CASE("median: of an odd count the middle, of an even one the mean of two, of none no number") {
  CHECK(median({3.0, 1.0, 2.0}) == 2.0);
  CHECK(median({4.0, 1.0, 2.0, 3.0}) == 2.5);
  CHECK(std::isnan(median({})));
}

}  // namespace share_test
