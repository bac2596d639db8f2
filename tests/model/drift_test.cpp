// SPDX-License-Identifier: Apache-2.0
#include "model/drift.h"

#include <doctest/doctest.h>

#include <cmath>

#include "sim/random.h"

namespace model_drift_test {

using namespace sinew;
using namespace sinew::model;

namespace {

// Errors of ten minutes whose size grows by this share of the mean square a minute, and which go together for ten seconds.
std::vector<double> slope_and_square(std::uint64_t seed, double growth_1_min) {
  const sim::RandomStream chance(seed, "error");
  Vector<double> error(6001);
  for (Index k = 0; k < error.size(); ++k) {
    const double minutes = static_cast<double>(k - drift_from) / 600.0, mean_minutes = 4.5;
    error(k) = std::sqrt(std::max(0.0, 1.0 + growth_1_min * (minutes - mean_minutes))) * chance.normal(static_cast<std::uint64_t>(k / 100));
  }
  const Vector<double> counted = error.tail(error.size() - drift_from);
  return {squared_error_slope_1_min(error), counted.squaredNorm() / static_cast<double>(counted.size())};
}
Drift drift_with(double growth_1_min, std::uint64_t first_seed, int sessions) {
  std::vector<double> slopes, squares;
  for (int i = 0; i < sessions; ++i) {
    const auto one = slope_and_square(first_seed + static_cast<std::uint64_t>(i), growth_1_min);
    slopes.push_back(one[0]);
    squares.push_back(one[1]);
  }
  return drift_of({slopes}, {squares});
}

}  // namespace

TEST_CASE("drift: the slope of a squared error that grows by 3 a minute is 3") {
  Vector<double> error(6001);
  for (Index k = 0; k < error.size(); ++k) error(k) = std::sqrt(5.0 + 3.0 * static_cast<double>(k) / 600.0);
  CHECK(squared_error_slope_1_min(error) == doctest::Approx(3.0).epsilon(1e-9));
  CHECK(std::isnan(squared_error_slope_1_min(error.head(drift_from + 1000))));
}
TEST_CASE("drift: 100 sessions show a growth of 5 % a minute, and none where there is none") {
  const Drift growing = drift_with(0.05, 1, 100);
  CHECK(growing.lowest > 0.0);
  CHECK(growing.lowest < 0.05);
  CHECK(growing.highest > 0.05);
  CHECK(growing.rmse == doctest::Approx(1.0).epsilon(0.05));
  // Of 40 predictors without drift, about one lies above its interval by chance: with five the test would be wrong once in 10^4.
  int alarms = 0;
  for (std::uint64_t i = 0; i < 40; ++i) alarms += drift_with(0.0, 1000 * (i + 1), 30).lowest > 0.0;
  CHECK(alarms <= 5);
}
TEST_CASE("drift: several seeds over the same sessions are one block a session, not many") {
  std::vector<double> slopes, squares;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const auto one = slope_and_square(i + 1, 0.0);
    slopes.push_back(one[0]);
    squares.push_back(one[1]);
  }
  const Drift once = drift_of({slopes}, {squares}), thrice = drift_of({slopes, slopes, slopes}, {squares, squares, squares});
  CHECK(thrice.lowest == doctest::Approx(once.lowest).epsilon(1e-9));
  CHECK(thrice.highest == doctest::Approx(once.highest).epsilon(1e-9));
}

}  // namespace model_drift_test
