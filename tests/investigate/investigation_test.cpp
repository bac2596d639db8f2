// SPDX-License-Identifier: Apache-2.0
#include "investigate/investigation.h"

#include <doctest/doctest.h>

#include <cmath>

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
  first.asked = Asked{.probability = 0.95, .budget_s = 600.0};
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

TEST_CASE("investigation: what was told is the relative entropy: a belief that is shaken has learned, one that stays as it is has not") {
  const auto believed = [](double nothing, double body) {
    Believed one;
    one.answers = {{"nothing", "nothing", nothing}, {"body_heat_storage", "unseen", body}};
    return one;
  };
  CHECK(told_bit(believed(0.9, 0.1), believed(0.9, 0.1)) == 0.0);
  // By hand: 0.5 log2(0.5/0.9) + 0.5 log2(0.5/0.1).
  CHECK(told_bit(believed(0.9, 0.1), believed(0.5, 0.5)) == doctest::Approx(0.736966));
  CHECK(told_bit(believed(0.5, 0.5), believed(1.0, 0.0)) == doctest::Approx(1.0));
  // What was not thought of, or excluded, was believed to one in ten thousand.
  Believed other;
  other.answers = {{"dry_friction", "named", 1.0}};
  CHECK(told_bit(believed(1.0, 0.0), other) == doctest::Approx(std::log2(1e4)));
  CHECK(told_bit(believed(1.0, 0.0), believed(0.0, 1.0)) == doctest::Approx(std::log2(1e4)));
}

TEST_CASE("investigation: its state goes through JSON and back, to the byte") {
  const Investigation one = example();
  CHECK(to_json(from_json(to_json(one))).dump() == to_json(one).dump());
  CHECK(from_json(to_json(one)).ending == Ending::interrupted);
  CHECK(from_json(to_json(one)).steps[0].asked == Asked{.probability = 0.95, .budget_s = 600.0});
  CHECK_FALSE(from_json(to_json(one)).steps[1].asked);
}

TEST_CASE("investigation: an experiment that told nothing counts as one, unless it was cut short or less was asked for then") {
  const Asked less{.budget_s = 600.0}, more{.budget_s = 900.0};
  Investigation one = example();
  one.ending.reset();
  Step told_nothing = one.steps[1];
  told_nothing.status = "finished";
  told_nothing.after = one.steps[0].after;
  told_nothing.asked = less;
  one.steps[0].asked = less;
  one.steps[1] = told_nothing;
  CHECK(idle(one, less) == 1);
  one.steps.push_back(told_nothing);
  CHECK(idle(one, less) == 2);
  // It is gone on with: both were planned before that.
  CHECK(idle(one, more) == 0);
  one.steps[2].asked = more;
  CHECK(idle(one, more) == 1);
  // Twice a trip: no experiment was made.
  one.steps[1].status = one.steps[2].status = "tripped";
  one.steps[2].asked = less;
  CHECK(idle(one, less) == 0);
  // One that told something ends the count.
  one.steps[2].status = "finished";
  one.steps[2].after->answers = {{"cross_heating", "named", 1.0}};
  CHECK(idle(one, less) == 0);
}

TEST_CASE("investigation: recordings that were given do not count as the limb's time") {
  Investigation one = example();
  CHECK(one.spent_s() == 90.0);
  one.steps[0].origin = "given";
  CHECK(one.spent_s() == 30.0);
}

// Records nothing but rows at rest, and notes what it is asked for.
class Counting : public Limb {
 public:
  explicit Counting(int until) : until_(until) {}
  Recorded record(const sim::Scenario& scenario, const std::string& name) override {
    asked.emplace_back(name, scenario.duration_s);
    seeds.push_back(scenario.seed);
    Recorded recorded;
    recorded.recording.columns = sim::columns_of(scenario.plant.system());
    for (int k = 0; k <= 10 * static_cast<int>(scenario.duration_s); ++k)
      recorded.recording.samples.push_back({0.1 * k, {0.0, 0.0}, {25.0, 25.0, 0.0}});
    if (static_cast<int>(asked.size()) >= until_) recorded.status = hil::SessionStatus::stopped;
    return recorded;
  }
  sim::Recording read(const std::string&) override { return {}; }
  std::vector<std::pair<std::string, double>> asked;
  std::vector<std::int64_t> seeds;

 private:
  int until_;
};

TEST_CASE("investigation: babbling for comparison fills the budget with recordings of their own seeds, without a look in between") {
  Settings settings;
  settings.use = Use::babbling;
  settings.asked.budget_s = 760.0;
  settings.seed = 9;
  Counting limb(3);  // a person stops the last one, so that no diagnosis is made
  Investigation state;
  investigate::investigate(state, plant::default_plant(), settings, limb, {}, false);
  // By hand: 120 s, and of the 640 s that are left 300 s, 300 s; 40 s are too short for one.
  const std::vector<std::pair<std::string, double>> due{{"recording_01", 120.0}, {"recording_02", 300.0}, {"recording_03", 300.0}};
  REQUIRE(state.steps.size() == due.size());
  for (std::size_t k = 0; k < due.size(); ++k) CHECK(state.steps[k].plan->duration_s == due[k].second);

  // The second one stopped: what is planned and recorded is kept, and goes through a file.
  Counting stopped(2);
  Investigation half;
  investigate::investigate(half, plant::default_plant(), settings, stopped, {}, false);
  CHECK(half.ending == Ending::stopped);
  CHECK(stopped.asked == std::vector<std::pair<std::string, double>>(due.begin(), due.begin() + 2));
  CHECK(stopped.seeds == std::vector<std::int64_t>{9, 10});
  Investigation read = from_json(to_json(half));
  REQUIRE(read.next() != nullptr);
  CHECK(read.next()->name == "recording_03");
}

TEST_CASE("investigation: every use of the limb's time has a name that is read again") {
  for (const Use use : {Use::designed, Use::babbling, Use::random, Use::once}) CHECK(use_of(text_of(use)) == use);
  CHECK_FALSE(use_of("twice"));
}

TEST_CASE("belief: half and two quarters leave one bit and a half open") {
  Belief belief;
  belief.all = {{Kind::named, {}, "a", 0.5}, {Kind::named, {}, "b", 0.25}, {Kind::something_else, {}, "c", 0.25}};
  CHECK(belief.entropy_bit() == doctest::Approx(1.5));
}

TEST_CASE("story: parts that are not alike are said beside a name, in words") {
  Investigation one = example();
  one.steps[0].after->answers[0].key = "latent_heat+coils unlike in the transformation temperatures";
  const std::string text = to_text(story_of(one, plant::default_plant().system()));
  CHECK_MESSAGE(text.find("(latent_heat), and its coils are not alike in the transformation temperatures.") != std::string::npos, text);
}

TEST_CASE("story: says what was asked, what came back, and how to go on") {
  const std::string text = to_text(story_of(example(), plant::default_plant().system()));
  for (const char* part : {"latent_heat 50 %", "is it latent_heat, or cross_heating?", "tripped", "Give the same command again", "fatigue"})
    CHECK_MESSAGE(text.find(part) != std::string::npos, part, " in:\n", text);
}

}  // namespace
