// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/fatigue.h"

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_fatigue_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("fatigue: after ten cycles at 0.3 % the coil has lost three hundredths of its transformation stretch") {
  const auto at = at_one_instant(limb_with("fatigue", {{"loss_per_cycle", 0.003}}), {}, {25.0, 25.0, 1.0, 1.0, 0.0, 0.0, 10.0, 0.0});
  // By hand: 28 mm * 0.97 = 27.16 mm; 113 N/m * (30 - 27.16) mm = 0.32092 N. Coil B is as new: 0.226 N.
  CHECK(at.now.transformation_stretch_m[A] == by_hand(0.02716));
  CHECK(at.now.tension_N[A] == doctest::Approx(0.32092).epsilon(1e-13));  // a difference of near numbers
  CHECK(at.now.tension_N[B] == doctest::Approx(0.226).epsilon(1e-13));
}

TEST_CASE("fatigue: transformation counts as half a cycle in either direction") {
  // Fractions 0.1 outside their envelopes of 1/2: at 75 degC falling, at 60 degC rising, by 1 /s each.
  const auto at = at_one_instant(limb_with("fatigue"), {}, {75.0, 60.0, 0.6, 0.4, 0.0, 0.0, 0.0, 0.0});
  CHECK(at.now.martensite_rate_1_s[A] == by_hand(-1.0));
  CHECK(at.rates[6] == by_hand(0.5));
  CHECK(at.now.martensite_rate_1_s[B] == by_hand(1.0));
  CHECK(at.rates[7] == by_hand(0.5));
}

TEST_CASE("fatigue: from cold to hot and back to cold is one cycle, the other coil has done none") {
  Integrator run(limb_with("fatigue", {{"loss_per_cycle", 0.003}}), Start{}, {.relative_tolerance = 1e-9});
  const double first = run.state()[2];
  run.hold({0.6, 0.0});
  REQUIRE_FALSE(run.advance_to(15.0));
  const double lowest = run.state()[2];
  CHECK(lowest < 0.001);
  run.hold({0.0, 0.0});
  REQUIRE_FALSE(run.advance_to(400.0));
  // Nothing turns back on the way, so the count is half the way down and half the way up.
  const double expected = 0.5 * (first - lowest) + 0.5 * (run.state()[2] - lowest);
  CHECK(run.state()[6] == doctest::Approx(expected).epsilon(1e-7));  // a hundred times the solver's tolerance
  CHECK(run.state()[6] == doctest::Approx(1.0).epsilon(0.01));       // the cold envelope is 0.993, not 1
  CHECK(run.state()[7] == 0.0);
}

}  // namespace plant_limb_effects_fatigue_test
