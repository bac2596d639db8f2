// SPDX-License-Identifier: Apache-2.0
// What the fit of everything else leaves of a column: of what a change would do to the data, the part that no other values of the
// unknowns could do as well.
//
//   P = V^-1 - V^-1 J (J^T V^-1 J + 1)^-1 J^T V^-1
//
// with J the columns of all unknowns of an explanation, whose priors count among the data.
#pragma once

#include <Eigen/Cholesky>

#include "diagnose/explanation.h"

namespace sinew::diagnose {

class Projection {
 public:
  explicit Projection(const Explanation& at);

  void whiten(Eigen::MatrixXd& columns) const { noise_->whiten(columns); }

  // Of whitened columns s [rows x n]: P^(1/2) s with its part among the priors, s^T P s, and s^T P r, with r the residual.
  struct Left {
    Eigen::MatrixXd columns;  // [rows + unknowns x n]
    Eigen::MatrixXd squares;  // [n x n]
    Eigen::VectorXd along;    // [n]
  };
  Left of(const Eigen::MatrixXd& whitened) const;

  // The plant's linear equations along the path.
  const Path& path() const { return path_; }

 private:
  Path path_;
  std::unique_ptr<StateNoise> noise_;
  Eigen::MatrixXd absorbed_;
  Eigen::VectorXd residual_, z_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace sinew::diagnose
