// SPDX-License-Identifier: Apache-2.0
#include "diagnose/path.h"

#include <doctest/doctest.h>

#include "diagnose/calibrate.h"
#include "diagnose/explanation.h"
#include "tests/diagnose/one_limb.h"

using namespace sinew;

namespace {

// Largest difference of a column between the path's sensitivities and the integrator's own, relative to the column.
double worst_difference(const plant::Plant& limb, const sim::Recording& recording) {
  const diagnose::FitProblem problem(limb, diagnose::fittable_parameters(limb), testing::data_of(recording),
                                     diagnose::StartPolicy::estimated, {plant::Method::arkode, 1e-7});
  const std::size_t n = problem.unknowns().size();
  std::vector<double> z(n, 0.0), residuals(problem.residual_count()), exact(problem.residual_count() * n);
  REQUIRE(problem.evaluate(z.data(), residuals.data(), exact.data()));
  diagnose::Path path;
  REQUIRE(diagnose::follow(problem, z.data(), diagnose::Want::everything, path));
  double worst = 0.0;
  for (std::size_t u = 0; u < n; ++u) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < problem.rows().size(); ++i) {
      difference += std::pow(path.jacobian[i * n + u] - exact[i * n + u], 2);
      size += std::pow(exact[i * n + u], 2);
    }
    worst = std::max(worst, std::sqrt(difference / (size + 1e-12)));
  }
  for (std::size_t i = 0; i < problem.rows().size(); ++i) CHECK(path.residuals[i] == doctest::Approx(residuals[i]).epsilon(1e-3));
  return worst;
}

}  // namespace

TEST_CASE("path: its sensitivities are those of the integrator to a few per cent, and its residuals the same") {
  const sim::Recording recording = testing::recorded(testing::babbling(60.0));
  // A few per cent: the derivatives are taken as constant over each tenth of a second, and the hysteresis has corners.
  CHECK(worst_difference(plant::default_plant(), recording) < 0.05);
}

TEST_CASE("path: a parameter that moves the instant of a jump has its sensitivity too") {
  const sim::Recording recording = testing::recorded(testing::babbling(60.0));
  plant::Plant gust = diagnose::with_effect(plant::default_plant(), testing::effect("airflow_change"));
  gust.set(testing::parameter("airflow_change.relative_change"), 0.5);
  gust.set(testing::parameter("airflow_change.onset_s"), 20.03);
  CHECK(worst_difference(gust, recording) < 0.05);
  plant::Plant late = diagnose::with_effect(plant::default_plant(), testing::effect("input_delay"));
  late.set(testing::parameter("input_delay.delay_s"), 0.237);
  CHECK(worst_difference(late, recording) < 0.05);
}
