// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/coil_slack.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_coil_slack_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// Bent by one radian towards A, the cold coil A is 30 - 6 mm long over its free length, 28 mm longer than hot.
const std::vector<double> bent{25.0, 25.0, 1.0, 1.0, 1.0, 0.0};

}  // namespace

TEST_CASE("coil slack: a coil that would push goes slack, the one that pulls does not notice") {
  const auto without = at_one_instant(default_plant(), {}, bent);
  const auto with = at_one_instant(limb_with("coil_slack", {{"enabled", 1.0}}), {}, bent);
  CHECK(without.now.tension_N[A] == doctest::Approx(-0.452).epsilon(1e-13));  // by hand: 113 N/m * -4 mm
  CHECK(with.now.tension_N[A] == 0.0);
  CHECK(with.now.tension_N[B] == without.now.tension_N[B]);
  CHECK(with.now.tension_N[B] == doctest::Approx(0.904).epsilon(1e-13));  // 113 N/m * 8 mm
}

TEST_CASE("coil slack: the limb is then held by the other coil and the beam alone") {
  const auto with = at_one_instant(limb_with("coil_slack", {{"enabled", 1.0}}), {}, bent);
  // By hand: -0.006 m * 0.904 N - 0.05 N m/rad * 1 rad.
  CHECK(with.now.moment_Nm[0] == doctest::Approx(-0.055424).epsilon(1e-13));
}

TEST_CASE("coil slack: where both coils pull, it does nothing") {
  const std::vector<double> y{80.0, 25.0, 0.3, 1.0, 0.2, 0.1};
  CHECK(at_one_instant(limb_with("coil_slack", {{"enabled", 1.0}}), {}, y).rates == at_one_instant(default_plant(), {}, y).rates);
}

}  // namespace plant_limb_effects_coil_slack_test
