// SPDX-License-Identifier: Apache-2.0
#include "diagnose/free_laws.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "diagnose/locate.h"
#include "diagnose/projection.h"
#include "sim/parallel.h"

namespace sinew::diagnose {
namespace {

constexpr std::size_t knot_count = 24;  // linear between them, a smooth curve is off by less than a hundredth of its bend
constexpr double smooth_over = 0.12;    // of the knots: the length over which a curve's values are alike
constexpr Eigen::Index shapes = 16;     // of which a curve is made: what such a prior leaves besides is below a thousandth of its size
constexpr std::array sizes{0.3, 1.0, 3.0, 10.0, 30.0};
constexpr std::array fading_memories_s{0.0, 15.0};
constexpr double typical_share = 0.2;  // of a factor

// What lies half-way between the quantiles and even steps: where the data are, and no two in one place.
std::vector<double> knots_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const double low = values.front(), high = values.back();
  if (!(high - low > 1e-9 * (std::abs(low) + std::abs(high)))) return {};
  std::vector<double> knots;
  for (std::size_t k = 0; k < knot_count; ++k) {
    const double share = static_cast<double>(k) / (knot_count - 1);
    const double quantile = values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    knots.push_back(0.5 * (quantile + low + share * (high - low)));
  }
  return knots;
}

// The shapes that a smooth law of size 1 is made of, each with the weight that the prior gives it: principal components of its covariance.
// Lengths are counted in knots, so that a curve can bend more where the data are.
Eigen::MatrixXd smooth_curve(const std::vector<double>& knots) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  const double length = smooth_over * static_cast<double>(knots.size() - 1);
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double apart = static_cast<double>(i - j) / length;
      covariance(i, j) = std::exp(-0.5 * apart * apart);
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> components(covariance);
  Eigen::MatrixXd curve(n, shapes);
  for (Eigen::Index j = 0; j < shapes; ++j) {
    const Eigen::Index k = n - 1 - j;  // by falling variance
    curve.col(j) = components.eigenvectors().col(k) * std::sqrt(std::max(0.0, components.eigenvalues()(k)));
    if (curve.col(j).sum() < 0.0) curve.col(j) *= -1.0;
  }
  return curve;
}

// The variable at the blocks, less its own low-pass, which begins anew with every recording.
Eigen::VectorXd less_slow_part(const Eigen::VectorXd& variable, const std::vector<Blocks::Block>& blocks, double memory_s) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(variable.size());
  double slow = 0.0;
  for (Eigen::Index i = 0; i < variable.size(); ++i) {
    const Blocks::Block& block = blocks[static_cast<std::size_t>(i)];
    if (i == 0 || block.recording != blocks[static_cast<std::size_t>(i - 1)].recording)
      slow = variable(i);
    else
      slow += (variable(i) - slow) * -std::expm1(-(block.time_s - blocks[static_cast<std::size_t>(i - 1)].time_s) / memory_s);
    result(i) = variable(i) - slow;
  }
  return result;
}

// What a law is of, in all its parts, at the blocks.
std::vector<double> values_of(const plant::Law& law, const Explanation& at, const std::vector<Eigen::VectorXd>& variables) {
  std::vector<double> values;
  for (const plant::VariableId v : law.argument) {
    const Eigen::VectorXd series =
        law.fading_memory_s > 0.0 ? less_slow_part(variables[v.index], at.blocks->blocks(), law.fading_memory_s) : variables[v.index];
    values.insert(values.end(), series.begin(), series.end());
  }
  return values;
}

// Of a curve by its values at knots: straight between them, held beyond.
double interpolated(const std::vector<double>& knots, const Eigen::VectorXd& values, double x) {
  if (!(x > knots.front())) return values(0);
  if (!(x < knots.back())) return values(values.size() - 1);
  const auto above = static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin());
  const double share = (x - knots[above - 1]) / (knots[above] - knots[above - 1]);
  return (1.0 - share) * values(static_cast<Eigen::Index>(above - 1)) + share * values(static_cast<Eigen::Index>(above));
}

std::vector<plant::Law> cells_of(const Explanation& at, const std::vector<Eigen::VectorXd>& variables) {
  const plant::System& system = at.system();
  std::vector<plant::Law> laws;
  if (variables.empty()) return laws;
  const plant::Plant model = at.model();
  const auto is_on = [&](const plant::Law& law) {
    return std::any_of(system.effects().begin(), system.effects().end(), [&](const plant::EffectInfo& effect) {
      if (!effect.law || model.get(effect.strength) == 0.0) return false;
      const plant::Law& other = system.laws()[*effect.law];
      return other.entry == law.entry && other.argument == law.argument && other.factor == law.factor &&
             other.fading_memory_s == law.fading_memory_s;
    });
  };
  for (const plant::EntryGroupId g : system.entry_groups().ids()) {
    std::vector<const plant::Entry*> entries;
    for (const plant::Entry& entry : system.entries())
      if (entry.group == g && (entry.state || entry.channel)) entries.push_back(&entry);
    if (entries.empty()) continue;
    std::size_t arguments = entries.front()->may_depend_on.size(), factors = entries.front()->factors.size();
    for (const plant::Entry* entry : entries) {
      arguments = std::min(arguments, entry->may_depend_on.size());
      factors = std::min(factors, entry->factors.size());
    }
    for (std::size_t a = 0; a < arguments; ++a)
      for (const double memory_s : fading_memories_s) {
        plant::Law law{.entry = g, .argument = {}, .factor = {}, .fading_memory_s = memory_s, .knots = {}, .curve = {}, .is_sought = true};
        bool of_time = false;
        for (const plant::Entry* entry : entries) {
          const plant::VariableId v = entry->may_depend_on[a];
          of_time = of_time || system.variables()[v].name == "time";
          law.argument.push_back(v);
        }
        std::vector<double> values = values_of(law, at, variables);
        if (of_time || !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) continue;
        law.knots = knots_of(std::move(values));
        if (law.knots.empty()) continue;
        const Eigen::MatrixXd smooth = smooth_curve(law.knots);
        for (std::size_t f = 0; f <= factors; ++f) {
          law.factor.clear();
          for (const plant::Entry* entry : entries)
            if (f > 0) law.factor.push_back(entry->factors[f - 1]);
          law.curve = (f > 0 ? typical_share : system.entry_groups()[g].typical) * smooth;
          if (!is_on(law)) laws.push_back(law);
        }
      }
  }
  return laws;
}

// A variable, or a part of an equation, at a sample: between those at the first samples of the blocks around it.
class AtSamples {
 public:
  AtSamples(const Explanation& at, std::size_t recording) : samples_(at.problem->data()[recording].recording->samples) {
    const auto& blocks = at.blocks->blocks();
    for (std::size_t b = 0; b < blocks.size(); ++b)
      if (blocks[b].recording == recording) of_block_.push_back(b);
    for (std::size_t k = 0, i = 0; k < at.problem->data()[recording].sample_count; ++k) {
      while (i + 1 < of_block_.size() && blocks[of_block_[i + 1]].first_sample <= k) ++i;
      const std::size_t next = std::min(i + 1, of_block_.size() - 1);
      const double from_s = samples_[blocks[of_block_[i]].first_sample].time_s,
                   to_s = samples_[blocks[of_block_[next]].first_sample].time_s;
      where_.push_back({of_block_[i], of_block_[next], to_s > from_s ? (samples_[k].time_s - from_s) / (to_s - from_s) : 0.0});
    }
  }
  double value(const Eigen::VectorXd& series, std::size_t sample) const {
    const auto& [low, high, share] = where_[sample];
    return (1.0 - share) * series(static_cast<Eigen::Index>(low)) + share * series(static_cast<Eigen::Index>(high));
  }

 private:
  struct Where {
    std::size_t low, high;
    double share;
  };
  const std::vector<sim::Sample>& samples_;
  std::vector<std::size_t> of_block_;
  std::vector<Where> where_;
};

// Adds `scale` times the law's shapes at x.
void add_shapes(const plant::Law& law, double x, double scale, Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> to) {
  const std::vector<double>& knots = law.knots;
  if (!(x > knots.front())) {
    to += scale * law.curve.row(0);
    return;
  }
  if (!(x < knots.back())) {
    to += scale * law.curve.row(law.curve.rows() - 1);
    return;
  }
  const auto above = static_cast<Eigen::Index>(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin());
  const double low = knots[static_cast<std::size_t>(above - 1)], share = (x - low) / (knots[static_cast<std::size_t>(above)] - low);
  to += scale * ((1.0 - share) * law.curve.row(above - 1) + share * law.curve.row(above));
}

// What the weights of these laws do to the rows, [rows x weights], row-major: the linear response of the plant along its path. Laws that
// are off change nothing of the path, so one path serves them all.
std::vector<double> responses(const Explanation& at, const Path& path, const std::vector<Eigen::VectorXd>& variables,
                              const std::vector<plant::Law>& laws, std::size_t first, std::size_t end) {
  const plant::System& system = at.system();
  const plant::Plant model = at.model();
  const auto n = static_cast<Eigen::Index>(model.states().size()), channels = static_cast<Eigen::Index>(system.channels().size());
  std::vector<Eigen::Index> at_column;
  Eigen::Index weights = 0;
  for (std::size_t l = first; l < end; ++l) {
    at_column.push_back(weights);
    weights += laws[l].curve.cols();
  }
  struct Acts {
    const plant::Law* law;
    Eigen::Index column;
    const plant::Entry* entry;
    Eigen::VectorXd argument;
    const Eigen::VectorXd* factor;
    double divided_by;
  };
  std::vector<Acts> acts;
  for (std::size_t l = first; l < end; ++l) {
    std::size_t part = 0;
    for (const plant::Entry& entry : system.entries()) {
      if (entry.group != laws[l].entry) continue;
      const Eigen::VectorXd& variable = variables[laws[l].argument[part].index];
      acts.push_back({&laws[l], at_column[l - first], &entry,
                      laws[l].fading_memory_s > 0.0 ? less_slow_part(variable, at.blocks->blocks(), laws[l].fading_memory_s) : variable,
                      laws[l].factor.empty() ? nullptr : &variables[laws[l].factor[part].index],
                      entry.divided_by ? model.get(*entry.divided_by) : 1.0});
      ++part;
    }
  }
  std::vector<double> rows(at.problem->rows().size() * static_cast<std::size_t>(weights));
  std::size_t row = 0;
  Eigen::MatrixXd state(n, weights), push(n, weights), shown(channels, weights);
  for (std::size_t r = 0; r < at.problem->data().size(); ++r) {
    const FitData& data = at.problem->data()[r];
    const AtSamples series(at, r);
    state.setZero();
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      const PathPoint& point = path.points[r][k];
      shown.noalias() = point.reading * state;
      push.setZero();
      for (const Acts& act : acts) {
        const double x = series.value(act.argument, k), times = act.factor ? series.value(*act.factor, k) : 1.0;
        const Eigen::Index columns = act.law->curve.cols();
        if (act.entry->channel)
          add_shapes(*act.law, x, times, shown.row(static_cast<Eigen::Index>(act.entry->channel->index)).segment(act.column, columns));
        if (act.entry->state)
          add_shapes(*act.law, x, times / act.divided_by,
                     push.row(static_cast<Eigen::Index>(act.entry->state->index)).segment(act.column, columns));
      }
      for (const plant::ChannelId c : system.channels().ids()) {
        if (std::isnan(measured(data.recording->samples[k], c))) continue;
        Eigen::Map<Eigen::RowVectorXd>(rows.data() + row * static_cast<std::size_t>(weights), weights) =
            shown.row(static_cast<Eigen::Index>(c.index)) / (data.deviation[c] * system.channels()[c].unit.internal_per_unit);
        ++row;
      }
      if (point.transition.size() == 0) continue;
      const Eigen::MatrixXd pushed = point.integral * push;
      state = point.transition * state + pushed;
    }
  }
  return rows;
}

}  // namespace

std::vector<LawCandidate> screen_laws(const Explanation& at, int threads, const std::function<bool(const plant::Law&)>& wanted) {
  const std::vector<Eigen::VectorXd> variables = variables_of(at);
  std::vector<plant::Law> laws = cells_of(at, variables);
  if (wanted) std::erase_if(laws, [&](const plant::Law& law) { return !wanted(law); });
  std::vector<LawCandidate> candidates(laws.size());
  if (laws.empty()) return candidates;
  const Projection rest(at);
  constexpr std::size_t together = 8;
  sim::in_parallel((laws.size() + together - 1) / together, threads, [&](std::size_t job) {
    const std::size_t first = job * together, end = std::min(laws.size(), first + together);
    const std::vector<double> rows = responses(at, rest.path(), variables, laws, first, end);
    Eigen::MatrixXd columns = at.blocks->means(rows.data(), rows.size() / at.problem->rows().size());
    if (!columns.allFinite()) return;
    rest.whiten(columns);
    Eigen::Index at_column = 0;
    for (std::size_t l = first; l < end; ++l) {
      const Eigen::Index n = laws[l].curve.cols();
      const Projection::Left left = rest.of(columns.middleCols(at_column, n));
      at_column += n;
      LawCandidate best;
      best.gain = -1e300;
      for (const double size : sizes) {
        Eigen::MatrixXd information = left.squares * (size * size);
        information.diagonal().array() += 1.0;
        const Eigen::LLT<Eigen::MatrixXd> factor(information);
        const Eigen::VectorXd along = size * left.along, solved = factor.solve(along);
        double log_determinant = 0.0;
        for (Eigen::Index i = 0; i < n; ++i) log_determinant += 2.0 * std::log(factor.matrixL()(i, i));
        const double gain = 0.5 * along.dot(solved) - 0.5 * log_determinant;
        if (!(gain > best.gain)) continue;
        best.law = laws[l];
        best.law.curve *= size;
        best.gain = gain;
        best.weights = -solved;
      }
      candidates[l] = std::move(best);
    }
  });
  std::erase_if(candidates, [](const LawCandidate& one) { return one.weights.size() == 0; });
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
  return candidates;
}

LawCandidate where_the_data_are(const Explanation& at, plant::EffectId law) {
  const plant::System& system = at.system();
  LawCandidate result;
  result.law = system.laws()[*system.effects()[law].law];
  const std::vector<Eigen::VectorXd> variables = variables_of(at);
  if (variables.empty()) return result;
  const std::vector<double> knots = knots_of(values_of(result.law, at, variables));
  if (knots.empty()) return result;
  const Eigen::VectorXd values = plant::values_of(at.model(), law);
  const Eigen::MatrixXd shapes_there = smooth_curve(knots) * (result.law.curve.norm() / smooth_curve(result.law.knots).norm());
  Eigen::VectorXd target(static_cast<Eigen::Index>(knots.size()));
  for (Eigen::Index k = 0; k < target.size(); ++k) target(k) = interpolated(result.law.knots, values, knots[static_cast<std::size_t>(k)]);
  result.law.knots = knots;
  result.law.curve = shapes_there;
  result.law.name.clear();
  // The likeliest weights, the values taken as known to a hundredth of a law's size.
  const double size = shapes_there.norm() / std::sqrt(static_cast<double>(knots.size())), loose = std::pow(0.01 * size, 2);
  Eigen::MatrixXd information = shapes_there.transpose() * shapes_there / loose;
  information.diagonal().array() += 1.0;
  result.weights = information.ldlt().solve(shapes_there.transpose() * target / loose);
  return result;
}

std::vector<ClosedForm> forms_within(const std::vector<double>& knots, const std::vector<double>& values,
                                     const std::vector<double>& deviation) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  const double low = knots.front(), range = knots.back() - low;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double span = *most - *least;
  if (!(span > 0.0)) return {};
  const Eigen::Map<const Eigen::VectorXd> target(values.data(), n);
  Eigen::VectorXd width(n);
  for (Eigen::Index k = 0; k < n; ++k) width(k) = 2.0 * std::max(deviation[static_cast<std::size_t>(k)], 0.02 * span);

  std::vector<ClosedForm> forms;
  // The best of a family of shapes with an offset and an amplitude, each knot weighted by its band.
  const auto ask = [&](const char* words, const std::vector<std::function<double(double)>>& shapes) {
    double best = 1e300;
    for (const auto& shape : shapes) {
      Eigen::MatrixXd columns(n, 2);
      for (Eigen::Index k = 0; k < n; ++k) columns.row(k) << 1.0, shape(knots[static_cast<std::size_t>(k)]);
      const Eigen::MatrixXd weighted = width.cwiseInverse().asDiagonal() * columns;
      const Eigen::Vector2d fitted = (weighted.transpose() * weighted).ldlt().solve(weighted.transpose() * target.cwiseQuotient(width));
      const Eigen::VectorXd off = columns * fitted - target;
      if ((off.cwiseAbs().array() > width.array()).any()) continue;
      best = std::min(best, std::sqrt(off.squaredNorm() / static_cast<double>(n)) / span);
    }
    if (best < 1e300) forms.push_back({words, best});
  };
  ask("a line", {[](double x) { return x; }});
  ask("a parabola about zero", {[](double x) { return x * x; }});
  ask("a cube", {[](double x) { return x * x * x; }});
  ask("the size of it", {[](double x) { return std::abs(x); }});
  std::vector<std::function<double(double)>> tanhs, ramps, exponentials, steps;
  for (int m = 0; m <= 10; ++m) {
    const double middle = low + 0.1 * m * range;
    for (const double w : {0.05, 0.1, 0.2, 0.4}) {
      tanhs.emplace_back([=](double x) { return std::tanh((x - middle) / (w * range)); });
      ramps.emplace_back([=](double x) {
        const double a = (x - middle) / (0.25 * w * range);
        return a > 30.0 ? a : std::log1p(std::exp(a));
      });
    }
    steps.emplace_back([=](double x) { return x > middle ? 1.0 : 0.0; });
  }
  for (const double rate : {-8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0})
    exponentials.emplace_back([=](double x) { return std::exp(rate * (x - low) / range); });
  ask("an exponential", exponentials);
  ask("a ramp from a threshold on", ramps);
  ask("a tanh (saturation)", tanhs);
  ask("a step", steps);
  std::stable_sort(forms.begin(), forms.end(), [](const auto& a, const auto& b) { return a.error < b.error; });
  return forms;
}

}  // namespace sinew::diagnose
