// SPDX-License-Identifier: Apache-2.0
#include "investigate/investigation.h"

#include <doctest/doctest.h>

#include "investigate/story.h"
#include "plant/systems.h"

namespace {

using namespace sinew;
using namespace sinew::investigate;

Investigation example() {
  Investigation one;
  Step first, second;
  first.name = "recording_01";
  first.origin = "babbling";
  first.status = "finished";
  first.duration_s = 60.0;
  first.highest_degC = 88.5;
  Believed believed;
  believed.answers = {{"latent_heat", "named", 0.5}, {"cross_heating", "named", 0.25}, {"something else", "something_else", 0.25}};
  believed.verdict = "missing_physics";
  believed.unseen = {"fatigue"};
  believed.entropy_bit = 1.5;
  believed.values = {{"latent_heat.latent_heat_J", 4.2}};
  first.after = believed;
  second.name = "recording_02";
  second.origin = "experiment";
  Plan plan;
  plan.words = "pulses";
  plan.family = "pulses_in_turn";
  plan.apart = "latent_heat";
  plan.from = "cross_heating";
  plan.duration_s = 90.0;
  plan.cool_s = 20.0;
  plan.expected_bit = 0.8;
  plan.separation = 6.5;
  plan.highest_degC = 97.0;
  plan.tried = 48;
  plan.scenario_yaml = "format: 1\n";
  second.plan = plan;
  second.status = "tripped";
  second.why = "the device tripped: sensor open";
  second.duration_s = 30.0;
  one.steps = {first, second};
  one.ending = Ending::interrupted;
  one.ending_words = "During recording_02: the device tripped.";
  return one;
}

TEST_CASE("investigation: its state goes through JSON and back, to the byte") {
  const Investigation one = example();
  CHECK(to_json(from_json(to_json(one))).dump() == to_json(one).dump());
  CHECK(from_json(to_json(one)).ending == Ending::interrupted);
}

TEST_CASE("investigation: recordings that were given do not count as the limb's time") {
  Investigation one = example();
  CHECK(one.spent_s() == 90.0);
  one.steps[0].origin = "given";
  CHECK(one.spent_s() == 30.0);
}

TEST_CASE("belief: half and two quarters leave one bit and a half open") {
  Belief belief;
  belief.all = {{Kind::named, {}, "a", 0.5}, {Kind::named, {}, "b", 0.25}, {Kind::something_else, {}, "c", 0.25}};
  CHECK(belief.entropy_bit() == doctest::Approx(1.5));
}

TEST_CASE("story: says what was asked, what came back, and how to go on") {
  const std::string text = to_text(story_of(example(), plant::default_plant().system()));
  for (const char* part : {"latent_heat 50 %", "is it latent_heat, or cross_heating?", "tripped", "Give the same command again", "fatigue"})
    CHECK_MESSAGE(text.find(part) != std::string::npos, part, " in:\n", text);
}

}  // namespace
