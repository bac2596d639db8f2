#include "diagnose/chance.h"

#include <doctest/doctest.h>

#include "tests/diagnose/one_limb.h"

using namespace sinew;
using diagnose::Explanation;
using diagnose::UnrestByChance;

TEST_CASE("chance: what is drawn from a plant has the unrest of one from which nothing is missing") {
  sim::Scenario scenario = testing::babbling(40.0);
  scenario.sensors = {};  // the paper's
  const sim::Recording recording = testing::recorded(scenario);
  const std::vector<diagnose::FitData> data{{&recording, recording.samples.size(), testing::paper_noise}};
  diagnose::ExplanationSettings settings;
  settings.start = diagnose::StartPolicy::at_rest;
  Explanation found = diagnose::explain({}, data, {}, settings);
  REQUIRE(found.usable);
  CHECK(found.unrest < 50.0);

  SUBCASE("much unrest never comes by chance, whatever the number of threads") {
    found.unrest = 1e4;
    const UnrestByChance by_one = diagnose::unrest_by_chance(found, data, 1, 7, settings);
    CHECK(by_one.drawn == 99);
    CHECK(by_one.as_large == 0);
    CHECK(by_one.probability() == 0.01);
    CHECK(by_one.largest > 0.0);
    CHECK(by_one.largest < 250.0);
    CHECK(diagnose::unrest_by_chance(found, data, 2, 7, settings).largest == by_one.largest);
    CHECK(diagnose::unrest_by_chance(found, data, 2, 8, settings).largest != by_one.largest);
  }
  SUBCASE("as much as any has comes with the first draws, and no more are made") {
    found.unrest = -1e9;
    const UnrestByChance any = diagnose::unrest_by_chance(found, data, 2, 7, settings);
    CHECK(any.drawn == 4);
    CHECK(any.as_large == 4);
    CHECK(any.probability() == 1.0);
  }
}
