// SPDX-License-Identifier: Apache-2.0
// The two envelopes and loops within them, on ramps slow enough to be worked by hand.
#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"

namespace validation_hysteresis_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// A wire of large heat capacity, C/h = 500 s, so that a duty of 0.3 is a ramp of less than 0.3 K/s, and a transformation
// that follows its envelope in 5 ms.
constexpr double capacity_J_K = 20.0, loss_W_K = 0.04, duty = 0.3, follow_s = 0.005;
constexpr double settled_K = duty * 49.0 / (2.5 * loss_W_K);  // 147 K above ambient

Plant slow_limb() {
  Plant limb = default_plant();
  set(limb, "heat_capacity_A_J_K", capacity_J_K);
  set(limb, "transformation_time_s", follow_s);
  return limb;
}

double logistic(double temperature_degC, double midpoint_degC) { return 1.0 / (1.0 + std::exp((temperature_degC - midpoint_degC) / 7.0)); }

// The fraction that follows an envelope is late by the follow time, to first order; the next order is 1e-8.
double late_fraction(double temperature_degC, double midpoint_degC, double rate_K_s) {
  const double envelope = logistic(temperature_degC, midpoint_degC);
  return envelope + follow_s * rate_K_s * envelope * (1.0 - envelope) / 7.0;
}
constexpr double tolerance = 2e-7;  // second order in the follow time, and the solver's 1e-9 a step

// By hand: how long a wire takes from one temperature to the other at that duty.
double seconds_from_to(double from_degC, double to_degC, double at_duty) {
  const double aim_degC = 25.0 + at_duty / duty * settled_K;
  return capacity_J_K / loss_W_K * std::log((aim_degC - from_degC) / (aim_degC - to_degC));
}
double rate_K_s(double temperature_degC, double at_duty) { return (at_duty * 19.6 - loss_W_K * (temperature_degC - 25.0)) / capacity_J_K; }

class Ramp {
 public:
  explicit Ramp(Method method) : run_(slow_limb(), Start{}, {.method = method, .relative_tolerance = 1e-9}) {}
  // Heats or cools to that temperature; returns the fraction there.
  double to(double temperature_degC) {
    const double at_duty = temperature_degC > now_degC_ ? duty : 0.0;
    run_.hold({at_duty, 0.0});
    time_s_ += seconds_from_to(now_degC_, temperature_degC, at_duty);
    now_degC_ = temperature_degC;
    advance(run_, time_s_);
    CHECK(std::abs(run_.state()[0] - temperature_degC) < 1.5e-5);  // as in heating_test.cpp
    return run_.state()[2];
  }
  double stay(double seconds) {
    run_.hold({loss_W_K * (now_degC_ - 25.0) / 19.6, 0.0});
    time_s_ += seconds;
    advance(run_, time_s_);
    return run_.state()[2];
  }

 private:
  Integrator run_;
  double time_s_ = 0.0, now_degC_ = 25.0;
};

const double three_K = 7.0 * std::log(3.0);  // from a midpoint to where an envelope is a quarter or three quarters

}  // namespace

TEST_CASE("heated, the fraction is held until the heating envelope takes it down") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Ramp ramp(method);
    const double cold = logistic(25.0, 60.0);                      // at rest on the cooling envelope: 0.9933
    CHECK(ramp.to(39.0) == doctest::Approx(cold).epsilon(1e-12));  // by hand: the heating envelope passes it at 40 degC
    CHECK(std::abs(ramp.to(75.0 - three_K) - late_fraction(75.0 - three_K, 75.0, rate_K_s(75.0 - three_K, duty))) < tolerance);
    CHECK(std::abs(ramp.to(75.0) - 0.5) < 5e-5);  // 5 ms late at 0.2 K/s: 3.5e-5
    CHECK(std::abs(ramp.to(75.0 + three_K) - late_fraction(75.0 + three_K, 75.0, rate_K_s(75.0 + three_K, duty))) < tolerance);
    CHECK(std::abs(ramp.to(120.0) - late_fraction(120.0, 75.0, rate_K_s(120.0, duty))) < tolerance);
  }
}

TEST_CASE("cooled, the fraction is held until the cooling envelope takes it up") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Ramp ramp(method);
    const double hot = ramp.to(120.0);
    const double held = ramp.to(106.0);  // by hand: the cooling envelope passes logistic(45/7) at 60 + 45 = 105 degC
    CHECK(std::abs(held - hot) < 1e-6);  // the lag of the ramp up is made up for
    CHECK(std::abs(held - logistic(120.0, 75.0)) < 1e-6);
    CHECK(std::abs(ramp.to(60.0 + three_K) - late_fraction(60.0 + three_K, 60.0, rate_K_s(60.0 + three_K, 0.0))) < tolerance);
    CHECK(std::abs(ramp.to(60.0) - late_fraction(60.0, 60.0, rate_K_s(60.0, 0.0))) < tolerance);
    CHECK(std::abs(ramp.to(60.0 - three_K) - late_fraction(60.0 - three_K, 60.0, rate_K_s(60.0 - three_K, 0.0))) < tolerance);
  }
}

TEST_CASE("turned back in the middle, the fraction crosses the loop unchanged and goes on along the other envelope") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Ramp ramp(method);
    ramp.to(120.0);
    ramp.to(60.0);
    // Held at the cooling midpoint the fraction comes to its envelope, one half, in a few follow times.
    CHECK(std::abs(ramp.stay(1.0) - 0.5) < 2e-7);
    CHECK(std::abs(ramp.to(67.0) - 0.5) < 2e-7);
    CHECK(std::abs(ramp.to(74.0) - 0.5) < 2e-7);  // one kelvin before the heating envelope is at one half
    CHECK(std::abs(ramp.to(75.0 + three_K) - 0.25) < 5e-5);
    CHECK(std::abs(ramp.to(75.0 + three_K) - late_fraction(75.0 + three_K, 75.0, rate_K_s(75.0 + three_K, duty))) < tolerance);
    // And back: a quarter is held until the cooling envelope is at a quarter, 15 K below; three quarters lie beyond.
    CHECK(std::abs(ramp.stay(1.0) - 0.25) < 2e-7);
    CHECK(std::abs(ramp.to(60.0 + three_K + 1.0) - 0.25) < 2e-7);
    CHECK(std::abs(ramp.to(60.0 - three_K) - late_fraction(60.0 - three_K, 60.0, rate_K_s(60.0 - three_K, 0.0))) < tolerance);
    CHECK(std::abs(ramp.stay(1.0) - 0.75) < 2e-7);
  }
}

TEST_CASE("a fraction inside the loop stands still while the temperature stands or moves within the loop") {
  std::vector<std::optional<double>> given(6);
  given[0] = 68.0;
  given[2] = 0.5;
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(slow_limb(), Start{given, {}}, {.method = method});
    advance(run, 60.0);  // cools to 63 degC; the cooling envelope is at one half at 60 degC
    CHECK(run.state()[2] == 0.5);
  }
}

TEST_CASE("with minor loops the fraction follows a share of the envelope across the loop") {
  // Inside the loop and away from its edges the law integrates: xi = xi_0 + mu (envelope(T) - envelope(T_0)).
  Plant limb = slow_limb();
  turn_on(limb, "minor_loops", {{"slope_share", 0.2}});
  std::vector<std::optional<double>> given(6);
  given[0] = 66.0;
  given[2] = 0.45;
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(limb, Start{given, {}}, {.method = method, .relative_tolerance = 1e-9});
    run.hold({duty, 0.0});
    double time_s = seconds_from_to(66.0, 72.0, duty);
    advance(run, time_s);
    const double warmed = 0.45 + 0.2 * (logistic(72.0, 75.0) - logistic(66.0, 75.0));
    CHECK(std::abs(run.state()[2] - warmed) < tolerance);
    run.hold({0.0, 0.0});
    time_s += seconds_from_to(72.0, 64.0, 0.0);
    advance(run, time_s);
    const double cooled = warmed + 0.2 * (logistic(64.0, 60.0) - logistic(72.0, 60.0));
    CHECK(std::abs(run.state()[2] - cooled) < tolerance);
  }
}

}  // namespace validation_hysteresis_test
