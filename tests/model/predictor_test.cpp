// SPDX-License-Identifier: Apache-2.0
#include "model/predictor.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model/errors.h"
#include "model/linear.h"
#include "model/network_loop.h"
#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/simulation.h"

namespace model_predictor_test {

using namespace sinew;
using namespace sinew::model;

namespace {

Task both_duties() { return task_of(plant::default_plant().system(), 3); }

// Two duties, and a value that follows their difference with a time constant of two seconds and bends: no linear model is right.
Series bending(std::uint64_t seed, Index samples, double noise = 0.0) {
  const sim::RandomStream chance(seed, "duty"), reading(seed, "noise");
  Series series{"bending", 0.0, Matrix<double>(2, samples), Vector<double>(samples)};
  double slow = 0.0;
  for (Index k = 0; k < samples; ++k) {
    for (Index i = 0; i < 2; ++i) series.v(i, k) = chance.uniform(static_cast<std::uint64_t>(2 * (k / 30) + i));
    if (k > 0) slow += (60.0 * (series.v(0, k - 1) - series.v(1, k - 1)) - slow) * (1.0 - std::exp(-period_s / 2.0));
    series.y(k) = slow + slow * slow / 100.0 + noise * reading.normal(static_cast<std::uint64_t>(k));
  }
  return series;
}

TrainingFile small_settings() {
  const sim::YamlValue root = sim::parse_yaml(
      "published: { hidden: 8, dense: 8, epochs: 2 }\n"
      "stateful: { hidden: 8, dense: 8, updates: 60, streams: 30, steps: 30, settling_s: 5, shortest_life_s: 10, longest_life_s: 20, "
      "validation_every: 20 }\n"
      "gru: { hidden: 8, dense: 8, updates: 60, streams: 30, steps: 30, settling_s: 5, shortest_life_s: 10, longest_life_s: 20, "
      "validation_every: 20 }\n",
      "small");
  TrainingFile file;
  for (const auto& entry : root.map) file.given.emplace(entry.key, entry.value);
  return file;
}

TrainedPredictor trained(std::string_view kind, const std::vector<Series>& data) {
  TrainingRun run;
  run.task = both_duties();
  const plant::Plant plant = plant::default_plant();
  return predictor_kind(kind).train({data, small_settings(), run, nullptr, &plant});
}

std::string path_of(const std::string& bytes) {
  const auto path = std::filesystem::temp_directory_path() / ("sinew_predictor_" + std::to_string(::getpid()) + ".h5");
  sim::write_file_whole(path, bytes);
  return path.string();
}
std::string what_reading_says(const std::string& bytes) {
  try {
    read_predictor(path_of(bytes));
  } catch (const sim::InputError& e) {
    return e.what();
  }
  return "nothing thrown";
}

}  // namespace

TEST_CASE("predictors: each kind comes back from its file as it was, and a copy goes its own way") {
  const std::vector<Series> data{bending(1, 1500, 0.1)};
  const Series other = bending(2, 300, 0.1), before = part_of(bending(3, 300, 0.1), 100, 50);
  for (const PredictorKind& kind : predictor_kinds()) {
    CAPTURE(kind.name);
    const TrainedPredictor one = trained(kind.name, data);
    CHECK(one.predictor->about().kind == kind.name);
    one.predictor->about().trained_on = "a plant that bends";
    one.predictor->about().arx = fit_arx(data);
    CHECK_FALSE(read_predictor(path_of(bytes_of(*one.predictor)))->about().intervals.has_value());  // as of an older version
    one.predictor->about().region = trained_region_of(data);
    one.predictor->about().intervals = intervals_from(*one.predictor, {{data.front(), 1000}}, 1);
    const std::string bytes = bytes_of(*one.predictor);
    CHECK(bytes == bytes_of(*one.predictor));
    const auto back = read_predictor(path_of(bytes));
    CHECK(back->about().kind == kind.name);
    CHECK(back->about().trained_on == "a plant that bends");
    CHECK(back->about().task.predicted.name == "angle_deg");
    CHECK(back->about().arx->coefficients == one.predictor->about().arx->coefficients);
    REQUIRE(back->about().intervals.has_value());
    CHECK(json_of(*back->about().intervals) == json_of(*one.predictor->about().intervals));
    REQUIRE(back->about().region.has_value());
    CHECK(back->about().region->visited == one.predictor->about().region->visited);
    CHECK(back->about().region->reach_cells == one.predictor->about().region->reach_cells);
    CHECK(bytes_of(*back) == bytes);
    const Vector<double> open = rollout(*one.predictor, other), step = one_step_ahead(*one.predictor, other, &before);
    CHECK(open.allFinite());
    CHECK(rollout(*back, other) == open);
    const auto copy = back->copy();
    back->begin(part_of(other, 0, 1));
    copy->begin(before);
    for (Index k = 1; k < 20; ++k) {
      CHECK(copy->step(other.v.col(k), other.y(k - 1)) == step(k));
      CHECK(back->step(other.v.col(k)) == open(k));
    }
  }
}
TEST_CASE("predictors: the linear ones are the rollouts and steps of their model, to the last digits") {
  const std::vector<Series> data{bending(1, 1500)};
  const Series other = bending(2, 400);
  const auto arx = trained("arx", data).predictor;
  const LinearModel model = fit_arx({part_of(data.front(), 0, 1005)});
  CHECK((rollout(*arx, other) - rollout(model, other)).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((one_step_ahead(*arx, other) - one_step_ahead(model, other)).cwiseAbs().maxCoeff() < 1e-9);
}
TEST_CASE("ARX: where readings are noisy, the fit to the rollout's error is the better one in open loop") {
  // One step ahead, noise on the values before makes them look less worth than they are (Ljung, 2nd ed., 8.2).
  const std::vector<Series> data{bending(1, 3000, 2.0)};
  const Series clean = bending(2, 3000);
  const double by_step = errors_of(rollout(fit_arx(data), clean), clean).rmse,
               by_simulation = errors_of(rollout(fit_arx_simulation(data), clean), clean).rmse;
  CHECK(by_simulation < by_step);
  // Of a plant that is linear it finds the plant: 60 (1 - exp(-t / 2 s)).
  Series linear{"lag", 0.0, Matrix<double>(1, 3000), Vector<double>(3000)};
  const sim::RandomStream chance(4, "duty"), noise(4, "noise");
  double y = 0.0;
  for (Index k = 0; k < 3000; ++k) {
    linear.v(0, k) = chance.uniform(static_cast<std::uint64_t>(k / 30));
    if (k > 0) y += (60.0 * linear.v(0, k - 1) - y) * (1.0 - std::exp(-0.05));
    linear.y(k) = y + noise.normal(static_cast<std::uint64_t>(k));
  }
  const LinearModel found = fit_arx_simulation({linear});
  const Vector<double>& c = found.coefficients;
  const double gain = c.segment(found.order, found.order + 1).sum() / (1.0 - c.head(found.order).sum());
  CHECK(gain == doctest::Approx(60.0).epsilon(0.01));  // noise of 1 on 3000 samples, 100 steps of duty
}
TEST_CASE("ARX: fitted to simulation error, it is stable: what it was begun with fades") {
  // A slow plant with little to see of its end: ten seconds of time constant, and 40 s of recording.
  Series slow{"slow", 0.0, Matrix<double>::Zero(1, 400), Vector<double>(400)};
  const sim::RandomStream noise(7, "noise");
  for (Index k = 0; k < 400; ++k) slow.y(k) = std::exp(0.004 * static_cast<double>(k)) + 0.01 * noise.normal(static_cast<std::uint64_t>(k));
  // What grows in the recording is fitted as well as a stable model can.
  const LinearModel model = fit_arx_simulation({slow});
  Series long_one{"long", 0.0, Matrix<double>::Zero(1, 30000), Vector<double>::Zero(30000)};
  long_one.y(0) = 100.0;
  Series other = long_one;
  other.y(0) = 0.0;
  const double left = std::abs(rollout(model, long_one)(29999) - rollout(model, other)(29999));
  CHECK(left < 100.0);
}
TEST_CASE("corrected: in open loop it is exactly what is inside, and one step ahead better than that and than ARX") {
  const std::vector<Series> data{bending(1, 6000, 0.1)};
  const Series other = bending(2, 2000, 0.1);
  TrainingRun run;
  run.task = both_duties();
  const TrainingFile settings = small_settings();
  const auto inside = predictor_kind("stateful").train({data, settings, run}).predictor;
  const auto corrected = predictor_kind("corrected").train({data, settings, run, inside.get()}).predictor;
  CHECK(rollout(*corrected, other) == rollout(*inside, other));
  // Not before the last 16 values, the longest memory of the correction, were measured.
  const auto step_error = [&](Predictor& one) { return root_mean_square_error(one_step_ahead(one, other), other, 20, 1980); };
  const double step = step_error(*corrected);
  CHECK(step < 0.5 * step_error(*inside));
  CHECK(step <= 1.02 * step_error(*trained("arx", data).predictor));
  // Begun in mid-motion the rollout leaps to where it believes to be. One step ahead that is known to be wrong.
  double leap = 0.0, first = 0.0;
  for (Index begin = 100; begin < 1900; begin += 100) {
    const Series moving = part_of(other, begin, 2);
    leap += std::abs(rollout(*inside, moving)(1) - moving.y(1));
    first += std::abs(one_step_ahead(*corrected, moving)(1) - moving.y(1));
  }
  CHECK(first < 0.25 * leap);
  // Where measurements end, the correction fades, and the rollout is left.
  const Vector<double> open = rollout(*inside, other);
  corrected->begin(part_of(other, 0, 1));
  double y = 0.0;
  for (Index k = 1; k < 1000; ++k) {
    y = corrected->step(other.v.col(k), k <= 200 ? std::optional<double>(other.y(k - 1)) : std::nullopt);
    if (k == 202) CHECK(std::abs(y - open(k)) > 1e-6);
  }
  CHECK(y == doctest::Approx(open(999)).epsilon(1e-6));
}
TEST_CASE("hybrid: where the plant is right it says what the plant says, and where it is wrong it comes nearer") {
  sim::Scenario scenario;
  scenario.plant = plant::default_plant();
  const auto simulated = [&](const plant::Plant& limb, std::uint64_t seed, Index samples) {
    plant::Integrator integrator(limb, plant::Start{}, {plant::Method::cvode, 1e-7});
    Series series = bending(seed, samples);
    for (Index k = 0; k < samples; ++k) {
      REQUIRE_FALSE(integrator.advance_to(static_cast<double>(k) * period_s));
      series.y(k) = sim::in_file_units(limb.system(), integrator.readings()).back();
      integrator.hold({0.4 * series.v(0, k), 0.4 * series.v(1, k)});
    }
    series.v *= 0.4;
    return series;
  };
  REQUIRE(plant::default_plant().system().channels()[plant::ChannelId{plant::default_plant().system().channels().size() - 1}].column ==
          "angle_deg");
  // A limb that bends by a fifth less, and is 3 degrees off: linear in what the plant says.
  Series wrong = simulated(plant::default_plant(), 1, 3000), fresh = simulated(plant::default_plant(), 2, 1500);
  const Series right = fresh;
  for (Series* one : {&wrong, &fresh}) one->y = (0.8 * one->y).array() + 3.0;
  const auto fitted = [&](const Series& data) {
    TrainingRun run;
    run.task = both_duties();
    const plant::Plant limb = plant::default_plant();
    TrainingFile settings = small_settings();
    settings.given.emplace("hybrid", sim::parse_yaml("{ base: arx_simulation }", "small"));
    return predictor_kind("hybrid").train({{data}, settings, run, nullptr, &limb}).predictor;
  };
  const double by_plant = errors_of(rollout(*trained("plant", {wrong}).predictor, fresh), fresh).rmse;
  const auto hybrid = fitted(wrong);
  CHECK(errors_of(rollout(*hybrid, fresh), fresh).rmse < 0.1 * by_plant);
  CHECK(errors_of(rollout(*fitted(simulated(plant::default_plant(), 1, 1500)), right), right).largest < 0.05);
  // Around it, a correction: the file says both, and what is inside them.
  TrainingRun run;
  run.task = both_duties();
  const TrainingFile settings = small_settings();
  const auto corrected = predictor_kind("corrected").train({{wrong}, settings, run, hybrid.get()}).predictor;
  const auto back = read_predictor(path_of(bytes_of(*corrected)));
  CHECK(back->about().kind == "corrected");
  CHECK(rollout(*back, fresh) == rollout(*hybrid, fresh));
  CHECK(one_step_ahead(*back, fresh) == one_step_ahead(*corrected, fresh));
}
TEST_CASE("plant: as a predictor it gives what the simulation gives") {
  sim::Scenario scenario;
  scenario.plant = plant::default_plant();
  sim::SimulatedBackend limb(scenario);
  plant::Integrator integrator(scenario.plant, plant::Start{}, {plant::Method::cvode, 1e-9});
  Series series = bending(1, 200);
  const auto& channels = scenario.plant.system().channels();
  std::size_t angle = 0;
  for (const plant::ChannelId c : channels.ids())
    if (channels[c].column == "angle_deg") angle = c.index;
  for (Index k = 0; k < series.samples(); ++k) {
    REQUIRE_FALSE(integrator.advance_to(static_cast<double>(k) * period_s));
    series.y(k) = sim::in_file_units(scenario.plant.system(), integrator.readings())[angle];
    integrator.hold({series.v(0, k), series.v(1, k)});
  }
  CHECK(series.y.maxCoeff() - series.y.minCoeff() > 5.0);
  const auto predictor = trained("plant", {series}).predictor;
  CHECK(errors_of(rollout(*predictor, series), series).largest < 0.01);  // tolerance 1e-5 of the predictor's integrator
  const Series later = part_of(series, 100, 100), history = part_of(series, 0, 101);
  CHECK(errors_of(rollout(*predictor, later, &history), later).largest < 0.01);
}
TEST_CASE("predictors: a file that was changed, or is of another kind, is refused") {
  const auto arx = trained("arx", {bending(1, 1500)}).predictor;
  Hdf5File file = arx->save();
  std::string& said = file.text_attributes["/"]["sinew"];
  said.replace(said.find("\"case\":3"), 8, "\"case\":4");
  CHECK(what_reading_says(to_bytes(file)).find("is not that of what is in the file") != std::string::npos);
  said.replace(said.find("\"method\":\"arx\""), 14, "\"method\":\"oracle\"");
  CHECK(what_reading_says(to_bytes(file)).find("is no kind of predictor of this version; there are arx, ") != std::string::npos);
  file = trained("corrected", {bending(1, 1500)}).predictor->save();
  std::string& correction = file.text_attributes["/"]["sinew_correction"];
  correction.replace(correction.find("\"order\":"), 9, "\"order\":3");
  CHECK(what_reading_says(to_bytes(file)).find("sinew_correction") != std::string::npos);
  arx->about().region = trained_region_of({bending(1, 300)});
  arx->about().intervals = intervals_from(*arx, {{bending(2, 1500), 300}}, 1);
  file = parse_hdf5(bytes_of(*arx), "whole");
  Hdf5File narrower = file, moved = file;
  std::string& trust = narrower.text_attributes["/"]["sinew_trust"];
  trust.replace(trust.find("\"unit\":\"minute\""), 15, "\"unit\":\"second\"");
  CHECK(what_reading_says(to_bytes(narrower)).find("intervals or description were changed") != std::string::npos);
  moved.arrays.at("/sinew_trust/visited").values.front() += 1.0;
  CHECK(what_reading_says(to_bytes(moved)).find("intervals or description were changed") != std::string::npos);
  CHECK(what_reading_says(to_bytes(file)) == "nothing thrown");
  CHECK_THROWS_WITH(predictor_kind("oracle"), doctest::Contains("there is no predictor oracle; there are arx, "));
}

TEST_CASE("network loop: rollouts side by side are those of one after the other, of any lengths, with any number of threads") {
  std::vector<Series> series;
  for (const Index samples : {1, 2, 51, 52, 300, 120, 101, 60, 7, 90, 33, 150, 200, 240, 99, 41, 77, 180})  // more than one group
    series.push_back(bending(static_cast<std::uint64_t>(samples), samples));
  for (const Cell cell : {Cell::lstm, Cell::gru})
    for (const bool memoryless : {false, true}) {
      if (cell == Cell::gru && memoryless) continue;
      CAPTURE(memoryless);
      Model model{both_duties(), memoryless ? "published" : "stateful", scaling_of(series, both_duties()), {}, ""};
      model.weights = first_weights({5, 12, 9, memoryless, cell}, 3);
      const std::vector<Vector<double>> together = rollouts(model, series, 2);
      REQUIRE(together.size() == series.size());
      CHECK(together == rollouts(model, series, 1));
      for (std::size_t i = 0; i < series.size(); ++i) {
        const Vector<double> alone = rollout(model, series[i]);
        REQUIRE(together[i].size() == alone.size());
        CHECK((together[i] - alone).cwiseAbs().maxCoeff() < 1e-3);
      }
    }
}

}  // namespace model_predictor_test
