// SPDX-License-Identifier: Apache-2.0
#include <complex>

#include "tests/plant/small_system_test.h"

namespace plant_silverbox_test {

using namespace sinew::test::small;

namespace {
Plant oscillator() { return plant_from("silverbox/linear.yaml"); }
}  // namespace

TEST_CASE("silverbox: drive less damping and spring accelerates the mass") {
  Plant plant = oscillator();
  set(plant, "drive_offset_V", 0.01);
  // By hand: 0.1 + 0.01 - 2e-4 * 50 - 1 * 0.05 = 0.05 V, on 5e-6 s^2.
  const AtOnce at = at_once(plant, 0.1, {0.05, 50.0});
  CHECK(at.rates[0] == 50.0);
  CHECK(at.rates[1] == near_exactly(1e4));
  CHECK(at.readings[0] == 0.05);
}

TEST_CASE("silverbox: it rings down as a damped oscillator does") {
  const Plant plant = oscillator();
  Integrator integrator(plant, {{0.1, 0.0}, {0.0}}, {.relative_tolerance = 1e-10});
  REQUIRE(!integrator.advance_to(0.05));
  // By hand: y = Re(c exp(s t)), m s^2 + d s + k = 0; from rest at y_0.
  const std::complex<double> s(-20.0, std::sqrt(1.0 / 5e-6 - 400.0));
  const std::complex<double> y = 0.1 * (std::exp(s * 0.05) * std::conj(s) - std::exp(std::conj(s) * 0.05) * s) / (std::conj(s) - s);
  CHECK(integrator.readings()[0] == doctest::Approx(y.real()).epsilon(1e-6));
}

TEST_CASE("silverbox: a drive that changes steadily between samples is followed with the static lag d/k") {
  const Plant plant = oscillator();
  CHECK(plant.system().inputs()[InputId{0}].between == Between::linear);
  std::vector<sinew::sim::Sample> samples;
  for (int k = 0; k <= 100; ++k) samples.push_back({0.01 * k, {0.02 * k}, {0.0}});  // 2 V/s
  // On the path it keeps: y = 2 (t - d/k).
  Integrator integrator(plant, {{-4e-4, 2.0}, {0.0}}, {});
  REQUIRE(!sinew::sim::replay(integrator, plant.system(), samples, [&](std::size_t k) {
    CHECK(integrator.readings()[0] == doctest::Approx(2.0 * (samples[k].time_s - 2e-4)).epsilon(1e-7).scale(0.01));
  }));
}

TEST_CASE("silverbox: each effect's force, by hand") {
  const double without = at_once(oscillator(), 0.0, {-0.2, 30.0}).rates[1];
  const auto more_force_V = [&](std::initializer_list<std::pair<const char*, double>> values) {
    Plant plant = oscillator();
    for (const auto& [key, value] : values) set(plant, key, value);
    return 5e-6 * (at_once(plant, 0.0, {-0.2, 30.0}).rates[1] - without);
  };
  const auto near = [](double force_V) { return doctest::Approx(force_V).epsilon(1e-10); };
  CHECK(more_force_V({{"cubic_stiffness.stiffness_1_V2", 4.0}}) == near(0.032));
  CHECK(more_force_V({{"quadratic_stiffness.stiffness_1_V", 0.5}}) == near(-0.02));
  CHECK(more_force_V({{"dry_friction.force_V", 0.002}}) == near(-0.002));
  CHECK(more_force_V({{"quadratic_damping.damping_s2_V", 1e-6}}) == near(-9e-4));
  CHECK(more_force_V({{"hard_stop.stiffness_V_V", 2.0}, {"hard_stop.distance_V", 0.15}}) == near(0.1));
}

TEST_CASE("silverbox: every effect is exactly nothing at its null, and something at its typical value") {
  check_nulls(oscillator(), 0.05, {{0.2, 30.0}, {-0.15, -60.0}, {0.01, 0.0}});
}

TEST_CASE("silverbox: sensitivities are those of differences") {
  check_sensitivities(oscillator(), {0.05, 20.0}, {0.05, -0.08, 0.09, 0.02, -0.06, 0.1, 0.03, -0.04}, 0.0016384);
}

TEST_CASE("silverbox: lists, files") { check_lists(oscillator(), "silverbox"); }

// Values are those of a least-squares fit.
TEST_CASE("silverbox: a cubic spring explains the benchmark's recording to 0.9 mV, a linear one to 6.4 mV") {
  const char* const file = "silverbox/multisine.csv";
  const auto without =
      open_loop_rms(oscillator(),
                    {{"mass_s2", 5.12446e-6}, {"damping_s", 2.18007e-4}, {"stiffness_V_V", 0.977039}, {"drive_offset_V", -0.00539555}},
                    {-0.0503047, -3.59173}, file);
  const auto with = open_loop_rms(oscillator(),
                                  {{"mass_s2", 5.16795e-6},
                                   {"damping_s", 2.15785e-4},
                                   {"stiffness_V_V", 0.952299},
                                   {"drive_offset_V", -0.00539099},
                                   {"cubic_stiffness.stiffness_1_V2", 3.79402}},
                                  {-0.0502566, -0.368025}, file);
  if (!with) return;
  CHECK(*without > 0.006);
  CHECK(*with < 0.00096);
}

}  // namespace plant_silverbox_test
