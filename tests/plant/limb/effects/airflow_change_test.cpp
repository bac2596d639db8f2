// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/effects/airflow_change.h"

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_airflow_change_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

const Plant draught = limb_with("airflow_change", {{"relative_change", 0.25}, {"onset_s", 12.0}});

}  // namespace

TEST_CASE("airflow change: from its onset on, both wires lose a quarter more") {
  const std::vector<double> y{75.0, 45.0, 0.5, 1.0, 0.0, 0.0};
  // By hand: 0.04 * 1.25 = 0.05 W/K, times 50 K and 20 K.
  const auto after = at_one_instant(draught, {.time_s = 13.0, .segment_start_s = 12.0}, y);
  CHECK(after.rates[0] == by_hand(-2.5 / 0.85));
  CHECK(after.rates[1] == by_hand(-1.0 / 0.85));
}

TEST_CASE("airflow change: before its onset there is none, up to the very end of the segment that ends there") {
  const std::vector<double> y{75.0, 45.0, 0.5, 1.0, 0.0, 0.0};
  const auto before = at_one_instant(draught, {.time_s = 12.0, .segment_start_s = 3.0}, y);
  CHECK(before.rates == at_one_instant(default_plant(), {}, y).rates);
}

TEST_CASE("airflow change: the integrator stops at the onset and cools by the other law from there") {
  std::vector<std::optional<double>> given(6);
  given[0] = 65.0;
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(draught, Start{given, {}}, {.method = method, .relative_tolerance = 1e-9});
    REQUIRE_FALSE(run.advance_to(20.0));
    CHECK(run.counters().restarts == 2);
    // By hand: 40 K decay at 0.04/0.85 /s for 12 s, then at 0.05/0.85 /s for 8 s.
    const double expected = 25.0 + 40.0 * std::exp(-(0.04 * 12.0 + 0.05 * 8.0) / 0.85);
    CHECK(run.state()[0] == doctest::Approx(expected).epsilon(1e-7));  // solver: 1e-9 a step
  }
}

TEST_CASE("airflow change: an onset at the start acts from the start") {
  const Plant limb = limb_with("airflow_change", {{"relative_change", 0.25}, {"onset_s", 0.0}});
  const Integrator run(limb, Start{}, {});
  CHECK(at_one_instant(limb, run).now.heat_loss_W_K[A] == by_hand(0.05));
}

}  // namespace plant_limb_effects_airflow_change_test
