#include "diagnose/state_noise.h"

#include <algorithm>
#include <cmath>

namespace sinew::diagnose {

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

StateNoise::StateNoise(const FitProblem& problem, const Blocks& blocks, const double* z, const Path& path)
    : blocks_(blocks) {
  const plant::Limb<double> limb = problem.limb_at(z);
  states_ = plant::layout_of(limb.on).size();
  const auto n = static_cast<Eigen::Index>(states_), q = static_cast<Eigen::Index>(forcing_entries), all = n + q;
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
  Eigen::MatrixXd since(all, all), last_transition = Eigen::MatrixXd::Identity(all, all), product(all, all);
  for (std::size_t b = 0; b < blocks_.blocks().size(); ++b) {
    const Blocks::Block& block = blocks_.blocks()[b];
    const FitData& data = problem.data()[block.recording];
    const auto& samples = data.recording->samples;
    const std::vector<PathPoint>& points = path.points[block.recording];
    Step step;
    step.first_of_recording = b == 0 || blocks_.blocks()[b - 1].recording != block.recording;
    if (step.first_of_recording) {
      step.transition = Eigen::MatrixXd::Identity(all, all);
    } else {
      step.step_s = samples[block.first_sample].time_s - samples[blocks_.blocks()[b - 1].first_sample].time_s;
      step.transition = last_transition;
    }
    step.reading = Eigen::MatrixXd::Zero(3, all);
    since.setIdentity();
    for (std::size_t k = block.first_sample; k <= block.last_sample; ++k) {
      const PathPoint& point = points[k];
      direct.col(0) = point.reading_ambient;
      step.reading.noalias() += point.reading * since.topRows(n);
      step.reading.noalias() += direct * since.bottomRows(q);
      if (point.transition.size() == 0) continue;
      push.col(0) = point.ambient;
      const Eigen::MatrixXd pushed = point.integral * push;
      product.topRows(n).noalias() = point.transition * since.topRows(n);
      product.topRows(n).noalias() += pushed * since.bottomRows(q);
      for (std::size_t e = 0; e < forcing_entries; ++e) {
        const auto j = n + static_cast<Eigen::Index>(e);
        const double tau_s = forcings[static_cast<std::size_t>(forcing_entry[e].forcing)].correlation_time_s;
        product.row(j) = since.row(j) * std::exp(-(samples[k + 1].time_s - samples[k].time_s) / tau_s);
      }
      since.swap(product);
    }
    last_transition = since;
    step.reading /= static_cast<double>(block.last_sample - block.first_sample + 1);
    for (std::size_t c = 0; c < channel_count; ++c)
      step.reading.row(static_cast<Eigen::Index>(c)) /= channels[c].internal_per_unit * data.deviation[c];
    steps_.push_back(std::move(step));
  }
}

void StateNoise::filter(bool keep_covariance) {
  std::vector<std::size_t> taking_part;
  for (std::size_t i = 0; i < states_; ++i) taking_part.push_back(i);
  for (std::size_t q = 0; q < forcing_entries; ++q)
    if (size_[static_cast<std::size_t>(forcing_entry[q].forcing)] > 0.0) taking_part.push_back(states_ + q);
  const bool same = taking_part == taking_part_;  // then the gains' matrices are there already
  taking_part_ = std::move(taking_part);
  const auto m = static_cast<Eigen::Index>(taking_part_.size());
  Eigen::MatrixXd covariance(m, m), product(m, m);
  gains_.resize(steps_.size());
  log_determinant_ = 0.0;
  const auto forcing_of = [&](std::size_t i) {
    return static_cast<std::size_t>(forcing_entry[taking_part_[i] - states_].forcing);
  };
  for (std::size_t b = 0; b < steps_.size(); ++b) {
    const Step& step = steps_[b];
    Gain& gain = gains_[b];
    if (!same) {
      gain.transition.resize(m, m);
      gain.reading.resize(3, m);
    }
    for (Eigen::Index j = 0; j < m && !same; ++j) {
      const auto from = static_cast<Eigen::Index>(taking_part_[static_cast<std::size_t>(j)]);
      for (Eigen::Index i = 0; i < m; ++i)
        gain.transition(i, j) =
            step.transition(static_cast<Eigen::Index>(taking_part_[static_cast<std::size_t>(i)]), from);
      gain.reading.col(j) = step.reading.col(from);
    }
    if (step.first_of_recording) {
      covariance.setZero();
      for (std::size_t i = states_; i < taking_part_.size(); ++i) {
        const double s = size_[forcing_of(i)];
        covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = s * s;
      }
    } else {
      product.noalias() = gain.transition * covariance;
      covariance.noalias() = product * gain.transition.transpose();
      for (std::size_t i = states_; i < taking_part_.size(); ++i) {
        const double s = size_[forcing_of(i)];
        covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) +=
            s * s * (1.0 - std::exp(-2.0 * step.step_s / forcings[forcing_of(i)].correlation_time_s));
      }
    }
    if (keep_covariance) gain.predicted = covariance;
    for (std::size_t c = 0; c < channel_count; ++c) {
      gain.variance[c] = 0.0;
      const std::size_t row = blocks_.blocks()[b].row[c];
      if (row == Blocks::no_row) continue;
      const auto h = gain.reading.row(static_cast<Eigen::Index>(c));
      gain.gain[c].noalias() = covariance * h.transpose();
      const double variance = h.dot(gain.gain[c]) + 1.0 / blocks_.rows()[row].count;
      covariance.noalias() -= gain.gain[c] * (gain.gain[c].transpose() / variance);
      gain.gain[c] /= variance;
      gain.variance[c] = variance;
      log_determinant_ += std::log(variance * blocks_.rows()[row].count);
    }
  }
}

void StateNoise::set(const ForcingSize& size) {
  size_ = size;
  filter(false);
}

void StateNoise::whiten(Eigen::Ref<Eigen::MatrixXd> columns) const {
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(taking_part_.size()), columns.cols());
  Eigen::MatrixXd next = state;
  Eigen::RowVectorXd innovation(columns.cols());
  for (std::size_t b = 0; b < gains_.size(); ++b) {
    const Gain& gain = gains_[b];
    if (steps_[b].first_of_recording) {
      state.setZero();
    } else {
      next.noalias() = gain.transition * state;
      state.swap(next);
    }
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (gain.variance[c] == 0.0) continue;
      const auto row = static_cast<Eigen::Index>(blocks_.blocks()[b].row[c]);
      innovation.noalias() = columns.row(row) - gain.reading.row(static_cast<Eigen::Index>(c)) * state;
      state.noalias() += gain.gain[c] * innovation;
      columns.row(row) = innovation / std::sqrt(gain.variance[c]);
    }
  }
}

double StateNoise::log_likelihood(const Eigen::VectorXd& residual) const {
  Eigen::MatrixXd whitened = residual;
  whiten(whitened);
  return -0.5 * (whitened.squaredNorm() + log_determinant_);
}

double StateNoise::likelihood_of(const Eigen::VectorXd& residual, const ForcingSize& size) {
  set(size);
  return log_likelihood(residual);
}

ForcingSize StateNoise::maximise(const Eigen::VectorXd& residual, const ForcingSize& begin,
                                 const std::array<bool, forcing_count>& free, double most_air_K, double finest_factor) {
  // Coordinate ascent in the logarithm: steps of a factor, halved in the exponent when none helps.
  constexpr double floor_share = 1.0 / 100.0, most_share = 200.0;
  ForcingSize best = begin;
  for (std::size_t q = 0; q < forcing_count; ++q)
    if (free[q] && best[q] <= forcings[q].typical * floor_share) best[q] = forcings[q].typical * floor_share * 2.0;
  double best_likelihood = likelihood_of(residual, best);
  double factor = 4.0;
  for (int sweep = 0; sweep < 12 && factor > finest_factor; ++sweep) {
    bool moved = false;
    for (std::size_t q = 0; q < forcing_count; ++q) {
      if (!free[q]) continue;
      const double lowest = forcings[q].typical * floor_share;
      const double highest = q == 0 ? most_air_K : forcings[q].typical * most_share;
      for (const double by : {factor, 1.0 / factor}) {
        bool helped = false;
        for (int step = 0; step < 6; ++step) {
          ForcingSize tried = best;
          tried[q] = std::clamp(best[q] > 0.0 ? best[q] * by : lowest * by, lowest, highest);
          if (tried[q] <= lowest) tried[q] = 0.0;
          if (tried[q] == best[q]) break;
          const double likelihood = likelihood_of(residual, tried);
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
  set(best);
  return best;
}

Smoothed StateNoise::smooth(const Eigen::VectorXd& residual) const {
  StateNoise again = *this;
  again.filter(true);
  const std::size_t count = again.gains_.size();
  const auto m = static_cast<Eigen::Index>(again.taking_part_.size());
  std::vector<Eigen::VectorXd> predicted(count);
  std::vector<std::array<double, channel_count>> innovation(count);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(m);
  for (std::size_t b = 0; b < count; ++b) {
    const Gain& gain = again.gains_[b];
    state = steps_[b].first_of_recording ? Eigen::VectorXd::Zero(m) : Eigen::VectorXd(gain.transition * state);
    predicted[b] = state;
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (gain.variance[c] == 0.0) continue;
      innovation[b][c] = residual(static_cast<Eigen::Index>(blocks_.blocks()[b].row[c])) -
                         gain.reading.row(static_cast<Eigen::Index>(c)).dot(state);
      state += gain.gain[c] * innovation[b][c];
    }
  }
  Smoothed result;
  const auto blocks = static_cast<Eigen::Index>(count);
  for (std::size_t q = 0; q < forcing_entries; ++q) {
    result.forcing[q] = Eigen::VectorXd::Zero(blocks);
    result.deviation[q] = Eigen::VectorXd::Zero(blocks);
  }
  Eigen::VectorXd adjoint = Eigen::VectorXd::Zero(m);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (std::size_t b = count; b-- > 0;) {
    const Gain& gain = again.gains_[b];
    for (std::size_t c = channel_count; c-- > 0;) {
      if (gain.variance[c] == 0.0) continue;
      const Eigen::VectorXd h = gain.reading.row(static_cast<Eigen::Index>(c)).transpose();
      const Eigen::MatrixXd through = Eigen::MatrixXd::Identity(m, m) - gain.gain[c] * h.transpose();
      adjoint = h * (innovation[b][c] / gain.variance[c]) + through.transpose() * adjoint;
      information = h * h.transpose() / gain.variance[c] + through.transpose() * information * through;
    }
    const Eigen::VectorXd smoothed = predicted[b] + gain.predicted * adjoint;
    for (Eigen::Index i = static_cast<Eigen::Index>(states_); i < m; ++i) {
      const std::size_t q = again.taking_part_[static_cast<std::size_t>(i)] - states_;
      result.forcing[q](static_cast<Eigen::Index>(b)) = smoothed(i);
      const Eigen::RowVectorXd row = gain.predicted.row(i);
      result.deviation[q](static_cast<Eigen::Index>(b)) =
          std::sqrt(std::max(0.0, gain.predicted(i, i) - (row * information).dot(row)));
    }
    if (steps_[b].first_of_recording) {
      adjoint.setZero();
      information.setZero();
    } else {
      adjoint = (gain.transition.transpose() * adjoint).eval();
      information = (gain.transition.transpose() * information * gain.transition).eval();
    }
  }
  // What each forcing alone would do: the limb's linearised equations, driven by its estimate.
  const auto all = static_cast<Eigen::Index>(states_ + forcing_entries);
  const auto limb = static_cast<Eigen::Index>(states_);
  result.response =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(blocks_.rows().size()), static_cast<Eigen::Index>(forcing_count));
  for (std::size_t f = 0; f < forcing_count; ++f) {
    if (size_[f] == 0.0) continue;
    Eigen::VectorXd driven = Eigen::VectorXd::Zero(all);
    for (std::size_t b = 0; b < count; ++b) {
      if (steps_[b].first_of_recording)
        driven.setZero();
      else
        driven.head(limb) = (steps_[b].transition.topRows(limb) * driven).eval();
      for (std::size_t q = 0; q < forcing_entries; ++q)
        driven(limb + static_cast<Eigen::Index>(q)) = static_cast<std::size_t>(forcing_entry[q].forcing) == f
                                                          ? result.forcing[q](static_cast<Eigen::Index>(b))
                                                          : 0.0;
      for (std::size_t c = 0; c < channel_count; ++c)
        if (const std::size_t row = blocks_.blocks()[b].row[c]; row != Blocks::no_row)
          result.response(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(f)) =
              steps_[b].reading.row(static_cast<Eigen::Index>(c)).dot(driven);
    }
  }
  return result;
}

}  // namespace sinew::diagnose
