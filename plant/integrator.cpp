// SPDX-License-Identifier: Apache-2.0
#include "plant/integrator.h"

#include <arkode/arkode_erkstep.h>
#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "plant/padded.h"

namespace sinew::plant {
namespace {

constexpr std::size_t width = jet_width;  // columns that one pass carries

// Two moments nearer than this are one; far below any sample period, far above rounding.
constexpr double same_time_s = 1e-9;

struct Free {
  void operator()(_SUNContext* c) const { SUNContext_Free(&c); }
  void operator()(_generic_N_Vector* v) const { N_VDestroy(v); }
  void operator()(_generic_SUNMatrix* m) const { SUNMatDestroy(m); }
  void operator()(_generic_SUNLinearSolver* s) const { SUNLinSolFree(s); }
};
using Context = std::unique_ptr<_SUNContext, Free>;
using Vector = std::unique_ptr<_generic_N_Vector, Free>;

Context make_context() {
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) throw std::bad_alloc();
  return Context(context);
}

// Vectors of a few dozen doubles spend most of their time in the library's call per operation and its scalar loops; with
// these four, sensitivities take about half as long (bench/methods). Arguments may be the same vector.
namespace fast {

std::size_t length(N_Vector v) { return static_cast<std::size_t>(NV_LENGTH_S(v)); }

// One block of the sum: in registers where the width is known to the compiler.
template <int width>
Eigen::Array<double, width, 1> block_of(int count, const realtype* factors, N_Vector* vectors, std::size_t begin) {
  using Block = Eigen::Array<double, width, 1>;
  Block sum = Block::Zero();
  for (int k = 0; k < count; ++k) sum += factors[k] * Eigen::Map<const Block>(NV_DATA_S(vectors[k]) + begin);
  return sum;
}
template <int width>
void put(const Eigen::Array<double, width, 1>& block, double* to) {
  Eigen::Map<Eigen::Array<double, width, 1>>{to} = block;
}

int linear_combination(int count, realtype* factors, N_Vector* vectors, N_Vector result) {
  const std::size_t n = length(result);
  double* to = NV_DATA_S(result);
  if (n < 4) {
    for (std::size_t i = 0; i < n; ++i) put<1>(block_of<1>(count, factors, vectors, i), to + i);
    return 0;
  }
  // The last block may overlap the one before, so it is made before anything is overwritten.
  const auto last = block_of<4>(count, factors, vectors, n - 4);
  std::size_t begin = 0;
  for (; begin + 32 <= n; begin += 32) put<32>(block_of<32>(count, factors, vectors, begin), to + begin);
  for (; begin + 4 <= n; begin += 4) put<4>(block_of<4>(count, factors, vectors, begin), to + begin);
  put<4>(last, to + n - 4);
  return 0;
}

realtype wrms_norm(N_Vector x, N_Vector weight) {
  const auto n = static_cast<Eigen::Index>(length(x));
  using Values = Eigen::Map<const Eigen::ArrayXd>;
  return std::sqrt((Values(NV_DATA_S(x), n) * Values(NV_DATA_S(weight), n)).square().sum() / static_cast<double>(n));
}

void linear_sum(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector result) {
  const double *from_x = NV_DATA_S(x), *from_y = NV_DATA_S(y);
  double* to = NV_DATA_S(result);
  const std::size_t n = length(x);
  for (std::size_t i = 0; i < n; ++i) to[i] = a * from_x[i] + b * from_y[i];
}

void scale(realtype factor, N_Vector x, N_Vector result) {
  const double* from = NV_DATA_S(x);
  double* to = NV_DATA_S(result);
  const std::size_t n = length(x);
  for (std::size_t i = 0; i < n; ++i) to[i] = factor * from[i];
}

}  // namespace fast

Vector make_vector(std::size_t length, SUNContext context) {
  Vector v(N_VNew_Serial(static_cast<sunindextype>(length), context));
  if (!v) throw std::bad_alloc();
  N_VConst(0.0, v.get());
  v->ops->nvlinearcombination = fast::linear_combination;  // clones inherit these
  v->ops->nvlinearsum = fast::linear_sum;
  v->ops->nvscale = fast::scale;
  v->ops->nvwrmsnorm = fast::wrms_norm;
  return v;
}

// What both solvers are asked to integrate: the state, and the sensitivities in rows, one a state, padded to whole Jets.
class Problem {
 public:
  Problem(const Plant& of, const SensitivityRequest& request)
      : plant(of),
        states_info(of.states()),
        equations(of.equations()),
        request_(request),
        rate_(states_info.size()),
        jet_state_(states_info.size()),
        jet_rate_(states_info.size()) {
    const std::size_t chunks = (request.columns() + width - 1) / width;
    for (std::size_t c = 0; c < chunks; ++c) {
      std::vector<std::pair<ParameterId, int>> seeds;
      for (std::size_t k = 0; k < width && c * width + k < request.parameters.size(); ++k)
        seeds.emplace_back(request.parameters[c * width + k], static_cast<int>(k));
      chunk_equations.push_back(plant.equations_with_derivatives(seeds));
    }
    scratch.resize(2 * states() * padded_columns());
    rate_again.resize(states());
    situation.inputs.assign(plant.system().inputs().size(), 0.0);
  }

  std::size_t states() const { return states_info.size(); }
  std::size_t channels() const { return plant.system().channels().size(); }
  std::size_t padded_columns() const { return chunk_equations.size() * width; }
  const SensitivityRequest& request() const { return request_; }

  const Situation& at(double time_s) {
    situation.time_s = time_s;
    return situation;
  }

  // False where a rate is not a number.
  bool rates(double time_s, const double* y, double* rate) {
    ++rhs_evaluations;
    equations->rates(at(time_s), y, rate);
    return std::all_of(rate, rate + states(), [](double r) { return std::isfinite(r); });
  }

  // sensitivity and its rate: [states x padded columns], row by row.
  bool rates_with_sensitivity(double time_s, const double* y, const double* sensitivity, double* rate, double* sensitivity_rate) {
    ++rhs_evaluations;
    const std::size_t n = states();
    for (std::size_t c = 0; c < chunk_equations.size(); ++c) {
      load(c, y, sensitivity, jet_state_.data());
      chunk_equations[c]->rates(at(time_s), jet_state_.data(), jet_rate_.data());
      for (std::size_t i = 0; i < n; ++i) {
        rate[i] = jet_rate_[i].a;
        Eigen::Map<Eigen::Matrix<double, jet_width, 1>>(sensitivity_rate + i * padded_columns() + c * width) = jet_rate_[i].v;
      }
    }
    return std::all_of(rate, rate + n, [](double r) { return std::isfinite(r); });
  }

  // By how much each column's parameter or first value may well differ: internal units, positive.
  std::vector<double> typical_sizes() const {
    std::vector<double> sizes;
    for (const ParameterId p : request_.parameters) {
      const Declaration& declared = plant.system().parameters()[p].declaration;
      const double size = std::max(std::abs(declared.typical), declared.prior_deviation);
      sizes.push_back((size > 0.0 ? size : 1.0) * declared.unit.internal_per_unit);
    }
    for (const StateId i : request_.initial_states) sizes.push_back(states_info[i].scale);
    return sizes;
  }

  void load(std::size_t chunk, const double* y, const double* sensitivity, Jet* state) const {
    for (std::size_t i = 0; i < states(); ++i) {
      state[i].a = y[i];
      state[i].v = Eigen::Map<const Eigen::Matrix<double, jet_width, 1>>(sensitivity + i * padded_columns() + chunk * width);
    }
  }

  // columns: [states x states], one state's after another's; rates: [states], where wanted.
  void jacobian(double time_s, const double* y, double* columns, double* rates = nullptr) {
    ++jacobian_evaluations;
    const std::size_t n = states();
    if (!jacobian_equations) jacobian_equations = plant.equations_with_derivatives({});
    for (std::size_t begin = 0; begin < n; begin += width) {
      for (std::size_t i = 0; i < n; ++i) {
        jet_state_[i] = Jet(y[i]);
        if (i >= begin && i < begin + width) jet_state_[i].v[static_cast<Eigen::Index>(i - begin)] = 1.0;
      }
      jacobian_equations->rates(at(time_s), jet_state_.data(), jet_rate_.data());
      if (rates)
        for (std::size_t i = 0; i < n; ++i) rates[i] = jet_rate_[i].a;
      for (std::size_t j = begin; j < std::min(n, begin + width); ++j)
        for (std::size_t i = 0; i < n; ++i) columns[j * n + i] = jet_rate_[i].v[static_cast<Eigen::Index>(j - begin)];
    }
  }

  // [channels]; what `rates` computed is of this instant afterwards.
  std::vector<double> readings(double time_s, const double* y) {
    std::vector<double> shown(channels());
    equations->rates(at(time_s), y, rate_.data());
    equations->readings(y, shown.data());
    return shown;
  }

  void readings_with_sensitivity(double time_s, const double* y, const double* s, std::vector<double>& readings,
                                 Eigen::MatrixXd& sensitivity) {
    const auto columns = static_cast<Eigen::Index>(request_.columns());
    std::vector<Jet> shown(channels());
    readings = this->readings(time_s, y);
    sensitivity.resize(static_cast<Eigen::Index>(channels()), columns);
    for (std::size_t c = 0; c < chunk_equations.size(); ++c) {
      load(c, y, s, jet_state_.data());
      chunk_equations[c]->rates(at(time_s), jet_state_.data(), jet_rate_.data());
      chunk_equations[c]->readings(jet_state_.data(), shown.data());
      const auto first = static_cast<Eigen::Index>(c * width);
      const Eigen::Index count = std::min<Eigen::Index>(jet_width, columns - first);
      for (std::size_t channel = 0; channel < channels(); ++channel) {
        sensitivity.row(static_cast<Eigen::Index>(channel)).segment(first, count) = shown[channel].v.head(count);
        readings[channel] = shown[channel].a;
      }
    }
  }

  Plant plant;
  States states_info;
  std::unique_ptr<Equations<double>> equations;
  std::unique_ptr<Equations<Jet>> jacobian_equations;  // made when first asked for
  std::vector<std::unique_ptr<Equations<Jet>>> chunk_equations;
  Situation situation;  // its time is that of the last evaluation
  std::int64_t rhs_evaluations = 0;
  std::int64_t jacobian_evaluations = 0;
  std::vector<double> rate_again;  // scratch for the rates themselves
  std::vector<double> scratch;     // rows of the sensitivities and of their rates, for a solver that keeps columns

 private:
  SensitivityRequest request_;
  // Scratch; kept, since clearing so many derivatives at every call takes a tenth of the time.
  std::vector<double> rate_;
  std::vector<Jet> jet_state_, jet_rate_;
};

// One SUNDIALS integrator of a Problem. y: [states], s: [states x padded columns], row by row.
class Solver {
 public:
  virtual ~Solver() = default;
  virtual void restart(double time_s, const std::vector<double>& y, const std::vector<double>& s, double first_step_s) = 0;
  // 0, or SUNDIALS' error code.
  virtual int advance(double time_s, std::vector<double>& y, std::vector<double>& s) = 0;
  virtual double next_step_s() const = 0;
  virtual void count(SolverCounters& counters) const = 0;  // adds what was done since the last restart
  virtual std::string worst_states(const States& states) = 0;
  std::string message;  // SUNDIALS' last words
};

void keep_message(int, const char*, const char*, char* words, void* solver) { static_cast<Solver*>(solver)->message = words; }

void require(int flag, const char* call) {
  if (flag < 0) throw std::runtime_error(std::string(call) + " failed with code " + std::to_string(flag));
}

// States with the largest error weighted by tolerance, for the report of a failed integration.
// While it lives, numbers below 2.2e-308 are zero. The sensitivity to a first value decays through that range, where some
// processors take a hundred times as long for each operation.
class FlushSubnormals {
 public:
#if defined(__SSE__)
  explicit FlushSubnormals(bool on) : before_(_mm_getcsr()) {
    constexpr unsigned flush_to_zero = 0x8000, subnormals_are_zero = 0x0040;
    if (on) _mm_setcsr(before_ | flush_to_zero | subnormals_are_zero);
  }
  ~FlushSubnormals() { _mm_setcsr(before_); }
#else
  explicit FlushSubnormals(bool) : before_(0) {}
#endif
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
  unsigned before_;
};

std::string worst_of(const States& states, const double* error, const double* weight) {
  std::vector<std::pair<double, std::size_t>> all;
  for (std::size_t i = 0; i < states.size(); ++i) all.emplace_back(std::abs(error[i] * weight[i]), i);
  std::sort(all.rbegin(), all.rend());
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, all.size()); ++k) text += (k ? ", " : "") + states.values()[all[k].second].key;
  return text;
}

class CvodeSolver : public Solver {
 public:
  CvodeSolver(Problem& problem, const NumericalSettings& settings)
      : problem_(problem), context_(make_context()), columns_(problem.request().columns()) {
    const auto n = static_cast<sunindextype>(problem.states());
    y_ = make_vector(problem.states(), context_.get());
    tolerance_ = make_vector(problem.states(), context_.get());
    for (sunindextype i = 0; i < n; ++i)
      N_VGetArrayPointer(tolerance_.get())[i] =
          settings.relative_tolerance * problem.states_info.values()[static_cast<std::size_t>(i)].scale;
    matrix_.reset(SUNDenseMatrix(n, n, context_.get()));
    linear_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get()));
    memory_ = CVodeCreate(CV_BDF, context_.get());
    if (!memory_) throw std::bad_alloc();
    require(CVodeInit(memory_, rates, 0.0, y_.get()), "CVodeInit");
    require(CVodeSetErrHandlerFn(memory_, keep_message, static_cast<Solver*>(this)), "CVodeSetErrHandlerFn");
    require(CVodeSVtolerances(memory_, settings.relative_tolerance, tolerance_.get()), "CVodeSVtolerances");
    require(CVodeSetUserData(memory_, &problem_), "CVodeSetUserData");
    require(CVodeSetLinearSolver(memory_, linear_.get(), matrix_.get()), "CVodeSetLinearSolver");
    require(CVodeSetJacFn(memory_, jacobian), "CVodeSetJacFn");
    require(CVodeSetMaxNumSteps(memory_, settings.most_steps), "CVodeSetMaxNumSteps");
    if (columns_ > 0) {
      for (std::size_t k = 0; k < columns_; ++k) {
        sensitivity_.push_back(make_vector(problem.states(), context_.get()));
        sensitivity_pointers_.push_back(sensitivity_.back().get());
      }
      require(CVodeSensInit(memory_, static_cast<int>(columns_), CV_STAGGERED, sensitivity_rates, sensitivity_pointers_.data()),
              "CVodeSensInit");
      require(CVodeSetSensErrCon(memory_, SUNFALSE), "CVodeSetSensErrCon");
      // CVODES makes tolerances of the sensitivities, for its corrector, from those of the state and these sizes.
      std::vector<double> typical = problem.typical_sizes();
      require(CVodeSetSensParams(memory_, nullptr, typical.data(), nullptr), "CVodeSetSensParams");
      require(CVodeSensEEtolerances(memory_), "CVodeSensEEtolerances");
    }
  }
  ~CvodeSolver() override { CVodeFree(&memory_); }
  CvodeSolver(const CvodeSolver&) = delete;
  CvodeSolver& operator=(const CvodeSolver&) = delete;

  void restart(double time_s, const std::vector<double>& y, const std::vector<double>& s, double first_step_s) override {
    std::copy(y.begin(), y.end(), N_VGetArrayPointer(y_.get()));
    require(CVodeReInit(memory_, time_s, y_.get()), "CVodeReInit");
    if (columns_ > 0) {
      scatter(s.data(), sensitivity_pointers_.data());
      require(CVodeSensReInit(memory_, CV_STAGGERED, sensitivity_pointers_.data()), "CVodeSensReInit");
    }
    require(CVodeSetInitStep(memory_, first_step_s), "CVodeSetInitStep");
  }

  int advance(double time_s, std::vector<double>& y, std::vector<double>& s) override {
    CVodeSetStopTime(memory_, time_s);
    double reached = 0.0;
    const int flag = CVode(memory_, time_s, y_.get(), &reached, CV_NORMAL);
    if (flag < 0) return flag;
    std::copy_n(N_VGetArrayPointer(y_.get()), y.size(), y.begin());
    if (columns_ > 0) {
      CVodeGetSens(memory_, &reached, sensitivity_pointers_.data());
      gather(sensitivity_pointers_.data(), s.data());
    }
    return 0;
  }

  double next_step_s() const override {
    double h = 0.0;
    CVodeGetActualInitStep(memory_, &h);
    return h;
  }
  void count(SolverCounters& counters) const override {
    long steps = 0, rhs = 0, setups = 0, failures = 0;
    int order = 0, next_order = 0;
    double h0, h, next, t;
    CVodeGetIntegratorStats(memory_, &steps, &rhs, &setups, &failures, &order, &next_order, &h0, &h, &next, &t);
    counters.steps += steps;
    counters.error_test_failures += failures;
  }
  std::string worst_states(const States& states) override {
    Vector error(N_VClone(y_.get())), weight(N_VClone(y_.get()));
    CVodeGetEstLocalErrors(memory_, error.get());
    CVodeGetErrWeights(memory_, weight.get());
    return worst_of(states, N_VGetArrayPointer(error.get()), N_VGetArrayPointer(weight.get()));
  }

 private:
  void scatter(const double* rows, N_Vector* columns) const {
    for (std::size_t k = 0; k < columns_; ++k) {
      double* column = N_VGetArrayPointer(columns[k]);
      for (std::size_t i = 0; i < problem_.states(); ++i) column[i] = rows[i * problem_.padded_columns() + k];
    }
  }
  void gather(N_Vector* columns, double* rows) const {
    for (std::size_t k = 0; k < columns_; ++k) {
      const double* column = N_VGetArrayPointer(columns[k]);
      for (std::size_t i = 0; i < problem_.states(); ++i) rows[i * problem_.padded_columns() + k] = column[i];
    }
  }
  static int rates(double t, N_Vector y, N_Vector rate, void* problem) {
    return static_cast<Problem*>(problem)->rates(t, N_VGetArrayPointer(y), N_VGetArrayPointer(rate)) ? 0 : 1;
  }
  static int jacobian(double t, N_Vector y, N_Vector, SUNMatrix matrix, void* problem, N_Vector, N_Vector, N_Vector) {
    static_cast<Problem*>(problem)->jacobian(t, N_VGetArrayPointer(y), SUNDenseMatrix_Data(matrix));
    return 0;
  }
  static int sensitivity_rates(int, double t, N_Vector y, N_Vector, N_Vector* s, N_Vector* s_rate, void* problem_data, N_Vector, N_Vector) {
    auto& problem = *static_cast<Problem*>(problem_data);
    const std::size_t n = problem.states(), padded = problem.padded_columns(), columns = problem.request().columns();
    double* rows = problem.scratch.data();
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t i = 0; i < n; ++i) rows[i * padded + k] = N_VGetArrayPointer(s[k])[i];
    std::vector<double>& rate = problem.rate_again;
    double* rows_rate = rows + n * padded;
    const bool finite = problem.rates_with_sensitivity(t, N_VGetArrayPointer(y), rows, rate.data(), rows_rate);
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t i = 0; i < n; ++i) N_VGetArrayPointer(s_rate[k])[i] = rows_rate[i * padded + k];
    return finite ? 0 : 1;
  }

  Problem& problem_;
  Context context_;
  std::size_t columns_;
  Vector y_, tolerance_;
  std::unique_ptr<_generic_SUNMatrix, Free> matrix_;
  std::unique_ptr<_generic_SUNLinearSolver, Free> linear_;
  std::vector<Vector> sensitivity_;
  std::vector<N_Vector> sensitivity_pointers_;
  void* memory_ = nullptr;
};

class ArkodeSolver : public Solver {
 public:
  ArkodeSolver(Problem& problem, const NumericalSettings& settings) : problem_(problem), context_(make_context()) {
    const std::size_t n = problem.states();
    const std::size_t length = n * (1 + problem.padded_columns());
    y_ = make_vector(length, context_.get());
    for (const StateInfo& state : problem.states_info) absolute_tolerance_.push_back(settings.relative_tolerance * state.scale);
    relative_tolerance_ = settings.relative_tolerance;
    const std::vector<double> sizes = problem.typical_sizes();
    sensitivity_weights_.assign(n * problem.padded_columns(), 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < sizes.size(); ++k)
        sensitivity_weights_[i * problem.padded_columns() + k] =
            std::sqrt(static_cast<double>(1 + problem.padded_columns()) / static_cast<double>(sizes.size())) * sizes[k] /
            (wider_for_sensitivities * absolute_tolerance_[i]);
    memory_ = ERKStepCreate(rates, 0.0, y_.get(), context_.get());
    if (!memory_) throw std::bad_alloc();
    require(ERKStepSetErrHandlerFn(memory_, keep_message, static_cast<Solver*>(this)), "ERKStepSetErrHandlerFn");
    require(ERKStepSetUserData(memory_, this), "ERKStepSetUserData");
    // The beam's fastest mode limits the step (some 5 a sample) long before accuracy does, so that a method of low order
    // with few stages wins; bench/methods prints the comparison. A step that grows too fast after a restart is thrown away.
    require(ERKStepSetTableNum(memory_, ARKODE_ARK324L2SA_ERK_4_2_3), "ERKStepSetTableNum");
    constexpr int gustafsson = 3, default_parameters = 1;
    require(ERKStepSetAdaptivityMethod(memory_, gustafsson, default_parameters, 0, nullptr), "ERKStepSetAdaptivityMethod");
    require(ERKStepSetMaxFirstGrowth(memory_, 1.2), "ERKStepSetMaxFirstGrowth");
    require(ERKStepWFtolerances(memory_, weights), "ERKStepWFtolerances");
    require(ERKStepSetMaxNumSteps(memory_, settings.most_steps), "ERKStepSetMaxNumSteps");
  }
  ~ArkodeSolver() override { ERKStepFree(&memory_); }
  ArkodeSolver(const ArkodeSolver&) = delete;
  ArkodeSolver& operator=(const ArkodeSolver&) = delete;

  void restart(double time_s, const std::vector<double>& y, const std::vector<double>& s, double first_step_s) override {
    double* to = N_VGetArrayPointer(y_.get());
    std::copy(y.begin(), y.end(), to);
    std::copy(s.begin(), s.end(), to + y.size());
    require(ERKStepReInit(memory_, rates, time_s, y_.get()), "ERKStepReInit");
    require(ERKStepSetInitStep(memory_, first_step_s), "ERKStepSetInitStep");
  }
  int advance(double time_s, std::vector<double>& y, std::vector<double>& s) override {
    ERKStepSetStopTime(memory_, time_s);
    double reached = 0.0;
    const int flag = ERKStepEvolve(memory_, time_s, y_.get(), &reached, ARK_NORMAL);
    if (flag < 0) return flag;
    const double* from = N_VGetArrayPointer(y_.get());
    std::copy_n(from, y.size(), y.begin());
    std::copy_n(from + y.size(), s.size(), s.begin());
    return 0;
  }
  double next_step_s() const override {
    double h = 0.0;
    ERKStepGetCurrentStep(memory_, &h);
    return h;
  }
  void count(SolverCounters& counters) const override {
    long expansions = 0, accuracy = 0, attempts = 0, rhs = 0, failures = 0;
    ERKStepGetTimestepperStats(memory_, &expansions, &accuracy, &attempts, &rhs, &failures);
    counters.steps += attempts - failures;
    counters.error_test_failures += failures;
  }
  std::string worst_states(const States& states) override {
    Vector error(N_VClone(y_.get())), weight(N_VClone(y_.get()));
    ERKStepGetEstLocalErrors(memory_, error.get());
    ERKStepGetErrWeights(memory_, weight.get());
    return worst_of(states, N_VGetArrayPointer(error.get()), N_VGetArrayPointer(weight.get()));
  }

 private:
  static int rates(double t, N_Vector y, N_Vector rate, void* solver) {
    Problem& problem = static_cast<ArkodeSolver*>(solver)->problem_;
    const double* from = N_VGetArrayPointer(y);
    double* to = N_VGetArrayPointer(rate);
    const std::size_t n = problem.states();
    const bool finite =
        problem.padded_columns() == 0 ? problem.rates(t, from, to) : problem.rates_with_sensitivity(t, from, from + n, to, to + n);
    return finite ? 0 : 1;
  }
  // The norm is that of the states' errors, plus that of the sensitivities' with tolerances that are wider. They must not be
  // left out: near rest the states alone would let the step grow past the limit of stability, and the sensitivities,
  // which are not near zero, would grow without bound before a state shows it.
  static int weights(N_Vector y, N_Vector weight, void* solver) {
    auto& self = *static_cast<ArkodeSolver*>(solver);
    const double* from = N_VGetArrayPointer(y);
    double* to = N_VGetArrayPointer(weight);
    const std::size_t n = self.absolute_tolerance_.size();
    const double share = std::sqrt(static_cast<double>(1 + self.problem_.padded_columns()));
    for (std::size_t i = 0; i < n; ++i) to[i] = share / (self.relative_tolerance_ * std::abs(from[i]) + self.absolute_tolerance_[i]);
    std::copy(self.sensitivity_weights_.begin(), self.sensitivity_weights_.end(), to + n);
    return 0;
  }
  static constexpr double wider_for_sensitivities = 100.0;

  Problem& problem_;
  Context context_;
  Vector y_;
  std::vector<double> sensitivity_weights_;  // [states x padded columns], row by row
  std::vector<double> absolute_tolerance_;
  double relative_tolerance_;
  void* memory_ = nullptr;
};

// Linearly implicit Runge-Kutta: RODAS3, four stages, order 3 with an embedded one of order 2, L-stable and stiffly accurate.
// The exact Jacobian is at hand for little more than the rates, so that a mode that no sensor sees, as the beam's of 5 ms, limits
// no step: one or two steps a sample do at a fit's accuracy (bench/methods). SUNDIALS has no such method, and an explicit one is bound by
// that mode. State alone, without sensitivities.
//
// Source: Sandu, Verwer, Blom, Spee, Carmichael, Potra 1997, Atmospheric Environment 31:3459, appendix; in the form of Hairer, Wanner 1996,
// Solving Ordinary Differential Equations II, 2nd edition, equation (IV.7.25).
template <int Size>
class RosenbrockSolver : public Solver {
 public:
  RosenbrockSolver(Problem& problem, const NumericalSettings& settings)
      : problem_(problem), settings_(settings), n_(static_cast<Eigen::Index>(problem.states())), jacobian_(n_, n_) {
    const Eigen::Index rows = padded(problem.states());
    for (const StateInfo& state : problem.states_info) scales_.push_back(state.scale);
    for (Column* v : {&y_, &rate_, &later_rate_, &trial_, &time_slope_, &right_}) v->setZero(rows);
    for (Column& stage : stages_) stage.setZero(rows);
    inverse_.setIdentity(rows, rows);
  }

  void restart(double time_s, const std::vector<double>& y, const std::vector<double>&, double first_step_s) override {
    y_.head(n_) = Eigen::Map<const Eigen::VectorXd>(y.data(), n_);
    time_s_ = time_s;
    steps_ = failures_ = 0;
    if (first_step_s > 0.0) step_s_ = first_step_s;
  }

  int advance(double time_s, std::vector<double>& y, std::vector<double>&) override {
    int steps = 0;
    while (time_s_ < time_s) {
      problem_.jacobian(time_s_, y_.data(), jacobian_.data(), rate_.data());
      if (!rate_.allFinite()) return gave_up("a rate is not a number");
      const double nudge_s = 1e-6 * std::max(1.0, time_s_);  // rates hardly depend on time itself, and are smooth in it between events
      if (!problem_.rates(time_s_ + nudge_s, y_.data(), time_slope_.data())) return gave_up("a rate is not a number");
      time_slope_ = (time_slope_ - rate_) / nudge_s;
      for (;;) {
        if (++steps > settings_.most_steps) return gave_up("too many steps");
        const double left_s = time_s - time_s_;
        // Two equal steps rather than a long one and a sliver.
        const double wanted_s = step_s_ > 0.0 ? step_s_ : left_s;
        const double h = wanted_s >= left_s ? left_s : (2.0 * wanted_s > left_s ? 0.5 * left_s : wanted_s);
        const double error = tried(h);
        const double factor = std::clamp(0.9 / std::cbrt(std::max(error, 1e-10)), 0.2, 5.0);
        if (error <= 1.0) {
          ++steps_;
          y_.swap(trial_);
          time_s_ = h == left_s ? time_s : time_s_ + h;
          // What was cut short says little of how long a step may be.
          step_s_ = h < wanted_s ? std::max(wanted_s, h * factor) : h * factor;
          break;
        }
        ++failures_;
        step_s_ = h * std::min(factor, 0.9);
        if (!(step_s_ > 1e-12 * std::max(1.0, time_s_))) return gave_up("the step has become too small");
      }
    }
    std::copy_n(y_.data(), y.size(), y.begin());
    return 0;
  }

  double next_step_s() const override { return step_s_; }
  void count(SolverCounters& counters) const override {
    counters.steps += steps_;
    counters.error_test_failures += failures_;
  }
  std::string worst_states(const States& states) override {
    std::vector<double> weights;
    for (Eigen::Index i = 0; i < n_; ++i) weights.push_back(1.0 / tolerance(i));
    return worst_of(states, stages_.back().data(), weights.data());
  }

 private:
  using Column = Eigen::Vector<double, Size>;

  int gave_up(const char* words) {
    message = words;
    return -1;
  }
  double tolerance(Eigen::Index i) const { return settings_.relative_tolerance * (std::abs(y_(i)) + scales_[static_cast<std::size_t>(i)]); }

  // A step into trial_; its error in units of the tolerance, infinite where it leads nowhere.
  double tried(double h) {
    constexpr double gamma = 0.5;
    constexpr double infinite = std::numeric_limits<double>::infinity();
    inverse_.setIdentity();
    inverse_.topLeftCorner(n_, n_) = -jacobian_;
    inverse_.diagonal().head(n_).array() += 1.0 / (gamma * h);
    invert<Size>(inverse_);
    auto& [k1, k2, k3, k4] = stages_;
    right_ = rate_ + (0.5 * h) * time_slope_;
    k1 = product<Size>(inverse_, right_);
    right_ = rate_ + (4.0 / h) * k1 + (1.5 * h) * time_slope_;
    k2 = product<Size>(inverse_, right_);
    trial_ = y_ + 2.0 * k1;
    if (!problem_.rates(time_s_ + h, trial_.data(), later_rate_.data())) return infinite;
    right_ = later_rate_ + (k1 - k2) / h;
    k3 = product<Size>(inverse_, right_);
    trial_ += k3;
    if (!problem_.rates(time_s_ + h, trial_.data(), later_rate_.data())) return infinite;
    right_ = later_rate_ + (k1 - k2 - (8.0 / 3.0) * k3) / h;
    k4 = product<Size>(inverse_, right_);  // the error, too
    trial_ += k4;
    double sum = 0.0;
    for (Eigen::Index i = 0; i < n_; ++i) sum += std::pow(k4(i) / tolerance(i), 2);
    return std::isfinite(sum) ? std::sqrt(sum / static_cast<double>(n_)) : infinite;
  }

  Problem& problem_;
  NumericalSettings settings_;
  Eigen::Index n_;
  Eigen::MatrixXd jacobian_;
  Column y_, rate_, later_rate_, trial_, time_slope_, right_;  // padded
  std::array<Column, 4> stages_;
  Eigen::Matrix<double, Size, Size> inverse_;
  std::vector<double> scales_;
  double time_s_ = 0.0, step_s_ = 0.0;
  std::int64_t steps_ = 0, failures_ = 0;  // since the last restart
};

// Above this spectral radius at the start, an explicit method takes more steps than BDF would.
constexpr double stiff_for_explicit_1_s = 1000.0;

Method chosen_method(Problem& problem, Method wanted, const std::vector<double>& y) {
  if (wanted == Method::rosenbrock && problem.request().columns() > 0) wanted = Method::automatic;
  if (wanted != Method::automatic) return wanted;
  const auto n = static_cast<Eigen::Index>(problem.states());
  Eigen::MatrixXd jacobian(n, n);
  problem.jacobian(0.0, y.data(), jacobian.data());
  return jacobian.eigenvalues().cwiseAbs().maxCoeff() > stiff_for_explicit_1_s ? Method::cvode : Method::arkode;
}

std::unique_ptr<Solver> make_solver(Problem& problem, const NumericalSettings& settings) {
  if (settings.method == Method::cvode) return std::make_unique<CvodeSolver>(problem, settings);
  if (settings.method == Method::rosenbrock)
    return with_padded_size(problem.states(), [&](auto size) -> std::unique_ptr<Solver> {
      return std::make_unique<RosenbrockSolver<size.value>>(problem, settings);
    });
  return std::make_unique<ArkodeSolver>(problem, settings);
}

}  // namespace

class Integrator::Implementation {
 public:
  Implementation(const Plant& plant, const Start& start, const NumericalSettings& settings, const SensitivityRequest& request)
      : problem_(plant, request) {
    if (!start.inputs.empty()) problem_.situation.inputs = right_count(start.inputs);
    commanded_ = {problem_.situation.inputs, {}};
    begin(start);
    NumericalSettings chosen = settings;
    chosen.method = chosen_method(problem_, settings.method, y_);
    prepare(chosen);
  }
  Implementation(const Plant& plant, const Checkpoint& from, const NumericalSettings& settings)
      : problem_(plant, {}), y_(from.state), time_s_(from.time_s), next_step_s_(from.next_step_s), counters_(from.counters) {
    if (y_.size() != problem_.states()) throw std::invalid_argument("checkpoint is of another plant");
    problem_.situation.inputs = right_count(from.held_inputs);
    problem_.situation.segment_start_s = from.segment_start_s;
    for (const auto& [arrival_s, inputs] : from.commands_under_way) pending_.push_back({arrival_s, {right_count(inputs), {}}});
    commanded_ = pending_.empty() ? Command{problem_.situation.inputs, {}} : pending_.back().command;
    NumericalSettings chosen = settings;
    chosen.method = from.method;
    prepare(chosen);
  }

  void hold(const std::vector<double>& inputs, const std::vector<double>& slopes_1_s) {
    // What changes steadily is commanded anew by each call.
    if (inputs == commanded_.inputs && slopes_1_s.empty() && commanded_.slopes_1_s.empty()) return;
    commanded_ = {right_count(inputs), slopes_1_s.empty() ? slopes_1_s : right_count(slopes_1_s)};
    pending_.push_back({time_s_ + delay_s_, commanded_});
    apply_events();
  }

  std::optional<IntegrationFailure> advance_to(double time_s) {
    const FlushSubnormals flush(!s_.empty());
    while (time_s_ < time_s) {
      double stop_s = time_s;
      for (const auto& [arrival_s, command] : pending_) stop_s = std::min(stop_s, arrival_s);
      for (const double switch_s : switches_)
        if (switch_s > time_s_ + same_time_s) stop_s = std::min(stop_s, switch_s);
      if (stop_s > time_s - same_time_s) stop_s = time_s;
      if (!running_) {
        solver_->restart(time_s_, y_, s_, std::min(next_step_s_, stop_s - time_s_));
        running_ = true;
        ++counters_.restarts;
      }
      const int flag = solver_->advance(stop_s, y_, s_);
      if (flag != 0)
        return IntegrationFailure{time_s_, solver_->message + "; largest errors: " + solver_->worst_states(problem_.states_info)};
      time_s_ = stop_s;
      apply_events();
    }
    return std::nullopt;
  }

  void restart() {
    if (!running_) return;
    solver_->count(counters_);
    next_step_s_ = solver_->next_step_s();
    running_ = false;
  }

  Checkpoint checkpoint() {
    const auto changes = [](const Pending& one) { return !one.command.slopes_1_s.empty(); };
    if (!problem_.situation.slopes_1_s.empty() || std::any_of(pending_.begin(), pending_.end(), changes))
      throw std::logic_error("a checkpoint cannot be taken while an input changes steadily");
    restart();
    Checkpoint taken{method_, time_s_, problem_.situation.segment_start_s, problem_.situation.inputs, {}, y_, next_step_s_, counters()};
    for (const auto& [arrival_s, command] : pending_) taken.commands_under_way.emplace_back(arrival_s, command.inputs);
    return taken;
  }

  SolverCounters counters() const {
    SolverCounters total = counters_;
    if (running_) solver_->count(total);
    total.rhs_evaluations += problem_.rhs_evaluations;
    total.jacobian_evaluations += problem_.jacobian_evaluations;
    return total;
  }

  Problem problem_;
  std::vector<double> y_;
  std::vector<double> s_;  // [states x padded columns], row by row
  double time_s_ = 0.0;

 private:
  // The state at the start, and its sensitivities: through rest(), so that what settles moves with what is asked about.
  void begin(const Start& start) {
    const std::size_t n = problem_.states();
    std::vector<std::optional<double>> given = start.given;
    if (given.empty()) given.resize(n);
    if (given.size() != n) throw std::invalid_argument("start must give one entry a state");
    y_ = problem_.equations->rest(problem_.at(0.0), given);
    s_.assign(n * problem_.padded_columns(), 0.0);
    const auto& request = problem_.request();
    for (std::size_t c = 0; c < problem_.chunk_equations.size(); ++c) {
      std::vector<std::optional<Jet>> lifted(n);
      for (std::size_t i = 0; i < n; ++i)
        if (given[i]) lifted[i] = Jet(*given[i]);
      for (std::size_t k = 0; k < width; ++k) {
        const std::size_t column = c * width + k;
        if (column < request.parameters.size() || column >= request.columns()) continue;
        const std::size_t i = request.initial_states[column - request.parameters.size()].index;
        if (i >= n || !lifted[i]) throw std::invalid_argument("sensitivity to a first value that is not given");
        lifted[i]->v[static_cast<Eigen::Index>(k)] = 1.0;
      }
      const auto state = problem_.chunk_equations[c]->rest(problem_.at(0.0), lifted);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < width; ++k)
          s_[i * problem_.padded_columns() + c * width + k] = state[i].v[static_cast<Eigen::Index>(k)];
    }
  }

  void prepare(const NumericalSettings& settings) {
    delay_s_ = problem_.equations->input_delay_s();
    switches_ = problem_.equations->switch_times_s();
    delay_gradient_.assign(problem_.padded_columns(), 0.0);
    switch_gradients_.assign(switches_.size(), delay_gradient_);
    for (std::size_t c = 0; c < problem_.chunk_equations.size(); ++c) {
      const Jet delay = problem_.chunk_equations[c]->input_delay_s();
      const auto switches = problem_.chunk_equations[c]->switch_times_s();
      for (std::size_t k = 0; k < width; ++k) {
        const auto lane = static_cast<Eigen::Index>(k);
        delay_gradient_[c * width + k] = delay.v[lane];
        for (std::size_t e = 0; e < switches.size(); ++e) switch_gradients_[e][c * width + k] = switches[e].v[lane];
      }
    }
    method_ = settings.method;
    solver_ = make_solver(problem_, settings);
    apply_events();
  }

  // Takes up every command that has arrived and every switch that is due. Where the moment of such a jump depends on a
  // parameter, the sensitivities jump by (f before - f after) dt/dp.
  void apply_events() {
    const auto jump = [&](const auto& change, const std::vector<double>& time_gradient) {
      std::vector<double> before(problem_.states()), after(problem_.states());
      const bool moves = std::any_of(time_gradient.begin(), time_gradient.end(), [](double g) { return g != 0.0; });
      if (moves) problem_.rates(time_s_, y_.data(), before.data());
      restart();
      change();
      if (!moves) return;
      problem_.rates(time_s_, y_.data(), after.data());
      for (std::size_t i = 0; i < before.size(); ++i)
        for (std::size_t k = 0; k < time_gradient.size(); ++k)
          s_[i * time_gradient.size() + k] += (before[i] - after[i]) * time_gradient[k];
    };
    for (std::size_t e = 0; e < switches_.size(); ++e)
      if (switches_[e] <= time_s_ + same_time_s && switches_[e] > problem_.situation.segment_start_s)
        jump([&] { problem_.situation.segment_start_s = std::max(time_s_, switches_[e]); }, switch_gradients_[e]);
    while (!pending_.empty() && pending_.front().arrival_s <= time_s_ + same_time_s) {
      jump(
          [&] {
            problem_.situation.inputs = pending_.front().command.inputs;
            problem_.situation.slopes_1_s = pending_.front().command.slopes_1_s;
            problem_.situation.inputs_from_s = pending_.front().arrival_s;
            problem_.situation.segment_start_s = std::max(time_s_, problem_.situation.segment_start_s);
          },
          delay_gradient_);
      pending_.erase(pending_.begin());
    }
  }

  struct Command {
    std::vector<double> inputs, slopes_1_s;
  };
  struct Pending {
    double arrival_s;
    Command command;
  };
  const std::vector<double>& right_count(const std::vector<double>& inputs) const {
    if (inputs.size() != problem_.situation.inputs.size()) throw std::invalid_argument("one value for each input is needed");
    return inputs;
  }

  Method method_ = Method::cvode;
  std::unique_ptr<Solver> solver_;
  bool running_ = false;  // false: the solver must be restarted before it goes on
  Command commanded_;
  std::vector<Pending> pending_;
  double delay_s_ = 0.0;
  std::vector<double> switches_;
  std::vector<double> delay_gradient_;
  std::vector<std::vector<double>> switch_gradients_;
  double next_step_s_ = 0.0;
  SolverCounters counters_;
};

Integrator::Integrator(const Plant& plant, const Start& start, const NumericalSettings& settings, const SensitivityRequest& request)
    : implementation_(std::make_unique<Implementation>(plant, start, settings, request)) {}
Integrator::Integrator(const Plant& plant, const Checkpoint& from, const NumericalSettings& settings)
    : implementation_(std::make_unique<Implementation>(plant, from, settings)) {}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

void Integrator::hold(const std::vector<double>& inputs, const std::vector<double>& slopes_1_s) {
  implementation_->hold(inputs, slopes_1_s);
}
std::optional<IntegrationFailure> Integrator::advance_to(double time_s) { return implementation_->advance_to(time_s); }
void Integrator::restart() { implementation_->restart(); }
void Integrator::move(const Eigen::Ref<const Eigen::VectorXd>& by) {
  implementation_->restart();
  for (std::size_t i = 0; i < implementation_->y_.size(); ++i) implementation_->y_[i] += by(static_cast<Eigen::Index>(i));
}
Checkpoint Integrator::checkpoint() { return implementation_->checkpoint(); }
double Integrator::time_s() const { return implementation_->time_s_; }
const std::vector<double>& Integrator::state() const { return implementation_->y_; }
const States& Integrator::states() const { return implementation_->problem_.states_info; }
SolverCounters Integrator::counters() const { return implementation_->counters(); }
const Situation& Integrator::situation() const { return implementation_->problem_.at(time_s()); }

std::vector<double> Integrator::readings() const { return implementation_->problem_.readings(time_s(), state().data()); }

std::vector<double> Integrator::variables() const {
  auto& problem = implementation_->problem_;
  static_cast<void>(problem.readings(time_s(), state().data()));
  std::vector<double> values(problem.plant.system().variables().size());
  problem.equations->variables(state().data(), values.data());
  return values;
}

Eigen::MatrixXd Integrator::state_sensitivity() const {
  const auto& problem = implementation_->problem_;
  const auto n = static_cast<Eigen::Index>(problem.states());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Rows>(implementation_->s_.data(), n, static_cast<Eigen::Index>(problem.padded_columns()))
      .leftCols(static_cast<Eigen::Index>(problem.request().columns()));
}

void Integrator::readings_with_sensitivity(std::vector<double>& readings, Eigen::MatrixXd& sensitivity) const {
  const FlushSubnormals flush(true);
  implementation_->problem_.readings_with_sensitivity(time_s(), state().data(), implementation_->s_.data(), readings, sensitivity);
}

}  // namespace sinew::plant
