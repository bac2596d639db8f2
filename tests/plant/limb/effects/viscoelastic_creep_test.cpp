// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/viscoelastic_creep.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_viscoelastic_creep_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

const Plant creeping = limb_with("viscoelastic_creep", {{"stiffness_Nm_rad", 0.015}, {"time_constant_s", 20.0}});

}  // namespace

TEST_CASE("viscoelastic creep: the branch resists by its stretch and relaxes in its time constant") {
  const auto at = at_one_instant(creeping, {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0, 0.2});
  const auto core = at_one_instant(default_plant(), {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0});
  // By hand: 0.015 N m/rad * 0.3 rad against the bend; 0.3 rad / 20 s.
  CHECK(at.now.moment_Nm[0] - core.now.moment_Nm[0] == doctest::Approx(-0.0045).epsilon(1e-13));
  CHECK(at.rates[6] == by_hand(0.015));
}

TEST_CASE("viscoelastic creep: a branch that has relaxed carries nothing, and so it is at rest") {
  const auto at = at_one_instant(creeping, {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0, 0.5});
  CHECK(at.now.moment_Nm[0] == at_one_instant(default_plant(), {}, {25.0, 25.0, 1.0, 1.0, 0.5, 0.0}).now.moment_Nm[0]);
  CHECK(at.rates[6] == 0.0);
  std::vector<std::optional<double>> hot(7);
  hot[0] = 100.0;
  const auto y = at_rest(creeping, hot);
  CHECK(y[4] > 0.5);
  CHECK(y[6] == y[4]);
}

}  // namespace plant_limb_effects_viscoelastic_creep_test
