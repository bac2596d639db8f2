// SPDX-License-Identifier: Apache-2.0
// Sensitivities of both methods against differences of runs that share nothing with them but the equations: Runge-Kutta
// with a fixed step, which is smooth in the parameters, so that the steps of the differences may be small.
#include "plant/integrator.h"
#include "tests/long_when_sanitized.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"
#include "tests/validation/runge_kutta.h"

namespace validation_sensitivity_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// What is compared at each sample: three readings, then all states.
constexpr std::size_t readings = 3;
constexpr std::size_t angular_velocity_row = readings + core_state::angular_velocity;

struct Trial {
  Plant limb = default_plant();
  std::vector<std::optional<double>> given;  // empty: at rest
  SensitivityRequest request;
  Profile profile = babbling_profile();
  double step_s = 2e-3;  // of the fixed step; must be stable for the limb's fastest motion
  // Whether a parameter stands at the end of its range, so that it can only be moved to one side: +1, -1, or 0 for neither.
  int side = 0;
  // How far the two may be apart; see below.
  double tolerance = 3e-3;
  bool at_two_steps = true;  // whether to see that the differences do not depend on their step

  std::size_t rows() const { return readings + limb.states().size(); }
  std::vector<double> sample_times_s() const { return sample_times_between_jumps(profile.end_s); }
  // A change of this size is large: of a parameter in internal units, or of a first value.
  double size(std::size_t column) const {
    if (column >= request.parameters.size()) return limb.states()[request.initial_states[column - request.parameters.size()]].scale;
    const Declaration& declared = parameters()[request.parameters[column]].declaration;
    return std::max(std::abs(declared.typical), declared.prior_deviation) * declared.unit.internal_per_unit;
  }
  std::string name(std::size_t column) const {
    if (column < request.parameters.size()) return parameters()[request.parameters[column]].key();
    return "first " + limb.states()[request.initial_states[column - request.parameters.size()]].key;
  }
};

// [rows x samples] of a run in which one column's quantity is moved by so much.
Eigen::MatrixXd moved(const Trial& trial, std::size_t column, double by) {
  Plant limb = trial.limb;
  std::vector<std::optional<double>> given = trial.given;
  if (column < trial.request.parameters.size()) {
    const ParameterId p = trial.request.parameters[column];
    limb.set(p, limb.get(p) + by);
  } else {
    *given[trial.request.initial_states[column - trial.request.parameters.size()].index] += by;
  }
  const auto samples = runge_kutta(limb, given, trial.profile, trial.sample_times_s(), trial.step_s);
  Eigen::MatrixXd result(static_cast<Eigen::Index>(trial.rows()), static_cast<Eigen::Index>(samples.size()));
  for (std::size_t k = 0; k < samples.size(); ++k)
    result.col(static_cast<Eigen::Index>(k)) << samples[k].reading[A], samples[k].reading[B], samples[k].reading[angle],
        Eigen::Map<const Eigen::VectorXd>(samples[k].state.data(), static_cast<Eigen::Index>(samples[k].state.size()));
  return result;
}

Eigen::MatrixXd difference_quotient(const Trial& trial, std::size_t column, double step) {
  if (trial.side == 0) return (moved(trial, column, step) - moved(trial, column, -step)) / (2.0 * step);
  const double h = trial.side * step;  // to second order from one side
  return (4.0 * moved(trial, column, h) - 3.0 * moved(trial, column, 0.0) - moved(trial, column, 2.0 * h)) / (2.0 * h);
}

// One matrix a column, [rows x samples].
std::vector<Eigen::MatrixXd> integrated(const Trial& trial, Method method) {
  Integrator run(trial.limb, Start{trial.given, {}}, {.method = method, .relative_tolerance = 1e-10, .most_steps = 1000000}, trial.request);
  const auto times_s = trial.sample_times_s();
  std::vector<Eigen::MatrixXd> columns(trial.request.columns(),
                                       Eigen::MatrixXd(static_cast<Eigen::Index>(trial.rows()), static_cast<Eigen::Index>(times_s.size())));
  drive(run, trial.profile, times_s, [&](std::size_t k) {
    std::vector<double> reading;
    Eigen::MatrixXd of_reading;
    run.readings_with_sensitivity(reading, of_reading);
    const Eigen::MatrixXd of_state = run.state_sensitivity();
    for (std::size_t c = 0; c < columns.size(); ++c)
      columns[c].col(static_cast<Eigen::Index>(k)) << of_reading.col(static_cast<Eigen::Index>(c)),
          of_state.col(static_cast<Eigen::Index>(c));
  });
  return columns;
}

struct Disagreement {
  double elsewhere = 0.0, angular_velocity = 0.0;
};

// Row by row: the norm over the run of the difference, as a share of the norm of what is expected. A row that the column
// hardly moves, less than a thousandth of its scale for a large change, is judged as if it were moved that much.
Disagreement disagreement(const Trial& trial, std::size_t column, const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  const States layout = trial.limb.states();
  Disagreement worst;
  for (std::size_t r = 0; r < trial.rows(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    const double scale = r < 2 ? 50.0 : r == 2 ? 1.0 : layout[StateId{r - readings}].scale;
    const double least = 1e-3 * scale / trial.size(column) * std::sqrt(static_cast<double>(expected.cols()));
    const double share = (found.row(row) - expected.row(row)).norm() / std::max(expected.row(row).norm(), least);
    double& kept = r == angular_velocity_row ? worst.angular_velocity : worst.elsewhere;
    kept = std::max(kept, std::isfinite(share) ? share : 1e300);
  }
  return worst;
}

// Tolerances. Away from corners both sides are right to 1e-6. A fraction that meets an envelope has a rate with a corner,
// and its sensitivity a rate with a jump: a step over it, of either integration, leaves an error of the step's length times
// the jump, as does a difference whose two runs meet the envelope in different steps. With some dozens of such meetings in
// a run that is 1e-4 to 1e-3 of the whole. The angular velocity is the derivative of such a thing, in bursts of 5 ms: ten
// times as much. Differences at steps of 1e-5 and 1e-6 of a parameter's size see the corners alike, or nothing is proved.
void check(const Trial& trial) {
  const auto cvode = integrated(trial, Method::cvode), arkode = integrated(trial, Method::arkode);
  for (std::size_t c = 0; c < trial.request.columns(); ++c) {
    const Eigen::MatrixXd expected = difference_quotient(trial, c, 1e-6 * trial.size(c));
    Disagreement of_differences;
    if (trial.at_two_steps) of_differences = disagreement(trial, c, difference_quotient(trial, c, 1e-5 * trial.size(c)), expected);
    const Disagreement of_cvode = disagreement(trial, c, cvode[c], expected);
    const Disagreement of_arkode = disagreement(trial, c, arkode[c], expected);
    INFO(trial.name(c), ": differences ", of_differences.elsewhere, ", cvode ", of_cvode.elsewhere, " (angular velocity ",
         of_cvode.angular_velocity, "), arkode ", of_arkode.elsewhere, " (angular velocity ", of_arkode.angular_velocity, ")");
    CHECK(of_differences.elsewhere < trial.tolerance);
    CHECK(of_cvode.elsewhere < trial.tolerance);
    CHECK(of_arkode.elsewhere < trial.tolerance);
    CHECK(of_differences.angular_velocity < 10.0 * trial.tolerance);
    CHECK(of_cvode.angular_velocity < 10.0 * trial.tolerance);
    CHECK(of_arkode.angular_velocity < 10.0 * trial.tolerance);
  }
}

// Dry friction at its usual smoothing decays in a third of a millisecond; the method is stable up to 2.8 times that.
double stable_step_s(std::string_view effect) { return effect == "dry_friction" ? 7e-4 : 2e-3; }

// A minor loop fades in over 0.001 of a fraction, a corner at either end of it at every turn of the temperature.
double tolerance_of(std::string_view effect) { return effect == "minor_loops" ? 4e-2 : 3e-3; }

Plant typical(EffectId effect) {
  Plant limb = default_plant();
  turn_on_typical(limb, effect);
  if (effects()[effect].name == "airflow_change") set_in_file_units(limb, "airflow_change.onset_s", 12.34);
  return limb;
}

std::vector<ParameterId> real_parameters(std::optional<EffectId> effect) {
  std::vector<ParameterId> real;
  for (const ParameterId p : parameters().ids())
    if (parameters()[p].effect == effect && parameters()[p].declaration.kind == Kind::real) real.push_back(p);
  return real;
}

// In mid-motion: both wires warm, both fractions inside their loops, the limb bent and moving, effects not at rest.
std::vector<std::optional<double>> in_motion(const Plant& limb) {
  std::vector<std::optional<double>> given{40.0, 30.0, 0.97, 0.992, 0.1, 0.5};
  const States layout = limb.states();
  for (std::size_t i = given.size(); i < layout.size(); ++i) given.push_back(layout[StateId{i}].unit.text == "degC" ? 33.0 : 0.05);
  return given;
}

}  // namespace

TEST_CASE("the run of these tests takes both fractions through their loops and the limb past 30 degrees both ways" * long_when_sanitized) {
  const auto samples = runge_kutta(default_plant(), {}, babbling_profile(), sample_times_between_jumps(36.0), 1e-3);
  double least[5] = {1e9, 1e9, 1e9, 1e9, 1e9}, most[5] = {-1e9, -1e9, -1e9, -1e9, -1e9};
  for (const Sample& sample : samples)
    for (std::size_t i = 0; i < 5; ++i) {
      least[i] = std::min(least[i], sample.state[i]);
      most[i] = std::max(most[i], sample.state[i]);
    }
  for (const std::size_t j : coils) {
    CHECK(least[core_state::martensite + j] < 0.05);
    CHECK(most[core_state::martensite + j] > 0.99);
  }
  CHECK(least[core_state::angle] < -30.0 * radians_per_degree);
  CHECK(most[core_state::angle] > 30.0 * radians_per_degree);
}

TEST_CASE("sensitivities are what differences say: every parameter of the core" * long_when_sanitized) {
  check({.given = {}, .request = {real_parameters(std::nullopt), {}}});
}

TEST_CASE("sensitivities are what differences say: every parameter of every effect" * long_when_sanitized) {
  for (const EffectId e : effects().ids()) {
    const auto name = effects()[e].name;
    const auto real = real_parameters(e);
    if (real.empty()) continue;
    check({.limb = typical(e), .given = {}, .request = {real, {}}, .step_s = stable_step_s(name), .tolerance = tolerance_of(name)});
  }
}

TEST_CASE("sensitivities are what differences say: every effect's strength at its null" * long_when_sanitized) {
  for (const EffectId e : effects().ids()) {
    const auto name = effects()[e].name;
    const ParameterId strength = effects()[e].strength;
    const Declaration& declared = parameters()[strength].declaration;
    if (declared.kind != Kind::real) continue;
    Trial trial{
        .limb = typical(e), .given = {}, .request = {{strength}, {}}, .step_s = stable_step_s(name), .tolerance = tolerance_of(name)};
    trial.profile.end_s = 24.0;  // both coils have pulled
    trial.limb.set_in_file_units(strength, *declared.null_value);
    trial.side = *declared.null_value == declared.range.lowest ? 1 : *declared.null_value == declared.range.highest ? -1 : 0;
    // Just inside the loops: a wire at rest stands on the corner of its cooling envelope, where sides differ.
    trial.given.resize(trial.limb.states().size());
    trial.given[core_state::martensite + A] = trial.given[core_state::martensite + B] = 0.995;
    check(trial);
  }
}

TEST_CASE("while the limb stands still and steps are long, its sensitivities stay what they are" * long_when_sanitized) {
  // A wire warms below its transformation and nothing moves; but with an R-phase it would, and that is the sensitivity.
  // The explicit method's steps, long for the state, must not be too long for what the sensitivity does.
  Plant limb = default_plant();
  turn_on(limb, "r_phase");
  const SensitivityRequest request{{parameter_id("r_phase.share")}, {}};
  for (const double tolerance : {1e-6, 1e-8}) {
    Integrator cvode(limb, Start{}, {.method = Method::cvode, .relative_tolerance = tolerance}, request);
    Integrator arkode(limb, Start{}, {.method = Method::arkode, .relative_tolerance = tolerance}, request);
    double worst_rad = 0.0;
    for (int tick = 1; tick <= 10; ++tick) {
      for (Integrator* run : {&cvode, &arkode}) {
        run->hold({0.6, 0.0});
        advance(*run, 0.1 * tick);
      }
      worst_rad =
          std::max(worst_rad, std::abs(cvode.state_sensitivity()(core_state::angle, 0) - arkode.state_sensitivity()(core_state::angle, 0)));
    }
    CAPTURE(tolerance);
    CHECK(cvode.state_sensitivity()(core_state::angle, 0) > 0.04);
    CHECK(worst_rad < 4e-4);  // a hundredth of it
  }
}

TEST_CASE("sensitivities are what differences say: every first value of a state" * long_when_sanitized) {
  const auto check_first_values = [](const Plant& limb, double step_s, double tolerance) {
    Trial trial{.limb = limb, .given = in_motion(limb), .request = {}, .step_s = step_s, .tolerance = tolerance};
    trial.profile.end_s = 16.0;  // by then wire A has been through its loop and a first value is nearly forgotten
    for (std::size_t i = 0; i < trial.given.size(); ++i) trial.request.initial_states.push_back(StateId{i});
    check(trial);
  };
  check_first_values(default_plant(), stable_step_s(""), 3e-3);
  for (const EffectId e : effects().ids()) {
    const Plant limb = typical(e);
    if (limb.states().size() > core_state::count) check_first_values(limb, stable_step_s(effects()[e].name), 3e-3);
  }
}

TEST_CASE("sensitivities are what differences say: all parameters and first values with all effects at once" * long_when_sanitized) {
  Trial trial{.given = {}, .request = {}};
  // As for minor loops, which also are among them; the more so as CVODES chooses its steps by the states alone.
  trial.tolerance = 5e-2;
  trial.profile.end_s = 16.0;
  trial.at_two_steps = false;  // each has been seen alone
  for (const EffectId e : effects().ids()) turn_on_typical(trial.limb, e);
  set_in_file_units(trial.limb, "airflow_change.onset_s", 12.34);
  set_in_file_units(trial.limb, "dry_friction.smoothing_rad_s", 0.5);  // so that the fixed step is stable
  set_in_file_units(trial.limb, "hard_stop.angle_deg", 10.0);          // so that it is reached
  for (const ParameterId p : parameters().ids())
    if (parameters()[p].declaration.kind == Kind::real) trial.request.parameters.push_back(p);
  trial.given = in_motion(trial.limb);
  for (std::size_t i = 0; i < trial.given.size(); ++i) trial.request.initial_states.push_back(StateId{i});
  check(trial);
}

}  // namespace validation_sensitivity_test
