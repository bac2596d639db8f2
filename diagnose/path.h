// SPDX-License-Identifier: Apache-2.0
// A plant's path through recordings, and the linear equations that hold along it.
//
// The path is integrated as everywhere. Sensitivities follow from the derivatives of the equations half-way between samples,
// taken as constant there, by the exponential midpoint rule
//
//   S_{k+1} = e^{F dt} S_k + phi_1(F dt) dt df/dp
//
// which takes less than half the time of integrating them (bench/methods), agrees with it to about a per cent, and gives
// what the noise in the state needs at the same time. An explanation's fit steers by these and judges by the path itself.
// Where a parameter moves an instant at which the rates jump, the sensitivities jump too.
//
// Source: Hochbruck, Ostermann 2010, Acta Numerica 19:209, section 2 (phi functions).
#pragma once

#include "diagnose/fit.h"

namespace sinew::diagnose {

// From one sample to the next, to first order: dx' = transition dx + integral g, for a push g on the rates that stays the
// same in between; and what the readings (internal units) at the sample make of dx. n: all states of the plant.
struct PathPoint {
  Eigen::MatrixXd transition, integral;  // [n x n]; of the last sample: empty
  Eigen::VectorXd ambient;               // [n]: d rates / d the surroundings' parameter, in between; 0 where there is none
  Eigen::MatrixXd reading;               // [channels x n]
  Eigen::VectorXd reading_ambient;       // [channels]
};

struct Path {
  std::vector<double> residuals;               // of all the problem's rows but the priors'
  std::vector<double> jacobian;                // [rows x unknowns], row-major; empty where not asked for
  std::vector<std::vector<PathPoint>> points;  // of each recording, one a sample
};

enum class Want { residuals, derivatives, points, everything };  // derivatives: the Jacobian; everything: that and points

// False where the integration fails.
bool follow(const FitProblem& problem, const double* z, Want want, Path& path);

// What pushes on the states (Course::pushes, of the problem's plant) do to the rows, to first order along a path that has its points.
std::vector<double> response_to(const FitProblem& problem, const Path& path, const std::vector<Eigen::MatrixXd>& pushes);

// Columns of further parameters at a path, [rows x parameters], row-major, in the scale of their prior deviations (or, where
// a parameter has none, of 1): `with` has them on, at their nulls or not; its states begin at rest but for what `start` of
// the problem gives, and for what the recordings' clock says.
bool sensitivity_to(const FitProblem& problem, const double* z, const plant::Plant& with, const std::vector<plant::ParameterId>& parameters,
                    std::vector<double>& columns);

}  // namespace sinew::diagnose
