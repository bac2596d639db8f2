// SPDX-License-Identifier: Apache-2.0
// Inputs that change at a steady rate between samples, against the closed form of dx/dt = g u.
#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>

#include "plant/integrator.h"
#include "sim/simulation.h"

namespace plant_linear_inputs_test {

using namespace sinew::plant;
namespace sim = sinew::sim;

namespace {

template <class S>
class SumEquations final : public Equations<S> {
 public:
  explicit SumEquations(S gain) : gain_(gain) {}
  void rates(const Situation& given, const S*, S* rates) override {
    input_ = given.input(0);
    rates[0] = gain_ * input_;
  }
  void readings(const S* y, S* readings) override {
    readings[0] = y[0];
    readings[1] = S(input_);
  }
  std::vector<S> rest(const Situation&, const std::vector<std::optional<S>>& known) override { return {known[0].value_or(S(0.0))}; }

 private:
  S gain_;
  double input_ = 0.0;
};

// Adds up one input: x, with a channel for x and one that shows the input itself.
class Sum final : public System {
 public:
  explicit Sum(Between between) {
    name_ = "sum";
    words_ = "the sum";
    inputs_.push_back(
        {.column = "u", .name = "u", .part = "u", .words = "u", .unit = units::none, .range = {-10.0, 10.0}, .between = between});
    for (const char* column : {"x", "shown_u"}) {
      ChannelInfo info{};
      info.column = column;
      info.unit = units::none;
      info.range = {-1e9, 1e9};
      channels_.push_back(info);
    }
    parameters_.push_back(
        {std::nullopt, "",
         Declaration{.name = "gain", .symbol = "g", .unit = units::none, .range = {0.0, 10.0}, .typical = 2.0, .meaning = ""}});
  }
  States states(const EffectsOn&) const override { return States({{"x", units::none, 1.0}}); }
  std::unique_ptr<Equations<double>> equations(const std::vector<double>& values, const EffectsOn&) const override {
    return std::make_unique<SumEquations<double>>(values[0]);
  }
  std::unique_ptr<Equations<Jet>> equations(const std::vector<Jet>& values, const EffectsOn&) const override {
    return std::make_unique<SumEquations<Jet>>(values[0]);
  }
};

constexpr Method methods[] = {Method::cvode, Method::arkode};
// One state of scale 1 at 1e-9 a step, some dozens of steps.
constexpr double tolerance = 1e-7;

}  // namespace

TEST_CASE("linear inputs: an input that rises steadily adds up to a parabola") {
  for (const Method method : methods) {
    Integrator run(Plant(std::make_shared<Sum>(Between::linear)), Start{}, {.method = method, .relative_tolerance = 1e-9});
    run.hold({0.5}, {1.5});
    for (const double t : {0.1, 0.7, 2.0}) {
      REQUIRE_FALSE(run.advance_to(t));
      CHECK(std::abs(run.state()[0] - 2.0 * (0.5 * t + 0.75 * t * t)) < tolerance);  // by hand: g (u t + s t^2 / 2)
      CHECK(run.readings()[1] == doctest::Approx(0.5 + 1.5 * t).epsilon(1e-14));
    }
  }
}

TEST_CASE("linear inputs: the next command counts from its own moment, and without slopes an input is held again") {
  for (const Method method : methods) {
    Integrator run(Plant(std::make_shared<Sum>(Between::linear)), Start{}, {.method = method, .relative_tolerance = 1e-9});
    run.hold({0.0}, {1.0});
    REQUIRE_FALSE(run.advance_to(1.0));
    run.hold({1.0}, {-2.0});
    REQUIRE_FALSE(run.advance_to(2.0));
    CHECK(run.readings()[1] == doctest::Approx(-1.0).epsilon(1e-14));
    CHECK(std::abs(run.state()[0] - 2.0 * 0.5) < tolerance);  // by hand: 1/2 up to 1 s, then 1 - 1 = 0
    run.hold({-1.0});
    REQUIRE_FALSE(run.advance_to(4.0));
    CHECK(run.readings()[1] == -1.0);
    CHECK(std::abs(run.state()[0] - 2.0 * (0.5 - 2.0)) < tolerance);
  }
}

TEST_CASE("linear inputs: a sensitivity follows the ramp") {
  for (const Method method : methods) {
    Integrator run(Plant(std::make_shared<Sum>(Between::linear)), Start{}, {.method = method, .relative_tolerance = 1e-9},
                   {{ParameterId{0}}, {}});
    run.hold({0.5}, {1.5});
    REQUIRE_FALSE(run.advance_to(2.0));
    CHECK(std::abs(run.state_sensitivity()(0, 0) - 4.0) < tolerance);  // by hand: 0.5 * 2 + 0.75 * 2^2 a unit of gain
  }
}

TEST_CASE("linear inputs: a replay goes from sample to sample along straight lines, where the System says so, or holds") {
  // Uneven samples of u = 3 - t: trapezoids are exact.
  std::vector<sim::Sample> samples;
  for (const double t : {10.0, 10.5, 10.75, 12.0, 13.0}) samples.push_back({t, {13.0 - t}, {NAN, NAN}});
  for (const Method method : methods)
    for (const Between between : {Between::linear, Between::held}) {
      const Plant plant(std::make_shared<Sum>(between));
      Integrator run(plant, Start{}, {.method = method, .relative_tolerance = 1e-9});
      double held = 0.0;
      const auto failure = sim::replay(run, plant.system(), samples, [&](std::size_t k) {
        const double t = samples[k].time_s - 10.0;
        const double sum = between == Between::linear ? 3.0 * t - 0.5 * t * t : held;
        CAPTURE(k);
        CHECK(std::abs(run.state()[0] - 2.0 * sum) < tolerance);
        if (k > 0 && between == Between::linear) CHECK(run.readings()[1] == doctest::Approx(3.0 - t).epsilon(1e-14).scale(1.0));
        if (k + 1 < samples.size()) held += samples[k].inputs[0] * (samples[k + 1].time_s - samples[k].time_s);
      });
      CHECK_FALSE(failure.has_value());
    }
}

TEST_CASE("linear inputs: a checkpoint on the way is refused, since it would forget the slope; once held it can be taken") {
  const Plant plant(std::make_shared<Sum>(Between::linear));
  Integrator run(plant, Start{}, {});
  run.hold({0.0}, {1.0});
  REQUIRE_FALSE(run.advance_to(1.0));
  CHECK_THROWS_WITH_AS(run.checkpoint(), "a checkpoint cannot be taken while an input changes steadily", std::logic_error);
  run.hold({1.0});
  CHECK(run.checkpoint().held_inputs == std::vector<double>{1.0});
}

TEST_CASE("linear inputs: as many slopes as inputs") {
  Integrator run(Plant(std::make_shared<Sum>(Between::linear)), Start{}, {});
  CHECK_THROWS_AS(run.hold({1.0}, {1.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(run.hold({1.0, 2.0}), std::invalid_argument);
}

}  // namespace plant_linear_inputs_test
