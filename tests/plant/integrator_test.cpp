// SPDX-License-Identifier: Apache-2.0
#include "plant/integrator.h"

#include <stdexcept>

#include "tests/plant/limb/one_instant.h"

namespace plant_integrator_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("integrator: a run begins at rest, where what is held at the start acts") {
  const Plant limb = default_plant();
  const Integrator run(limb, Start{{}, {0.3, 0.0}}, {});
  CHECK(run.time_s() == 0.0);
  CHECK(run.state()[0] == 25.0);
  CHECK(run.state()[4] == 0.0);
  CHECK(at_one_instant(limb, run).now.joule_heat_W[A] == by_hand(5.88));
}

TEST_CASE("integrator: a duty that is commanded again unchanged is no jump") {
  Integrator run(default_plant(), Start{}, {});
  for (int tick = 0; tick < 10; ++tick) {
    run.hold({0.6, 0.0});
    REQUIRE_FALSE(run.advance_to(0.1 * (tick + 1)));
  }
  CHECK(run.counters().restarts == 1);
  run.hold({0.5, 0.0});
  REQUIRE_FALSE(run.advance_to(1.1));
  CHECK(run.counters().restarts == 2);
}

TEST_CASE("integrator: of two commands at one moment the later one holds") {
  const Plant limb = default_plant();
  Integrator run(limb, Start{}, {});
  run.hold({0.6, 0.0});
  run.hold({0.0, 0.2});
  CHECK(at_one_instant(limb, run).now.duty_fraction == std::vector<double>{0.0, 0.2});
  REQUIRE_FALSE(run.advance_to(1.0));
  CHECK(run.state()[0] == 25.0);
}

TEST_CASE("integrator: counters only grow, over restarts too, and say what was done") {
  for (const Method method : {Method::cvode, Method::arkode, Method::rosenbrock}) {
    Integrator run(default_plant(), Start{}, {.method = method});
    SolverCounters before = run.counters();
    for (int tick = 0; tick < 5; ++tick) {
      run.hold({0.1 * (tick + 1), 0.0});
      REQUIRE_FALSE(run.advance_to(0.5 * (tick + 1)));
      const SolverCounters now = run.counters();
      CHECK(now.steps > before.steps);
      CHECK(now.rhs_evaluations >= before.rhs_evaluations + (now.steps - before.steps));
      CHECK(now.restarts == before.restarts + 1);
      CHECK(now.error_test_failures >= before.error_test_failures);
      before = now;
    }
    CHECK((before.jacobian_evaluations > 0) == (method != Method::arkode));
  }
}

TEST_CASE("integrator: the automatic method is explicit for the core and implicit where dry friction is stiff") {
  const auto jacobians = [](const Plant& limb) {
    Integrator run(limb, Start{}, {.method = Method::automatic});
    run.hold({0.6, 0.0});
    REQUIRE_FALSE(run.advance_to(5.0));
    return run.counters().jacobian_evaluations;
  };
  CHECK(jacobians(default_plant()) == 1);  // the one by which it chose
  CHECK(jacobians(limb_with("dry_friction", {{"moment_Nm", 0.003}})) > 1);
}

// Ten seconds with a duty that changes every half second, and with what switches on at 4 s; a reading each tenth of a second.
std::vector<double> readings_of(const Plant& limb, const NumericalSettings& settings, SolverCounters* counters = nullptr) {
  Integrator run(limb, Start{}, settings);
  std::vector<double> all;
  for (int k = 1; k <= 100; ++k) {
    if (k % 5 == 1) run.hold({(k / 5) % 3 == 0 ? 0.7 : 0.0, (k / 5) % 4 == 1 ? 0.6 : 0.1});
    REQUIRE_FALSE(run.advance_to(0.1 * k));
    const std::vector<double> shown = run.readings();
    all.insert(all.end(), shown.begin(), shown.end());
  }
  if (counters) *counters = run.counters();
  return all;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST_CASE("integrator: the linearly implicit method agrees with CVODE, the better the closer its tolerance, on stiff limbs too") {
  for (const Plant& limb : {default_plant(), limb_with("dry_friction", {{"moment_Nm", 0.003}, {"smoothing_rad_s", 0.02}}),
                            limb_with("airflow_change", {{"relative_change", 1.0}, {"onset_s", 4.03}}),
                            limb_with("input_delay", {{"delay_s", 0.23}}), limb_with("ambient_drift", {{"rate_K_s", 0.5}})}) {
    const std::vector<double> exact = readings_of(limb, {.method = Method::cvode, .relative_tolerance = 1e-11});
    double before = 1e9;
    for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
      const double off = largest_difference(readings_of(limb, {.method = Method::rosenbrock, .relative_tolerance = tolerance}), exact);
      CHECK(off < 0.5 * before);
      before = off;
    }
    CHECK(before < 2e-5);
  }
}

TEST_CASE("integrator: the linearly implicit method takes steps that no fast mode limits, and few of them") {
  SolverCounters implicit, explicit_one;
  readings_of(default_plant(), {.method = Method::rosenbrock, .relative_tolerance = 1e-4}, &implicit);
  readings_of(default_plant(), {.method = Method::arkode, .relative_tolerance = 1e-4}, &explicit_one);
  CHECK(implicit.steps < 200);
  CHECK(explicit_one.steps > 3 * implicit.steps);
}

TEST_CASE("integrator: a run by the linearly implicit method is the same where it went on from a checkpoint") {
  const auto run_to = [](Integrator& run, int from, int to) {
    for (int k = from; k < to; ++k) {
      run.hold({k % 2 ? 0.6 : 0.0, 0.2});
      REQUIRE_FALSE(run.advance_to(0.5 * (k + 1)));
    }
  };
  const NumericalSettings settings{.method = Method::rosenbrock, .relative_tolerance = 1e-6};
  Integrator whole(default_plant(), Start{}, settings);
  run_to(whole, 0, 3);
  const Checkpoint taken = whole.checkpoint();
  run_to(whole, 3, 8);
  Integrator again(default_plant(), taken, settings);
  run_to(again, 3, 8);
  CHECK(again.state() == whole.state());
  CHECK(again.counters() == whole.counters());
}

TEST_CASE("integrator: a start that does not fit the limb is refused") {
  const Start start{std::vector<std::optional<double>>(7), {}};
  CHECK_THROWS_WITH_AS(Integrator(default_plant(), start, {}), "start must give one entry a state", std::invalid_argument);
}

TEST_CASE("integrator: a request that does not fit the limb is refused") {
  const auto with_request = [](const SensitivityRequest& request) { Integrator(default_plant(), Start{}, {}, request); };
  CHECK_THROWS_AS(with_request({{}, {StateId{0}}}), std::invalid_argument);                        // not given, so there is nothing to vary
  CHECK_THROWS_AS(with_request({{}, {StateId{99}}}), std::invalid_argument);                       // no such state
  CHECK_THROWS_AS(with_request({{ParameterId{parameters().size()}}, {}}), std::invalid_argument);  // no such parameter
}

TEST_CASE("integrator: to ask for sensitivities changes no reading by more than the tolerance") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    const NumericalSettings settings{.method = method};
    Integrator alone(default_plant(), Start{}, settings);
    Integrator asked(default_plant(), Start{}, settings, {{ParameterId{0}, ParameterId{5}, ParameterId{9}}, {}});
    for (Integrator* run : {&alone, &asked}) {
      run->hold({0.6, 0.0});
      REQUIRE_FALSE(run->advance_to(6.0));
    }
    std::vector<double> reading;
    Eigen::MatrixXd sensitivity;
    asked.readings_with_sensitivity(reading, sensitivity);
    CHECK(sensitivity.cols() == 3);
    CHECK(reading[A] == asked.readings()[A]);
    CHECK(reading[angle] == asked.readings()[angle]);
    // Steps may differ; each keeps to 1e-8, and some hundred of them add up.
    CHECK(std::abs(reading[angle] - alone.readings()[angle]) < 1e-6);
    CHECK(std::abs(reading[A] - alone.readings()[A]) < 1e-4);
  }
}

}  // namespace plant_integrator_test
