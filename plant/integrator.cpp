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
#include <cmath>
#include <functional>
#include <stdexcept>

namespace sinew::plant {
namespace {

constexpr int jacobian_width = 8;      // states a Jet carries when the Jacobian is made
constexpr int sensitivity_width = 16;  // columns a Jet carries when sensitivities are integrated
using JacobianJet = Jet<jacobian_width>;
using SensitivityJet = Jet<sensitivity_width>;

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
  Problem(const Limb<double>& limb, const SensitivityRequest& request)
      : equations(limb), jacobian_equations(lift<JacobianJet>(limb)), request_(request) {
    const std::size_t chunks = (request.columns() + sensitivity_width - 1) / sensitivity_width;
    for (std::size_t c = 0; c < chunks; ++c) {
      Limb<SensitivityJet> seeded = lift<SensitivityJet>(limb);
      const auto all = fields(seeded);
      for (std::size_t k = 0; k < sensitivity_width; ++k) {
        const std::size_t column = c * sensitivity_width + k;
        if (column >= request.parameters.size()) continue;
        if (request.parameters[column] >= all.size()) throw std::invalid_argument("sensitivity to a parameter that is not there");
        all[request.parameters[column]]->v[static_cast<Eigen::Index>(k)] = 1.0;
      }
      chunk_equations.emplace_back(seeded);
    }
    scratch.resize(2 * states() * padded_columns());
  }

  std::size_t states() const { return equations.layout().size(); }
  std::size_t padded_columns() const { return chunk_equations.size() * sensitivity_width; }
  const SensitivityRequest& request() const { return request_; }

  Situation at(double time_s) const { return {time_s, segment_start_s, duty_fraction}; }

  // False where a rate is not a number.
  bool rates(double time_s, const double* y, double* rate) {
    ++rhs_evaluations;
    Instant<double> now;
    equations.evaluate(at(time_s), y, now, rate);
    return std::all_of(rate, rate + states(), [](double r) { return std::isfinite(r); });
  }

  // sensitivity and its rate: [states x padded columns], row by row.
  bool rates_with_sensitivity(double time_s, const double* y, const double* sensitivity, double* rate,
                              double* sensitivity_rate) {
    ++rhs_evaluations;
    const std::size_t n = states();
    for (std::size_t c = 0; c < chunk_equations.size(); ++c) {
      load(c, y, sensitivity, jet_state_.data());
      chunk_equations[c].evaluate(at(time_s), jet_state_.data(), jet_instant_, jet_rate_.data());
      for (std::size_t i = 0; i < n; ++i) {
        rate[i] = jet_rate_[i].a;
        Eigen::Map<Eigen::Matrix<double, sensitivity_width, 1>>(sensitivity_rate + i * padded_columns() +
                                                               c * sensitivity_width) = jet_rate_[i].v;
      }
    }
    return std::all_of(rate, rate + n, [](double r) { return std::isfinite(r); });
  }

  // By how much each column's parameter or first value may well differ: internal units, positive.
  std::vector<double> typical_sizes() const {
    std::vector<double> sizes;
    for (const std::size_t p : request_.parameters) {
      const Declaration& declared = parameters()[p].declaration;
      const double size = std::max(std::abs(declared.typical), declared.prior_deviation);
      sizes.push_back((size > 0.0 ? size : 1.0) * declared.unit.internal_per_unit);
    }
    for (const std::size_t i : request_.initial_states) sizes.push_back(equations.layout().entries[i].declaration.scale);
    return sizes;
  }

  void load(std::size_t chunk, const double* y, const double* sensitivity, SensitivityJet* state) const {
    for (std::size_t i = 0; i < states(); ++i) {
      state[i].a = y[i];
      state[i].v = Eigen::Map<const Eigen::Matrix<double, sensitivity_width, 1>>(
          sensitivity + i * padded_columns() + chunk * sensitivity_width);
    }
  }

  // Column-major [states x states].
  void jacobian(double time_s, const double* y, double* columns) {
    ++jacobian_evaluations;
    const std::size_t n = states();
    Instant<JacobianJet> now;
    std::array<JacobianJet, largest_state_count> state, rate;
    for (std::size_t begin = 0; begin < n; begin += jacobian_width) {
      for (std::size_t i = 0; i < n; ++i) {
        state[i] = JacobianJet(y[i]);
        if (i >= begin && i < begin + jacobian_width) state[i].v[static_cast<Eigen::Index>(i - begin)] = 1.0;
      }
      jacobian_equations.evaluate(at(time_s), state.data(), now, rate.data());
      for (std::size_t j = begin; j < std::min(n, begin + jacobian_width); ++j)
        for (std::size_t i = 0; i < n; ++i) columns[j * n + i] = rate[i].v[static_cast<Eigen::Index>(j - begin)];
    }
  }

  Equations<double> equations;
  Equations<JacobianJet> jacobian_equations;
  std::vector<Equations<SensitivityJet>> chunk_equations;
  PerCoil<double> duty_fraction{};
  double segment_start_s = 0.0;
  std::int64_t rhs_evaluations = 0;
  std::int64_t jacobian_evaluations = 0;
  std::vector<double> scratch;  // rows of the sensitivities and of their rates, for a solver that keeps columns

 private:
  SensitivityRequest request_;
  // Scratch of rates_with_sensitivity; kept, since clearing so many derivatives at every call takes a tenth of the time.
  Instant<SensitivityJet> jet_instant_;
  std::array<SensitivityJet, largest_state_count> jet_state_, jet_rate_;
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
  virtual std::string worst_states(const Layout& layout) = 0;
  std::string message;  // SUNDIALS' last words
};

void keep_message(int, const char*, const char*, char* words, void* solver) {
  static_cast<Solver*>(solver)->message = words;
}

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

std::string worst_of(const Layout& layout, const double* error, const double* weight) {
  std::vector<std::pair<double, std::size_t>> all;
  for (std::size_t i = 0; i < layout.size(); ++i) all.emplace_back(std::abs(error[i] * weight[i]), i);
  std::sort(all.rbegin(), all.rend());
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, all.size()); ++k)
    text += (k ? ", " : "") + layout.entries[all[k].second].key;
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
          settings.relative_tolerance *
          problem.equations.layout().entries[static_cast<std::size_t>(i)].declaration.scale;
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
      require(CVodeSensInit(memory_, static_cast<int>(columns_), CV_STAGGERED, sensitivity_rates,
                            sensitivity_pointers_.data()),
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
  std::string worst_states(const Layout& layout) override {
    Vector error(N_VClone(y_.get())), weight(N_VClone(y_.get()));
    CVodeGetEstLocalErrors(memory_, error.get());
    CVodeGetErrWeights(memory_, weight.get());
    return worst_of(layout, N_VGetArrayPointer(error.get()), N_VGetArrayPointer(weight.get()));
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
  static int sensitivity_rates(int, double t, N_Vector y, N_Vector, N_Vector* s, N_Vector* s_rate, void* problem_data,
                               N_Vector, N_Vector) {
    auto& problem = *static_cast<Problem*>(problem_data);
    const std::size_t n = problem.states(), padded = problem.padded_columns(), columns = problem.request().columns();
    double* rows = problem.scratch.data();
    for (std::size_t k = 0; k < columns; ++k)
      for (std::size_t i = 0; i < n; ++i) rows[i * padded + k] = N_VGetArrayPointer(s[k])[i];
    std::array<double, largest_state_count> rate;
    double* rows_rate = rows + n * padded;
    const bool finite =
        problem.rates_with_sensitivity(t, N_VGetArrayPointer(y), rows, rate.data(), rows_rate);
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
    for (const auto& entry : problem.equations.layout().entries)
      absolute_tolerance_.push_back(settings.relative_tolerance * entry.declaration.scale);
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
  std::string worst_states(const Layout& layout) override {
    Vector error(N_VClone(y_.get())), weight(N_VClone(y_.get()));
    ERKStepGetEstLocalErrors(memory_, error.get());
    ERKStepGetErrWeights(memory_, weight.get());
    return worst_of(layout, N_VGetArrayPointer(error.get()), N_VGetArrayPointer(weight.get()));
  }

 private:
  static int rates(double t, N_Vector y, N_Vector rate, void* solver) {
    Problem& problem = static_cast<ArkodeSolver*>(solver)->problem_;
    const double* from = N_VGetArrayPointer(y);
    double* to = N_VGetArrayPointer(rate);
    const std::size_t n = problem.states();
    const bool finite = problem.padded_columns() == 0 ? problem.rates(t, from, to)
                                                      : problem.rates_with_sensitivity(t, from, from + n, to, to + n);
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
    for (std::size_t i = 0; i < n; ++i)
      to[i] = share / (self.relative_tolerance_ * std::abs(from[i]) + self.absolute_tolerance_[i]);
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

// Above this spectral radius at the start, an explicit method takes more steps than BDF would.
constexpr double stiff_for_explicit_1_s = 1000.0;

Method chosen_method(Problem& problem, Method wanted, const std::vector<double>& y) {
  if (wanted != Method::automatic) return wanted;
  const auto n = static_cast<Eigen::Index>(problem.states());
  Eigen::MatrixXd jacobian(n, n);
  problem.jacobian(0.0, y.data(), jacobian.data());
  return jacobian.eigenvalues().cwiseAbs().maxCoeff() > stiff_for_explicit_1_s ? Method::cvode : Method::arkode;
}

std::unique_ptr<Solver> make_solver(Problem& problem, const NumericalSettings& settings) {
  if (settings.method == Method::cvode) return std::make_unique<CvodeSolver>(problem, settings);
  return std::make_unique<ArkodeSolver>(problem, settings);
}

}  // namespace

class Integrator::Implementation {
 public:
  Implementation(const Limb<double>& limb, const Start& start, const NumericalSettings& settings,
                 const SensitivityRequest& request)
      : problem_(limb, request) {
    problem_.duty_fraction = start.duty_fraction;
    commanded_ = start.duty_fraction;
    begin(start);
    NumericalSettings chosen = settings;
    chosen.method = chosen_method(problem_, settings.method, y_);
    prepare(chosen);
  }
  Implementation(const Limb<double>& limb, const Checkpoint& from, const NumericalSettings& settings)
      : problem_(limb, {}), y_(from.state), time_s_(from.time_s), pending_(from.commands_under_way),
        next_step_s_(from.next_step_s), counters_(from.counters) {
    if (y_.size() != problem_.states()) throw std::invalid_argument("checkpoint is of another limb");
    problem_.duty_fraction = from.held_duty_fraction;
    problem_.segment_start_s = from.segment_start_s;
    commanded_ = pending_.empty() ? from.held_duty_fraction : pending_.back().second;
    NumericalSettings chosen = settings;
    chosen.method = from.method;
    prepare(chosen);
  }

  void hold(const PerCoil<double>& duty_fraction) {
    if (duty_fraction == commanded_) return;
    commanded_ = duty_fraction;
    pending_.emplace_back(time_s_ + delay_s_, duty_fraction);
    apply_events();
  }

  std::optional<IntegrationFailure> advance_to(double time_s) {
    const FlushSubnormals flush(!s_.empty());
    while (time_s_ < time_s) {
      double stop_s = time_s;
      for (const auto& [arrival_s, duty] : pending_) stop_s = std::min(stop_s, arrival_s);
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
        return IntegrationFailure{time_s_, solver_->message + "; largest errors: " +
                                               solver_->worst_states(problem_.equations.layout())};
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
    restart();
    return {method_, time_s_, problem_.segment_start_s, problem_.duty_fraction, pending_, y_, next_step_s_, counters()};
  }

  SolverCounters counters() const {
    SolverCounters total = counters_;
    if (running_) solver_->count(total);
    total.rhs_evaluations += problem_.rhs_evaluations;
    total.jacobian_evaluations += problem_.jacobian_evaluations;
    return total;
  }

  Instant<double> instant() const {
    Instant<double> now;
    std::array<double, largest_state_count> rate;
    problem_.equations.evaluate(problem_.at(time_s_), y_.data(), now, rate.data());
    return now;
  }

  void reading_with_sensitivity(Reading<double>& reading, Eigen::Matrix<double, 3, Eigen::Dynamic>& sensitivity) const {
    const FlushSubnormals flush(true);
    const auto columns = static_cast<Eigen::Index>(problem_.request().columns());
    sensitivity.resize(3, columns);
    Instant<SensitivityJet> now;
    std::array<SensitivityJet, largest_state_count> state, rate;
    for (std::size_t c = 0; c < problem_.chunk_equations.size(); ++c) {
      const auto& equations = problem_.chunk_equations[c];
      problem_.load(c, y_.data(), s_.data(), state.data());
      equations.evaluate(problem_.at(time_s_), state.data(), now, rate.data());
      const Reading<SensitivityJet> shown = equations.reading(now, state.data());
      const auto first = static_cast<Eigen::Index>(c) * sensitivity_width;
      const Eigen::Index width = std::min<Eigen::Index>(sensitivity_width, columns - first);
      for (Eigen::Index k = 0; k < width; ++k) {
        for (const std::size_t j : coils)
          sensitivity(static_cast<Eigen::Index>(j), first + k) = shown.temperature_degC[j].v[k];
        sensitivity(2, first + k) = shown.angle_rad.v[k];
      }
      for (const std::size_t j : coils) reading.temperature_degC[j] = shown.temperature_degC[j].a;
      reading.angle_rad = shown.angle_rad.a;
    }
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
    y_ = problem_.equations.rest(problem_.at(0.0), given);
    s_.assign(n * problem_.padded_columns(), 0.0);
    const auto& request = problem_.request();
    for (std::size_t c = 0; c < problem_.chunk_equations.size(); ++c) {
      std::vector<std::optional<SensitivityJet>> lifted(n);
      for (std::size_t i = 0; i < n; ++i)
        if (given[i]) lifted[i] = SensitivityJet(*given[i]);
      for (std::size_t k = 0; k < sensitivity_width; ++k) {
        const std::size_t column = c * sensitivity_width + k;
        if (column < request.parameters.size() || column >= request.columns()) continue;
        const std::size_t i = request.initial_states[column - request.parameters.size()];
        if (i >= n || !lifted[i]) throw std::invalid_argument("sensitivity to a first value that is not given");
        lifted[i]->v[static_cast<Eigen::Index>(k)] = 1.0;
      }
      const auto state = problem_.chunk_equations[c].rest(problem_.at(0.0), lifted);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < sensitivity_width; ++k)
          s_[i * problem_.padded_columns() + c * sensitivity_width + k] = state[i].v[static_cast<Eigen::Index>(k)];
    }
  }

  void prepare(const NumericalSettings& settings) {
    delay_s_ = problem_.equations.command_delay_s();
    switches_ = problem_.equations.switch_times_s();
    delay_gradient_.assign(problem_.padded_columns(), 0.0);
    switch_gradients_.assign(switches_.size(), delay_gradient_);
    for (std::size_t c = 0; c < problem_.chunk_equations.size(); ++c) {
      const SensitivityJet delay = problem_.chunk_equations[c].command_delay_s();
      const auto switches = problem_.chunk_equations[c].switch_times_s();
      for (std::size_t k = 0; k < sensitivity_width; ++k) {
        const auto lane = static_cast<Eigen::Index>(k);
        delay_gradient_[c * sensitivity_width + k] = delay.v[lane];
        for (std::size_t e = 0; e < switches.size(); ++e)
          switch_gradients_[e][c * sensitivity_width + k] = switches[e].v[lane];
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
      if (switches_[e] <= time_s_ + same_time_s && switches_[e] > problem_.segment_start_s)
        jump([&] { problem_.segment_start_s = std::max(time_s_, switches_[e]); }, switch_gradients_[e]);
    while (!pending_.empty() && pending_.front().first <= time_s_ + same_time_s) {
      jump(
          [&] {
            problem_.duty_fraction = pending_.front().second;
            problem_.segment_start_s = std::max(time_s_, problem_.segment_start_s);
          },
          delay_gradient_);
      pending_.erase(pending_.begin());
    }
  }

  Method method_ = Method::cvode;
  std::unique_ptr<Solver> solver_;
  bool running_ = false;  // false: the solver must be restarted before it goes on
  PerCoil<double> commanded_{};
  std::vector<std::pair<double, PerCoil<double>>> pending_;
  double delay_s_ = 0.0;
  std::vector<double> switches_;
  std::vector<double> delay_gradient_;
  std::vector<std::vector<double>> switch_gradients_;
  double next_step_s_ = 0.0;
  SolverCounters counters_;
};

Integrator::Integrator(const Limb<double>& limb, const Start& start, const NumericalSettings& settings,
                       const SensitivityRequest& request)
    : implementation_(std::make_unique<Implementation>(limb, start, settings, request)) {}
Integrator::Integrator(const Limb<double>& limb, const Checkpoint& from, const NumericalSettings& settings)
    : implementation_(std::make_unique<Implementation>(limb, from, settings)) {}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

void Integrator::hold(const PerCoil<double>& duty_fraction) { implementation_->hold(duty_fraction); }
std::optional<IntegrationFailure> Integrator::advance_to(double time_s) { return implementation_->advance_to(time_s); }
void Integrator::restart() { implementation_->restart(); }
Checkpoint Integrator::checkpoint() { return implementation_->checkpoint(); }
double Integrator::time_s() const { return implementation_->time_s_; }
const std::vector<double>& Integrator::state() const { return implementation_->y_; }
const Layout& Integrator::layout() const { return implementation_->problem_.equations.layout(); }
Instant<double> Integrator::instant() const { return implementation_->instant(); }
SolverCounters Integrator::counters() const { return implementation_->counters(); }

Reading<double> Integrator::reading() const {
  return implementation_->problem_.equations.reading(instant(), state().data());
}

Eigen::MatrixXd Integrator::state_sensitivity() const {
  const auto& problem = implementation_->problem_;
  const auto n = static_cast<Eigen::Index>(problem.states());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Rows>(implementation_->s_.data(), n, static_cast<Eigen::Index>(problem.padded_columns()))
      .leftCols(static_cast<Eigen::Index>(problem.request().columns()));
}

void Integrator::reading_with_sensitivity(Reading<double>& reading,
                                          Eigen::Matrix<double, 3, Eigen::Dynamic>& sensitivity) const {
  implementation_->reading_with_sensitivity(reading, sensitivity);
}

}  // namespace sinew::plant
