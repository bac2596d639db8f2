// SPDX-License-Identifier: Apache-2.0
// A plant in time: SUNDIALS behind values. The one source file that includes SUNDIALS headers is integrator.cpp.
//
// CVODE (variable-order BDF, dense Jacobian by automatic differentiation, CVODES for sensitivities) is the reference.
// ARKODE (explicit Runge-Kutta) needs no history, so that a jump of an input costs it nothing; fits use it where the plant is
// not stiff. Sensitivities in both are those of the equations' own code, through Jets.
//
// Inputs are held, or change at a steady rate, between calls of `hold`. The integrator never steps over a jump: it stops there
// and starts again. An input that is commanded again unchanged is no jump.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plant/system.h"

namespace sinew::plant {

enum class Method {
  cvode,       // BDF; the reference
  arkode,      // explicit Runge-Kutta
  automatic,   // arkode, unless an eigenvalue of the Jacobian says that the plant is stiff for it
  rosenbrock,  // linearly implicit Runge-Kutta, for fits: few steps whatever is stiff; asked for sensitivities, `automatic` is taken
};

struct NumericalSettings {
  Method method = Method::cvode;
  double relative_tolerance = 1e-8;  // absolute tolerance of a state: this times its scale
  int most_steps = 100000;           // between two calls of advance_to
};

// Columns of the sensitivities: first the parameters (internal units), then the first values of states (each must be given in
// Start).
struct SensitivityRequest {
  std::vector<ParameterId> parameters;
  std::vector<StateId> initial_states;
  std::size_t columns() const { return parameters.size() + initial_states.size(); }
};

// Where a run begins. A state without a value is at rest; see Equations::rest.
struct Start {
  std::vector<std::optional<double>> given;  // empty, or one entry a state
  std::vector<double> inputs;                // what was held before the first command; empty: nothing, 0
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
  std::vector<double> held_inputs;
  std::vector<std::pair<double, std::vector<double>>> commands_under_way;  // time of arrival, inputs
  std::vector<double> state;
  double next_step_s = 0.0;
  SolverCounters counters;
};

class Integrator {
 public:
  // Throws std::invalid_argument where start or request do not fit the plant.
  Integrator(const Plant& plant, const Start& start, const NumericalSettings& settings, const SensitivityRequest& request = {});
  Integrator(const Plant& plant, const Checkpoint& from, const NumericalSettings& settings);
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  // From now on these inputs are commanded, until the next call. With `slopes_1_s` (one an input; empty: all are held) they
  // change at that rate; a checkpoint cannot be taken then.
  void hold(const std::vector<double>& inputs, const std::vector<double>& slopes_1_s = {});

  // Integrates to `time_s`, which must not lie before time_s().
  [[nodiscard]] std::optional<IntegrationFailure> advance_to(double time_s);

  // Starts the solver again here even though nothing jumped, so that a checkpoint can be taken.
  void restart();

  // Moves the states here and now by as much, [states]; their sensitivities stay.
  void move(const Eigen::Ref<const Eigen::VectorXd>& by);
  Checkpoint checkpoint();

  double time_s() const;
  const std::vector<double>& state() const;
  const States& states() const;
  const Situation& situation() const;     // here and now
  std::vector<double> readings() const;   // [channels], internal units
  std::vector<double> variables() const;  // [variables], in the units of their list

  // [states x columns] and [channels x columns]: d/dp of the state, and of the readings. Internal units.
  Eigen::MatrixXd state_sensitivity() const;
  void readings_with_sensitivity(std::vector<double>& readings, Eigen::MatrixXd& sensitivity) const;

  SolverCounters counters() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew::plant
