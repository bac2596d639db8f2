// SPDX-License-Identifier: Apache-2.0
#include "model/train.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>

#include "model/errors.h"
#include "model/linear.h"
#include "model/network_loop.h"
#include "model/predictor.h"
#include "plant/systems.h"
#include "sim/fields.h"
#include "tests/long_when_sanitized.h"

namespace model_train_test {

using namespace sinew;
using namespace sinew::model;

// The linker sends every malloc and operator new of this program's own objects here (tests/CMakeLists.txt).
static thread_local long allocations = 0;
extern "C" {
void* __real_malloc(std::size_t);
void* __wrap_malloc(std::size_t size) {
  ++allocations;
  return __real_malloc(size);
}
void* __real__Znwm(std::size_t);
void* __wrap__Znwm(std::size_t size) {
  ++allocations;
  return __real__Znwm(size);
}
}

namespace {

// A limb of one line: the angle goes to 60 times the duty with a time constant of two seconds. What is right can be said by hand.
Series first_order(std::uint64_t seed, Index samples) {
  const sim::RandomStream chance(seed, "duty");
  Series series{"first order", 0.0, Matrix<double>(1, samples), Vector<double>(samples)};
  double angle = 0.0;
  for (Index k = 0; k < samples; ++k) {
    series.v(0, k) = chance.uniform(static_cast<std::uint64_t>(k / 30));
    if (k > 0) angle += (60.0 * series.v(0, k - 1) - angle) * (1.0 - std::exp(-period_s / 2.0));
    series.y(k) = angle;
  }
  return series;
}

Task duty_to_angle() { return task_of(plant::default_plant().system(), 1); }

StatefulSettings small() {
  StatefulSettings settings;
  settings.hidden = settings.dense = 24;
  settings.streams = 30;  // two parts
  settings.steps = 40;
  settings.updates = 300;
  settings.rate = 1e-2;
  settings.longest_memory_s = 5.0;
  settings.settling_s = 5.0;
  settings.shortest_life_s = 20.0;
  settings.longest_life_s = 60.0;
  settings.training_fraction = 1.0;
  settings.validation_every = 50;
  return settings;
}
TrainingRun run_of(int threads) {
  TrainingRun run;
  run.task = duty_to_angle();
  run.seed = 5;
  run.threads = threads;
  return run;
}

}  // namespace

TEST_CASE("training: stateful learns a lag of first order well enough for a rollout" * long_when_sanitized) {
  StatefulSettings settings = small();
  settings.updates = 600;
  const Trained trained = train_stateful({first_order(1, 4000)}, settings, run_of(2));
  const Series other = first_order(2, 2000);
  const Errors off = errors_of(rollout(trained.model, other), other);
  // The angle's own standard deviation is about 15 deg; a tenth of that is the least one would ask of it.
  CHECK(off.rmse < 1.5);
  CHECK(off.last_minute < 1.5);
}
TEST_CASE("training: the same seed gives the same weights to the last bit, whatever the number of threads") {
  StatefulSettings settings = small();
  settings.updates = 50;
  const Series data = first_order(1, 2000);
  const auto one = train_stateful({data}, settings, run_of(1)), three = train_stateful({data}, settings, run_of(3));
  CHECK(one.model.weights.all == three.model.weights.all);
  TrainingRun other = run_of(1);
  other.seed = 6;
  CHECK(train_stateful({data}, settings, other).model.weights.all != one.model.weights.all);
  PublishedSettings published;
  published.hidden = published.dense = 10;
  published.epochs = 2;
  const auto a = train_published({data}, published, run_of(1)), b = train_published({data}, published, run_of(4));
  CHECK(a.model.weights.all == b.model.weights.all);
}
TEST_CASE("training: published leaves the recurrent weights where they began, and predicts one step ahead" * long_when_sanitized) {
  PublishedSettings settings;
  settings.hidden = settings.dense = 300;
  const Series data = first_order(1, 4000);
  const Trained trained = train_published({data}, settings, run_of(2));
  CHECK(trained.model.weights.recurrent() == first_weights({3, 300, 300, true}, 5).recurrent());
  const Series other = first_order(2, 2000);
  CHECK(errors_of(one_step_ahead(trained.model, other), other).rmse < 3.0);
  CHECK(trained.best_update == 20 * ((4000 * 67 / 100 - 1 + 99) / 100));
}
TEST_CASE("training: as published, the scaler has seen what follows the training part, and the clean one has not") {
  Series data = first_order(1, 1000);
  data.v(0, 900) = 3.0;  // after 67 %
  data.y(950) = 500.0;
  PublishedSettings settings;
  settings.hidden = settings.dense = 4;
  settings.epochs = 1;
  const Scaling leaky = train_published({data}, settings, run_of(1)).model.scaling;
  CHECK(leaky.v_offset(0) + leaky.v_span(0) == 3.0);
  CHECK(leaky.y_offset + leaky.y_span == doctest::Approx(500.0));
  settings.scaler_sees_all = false;
  const Scaling clean = train_published({data}, settings, run_of(1)).model.scaling;
  CHECK(clean.v_offset(0) + clean.v_span(0) == data.v.row(0).head(670).maxCoeff());  // inputs are scaled, too
  CHECK(clean.y_offset + clean.y_span == doctest::Approx(data.y.head(670).maxCoeff()));
}
TEST_CASE("training: in a pause nothing is learned") {
  // The same recording, and one in which the pause holds other values: the weights are the same.
  Series data = first_order(1, 2000);
  data.counted = Vector<double>::Ones(2000);
  data.counted.segment(500, 200).setZero();
  Series other = data;
  for (Index k = 510; k < 690; ++k) other.y(k) = 0.5 * (data.y.minCoeff() + data.y.maxCoeff());
  StatefulSettings settings = small();
  settings.updates = 40;
  settings.validation_every = 40;
  CHECK(train_stateful({data}, settings, run_of(1)).model.weights.all == train_stateful({other}, settings, run_of(1)).model.weights.all);
  CHECK(fit_arx({data}).coefficients == fit_arx({other}).coefficients);
  PublishedSettings published;
  published.hidden = published.dense = 4;
  published.epochs = 1;
  CHECK(train_published({data}, published, run_of(1)).model.weights.all ==
        train_published({other}, published, run_of(1)).model.weights.all);
}
TEST_CASE("training: weights that came from elsewhere stay where training does not make them better" * long_when_sanitized) {
  const Series data = first_order(1, 3000);
  const Trained good = train_stateful({data}, small(), run_of(2));
  StatefulSettings settings = small();
  settings.updates = 4;
  settings.validation_every = 1;
  settings.rate = 0.3;  // ruins them
  TrainingRun run = run_of(1);
  run.from = &good.model;
  const Trained after = train_stateful({data}, settings, run);
  CHECK(after.best_update == 0);
  CHECK(after.model.weights.all == good.model.weights.all);
}
TEST_CASE("linear: of recordings too short for an order the others are tried, and for all of them there is no finite fit") {
  CHECK(fit_arx({first_order(1, 9)}).coefficients.allFinite());
  CHECK_FALSE(fit_arx({first_order(1, 1)}).coefficients.allFinite());
  Series every_other = first_order(1, 200);
  every_other.counted = Vector<double>::Ones(200);
  for (Index k = 0; k < 200; k += 2) every_other.counted(k) = 0.0;
  CHECK_FALSE(fit_arx({every_other}).coefficients.allFinite());
  CHECK(fit_static({every_other}).coefficients.allFinite());
}
TEST_CASE("training: where nothing is left to judge by, there are no weights") {
  StatefulSettings settings = small();
  settings.settling_s = 40.0;
  const std::vector<Series> short_ones(6, first_order(1, 350));
  CHECK_THROWS_WITH(train_stateful(short_ones, settings, run_of(1)),
                    doctest::Contains("of what is set aside, 0 s are left to judge by after settling_s = 40"));
  CHECK_THROWS_WITH(train_stateful({first_order(1, 280)}, settings, run_of(1)), doctest::Contains("4.2 s are left to judge by"));
}
TEST_CASE("training: the file that is shipped has every setting of every predictor, at its default") {
  const TrainingFile file = read_training(std::filesystem::path(SINEW_SOURCE_DIR) / "scenarios/train.yaml");
  const std::string whole = sim::read_file(std::filesystem::path(SINEW_SOURCE_DIR) / "scenarios/train.yaml");
  for (const PredictorKind& kind : predictor_kinds()) {
    CAPTURE(kind.name);
    CHECK(file.has(kind.name));
    const std::string defaults = kind.settings_text({});
    CHECK(kind.settings_text(file) == defaults);
    const std::string section = whole.substr(whole.find("\n" + std::string(kind.name) + ":"));
    for (std::size_t at = 0; at < defaults.size(); at = defaults.find('\n', at) + 1)
      CHECK(section.find("\n  " + defaults.substr(at, defaults.find(':', at) - at) + ": ") != std::string::npos);
  }
}
TEST_CASE("predictor: step by step is what the unrolled network gives") {
  const Series series = first_order(3, 200);
  Model model;
  model.task = duty_to_angle();
  model.method = "stateful";
  model.scaling = scaling_of({series}, duty_to_angle());
  model.weights = first_weights({3, 16, 8, false}, 1);
  const ScaledSeries x = scaled(series, model.scaling);
  Unrolled<float> network(model.weights.shape, 199, 1);
  Stretch<float> stretch{x.exogenous, x.y.head(199).transpose(), Matrix<float>::Ones(1, 199), Matrix<float>::Zero(1, 199),
                         Matrix<float>::Zero(1, 199)};
  State<float> state(model.weights.shape, 1);
  state.last_output(0) = x.y(0);
  network.forward(model.weights, stretch, state);
  const Vector<double> angle = rollout(model, series);
  for (Index t = 0; t < 199; ++t) REQUIRE(angle(t + 1) == doctest::Approx(model.scaling.y(network.outputs()(0, t))).epsilon(1e-4));
}
TEST_CASE("predictor: a step allocates nothing") {
  const Series series = first_order(3, 50);
  for (const std::string method : {"published", "stateful"}) {
    Model model;
    model.task = duty_to_angle();
    model.method = method;
    model.scaling = scaling_of({series}, duty_to_angle());
    model.weights = first_weights({3, 300, 300, method == "published"}, 1);
    const long before_all = allocations;
    NetworkLoop predictor(model);
    CHECK(allocations > before_all);  // the counter counts
    predictor.begin(series.y(0), series.v.col(0));
    const long before = allocations;
    double sum = 0.0;
    for (Index k = 1; k < series.samples(); ++k) sum += predictor.open_loop(series.v.col(k)) + predictor.one_step(series.v.col(k), 1.0);
    CHECK(allocations == before);
    CHECK(std::isfinite(sum));
  }
}
TEST_CASE("ARX: finds a lag of first order to the last digit; least squares on duty alone cannot") {
  const Series data = first_order(1, 2000), other = first_order(2, 2000);
  CHECK(errors_of(rollout(fit_arx({data}), other), other).rmse < 1e-3);
  CHECK(errors_of(rollout(fit_static({data}), other), other).rmse > 5.0);
}

}  // namespace model_train_test
