// SPDX-License-Identifier: Apache-2.0
#include "model/trained_region.h"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/predictor.h"
#include "plant/systems.h"
#include "sim/random.h"

namespace model_trained_region_test {

using namespace sinew;
using namespace sinew::model;

namespace {

Task both_duties() { return task_of(plant::default_plant().system(), 3); }

// Two duties, of 0.1 to 0.6, held for 1 to 6 s, of which only one is on at a time; y follows their difference.
Series one_at_a_time(std::uint64_t seed, Index samples) {
  const sim::RandomStream chance(seed, "duties");
  Series series{"one at a time", 0.0, Matrix<double>::Zero(2, samples), Vector<double>::Zero(samples)};
  std::uint64_t n = 0;
  for (Index k = 0; k < samples;) {
    const Index coil = chance.uniform(n++) < 0.5, held = 10 + static_cast<Index>(50.0 * chance.uniform(n++));
    const double duty = 0.1 * std::ceil(6.0 * chance.uniform(n++));
    for (Index i = 0; i < held && k < samples; ++i, ++k) series.v(coil, k) = duty;
  }
  for (Index k = 1; k < samples; ++k)
    series.y(k) = series.y(k - 1) + 0.03 * (60.0 * (series.v(0, k - 1) - series.v(1, k - 1)) - series.y(k - 1));
  return series;
}

TrainedRegion of_ten() {
  std::vector<Series> training;
  for (std::uint64_t r = 0; r < 10; ++r) training.push_back(one_at_a_time(r, 3000));
  return trained_region_of(training);
}

}  // namespace

TEST_CASE("trained region: fresh recordings of the same kind lie inside") {
  const TrainedRegion region = of_ten();
  double outside = 0.0;
  int departed = 0;
  for (std::uint64_t r = 100; r < 140; ++r) {
    const Series fresh = one_at_a_time(r, 3000);
    const double share = departures_of(region, fresh, fresh.y).share();
    outside += share / 40.0;
    departed += share > region.usual_share;
  }
  CHECK(outside < 0.03);  // of ten recordings, the most extreme one of eleven is one of them or the fresh one
  CHECK(departed <= 9);   // 40/11 are expected; more than 9 come by chance in one of 200
  CHECK(region.usual_share < 0.15);
}
TEST_CASE("trained region: a duty that training never had is outside by its range, and is named with the time") {
  const TrainedRegion region = of_ten();
  Series more = one_at_a_time(100, 600);
  more.v.row(1).segment(300, 20).setConstant(0.9);
  const Departures found = departures_of(region, more, more.y);
  CHECK(found.first == 300);
  CHECK(found.alone >= 20);
  const std::string words = words_of(found, region, both_duties(), 5.0);
  CHECK(words.find("first at 35 s") != std::string::npos);
  CHECK(words.find("duty B is 0.9, in training 0 to 0.6") != std::string::npos);
}
TEST_CASE("trained region: two duties that were on, though never together, are outside though each is in its range") {
  const TrainedRegion region = of_ten();
  Series both = one_at_a_time(100, 600);
  both.v.middleCols(300, 100).setConstant(0.45);
  both.y = one_at_a_time(100, 600).y;
  const Departures found = departures_of(region, both, both.y);
  CHECK(found.share() > 0.1);  // 100 of 599 samples
  CHECK(found.alone == 0);
  CHECK(found.first >= 300);
  CHECK(found.first < 310);
  CHECK(words_of(found, region, both_duties(), 0.0).find("duty B is 0.45, which training never had together") != std::string::npos);
}
TEST_CASE("trained region: a duty that was held longer than ever is outside by what it was over the last 30 s") {
  const TrainedRegion region = of_ten();
  Series held = one_at_a_time(100, 900);
  held.v.middleCols(300, 600).setZero();
  held.v.row(0).segment(300, 600).setConstant(0.55);
  const Departures found = departures_of(region, held, held.y);
  const std::vector<std::string> names = region_names(both_duties());
  CHECK(names[static_cast<std::size_t>(found.furthest.entry)] == "duty A over the last 30 s");
  CHECK(found.first > 310);  // a hold of six seconds is usual
  CHECK(found.share() > 0.3);
}
TEST_CASE("trained region: what lies before a rollout counts as its past") {
  const TrainedRegion region = of_ten();
  Series held = one_at_a_time(100, 900);
  held.v.middleCols(300, 600).setZero();
  held.v.row(0).segment(300, 600).setConstant(0.55);
  const Series later = part_of(held, 700, 100), before = part_of(held, 0, 701);
  CHECK(departures_of(region, later, later.y, &before).share() == 1.0);
}
TEST_CASE("trained region: comes back from a file as it was") {
  const TrainedRegion region = of_ten();
  const TrainedRegion back = trained_region_of_json(json_of(region), visited_of(region), both_duties(), "x");
  CHECK(back.lowest == region.lowest);
  CHECK(back.visited == region.visited);
  CHECK(back.reach_cells == region.reach_cells);
}

}  // namespace model_trained_region_test
