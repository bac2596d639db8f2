// SPDX-License-Identifier: Apache-2.0
// Noise in the state: what a residual may look like when the model is right but the world is not perfectly still.
//
// Residuals of an open-loop simulation are correlated over as long as the limb remembers. Here a slow random forcing eta
// enters each equation, so that along a trajectory, to first order,
//
//   d dx/dt = F dx + B eta,   d eta/dt = -eta/tau + white noise,   r = H dx + eps,   V = cov r = R + S Sigma_eta S^T
//
// A Kalman filter along the trajectory multiplies by W with W V W^T = 1 and gives log det V, in time that grows linearly with
// the recording; its smoother says which forcing would explain a residual.
//
// Residuals are first averaged over blocks (System::averaging_s): a limb has no faster motion that ten samples a second would
// show and five averaged ones would not, and it makes the filter five times as fast.
//
// Source: Kristensen, Madsen, Jorgensen 2004, Automatica 40:225 (noise in the state to find what a grey-box model lacks);
// Anderson, Moore, Optimal Filtering (1979), chapters 3 and 7; Bryson, Frazier 1963 (smoother).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnose/path.h"

namespace sinew::diagnose {

// One more forcing: an effect whose strength varies (varying.h). What it does to the plant along a path, for a strength that
// is typical of it, sample by sample.
struct VaryingPush {
  double correlation_time_s;
  std::vector<std::vector<Eigen::VectorXd>> rates;     // [n] of each recording's samples
  std::vector<std::vector<Eigen::VectorXd>> readings;  // [channels], internal units
};

// Standard deviation of the forcing of each group of entries (System::entry_groups), internal units; 0 takes it out.
using ForcingSize = plant::ListOf<plant::EntryGroupId, double>;
using FreeForcings = plant::ListOf<plant::EntryGroupId, bool>;  // which sizes are estimated

ForcingSize no_forcing(const plant::System& system);
ForcingSize forcing_to_begin_with(const plant::System& system);
// The same, but for the surroundings a tenth: forcings that leave the parameters what they can explain.
ForcingSize small_forcing(const plant::System& system);
// The sensors' noise and nothing else, or with surroundings that vary by `size`.
ForcingSize only_nuisance(const plant::System& system, double size);
// The size of the surroundings' forcing, 0 where a system has none.
double nuisance_of(const plant::System& system, const ForcingSize& size);
FreeForcings with_a_size(const ForcingSize& size);  // those that are not 0
FreeForcings all_free(const plant::System& system);
FreeForcings nuisance_free(const plant::System& system);
FreeForcings ordinary_free(const plant::System& system);  // that can be no sign of missing physics (EntryGroup::ordinary)
FreeForcings nuisance_and(const plant::System& system, plant::EntryGroupId group);

// Rows of a FitProblem averaged over blocks of time, channel by channel.
class Blocks {
 public:
  struct Row {
    std::size_t recording, block;
    plant::ChannelId channel;
    double count;  // samples in it
  };
  struct Block {
    std::size_t recording, first_sample, last_sample;  // both inclusive
    double time_s;                                     // middle, recording's own time
    plant::ListOf<plant::ChannelId, std::size_t> row;  // no_row where the channel has no sample here
  };
  static constexpr std::size_t no_row = static_cast<std::size_t>(-1);

  explicit Blocks(const FitProblem& problem);
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<Block>& blocks() const { return blocks_; }

  // Means over each block of the problem's data rows: [rows() x columns] from [problem rows x columns], row-major.
  Eigen::MatrixXd means(const double* problem_rows, std::size_t columns) const;

 private:
  std::vector<Row> rows_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> block_row_of_;  // of each row of the problem
};

// What the smoother says of a residual.
struct Smoothed {
  // Of each entry (System::entries) over all blocks: estimate and standard deviation, internal units.
  std::vector<Eigen::VectorXd> forcing, deviation;
  // Of the strength that varies, in units of what is typical; empty where there is none.
  Eigen::VectorXd varying, varying_deviation;
  // What each forcing alone does to the rows, in standard deviations of the sensors: [rows x groups].
  Eigen::MatrixXd response;
};

class StateNoise {
 public:
  // Along the path at z, which has its points. `groups`: those that can have a size; empty: all. The fewer, the faster.
  StateNoise(const FitProblem& problem, const Blocks& blocks, const double* z, const Path& path, const VaryingPush* varying = nullptr,
             const FreeForcings& groups = {});

  // How large the forcings are. Needed before whatever follows.
  void set(const ForcingSize& size);
  void set(const ForcingSize& size, double varying);
  const ForcingSize& size() const { return size_; }
  double varying_size() const { return varying_size_; }

  // W times columns of block rows, in place.
  void whiten(Eigen::Ref<Eigen::MatrixXd> columns) const;
  double log_determinant() const { return log_determinant_; }

  // log N(residual; 0, V) but for the constant.
  double log_likelihood(const Eigen::VectorXd& residual) const;

  Smoothed smooth(const Eigen::VectorXd& residual) const;

  // Course::pushes that would explain a residual, of the plant at z along its path; not those of a strength that varies. Of all forcings,
  // or of the surroundings' part in that explanation.
  enum class Of { all, surroundings };
  std::vector<Eigen::MatrixXd> pushes(const Eigen::VectorXd& residual, const FitProblem& problem, const double* z, const Path& path,
                                      Of which) const;

  // The sizes that make a residual most likely, from `begin` on. Forcings not in `free` keep their size. Sizes that do not
  // help end at 0; the surroundings do not pass EntryGroup::ordinary, and nothing does where only what is ordinary is sought. The strength
  // that varies, where there is one, is free, too, and begins at its size here. Sizes are found to within `finest_factor`. Leaves the
  // object at the result.
  ForcingSize maximise(const Eigen::VectorXd& residual, const ForcingSize& begin, const FreeForcings& free, double finest_factor,
                       bool only_ordinary = false);

 private:
  // The plant's states, padded, then the forcings', padded.
  struct Step {
    Eigen::MatrixXd transition;  // [all x all], from the block before
    Eigen::MatrixXd reading;     // [all x channels], in standard deviations of the sensors
    bool first_of_recording = false;
  };
  // Of each block: gains [all x channels] and variances of the innovations (0 where there is no row).
  struct Gain {
    Eigen::MatrixXd gain;
    PerChannel variance;
  };
  // Each block's covariance before its measurements goes to `predicted`, unless that is null.
  void filter(std::vector<Eigen::MatrixXd>* predicted);
  // work(states, forcings): both as integral constants, Eigen::Dynamic where they are larger than what is unrolled.
  template <class Work>
  decltype(auto) with_sizes(Work&& work) const;
  template <int Size, int Forcings>
  void filter_padded(std::vector<Eigen::MatrixXd>* predicted);
  template <int Size, int Forcings>
  void whiten_padded(Eigen::Ref<Eigen::MatrixXd> columns) const;
  // Of the k-th forcing: first those of `used_`, then the strength that varies.
  Eigen::Index forcing_state(std::size_t k) const { return padded_states_ + static_cast<Eigen::Index>(k); }
  std::size_t forcings() const { return used_.size() + (varies_ ? 1 : 0); }
  // Rates by each forcing, [states x used_]; nothing by the surroundings', which push by what a point of the path says.
  Eigen::MatrixXd constant_push(const plant::Plant& plant) const;

  const plant::System& system_;
  const Blocks& blocks_;
  std::vector<Step> steps_;
  std::vector<std::size_t> used_;  // entries (System::entries) that have a forcing
  std::size_t states_ = 0;         // of the plant
  Eigen::Index padded_states_ = 0, padded_forcings_ = 0;
  ForcingSize size_;
  bool varies_ = false;
  double varying_size_ = 0.0;
  std::vector<Gain> gains_;
  double log_determinant_ = 0.0;
};

}  // namespace sinew::diagnose
