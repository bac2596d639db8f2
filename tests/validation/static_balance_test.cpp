// SPDX-License-Identifier: Apache-2.0
// Where the beam comes to rest, against a root of the moment written out here and found by bisection.
#include <functional>
#include <numbers>
#include <random>

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"

namespace validation_static_balance_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// A falling function's root between the limits, to the last bits.
double bisect(const std::function<double(double)>& falling, double low, double high) {
  REQUIRE(falling(low) > 0.0);
  REQUIRE(falling(high) < 0.0);
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    (falling(middle) > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double logistic(double temperature_degC, double midpoint_degC, double width_K) {
  return 1.0 / (1.0 + std::exp((temperature_degC - midpoint_degC) / width_K));
}

// Tension of a default coil, written out.
double tension_N(double fraction, double longer_share, double shortening_m) {
  return (313.0 - 200.0 * fraction) * (0.030 - shortening_m - 0.028 * longer_share);
}

// Rounding of the moment, 1e-17 N m, over the least stiffness, 0.05 N m/rad, and of the Newton steps' differences.
constexpr double rest_rad = 1e-12;

}  // namespace

TEST_CASE("at rest the core's beam stands where tensions and bending balance") {
  std::mt19937_64 bits(4711);
  const auto between = [&](double low, double high) { return low + (high - low) * (static_cast<double>(bits() >> 11) * 0x1p-53); };
  for (int n = 0; n < 50; ++n) {
    Plant limb = default_plant();
    const double ka = between(200.0, 400.0), km = between(50.0, 200.0);
    const double stretch_m = between(0.01, 0.04), transformation_m = between(0.01, 0.04);
    const double arm_a = between(0.003, 0.01), arm_b = between(0.003, 0.01);
    const double beam_Nm_rad = between(0.03, 0.1), sign = n % 2 ? 1.0 : -1.0;
    set(limb, "austenite_stiffness_N_m", ka);
    set(limb, "martensite_stiffness_N_m", km);
    set(limb, "coil_stretch_m", stretch_m);
    set(limb, "transformation_stretch_m", transformation_m);
    set(limb, "moment_arm_A_m", arm_a);
    set(limb, "moment_arm_B_m", arm_b);
    set(limb, "beam_stiffness_Nm_rad", beam_Nm_rad);
    set(limb, "bend_sign", sign);
    const double a = between(0.0, 1.0), b = between(0.0, 1.0);
    std::vector<std::optional<double>> given(6);
    given[0] = between(20.0, 100.0);
    given[2] = a;
    given[3] = b;
    const auto y = at_rest(limb, given);
    const auto moment = [&](double theta) {
      const double fa = (ka + a * (km - ka)) * (stretch_m - sign * arm_a * theta - a * transformation_m);
      const double fb = (ka + b * (km - ka)) * (stretch_m + sign * arm_b * theta - b * transformation_m);
      return sign * (arm_a * fa - arm_b * fb) - beam_Nm_rad * theta;
    };
    CHECK(std::abs(y[4] - bisect(moment, -6.0, 6.0)) < rest_rad);
    CHECK(y[0] == *given[0]);
    CHECK(y[1] == 25.0);
    CHECK(y[2] == a);
    CHECK(y[5] == 0.0);
  }
}

TEST_CASE("at rest with weight, stiffening, a stop, slack, an R-phase, creep and friction, all at once") {
  Plant limb = default_plant();
  turn_on(limb, "gravity_load", {{"moment_Nm", 0.02}, {"tilt_deg", 35.0}});
  turn_on(limb, "cubic_stiffening", {{"stiffness_Nm_rad3", 0.08}});
  turn_on(limb, "hard_stop", {{"stiffness_Nm_rad", 0.15}, {"angle_deg", 12.0}});
  turn_on(limb, "coil_slack", {{"enabled", 1.0}});
  turn_on(limb, "r_phase", {{"share", 0.3}, {"midpoint_degC", 45.0}, {"width_K", 4.0}});
  turn_on(limb, "viscoelastic_creep", {{"stiffness_Nm_rad", 0.03}});  // relaxed at rest: no moment
  turn_on(limb, "dry_friction", {{"moment_Nm", 0.01}});               // not moving: no moment
  turn_on(limb, "fatigue", {{"loss_per_cycle", 0.01}});               // no cycle done yet
  struct Case {
    double t_a, t_b, xi_a, xi_b;
  };
  // Hot A, hot B (so that it leans on the stop from the other side), both half-way, and one where the cold coil is slack.
  for (const Case& c :
       {Case{95.0, 25.0, 0.05, 0.99}, Case{25.0, 95.0, 0.99, 0.05}, Case{67.0, 67.0, 0.5, 0.5}, Case{25.0, 120.0, 1.0, 0.0}}) {
    std::vector<std::optional<double>> given(limb.states().size());
    given[0] = c.t_a;
    given[1] = c.t_b;
    given[2] = c.xi_a;
    given[3] = c.xi_b;
    const auto y = at_rest(limb, given);
    const auto moment = [&](double theta) {
      constexpr double degree = std::numbers::pi / 180.0;
      const double fa = std::max(0.0, tension_N(c.xi_a, 0.7 * c.xi_a + 0.3 * logistic(c.t_a, 45.0, 4.0), 0.006 * theta));
      const double fb = std::max(0.0, tension_N(c.xi_b, 0.7 * c.xi_b + 0.3 * logistic(c.t_b, 45.0, 4.0), -0.006 * theta));
      const double beyond = std::max(0.0, std::abs(theta) - 12.0 * degree);
      return 0.006 * (fa - fb) - 0.05 * theta - 0.08 * theta * theta * theta - 0.02 * std::sin(theta + 35.0 * degree) -
             0.15 * (theta < 0.0 ? -beyond : beyond);
    };
    CHECK(std::abs(y[4] - bisect(moment, -2.0, 2.0)) < rest_rad);
  }
}

TEST_CASE("at rest with stress shift, fractions and bend settle together") {
  // Room temperature, one side warm, both warm alike (so that the beam is straight from the first), and a strong shift.
  struct Case {
    double shift_K_N;
    std::vector<double> temperature_degC;
  };
  for (const auto& [shift_K_N, temperature_degC] : {Case{0.8, {25.0, 25.0}},
                                                    {0.8, {62.0, 25.0}},
                                                    {0.8, {30.0, 66.0}},
                                                    {0.8, {62.0, 62.0}},
                                                    {2.5, {25.0, 25.0}},
                                                    {2.5, {70.0, 25.0}},
                                                    {5.0, {70.0, 25.0}}}) {
    CAPTURE(shift_K_N);
    CAPTURE(temperature_degC[A]);
    CAPTURE(temperature_degC[B]);
    const auto limb = limb_with("stress_shift", {{"shift_K_N", shift_K_N}});
    std::vector<std::optional<double>> given(6);
    given[0] = temperature_degC[A];
    given[1] = temperature_degC[B];
    const auto y = at_rest(limb, given);
    // A coil's fraction is the root of xi = xi_cool(T - F(xi) / C_F) at its stretch; the beam's angle that of the moment.
    const double shift = shift_K_N;
    const auto fraction = [shift](double t_degC, double shortening_m) {
      return bisect([&](double xi) { return logistic(t_degC, 60.0 + shift * tension_N(xi, xi, shortening_m), 7.0) - xi; }, -0.1, 1.1);
    };
    const auto moment = [&](double theta) {
      const double a = fraction(temperature_degC[A], 0.006 * theta), b = fraction(temperature_degC[B], -0.006 * theta);
      return 0.006 * (tension_N(a, a, 0.006 * theta) - tension_N(b, b, -0.006 * theta)) - 0.05 * theta;
    };
    const double theta = bisect(moment, -2.0, 2.0);
    CHECK(std::abs(y[4] - theta) < rest_rad);
    CHECK(std::abs(y[2] - fraction(temperature_degC[A], 0.006 * theta)) < rest_rad);
    CHECK(std::abs(y[3] - fraction(temperature_degC[B], -0.006 * theta)) < rest_rad);
  }
}

TEST_CASE("at rest neither fractions nor limb want to move, however strong the shift by stress and however warm the wires") {
  int not_at_rest = 0;
  for (const double shift_K_N : {0.3, 0.8, 2.5, 5.0, 10.0, 20.0})
    for (double warm_degC = 0.0; warm_degC <= 150.0; warm_degC += 7.5)
      for (const double other_degC : {25.0, 70.0, warm_degC}) {
        Plant limb = limb_with("stress_shift", {{"shift_K_N", shift_K_N}});
        turn_on(limb, "gravity_load", {{"moment_Nm", 0.02}});
        turn_on(limb, "coil_slack", {{"enabled", 1.0}});
        std::vector<std::optional<double>> given(6);
        given[0] = warm_degC;
        given[1] = other_degC;
        const auto at = at_one_instant(limb, {}, at_rest(limb, given));
        for (const std::size_t j : coils) not_at_rest += std::abs(at.now.cooling_envelope[j] - at.now.martensite_fraction[j]) > rest_rad;
        not_at_rest += std::abs(at.now.moment_Nm[0] / 0.05) > rest_rad;
      }
  CHECK(not_at_rest == 0);
}

TEST_CASE("how the state at rest depends on a parameter is what differences of states at rest say") {
  const double step = 1e-6;  // of a parameter of size one; differences of values right to 1e-15 are then right to 1e-9
  for (const std::string_view key : {"stress_shift.shift_K_N", "coil_stretch_m", "ambient_temperature_degC"}) {
    CAPTURE(key);
    const ParameterId p = parameter_id(key);
    const double size = parameters()[p].declaration.typical;
    const auto at_rest_moved = [&](double by) {
      Plant limb = limb_with("stress_shift", {{"shift_K_N", 2.5}});
      limb.set(p, limb.get(p) + by);
      std::vector<std::optional<double>> given(6);
      given[0] = 70.0;
      return at_rest(limb, given);
    };
    std::vector<std::optional<double>> given(6);
    given[0] = 70.0;
    const Integrator run(limb_with("stress_shift", {{"shift_K_N", 2.5}}), Start{given, {}}, {}, {{p}, {}});
    const auto above = at_rest_moved(step * size), below = at_rest_moved(-step * size);
    for (std::size_t i = 0; i < 6; ++i) {
      CAPTURE(i);
      const double expected = (above[i] - below[i]) / (2.0 * step);  // for a change of the parameter's size
      CHECK(std::abs(run.state_sensitivity()(static_cast<Eigen::Index>(i), 0) * size - expected) < 1e-7);
    }
  }
}

TEST_CASE("a limb that is let go goes to the bend at which it balances") {
  Plant limb = default_plant();
  turn_on(limb, "gravity_load", {{"moment_Nm", 0.02}, {"tilt_deg", 35.0}});
  turn_on(limb, "cubic_stiffening", {{"stiffness_Nm_rad3", 0.08}});
  turn_on(limb, "hard_stop", {{"stiffness_Nm_rad", 0.15}, {"angle_deg", 12.0}});
  turn_on(limb, "coil_slack", {{"enabled", 1.0}});
  turn_on(limb, "viscoelastic_creep", {{"stiffness_Nm_rad", 0.03}, {"time_constant_s", 0.5}});
  turn_on(limb, "dry_friction", {{"moment_Nm", 0.001}, {"smoothing_rad_s", 0.1}});
  std::vector<std::optional<double>> given(limb.states().size());
  given[0] = 100.0;
  given[2] = 0.02;  // inside the loop, 0.003 to 0.027
  given[3] = 0.995;
  given[4] = -0.4;
  const auto moment = [](double theta) {
    constexpr double degree = std::numbers::pi / 180.0;
    const double fa = std::max(0.0, tension_N(0.02, 0.02, 0.006 * theta)), fb = std::max(0.0, tension_N(0.995, 0.995, -0.006 * theta));
    const double beyond = std::max(0.0, std::abs(theta) - 12.0 * degree);
    return 0.006 * (fa - fb) - 0.05 * theta - 0.08 * theta * theta * theta - 0.02 * std::sin(theta + 35.0 * degree) -
           0.15 * (theta < 0.0 ? -beyond : beyond);
  };
  const double expected_rad = bisect(moment, -2.0, 2.0);
  for (const Method method : {Method::cvode, Method::arkode}) {
    // By hand: duty that makes up for the loss of 0.04 * 75 W.
    Integrator run(limb, Start{given, {3.0 * 2.5 / 49.0, 0.0}}, {.method = method, .relative_tolerance = 1e-9});
    CHECK(run.state()[4] == -0.4);
    advance(run, 20.0);
    CHECK(std::abs(run.state()[0] - 100.0) < 1e-9);
    // The slowest motion decays by more than 1e-9 in 20 s; what remains is the solver's tolerance.
    CHECK(std::abs(run.state()[4] - expected_rad) < 1e-7);
  }
}

TEST_CASE("a limb at rest stays at rest") {
  Plant limb = default_plant();
  for (const EffectId e : effects().ids()) turn_on_typical(limb, e);
  set_in_file_units(limb, "ambient_drift.rate_K_s", 0.0);
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(limb, Start{}, {.method = method});
    const auto at_first = run.state();
    advance(run, 100.0);
    for (std::size_t i = 0; i < at_first.size(); ++i) {
      INFO(run.states()[StateId{i}].key);
      if (run.states()[StateId{i}].key.ends_with("elapsed_s")) continue;  // time goes on
      CHECK(std::abs(run.state()[i] - at_first[i]) < 1e-9);               // what rest() leaves, 1e-12, and the solver's 1e-8 of it
    }
  }
}

}  // namespace validation_static_balance_test
