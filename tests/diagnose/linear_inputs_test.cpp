// SPDX-License-Identifier: Apache-2.0
// Fits of a plant that is no limb, and whose input changes steadily between samples: dx/dt = -a x + g u, x is measured.
#include <doctest/doctest.h>

#include <cmath>

#include "diagnose/calibrate.h"
#include "diagnose/explanation.h"
#include "diagnose/path.h"
#include "diagnose/state_noise.h"
#include "sim/random.h"
#include "sim/simulation.h"

namespace diagnose_linear_inputs_test {

using namespace sinew;

namespace {

template <class S>
class LagEquations final : public plant::Equations<S> {
 public:
  explicit LagEquations(const std::vector<S>& values) : rate_1_s_(values[0]), gain_(values[1]) {}
  void rates(const plant::Situation& given, const S* y, S* rates) override { rates[0] = -rate_1_s_ * y[0] + gain_ * given.input(0); }
  void readings(const S* y, S* readings) override { readings[0] = y[0]; }
  std::vector<S> rest(const plant::Situation& given, const std::vector<std::optional<S>>& known) override {
    return {known[0] ? *known[0] : gain_ * given.input(0) / rate_1_s_};
  }

 private:
  S rate_1_s_, gain_;
};

constexpr double rate_1_s = 0.8, gain = 2.0;

// No surroundings, no effects, no averaging.
class Lag final : public plant::System {
 public:
  explicit Lag(plant::Between between) {
    name_ = "lag";
    words_ = "the lag";
    inputs_.push_back(
        {.column = "u", .name = "u", .part = "u", .words = "u", .unit = plant::units::none, .range = {-10.0, 10.0}, .between = between});
    channels_.push_back({.column = "x",
                         .words = "x",
                         .unit_words = "",
                         .unit = plant::units::none,
                         .range = {-1e9, 1e9},
                         .noise = 0.01,
                         .step = 0.0,
                         .short_name = "x",
                         .kind = "x"});
    const auto parameter = [&](const char* name, double typical, double deviation) {
      parameters_.push_back({std::nullopt, "",
                             plant::Declaration{.name = name,
                                                .symbol = name,
                                                .unit = plant::units::none,
                                                .range = {0.01, 10.0},
                                                .typical = typical,
                                                .prior_deviation = deviation,
                                                .meaning = ""}});
    };
    parameter("rate_1_s", rate_1_s, 0.4);
    parameter("gain", gain, 1.0);
    entry_groups_.push_back({.name = "x", .words = "x", .unit = "1/s", .typical = 0.1, .correlation_time_s = 2.0, .begin = 0.05});
    entries_.push_back({.group = {0}, .state = plant::StateId{0}});
  }
  plant::States states(const plant::EffectsOn&) const override { return plant::States({{"x", plant::units::none, 1.0}}); }
  std::unique_ptr<plant::Equations<double>> equations(const std::vector<double>& values, const plant::EffectsOn&) const override {
    return std::make_unique<LagEquations<double>>(values);
  }
  std::unique_ptr<plant::Equations<plant::Jet>> equations(const std::vector<plant::Jet>& values, const plant::EffectsOn&) const override {
    return std::make_unique<LagEquations<plant::Jet>>(values);
  }
};

// x and its derivatives with respect to its first value and the gain, from sample to sample in closed form: along a ramp of
// slope s from u, with e = exp(-a h):  x' = e x + g (u (1 - e)/a + s (h/a - (1 - e)/a^2)).
struct Exact {
  double x, by_start = 1.0, by_gain = 0.0;
  void step(double h, double u, double slope) {
    const double e = std::exp(-rate_1_s * h), held = (1.0 - e) / rate_1_s, ramp = h / rate_1_s - (1.0 - e) / (rate_1_s * rate_1_s);
    x = e * x + gain * (u * held + slope * ramp);
    by_start *= e;
    by_gain = e * by_gain + u * held + slope * ramp;
  }
};

// Coarse samples, 0.2 to 0.6 s apart, of an input that is drawn anew at each; what is measured is 0.
sim::Recording drawn(const plant::System& system, std::size_t count) {
  sim::Recording recording{.name = "drawn", .columns = sim::columns_of(system)};
  const sim::RandomStream chance(4, "test.linear_inputs");
  double time_s = 3.0;
  for (std::size_t k = 0; k < count; ++k) {
    recording.samples.push_back({time_s, {2.0 * chance.uniform(2 * k) - 1.0}, {0.0}});
    time_s += 0.2 + 0.4 * chance.uniform(2 * k + 1);
  }
  return recording;
}

// visit(sample, Exact), for x = `first` at the first sample.
template <class Visit>
void each_exact(const sim::Recording& recording, bool linear, double first, Visit&& visit) {
  Exact exact{.x = first};
  const auto& samples = recording.samples;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    visit(k, exact);
    if (k + 1 == samples.size()) break;
    const double h = samples[k + 1].time_s - samples[k].time_s, u = samples[k].inputs[0];
    exact.step(h, u, linear ? (samples[k + 1].inputs[0] - u) / h : 0.0);
  }
}

}  // namespace

TEST_CASE("linear inputs: residuals and Jacobian of a fit are those of the closed form; and so where inputs are held") {
  for (const bool linear : {true, false}) {
    CAPTURE(linear);
    const plant::Plant plant(std::make_shared<Lag>(linear ? plant::Between::linear : plant::Between::held));
    const sim::Recording recording = drawn(plant.system(), 80);
    const diagnose::FitProblem problem(plant, {plant.system().parameter("gain")},
                                       {{&recording, recording.samples.size(), diagnose::per_channel(1, 0.1)}},
                                       diagnose::StartPolicy::estimated, {plant::Method::arkode, 1e-9});
    REQUIRE(problem.unknowns().size() == 2);
    const double z[] = {0.0, 0.6};
    const double first = problem.value(1, z[1]), start_deviation = problem.unknowns()[1].deviation,
                 gain_slope = problem.unknowns()[0].slope_at(z[0]);
    const std::size_t rows = problem.rows().size();
    REQUIRE(rows == 80);
    std::vector<double> residuals(problem.residual_count()), jacobian(2 * residuals.size());
    REQUIRE(problem.evaluate(z, residuals.data(), jacobian.data()));
    diagnose::Path path, plain;
    REQUIRE(diagnose::follow(problem, z, diagnose::Want::everything, path));
    REQUIRE(diagnose::follow(problem, z, diagnose::Want::residuals, plain));
    each_exact(recording, linear, first, [&](std::size_t k, const Exact& exact) {
      CAPTURE(k);
      for (const auto* found : {&residuals, &path.residuals, &plain.residuals}) CHECK(std::abs((*found)[k] - exact.x / 0.1) < 1e-5);
      CHECK(std::abs(jacobian[2 * k] - exact.by_gain * gain_slope / 0.1) < 1e-5);
      CHECK(std::abs(jacobian[2 * k + 1] - exact.by_start * start_deviation / 0.1) < 1e-5);
      // The path takes the input half-way for its mean. Where it is not held, a step of h is off by |u' - u| a h^2 / 12, 0.048 at
      // most; to take it as held would be off by |u' - u| h / 2, up to 0.6.
      CHECK(std::abs(path.jacobian[2 * k] - exact.by_gain * gain_slope / 0.1) < (linear ? 0.048 / 0.1 : 0.02));
      CHECK(std::abs(path.jacobian[2 * k + 1] - exact.by_start * start_deviation / 0.1) < 2e-3);
    });
  }
}

TEST_CASE("linear inputs: a plant that is no limb is calibrated, and explained with noise in its state") {
  const plant::Plant nominal(std::make_shared<Lag>(plant::Between::linear));
  plant::Plant other = nominal;
  other.set(other.system().parameter("rate_1_s"), 0.5);
  other.set(other.system().parameter("gain"), 2.6);
  sim::Recording recording = drawn(nominal.system(), 400);
  {
    plant::Integrator integrator(other, plant::Start{}, {});
    const sim::RandomStream chance(5, "test.noise");
    REQUIRE_FALSE(sim::replay(integrator, other.system(), recording.samples, [&](std::size_t k) {
      recording.samples[k].channels[0] = integrator.readings()[0] + 0.01 * chance.normal(k);
    }));
  }
  const std::vector<diagnose::FitData> data{{&recording, recording.samples.size(), diagnose::per_channel(1, 0.01)}};
  const auto calibration = diagnose::calibrate(nominal, data, {});
  REQUIRE(calibration.estimates.size() == 3);
  for (std::size_t p = 0; p < 2; ++p) {
    const diagnose::Estimate& e = calibration.estimates[p];
    INFO(e.unknown.name << " " << e.value << " +- " << e.standard_error);
    CHECK(std::abs(e.value - other.get(*e.unknown.parameter)) < 4.0 * e.standard_error);
    CHECK(e.standard_error < 0.01);
  }
  const diagnose::Explanation explained = diagnose::explain(nominal, data, {}, {});
  REQUIRE(explained.usable);
  for (std::size_t u = 0; u < 2; ++u)
    CHECK(std::abs(explained.value(u) - other.get(*explained.problem->unknowns()[u].parameter)) < 4.0 * explained.deviation(u));
  CHECK(explained.process_noise < 20.0);
}

}  // namespace diagnose_linear_inputs_test
