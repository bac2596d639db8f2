// SPDX-License-Identifier: Apache-2.0
#include "diagnose/state_noise.h"

#include <algorithm>
#include <cmath>

#include "plant/padded.h"

namespace sinew::diagnose {

using plant::product;
using plant::with_padded_size;

namespace {

// Of the first System: the surroundings and the readings alone, and all nine entries and one strength that varies, with room.
constexpr int few_forcings = 4, unrolled_forcings = 12;

}  // namespace

ForcingSize no_forcing(const plant::System& system) { return ForcingSize(system.entry_groups().size(), 0.0); }

ForcingSize forcing_to_begin_with(const plant::System& system) {
  ForcingSize size;
  for (const plant::EntryGroup& group : system.entry_groups()) size.push_back(group.begin);
  return size;
}

ForcingSize small_forcing(const plant::System& system) {
  ForcingSize size = forcing_to_begin_with(system);
  for (const plant::EntryGroupId g : size.ids())
    if (!system.entry_groups()[g].is_nuisance) size[g] *= 0.1;
  return size;
}

ForcingSize only_nuisance(const plant::System& system, double size) {
  ForcingSize result = no_forcing(system);
  for (const plant::EntryGroupId g : result.ids())
    if (system.entry_groups()[g].is_nuisance) result[g] = size;
  return result;
}

double nuisance_of(const plant::System& system, const ForcingSize& size) {
  for (const plant::EntryGroupId g : size.ids())
    if (system.entry_groups()[g].is_nuisance) return size[g];
  return 0.0;
}

FreeForcings with_a_size(const ForcingSize& size) {
  FreeForcings some;
  for (const double one : size) some.push_back(one > 0.0);
  return some;
}

FreeForcings all_free(const plant::System& system) { return FreeForcings(system.entry_groups().size(), true); }

FreeForcings nuisance_free(const plant::System& system) {
  FreeForcings free;
  for (const plant::EntryGroup& group : system.entry_groups()) free.push_back(group.is_nuisance);
  return free;
}

FreeForcings ordinary_free(const plant::System& system) {
  FreeForcings free;
  for (const plant::EntryGroup& group : system.entry_groups()) free.push_back(group.ordinary > 0.0);
  return free;
}

FreeForcings nuisance_and(const plant::System& system, plant::EntryGroupId group) {
  FreeForcings free = nuisance_free(system);
  free[group] = true;
  return free;
}

Blocks::Blocks(const FitProblem& problem) {
  const plant::ListOf<plant::ChannelId, std::size_t> none(problem.system().channels().size(), no_row);
  const double period_s = problem.system().averaging_s();
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const auto& samples = data.recording->samples;
    long last = -1;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      const long index = period_s > 0.0 ? static_cast<long>(std::floor((samples[k].time_s - samples.front().time_s) / period_s + 1e-6))
                                        : static_cast<long>(k);
      if (k == 0 || index != last) blocks_.push_back({r, k, k, 0.0, none});
      last = index;
      blocks_.back().last_sample = k;
    }
  }
  std::size_t b = 0;
  for (const auto& row : problem.rows()) {
    while (blocks_[b].recording != row.recording || row.sample > blocks_[b].last_sample) ++b;
    Block& block = blocks_[b];
    if (block.row[row.channel] == no_row) {
      block.row[row.channel] = rows_.size();
      rows_.push_back({row.recording, b, row.channel, 0.0});
    }
    rows_[block.row[row.channel]].count += 1.0;
    block_row_of_.push_back(block.row[row.channel]);
  }
  for (Block& block : blocks_) {
    const auto& samples = problem.data()[block.recording].recording->samples;
    block.time_s = 0.5 * (samples[block.first_sample].time_s + samples[block.last_sample].time_s);
  }
}

Eigen::MatrixXd Blocks::means(const double* problem_rows, std::size_t columns) const {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> sum =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows_.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < block_row_of_.size(); ++i)
    sum.row(static_cast<Eigen::Index>(block_row_of_[i])) +=
        Eigen::Map<const Eigen::RowVectorXd>(problem_rows + i * columns, static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows_.size(); ++i) sum.row(static_cast<Eigen::Index>(i)) /= rows_[i].count;
  return sum;
}

StateNoise::StateNoise(const FitProblem& problem, const Blocks& blocks, const double* z, const Path& path, const VaryingPush* varying,
                       const FreeForcings& groups)
    : system_(problem.system()), blocks_(blocks), varies_(varying != nullptr) {
  const plant::Plant plant = problem.plant_at(z);
  const std::vector<plant::Entry>& entries = system_.entries();
  states_ = plant.states().size();
  padded_states_ = plant::padded(states_);
  for (std::size_t e = 0; e < entries.size(); ++e)
    if (groups.empty() || groups[entries[e].group]) used_.push_back(e);
  const std::size_t forcings = this->forcings();
  padded_forcings_ = forcings <= few_forcings        ? few_forcings
                     : forcings <= unrolled_forcings ? unrolled_forcings
                                                     : static_cast<Eigen::Index>(forcings);
  size_ = no_forcing(system_);
  const auto n = static_cast<Eigen::Index>(states_), q = static_cast<Eigen::Index>(forcings),
             channels = static_cast<Eigen::Index>(system_.channels().size());
  const Eigen::Index all = padded_states_ + padded_forcings_, last = q - 1;
  Eigen::MatrixXd push = Eigen::MatrixXd::Zero(n, q), direct = Eigen::MatrixXd::Zero(channels, q);
  push.leftCols(static_cast<Eigen::Index>(used_.size())) = constant_push(plant);
  std::vector<Eigen::Index> along_the_path;  // entries that push by what the path itself says
  for (std::size_t k = 0; k < used_.size(); ++k) {
    const auto j = static_cast<Eigen::Index>(k);
    const plant::Entry& entry = entries[used_[k]];
    if (entry.channel) direct(static_cast<Eigen::Index>(entry.channel->index), j) = 1.0;
    if (entry.parameter) along_the_path.push_back(j);
  }
  // A block's state is that of its first sample; what its mean shows is what each of its samples makes of that state.
  Eigen::MatrixXd since(all, all), last_transition = Eigen::MatrixXd::Identity(all, all), moved = Eigen::MatrixXd::Zero(all, all);
  for (std::size_t b = 0; b < blocks_.blocks().size(); ++b) {
    const Blocks::Block& block = blocks_.blocks()[b];
    const FitData& data = problem.data()[block.recording];
    const auto& samples = data.recording->samples;
    const std::vector<PathPoint>& points = path.points[block.recording];
    Step step;
    step.first_of_recording = b == 0 || blocks_.blocks()[b - 1].recording != block.recording;
    step.transition = last_transition;
    Eigen::MatrixXd reading = Eigen::MatrixXd::Zero(channels, all);
    since.setIdentity();
    for (std::size_t k = block.first_sample; k <= block.last_sample; ++k) {
      const PathPoint& point = points[k];
      for (const Eigen::Index j : along_the_path) direct.col(j) = point.reading_ambient;
      if (varying) direct.col(last) = varying->readings[block.recording][k];
      reading.noalias() += point.reading * since.topRows(n);
      reading.noalias() += direct * since.middleRows(padded_states_, q);
      if (point.transition.size() == 0) continue;
      for (const Eigen::Index j : along_the_path) push.col(j) = point.ambient;
      if (varying) push.col(last) = varying->rates[block.recording][k];
      const Eigen::MatrixXd pushed = point.integral * push;
      moved.topRows(n).noalias() = point.transition * since.topRows(n);
      moved.topRows(n).noalias() += pushed * since.middleRows(padded_states_, q);
      for (std::size_t e = 0; e < forcings; ++e) {
        const Eigen::Index j = forcing_state(e);
        const double tau_s =
            e < used_.size() ? system_.entry_groups()[entries[used_[e]].group].correlation_time_s : varying->correlation_time_s;
        moved.row(j) = since.row(j) * std::exp(-(samples[k + 1].time_s - samples[k].time_s) / tau_s);
      }
      since = moved;
    }
    last_transition = since;
    reading /= static_cast<double>(block.last_sample - block.first_sample + 1);
    for (const plant::ChannelId c : system_.channels().ids())
      reading.row(static_cast<Eigen::Index>(c.index)) /= system_.channels()[c].unit.internal_per_unit * data.deviation[c];
    step.reading = reading.transpose();
    steps_.push_back(std::move(step));
  }
}

Eigen::MatrixXd StateNoise::constant_push(const plant::Plant& plant) const {
  Eigen::MatrixXd push = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(states_), static_cast<Eigen::Index>(used_.size()));
  for (std::size_t k = 0; k < used_.size(); ++k)
    if (const plant::Entry& entry = system_.entries()[used_[k]]; entry.state)
      push(static_cast<Eigen::Index>(entry.state->index), static_cast<Eigen::Index>(k)) =
          entry.divided_by ? 1.0 / plant.get(*entry.divided_by) : 1.0;
  return push;
}

template <class Work>
decltype(auto) StateNoise::with_sizes(Work&& work) const {
  using Any = std::integral_constant<int, Eigen::Dynamic>;
  if (padded_forcings_ != unrolled_forcings && padded_forcings_ != few_forcings) return work(Any{}, Any{});
  return with_padded_size(states_, [&](auto size) {
    if constexpr (size.value == Eigen::Dynamic)
      return work(Any{}, Any{});
    else if (padded_forcings_ == few_forcings)
      return work(size, std::integral_constant<int, few_forcings>{});
    else
      return work(size, std::integral_constant<int, unrolled_forcings>{});
  });
}

void StateNoise::filter(std::vector<Eigen::MatrixXd>* predicted) {
  with_sizes([&](auto size, auto forcings) { filter_padded<size.value, forcings.value>(predicted); });
}

// With the plant's states above and the forcings' below, a step is [A B; 0 D] with D diagonal: of the covariance [X Y; Y^T Z] that
// makes X' = (A X + B Y^T) A^T + (A Y + B Z) B^T and Y' = (A Y + B Z) D.
template <int Size, int Forcings>
SINEW_FLATTEN void StateNoise::filter_padded(std::vector<Eigen::MatrixXd>* predicted) {
  constexpr int all = Size == Eigen::Dynamic ? Eigen::Dynamic : Size + Forcings;
  const Eigen::Index n = padded_states_, q = padded_forcings_, m = n + q;
  using Whole = Eigen::Matrix<double, all, all>;
  using Own = Eigen::Matrix<double, Size, Size>;
  using Push = Eigen::Matrix<double, Size, Forcings>;
  using Forced = Eigen::Matrix<double, Forcings, Forcings>;
  using Column = Eigen::Vector<double, all>;
  const std::vector<plant::Entry>& entries = system_.entries();
  Eigen::Vector<double, Forcings> variance_of = Eigen::Vector<double, Forcings>::Zero(q);
  for (std::size_t k = 0; k < used_.size(); ++k) variance_of(static_cast<Eigen::Index>(k)) = std::pow(size_[entries[used_[k]].group], 2);
  if (varies_) variance_of(static_cast<Eigen::Index>(used_.size())) = std::pow(varying_size_, 2);
  gains_.resize(steps_.size());
  if (predicted) predicted->clear();
  log_determinant_ = 0.0;
  Whole covariance(m, m);
  for (std::size_t b = 0; b < steps_.size(); ++b) {
    const Step& step = steps_[b];
    if (step.first_of_recording) {
      covariance.setZero();
      covariance.bottomRightCorner(q, q).diagonal() = variance_of;
    } else {
      const Eigen::Map<const Whole> transition(step.transition.data(), m, m);
      const Own a = transition.template topLeftCorner<Size, Size>(n, n), x = covariance.template topLeftCorner<Size, Size>(n, n);
      const Push push = transition.template topRightCorner<Size, Forcings>(n, q),
                 y = covariance.template topRightCorner<Size, Forcings>(n, q);
      const Eigen::Vector<double, Forcings> decay = transition.template bottomRightCorner<Forcings, Forcings>(q, q).diagonal();
      Forced z = covariance.template bottomRightCorner<Forcings, Forcings>(q, q);
      Own own = product<Size>(a, x);
      own += product<Size>(push, y.transpose());
      Push across = product<Size>(a, y);
      across += product<Size>(push, z);
      Own spread = product<Size>(own, a.transpose());
      spread += product<Size>(across, push.transpose());
      across = across * decay.asDiagonal();
      z = decay.asDiagonal() * z * decay.asDiagonal();
      z.diagonal() += variance_of.cwiseProduct((1.0 - decay.array().square()).matrix());
      covariance.template topLeftCorner<Size, Size>(n, n) = spread;
      covariance.template topRightCorner<Size, Forcings>(n, q) = across;
      covariance.template bottomLeftCorner<Forcings, Size>(q, n) = across.transpose();
      covariance.template bottomRightCorner<Forcings, Forcings>(q, q) = z;
    }
    if (predicted) predicted->push_back(covariance);
    Gain& gain = gains_[b];
    gain.gain.resize(m, static_cast<Eigen::Index>(system_.channels().size()));
    gain.variance = per_channel(system_);
    for (const plant::ChannelId c : system_.channels().ids()) {
      const std::size_t row = blocks_.blocks()[b].row[c];
      if (row == Blocks::no_row) continue;
      const auto column = static_cast<Eigen::Index>(c.index);
      const Eigen::Map<const Column> h(step.reading.col(column).data(), m);
      const Column seen = product<Size>(covariance, h);
      const double variance = h.dot(seen) + 1.0 / blocks_.rows()[row].count;
      const Column by = seen / variance;
      covariance -= by.lazyProduct(seen.transpose());
      gain.gain.col(column) = by;
      gain.variance[c] = variance;
      log_determinant_ += std::log(variance * blocks_.rows()[row].count);
    }
  }
}

void StateNoise::set(const ForcingSize& size) { set(size, 0.0); }

void StateNoise::set(const ForcingSize& size, double varying) {
  size_ = size;
  varying_size_ = varying;
  filter(nullptr);
}

void StateNoise::whiten(Eigen::Ref<Eigen::MatrixXd> columns) const {
  with_sizes([&](auto size, auto forcings) { whiten_padded<size.value, forcings.value>(columns); });
}

template <int Size, int Forcings>
SINEW_FLATTEN void StateNoise::whiten_padded(Eigen::Ref<Eigen::MatrixXd> columns) const {
  constexpr int all = Size == Eigen::Dynamic ? Eigen::Dynamic : Size + Forcings;
  const Eigen::Index n = padded_states_, q = padded_forcings_, m = n + q;
  using Whole = Eigen::Matrix<double, all, all>;
  Eigen::Matrix<double, all, Eigen::Dynamic> state = Eigen::MatrixXd::Zero(m, columns.cols());
  Eigen::Matrix<double, Size, Eigen::Dynamic> next(n, columns.cols());
  Eigen::RowVectorXd innovation(columns.cols());
  for (std::size_t b = 0; b < gains_.size(); ++b) {
    const Gain& gain = gains_[b];
    if (steps_[b].first_of_recording) {
      state.setZero();
    } else {
      const Eigen::Map<const Whole> transition(steps_[b].transition.data(), m, m);
      next = product<Size>(transition.template topRows<Size>(n), state);
      const auto decay = transition.template bottomRightCorner<Forcings, Forcings>(q, q).diagonal();
      state.template bottomRows<Forcings>(q).array().colwise() *= decay.array();
      state.template topRows<Size>(n) = next;
    }
    for (const plant::ChannelId c : system_.channels().ids()) {
      if (gain.variance[c] == 0.0) continue;
      const auto row = static_cast<Eigen::Index>(blocks_.blocks()[b].row[c]), column = static_cast<Eigen::Index>(c.index);
      const Eigen::Map<const Eigen::Vector<double, all>> h(steps_[b].reading.col(column).data(), m), by(gain.gain.col(column).data(), m);
      innovation = columns.row(row) - h.transpose().lazyProduct(state);
      state += by.lazyProduct(innovation);
      columns.row(row) = innovation / std::sqrt(gain.variance[c]);
    }
  }
}

double StateNoise::log_likelihood(const Eigen::VectorXd& residual) const {
  Eigen::MatrixXd whitened = residual;
  whiten(whitened);
  return -0.5 * (whitened.squaredNorm() + log_determinant_);
}

ForcingSize StateNoise::maximise(const Eigen::VectorXd& residual, const ForcingSize& begin, const FreeForcings& free, double finest_factor,
                                 bool only_ordinary) {
  // Coordinate ascent in the logarithm: steps of a factor, halved in the exponent when none helps. The last coordinate is
  // the strength that varies.
  constexpr double floor_share = 1.0 / 100.0, most_share = 200.0;
  using Sizes = std::vector<double>;
  const std::size_t groups = system_.entry_groups().size(), all = groups + 1;
  Sizes best, typical, most;
  std::vector<bool> is_free;
  for (const plant::EntryGroupId g : system_.entry_groups().ids()) {
    const plant::EntryGroup& group = system_.entry_groups()[g];
    typical.push_back(group.typical);
    const bool is_limited = group.ordinary > 0.0 && (group.is_nuisance || only_ordinary);
    most.push_back(is_limited ? group.ordinary : group.typical * most_share);
    best.push_back(free[g] ? std::min(begin[g], most.back()) : begin[g]);
    is_free.push_back(free[g]);
  }
  best.push_back(varying_size_);
  typical.push_back(1.0);
  most.push_back(most_share);
  is_free.push_back(varies_);
  const auto likelihood_of = [&](const Sizes& size) {
    set(ForcingSize(Sizes(size.begin(), size.end() - 1)), size.back());
    return log_likelihood(residual);
  };
  for (std::size_t q = 0; q < all; ++q)
    if (is_free[q] && best[q] <= typical[q] * floor_share) best[q] = typical[q] * floor_share * 2.0;
  double best_likelihood = likelihood_of(best);
  double factor = 4.0;
  for (int sweep = 0; sweep < 12 && factor > finest_factor; ++sweep) {
    bool moved = false;
    for (std::size_t q = 0; q < all; ++q) {
      if (!is_free[q]) continue;
      const double lowest = typical[q] * floor_share, highest = most[q];
      for (const double by : {factor, 1.0 / factor}) {
        bool helped = false;
        for (int step = 0; step < 6; ++step) {
          auto tried = best;
          tried[q] = std::clamp(best[q] > 0.0 ? best[q] * by : lowest * by, lowest, highest);
          if (tried[q] <= lowest) tried[q] = 0.0;
          if (tried[q] == best[q]) break;
          const double likelihood = likelihood_of(tried);
          if (likelihood <= best_likelihood + 1e-3) break;
          best_likelihood = likelihood;
          best = tried;
          helped = moved = true;
          if (best[q] == 0.0) break;
        }
        if (helped) break;
      }
    }
    if (!moved) factor = std::sqrt(factor);
  }
  likelihood_of(best);
  return size_;
}

Smoothed StateNoise::smooth(const Eigen::VectorXd& residual) const {
  StateNoise again = *this;
  std::vector<Eigen::MatrixXd> covariance;
  again.filter(&covariance);
  const std::size_t count = again.gains_.size();
  const Eigen::Index m = padded_states_ + padded_forcings_;
  const std::size_t entries = system_.entries().size();
  std::vector<Eigen::VectorXd> predicted(count);
  std::vector<PerChannel> innovation(count, per_channel(system_));
  Eigen::VectorXd state = Eigen::VectorXd::Zero(m);
  for (std::size_t b = 0; b < count; ++b) {
    const Gain& gain = again.gains_[b];
    state = steps_[b].first_of_recording ? Eigen::VectorXd::Zero(m) : Eigen::VectorXd(steps_[b].transition * state);
    predicted[b] = state;
    for (const plant::ChannelId c : system_.channels().ids()) {
      if (gain.variance[c] == 0.0) continue;
      const auto column = static_cast<Eigen::Index>(c.index);
      innovation[b][c] = residual(static_cast<Eigen::Index>(blocks_.blocks()[b].row[c])) - steps_[b].reading.col(column).dot(state);
      state += gain.gain.col(column) * innovation[b][c];
    }
  }
  Smoothed result;
  const auto blocks = static_cast<Eigen::Index>(count);
  result.forcing.assign(entries, Eigen::VectorXd::Zero(blocks));
  result.deviation = result.forcing;
  if (varies_) result.varying = result.varying_deviation = Eigen::VectorXd::Zero(blocks);
  Eigen::VectorXd adjoint = Eigen::VectorXd::Zero(m);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (std::size_t b = count; b-- > 0;) {
    const Gain& gain = again.gains_[b];
    for (std::size_t k = system_.channels().size(); k-- > 0;) {
      const plant::ChannelId c{k};
      if (gain.variance[c] == 0.0) continue;
      const auto column = static_cast<Eigen::Index>(k);
      const Eigen::VectorXd h = steps_[b].reading.col(column);
      const Eigen::MatrixXd through = Eigen::MatrixXd::Identity(m, m) - gain.gain.col(column) * h.transpose();
      adjoint = h * (innovation[b][c] / gain.variance[c]) + through.transpose() * adjoint;
      information = h * h.transpose() / gain.variance[c] + through.transpose() * information * through;
    }
    const Eigen::VectorXd smoothed = predicted[b] + covariance[b] * adjoint;
    for (std::size_t q = 0; q < forcings(); ++q) {
      const Eigen::Index i = forcing_state(q);
      const Eigen::RowVectorXd row = covariance[b].row(i);
      const bool of_entry = q < used_.size();
      (of_entry ? result.forcing[used_[q]] : result.varying)(static_cast<Eigen::Index>(b)) = smoothed(i);
      (of_entry ? result.deviation[used_[q]] : result.varying_deviation)(static_cast<Eigen::Index>(b)) =
          std::sqrt(std::max(0.0, covariance[b](i, i) - (row * information).dot(row)));
    }
    if (steps_[b].first_of_recording) {
      adjoint.setZero();
      information.setZero();
    } else {
      adjoint = (steps_[b].transition.transpose() * adjoint).eval();
      information = (steps_[b].transition.transpose() * information * steps_[b].transition).eval();
    }
  }
  // What each forcing alone would do: the plant's linearised equations, driven by its estimate.
  result.response =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(blocks_.rows().size()), static_cast<Eigen::Index>(system_.entry_groups().size()));
  for (const plant::EntryGroupId g : system_.entry_groups().ids()) {
    if (size_[g] == 0.0) continue;
    Eigen::VectorXd driven = Eigen::VectorXd::Zero(m);
    for (std::size_t b = 0; b < count; ++b) {
      if (steps_[b].first_of_recording)
        driven.setZero();
      else
        driven.head(padded_states_) = (steps_[b].transition.topRows(padded_states_) * driven).eval();
      for (std::size_t k = 0; k < used_.size(); ++k)
        driven(forcing_state(k)) = system_.entries()[used_[k]].group == g ? result.forcing[used_[k]](static_cast<Eigen::Index>(b)) : 0.0;
      for (const plant::ChannelId c : system_.channels().ids())
        if (const std::size_t row = blocks_.blocks()[b].row[c]; row != Blocks::no_row)
          result.response(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(g.index)) =
              steps_[b].reading.col(static_cast<Eigen::Index>(c.index)).dot(driven);
    }
  }
  return result;
}

// A residual is what the plant shows too much: so much of each forcing is taken off.
std::vector<Eigen::MatrixXd> StateNoise::pushes(const Eigen::VectorXd& residual, const FitProblem& problem, const double* z,
                                                const Path& path, Of which) const {
  const Smoothed smoothed = smooth(residual);
  Eigen::MatrixXd push = constant_push(problem.plant_at(z));
  std::vector<Eigen::MatrixXd> result;
  for (const FitData& data : problem.data())
    result.emplace_back(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(states_), static_cast<Eigen::Index>(data.sample_count) - 1));
  Eigen::VectorXd forcing(static_cast<Eigen::Index>(used_.size()));
  for (std::size_t b = 0; b < blocks_.blocks().size(); ++b) {
    const Blocks::Block& block = blocks_.blocks()[b];
    const auto& samples = problem.data()[block.recording].recording->samples;
    for (std::size_t k = block.first_sample; k <= block.last_sample; ++k) {
      const PathPoint& point = path.points[block.recording][k];
      if (point.transition.size() == 0) continue;
      // A block's state is that of its first sample; from there on forcings fade.
      for (std::size_t e = 0; e < used_.size(); ++e) {
        const plant::Entry& entry = system_.entries()[used_[e]];
        const double tau_s = system_.entry_groups()[entry.group].correlation_time_s;
        if (entry.parameter)
          push.col(static_cast<Eigen::Index>(e)) = point.ambient;
        else if (which == Of::surroundings)
          push.col(static_cast<Eigen::Index>(e)).setZero();
        forcing(static_cast<Eigen::Index>(e)) = smoothed.forcing[used_[e]](static_cast<Eigen::Index>(b)) *
                                                std::exp(-(samples[k].time_s - samples[block.first_sample].time_s) / tau_s);
      }
      result[block.recording].col(static_cast<Eigen::Index>(k)) = -(point.integral * (push * forcing));
    }
  }
  return result;
}

}  // namespace sinew::diagnose
