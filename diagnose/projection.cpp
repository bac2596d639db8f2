// SPDX-License-Identifier: Apache-2.0
#include "diagnose/projection.h"

namespace sinew::diagnose {

Projection::Projection(const Explanation& at) : z_(at.z) {
  follow(*at.problem, at.z.data(), Want::everything, path_);
  noise_ = std::make_unique<StateNoise>(*at.problem, *at.blocks, at.z.data(), path_, nullptr, with_a_size(at.forcing));
  noise_->set(at.forcing);
  absorbed_ = at.blocks->means(path_.jacobian.data(), at.problem->unknowns().size());
  noise_->whiten(absorbed_);
  Eigen::MatrixXd residual = at.residual;
  noise_->whiten(residual);
  residual_ = residual.col(0);
  Eigen::MatrixXd information = absorbed_.transpose() * absorbed_;
  information.diagonal().array() += 1.0;
  factor_.compute(information);
}

Projection::Left Projection::of(const Eigen::MatrixXd& whitened) const {
  const Eigen::MatrixXd coefficients = factor_.solve(absorbed_.transpose() * whitened);
  Left left;
  left.columns.resize(whitened.rows() + coefficients.rows(), whitened.cols());
  left.columns << whitened - absorbed_ * coefficients, -coefficients;
  left.squares = left.columns.transpose() * left.columns;
  left.along = left.columns.topRows(whitened.rows()).transpose() * residual_ - coefficients.transpose() * z_;
  return left;
}

}  // namespace sinew::diagnose
