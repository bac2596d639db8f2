// SPDX-License-Identifier: Apache-2.0
// Which method, at which tolerance, for which limb: what the choices in plant/integrator.cpp rest on.
//
//   1. work against precision, CVODE and ARKODE at 1e-4 to 1e-8;
//   2. a limb made stiff by dry friction: where CVODE overtakes ARKODE, and so the threshold of Method::automatic;
//   3. ARKODE's Runge-Kutta tables, on the same equations through SUNDIALS as it comes: its own vectors, its own step control.
#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include <Eigen/Eigenvalues>

#include "bench/babbling.h"

using namespace sinew;

namespace {

void precision(const sim::Recording& recording, const bench::Replay& reference) {
  std::printf(
      "### Work against precision: ten minutes of babbling, core plant\n\n"
      "| method | relative tolerance | ms | steps | failed steps | right-hand sides | angle error rms, max [deg] | temperature error "
      "rms [K] |\n|---|---|---|---|---|---|---|---|\n");
  for (const plant::Method method : {plant::Method::cvode, plant::Method::arkode, plant::Method::rosenbrock})
    for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
      bench::Replay run;
      const double ms = 1e3 * bench::fastest_s(7, [&] { run = bench::replay(recording, {method, tolerance}); });
      const bench::Errors e = bench::errors_of(run, reference);
      std::printf("| %s | %.0e | %.1f | %lld | %lld | %lld | %.1e, %.1e | %.1e |\n", bench::name_of(method), tolerance, ms,
                  static_cast<long long>(run.counters.steps), static_cast<long long>(run.counters.error_test_failures),
                  static_cast<long long>(run.counters.rhs_evaluations), e.angle_rms_deg, e.angle_max_deg, e.temperature_rms_K);
    }
  std::printf("\n");
}

// Largest modulus of the Jacobian's eigenvalues at rest, by differences: what Method::automatic looks at.
double spectral_radius_1_s(const plant::Plant& limb) {
  const auto equations = limb.equations();
  const plant::Situation idle{.inputs = std::vector<double>(limb.system().inputs().size(), 0.0)};
  const std::vector<double> rest = equations->rest(idle, std::vector<std::optional<double>>(limb.states().size()));
  const auto n = static_cast<Eigen::Index>(rest.size());
  const auto rates = [&](const std::vector<double>& y) {
    Eigen::VectorXd rate(n);
    equations->rates(idle, y.data(), rate.data());
    return rate;
  };
  Eigen::MatrixXd jacobian(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    constexpr double difference = 1e-7;
    std::vector<double> high = rest, low = rest;
    high[static_cast<std::size_t>(i)] += difference;
    low[static_cast<std::size_t>(i)] -= difference;
    jacobian.col(i) = (rates(high) - rates(low)) / (2.0 * difference);
  }
  return jacobian.eigenvalues().cwiseAbs().maxCoeff();
}

void stiffness(const sim::Recording& recording) {
  std::printf(
      "### A stiff limb: %.0f s of babbling with dry_friction (moment 0.003 N*m), relative tolerance 1e-6\n\n"
      "Method::automatic goes by the spectral radius at the start (stiff_for_explicit_1_s in plant/integrator.cpp).\n\n"
      "| smoothing_rad_s | spectral radius [1/s] | CVODE [ms] | ARKODE [ms] | quicker, by | with 16 columns: CVODE [ms] | ARKODE "
      "[ms] | quicker, by | automatic [ms] | it takes |\n|---|---|---|---|---|---|---|---|---|---|\n",
      recording.duration_s());
  const plant::SensitivityRequest request = bench::columns(16);
  for (const double smoothing_rad_s : {0.0, 1.0, 0.3, 0.2, 0.15, 0.1, 0.05, 0.02}) {
    plant::Plant limb = plant::default_plant();
    if (smoothing_rad_s > 0.0) {
      limb.set(limb.system().parameter("dry_friction.moment_Nm"), 0.003);
      limb.set(limb.system().parameter("dry_friction.smoothing_rad_s"), smoothing_rad_s);
      limb.turn_on_by_strength();
    }
    const plant::Start start = bench::given_start(limb);
    bench::Replay automatic, cvode, arkode;
    const std::vector<double> s =
        bench::fastest_in_turn_s(3, {[&] {
                                       cvode = bench::replay(recording, {plant::Method::cvode, 1e-6}, {}, limb);
                                     },
                                     [&] {
                                       arkode = bench::replay(recording, {plant::Method::arkode, 1e-6}, {}, limb);
                                     },
                                     [&] {
                                       automatic = bench::replay(recording, {plant::Method::automatic, 1e-6}, {}, limb);
                                     }});
    const std::vector<double> with_s =
        bench::fastest_in_turn_s(2, {[&] {
                                       bench::replay(recording, {plant::Method::cvode, 1e-6}, request, limb, start);
                                     },
                                     [&] {
                                       bench::replay(recording, {plant::Method::arkode, 1e-6}, request, limb, start);
                                     }});
    const auto quicker = [](const std::vector<double>& both_s) {
      char text[40];
      std::snprintf(text, sizeof text, "%s, %.1f", both_s[0] < both_s[1] ? "CVODE" : "ARKODE",
                    std::max(both_s[0], both_s[1]) / std::min(both_s[0], both_s[1]));
      return std::string(text);
    };
    char smoothing[16] = "none";
    if (smoothing_rad_s > 0.0) std::snprintf(smoothing, sizeof smoothing, "%g", smoothing_rad_s);
    std::printf("| %s | %.0f | %.1f | %.1f | %s | %.1f | %.1f | %s | %.1f | %s |\n", smoothing, spectral_radius_1_s(limb), 1e3 * s[0],
                1e3 * s[1], quicker(s).c_str(), 1e3 * with_s[0], 1e3 * with_s[1], quicker(with_s).c_str(), 1e3 * s[2],
                automatic.counters.steps == cvode.counters.steps ? "CVODE" : "ARKODE");
  }
  std::printf("\n");
}

// ERKStep on plant::Equations, with S = double or a Jet, restarted at each jump as the integrator does.
template <class S>
class Plain {
 public:
  Plain(const plant::Plant& limb, std::unique_ptr<plant::Equations<S>> equations, std::vector<double> start, int table, double tolerance)
      : states_(limb.states()), equations_(std::move(equations)), tolerance_(tolerance), jets_(states_.size()), jet_rates_(states_.size()) {
    given_.inputs.assign(limb.system().inputs().size(), 0.0);
    if (SUNContext_Create(nullptr, &context_) != 0) throw std::bad_alloc();
    start.resize(states_.size() * (1 + columns), 0.0);
    y_ = N_VNew_Serial(static_cast<sunindextype>(start.size()), context_);
    std::copy(start.begin(), start.end(), N_VGetArrayPointer(y_));
    memory_ = ERKStepCreate(rates, 0.0, y_, context_);
    ERKStepSetUserData(memory_, this);
    ERKStepSetTableNum(memory_, static_cast<ARKODE_ERKTableID>(table));
    ERKStepWFtolerances(memory_, weights);
    ERKStepSetMaxNumSteps(memory_, 1000000);
    ERKStepSetMaxErrTestFails(memory_, 50);  // of low order, it grows the step without bound where the limb rests
  }
  ~Plain() {
    ERKStepFree(&memory_);
    N_VDestroy(y_);
    SUNContext_Free(&context_);
  }
  Plain(const Plain&) = delete;
  Plain& operator=(const Plain&) = delete;

  bench::Replay replay(const sim::Recording& recording) {
    bench::Replay result;
    double next_step_s = 0.0;
    for (std::size_t k = 0; k < recording.samples.size(); ++k) {
      const sim::Sample& sample = recording.samples[k];
      if (k > 0) {
        ERKStepSetStopTime(memory_, sample.time_s);
        double reached_s = 0.0;
        if (ERKStepEvolve(memory_, sample.time_s, y_, &reached_s, ARK_NORMAL) < 0) throw std::runtime_error("ERKStep failed");
      }
      const double* y = N_VGetArrayPointer(y_);
      result.shown.push_back({y[0], y[1], y[4]});
      if (sample.inputs != given_.inputs) {
        given_.inputs = sample.inputs;
        count(result);
        if (k > 0) ERKStepGetCurrentStep(memory_, &next_step_s);
        ERKStepReInit(memory_, rates, sample.time_s, y_);
        ERKStepSetInitStep(memory_, next_step_s);
      }
    }
    count(result);
    return result;
  }

 private:
  static constexpr std::size_t columns = std::is_same_v<S, double> ? 0 : plant::jet_width;

  void count(bench::Replay& result) const {
    long expansions = 0, accuracy = 0, attempts = 0, rhs = 0, failures = 0;
    ERKStepGetTimestepperStats(memory_, &expansions, &accuracy, &attempts, &rhs, &failures);
    result.counters.steps += attempts - failures;
    result.counters.rhs_evaluations += rhs;
  }
  static int rates(double t, N_Vector y_vector, N_Vector rate_vector, void* user) {
    Plain& self = *static_cast<Plain*>(user);
    self.given_.time_s = t;
    const double* y = N_VGetArrayPointer(y_vector);
    double* rate = N_VGetArrayPointer(rate_vector);
    const std::size_t states = self.states_.size();
    if constexpr (columns == 0) {
      self.equations_->rates(self.given_, y, rate);
    } else {
      std::vector<S>&state = self.jets_, &state_rate = self.jet_rates_;
      using Row = Eigen::Matrix<double, static_cast<int>(columns), 1>;
      for (std::size_t i = 0; i < states; ++i) {
        state[i].a = y[i];
        state[i].v = Eigen::Map<const Row>(y + states + i * columns);
      }
      self.equations_->rates(self.given_, state.data(), state_rate.data());
      for (std::size_t i = 0; i < states; ++i) {
        rate[i] = state_rate[i].a;
        Eigen::Map<Row>(rate + states + i * columns) = state_rate[i].v;
      }
    }
    return 0;
  }
  static int weights(N_Vector y_vector, N_Vector weight_vector, void* user) {
    const Plain& self = *static_cast<Plain*>(user);
    const double* y = N_VGetArrayPointer(y_vector);
    double* weight = N_VGetArrayPointer(weight_vector);
    const std::size_t states = self.states_.size();
    for (std::size_t i = 0; i < states; ++i)
      weight[i] = std::sqrt(1.0 + columns) / (self.tolerance_ * (std::abs(y[i]) + self.states_[plant::StateId{i}].scale));
    std::fill(weight + states, weight + states * (1 + columns), 0.0);
    return 0;
  }

  plant::States states_;
  std::unique_ptr<plant::Equations<S>> equations_;
  double tolerance_;
  std::vector<S> jets_, jet_rates_;  // scratch
  plant::Situation given_;
  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr;
  void* memory_ = nullptr;
};

void tables(const sim::Recording& recording, const bench::Replay& reference) {
  struct Table {
    int number;
    const char* words;
  };
  const std::vector<Table> all{{ARKODE_HEUN_EULER_2_1_2, "Heun, Euler 2-1-2"},
                               {ARKODE_BOGACKI_SHAMPINE_4_2_3, "Bogacki, Shampine 4-2-3"},
                               {ARKODE_ARK324L2SA_ERK_4_2_3, "ARK324L2SA 4-2-3 (the integrator's)"},
                               {ARKODE_ZONNEVELD_5_3_4, "Zonneveld 5-3-4 (ARKODE's default)"},
                               {ARKODE_ARK436L2SA_ERK_6_3_4, "ARK436L2SA 6-3-4"},
                               {ARKODE_CASH_KARP_6_4_5, "Cash, Karp 6-4-5"},
                               {ARKODE_DORMAND_PRINCE_7_4_5, "Dormand, Prince 7-4-5"}};
  std::printf(
      "### Runge-Kutta tables of ARKODE as it comes, ten minutes of babbling, core plant\n\n"
      "Sinew's integrator adds its own step control and vector operations; the last column has sensitivities to 16 parameters.\n\n"
      "| table | 1e-5: ms | steps | angle error rms [deg] | 1e-6: ms | steps | angle error rms [deg] | 1e-5 with 16 columns: ms |\n"
      "|---|---|---|---|---|---|---|---|\n");
#if defined(__SSE__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);  // as the integrator does: sensitivities decay through subnormal numbers
#endif
  const plant::Plant limb = plant::default_plant();
  std::vector<std::pair<plant::ParameterId, int>> seeds;
  for (int k = 0; k < plant::jet_width; ++k) seeds.emplace_back(plant::ParameterId{static_cast<std::size_t>(k)}, k);
  const std::vector<double> start = plant::Integrator(limb, plant::Start{}, plant::NumericalSettings{}).state();
  const auto print_pair = [&](double ms, const bench::Replay& run) {
    std::printf(" %.1f | %lld | %.1e |", ms, static_cast<long long>(run.counters.steps), bench::errors_of(run, reference).angle_rms_deg);
  };
  for (const Table& table : all) {
    std::printf("| %s |", table.words);
    for (const double tolerance : {1e-5, 1e-6}) {
      bench::Replay run;
      const double ms =
          1e3 * bench::fastest_s(3, [&] { run = Plain<double>(limb, limb.equations(), start, table.number, tolerance).replay(recording); });
      print_pair(ms, run);
    }
    std::printf(" %.0f |\n", 1e3 * bench::fastest_s(2, [&] {
                               Plain<plant::Jet>(limb, limb.equations_with_derivatives(seeds), start, table.number, 1e-5).replay(recording);
                             }));
  }
  std::printf("| **Sinew's integrator** |");
  for (const double tolerance : {1e-5, 1e-6}) {
    bench::Replay run;
    const double ms = 1e3 * bench::fastest_s(3, [&] { run = bench::replay(recording, {plant::Method::arkode, tolerance}); });
    print_pair(ms, run);
  }
  std::printf(" %.0f |\n\n", 1e3 * bench::fastest_s(2, [&] {
                               bench::replay(recording, {plant::Method::arkode, 1e-5}, bench::columns(16));
                             }));
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const sim::Recording recording = bench::babbling(600.0);
  const bench::Replay reference = bench::replay(recording, {plant::Method::cvode, 1e-12});
  precision(recording, reference);
  stiffness(bench::first_part(recording, 60.0));
  tables(recording, reference);
  std::printf("Least of 2 to 7 repeats; %s.\n", bench::conditions().c_str());
}
