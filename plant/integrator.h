// SPDX-License-Identifier: Apache-2.0
// The limb in time: SUNDIALS behind values. The one source file that includes SUNDIALS headers is integrator.cpp.
//
// CVODE (variable-order BDF, dense Jacobian by automatic differentiation, CVODES for sensitivities) is the reference.
// ARKODE (explicit Runge-Kutta) needs no history, so that a jump of the duty costs it nothing; fits use it where the limb is
// not stiff. Sensitivities in both are those of the equations' own code, through Jets.
//
// Duty is held between calls of `hold`. The integrator never steps over a jump: it stops there and starts again. A duty
// that is commanded again unchanged is no jump.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plant/equations.h"

namespace sinew::plant {

enum class Method {
  cvode,      // BDF; the reference
  arkode,     // explicit Runge-Kutta
  automatic,  // arkode, unless an eigenvalue of the Jacobian says that the limb is stiff for it
};

struct NumericalSettings {
  Method method = Method::cvode;
  double relative_tolerance = 1e-8;  // absolute tolerance of a state: this times its scale
  int most_steps = 100000;           // between two calls of advance_to
};

// Columns of the sensitivities: first the parameters (indices into parameters(), internal units), then the first values of
// the states (indices into the layout; each must be given in Start).
struct SensitivityRequest {
  std::vector<std::size_t> parameters;
  std::vector<std::size_t> initial_states;
  std::size_t columns() const { return parameters.size() + initial_states.size(); }
};

// Where a run begins. A state without a value is at rest; see Equations::rest.
struct Start {
  std::vector<std::optional<double>> given;  // empty, or one entry a state
  PerCoil<double> duty_fraction{};           // what was held before the first command
};

struct SolverCounters {
  std::int64_t steps = 0;
  std::int64_t rhs_evaluations = 0;
  std::int64_t jacobian_evaluations = 0;
  std::int64_t error_test_failures = 0;
  std::int64_t restarts = 0;
  friend bool operator==(const SolverCounters&, const SolverCounters&) = default;
};

// What the solver said when it gave up: time, reason, and the states with the largest weighted errors.
struct IntegrationFailure {
  double time_s;
  std::string reason;
};

// All that a run needs to go on as if it had not stopped. Can be taken right after the integrator has restarted.
struct Checkpoint {
  Method method = Method::cvode;  // the one that runs: what `automatic` chose at the start stays chosen
  double time_s = 0.0;
  double segment_start_s = 0.0;
  PerCoil<double> held_duty_fraction{};
  std::vector<std::pair<double, PerCoil<double>>> commands_under_way;  // time of arrival, duty
  std::vector<double> state;
  double next_step_s = 0.0;
  SolverCounters counters;
};

class Integrator {
 public:
  // Throws std::invalid_argument where the request does not fit the limb.
  Integrator(const Limb<double>& limb, const Start& start, const NumericalSettings& settings,
             const SensitivityRequest& request = {});
  Integrator(const Limb<double>& limb, const Checkpoint& from, const NumericalSettings& settings);
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  // From now on this duty is commanded, until the next call.
  void hold(const PerCoil<double>& duty_fraction);

  // Integrates to `time_s`, which must not lie before time_s().
  [[nodiscard]] std::optional<IntegrationFailure> advance_to(double time_s);

  // Starts the solver again here even though nothing jumped, so that a checkpoint can be taken.
  void restart();
  Checkpoint checkpoint();

  double time_s() const;
  const std::vector<double>& state() const;
  const Layout& layout() const;
  Reading<double> reading() const;
  Instant<double> instant() const;

  // [states x columns] and [3 x columns]: d/dp of the state, and of temperature A, temperature B [degC], angle [rad].
  Eigen::MatrixXd state_sensitivity() const;
  void reading_with_sensitivity(Reading<double>& reading, Eigen::Matrix<double, 3, Eigen::Dynamic>& sensitivity) const;

  SolverCounters counters() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew::plant
