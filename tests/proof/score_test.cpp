// SPDX-License-Identifier: Apache-2.0
// Figures, tables and files of a score, of cases made by hand.
#include "proof/score.h"

#include <doctest/doctest.h>

#include <cmath>

#include "proof/judged.h"
#include "proof/score_files.h"
#include "tests/proof/cases_for_tests.h"

namespace score_test {

using namespace sinew::proof;
using doctest::Approx;
using proof_for_tests::concealing;
using proof_for_tests::naming;

namespace {

Figure figure(const std::vector<Case>& cases, const std::string& what) {
  for (const Figure& one : figures_of(cases))
    if (one.what == what) return one;
  FAIL("no figure " << what);
  return {};
}
void check_share(const Figure& one, int good, int all) {
  CHECK(std::get<Share>(one.measured).good == good);
  CHECK(std::get<Share>(one.measured).all == all);
}
Case with_errors(Case one, double before, double after, double oracle) {
  one.reported.held_out = {.before = before, .after = after, .refit = {}, .oracle = oracle};
  return one;
}

}  // namespace

TEST_CASE("score: of no case, every figure is not measured, and files are written all the same") {
  const Score score = score_of({});
  for (const Figure& one : score.figures) {
    INFO(one.what);
    CHECK(one.of() == 0);
    CHECK_FALSE(one.reached());
  }
  CHECK(score_json(score)["figures"].size() == score.figures.size());
  CHECK(score_markdown(score, "x").find("| three effects: all named | not measured | | at least 60 % | – |") != std::string::npos);
  CHECK(reliability_svg(score).starts_with("<svg"));
  CHECK(confusion_svg(score).ends_with("</svg>\n"));
}

TEST_CASE("score: of triples, all three and at least two are counted, in any order and whatever else is named") {
  const Case three = concealing(CaseFamily::triple, {"lag", "creep", "slack"});
  const std::vector<Case> cases{naming(three, {{"slack", 0.9}, {"other", 0.9}, {"lag", 0.8}, {"creep", 0.7}}),
                                naming(three, {{"creep", 0.9}, {"lag", 0.9}}), naming(three, {{"other", 0.9}, {"lag", 0.9}})};
  check_share(figure(cases, "three effects: all named"), 1, 3);
  check_share(figure(cases, "three effects: two or all named"), 2, 3);
  CHECK(score_of(cases).misses.size() == 2);
  CHECK(score_of(cases).misses[0].why == "found 2 of 3, first creep");
}

TEST_CASE("score: a wrong name counts with 0.5 or more, and with 0.9 or more, also where it is not the first") {
  const Case lag = concealing(CaseFamily::catalogue, {"lag"});
  const std::vector<Case> cases{naming(lag, {{"lag", 0.95}}), naming(lag, {{"lag", 0.95}, {"creep", 0.5}}), naming(lag, {{"creep", 0.9}}),
                                naming(lag, {{"creep", 0.49}}), naming(concealing(CaseFamily::removed, {"lag"}), {{"lag", 0.6}})};
  check_share(figure(cases, "all cases: a wrong name with 0.5 or more"), 3, 5);
  check_share(figure(cases, "all cases: a wrong name with 0.9 or more"), 1, 5);
  const Score score = score_of(cases);
  CHECK(score.by_family.at(CaseFamily::catalogue).right_first == 2);
  CHECK(score.by_family.at(CaseFamily::catalogue).wrong_first == 2);
  CHECK(score.by_family.at(CaseFamily::catalogue).wrong_confident == 2);
  CHECK(score.by_family.at(CaseFamily::removed).wrong_confident == 1);
}

TEST_CASE("score: of what has no name, the equation that is said first counts, not one that is said to be alike") {
  Case right = naming(concealing(CaseFamily::outside, {"bow"}), {}), alike = right;
  right.reported.place = "thermal";
  alike.reported.places_alike = {"thermal"};
  check_share(figure({right, alike}, "outside or taken out of the catalogue: right equation first"), 1, 2);
  check_share(figure({right, alike}, "equation right, or among those said to be alike"), 2, 2);
}

TEST_CASE("score: coils that are not alike must be said to be so, and the name beside them") {
  Case differ = concealing(CaseFamily::unlike, {"unlike", "lag"});
  differ.truth.effects[0].form = "heating_width_K";
  Case said = naming(differ, {{"lag", 0.9}}), of_another = said, misnamed = naming(differ, {{"lag", 0.9}, {"creep", 0.6}});
  said.reported.apart = misnamed.reported.apart = {{"heating_width_K", 0.9}};
  of_another.reported.apart = {{"heating_midpoint_degC", 0.9}};
  Case unnamed = naming(differ, {}), alike = naming(concealing(CaseFamily::catalogue, {"lag"}), {{"lag", 0.9}}), wrongly = alike;
  unnamed.reported.apart = wrongly.reported.apart = {{"heating_width_K", 0.6}};
  CHECK(miss_of(said) == "");
  CHECK(miss_of(of_another) == "not said that parts differ in heating_width_K: lag (0.90)");
  CHECK(miss_of(misnamed) == "confidently misnamed creep (0.60)");
  CHECK(miss_of(unnamed) == "not named lag");
  const Score score = score_of({said, of_another, misnamed, unnamed, alike, wrongly});
  CHECK(score.said_unlike.good == 3);
  CHECK(score.said_unlike.all == 4);
  CHECK(score.wrongly_said_unlike.good == 1);
  CHECK(score.wrongly_said_unlike.all == 2);
  const std::string text = score_markdown(score, "x");
  CHECK(text.find("in which parts differ the answer said so in 3 of 4.") != std::string::npos);
  CHECK(text.find("Parts that are alike were said to differ in 1 of 2.") != std::string::npos);
  // It has a probability as a name has, and counts as one.
  CHECK(miss_of(wrongly) == "confidently misnamed parts that differ in heating_width_K (0.60)");
  check_share(figure({said, wrongly}, "all cases: a wrong name with 0.5 or more"), 1, 2);
  CHECK(score.reliability.front().forecasts == 11);
}

TEST_CASE("score: what shows nothing, and was answered so, is no case of the figures of names") {
  Case hidden = naming(concealing(CaseFamily::removed, {"lag"}), {});
  hidden.reported.visibility = 4.9;
  hidden.reported.verdict = Verdict::consistent;
  CHECK(is_rightly_unseen(hidden));
  CHECK(figure({hidden}, "outside or taken out of the catalogue: right equation first").of() == 0);
  CHECK(score_of({hidden}).invisible == 1);
  hidden.reported.visibility = 5.0;
  CHECK_FALSE(is_rightly_unseen(hidden));
  hidden.reported.cannot_be_seen = {"lag"};
  CHECK(is_rightly_unseen(hidden));
}

TEST_CASE("score: share of the oracle's reduction of the held-out error, its median by family") {
  const Case outside = naming(concealing(CaseFamily::outside, {"bow"}), {});
  // Before 10, the oracle 2: after 6 half of that is reached, after 4 three quarters, after 12 less than nothing.
  const std::vector<Case> cases{with_errors(outside, 10.0, 6.0, 2.0), with_errors(outside, 10.0, 4.0, 2.0),
                                with_errors(outside, 10.0, 12.0, 2.0), with_errors(outside, 10.0, 5.0, 11.0)};
  const Figure share = figure(cases, "outside the catalogue: held-out error, median share of the oracle's reduction");
  CHECK(share.of() == 3);
  CHECK(share.value() == Approx(0.5).epsilon(1e-12));
  check_share(figure(cases, "outside or taken out of the catalogue: held-out error worse than before"), 1, 4);
  CHECK(figure(cases, "taken out of the catalogue: held-out error, median share of the oracle's reduction").of() == 0);
}

TEST_CASE("score: a repaired plant that cannot follow the held-out recording is worse than any, and the median stays a number") {
  const Case outside = naming(concealing(CaseFamily::outside, {"bow"}), {});
  const double lost = std::nan("");
  CHECK(*share_of_reduction(10.0, lost, 2.0) == -HUGE_VAL);
  CHECK(figure({with_errors(outside, 10.0, lost, 2.0), with_errors(outside, 10.0, 4.0, 2.0), with_errors(outside, 10.0, 6.0, 2.0)},
               "outside the catalogue: held-out error, median share of the oracle's reduction")
            .value() == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("score: strength and interval are compared where the catalogue's own effect is named, not what was known") {
  Case one = naming(concealing(CaseFamily::catalogue, {"lag"}), {{"lag", 0.9}});
  one.truth.effects[0].parameters = {{"time_s", 2.0}, {"share", 0.5}};
  one.reported.effects[0].strength = "time_s";
  one.reported.effects[0].parameters = {{"time_s", {2.5, 2.1, 2.9, false}}, {"share", {0.5, 0.5, 0.5, true}}};
  CHECK(figure({one}, "strength: median relative error").value() == Approx(0.25).epsilon(1e-12));
  check_share(figure({one}, "95 % intervals that cover the truth"), 0, 1);
  one.truth.family = CaseFamily::other_form;
  CHECK(figure({one}, "strength: median relative error").of() == 0);
}

TEST_CASE("score: Sinew's Brier score is put beside BIC's on the cases that have its weights alone") {
  Case with = naming(concealing(CaseFamily::catalogue, {"lag"}), {{"lag", 0.9}}), without = naming(with, {});
  with.reported.baselines = ReportedBaselines{.bic_names = {"creep"}, .bic_weights = {{"creep", 1.0}}, .bic_after = {}};
  const Figure brier = figure({with, without}, "Brier score of a case, where BIC weights are there");
  CHECK(brier.of() == 1);
  CHECK(brier.value() == Approx(0.01).epsilon(1e-9));
  CHECK(brier.reached());
  CHECK(brier.goal.words == "less than 2.00, that of BIC weights");
  REQUIRE(score_of({with, without}).reliability.size() == 3);
  CHECK(score_of({with, without}).reliability[2].brier == 1.0);
  CHECK(score_of({with, without}).methods.back().by_method.at("BIC") == 2.0);
}

TEST_CASE("score: a case that failed is counted as such, and breaks nothing") {
  Case failed = naming(concealing(CaseFamily::pair, {"lag", "creep"}), {});
  failed.reported.verdict = Verdict::failed;
  failed.reported.why_failed = "gave up";
  const Score score = score_of({failed});
  CHECK(score.by_family.at(CaseFamily::pair).failed == 1);
  CHECK(score.misses[0].reason == "gave up");
}

}  // namespace score_test
