// SPDX-License-Identifier: Apache-2.0
#include "diagnose/decide.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/diagnose/one_limb.h"

namespace diagnose_decide_test {

using namespace sinew;
using namespace sinew::diagnose;

TEST_CASE("what has a name, and leaves nothing, is the missing physics") {
  CHECK(decide({.is_named = true, .has_more = true, .leaves_something = false}) == Verdict::missing_physics);
}

TEST_CASE("what has a name, and leaves something, is named in part") {
  CHECK(decide({.is_named = true, .has_more = true, .leaves_something = true}) == Verdict::named_in_part);
}

TEST_CASE("what the plant as given leaves, or what makes up for it without a name, is unexplained") {
  CHECK(decide({.is_named = false, .has_more = false, .leaves_something = true}) == Verdict::unexplained);
  CHECK(decide({.is_named = false, .has_more = true, .leaves_something = true}) == Verdict::unexplained);
  CHECK(decide({.is_named = false, .has_more = true, .leaves_something = false}) == Verdict::unexplained);
}

TEST_CASE("a plant as given that leaves nothing is consistent") { CHECK(decide({}) == Verdict::consistent); }

TEST_CASE("a channel is far off beyond its noise and what air does, and counts by the squared error beyond noise") {
  const plant::System& limb = testing::limb_system();
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
