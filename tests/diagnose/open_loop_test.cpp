// SPDX-License-Identifier: Apache-2.0
#include "diagnose/open_loop.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnose/score.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_open_loop_test {

using namespace sinew;
using diagnose::Explanation;
using diagnose::Fitted;

namespace {

sim::Scenario lagging_thermocouples() {
  sim::Scenario scenario = testing::babbling(60.0);
  scenario.plant = diagnose::with_effect(plant::default_plant(), testing::effect("thermocouple_lag"));
  scenario.plant.set(testing::parameter("thermocouple_lag.time_constant_s"), 2.5);
  return scenario;
}

// Folds whose error, in units of noise, is as given.
diagnose::FoldErrors folds_of(const std::vector<double>& errors) {
  diagnose::FoldErrors folds;
  for (const double error : errors) {
    folds.squares.push_back(diagnose::PerChannel({100.0, 100.0, 100.0 * error * error}));
    folds.noise.push_back(diagnose::per_channel(testing::limb_system(), 100.0));
  }
  return folds;
}

// A limb whose commands act 0.35 s late.
sim::Scenario driven_late() {
  sim::Scenario scenario = testing::babbling(40.0, diagnose::with_effect(plant::default_plant(), testing::effect("input_delay")));
  scenario.plant.set(testing::parameter("input_delay.delay_s"), 0.35);
  return scenario;
}

}  // namespace

TEST_CASE("open loop: a recording that is held out begins as far into a drift as its clock says") {
  sim::Recording held_out = testing::recorded(testing::babbling(20.0));
  plant::Plant warming = diagnose::with_effect(plant::default_plant(), testing::effect("ambient_drift"));
  warming.set_in_file_units(testing::parameter("ambient_drift.rate_K_s"), 0.01);
  const plant::States states = warming.states();
  plant::StateId room{};
  for (const plant::StateId i : states.ids())
    if (states[i].key == "ambient_drift.elapsed_s") room = i;
  diagnose::ExplanationSettings settings;
  settings.start = {diagnose::StartPolicy::estimated, 1000.0};
  held_out.time_zero_s = 1400.0;
  CHECK(diagnose::start_of(warming, held_out, testing::paper_noise, settings).given[room.index].value() == 400.0);
  settings.start.policy = diagnose::StartPolicy::at_rest;
  CHECK(diagnose::start_of(warming, held_out, testing::paper_noise, settings).given[room.index].value() == 400.0);
  // Where it does not say when it was made, its first seconds do: it was made where the first one was, and the room is as it was then.
  settings.start.policy = diagnose::StartPolicy::estimated;
  held_out.time_zero_s.reset();
  const plant::Start found = diagnose::start_of(warming, held_out, testing::paper_noise, settings);
  REQUIRE(found.given[room.index]);
  CHECK(std::abs(*found.given[room.index]) < 300.0);
  CHECK(*found.given[room.index] != 0.0);
}

TEST_CASE("open loop: where inputs act late, a recording says whether there was a command before it") {
  const sim::Recording all = testing::recorded(driven_late());
  const auto driven = [](const sim::Sample& sample) { return sample.inputs[0] + sample.inputs[1] > 0.3; };
  const auto from = [&](std::size_t first) {
    sim::Recording rest = all;
    rest.samples.erase(rest.samples.begin(), rest.samples.begin() + static_cast<std::ptrdiff_t>(first));
    return rest;
  };
  std::size_t first = 0;
  while (!driven(all.samples[first])) ++first;
  std::size_t held = first + 50;
  while (!driven(all.samples[held]) || all.samples[held].inputs != all.samples[held - 5].inputs) ++held;
  const sim::Recording whole = from(first), middle = from(held);
  const diagnose::ExplanationSettings settings;
  diagnose::Guess guess;
  guess.values["input_delay.delay_s"] = 0.3;
  const plant::Plant late = diagnose::with_effect(plant::default_plant(), testing::effect("input_delay"));
  for (const auto& [recording, idle] : std::map<const sim::Recording*, bool>{{&whole, true}, {&middle, false}}) {
    const Explanation found = diagnose::explain(late, testing::data_of(*recording), guess, settings);
    REQUIRE(found.usable);
    CHECK(found.model().get(testing::parameter("input_delay.delay_s")) == doctest::Approx(0.35).epsilon(0.03));
    CHECK((found.start(0).inputs.empty() == idle));
  }
}

TEST_CASE("open loop: the polished path is no further from the recording than the explanation's own") {
  const testing::FittedCore limb(lagging_thermocouples());
  REQUIRE(limb.core.usable);
  const Fitted polished = diagnose::polished(limb.core, limb.data, limb.settings);
  const auto& numerics = limb.settings.numerics;
  CHECK(diagnose::spread_of(polished, limb.data, numerics).log_sum <=
        diagnose::spread_of(diagnose::fitted(limb.core), limb.data, numerics).log_sum);
  // What is missing is far more than noise, whatever the core's parameters.
  CHECK(diagnose::spread_of(polished, limb.data, numerics).rmse[0][testing::temperature_A] >
        5.0 * testing::paper_noise[testing::temperature_A]);
}

TEST_CASE("open loop: least squares has no forcings, and says nothing of them") {
  const testing::FittedCore limb(lagging_thermocouples());
  auto least_squares = limb.settings;
  least_squares.least_squares = true;
  Explanation core = diagnose::explain(limb.core.problem->centres(), limb.data, limb.core.as_guess(), least_squares);
  REQUIRE(core.usable);
  CHECK(core.misfit == 0.0);
  CHECK(core.process_noise == 0.0);
  for (const double size : core.forcing) CHECK(size == 0.0);
  CHECK(core.log_likelihood < limb.core.log_likelihood - 1000.0);  // the lag is far more than noise
}

TEST_CASE("open loop: for how long errors stay alike is each recording's own") {
  const testing::FittedCore limb(lagging_thermocouples());
  sim::Scenario left_alone = lagging_thermocouples();
  left_alone.input = sim::OpenLoopInput{};
  const sim::Recording idle = testing::recorded(left_alone);
  plant::Plant warm = limb.core.model();
  const plant::ParameterId ambient = testing::parameter("ambient_temperature_degC");
  warm.set(ambient, warm.get(ambient) + 0.1);
  const Fitted one{limb.core, warm, {{}}}, both{limb.core, warm, {{}, {}}};
  std::vector<diagnose::FitData> data = limb.data;
  const auto alone = diagnose::samples_alike_of(one, data, limb.settings.numerics);
  data.push_back(testing::data_of(idle).front());
  const auto beside = diagnose::samples_alike_of(both, data, limb.settings.numerics);
  for (const plant::ChannelId c : alone[0].ids()) CHECK(beside[0][c] == alone[0][c]);
  CHECK(beside[1][testing::temperature_A] > 1.5 * beside[0][testing::temperature_A]);
}

TEST_CASE("open loop: a path's values, with intervals that take its errors as they are") {
  const testing::FittedCore limb(lagging_thermocouples());
  const Fitted polished = diagnose::polished(limb.core, limb.data, limb.settings);
  const Explanation values = diagnose::as_fitted(polished, limb.data, limb.settings);
  REQUIRE(values.usable);
  const plant::Plant model = values.model();
  for (const plant::ParameterId p : values.problem->parameters()) CHECK(model.get(p) == polished.model.get(p));
  // Errors that last for seconds leave more open than as many independent ones of the same size, which `polished` takes them for.
  // What is known little better than before is left as it was.
  double largest = 0.0;
  for (std::size_t u = 0; u < values.problem->parameters().size(); ++u) {
    CHECK(values.deviation(u) > 0.99 * polished.of.deviation(u));
    largest = std::max(largest, values.deviation(u) / polished.of.deviation(u));
  }
  CHECK(largest > 1.3);
}

TEST_CASE("open loop: cross-validation prefers the right plant, and asks of every sample once" * long_when_sanitized) {
  const testing::FittedCore limb(lagging_thermocouples());
  const Fitted core = diagnose::polished(limb.core, limb.data, limb.settings);
  auto least_squares = limb.settings;
  least_squares.least_squares = true;
  const Explanation right = diagnose::explain(diagnose::with_effect(limb.core.problem->centres(), testing::effect("thermocouple_lag")),
                                              limb.data, {{{"thermocouple_lag.time_constant_s", 2.0}}, {}}, least_squares);
  REQUIRE(right.usable);
  const auto without = diagnose::cross_validated(core, limb.data, 2, limb.settings),
             with = diagnose::cross_validated(diagnose::fitted(right), limb.data, 1, limb.settings);
  CHECK(diagnose::gain_of(without, with).beyond_chance());
  CHECK_FALSE(diagnose::gain_of(with, without).beyond_chance());
  double squares = 0.0, noise = 0.0, samples = 0.0;
  for (std::size_t f = 0; f < with.squares.size(); ++f)
    squares += with.squares[f][testing::temperature_A], noise += with.noise[f][testing::temperature_A],
        samples += with.noise[f][testing::temperature_A] / std::pow(testing::paper_noise[testing::temperature_A], 2);
  CHECK(squares < 0.01 * noise);                           // the recording has none
  CHECK(samples == doctest::Approx(500.0).epsilon(0.01));  // all but the first ten seconds, once
}

TEST_CASE("open loop: better in one fold is chance, better in most is not, and less than noise is noise") {
  const auto before = folds_of({5, 5, 5, 5, 5, 5, 5, 5, 5, 5});
  CHECK(diagnose::gain_of(before, folds_of({3, 4, 3, 4, 3, 4, 3, 4, 3, 4})).beyond_chance());
  CHECK_FALSE(diagnose::gain_of(before, before).beyond_chance());
  CHECK_FALSE(diagnose::gain_of(folds_of({5, 5, 5, 5, 5, 5, 5, 5, 5, 50}), before).beyond_chance());
  CHECK_FALSE(diagnose::gain_of(before, folds_of({2, 9, 1, 8, 2, 7, 3, 4, 3, 1})).beyond_chance());
  CHECK_FALSE(diagnose::gain_of(folds_of(std::vector<double>(10, 1.0)), folds_of(std::vector<double>(10, 0.1))).beyond_chance());
  // Where the plant could not follow once, nothing is known.
  CHECK_FALSE(diagnose::gain_of(before, folds_of({1, 1, 1, 1, 1, 1, 1, 1, 1, 1e148})).beyond_chance());
}

TEST_CASE("joint score: of two columns it is what least squares on both explains, and forbids what physics does") {
  diagnose::Score one, other;
  one.effect = testing::effect("latent_heat");  // never negative
  other.effect = testing::effect("ambient_drift");
  other.two_sided = true;  // of either sign
  const double cosine = 0.6;
  one.column = other.column = Eigen::VectorXd::Zero(16);
  one.column(0) = 1.0;
  other.column(0) = cosine;
  other.column(1) = 0.8;
  Eigen::VectorXd data = 3.0 * one.column - 2.0 * other.column;
  data(2) = 7.0;
  one.root = one.column.dot(data);
  other.root = other.column.dot(data);
  const diagnose::JointScore both = diagnose::joint(one, other);
  CHECK(both.root == doctest::Approx(3.0));
  CHECK(both.other_root == doctest::Approx(-2.0));
  CHECK(both.statistic == doctest::Approx(data.squaredNorm() - 49.0));  // all but what is orthogonal to both
  one.root = -one.root;
  other.root = -other.root;
  CHECK(diagnose::joint(one, other).statistic == 0.0);
}

}  // namespace diagnose_open_loop_test
