// SPDX-License-Identifier: Apache-2.0
// The predictor of 300 and 300: one update of training, one step, ten minutes of rollout; and how fast memory gives the weights.
//
//   bench_network [--export FOLDER]      FOLDER: batch.h5 and network.json for against_torch.py
#include <cstring>
#include <nlohmann/json.hpp>

#include "bench/babbling.h"
#include "model/hdf5_file.h"
#include "model/network_loop.h"
#include "model/train.h"
#include "model/weights_file.h"
#include "sim/text.h"

using namespace sinew;

namespace {

constexpr int threads = 2;
constexpr model::Index published_batch = 100, streams = 50, steps = 100, stateful_updates = 12;

model::Task task() { return model::task_of(plant::default_plant().system(), 3); }

model::TrainingRun run() {
  model::TrainingRun one;
  one.task = task();
  one.threads = threads;
  return one;
}

// By the wall: more than one thread works.
double fastest_by_wall_s(const std::function<void()>& work) {
  double least_s = 1e300;
  for (int i = 0; i < 3; ++i) {
    const double began_s = bench::seconds_on(CLOCK_MONOTONIC);
    work();
    least_s = std::min(least_s, bench::seconds_on(CLOCK_MONOTONIC) - began_s);
  }
  return least_s;
}

// Seconds of one update, of the fastest of three trainings.
double published_update_s(const model::Series& data, model::Index& updates) {
  model::PublishedSettings settings;
  settings.epochs = 2;
  settings.training_fraction = 1.0;
  updates = settings.epochs * ((data.samples() - 1 + published_batch - 1) / published_batch);
  return fastest_by_wall_s([&] { static_cast<void>(model::train_published({data}, settings, run())); }) / static_cast<double>(updates);
}

double stateful_update_s(const model::Series& data) {
  model::StatefulSettings settings;
  settings.hidden = settings.dense = 300;
  settings.streams = streams;
  settings.steps = steps;
  settings.updates = settings.validation_every = stateful_updates;
  settings.training_fraction = 1.0;
  settings.validation_fraction = 0.011;  // validation is not what is timed
  settings.settling_s = 0.0;
  return fastest_by_wall_s([&] { static_cast<void>(model::train_stateful({data}, settings, run())); }) /
         static_cast<double>(stateful_updates);
}

// Seconds to read so many bytes again and again, where they fit.
double reading_s(std::size_t bytes) {
  const Eigen::VectorXf data = Eigen::VectorXf::Ones(static_cast<model::Index>(bytes / sizeof(float)));
  constexpr int times = 200;
  volatile float sink = 0.0F;
  return bench::fastest_in_turn_s(15, {[&] {
                                    for (int i = 0; i < times; ++i) sink = sink + data.sum();
                                  }})
             .front() /
         times;
}

void put(model::Hdf5File& file, const std::string& name, const auto& matrix) {  // [rows x cols], rows slowest
  model::Hdf5Array& array = file.arrays["/" + name];
  array.extents = {static_cast<std::uint64_t>(matrix.rows()), static_cast<std::uint64_t>(matrix.cols())};
  for (model::Index i = 0; i < matrix.rows(); ++i)
    for (model::Index j = 0; j < matrix.cols(); ++j) array.values.push_back(static_cast<double>(matrix(i, j)));
}

// One batch of each kind with what comes out of it.
void export_batches(const std::filesystem::path& folder) {
  model::Hdf5File file;
  for (const bool memoryless : {true, false}) {
    const model::Index T = memoryless ? 1 : steps, B = memoryless ? published_batch : streams;
    const model::Shape shape{5, 300, 300, memoryless};
    const model::Weights<float> w = model::first_weights(shape, 1);
    const sim::RandomStream chance(1, "batch");
    std::uint64_t n = 0;
    const auto drawn = [&](model::Index rows, model::Index cols) {
      model::Matrix<float> m(rows, cols);
      for (float& entry : m.reshaped()) entry = static_cast<float>(chance.uniform(n++));
      return m;
    };
    model::Stretch<float> stretch{drawn(4, T * B), drawn(B, T), model::Matrix<float>::Constant(B, T, memoryless ? 0.0F : 1.0F), drawn(B, T),
                                  model::Matrix<float>::Constant(B, T, 1.0F / static_cast<float>(T * B))};
    model::State<float> state(shape, B);
    state.last_output.setConstant(0.5F);
    model::Unrolled<float> network(shape, T, B, memoryless);
    network.forward(w, stretch, state);
    model::Weights<float> gradient(shape);
    const float loss = network.backward(w, stretch, gradient);
    const std::string at = memoryless ? "published/" : "stateful/";
    put(file, at + "exogenous", stretch.exogenous);
    put(file, at + "angle_before", stretch.y_before);
    put(file, at + "target", stretch.target);
    put(file, at + "outputs", network.outputs());
    put(file, at + "loss", model::Matrix<float>::Constant(1, 1, loss));
    put(file, at + "input", w.input());
    put(file, at + "recurrent", w.recurrent());
    put(file, at + "bias", w.bias());
    put(file, at + "dense", w.dense());
    put(file, at + "output", w.output());
    put(file, at + "gradient_input", gradient.input());
    put(file, at + "gradient_recurrent", gradient.recurrent());
    put(file, at + "gradient_dense", gradient.dense());
  }
  sim::write_file_whole(folder / "batch.h5", model::to_bytes(file));
}

}  // namespace

int main(int argc, char** argv) {
  const bool exports = argc == 3 && std::strcmp(argv[1], "--export") == 0;
  if (argc != 1 && !exports) {
    std::fputs("usage: bench_network [--export FOLDER]\n", stderr);
    return 2;
  }
  const model::Series data = model::series_of(bench::babbling(600.0), task());
  model::Index published_updates = 0;
  const double published_s = published_update_s(data, published_updates), stateful_s = stateful_update_s(data);
  std::printf("LSTM of 300, dense layer of 300, case 3, 32-bit floats; training on %d threads, prediction on one.\n\n", threads);
  std::printf(
      "| what | ms |\n|---|---|\n| published: one update, batch of %lld | %.2f |\n| stateful: one update, %lld streams of %lld steps | "
      "%.1f |\n\n",
      static_cast<long long>(published_batch), 1e3 * published_s, static_cast<long long>(streams), static_cast<long long>(steps),
      1e3 * stateful_s);

  std::printf(
      "| one step of prediction | us | weights read, bytes | reading those alone, us | times the bound | goal | "
      "|\n|---|---|---|---|---|---|---|\n");
  nlohmann::ordered_json json{{"threads", threads}, {"published_update_s", published_s}, {"stateful_update_s", stateful_s}};
  for (const std::string method : {"published", "stateful"}) {
    model::Model one;
    one.method = method;
    one.scaling = model::scaling_of({data}, task());
    one.weights = model::first_weights({5, 300, 300, method == "published"}, 1);
    model::NetworkLoop predictor(one);
    predictor.begin(data.y(0), data.v.col(0));
    volatile double sink = 0.0;
    const double step_s = bench::fastest_in_turn_s(5, {[&] {
                                                     for (model::Index k = 1; k < data.samples(); ++k)
                                                       sink = predictor.open_loop(data.v.col(k));
                                                   }})
                              .front() /
                          static_cast<double>(data.samples() - 1);
    const auto& shape = one.weights.shape;
    const auto bytes = sizeof(float) * static_cast<std::size_t>(one.memoryless() ? shape.rest() : shape.size());
    const double bound_s = reading_s(bytes);
    std::printf("| %s | %.1f | %zu | %.1f | %.2f | at most 2 | %s |\n", method.c_str(), 1e6 * step_s, bytes, 1e6 * bound_s,
                step_s / bound_s, bench::verdict(step_s <= 2.0 * bound_s));
    json[method + "_step_s"] = step_s;
    json[method + "_times_real_time"] = model::period_s / step_s;
  }
  std::printf("\n| ten minutes of rollout | times real time | goal | |\n|---|---|---|---|\n");
  for (const std::string method : {"published", "stateful"}) {
    const double times = json[method + "_times_real_time"];
    std::printf("| %s, 300 and 300 | %.0f | at least 5000 | %s |\n", method.c_str(), times, bench::verdict(times >= 5000.0));
    model::Model one;
    one.method = method;
    one.scaling = model::scaling_of({data}, task());
    one.weights = model::first_weights({5, 300, 300, method == "published"}, 1);
    const std::vector<model::Series> sessions(model::at_once, data);
    const double all_s = bench::fastest_in_turn_s(3, {[&] { (void)model::rollouts(one, sessions, 1); }}).front();
    const double together = static_cast<double>(sessions.size() * static_cast<std::size_t>(data.samples() - 1)) * model::period_s / all_s;
    std::printf("| %s, %zu side by side, together | %.0f | at least 5000 | %s |\n", method.c_str(), sessions.size(), together,
                bench::verdict(together >= 5000.0));
    json[method + "_side_by_side_times_real_time"] = together;
  }
  if (exports) {
    export_batches(argv[2]);
    sim::write_file_whole(std::filesystem::path(argv[2]) / "network.json", json.dump(1) + "\n");
  }
  return 0;
}
