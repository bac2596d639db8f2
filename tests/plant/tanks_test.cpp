// SPDX-License-Identifier: Apache-2.0
#include "tests/plant/small_system_test.h"

namespace plant_tanks_test {

using namespace sinew::test::small;

namespace {
Plant tanks() { return plant_from("tanks/no_overflow.yaml"); }
}  // namespace

TEST_CASE("tanks: what runs out of the upper tank runs into the lower one") {
  // By hand: 0.05 * 3 - 0.07 * sqrt(4) = 0.01 V/s; 0.07 * 2 - 0.07 * 3 = -0.07 V/s.
  const AtOnce at = at_once(tanks(), 3.0, {4.0, 9.0});
  CHECK(at.rates[0] == near_exactly(0.01));
  CHECK(at.rates[1] == near_exactly(-0.07));
  CHECK(at.readings[0] == 9.0);
  Plant shifted = tanks();
  set(shifted, "sensor_zero_V", -1.5);
  CHECK(at_once(shifted, 3.0, {4.0, 9.0}).readings[0] == 7.5);
}

TEST_CASE("tanks: an upper tank without inflow empties as Torricelli says") {
  const Plant plant = tanks();
  Integrator integrator(plant, {{9.0, 0.0}, {0.0}}, {});
  REQUIRE(!integrator.advance_to(20.0));
  // By hand: sqrt(h) = sqrt(9) - 0.07 * 20 / 2 = 2.3.
  CHECK(integrator.state()[0] == doctest::Approx(2.3 * 2.3).epsilon(1e-7));
}

TEST_CASE("tanks: a tank that runs dry stays dry") {
  const Plant plant = tanks();
  Integrator integrator(plant, {{0.5, 0.2}, {0.0}}, {.method = Method::arkode, .relative_tolerance = 1e-6});
  REQUIRE(!integrator.advance_to(400.0));
  CHECK(std::abs(integrator.state()[0]) < 1e-4);
  CHECK(std::abs(integrator.state()[1]) < 1e-4);
}

TEST_CASE("tanks: at rest both levels are those that the pump keeps, and a known level is kept by the other") {
  Plant plant = tanks();
  plant.set(plant.system().parameter("lower_outflow_sqrtV_s"), 0.05);
  Situation given;
  given.inputs = {2.0};
  const auto equations = plant.equations();
  // By hand: sqrt(h_1) = 0.05 * 2 / 0.07; sqrt(h_2) = 0.07 sqrt(h_1) / 0.05 = 2.
  const auto rest = equations->rest(given, {std::nullopt, std::nullopt});
  CHECK(rest[0] == near_exactly(100.0 / 49.0));
  CHECK(rest[1] == near_exactly(4.0));
  CHECK(equations->rest(given, {std::nullopt, 9.0})[0] == near_exactly(9.0 * 25.0 / 49.0));
}

TEST_CASE("tanks: before a fit the lower level is what the sensor shows above its zero, and the upper one keeps it") {
  Plant plant = tanks();
  set(plant, "sensor_zero_V", -1.5);
  const double first[] = {5.5};
  const auto beliefs = plant.system().start_beliefs(plant, first);
  CHECK(beliefs[0].centre == near_exactly(7.0));
  CHECK(beliefs[1].centre == near_exactly(7.0));
  CHECK(beliefs[0].lowest == 0.0);
}

TEST_CASE("tanks: each effect, by hand") {
  const auto with = [](std::initializer_list<std::pair<const char*, double>> values) {
    Plant plant = tanks();
    for (const auto& [key, value] : values) set(plant, key, value);
    return at_once(plant, 3.0, {16.0, 11.0});
  };
  const AtOnce without = with({});
  // Of 2 V that stand over, 0.2 in a second; a quarter of it into the lower tank.
  const AtOnce overflow =
      with({{"upper_overflow.rate_1_s", 0.2}, {"upper_overflow.height_V", 14.0}, {"upper_overflow.share_fraction", 0.25}});
  CHECK(overflow.rates[0] - without.rates[0] == near_exactly(-0.4));
  CHECK(overflow.rates[1] - without.rates[1] == near_exactly(0.1));
  CHECK(with({{"sensor_saturation.share_fraction", 1.0}, {"sensor_saturation.highest_V", 10.0}}).readings[0] == near_exactly(10.0));
  const AtOnce lower = with({{"lower_overflow.rate_1_s", 0.2}, {"lower_overflow.height_V", 10.5}});
  CHECK(lower.rates[1] - without.rates[1] == near_exactly(-0.1));
  CHECK(with({{"upper_leak.leak_1_s", 0.01}}).rates[0] - without.rates[0] == near_exactly(-0.16));
  CHECK(with({{"pump_dead_band.voltage_V", 1.0}}).rates[0] - without.rates[0] == near_exactly(-0.05));
}

TEST_CASE("tanks: every effect is exactly nothing at its null, and something at its typical value") {
  check_nulls(tanks(), 3.0, {{4.0, 5.0}, {14.0, 11.0}, {0.0, 0.0}});
}

TEST_CASE("tanks: sensitivities are those of differences") {
  check_sensitivities(tanks(), {12.0, 9.0}, {5.0, 6.0, 4.0, 3.0, 5.5, 6.0}, 4.0);
}

TEST_CASE("tanks: lists, files") { check_lists(tanks(), "tanks"); }

// Values are those of a least-squares fit.
TEST_CASE("tanks: overflow explains the benchmark's recording to 0.26 V, its absence to 0.57 V") {
  const char* const file = "cascaded_tanks/estimation.csv";
  const auto without = open_loop_rms(tanks(),
                                     {{"pump_gain_1_s", 0.112773},
                                      {"upper_outflow_sqrtV_s", 0.0584627},
                                      {"lower_outflow_sqrtV_s", 0.125486},
                                      {"sensor_zero_V", -0.961149}},
                                     {27.9623, 6.08489}, file);
  const auto with = open_loop_rms(tanks(),
                                  {{"pump_gain_1_s", 0.0407896},
                                   {"upper_outflow_sqrtV_s", 0.0453939},
                                   {"lower_outflow_sqrtV_s", 0.0423493},
                                   {"sensor_zero_V", -1.76015},
                                   {"upper_overflow.rate_1_s", 0.0917844},
                                   {"upper_overflow.height_V", 9.137},
                                   {"upper_overflow.share_fraction", 1.0},
                                   {"lower_overflow.rate_1_s", 5.0},
                                   {"lower_overflow.height_V", 11.7936}},
                                  {5.62613, 7.00976}, file);
  if (!with) return;
  CHECK(*without > 0.5);
  CHECK(*with < 0.26);
}

}  // namespace plant_tanks_test
