// SPDX-License-Identifier: Apache-2.0
#include "diagnose/decide.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/diagnose/one_limb.h"

namespace diagnose_decide_test {

using namespace sinew;
using namespace sinew::diagnose;

const plant::System& limb = testing::limb_system();

FoundEffect some_effect() {
  FoundEffect effect;
  effect.effect = testing::effect("supply_sag");
  effect.confidence = 0.9;
  return effect;
}
Found with_name() {
  Found found;
  found.effects.push_back(some_effect());
  return found;
}
Found with_parts_that_differ() {
  Found found;
  found.apart.emplace_back();
  return found;
}
NoConstant with_course() {
  NoConstant varying;
  varying.effects.push_back(some_effect());
  varying.ambiguous_with.push_back(testing::effect("resistance_change"));
  return varying;
}

TEST_CASE("what has a name, and leaves nothing, is the missing physics") {
  CHECK(verdict_of(decide(limb, with_name(), true, false)) == Verdict::missing_physics);
}

TEST_CASE("what has a name, and leaves something, is named in part") {
  CHECK(verdict_of(decide(limb, with_name(), true, true)) == Verdict::named_in_part);
}

TEST_CASE("parts that differ are an answer without a name") {
  CHECK(verdict_of(decide(limb, with_parts_that_differ(), false, false)) == Verdict::missing_physics);
}

TEST_CASE("what the plant as given leaves, or what makes up for it without a name, is unexplained") {
  CHECK(std::holds_alternative<Unexplained>(decide(limb, {}, false, true)));
  CHECK(std::holds_alternative<Unexplained>(decide(limb, {}, true, true)));
  CHECK(std::holds_alternative<Unexplained>(decide(limb, {}, true, false)));
  CHECK(verdict_of(Unexplained{}) == Verdict::unexplained);
  CHECK(verdict_of(NoConstant{}) == Verdict::unexplained);
}

TEST_CASE("a plant as given that leaves nothing is consistent") {
  CHECK(std::holds_alternative<NothingMissing>(decide(limb, {}, false, false)));
  CHECK(verdict_of(NothingMissing{}) == Verdict::consistent);
}

TEST_CASE("an answer gives what it has, and nothing of what it has not") {
  const Answer found = decide(limb, with_name(), true, false);
  CHECK(effects_in(found).size() == 1);
  CHECK(laws_in(found).empty());
  const Answer varying = with_course();
  CHECK(effects_in(varying).size() == 1);
  CHECK(ambiguous_in(varying).size() == 1);
  CHECK(apart_in(varying).empty());
  CHECK(effects_in(Unexplained{}).empty());
  CHECK(ambiguous_in(NothingMissing{}).empty());
}

TEST_CASE("a channel is far off beyond its noise and what air does, and counts by the squared error beyond noise") {
  const plant::ChannelId angle = testing::angle;
  PerChannel noise = per_channel(limb);
  noise[angle] = 0.05;
  const double disturbance = limb.channels()[angle].ordinary_disturbance;
  REQUIRE(disturbance > 0.0);
  CHECK(!far_off(limb, disturbance, angle, noise));
  CHECK(far_off(limb, 1.1 * std::hypot(disturbance, 0.1), angle, noise));
  noise[angle] = disturbance;  // a coarse sensor may be off by twice its noise
  CHECK(!far_off(limb, 2.0 * disturbance, angle, noise));
  CHECK(share_left(5.0, 3.0, 0.0) == doctest::Approx(0.36));
  CHECK(share_left(5.0, 3.0, 3.0) == 0.0);
}

}  // namespace diagnose_decide_test
