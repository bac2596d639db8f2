// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/input_delay.h"

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_input_delay_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// By hand: T(t) of a wire heated at duty 0.6 from ambient temperature for that long.
double heated_degC(double seconds) { return 25.0 + 0.6 * 49.0 / 2.5 / 0.04 * (1.0 - std::exp(-seconds * 0.04 / 0.85)); }

}  // namespace

TEST_CASE("input delay: a wire begins to warm only when the command has arrived") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    const Plant limb = limb_with("input_delay", {{"delay_s", 0.3}});
    Integrator run(limb, Start{}, {.method = method, .relative_tolerance = 1e-9});
    run.hold({0.6, 0.0});
    CHECK(at_one_instant(limb, run).now.joule_heat_W[A] == 0.0);
    REQUIRE_FALSE(run.advance_to(0.29));
    CHECK(run.state()[0] == 25.0);
    REQUIRE_FALSE(run.advance_to(2.0));
    CHECK(run.state()[0] == doctest::Approx(heated_degC(1.7)).epsilon(1e-7));  // solver: 1e-9 a step
  }
}

TEST_CASE("input delay: commands under way arrive one by one, each as late as the other") {
  const Plant limb = limb_with("input_delay", {{"delay_s", 0.3}});
  Integrator run(limb, Start{}, {.relative_tolerance = 1e-9});
  run.hold({0.6, 0.0});
  REQUIRE_FALSE(run.advance_to(0.1));
  run.hold({0.0, 0.4});
  REQUIRE_FALSE(run.advance_to(0.2));
  run.hold({0.2, 0.0});
  const auto duty_at = [&](double time_s) {
    REQUIRE_FALSE(run.advance_to(time_s));
    return at_one_instant(limb, run).now.duty_fraction;
  };
  CHECK(duty_at(0.25) == std::vector<double>{0.0, 0.0});
  CHECK(duty_at(0.35) == std::vector<double>{0.6, 0.0});
  CHECK(duty_at(0.45) == std::vector<double>{0.0, 0.4});
  CHECK(duty_at(0.55) == std::vector<double>{0.2, 0.0});
}

TEST_CASE("input delay: what was held at the start acts until the first command arrives") {
  const Plant limb = limb_with("input_delay", {{"delay_s", 0.3}});
  Integrator run(limb, Start{{}, {0.6, 0.0}}, {.relative_tolerance = 1e-9});
  run.hold({0.0, 0.0});
  REQUIRE_FALSE(run.advance_to(0.3));
  CHECK(run.state()[0] == doctest::Approx(heated_degC(0.3)).epsilon(1e-7));
  CHECK(at_one_instant(limb, run).now.duty_fraction[A] == 0.0);
}

}  // namespace plant_limb_effects_input_delay_test
