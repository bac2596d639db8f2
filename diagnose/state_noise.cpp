// SPDX-License-Identifier: Apache-2.0
#include "diagnose/state_noise.h"

#include <algorithm>
#include <cmath>

#include "diagnose/padded.h"

namespace sinew::diagnose {
namespace {

constexpr int padded_forcings = (static_cast<int>(forcing_entries) + 1 + 3) / 4 * 4;  // one may wander

}  // namespace

Blocks::Blocks(const FitProblem& problem) {
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const auto& samples = data.recording->samples;
    long last = -1;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      const long index = static_cast<long>(std::floor((samples[k].time_s - samples.front().time_s) / period_s + 1e-6));
      if (k == 0 || index != last) blocks_.push_back({r, k, k, 0.0, {no_row, no_row, no_row}});
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

StateNoise::StateNoise(const FitProblem& problem, const Blocks& blocks, const double* z, const Path& path,
                       const VaryingPush* varying)
    : blocks_(blocks), varies_(varying != nullptr) {
  const plant::Limb<double> limb = problem.limb_at(z);
  states_ = plant::layout_of(limb.on).size();
  padded_states_ = with_padded_size(states_, [](auto size) { return static_cast<Eigen::Index>(size.value); });
  const auto n = static_cast<Eigen::Index>(states_), q = static_cast<Eigen::Index>(forcing_entries + (varying ? 1 : 0));
  const Eigen::Index all = padded_states_ + padded_forcings, last = q - 1;
  Eigen::MatrixXd push = Eigen::MatrixXd::Zero(n, q), direct = Eigen::MatrixXd::Zero(3, q);
  for (std::size_t e = 0; e < forcing_entries; ++e) {
    const auto j = static_cast<Eigen::Index>(e);
    const auto coil = static_cast<Eigen::Index>(forcing_entry[e].coil);
    switch (forcing_entry[e].forcing) {
      case Forcing::air:
        break;  // changes along the path
      case Forcing::heat:
        push(coil, j) = 1.0 / limb.core.heat_capacity_J_K[forcing_entry[e].coil];
        break;
      case Forcing::transformation:
        push(2 + coil, j) = 1.0;
        break;
      case Forcing::moment:
        push(static_cast<Eigen::Index>(plant::core_state::angular_velocity), j) = 1.0 / limb.core.beam_inertia_kgm2;
        break;
      case Forcing::temperature_reading:
        direct(coil, j) = 1.0;
        break;
      case Forcing::angle_reading:
        direct(2, j) = 1.0;
        break;
    }
  }
  // A block's state is that of its first sample; what its mean shows is what each of its samples makes of that state.
  Eigen::MatrixXd since(all, all), last_transition = Eigen::MatrixXd::Identity(all, all), product = Eigen::MatrixXd::Zero(all, all);
  for (std::size_t b = 0; b < blocks_.blocks().size(); ++b) {
    const Blocks::Block& block = blocks_.blocks()[b];
    const FitData& data = problem.data()[block.recording];
    const auto& samples = data.recording->samples;
    const std::vector<PathPoint>& points = path.points[block.recording];
    Step step;
    step.first_of_recording = b == 0 || blocks_.blocks()[b - 1].recording != block.recording;
    step.transition = last_transition;
    Eigen::MatrixXd reading = Eigen::MatrixXd::Zero(3, all);
    since.setIdentity();
    for (std::size_t k = block.first_sample; k <= block.last_sample; ++k) {
      const PathPoint& point = points[k];
      direct.col(0) = point.reading_ambient;
      if (varying) direct.col(last) = varying->readings[block.recording][k];
      reading.noalias() += point.reading * since.topRows(n);
      reading.noalias() += direct * since.middleRows(padded_states_, q);
      if (point.transition.size() == 0) continue;
      push.col(0) = point.ambient;
      if (varying) push.col(last) = varying->rates[block.recording][k];
      const Eigen::MatrixXd pushed = point.integral * push;
      product.topRows(n).noalias() = point.transition * since.topRows(n);
      product.topRows(n).noalias() += pushed * since.middleRows(padded_states_, q);
      for (std::size_t e = 0; e < static_cast<std::size_t>(q); ++e) {
        const Eigen::Index j = forcing_state(e);
        const double tau_s = e < forcing_entries
                                 ? forcings[static_cast<std::size_t>(forcing_entry[e].forcing)].correlation_time_s
                                 : varying->correlation_time_s;
        product.row(j) = since.row(j) * std::exp(-(samples[k + 1].time_s - samples[k].time_s) / tau_s);
      }
      since = product;
    }
    last_transition = since;
    reading /= static_cast<double>(block.last_sample - block.first_sample + 1);
    for (std::size_t c = 0; c < channel_count; ++c)
      reading.row(static_cast<Eigen::Index>(c)) /= channels[c].internal_per_unit * data.deviation[c];
    step.reading = reading.transpose();
    steps_.push_back(std::move(step));
  }
}

void StateNoise::filter(std::vector<Eigen::MatrixXd>* predicted) {
  with_padded_size(states_, [&](auto size) { filter_padded<size.value>(predicted); });
}

// With the limb's states above and the forcings' below, a step is [A B; 0 D] with D diagonal: of the covariance [X Y; Y^T Z] that
// makes X' = (A X + B Y^T) A^T + (A Y + B Z) B^T and Y' = (A Y + B Z) D.
template <int Size>
[[gnu::flatten]] void StateNoise::filter_padded(std::vector<Eigen::MatrixXd>* predicted) {
  constexpr int all = Size + padded_forcings;
  using Whole = Eigen::Matrix<double, all, all>;
  using Limb = Eigen::Matrix<double, Size, Size>;
  using Push = Eigen::Matrix<double, Size, padded_forcings>;
  using Forced = Eigen::Matrix<double, padded_forcings, padded_forcings>;
  Eigen::Vector<double, padded_forcings> variance_of = Eigen::Vector<double, padded_forcings>::Zero();
  for (std::size_t e = 0; e < forcing_entries; ++e)
    variance_of(static_cast<Eigen::Index>(e)) = std::pow(size_[static_cast<std::size_t>(forcing_entry[e].forcing)], 2);
  if (varies_) variance_of(static_cast<Eigen::Index>(forcing_entries)) = std::pow(varying_size_, 2);
  gains_.resize(steps_.size());
  if (predicted) predicted->clear();
  log_determinant_ = 0.0;
  Whole covariance;
  for (std::size_t b = 0; b < steps_.size(); ++b) {
    const Step& step = steps_[b];
    if (step.first_of_recording) {
      covariance.setZero();
      covariance.template bottomRightCorner<padded_forcings, padded_forcings>().diagonal() = variance_of;
    } else {
      const Eigen::Map<const Whole> transition(step.transition.data());
      const Limb a = transition.template topLeftCorner<Size, Size>(), x = covariance.template topLeftCorner<Size, Size>();
      const Push push = transition.template topRightCorner<Size, padded_forcings>(),
                 y = covariance.template topRightCorner<Size, padded_forcings>();
      const Eigen::Vector<double, padded_forcings> decay =
          transition.template bottomRightCorner<padded_forcings, padded_forcings>().diagonal();
      Forced z = covariance.template bottomRightCorner<padded_forcings, padded_forcings>();
      Limb limb = a.lazyProduct(x);
      limb += push.lazyProduct(y.transpose());
      Push across = a.lazyProduct(y);
      across += push.lazyProduct(z);
      Limb spread = limb.lazyProduct(a.transpose());
      spread += across.lazyProduct(push.transpose());
      across = across * decay.asDiagonal();
      z = decay.asDiagonal() * z * decay.asDiagonal();
      z.diagonal() += variance_of.cwiseProduct((1.0 - decay.array().square()).matrix());
      covariance.template topLeftCorner<Size, Size>() = spread;
      covariance.template topRightCorner<Size, padded_forcings>() = across;
      covariance.template bottomLeftCorner<padded_forcings, Size>() = across.transpose();
      covariance.template bottomRightCorner<padded_forcings, padded_forcings>() = z;
    }
    if (predicted) predicted->push_back(covariance);
    Gain& gain = gains_[b];
    gain.gain.resize(all, static_cast<Eigen::Index>(channel_count));
    for (std::size_t c = 0; c < channel_count; ++c) {
      gain.variance[c] = 0.0;
      const std::size_t row = blocks_.blocks()[b].row[c];
      if (row == Blocks::no_row) continue;
      const auto column = static_cast<Eigen::Index>(c);
      const Eigen::Map<const Eigen::Vector<double, all>> h(step.reading.col(column).data());
      const Eigen::Vector<double, all> seen = covariance.lazyProduct(h);
      const double variance = h.dot(seen) + 1.0 / blocks_.rows()[row].count;
      const Eigen::Vector<double, all> by = seen / variance;
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
  with_padded_size(states_, [&](auto size) { whiten_padded<size.value>(columns); });
}

template <int Size>
[[gnu::flatten]] void StateNoise::whiten_padded(Eigen::Ref<Eigen::MatrixXd> columns) const {
  constexpr int all = Size + padded_forcings;
  using Whole = Eigen::Matrix<double, all, all>;
  Eigen::Matrix<double, all, Eigen::Dynamic> state = Eigen::MatrixXd::Zero(all, columns.cols());
  Eigen::Matrix<double, Size, Eigen::Dynamic> next(Size, columns.cols());
  Eigen::RowVectorXd innovation(columns.cols());
  for (std::size_t b = 0; b < gains_.size(); ++b) {
    const Gain& gain = gains_[b];
    if (steps_[b].first_of_recording) {
      state.setZero();
    } else {
      const Eigen::Map<const Whole> transition(steps_[b].transition.data());
      next = transition.template topRows<Size>().lazyProduct(state);
      const auto decay = transition.template bottomRightCorner<padded_forcings, padded_forcings>().diagonal();
      state.template bottomRows<padded_forcings>().array().colwise() *= decay.array();
      state.template topRows<Size>() = next;
    }
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (gain.variance[c] == 0.0) continue;
      const auto row = static_cast<Eigen::Index>(blocks_.blocks()[b].row[c]), column = static_cast<Eigen::Index>(c);
      const Eigen::Map<const Eigen::Vector<double, all>> h(steps_[b].reading.col(column).data()),
          by(gain.gain.col(column).data());
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

ForcingSize StateNoise::maximise(const Eigen::VectorXd& residual, const ForcingSize& begin,
                                 const FreeForcings& free, double most_air_K, double finest_factor) {
  // Coordinate ascent in the logarithm: steps of a factor, halved in the exponent when none helps. The last coordinate is
  // the strength that wanders.
  constexpr double floor_share = 1.0 / 100.0, most_share = 200.0;
  constexpr std::size_t all = forcing_count + 1;
  std::array<double, all> best{}, typical{};
  std::array<bool, all> is_free{};
  for (std::size_t q = 0; q < forcing_count; ++q)
    best[q] = begin[q], typical[q] = forcings[q].typical, is_free[q] = free[q];
  best.back() = varying_size_;
  typical.back() = 1.0;
  is_free.back() = varies_;
  const auto likelihood_of = [&](const std::array<double, all>& size) {
    ForcingSize forcing;
    std::copy_n(size.begin(), forcing_count, forcing.begin());
    set(forcing, size.back());
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
      const double lowest = typical[q] * floor_share, highest = q == 0 ? most_air_K : typical[q] * most_share;
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
  const Eigen::Index m = padded_states_ + padded_forcings;
  std::vector<Eigen::VectorXd> predicted(count);
  std::vector<std::array<double, channel_count>> innovation(count);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(m);
  for (std::size_t b = 0; b < count; ++b) {
    const Gain& gain = again.gains_[b];
    state = steps_[b].first_of_recording ? Eigen::VectorXd::Zero(m) : Eigen::VectorXd(steps_[b].transition * state);
    predicted[b] = state;
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (gain.variance[c] == 0.0) continue;
      const auto column = static_cast<Eigen::Index>(c);
      innovation[b][c] = residual(static_cast<Eigen::Index>(blocks_.blocks()[b].row[c])) - steps_[b].reading.col(column).dot(state);
      state += gain.gain.col(column) * innovation[b][c];
    }
  }
  Smoothed result;
  const auto blocks = static_cast<Eigen::Index>(count);
  for (std::size_t q = 0; q < forcing_entries; ++q) {
    result.forcing[q] = Eigen::VectorXd::Zero(blocks);
    result.deviation[q] = Eigen::VectorXd::Zero(blocks);
  }
  if (varies_) result.varying = result.varying_deviation = Eigen::VectorXd::Zero(blocks);
  Eigen::VectorXd adjoint = Eigen::VectorXd::Zero(m);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (std::size_t b = count; b-- > 0;) {
    const Gain& gain = again.gains_[b];
    for (std::size_t c = channel_count; c-- > 0;) {
      if (gain.variance[c] == 0.0) continue;
      const auto column = static_cast<Eigen::Index>(c);
      const Eigen::VectorXd h = steps_[b].reading.col(column);
      const Eigen::MatrixXd through = Eigen::MatrixXd::Identity(m, m) - gain.gain.col(column) * h.transpose();
      adjoint = h * (innovation[b][c] / gain.variance[c]) + through.transpose() * adjoint;
      information = h * h.transpose() / gain.variance[c] + through.transpose() * information * through;
    }
    const Eigen::VectorXd smoothed = predicted[b] + covariance[b] * adjoint;
    for (std::size_t q = 0; q < forcing_entries + (varies_ ? 1 : 0); ++q) {
      const Eigen::Index i = forcing_state(q);
      const Eigen::RowVectorXd row = covariance[b].row(i);
      (q < forcing_entries ? result.forcing[q] : result.varying)(static_cast<Eigen::Index>(b)) = smoothed(i);
      (q < forcing_entries ? result.deviation[q] : result.varying_deviation)(static_cast<Eigen::Index>(b)) =
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
  // What each forcing alone would do: the limb's linearised equations, driven by its estimate.
  result.response =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(blocks_.rows().size()), static_cast<Eigen::Index>(forcing_count));
  for (std::size_t f = 0; f < forcing_count; ++f) {
    if (size_[f] == 0.0) continue;
    Eigen::VectorXd driven = Eigen::VectorXd::Zero(m);
    for (std::size_t b = 0; b < count; ++b) {
      if (steps_[b].first_of_recording)
        driven.setZero();
      else
        driven.head(padded_states_) = (steps_[b].transition.topRows(padded_states_) * driven).eval();
      for (std::size_t q = 0; q < forcing_entries; ++q)
        driven(forcing_state(q)) = static_cast<std::size_t>(forcing_entry[q].forcing) == f
                                                          ? result.forcing[q](static_cast<Eigen::Index>(b))
                                                          : 0.0;
      for (std::size_t c = 0; c < channel_count; ++c)
        if (const std::size_t row = blocks_.blocks()[b].row[c]; row != Blocks::no_row)
          result.response(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(f)) =
              steps_[b].reading.col(static_cast<Eigen::Index>(c)).dot(driven);
    }
  }
  return result;
}

}  // namespace sinew::diagnose
