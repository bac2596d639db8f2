// SPDX-License-Identifier: Apache-2.0
#include "diagnose/path.h"

#include <doctest/doctest.h>

#include "diagnose/calibrate.h"
#include "diagnose/explanation.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"
#include "tests/plant/limb/general.h"

namespace diagnose_path_test {

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
  for (const double delay_s : {0.237, 0.2}) {  // between samples, and at one
    late.set(testing::parameter("input_delay.delay_s"), delay_s);
    CHECK(worst_difference(late, recording) < 0.05);
  }
}

namespace {

// The two-segment limb with lags, creep and bodies that store heat.
plant::Plant large_plant() {
  plant::Plant plant = test::plant_of(test::two_segments);
  for (const char* effect : {"thermocouple_lag", "viscoelastic_creep", "body_heat_storage", "sheath_heat_storage"}) {
    plant = diagnose::with_effect(plant, plant.system().effect(effect));
    const plant::ParameterId strength = plant.system().effects()[plant.system().effect(effect)].strength;
    plant.set_in_file_units(strength, plant.system().parameters()[strength].declaration.typical);
  }
  return plant;
}

double norm_of_column(const std::vector<double>& columns, std::size_t count, std::size_t column) {
  double sum = 0.0;
  for (std::size_t i = column; i < columns.size(); i += count) sum += columns[i] * columns[i];
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("path: of more states than are unrolled, its sensitivities are those of differences, first values included" *
          long_when_sanitized) {
  const plant::Plant plant = large_plant();
  REQUIRE(plant.states().size() > 16);
  const sim::Recording whole = testing::recorded(testing::babbling(30.0, plant));
  sim::Recording recording = whole;  // begins in mid-motion
  recording.samples.erase(recording.samples.begin(), recording.samples.begin() + 100);
  const diagnose::FitProblem problem(plant, diagnose::fittable_parameters(plant),
                                     testing::data_of(recording, diagnose::noise_of(plant.system(), recording)),
                                     diagnose::StartPolicy::estimated, {plant::Method::arkode, 1e-9});
  const std::size_t n = problem.unknowns().size();
  std::vector<double> z(n, 0.0), low(problem.residual_count()), high(low), exact(low.size() * n);
  // At other points the columns of coil D, hardly driven and so a hundredth as long, are off by up to a tenth.
  for (std::size_t u = 0; u < n; ++u) z[u] = 0.02 * static_cast<double>(u % 3) - 0.02;
  diagnose::Path path;
  REQUIRE(diagnose::follow(problem, z.data(), diagnose::Want::everything, path));
  REQUIRE(path.jacobian.size() == problem.rows().size() * n);
  REQUIRE(problem.evaluate(z.data(), low.data(), exact.data()));
  for (std::size_t u = 0; u < n; ++u) {
    constexpr double step = 1e-3;
    std::vector<double> there = z;
    there[u] = z[u] + step;
    REQUIRE(problem.evaluate(there.data(), high.data(), nullptr));
    there[u] = z[u] - step;
    REQUIRE(problem.evaluate(there.data(), low.data(), nullptr));
    double from_exact = 0.0, from_slope = 0.0, size = 0.0;
    for (std::size_t i = 0; i < problem.rows().size(); ++i) {
      const double slope = (high[i] - low[i]) / (2.0 * step);
      from_exact += std::pow(path.jacobian[i * n + u] - exact[i * n + u], 2);
      from_slope += std::pow(path.jacobian[i * n + u] - slope, 2);
      size += std::pow(exact[i * n + u], 2);
    }
    INFO(problem.unknowns()[u].name);
    CHECK(std::sqrt(from_exact) < 0.05 * std::sqrt(size));
    // The integrator's tolerance leaves about 1 in a difference; most columns are some thousands long.
    CHECK(std::sqrt(from_slope) < 0.05 * std::sqrt(size) + 3.0);
  }
}

TEST_CASE("path: columns of parameters that are not fitted are those they would have if they were") {
  const plant::Plant plant = large_plant();
  const sim::Recording recording = testing::recorded(testing::babbling(20.0, plant));
  const std::vector<plant::ParameterId> all = diagnose::fittable_parameters(plant);
  const auto data = testing::data_of(recording, diagnose::noise_of(plant.system(), recording));
  const auto problem_with = [&](const std::vector<plant::ParameterId>& parameters) {
    return diagnose::FitProblem(plant, parameters, data, diagnose::StartPolicy::at_rest, {plant::Method::arkode, 1e-7});
  };
  const diagnose::FitProblem of_all = problem_with(all), of_none = problem_with({});
  const std::vector<double> z(all.size(), 0.0);
  diagnose::Path path;
  REQUIRE(diagnose::follow(of_all, z.data(), diagnose::Want::everything, path));
  std::vector<double> columns;
  REQUIRE(diagnose::sensitivity_to(of_none, z.data(), plant, all, columns));
  REQUIRE(columns.size() == path.jacobian.size());
  for (std::size_t p = 0; p < all.size(); ++p) {
    INFO(plant.system().parameters()[all[p]].key());
    double difference = 0.0;
    const diagnose::Unknown& unknown = of_all.unknowns()[p];
    const auto& declared = plant.system().parameters()[all[p]].declaration;
    const double per_z = unknown.slope_at(0.0) / (declared.prior_deviation * declared.unit.internal_per_unit);
    for (std::size_t i = p; i < columns.size(); i += all.size()) difference += std::pow(columns[i] * per_z - path.jacobian[i], 2);
    CHECK(std::sqrt(difference) <= 1e-9 * norm_of_column(path.jacobian, all.size(), p));
  }
}

TEST_CASE("path: an effect that goes on between recordings does so by their clock in the column of its strength") {
  sim::Recording first = testing::recorded(testing::babbling(20.0)), later = first;
  first.time_zero_s = 50.0, later.time_zero_s = 350.0;
  const plant::ParameterId rate = testing::parameter("ambient_drift.rate_K_s");
  const plant::Plant nominal = plant::default_plant();
  const std::vector<diagnose::FitData> data{{&first, first.samples.size(), testing::paper_noise},
                                            {&later, later.samples.size(), testing::paper_noise}};
  const plant::NumericalSettings numerics{plant::Method::arkode, 1e-8};
  const diagnose::FitProblem problem(nominal, {}, data, diagnose::StartPolicy::at_rest, numerics);
  plant::Plant warming = diagnose::with_effect(nominal, testing::effect("ambient_drift"));
  std::vector<double> columns;
  REQUIRE(diagnose::sensitivity_to(problem, nullptr, warming, {rate}, columns));
  // Against a difference: a rate of 1e-3 K/s, of both recordings, of which the second begins 0.3 K warmer.
  warming.set_in_file_units(rate, 1e-3);
  const diagnose::FitProblem other(warming, {}, data, diagnose::StartPolicy::at_rest, numerics);
  diagnose::Path without, with;
  REQUIRE(diagnose::follow(problem, nullptr, diagnose::Want::residuals, without));
  REQUIRE(diagnose::follow(other, nullptr, diagnose::Want::residuals, with));
  const double prior = testing::limb_system().parameters()[rate].declaration.prior_deviation;
  double off = 0.0, size = 0.0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double slope = (with.residuals[i] - without.residuals[i]) / 1e-3 * prior;
    off += std::pow(columns[i] - slope, 2), size += std::pow(slope, 2);
  }
  CHECK(std::sqrt(off) < 0.02 * std::sqrt(size));
}

}  // namespace diagnose_path_test
