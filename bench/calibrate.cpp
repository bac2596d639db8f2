// SPDX-License-Identifier: Apache-2.0
// Calibrating 12 parameters and 4 first values on ten minutes of babbling, three starts on two threads; and what one Jacobian
// costs through sensitivities and through differences.
//
// The recording is that of a limb whose 12 parameters are off by half a prior deviation each, up and down in turn, with the
// sensors' noise and steps. Of what trades off with these by itself (resistances with heat capacities and losses,
// stiffnesses of the coils with their arms and the beam's) one of each group is fitted.
#include <chrono>

#include "bench/babbling.h"
#include "diagnose/calibrate.h"

using namespace sinew;

namespace {

constexpr const char* names[] = {"heat_capacity_A_J_K",      "heat_capacity_B_J_K",      "heat_loss_A_W_K",       "heat_loss_B_W_K",
                                 "ambient_temperature_degC", "heating_midpoint_degC",    "heating_width_K",       "cooling_midpoint_degC",
                                 "cooling_width_K",          "transformation_stretch_m", "beam_stiffness_Nm_rad", "angle_offset_deg"};
constexpr double goal_s = 15.0;

double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct Jacobian {
  diagnose::FitProblem::RowMajor values;
  double time_s = 0.0;
};

// Largest error of a column, as a share of the column's length.
double largest_error(const Jacobian& one, const Jacobian& exact) {
  double largest = 0.0;
  for (Eigen::Index u = 0; u < exact.values.cols(); ++u)
    largest = std::max(largest, (one.values.col(u) - exact.values.col(u)).norm() / exact.values.col(u).norm());
  return largest;
}

}  // namespace

int main() {
  const plant::Plant nominal = plant::default_plant();
  plant::Plant truth = nominal;
  std::vector<plant::ParameterId> parameters;
  for (const char* name : names) {
    const plant::ParameterId p = truth.system().parameter(name);
    const auto& declared = truth.system().parameters()[p].declaration;
    const double shift = (parameters.size() % 2 ? -0.5 : 0.5) * declared.prior_deviation;
    truth.set_in_file_units(p, truth.get_in_file_units(p) + shift);
    parameters.push_back(p);
  }
  const sim::Recording recording = bench::babbling(600.0, truth);
  const std::vector<diagnose::FitData> data{{&recording, recording.samples.size(), diagnose::noise_of(nominal.system(), recording)}};
  diagnose::CalibrationSettings settings;
  settings.parameters = parameters;

  const double began_wall_s = wall_s(), began_s = bench::seconds_on(CLOCK_PROCESS_CPUTIME_ID);
  const diagnose::Calibration calibration = diagnose::calibrate(nominal, data, settings);
  const double took_wall_s = wall_s() - began_wall_s, took_s = bench::seconds_on(CLOCK_PROCESS_CPUTIME_ID) - began_s;

  std::printf("Calibration of 12 parameters and 4 first values on ten minutes (%zu samples), 3 starts, 2 threads, tolerance 1e-5.\n\n",
              recording.samples.size());
  std::printf(
      "| by the wall [s] | goal | | processor time, both threads [s] | iterations of the starts | starts agree |\n"
      "|---|---|---|---|---|---|\n| %.1f | at most %.0f | %s | %.1f |",
      took_wall_s, goal_s, bench::verdict(took_wall_s <= goal_s), took_s);
  for (const auto& outcome : calibration.outcomes) std::printf(" %d", outcome.iterations);
  std::printf(" | %s |\n\n", calibration.several_starts_agree ? "yes" : "**no**");

  std::printf("| parameter | true | fitted | standard error | error in standard errors |\n|---|---|---|---|---|\n");
  for (std::size_t u = 0; u < parameters.size(); ++u) {
    const auto& e = calibration.estimates[u];
    const double unit = e.unknown.internal_per_unit, true_value = truth.get(parameters[u]);
    std::printf("| %s | %.5g | %.5g | %.1e | %.1f |\n", e.unknown.name.c_str(), true_value / unit, e.value / unit, e.standard_error / unit,
                (e.value - true_value) / e.standard_error);
  }

  // One Jacobian at the nominal plant.
  using Settings = plant::NumericalSettings;
  const auto problem_with = [&](const Settings& numerics) {
    return diagnose::FitProblem(nominal, parameters, data, diagnose::StartPolicy::estimated, numerics);
  };
  const diagnose::FitProblem problem = problem_with(settings.numerics);
  const std::size_t columns = problem.unknowns().size(), rows = problem.residual_count();
  const std::vector<double> z(columns, 0.0);
  const auto by_sensitivities = [&](const diagnose::FitProblem& of) {
    Jacobian jacobian{diagnose::FitProblem::RowMajor(rows, columns)};
    std::vector<double> residuals(rows);
    jacobian.time_s = bench::fastest_s(3, [&] { of.evaluate(z.data(), residuals.data(), jacobian.values.data()); });
    return jacobian;
  };
  // Forward, one run at z and one more for each unknown, displaced by `step` prior deviations.
  const auto by_differences = [&](const diagnose::FitProblem& of, double step) {
    Jacobian jacobian{diagnose::FitProblem::RowMajor(rows, columns)};
    jacobian.time_s = bench::fastest_s(2, [&] {
      std::vector<double> here(rows), there(rows);
      of.evaluate(z.data(), here.data(), nullptr);
      for (std::size_t u = 0; u < columns; ++u) {
        std::vector<double> displaced = z;
        displaced[u] += step;
        of.evaluate(displaced.data(), there.data(), nullptr);
        for (std::size_t r = 0; r < rows; ++r)
          jacobian.values(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(u)) = (there[r] - here[r]) / step;
      }
    });
    return jacobian;
  };
  const Jacobian exact = by_sensitivities(problem_with(Settings{plant::Method::arkode, 1e-10}));
  std::printf(
      "\nOne Jacobian of %zu rows and %zu columns; errors against sensitivities at 1e-10, as a share of the worst column.\n\n"
      "| how | runs | ms | times that by sensitivities | largest error |\n|---|---|---|---|---|\n",
      rows, columns);
  const Jacobian ours = by_sensitivities(problem);
  const auto print = [&](const char* how, std::size_t runs, const Jacobian& one) {
    std::printf("| %s | %zu | %.1f | %.2f | %.1e |\n", how, runs, 1e3 * one.time_s, one.time_s / ours.time_s, largest_error(one, exact));
  };
  print("sensitivities, 1e-5 (as `calibrate` does)", 1, ours);
  print("differences, 1e-5, step 1e-2 of the prior", 1 + columns, by_differences(problem, 1e-2));
  print("differences, 1e-5, step 1e-4 of the prior", 1 + columns, by_differences(problem, 1e-4));
  const diagnose::FitProblem careful = problem_with(Settings{plant::Method::arkode, 1e-8});
  print("differences, 1e-8, step 1e-3 of the prior", 1 + columns, by_differences(careful, 1e-3));
  std::printf("\nCalibration once, Jacobians least of 2 or 3 repeats; %s.\n", bench::conditions().c_str());
}
