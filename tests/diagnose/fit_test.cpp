// SPDX-License-Identifier: Apache-2.0
#include "diagnose/fit.h"

#include <doctest/doctest.h>

#include "diagnose/calibrate.h"
#include "sim/plant_file.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_fit_test {

using namespace sinew;

namespace {

// Largest relative difference of a column from central differences, over the rows' norm.
double worst_column(const diagnose::FitProblem& problem, const std::vector<double>& z) {
  const auto rows = problem.residual_count(), columns = z.size();
  std::vector<double> residuals(rows), low(rows), high(rows);
  std::vector<double> jacobian(rows * columns);
  REQUIRE(problem.evaluate(z.data(), residuals.data(), jacobian.data()));
  double worst = 0.0;
  for (std::size_t u = 0; u < columns; ++u) {
    const double step = 1e-4;
    auto there = z;
    there[u] = z[u] + step;
    REQUIRE(problem.evaluate(there.data(), high.data(), nullptr));
    there[u] = z[u] - step;
    REQUIRE(problem.evaluate(there.data(), low.data(), nullptr));
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < rows; ++i) {
      const double slope = (high[i] - low[i]) / (2.0 * step);
      difference += std::pow(jacobian[i * columns + u] - slope, 2);
      size += slope * slope;
    }
    INFO(problem.unknowns()[u].name);
    CHECK(std::sqrt(difference / size) < 5e-3);
    worst = std::max(worst, std::sqrt(difference / size));
  }
  return worst;
}

}  // namespace

TEST_CASE("fit: the Jacobian over two recordings is that of differences, first values included" * long_when_sanitized) {
  const sim::Recording first = testing::recorded(testing::babbling(25.0)), second = testing::recorded(testing::babbling(15.0));
  plant::Plant limb = plant::default_plant();
  limb.set_in_file_units(testing::parameter("viscoelastic_creep.stiffness_Nm_rad"), 0.01);
  limb.turn_on_by_strength();
  const diagnose::FitProblem problem(limb, diagnose::fittable_parameters(limb),
                                     {{&first, first.samples.size(), testing::paper_noise}, {&second, 100, testing::paper_noise}},
                                     diagnose::StartPolicy::estimated, {plant::Method::arkode, 1e-10});
  std::vector<double> z(problem.unknowns().size());
  for (std::size_t u = 0; u < z.size(); ++u) z[u] = 0.03 * (u % 3) - 0.02;
  // Differences of step 1e-4 over corners of the hysteresis are good to some 1e-3.
  CHECK(worst_column(problem, z) > 0.0);
}

TEST_CASE("fit: missing samples have no row, and the last rows are the prior") {
  sim::Recording recording = testing::recorded(testing::babbling(10.0));
  recording.samples[5].channels[2] = std::nan("");
  const diagnose::FitProblem problem(plant::default_plant(), {testing::parameter("heat_loss_A_W_K")},
                                     {{&recording, 50, testing::paper_noise}}, diagnose::StartPolicy::at_rest,
                                     {plant::Method::cvode, 1e-8});
  CHECK(problem.rows().size() == 3 * 50 - 1);
  REQUIRE(problem.residual_count() == 150);
  const double z = 0.7;
  std::vector<double> residuals(150), jacobian(150);
  REQUIRE(problem.evaluate(&z, residuals.data(), jacobian.data()));
  CHECK(residuals.back() == 0.7);
  CHECK(jacobian.back() == 1.0);
  // One deviation of the prior is 0.02 W/K around 0.04.
  CHECK(problem.plant_at(&z).get(testing::parameter("heat_loss_A_W_K")) == doctest::Approx(0.054).epsilon(1e-12));
}

TEST_CASE("fit: at a bound, rounding leaves no parameter outside the range of a plant file") {
  const sim::Recording recording = testing::recorded(testing::babbling(2.0));
  plant::Plant limb = plant::default_plant();
  limb.set_in_file_units(testing::parameter("beam_damping_Nms_rad"), 0.0017);
  const diagnose::FitProblem problem(limb, diagnose::fittable_parameters(limb), {{&recording, 20, testing::paper_noise}},
                                     diagnose::StartPolicy::at_rest, {plant::Method::arkode, 1e-6});
  for (const bool low : {true, false}) {
    std::vector<double> z;
    for (const auto& unknown : problem.unknowns())
      z.push_back(((low ? unknown.lowest : unknown.highest) - unknown.centre) / unknown.deviation);
    const std::string yaml = sim::plant_to_yaml(problem.plant_at(z.data()));
    CHECK_NOTHROW(sim::read_plant(sim::parse_yaml(yaml, "plant.yaml"), "."));
  }
}

TEST_CASE("fit: a cooling midpoint above the heating midpoint costs, one below does not; an effect widens what it hides") {
  const testing::FittedCore limb(testing::babbling(20.0));
  const auto id = [](const char* key) { return testing::parameter(key); };
  const std::vector<plant::ParameterId> both{id("heating_midpoint_degC"), id("cooling_midpoint_degC")};
  const diagnose::FitProblem problem(plant::default_plant(), both, limb.data, diagnose::StartPolicy::at_rest, limb.settings.numerics);
  REQUIRE(problem.order_count() == 1);
  const std::vector<double> ordered{0.0, 0.0}, crossed{0.0, 1.6};  // 75 and 60 degC; 75 and 76
  CHECK(problem.order_residuals(ordered.data(), nullptr)(0) == 0.0);
  // A kelvin, in hundredths of a deviation of 10 K.
  CHECK(problem.order_residuals(crossed.data(), nullptr)(0) == doctest::Approx(10.0));
  diagnose::FitProblem::RowMajor slope;
  static_cast<void>(problem.order_residuals(crossed.data(), &slope));
  CHECK(slope(0, 0) == doctest::Approx(-100.0));
  CHECK(slope(0, 1) == doctest::Approx(100.0));
  CHECK(diagnose::FitProblem(plant::default_plant(), {both[1]}, limb.data, diagnose::StartPolicy::at_rest, limb.settings.numerics)
            .order_count() == 0);

  const std::vector<plant::ParameterId> capacity{id("heat_capacity_A_J_K"), id("beam_stiffness_Nm_rad")};
  const auto deviations = [&](const plant::Plant& plant) {
    const diagnose::FitProblem of(plant, capacity, limb.data, diagnose::StartPolicy::at_rest, limb.settings.numerics);
    return std::pair{of.unknowns()[0].deviation, of.unknowns()[1].deviation};
  };
  const auto core = deviations(plant::default_plant());
  const auto with = deviations(diagnose::with_effect(plant::default_plant(), testing::effect("junction")));
  CHECK(with.first == 2.0 * core.first);
  CHECK(with.second == core.second);
}

}  // namespace diagnose_fit_test
