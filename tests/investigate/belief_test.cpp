// SPDX-License-Identifier: Apache-2.0
#include "investigate/belief.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "investigate/usual_strength.h"
#include "plant/contains.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace investigate_belief_test {

using namespace sinew;
using namespace sinew::investigate;

namespace {

sim::Scenario noisy_babbling(const plant::Plant& plant) {
  sim::Scenario scenario = testing::babbling(60.0, plant);
  scenario.sensors = sim::usual_sensors(plant.system());
  return scenario;
}

const Hypothesis* find(const Belief& belief, std::string_view key) {
  const auto there = std::ranges::find(belief.all, key, &Hypothesis::key);
  return there == belief.all.end() ? nullptr : &*there;
}

}  // namespace

TEST_CASE("usual strength: a body that is there fits at least as well as none, though to first order it is far off; a lag does not") {
  const plant::EffectId body = testing::effect("body_heat_storage"), lag = testing::effect("thermocouple_lag");
  plant::Plant with_body = diagnose::with_effect(plant::default_plant(), body);
  const plant::ParameterId strength = testing::limb_system().effects()[body].strength;
  with_body.set_in_file_units(strength, testing::limb_system().parameters()[strength].declaration.typical);
  const testing::FittedCore core(noisy_babbling(with_body));
  REQUIRE(core.core.usable);
  diagnose::SearchSettings settings;
  settings.fit = core.settings;
  const auto fits = at_usual_strength(core.core, {body, lag}, settings).with;
  REQUIRE(fits.size() == 2);
  REQUIRE(fits[0]);
  REQUIRE(fits[1]);
  CHECK(fits[0]->log_posterior > core.core.log_posterior);
  CHECK(fits[1]->log_posterior < core.core.log_posterior - 100.0);
  // What is asked is the usual strength, not whatever fits.
  CHECK(fits[0]->model().get(strength) == with_body.get(strength));
  CHECK_FALSE(contains(fits[0]->problem->parameters(), strength));
  // To first order it is hardly there, and at its usual strength would be far from where the core is.
  const diagnose::Score score = diagnose::score(core.core, {body}, 1).all.front();
  const double root = 5.0 * with_body.get(strength) / score.smallest_seen;
  CHECK(root * score.root - 0.5 * root * root < -100.0);
}

TEST_CASE("usual strength: of a strength that may have either sign, the likelier one: a room that cools is not taken for one that warms") {
  const plant::EffectId drift = testing::effect("ambient_drift");
  const plant::ParameterId rate = testing::limb_system().effects()[drift].strength;
  plant::Plant cooling = diagnose::with_effect(plant::default_plant(), drift);
  cooling.set_in_file_units(rate, -testing::limb_system().parameters()[rate].declaration.typical);
  const testing::FittedCore core(noisy_babbling(cooling));
  REQUIRE(core.core.usable);
  diagnose::SearchSettings settings;
  settings.fit = core.settings;
  const auto fits = at_usual_strength(core.core, {drift}, settings).with;
  REQUIRE(fits[0]);
  CHECK(fits[0]->model().get(rate) == cooling.get(rate));
}

TEST_CASE("belief: where nothing is missing it is that, or what this recording could not have shown" * long_when_sanitized) {
  plant::Plant limb = plant::default_plant();
  limb.set(testing::parameter("heat_loss_A_W_K"), 0.043);
  const sim::Recording recording = testing::recorded(noisy_babbling(limb));
  diagnose::DiagnosisSettings settings;
  settings.start = diagnose::StartPolicy::at_rest;
  const diagnose::Diagnosis diagnosis = diagnose::diagnose(plant::default_plant(), {recording}, {}, settings);
  REQUIRE(verdict_of(diagnosis.answer) == diagnose::Verdict::consistent);
  const Belief belief = belief_of(diagnosis, settings);
  double sum = 0.0;
  for (const Hypothesis& one : belief.all) sum += one.probability;
  CHECK(sum == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(belief.first().key == "nothing");
  REQUIRE(find(belief, "thermocouple_lag"));
  CHECK(find(belief, "thermocouple_lag")->probability < 1e-6);
  REQUIRE(find(belief, "coil_slack"));
  CHECK(Belief::may_yet_show(*find(belief, "coil_slack")));
  // Two names are right together where each is.
  diagnose::Found two;
  for (const auto& [name, confidence] : {std::pair{"dry_friction", 0.9}, {"latent_heat", 0.8}}) {
    two.effects.emplace_back();
    two.effects.back().effect = testing::effect(name);
    two.effects.back().confidence = confidence;
  }
  diagnose::Diagnosis named = diagnosis;
  named.answer = two;
  const Belief of_two = belief_of(named, settings);
  REQUIRE(of_two.first().kind == Kind::named);
  CHECK(of_two.first().effects.size() == 2);
  CHECK(of_two.first().probability == doctest::Approx(0.72).epsilon(1e-9));
}

}  // namespace investigate_belief_test
