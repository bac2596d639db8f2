// SPDX-License-Identifier: Apache-2.0
#include "model/train.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "model/errors.h"
#include "model/network_loop.h"
#include "sim/fields.h"
#include "sim/input_error.h"
#include "sim/parallel.h"

namespace sinew::model {
namespace {

// Streams that are worked on together by one thread. Part of the result: the order of sums depends on it.
constexpr Index part_size = 25;
// Weights are chosen by the error over at least so much of rollouts.
constexpr double least_judged_s = 5.0;

// One part of the streams of an update: its stretch, its state, its gradient.
struct Part {
  Unrolled<float> network;
  Stretch<float> stretch;
  State<float> state;
  Weights<float> gradient;
  float loss = 0.0F;

  Part(const Shape& shape, Index steps, Index streams, bool memoryless)
      : network(shape, steps, streams, memoryless),
        stretch{Matrix<float>(shape.inputs - 1, steps * streams), Matrix<float>(streams, steps), Matrix<float>::Zero(streams, steps),
                Matrix<float>(streams, steps), Matrix<float>(streams, steps)},
        state(shape, streams),
        gradient(shape) {}
  Index streams() const { return stretch.target.rows(); }

  void work(const Weights<float>& weights) {
    gradient.all.setZero();
    network.forward(weights, stretch, state);
    loss = network.backward(weights, stretch, gradient);
  }
};

std::vector<Part> parts_of(const Shape& shape, Index steps, Index streams, bool memoryless) {
  std::vector<Part> parts;
  for (Index from = 0; from < streams; from += part_size) parts.emplace_back(shape, steps, std::min(part_size, streams - from), memoryless);
  return parts;
}

// Gradient and loss of all parts, added in their order into the first one's gradient.
double work_on(std::vector<Part>& parts, const Weights<float>& weights, int threads) {
  sim::in_parallel(parts.size(), threads, [&](std::size_t p) { parts[p].work(weights); });
  double loss = parts.front().loss;
  for (std::size_t p = 1; p < parts.size(); ++p) {
    parts.front().gradient.all += parts[p].gradient.all;
    loss += parts[p].loss;
  }
  return loss;
}

Model model_of(const TrainingRun& run, const Scaling& scaling, std::string_view method, const Shape& layers, double longest_memory) {
  if (run.from) return *run.from;
  Model model;
  model.task = run.task;
  model.method = method;
  model.scaling = scaling;
  const auto features = static_cast<Index>(run.task.features.size());
  Shape shape = layers;
  shape.inputs = 2 * features + 1;
  model.weights = first_weights(shape, run.seed, longest_memory);
  return model;
}

std::vector<Series> first_parts(const std::vector<Series>& recordings, double share, Index least) {
  std::vector<Series> parts;
  for (const Series& one : recordings) {
    const auto count = static_cast<Index>(std::floor(share * static_cast<double>(one.samples())));
    if (count < least)
      throw sim::InputError({.file = one.name,
                             .key = "samples for training",
                             .value = std::to_string(count),
                             .advice = "is too short; at least " + std::to_string(least) + " are needed"});
    parts.push_back(part_of(one, 0, count));
  }
  return parts;
}

Index counted_of(const Series& one, Index lead_in) { return std::max(Index{0}, one.samples() - std::max(Index{1}, lead_in)); }

// Over all samples of all series but the first ones of each, its lead-in and at least the one that is given.
double root_mean_square(const std::vector<Series>& series, const std::vector<Index>& lead_in,
                        const std::vector<Vector<double>>& predicted) {
  SquaredError all;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const Index counted = counted_of(series[i], lead_in[i]);
    const SquaredError one = squared_error(predicted[i], series[i], series[i].samples() - counted, counted);
    all.sum += one.sum;
    all.count += one.count;
  }
  return all.root_mean();
}

std::vector<Vector<double>> all_one_step_ahead(const Model& model, const std::vector<Series>& series, int threads) {
  std::vector<Vector<double>> predicted(series.size());
  sim::in_parallel(series.size(), threads, [&](std::size_t i) { predicted[i] = one_step_ahead(model, series[i]); });
  return predicted;
}

// A permutation of 0 ... count - 1 (Fisher and Yates), the n-th of a stream.
std::vector<Index> shuffled(Index count, const sim::RandomStream& chance, std::uint64_t n) {
  std::vector<Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Index{0});
  for (Index i = count - 1; i > 0; --i) {
    const double u = chance.uniform(n * static_cast<std::uint64_t>(count) + static_cast<std::uint64_t>(i));
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(u * static_cast<double>(i + 1))]);
  }
  return order;
}

// A walk through the recordings: where it is, and when it begins anew.
struct Walk {
  std::size_t recording = 0;
  Index at = 1;    // the next sample to be predicted
  Index age = 0;   // steps since it began
  Index left = 0;  // steps before it begins anew
  bool teacher = false;
};

}  // namespace

Trained train_published(const std::vector<Series>& recordings, const PublishedSettings& settings, const TrainingRun& run) {
  const std::vector<Series> training = first_parts(recordings, settings.training_fraction, 2);
  std::vector<Series> rest;
  for (std::size_t r = 0; r < recordings.size(); ++r)
    if (const Index used = training[r].samples(); recordings[r].samples() - used >= 2)
      rest.push_back(part_of(recordings[r], used, recordings[r].samples() - used));
  const Scaling scaling = scaling_of(settings.scaler_sees_all ? recordings : training, run.task, Scaled::all);
  Trained trained{model_of(run, scaling, PublishedSettings::name, {0, settings.hidden, settings.dense, true}, 0.0), {}, 0};
  Weights<float>& weights = trained.model.weights;

  std::vector<ScaledSeries> data;
  std::vector<std::pair<std::size_t, Index>> samples;
  for (const Series& one : training) {
    data.push_back(scaled(one, trained.model.scaling));
    for (Index k = 1; k < one.samples(); ++k)
      if (one.is_measured(k) && one.is_measured(k - 1)) samples.emplace_back(data.size() - 1, k);
  }
  const auto count = static_cast<Index>(samples.size());
  Adam<float> adam(weights.shape.rest());  // the recurrent weights have no gradient
  const AdamSettings rates{settings.rate, settings.decay, 0.9, 0.999, 1e-7};
  const sim::RandomStream chance(run.seed, "training.order");
  const double span = trained.model.scaling.y_span;
  std::vector<Part> parts;
  Index parts_for = 0;
  for (Index epoch = 0; epoch < settings.epochs; ++epoch) {
    std::vector<Index> order(samples.size());
    std::iota(order.begin(), order.end(), Index{0});
    if (settings.shuffle) order = shuffled(count, chance, static_cast<std::uint64_t>(epoch));
    double sum = 0.0;
    for (Index from = 0; from < count; from += settings.batch) {
      if (run.should_stop && run.should_stop()) throw Stopped{};
      const Index batch = std::min(settings.batch, count - from);
      if (batch != parts_for) {
        parts = parts_of(weights.shape, 1, batch, true);
        parts_for = batch;
      }
      Index next = from;
      for (Part& part : parts)
        for (Index s = 0; s < part.streams(); ++s, ++next) {
          const auto [r, k] = samples[static_cast<std::size_t>(order[static_cast<std::size_t>(next)])];
          part.stretch.exogenous.col(s) = data[r].exogenous.col(k - 1);
          part.stretch.y_before(s, 0) = data[r].y(k - 1);
          part.stretch.target(s, 0) = data[r].y(k);
          part.stretch.weight(s, 0) = 1.0F / static_cast<float>(batch);
        }
      const double loss = work_on(parts, weights, run.threads);
      sum += loss * static_cast<double>(batch);
      adam.update(weights.all, parts.front().gradient.all, rates);
    }
    trained.curve.push_back(
        {static_cast<Index>(adam.updates()), span * std::sqrt(sum / static_cast<double>(count)),
         root_mean_square(rest, std::vector<Index>(rest.size(), 1), all_one_step_ahead(trained.model, rest, run.threads))});
    if (run.progress) run.progress(static_cast<double>(epoch + 1) / static_cast<double>(settings.epochs), trained.curve.back());
  }
  trained.best_update = static_cast<Index>(adam.updates());
  return trained;
}

Trained train_stateful(const std::vector<Series>& recordings, const StatefulSettings& settings, const TrainingRun& run, Cell cell) {
  const auto settled_after = static_cast<Index>(std::lround(settings.settling_s / period_s));
  std::vector<Series> training = first_parts(recordings, settings.training_fraction, 2), validation;
  std::vector<Index> lead_ins;  // of each recording set aside: what a rollout needs to settle, and is not judged by
  if (training.size() >= 5) {
    const auto aside = static_cast<std::size_t>(std::ceil(settings.validation_fraction * static_cast<double>(training.size())));
    validation.assign(training.end() - static_cast<std::ptrdiff_t>(aside), training.end());
    training.resize(training.size() - aside);
    lead_ins.assign(aside, settled_after);
  } else {
    for (Series& one : training) {
      const auto aside = static_cast<Index>(std::ceil(settings.validation_fraction * static_cast<double>(one.samples())));
      const Index lead_in = std::min(settled_after, one.samples() - aside);
      validation.push_back(part_of(one, one.samples() - aside - lead_in, aside + lead_in));
      lead_ins.push_back(lead_in);
      one = part_of(one, 0, one.samples() - aside);
    }
  }
  Index judged = 0;
  for (std::size_t i = 0; i < validation.size(); ++i) judged += counted_of(validation[i], lead_ins[i]);
  const double judged_s = static_cast<double>(judged) / std::round(1.0 / period_s);
  if (judged_s < least_judged_s)
    throw sim::InputError({.file = recordings.front().name + (recordings.size() > 1 ? " and others" : ""),
                           .advice = "of what is set aside, " + sim::shortest(judged_s) + " s are left to judge by after settling_s = " +
                                     sim::shortest(settings.settling_s) + " in each recording, at least " + sim::shortest(least_judged_s) +
                                     " are needed; longer recordings, a larger validation_fraction or a smaller settling_s would do"});
  for (const Series& one : training)
    if (one.samples() <= settings.steps)
      throw sim::InputError({.file = one.name,
                             .key = "samples for training",
                             .value = std::to_string(one.samples()),
                             .advice = "is too short; a stretch has " + std::to_string(settings.steps) + " steps"});
  Trained trained{model_of(run, scaling_of(training, run.task), cell == Cell::gru ? "gru" : StatefulSettings::name,
                           {0, settings.hidden, settings.dense, false, cell}, settings.longest_memory_s / period_s),
                  {},
                  0};
  Weights<float> weights = trained.model.weights;  // what is trained; the model keeps the best

  std::vector<ScaledSeries> data;
  std::vector<double> until;  // shares of all samples, added up
  double all = 0.0;
  for (const Series& one : training) {
    data.push_back(scaled(one, trained.model.scaling));
    until.push_back(all += static_cast<double>(one.samples() - settings.steps));
  }
  const sim::RandomStream where(run.seed, "training.where"), life(run.seed, "training.life"), kind(run.seed, "training.kind"),
      noise(run.seed, "training.noise"), first(run.seed, "training.first");
  std::uint64_t begun = 0, noises = 0;
  const Index T = settings.steps;
  std::vector<Part> parts = parts_of(weights.shape, T, settings.streams, false);
  std::vector<std::vector<Walk>> walks;
  for (const Part& part : parts) walks.emplace_back(static_cast<std::size_t>(part.streams()));

  const auto begin_anew = [&](Walk& walk, Part& part, Index s) {
    const double u = where.uniform(begun) * all;
    walk.recording = static_cast<std::size_t>(std::upper_bound(until.begin(), until.end() - 1, u) - until.begin());
    const double before = walk.recording > 0 ? until[walk.recording - 1] : 0.0;
    walk.at = first.uniform(begun) < settings.from_first_fraction ? 1 : 1 + static_cast<Index>(u - before);
    const Index last_begin = data[walk.recording].y.size() - T;
    for (Index tried = 0; tried < last_begin && !training[walk.recording].is_measured(walk.at - 1); ++tried)
      walk.at = walk.at < last_begin ? walk.at + 1 : 1;
    walk.age = 0;
    walk.left = static_cast<Index>((settings.shortest_life_s + (settings.longest_life_s - settings.shortest_life_s) * life.uniform(begun)) /
                                   period_s);
    walk.teacher = kind.uniform(begun) < settings.teacher_fraction;
    ++begun;
    part.state.c.col(s).setZero();
    part.state.h.col(s).setZero();
    part.state.last_output(s) = data[walk.recording].y(walk.at - 1);
  };
  // A tenth at first, rising to 1. A recording's own beginning, at rest, is known; its y and nothing before says enough.
  const auto weight_at = [&](const Walk& walk, Index age) {
    const double known =
        walk.teacher ? 1.0
                     : std::min(1.0, 0.1 + 0.9 * static_cast<double>(age) / std::max<double>(1.0, static_cast<double>(settled_after)));
    return static_cast<float>(known / static_cast<double>(settings.streams * T));
  };
  const auto fill = [&](Part& part, std::vector<Walk>& streams) {
    const Index B = part.streams();
    for (Index s = 0; s < B; ++s) {
      Walk& walk = streams[static_cast<std::size_t>(s)];
      if (walk.left <= 0 || walk.at + T > data[walk.recording].y.size()) begin_anew(walk, part, s);
      const ScaledSeries& from = data[walk.recording];
      for (Index t = 0; t < T; ++t) {
        const Index k = walk.at + t;
        part.stretch.exogenous.col(t * B + s) = from.exogenous.col(k - 1);
        part.stretch.y_before(s, t) = from.y(k - 1);
        part.stretch.target(s, t) = from.y(k);
        part.stretch.weight(s, t) = training[walk.recording].is_measured(k) ? weight_at(walk, walk.age + t) : 0.0F;
        part.stretch.free(s, t) = walk.teacher && training[walk.recording].is_measured(k - 1) ? 0.0F : 1.0F;
        if (walk.teacher) part.stretch.y_before(s, t) += static_cast<float>(settings.feedback_noise * noise.normal(noises++));
      }
      walk.at += T;
      walk.left -= T;
      walk.age += T;
    }
  };

  Adam<float> adam(weights.shape.size());
  const AdamSettings rates{settings.rate, 0.0, 0.9, 0.999, 1e-7};
  double sum = 0.0, best = HUGE_VAL;
  Index since_best = 0, since_point = 0;
  Model tried = trained.model;
  const double span = trained.model.scaling.y_span;
  const auto error_of = [&](const Model& model) {
    return root_mean_square(validation, lead_ins, rollouts(model, validation, run.threads));
  };
  if (run.from) {  // weights that came from elsewhere stay where training does not make them better
    best = error_of(trained.model);
    trained.curve.push_back({0, std::nan(""), best});
  }
  for (Index update = 0; update < settings.updates; ++update) {
    if (run.should_stop && run.should_stop()) throw Stopped{};
    for (std::size_t p = 0; p < parts.size(); ++p) fill(parts[p], walks[p]);
    sum += work_on(parts, weights, run.threads);
    ++since_point;
    Vector<float>& gradient = parts.front().gradient.all;
    const double norm = gradient.cast<double>().norm();
    if (!std::isfinite(norm))
      throw std::runtime_error("training diverged at update " + std::to_string(update) + "; a smaller rate may help");
    if (norm > settings.clip_norm) gradient *= static_cast<float>(settings.clip_norm / norm);
    const double done = static_cast<double>(update) / static_cast<double>(settings.updates);
    adam.update(weights.all, gradient, rates, 0.01 + 0.99 * 0.5 * (1.0 + std::cos(std::numbers::pi * done)));
    if ((update + 1) % settings.validation_every != 0 && update + 1 != settings.updates) continue;
    tried.weights = weights;
    const double error = error_of(tried);
    trained.curve.push_back({update + 1, span * std::sqrt(sum / static_cast<double>(since_point)), error});
    sum = 0.0;
    since_point = 0;
    ++since_best;
    if (error < best) {
      best = error;
      since_best = 0;
      trained.model.weights = weights;
      trained.best_update = update + 1;
    }
    if (run.progress) run.progress(static_cast<double>(update + 1) / static_cast<double>(settings.updates), trained.curve.back());
    if (settings.patience > 0 && since_best >= settings.patience) break;
  }
  if (!std::isfinite(best))
    throw std::runtime_error("training diverged: no rollout over what was set aside had a finite error; a smaller rate may help");
  return trained;
}

}  // namespace sinew::model
