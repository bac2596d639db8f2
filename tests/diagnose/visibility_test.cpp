#include "diagnose/visibility.h"

#include <doctest/doctest.h>

#include "tests/diagnose/one_limb.h"

using namespace sinew;
using namespace sinew::diagnose;

namespace {

constexpr double least_gain = 24.0;

sim::Scenario scenario_with(double conductance_W_K) {
  sim::Scenario scenario = testing::babbling(120.0);
  scenario.sensors = {};
  if (conductance_W_K > 0.0) {
    scenario.limb = with_effect(scenario.limb, plant::effect_index("body_heat_storage"));
    plant::set_in_file_units(scenario.limb, plant::parameter_index("body_heat_storage.conductance_W_K"), conductance_W_K);
  }
  return scenario;
}

// What the effect gains, from the recording that it was in.
double gain_where_it_is(double conductance_W_K) {
  const testing::FittedCore limb(scenario_with(conductance_W_K));
  Guess guess = limb.core.as_guess();
  guess.values["body_heat_storage.conductance_W_K"] = conductance_W_K;
  const Explanation with =
      explain(with_effect(limb.core.problem->centres(), plant::effect_index("body_heat_storage")), limb.data, guess, limb.settings);
  return 2.0 * (with.log_posterior - limb.core.log_posterior);
}

}  // namespace

TEST_CASE("visibility: what first order cannot see is seen from about the strength that a search would find") {
  const testing::FittedCore limb(scenario_with(0.0));
  REQUIRE(limb.core.usable);
  const double smallest = smallest_seen(limb.core, plant::effect_index("body_heat_storage"), least_gain, limb.settings);
  CAPTURE(smallest);
  CHECK(smallest > 1e-4);
  CHECK(smallest < 0.01);
  CHECK(gain_where_it_is(3.0 * smallest) > least_gain);
  CHECK(gain_where_it_is(smallest / 3.0) < least_gain);
}

TEST_CASE("visibility: a thermocouple's gain is not seen until the core that imitates it is hard to believe") {
  const testing::FittedCore limb(scenario_with(0.0));
  const double typical = 0.1;
  CHECK(smallest_seen(limb.core, plant::effect_index("thermocouple_heat_sink"), least_gain, limb.settings) > 2.0 * typical);
}
