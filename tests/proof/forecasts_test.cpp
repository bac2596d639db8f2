// SPDX-License-Identifier: Apache-2.0
#include "proof/forecasts.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/proof/cases_for_tests.h"

namespace forecasts_test {

using namespace sinew::proof;
using doctest::Approx;
using proof_for_tests::concealing;
using proof_for_tests::naming;

TEST_CASE("forecasts: Brier and log score of three forecasts, by hand") {
  const std::vector<Forecast> forecasts{{0.8, true}, {0.6, false}, {0.5, true}};
  CHECK(brier_score(forecasts) == Approx((0.04 + 0.36 + 0.25) / 3.0).epsilon(1e-12));
  CHECK(log_score(forecasts) == Approx(-(std::log(0.8) + std::log(0.4) + std::log(0.5)) / 3.0).epsilon(1e-12));
}

TEST_CASE("forecasts: a wrong certainty has an infinite log score, a right one none") {
  CHECK(std::isinf(log_score({{1.0, false}, {0.5, true}})));
  CHECK(log_score({{1.0, true}, {0.0, false}}) == 0.0);
}

TEST_CASE("forecasts: without any, scores are not a number") {
  CHECK(std::isnan(brier_score({})));
  CHECK(std::isnan(log_score({})));
  CHECK(equal_count_bins({}).empty());
  CHECK(std::isnan(expected_calibration_error({})));
}

TEST_CASE("forecasts: bins have equal counts, and equal probabilities are never parted") {
  std::vector<Forecast> forecasts;
  for (int i = 0; i < 20; ++i) forecasts.push_back({0.01 * i, i % 2 == 0});
  for (const ReliabilityBin& bin : equal_count_bins(forecasts, 5)) CHECK(bin.came_true.all == 4);
  // Of ten, five alike: the first bin, of at least five, takes all of them.
  std::vector<Forecast> alike(5, Forecast{0.3, true});
  for (int i = 0; i < 5; ++i) alike.push_back({0.5 + 0.1 * i, true});
  const auto bins = equal_count_bins(alike, 4);
  REQUIRE(bins.size() == 4);
  CHECK(bins[0].came_true.all == 5);
  CHECK(bins[0].highest == 0.3);
  CHECK(bins[1].lowest == 0.5);
  int all = 0;
  for (const ReliabilityBin& bin : bins) all += bin.came_true.all;
  CHECK(all == 10);
}

TEST_CASE("forecasts: more bins than forecasts leave a bin for each") {
  CHECK(equal_count_bins({{0.1, true}, {0.2, false}}, 10).size() == 2);
}

TEST_CASE("forecasts: calibration error of two bins, weighted by their counts, by hand") {
  // Eight at 0.25 of which six came true: off by 0.5. Two at 0.9 of which two did: off by 0.1.
  std::vector<Forecast> forecasts;
  for (int i = 0; i < 8; ++i) forecasts.push_back({0.25, i < 6});
  forecasts.insert(forecasts.end(), 2, Forecast{0.9, true});
  CHECK(expected_calibration_error(equal_count_bins(forecasts)) == Approx(0.8 * 0.5 + 0.2 * 0.1).epsilon(1e-12));
}

TEST_CASE("forecasts: by chance a hundred that say a half miss by sqrt(2 / pi) of a standard deviation of 0.05") {
  CHECK(calibration_error_by_chance(equal_count_bins(std::vector<Forecast>(100, {0.5, true}))) == Approx(0.0398942).epsilon(1e-5));
}

TEST_CASE("forecasts: each name given is one, and comes true where that effect is concealed, in whatever form") {
  const auto forecasts = forecasts_of({naming(concealing(CaseFamily::other_form, {"lag"}), {{"lag", 0.7}, {"creep", 0.2}})});
  REQUIRE(forecasts.size() == 2);
  double of_right = 0.0, of_wrong = 0.0;
  for (const Forecast& one : forecasts) (one.came_true ? of_right : of_wrong) += one.probability;
  CHECK(of_right == 0.7);
  CHECK(of_wrong == 0.2);
}

TEST_CASE("forecasts: no name comes true where the effect was taken out of the catalogue, not even its own") {
  CHECK_FALSE(forecasts_of({naming(concealing(CaseFamily::removed, {"lag"}), {{"lag", 0.7}})})[0].came_true);
}

TEST_CASE("forecasts: nothing missing is one only with a probability, and comes true of what cannot be seen, too") {
  Case clean = naming(concealing(CaseFamily::clean, {}), {}), hidden = naming(concealing(CaseFamily::catalogue, {"lag"}), {}),
       seen = hidden;
  hidden.reported.visibility = 1.0;
  seen.reported.visibility = 50.0;
  for (Case* one : {&clean, &hidden, &seen}) one->reported.verdict = Verdict::consistent;
  CHECK(forecasts_of({clean, hidden, seen}).empty());
  CHECK(said_nothing({clean, hidden, seen}).good == 2);
  CHECK(said_nothing({clean, hidden, seen}).all == 3);
  for (Case* one : {&clean, &hidden, &seen}) one->reported.probability_of_nothing = 0.9;
  const auto forecasts = forecasts_of({clean, hidden, seen});
  REQUIRE(forecasts.size() == 3);
  CHECK(forecasts[0].came_true);
  CHECK(forecasts[1].came_true);
  CHECK_FALSE(forecasts[2].came_true);
}

TEST_CASE("forecasts: something without a name is right where the catalogue has no name for it") {
  Case outside = naming(concealing(CaseFamily::outside, {"bow"}), {}), inside = naming(concealing(CaseFamily::catalogue, {"lag"}), {});
  for (Case* one : {&outside, &inside}) one->reported.verdict = Verdict::unexplained;
  CHECK(said_unknown({outside, inside}).good == 1);
  CHECK(said_unknown({outside, inside}).all == 2);
}

TEST_CASE("forecasts: a name that is not given has probability 0 in the Brier score of a case, and BIC has a score of its own") {
  Case one = naming(concealing(CaseFamily::pair, {"lag", "creep"}), {{"lag", 0.6}, {"slack", 0.5}});
  // (0.6 - 1)^2 + 0.5^2 + 1 for creep.
  CHECK(brier_score_of_cases({one}) == Approx(0.16 + 0.25 + 1.0).epsilon(1e-12));
  CHECK(std::isnan(brier_score_of_cases_bic({one})));
  one.reported.baselines = ReportedBaselines{.bic_names = {"creep"}, .bic_weights = {{"creep", 0.9}, {"slack", 0.4}}, .bic_after = {}};
  // 0.1^2, and 1 for lag; slack was tried and not given.
  CHECK(brier_score_of_cases_bic({one}) == Approx(0.01 + 1.0).epsilon(1e-12));
  REQUIRE(forecasts_of_bic({one}).size() == 1);
  CHECK(forecasts_of_bic({one})[0].probability == 0.9);
  CHECK(forecasts_of_bic({one})[0].came_true);
}

}  // namespace forecasts_test
