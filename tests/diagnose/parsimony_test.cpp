// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <utility>

#include "diagnose/confidence.h"
#include "diagnose/diagnosis.h"
#include "tests/diagnose/one_limb.h"

namespace diagnose_parsimony_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

using testing::effect;

// A search whose first round fitted these effects alone, each taking away a share of the core's misfit.
Search searched(const std::vector<std::pair<const char*, double>>& shares_alone) {
  Search search;
  search.core.problem = std::make_shared<FitProblem>(plant::default_plant(), std::vector<plant::ParameterId>{}, std::vector<FitData>{},
                                                     StartPolicy::at_rest, plant::NumericalSettings{});
  search.core.misfit = 1e6;
  search.rounds.emplace_back();
  for (const auto& [name, share] : shares_alone) {
    Candidate candidate{effect(name), {}, {}};
    candidate.explanation.usable = true;
    candidate.explanation.misfit = (1.0 - share) * search.core.misfit;
    search.rounds.back().candidates.push_back(candidate);
  }
  return search;
}

}  // namespace

TEST_CASE("parsimony: one effect that leaves nothing stands, however much its twin explains") {
  const Search search = searched({{"body_heat_storage", 1.0}, {"ambient_drift", 0.99}});
  CHECK(parsimony_of({effect("body_heat_storage")}, search, false, {}).none());
}

TEST_CASE("parsimony: where something is left, what explains nearly all alone is as good") {
  const Search search = searched({{"thermocouple_lag", 0.98}, {"input_delay", 0.94}, {"angle_sensor_lag", 0.8}});
  CHECK(parsimony_of({effect("thermocouple_lag")}, search, true, {}).as_good == std::vector<plant::EffectId>{effect("input_delay")});
}

TEST_CASE("parsimony: another form of what was found is no rival of it") {
  CHECK(parsimony_of({effect("driver_lag")}, searched({{"driver_lag", 0.97}, {"input_delay", 0.95}}), true, {}).as_good.empty());
  CHECK(parsimony_of({effect("driver_lag")}, searched({{"driver_lag", 0.97}, {"thermocouple_lag", 0.95}}), true, {}).as_good ==
        std::vector<plant::EffectId>{effect("thermocouple_lag")});
}

TEST_CASE("parsimony: two effects that leave nothing stand") {
  const std::vector<plant::EffectId> both{effect("cubic_stiffening"), effect("hard_stop")};
  CHECK(parsimony_of(both, searched({{"cubic_stiffening", 0.95}, {"hard_stop", 0.3}}), false, {}).none());
}

TEST_CASE("parsimony: both kinds of sensor late may be one cause before both") {
  const Search search = searched({{"thermocouple_lag", 0.87}, {"input_delay", 0.81}, {"junction", 0.8}, {"latent_heat", 0.5}});
  const auto delay = std::vector<plant::EffectId>{effect("input_delay")};
  CHECK(parsimony_of({effect("thermocouple_lag"), effect("angle_sensor_lag")}, search, false, {}).common_causes == delay);
  CHECK(parsimony_of({effect("thermocouple_lag"), effect("viscoelastic_creep")}, search, false, {}).none());
}

TEST_CASE("parsimony: a second sensor's effect counts although the answer does without it") {
  Search search = searched({{"thermocouple_lag", 0.96}, {"input_delay", 0.8}});
  CHECK(parsimony_of({effect("thermocouple_lag")}, search, true, {}).none());
  search.rounds.front().accepted = true;
  Round second;
  second.accepted = true;
  second.candidates.push_back({effect("angle_sensor_lag"), {}, {}});
  search.rounds.push_back(second);
  CHECK(parsimony_of({effect("thermocouple_lag")}, search, true, {}).common_causes == std::vector<plant::EffectId>{effect("input_delay")});
}

TEST_CASE("answer: a name that was taken out after it was accepted is no part of it, where something is left") {
  Search search = searched({{"angle_sensor_drift", 0.8}});
  const auto with = [&](const std::vector<const char*>& names, double share) {
    plant::Plant plant = plant::default_plant();
    for (const char* name : names) plant = with_effect(plant, effect(name));
    Explanation one;
    one.problem = std::make_shared<FitProblem>(plant, std::vector<plant::ParameterId>{}, std::vector<FitData>{}, StartPolicy::at_rest,
                                               plant::NumericalSettings{});
    one.usable = true;
    one.misfit = (1.0 - share) * search.core.misfit;
    one.process_noise = 0.01 * search.core.misfit;
    return one;
  };
  search.core.process_noise = search.core.misfit;
  search.rounds[0].accepted = true;
  search.rounds[0].before = search.core;
  search.rounds[0].candidates[0].explanation = with({"angle_sensor_drift"}, 0.8);
  search.rounds.emplace_back();
  search.rounds[1].accepted = true;
  search.rounds[1].before = search.rounds[0].candidates[0].explanation;
  search.rounds[1].candidates.push_back({effect("viscoelastic_creep"), {}, with({"angle_sensor_drift", "viscoelastic_creep"}, 0.99)});
  const auto answer = [&] { return chosen(search, {}, {}).effects(); };
  search.best = search.rounds[1].candidates[0].explanation;
  CHECK(answer() == search.best.effects());
  search.best = with({"viscoelastic_creep"}, 0.985);  // drift was found to add nothing
  CHECK(answer() == std::vector<plant::EffectId>{effect("viscoelastic_creep")});
  // The first accepted round that explains enough stands, as long as its names do.
  search.rounds[0].candidates[0].explanation = with({"angle_sensor_drift"}, 0.95);
  CHECK(answer() == std::vector<plant::EffectId>{effect("viscoelastic_creep")});
  search.best = search.rounds[1].candidates[0].explanation;
  CHECK(answer() == std::vector<plant::EffectId>{effect("angle_sensor_drift")});
}

TEST_CASE("probability: a name is likelier the more it gains, and less so the fainter it is, or beside a law") {
  const auto of = [](double gain, double faint) { return probability({.share = 1.0, .gain = gain, .faint = faint}); };
  CHECK(of(300.0, 0.0) > of(30.0, 0.0));
  CHECK(of(300.0, 1.0) < of(300.0, 0.5));
  // Beyond what the concealed cases had, it no longer changes.
  CHECK(of(1e5, 0.0) == of(1e4, 0.0));
  CHECK(of(300.0, 3.0) == of(300.0, 2.0));
  CHECK(probability({.share = 0.25, .gain = 300.0, .faint = 0.0}) == doctest::Approx(0.25 * of(300.0, 0.0)).epsilon(1e-14));
  CHECK(probability({.share = 1.0, .gain = 300.0, .law_beside = true}) < of(300.0, 0.0));
  // Two deviations off are no matter; at 3.7 the odds are even that it stands in for what was not tried.
  const auto off_by = [&](double deviations) {
    return probability({.share = 1.0, .gain = 300.0, .unbelieved = deviations * deviations}) / of(300.0, 0.0);
  };
  CHECK(off_by(2.0) == doctest::Approx(1.0).epsilon(0.01));
  CHECK(off_by(std::sqrt(2.0 * std::log(1000.0))) == doctest::Approx(0.5).epsilon(2e-3));
  CHECK(off_by(5.0) < 0.01);
  CHECK(off_by(1e9) >= 0.0);
}

TEST_CASE("probability: a law is likelier a name's form the less the name's own formula leaves") {
  const auto one = [](double left) { return probabilities_of_forms({left}).front(); };
  CHECK(one(0.02) == doctest::Approx(0.88).epsilon(0.005));  // as docs/diagnosis.md says
  CHECK(one(1.0) == doctest::Approx(0.13).epsilon(0.04));
  CHECK(one(0.01) > one(0.1));
  // Where the two are as likely: of one density in log space over three decades, and one in linear space.
  CHECK(one(1.0 / std::log(1000.0)) == doctest::Approx(0.5).epsilon(1e-14));
  // Nearer than a thousandth says no more, nor can a formula leave more than there was.
  CHECK(one(1e-6) == one(1e-3));
  CHECK(one(1.4) == one(1.0));
  // Two names share what one would have; what is left of it is no name.
  const std::vector<double> two = probabilities_of_forms({0.02, 0.02}), unlike = probabilities_of_forms({0.02, 1.0});
  CHECK(two[0] == two[1]);
  CHECK(two[0] + two[1] == doctest::Approx(one(0.02)).epsilon(1e-14));
  CHECK(unlike[0] == doctest::Approx(50.0 * unlike[1]).epsilon(1e-12));
  CHECK(unlike[0] + unlike[1] < 1.0);
  CHECK(probabilities_of_forms({}).empty());
}

}  // namespace diagnose_parsimony_test
