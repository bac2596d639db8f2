// SPDX-License-Identifier: Apache-2.0
// Temperatures and bends for which the equations can be solved on paper.
#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"

namespace validation_heating_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

constexpr Method methods[] = {Method::cvode, Method::arkode};

// The solvers are given 1e-9 of 50 degC and of the temperature a step, 1.5e-7 K at most; a hundred steps add up to this.
constexpr double tolerance_K = 1.5e-5;
constexpr NumericalSettings settings(Method method) { return {.method = method, .relative_tolerance = 1e-9}; }

}  // namespace

TEST_CASE("a wire heats and cools by the exponential law, across every jump of the duty") {
  Plant limb = default_plant();
  set(limb, "resistance_B_Ohm", 3.1);
  set(limb, "heat_capacity_B_J_K", 0.6);
  set(limb, "heat_loss_B_W_K", 0.055);
  set(limb, "ambient_temperature_degC", 21.0);
  const Profile profile = babbling_profile();
  for (const Method method : methods) {
    Integrator run(limb, Start{}, settings(method));
    std::vector<double> expected_degC{21.0, 21.0};
    double worst_K = 0.0;
    for (std::size_t k = 0; k < profile.jumps.size(); ++k) {
      run.hold(profile.jumps[k].duty_fraction);
      const double begin_s = profile.jumps[k].time_s;
      const double end_s = k + 1 < profile.jumps.size() ? profile.jumps[k + 1].time_s : profile.end_s;
      advance(run, end_s);
      for (const std::size_t j : coils) {
        // T(t) = T_inf + u V^2 / (R h) + (T(0) - T_inf - u V^2 / (R h)) exp(-t h / C).
        const double h = j == A ? 0.040 : 0.055, capacity = j == A ? 0.85 : 0.6, ohm = j == A ? 2.5 : 3.1;
        const double settled_degC = 21.0 + profile.jumps[k].duty_fraction[j] * 49.0 / (ohm * h);
        expected_degC[j] = settled_degC + (expected_degC[j] - settled_degC) * std::exp(-(end_s - begin_s) * h / capacity);
        worst_K = std::max(worst_K, std::abs(run.state()[j] - expected_degC[j]));
      }
    }
    INFO("worst ", worst_K);
    CHECK(worst_K < tolerance_K);
  }
}

TEST_CASE("how a wire's temperature depends on its parameters is the derivative of the exponential law") {
  const SensitivityRequest request{{parameter_id("supply_voltage_V"), parameter_id("resistance_A_Ohm"), parameter_id("heat_capacity_A_J_K"),
                                    parameter_id("heat_loss_A_W_K"), parameter_id("ambient_temperature_degC"),
                                    parameter_id("resistance_B_Ohm")},
                                   {StateId{core_state::temperature + A}}};
  std::vector<std::optional<double>> given(6);
  given[0] = 40.0;
  for (const Method method : methods) {
    Integrator run(default_plant(), Start{given, {}}, settings(method), request);
    run.hold({0.3, 0.0});
    for (const double t : {0.5, 3.0, 8.0}) {
      advance(run, t);
      // By hand, with e = exp(-t h / C), D = u V^2 / (R h): T = T_inf + D (1 - e) + (T_0 - T_inf) e.
      const double h = 0.040, C = 0.85, e = std::exp(-t * h / C), D = 0.3 * 49.0 / (2.5 * h);
      const double by_exponent = D - (40.0 - 25.0);  // -dT/de
      const std::vector<double> expected{2.0 * D / 7.0 * (1.0 - e),
                                         -D / 2.5 * (1.0 - e),
                                         -by_exponent * e * t * h / (C * C),
                                         -D / h * (1.0 - e) + by_exponent * e * t / C,
                                         1.0 - e,
                                         0.0,
                                         e};
      const Eigen::MatrixXd measured = run.state_sensitivity();
      REQUIRE(measured.cols() == 7);
      for (std::size_t k = 0; k < expected.size(); ++k) {
        CAPTURE(k);
        // Steps are chosen for the temperature alone, to 1.5e-7 of 50 K as above; the sensitivities' equations are as smooth.
        CHECK(measured(0, static_cast<Eigen::Index>(k)) == doctest::Approx(expected[k]).epsilon(1e-5).scale(std::abs(expected[k]) + 1e-9));
      }
    }
  }
}

TEST_CASE("a thermocouple behind its bead reads the answer of two time constants") {
  for (const Method method : methods) {
    Integrator run(limb_with("thermocouple_lag", {{"time_constant_s", 1.5}}), Start{}, settings(method));
    run.hold({0.4, 0.0});
    for (const double t : {0.2, 1.0, 4.0, 12.0}) {
      advance(run, t);
      const double wire_s = 0.85 / 0.04, bead_s = 1.5, rise_K = 0.4 * 49.0 / (2.5 * 0.04);
      const double expected_degC =
          25.0 + rise_K * (1.0 - (wire_s * std::exp(-t / wire_s) - bead_s * std::exp(-t / bead_s)) / (wire_s - bead_s));
      CHECK(std::abs(run.readings()[A] - expected_degC) < tolerance_K);
    }
  }
}

TEST_CASE("two wires that heat each other: their mean knows nothing of it, their difference decays faster") {
  std::vector<std::optional<double>> given(6);
  given[0] = 90.0;
  given[1] = 40.0;
  for (const Method method : methods) {
    Integrator run(limb_with("cross_heating", {{"conductance_W_K", 0.02}}), Start{given, {}}, settings(method));
    for (const double t : {1.0, 5.0, 15.0}) {
      advance(run, t);
      const double mean_K = 40.0 * std::exp(-t * 0.04 / 0.85);        // by hand: C dM/dt = -h M
      const double difference_K = 50.0 * std::exp(-t * 0.08 / 0.85);  // C dD/dt = -(h + 2 G) D
      CHECK(std::abs(run.state()[0] - (25.0 + mean_K + 0.5 * difference_K)) < tolerance_K);
      CHECK(std::abs(run.state()[1] - (25.0 + mean_K - 0.5 * difference_K)) < tolerance_K);
    }
  }
}

TEST_CASE("a cold limb that is bent by hand and let go springs back as its two rates say") {
  // Cold wires, held inside their loops at 0.995: both coils are linear springs of 114 N/m with arms of 6 mm.
  std::vector<std::optional<double>> given(6);
  given[2] = given[3] = 0.995;
  given[4] = 0.3;
  const double stiffness = 0.05 + 2.0 * 0.006 * 0.006 * (313.0 - 0.995 * 200.0), damping = 0.004, inertia = 2.0e-5;
  const double root = std::sqrt(damping * damping - 4.0 * inertia * stiffness);
  const double slow_1_s = (-damping + root) / (2.0 * inertia), fast_1_s = (-damping - root) / (2.0 * inertia);
  for (const Method method : methods) {
    Integrator run(default_plant(), Start{given, {}}, settings(method));
    for (const double t : {0.002, 0.01, 0.05, 0.2}) {
      advance(run, t);
      // theta = 0.3 (s_fast e^(s_slow t) - s_slow e^(s_fast t)) / (s_fast - s_slow): at rest at first.
      const double expected_rad = 0.3 * (fast_1_s * std::exp(slow_1_s * t) - slow_1_s * std::exp(fast_1_s * t)) / (fast_1_s - slow_1_s);
      CHECK(std::abs(run.state()[4] - expected_rad) < 1e-7);  // a hundred steps of 1e-9 rad
    }
  }
}

}  // namespace validation_heating_test
