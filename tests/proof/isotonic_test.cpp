// SPDX-License-Identifier: Apache-2.0
#include "proof/isotonic.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isotonic_test {

using namespace sinew::proof;
using doctest::Approx;

// So many forecasts of a probability, of which so many came true.
std::vector<Forecast> forecasts(std::vector<std::array<double, 3>> all) {
  std::vector<Forecast> made;
  for (const auto& [probability, of, good] : all)
    for (int i = 0; i < of; ++i) made.push_back({probability, i < good});
  return made;
}

TEST_CASE("isotonic: where frequencies rise, each probability goes to its own") {
  const MonotoneMap map = isotonic(forecasts({{0.2, 10, 1}, {0.5, 10, 4}, {0.9, 10, 7}}));
  CHECK(map(0.2) == Approx(0.1).epsilon(1e-12));
  CHECK(map(0.5) == Approx(0.4).epsilon(1e-12));
  CHECK(map(0.9) == Approx(0.7).epsilon(1e-12));
}

TEST_CASE("isotonic: neighbours that violate the order are pooled, back to where the order holds") {
  // 6 of 10 above 2 of 30: together 8 of 40. That violates 3 of 10 before it: 11 of 50.
  const MonotoneMap map = isotonic(forecasts({{0.1, 10, 1}, {0.3, 10, 3}, {0.5, 10, 6}, {0.7, 30, 2}, {0.9, 10, 9}}));
  CHECK(map(0.1) == Approx(0.1).epsilon(1e-12));
  for (const double probability : {0.3, 0.5, 0.6, 0.7}) CHECK(map(probability) == Approx(0.22).epsilon(1e-12));
  CHECK(map(0.9) == Approx(0.9).epsilon(1e-12));
}

TEST_CASE("isotonic: between knots it is straight in log odds, beyond them constant") {
  const MonotoneMap map = isotonic(forecasts({{0.2, 10, 2}, {0.8, 10, 6}}));
  // 0.5 has log odds 0, in the middle of those of 0.2 and 0.8; 2/3 has ln 2, three quarters of the way from -ln 4 to ln 4.
  CHECK(map(0.5) == Approx(0.4).epsilon(1e-12));
  CHECK(map(2.0 / 3.0) == Approx(0.5).epsilon(1e-12));
  CHECK(map(0.0) == Approx(0.2).epsilon(1e-12));
  CHECK(map(1.0) == Approx(0.6).epsilon(1e-12));
}

TEST_CASE("isotonic: certainties have infinite log odds, and everything between is nearer to what is finite") {
  const MonotoneMap map = isotonic(forecasts({{0.0, 10, 1}, {0.5, 10, 5}, {1.0, 10, 8}}));
  CHECK(map(0.0) == Approx(0.1).epsilon(1e-12));
  CHECK(map(0.01) == Approx(0.5).epsilon(1e-12));
  CHECK(map(0.99) == Approx(0.5).epsilon(1e-12));
  CHECK(map(1.0) == Approx(0.8).epsilon(1e-12));
}

TEST_CASE("isotonic: never falls, and has no larger Brier score than the probabilities themselves") {
  std::vector<Forecast> made;
  for (int i = 1; i < 200; ++i) made.push_back({i / 200.0, (i * 37) % 101 < i / 3});
  const MonotoneMap map = isotonic(made);
  double last = 0.0;
  for (int i = 0; i <= 1000; ++i) {
    CHECK(map(i / 1000.0) >= last);
    last = map(i / 1000.0);
  }
  std::vector<Forecast> mapped = made;
  for (Forecast& one : mapped) one.probability = map(one.probability);
  CHECK(brier_score(mapped) < brier_score(made));
  CHECK(expected_calibration_error(equal_count_bins(mapped)) < expected_calibration_error(equal_count_bins(made)));
}

TEST_CASE("isotonic: the order of the forecasts does not matter, and without any there is no map") {
  std::vector<Forecast> made = forecasts({{0.3, 4, 3}, {0.6, 4, 1}, {0.9, 4, 4}});
  const MonotoneMap forward = isotonic(made);
  std::reverse(made.begin(), made.end());
  CHECK(isotonic(made).frequency == forward.frequency);
  CHECK(isotonic(made).log_odds == forward.log_odds);
  CHECK(std::isnan(isotonic({})(0.5)));
}

}  // namespace isotonic_test
