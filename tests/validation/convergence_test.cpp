// SPDX-License-Identifier: Apache-2.0
// Both solvers against each other, against a method that shares nothing with them, and against their tolerance.
#include "plant/integrator.h"
#include "tests/long_when_sanitized.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"
#include "tests/validation/runge_kutta.h"

namespace validation_convergence_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

const std::vector<double> sample_times_s = sample_times_between_jumps(36.0);

std::vector<std::vector<double>> states(const Plant& limb, Method method, double tolerance) {
  Integrator run(limb, Start{}, {.method = method, .relative_tolerance = tolerance, .most_steps = 1000000});
  std::vector<std::vector<double>> all;
  drive(run, babbling_profile(), sample_times_s, [&](std::size_t) { all.push_back(run.state()); });
  return all;
}

// Differences of all states at all samples, as shares of the states' scales.
struct Distance {
  double largest = 0.0, mean_square = 0.0;
};
Distance distance(const Plant& limb, const std::vector<std::vector<double>>& left, const std::vector<std::vector<double>>& right) {
  const States layout = limb.states();
  Distance result;
  REQUIRE(left.size() == right.size());
  for (std::size_t k = 0; k < left.size(); ++k)
    for (std::size_t i = 0; i < layout.size(); ++i) {
      const double d = std::abs(left[k][i] - right[k][i]) / layout[StateId{i}].scale;
      result.largest = std::max(result.largest, d);
      result.mean_square += d * d / static_cast<double>(left.size() * layout.size());
    }
  return result;
}

// Effects that came after the reference: on their own, for with them the others meet other corners.
constexpr std::array bodies{"sheath_heat_storage", "junction", "junction_layer"};
constexpr std::array filters{"driver_lag", "thermocouple_two_lags", "angle_sensor_second_order"};

Plant limb_of(const std::array<const char*, 3>& names) {
  Plant limb = default_plant();
  for (const char* name : names) turn_on_typical(limb, effect_id(name));
  return limb;
}

Plant limb_with_everything() {
  Plant limb = default_plant();
  for (const EffectId e : effects().ids())
    if (std::find(bodies.begin(), bodies.end(), effects()[e].name) == bodies.end() &&
        std::find(filters.begin(), filters.end(), effects()[e].name) == filters.end())
      turn_on_typical(limb, e);
  set_in_file_units(limb, "airflow_change.onset_s", 12.34);
  set_in_file_units(limb, "dry_friction.smoothing_rad_s", 0.5);  // so that the fixed step below is stable
  return limb;
}

}  // namespace

TEST_CASE("the error falls with the tolerance and stays within fifty times of it" * long_when_sanitized) {
  // A step is held to the tolerance. Some dozens of steps add up before a state forgets them, and a step over the corner of
  // an envelope is worse than it looks to the solver: that is the factor of 50. The angular velocity, which feels both most,
  // sets the largest error, twenty times the mean. Which corners a step meets is chance, so that a tolerance ten times
  // smaller may gain little, but not twice in a row. The estimate of ARKODE's method is of order three, so that its steps shorten
  // with the cube root of the tolerance, and below 1e-7, where that and not stability sets them, as many more add up.
  for (const Plant& limb : {default_plant(), limb_of(bodies), limb_of(filters), limb_with_everything()}) {
    const auto limit = states(limb, Method::cvode, 1e-12);
    for (const Method method : {Method::cvode, Method::arkode}) {
      double before = 1.0, before_that = 1.0;
      for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
        const Distance error = distance(limb, states(limb, method, tolerance), limit);
        const double mean = std::sqrt(error.mean_square);
        CAPTURE(method);
        CAPTURE(tolerance);
        const double steps = method == Method::arkode ? std::max(1.0, std::cbrt(1e-7 / tolerance)) : 1.0;
        CHECK(mean < 50.0 * steps * tolerance);
        CHECK(error.largest < 1000.0 * steps * tolerance);
        CHECK(mean < 0.2 * before_that);
        before_that = before;
        before = mean;
      }
    }
  }
}

TEST_CASE("both methods and a fixed step of Runge and Kutta go to one limit" * long_when_sanitized) {
  for (const Plant& limb : {default_plant(), limb_with_everything()}) {
    const auto cvode = states(limb, Method::cvode, 1e-11);
    CHECK(distance(limb, cvode, states(limb, Method::arkode, 1e-10)).largest < 1e-7);  // 1000 times the tolerance, as above
    const auto by_other_means = [&](double step_s) {
      std::vector<std::vector<double>> all;
      for (const Sample& sample : runge_kutta(limb, {}, babbling_profile(), sample_times_s, step_s)) all.push_back(sample.state);
      return all;
    };
    // Fixed steps go over the corners of the envelopes, which leaves an error of the square of the step.
    CHECK(distance(limb, cvode, by_other_means(1e-3)).largest < 1e-6);
    CHECK(distance(limb, cvode, by_other_means(2.5e-4)).largest < 6e-8);
  }
}

}  // namespace validation_convergence_test
