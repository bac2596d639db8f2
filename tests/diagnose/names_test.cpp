// SPDX-License-Identifier: Apache-2.0
#include "diagnose/names.h"

#include <doctest/doctest.h>

#include "tests/diagnose/one_limb.h"

namespace diagnose_names_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

using testing::effect;

// A law of the duties in the wires' heat: what a dead band would be.
FoundLaw law_of_duty() {
  FoundLaw found;
  found.law.entry = testing::group("heat");
  found.law.argument = {testing::variable("duty A"), testing::variable("duty B")};
  return found;
}

FoundEffect name(std::string_view of, double probability) {
  FoundEffect found;
  found.effect = effect(of);
  found.confidence = probability;
  return found;
}

// A search in which formulas were fitted in the first round, by the share of the misfit that each leaves.
Search searched(const std::vector<std::pair<std::string_view, double>>& fitted) {
  Search search;
  search.core.misfit = 1000.0;
  search.core.problem = std::make_shared<FitProblem>(plant::default_plant(), std::vector<plant::ParameterId>{}, std::vector<FitData>{},
                                                     StartPolicy::at_rest, plant::NumericalSettings{});
  Round round;
  round.before = search.core;
  for (const auto& [of, left] : fitted) {
    Candidate candidate{effect(of), {}, {}};
    candidate.explanation.usable = true;
    candidate.explanation.misfit = left * search.core.misfit;
    round.candidates.push_back(candidate);
  }
  search.rounds.push_back(round);
  return search;
}

double probability_of_dead_band(const Search& search, const Proposals* proposals = nullptr) {
  const plant::Plant given = plant::default_plant();
  const std::vector<plant::EffectId> none;
  const std::vector<FoundLaw> laws{law_of_duty()};
  const Naming naming{
      .given = given, .search = search, .without = none, .names = none, .laws = laws, .explained_share = 1.0, .proposals = proposals};
  for (const auto& [of, probability] : naming.names_for(laws.front().law))
    if (of == effect("duty_deadband")) return probability;
  return 0.0;
}

// In open-loop simulation: how far off plants are, by the effects that were added.
double probability_of_dead_band(const std::vector<std::pair<std::vector<plant::EffectId>, double>>& errors) {
  Proposals proposals;
  for (const auto& [effects, error] : errors) {
    Proposal& one = proposals.all.emplace_back();
    one.effects = effects;
    one.error = error;
  }
  return probability_of_dead_band(searched({}), &proposals);
}

}  // namespace

TEST_CASE("names: a law is beside a name, or its form") {
  const plant::System& system = testing::limb_system();
  const std::vector<FoundLaw> laws{law_of_duty()};
  CHECK(has_law_as_form(system, laws, effect("duty_deadband")));
  CHECK_FALSE(has_law_as_form(system, laws, effect("hard_stop")));
  CHECK_FALSE(has_law_beside(system, laws, {effect("hard_stop"), effect("duty_deadband")}));
  CHECK(has_law_beside(system, laws, {effect("hard_stop")}));
}

TEST_CASE("names: what a law may be the form of is said where it is likelier than not, what is fitted always") {
  const plant::System& system = testing::limb_system();
  const std::vector<FoundLaw> laws{law_of_duty()};
  const std::vector<FoundEffect> found{name("duty_deadband", 0.4), name("hard_stop", 0.4)};
  CHECK(names_said(system, found, laws) == std::vector<plant::EffectId>{effect("hard_stop")});
  CHECK(names_said(system, {name("duty_deadband", 0.6)}, laws) == std::vector<plant::EffectId>{effect("duty_deadband")});
  CHECK(names_said(system, {name("duty_deadband", 0.4)}, {}).size() == 1);
}

TEST_CASE("names: a law is likelier a name's form the less the name's own formula leaves") {
  const double near = probability_of_dead_band(searched({{"duty_deadband", 0.02}})),
               far = probability_of_dead_band(searched({{"duty_deadband", 0.9}}));
  CHECK(near > 2.0 * far);
  CHECK(near < 1.0);
  CHECK(far > 0.0);
}

TEST_CASE("names: in open-loop simulation, what a formula leaves is the square of how far off the plants are with it and without") {
  const double near = probability_of_dead_band(searched({{"duty_deadband", 0.04}})),
               far = probability_of_dead_band(searched({{"duty_deadband", 0.81}}));
  const plant::EffectId stop = effect("hard_stop"), dead_band = effect("duty_deadband");
  CHECK(probability_of_dead_band({{{stop}, 0.1}, {{dead_band, stop}, 0.02}}) == doctest::Approx(near));
  CHECK(probability_of_dead_band({{{stop}, 0.1}, {{dead_band, stop}, 0.09}}) == doctest::Approx(far));
  // A plant that has another effect, too, tells nothing of this one.
  CHECK(probability_of_dead_band({{{}, 0.1}, {{dead_band, stop}, 0.01}}) == doctest::Approx(probability_of_dead_band(searched({}))));
}

}  // namespace diagnose_names_test
