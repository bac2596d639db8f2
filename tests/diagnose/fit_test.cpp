// SPDX-License-Identifier: Apache-2.0
#include "diagnose/fit.h"

#include <doctest/doctest.h>

#include "diagnose/calibrate.h"
#include "plant/contains.h"
#include "sim/plant_file.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_fit_test {

using namespace sinew;

namespace {

std::vector<double> jacobian_at(const diagnose::FitProblem& problem, const std::vector<double>& z) {
  std::vector<double> residuals(problem.residual_count()), jacobian(problem.residual_count() * z.size());
  REQUIRE(problem.evaluate(z.data(), residuals.data(), jacobian.data()));
  return jacobian;
}

// Relative difference of a column of the Jacobian from central differences, over the rows' norm.
double column_off(const diagnose::FitProblem& problem, const std::vector<double>& z, const std::vector<double>& jacobian, std::size_t u,
                  double step) {
  const auto rows = problem.residual_count(), columns = z.size();
  std::vector<double> low(rows), high(rows);
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
  return std::sqrt(difference / size);
}

double worst_column(const diagnose::FitProblem& problem, const std::vector<double>& z) {
  const std::vector<double> jacobian = jacobian_at(problem, z);
  double worst = 0.0;
  for (std::size_t u = 0; u < z.size(); ++u) {
    const double off = column_off(problem, z, jacobian, u, 1e-4);
    INFO(problem.unknowns()[u].name);
    CHECK(off < 5e-3);
    worst = std::max(worst, off);
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

TEST_CASE("fit: what has grown since the first recording is open where a later one begins" * long_when_sanitized) {
  const sim::Recording first = testing::recorded(testing::babbling(15.0)), second = testing::recorded(testing::babbling(15.0));
  plant::Plant limb = plant::default_plant();
  for (const char* strength : {"ambient_drift.rate_K_s", "angle_sensor_drift.rate_deg_s", "fatigue.loss_per_cycle"})
    limb.set_in_file_units(testing::parameter(strength), 0.01);
  limb.turn_on_by_strength();
  const auto unknowns_of = [&](const std::vector<diagnose::FitData>& data, diagnose::StartPolicy start) {
    const diagnose::FitProblem problem(limb, diagnose::fittable_parameters(limb), data, start, {});
    std::vector<std::string> names;
    for (const auto& unknown : problem.unknowns()) names.push_back(unknown.name);
    return names;
  };
  const auto of = [](const sim::Recording& r) { return diagnose::FitData{&r, r.samples.size(), testing::paper_noise}; };
  const auto both = unknowns_of({of(first), of(second)}, diagnose::StartPolicy::estimated);
  const auto one = unknowns_of({of(first)}, diagnose::StartPolicy::estimated);
  const auto resting = unknowns_of({of(first), of(second)}, diagnose::StartPolicy::at_rest);
  for (const std::string state : {"ambient_drift.elapsed_s", "angle_sensor_drift.elapsed_s", "fatigue.cycles_A", "fatigue.cycles_B"}) {
    INFO(state);
    CHECK(contains(both, "start[1]." + state));
    CHECK_FALSE(contains(both, "start[0]." + state));
    CHECK_FALSE(contains(one, "start." + state));
    CHECK(contains(resting, "start[1]." + state));
  }
  CHECK(contains(both, "start[0].temperature_A_degC"));
  CHECK_FALSE(contains(resting, "start[1].temperature_A_degC"));

  const diagnose::FitProblem problem(limb, diagnose::fittable_parameters(limb), {of(first), of(second)}, diagnose::StartPolicy::estimated,
                                     {plant::Method::arkode, 1e-10});
  std::vector<double> z(problem.unknowns().size());
  for (std::size_t u = 0; u < z.size(); ++u) z[u] = 0.03 * (u % 3) - 0.02;
  const std::vector<double> jacobian = jacobian_at(problem, z);
  for (std::size_t u = 0; u < z.size(); ++u)
    if (problem.unknowns()[u].name.starts_with("start[1].") && problem.unknowns()[u].name.find("temperature") == std::string::npos &&
        problem.unknowns()[u].name.find("martensite") == std::string::npos) {
      INFO(problem.unknowns()[u].name);
      CHECK(column_off(problem, z, jacobian, u, 1e-2) < 1e-3);
    }
}

TEST_CASE("fit: where recordings say when they were made, the time since the first one is known") {
  sim::Recording first = testing::recorded(testing::babbling(15.0)), second = first, later = first;
  first.time_zero_s = 1000.0, second.time_zero_s = 1200.0, later.time_zero_s = 90000.0;
  plant::Plant limb = plant::default_plant();
  for (const char* strength : {"ambient_drift.rate_K_s", "angle_sensor_drift.rate_deg_s", "fatigue.loss_per_cycle"})
    limb.set_in_file_units(testing::parameter(strength), 0.01);
  limb.turn_on_by_strength();
  const plant::States states = limb.states();
  const auto of = [](const sim::Recording& r) { return diagnose::FitData{&r, r.samples.size(), testing::paper_noise}; };
  const diagnose::FitProblem problem(limb, {}, {of(first), of(second), of(later)}, diagnose::StartPolicy::estimated, {});
  std::vector<std::string> names;
  for (const auto& unknown : problem.unknowns()) names.push_back(unknown.name);
  const std::vector<double> z(names.size(), 0.0);
  for (const plant::StateId i : states.ids()) {
    if (states[i].at_start != plant::AtStart::elapsed) continue;
    INFO(states[i].key);
    CHECK_FALSE(contains(names, "start[1]." + states[i].key));
    CHECK(problem.start_at(z.data(), 0).given[i.index].value() == 0.0);
    CHECK(problem.start_at(z.data(), 1).given[i.index].value() == 200.0);
    // A day later no straight line is believed any more.
    CHECK(contains(names, "start[2]." + states[i].key));
  }
  CHECK(contains(names, "start[1].fatigue.cycles_A"));

  // Of one that is not the first, as where a plant is judged on a held-out recording.
  const diagnose::FitProblem held_out(limb, {}, {of(second)}, {diagnose::StartPolicy::at_rest, 1000.0}, {});
  plant::StateId room{};
  for (const plant::StateId i : states.ids())
    if (states[i].key == "ambient_drift.elapsed_s") room = i;
  CHECK(held_out.start_at(nullptr, 0).given[room.index].value() == 200.0);
  second.time_zero_s.reset();
  const diagnose::FitProblem unknown_time(limb, {}, {of(second)}, {diagnose::StartPolicy::at_rest, 1000.0}, {});
  CHECK_FALSE(unknown_time.start_at(nullptr, 0).given[room.index]);
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
  // The prior is log-normal about 0.04 W/K, and 0.02 W/K, half of that, its deviation.
  CHECK(problem.plant_at(&z).get(testing::parameter("heat_loss_A_W_K")) ==
        doctest::Approx(0.04 * std::exp(0.7 * std::sqrt(std::log(1.25)))).epsilon(1e-12));
}

TEST_CASE("fit: at a bound, rounding leaves no parameter outside the range of a plant file") {
  const sim::Recording recording = testing::recorded(testing::babbling(2.0));
  plant::Plant limb = plant::default_plant();
  limb.set_in_file_units(testing::parameter("beam_damping_Nms_rad"), 0.0017);
  const diagnose::FitProblem problem(limb, diagnose::fittable_parameters(limb), {{&recording, 20, testing::paper_noise}},
                                     diagnose::StartPolicy::at_rest, {plant::Method::arkode, 1e-6});
  for (const bool low : {true, false}) {
    std::vector<double> z;
    for (const auto& unknown : problem.unknowns()) z.push_back(unknown.coordinate_of(low ? unknown.lowest : unknown.highest));
    const std::string yaml = sim::plant_to_yaml(problem.plant_at(z.data()));
    CHECK_NOTHROW(sim::read_plant(sim::parse_yaml(yaml, "plant.yaml"), "."));
  }
}

TEST_CASE("fit: twice as much of what is positive is believed as easily as half; a temperature may lie on either side of zero") {
  const testing::FittedCore limb(testing::babbling(20.0));
  const diagnose::FitProblem problem(plant::default_plant(), diagnose::fittable_parameters(plant::default_plant()), limb.data,
                                     diagnose::StartPolicy::at_rest, limb.settings.numerics);
  for (const diagnose::Unknown& unknown : problem.unknowns()) {
    CAPTURE(unknown.name);
    const bool positive = unknown.name.find("degC") == std::string::npos && unknown.name.find("angle_offset") == std::string::npos &&
                          unknown.name.find("stretch") == std::string::npos;
    CHECK((unknown.log_deviation > 0.0) == positive);
    if (positive) CHECK(unknown.coordinate_of(2.0 * unknown.centre) == doctest::Approx(-unknown.coordinate_of(0.5 * unknown.centre)));
    for (const double z : {-1.5, 0.0, 2.0}) {
      CHECK(unknown.coordinate_of(unknown.value_at(z)) == doctest::Approx(z));
      CHECK((unknown.value_at(z + 1e-6) - unknown.value_at(z - 1e-6)) / 2e-6 == doctest::Approx(unknown.slope_at(z)).epsilon(1e-6));
    }
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
    return std::pair{of.unknowns()[0].log_deviation, of.unknowns()[1].log_deviation};
  };
  const auto core = deviations(plant::default_plant());
  const auto with = deviations(diagnose::with_effect(plant::default_plant(), testing::effect("junction")));
  CHECK(with.first == 2.0 * core.first);
  CHECK(with.second == core.second);

  // What the plant file knows of this limb takes its place; and is not made wider by what hides it.
  plant::Plant known = diagnose::with_effect(plant::default_plant(), testing::effect("junction"));
  known.set_in_file_units(capacity[0], 0.5);
  known.set_own_deviation(capacity[0], 0.1);
  CHECK(deviations(known).first == doctest::Approx(std::sqrt(std::log1p(0.04))));
  CHECK(deviations(known).second == core.second);
  known.set_own_deviation(capacity[0], 0.0);
  known.set_own_deviation(id("supply_voltage_V"), 0.35);
  const std::vector<plant::ParameterId> fitted = diagnose::fittable_parameters(known);
  CHECK(std::count(fitted.begin(), fitted.end(), capacity[0]) == 0);
  CHECK(std::count(fitted.begin(), fitted.end(), id("supply_voltage_V")) == 1);
}

}  // namespace diagnose_fit_test
