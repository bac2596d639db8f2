// SPDX-License-Identifier: Apache-2.0
#include "tests/plant/small_system_test.h"

namespace plant_emps_test {

using namespace sinew::test::small;

namespace {
Plant axis() { return plant_from("emps/rigid_axis.yaml"); }
}  // namespace

TEST_CASE("positioning axis: the drive's force less viscous friction accelerates the mass") {
  // By hand: 35.15 N/V * 2 V - 200 N s/m * 0.1 m/s = 50.3 N, on 100 kg.
  const AtOnce at = at_once(axis(), 2.0, {0.05, 0.1});
  CHECK(at.rates[0] == 0.1);
  CHECK(at.rates[1] == near_exactly(0.503));
  CHECK(at.readings[0] == 0.05);
}

TEST_CASE("positioning axis: a steady voltage leads to a steady speed, exponentially") {
  const Plant plant = axis();
  Integrator integrator(plant, {{0.0, 0.0}, {1.0}}, {});
  REQUIRE(!integrator.advance_to(1.5));
  // By hand: v = g u / c (1 - exp(-t / tau)), tau = M / c = 0.5 s;  x = g u / c (t - tau (1 - exp(-t / tau))).
  const double grown = 1.0 - std::exp(-3.0), speed = 35.15 / 200.0;
  CHECK(integrator.state()[1] == doctest::Approx(speed * grown).epsilon(1e-7));
  CHECK(integrator.state()[0] == doctest::Approx(speed * (1.5 - 0.5 * grown)).epsilon(1e-7));
}

TEST_CASE("positioning axis: each effect's force, by hand") {
  const double without = at_once(axis(), 0.0, {0.3, -0.1}).rates[1];  // 20 N on 100 kg
  CHECK(without == near_exactly(0.2));
  const auto more_force_N = [&](std::initializer_list<std::pair<const char*, double>> values) {
    Plant plant = axis();
    for (const auto& [key, value] : values) set(plant, key, value);
    return 100.0 * (at_once(plant, 0.0, {0.3, -0.1}).rates[1] - without);
  };
  const auto near = [](double force_N) { return doctest::Approx(force_N).epsilon(1e-11); };
  CHECK(more_force_N({{"dry_friction.force_N", 20.0}}) == near(20.0));  // against the motion, full above 0.5 mm/s
  CHECK(more_force_N({{"force_offset.force_N", 3.0}}) == near(-3.0));
  CHECK(more_force_N({{"stribeck_friction.force_N", 5.0}, {"stribeck_friction.speed_m_s", 0.1}}) == near(5.0 * std::exp(-1.0)));
  CHECK(more_force_N({{"quadratic_friction.friction_Ns2_m2", 100.0}}) == near(1.0));
  CHECK(more_force_N({{"centring_spring.stiffness_N_m", 50.0}, {"centring_spring.centre_m", 0.1}}) == near(-10.0));
}

TEST_CASE("positioning axis: a sensor that lags shows a steadily moving axis where it was a time constant ago") {
  Plant plant = axis();
  set(plant, "sensor_lag.time_constant_s", 0.05);
  Integrator integrator(plant, {{0.0, 0.17575, 0.0}, {1.0}}, {});  // at the steady speed of 1 V from the start
  REQUIRE(!integrator.advance_to(2.0));
  CHECK(integrator.readings()[0] == doctest::Approx(0.17575 * 1.95).epsilon(1e-7));
}

TEST_CASE("positioning axis: every effect is exactly nothing at its null, and something at its typical value") {
  check_nulls(axis(), 1.5, {{0.0, 0.0}, {0.2, 0.05}, {-0.1, -0.004}});
}

TEST_CASE("positioning axis: sensitivities are those of differences") {
  check_sensitivities(axis(), {0.01, 0.05}, {1.0, 1.5, 2.0, 1.0, 1.2, 1.4, 1.6, 1.3}, 0.03);
}

TEST_CASE("positioning axis: lists, files") { check_lists(axis(), "emps"); }

// Values are those of a least-squares fit; published: about 95 kg, 204 N s/m, 20.4 N, -3.2 N.
TEST_CASE("positioning axis: dry friction and an offset explain the benchmark's recording to 2.6 mm, their absence to 92 mm") {
  const char* const file = "emps/DATA_EMPS.mat";
  const double gain = 35.15065188248547;
  const auto without =
      open_loop_rms(axis(), {{"mass_kg", 212.358}, {"viscous_friction_Ns_m", 357.676}, {"drive_gain_N_V", gain}}, {0.0, 0.0}, file);
  const auto with = open_loop_rms(axis(),
                                  {{"mass_kg", 91.0569},
                                   {"viscous_friction_Ns_m", 191.83},
                                   {"drive_gain_N_V", gain},
                                   {"dry_friction.force_N", 22.027},
                                   {"force_offset.force_N", -3.35788}},
                                  {0.0, 0.0}, file);
  if (!with) return;
  CHECK(*without > 0.08);
  CHECK(*with < 0.0027);
}

}  // namespace plant_emps_test
