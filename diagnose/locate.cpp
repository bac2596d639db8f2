// SPDX-License-Identifier: Apache-2.0
#include "diagnose/locate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/random.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

constexpr double bootstrap_block_s = 20.0;
constexpr int bootstrap_draws = 400;
constexpr std::size_t on_the_beam = 2;

FreeForcings air_and(Forcing forcing) {
  FreeForcings free = air_free;
  free[static_cast<std::size_t>(forcing)] = true;
  return free;
}

// "while coil A cools from 72 to 55 °C": the coil that is further from ambient in these windows, and what it does
// there.
std::string describe(const sim::Recording& recording, const std::vector<std::pair<double, double>>& windows) {
  std::array<std::vector<double>, 2> temperature;
  std::array<double, 2> duty{};
  std::size_t count = 0;
  for (const sim::Sample& sample : recording.samples) {
    const bool inside = std::any_of(windows.begin(), windows.end(), [&](const auto& w) {
      return sample.time_s >= w.first && sample.time_s <= w.second;
    });
    if (!inside) continue;
    ++count;
    for (const std::size_t j : plant::coils) {
      if (!std::isnan(sample.temperature_degC[j])) temperature[j].push_back(sample.temperature_degC[j]);
      duty[j] += sample.duty_fraction[j];
    }
  }
  if (count == 0) return "";
  std::array<double, 2> low{}, high{};
  for (const std::size_t j : plant::coils) {
    if (temperature[j].empty()) continue;
    std::sort(temperature[j].begin(), temperature[j].end());
    low[j] = temperature[j][temperature[j].size() / 10];
    high[j] = temperature[j][temperature[j].size() * 9 / 10];
  }
  const std::size_t j = high[0] >= high[1] ? 0 : 1;
  const bool heats = duty[j] / static_cast<double>(count) > 0.1;
  return std::string("while coil ") + (j == 0 ? "A" : "B") + (heats ? " is heated, at " : " cools, between ") +
         std::to_string(static_cast<int>(std::lround(heats ? low[j] : high[j]))) + (heats ? " to " : " and ") +
         std::to_string(static_cast<int>(std::lround(heats ? high[j] : low[j]))) + " °C";
}

struct Variable {
  std::string name, unit;
  Eigen::VectorXd value;  // at each block
};

// Variables of the limb at the blocks' first samples, for a forcing that acts on `coil` (or on the beam).
std::vector<Variable> variables_of(const Explanation& at, std::size_t coil, bool on_a_wire) {
  const auto& blocks = at.blocks->blocks();
  const auto count = static_cast<Eigen::Index>(blocks.size());
  const std::string mine = coil == 0 ? " A" : " B", other = coil == 0 ? " B" : " A";
  std::vector<Variable> all;
  if (on_a_wire) {
    all = {{"temperature" + mine, "°C", {}},
           {"temperature" + other, "°C", {}},
           {"rate of temperature" + mine, "K/s", {}},
           {"martensite fraction" + mine, "", {}},
           {"duty" + mine, "", {}},
           {"angle", "°", {}},
           {"angular velocity", "°/s", {}},
           {"speed of bending", "°/s", {}},
           {"time", "s", {}}};
  } else {
    all = {{"angle", "°", {}},
           {"angular velocity", "°/s", {}},
           {"speed of bending", "°/s", {}},
           {"temperature A", "°C", {}},
           {"temperature B", "°C", {}},
           {"martensite fraction A", "", {}},
           {"martensite fraction B", "", {}},
           {"time", "s", {}}};
  }
  for (Variable& variable : all) variable.value = Eigen::VectorXd::Zero(count);
  std::size_t b = 0;
  for (std::size_t r = 0; r < at.problem->data().size(); ++r) {
    const FitData& data = at.problem->data()[r];
    plant::Integrator integrator(at.limb(), at.start(r), at.problem->numerics());
    const auto& samples = data.recording->samples;
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(samples[k].time_s - samples.front().time_s)) return {};
      integrator.hold(samples[k].duty_fraction);
      if (b >= blocks.size() || blocks[b].recording != r || blocks[b].first_sample != k) continue;
      const plant::Instant<double> now = integrator.instant();
      constexpr double degree = plant::radians_per_degree;
      const double angle = now.angle_rad / degree, speed = now.angular_velocity_rad_s / degree,
                   time = samples[k].time_s;
      const auto j = static_cast<Eigen::Index>(b++);
      const std::size_t o = 1 - coil;
      std::vector<double> values;
      if (on_a_wire)
        values = {now.temperature_degC[coil],
                  now.temperature_degC[o],
                  now.temperature_rate_K_s[coil],
                  now.martensite_fraction[coil],
                  now.duty_fraction[coil],
                  angle,
                  speed,
                  std::abs(speed),
                  time};
      else
        values = {angle,
                  speed,
                  std::abs(speed),
                  now.temperature_degC[0],
                  now.temperature_degC[1],
                  now.martensite_fraction[0],
                  now.martensite_fraction[1],
                  time};
      for (std::size_t v = 0; v < values.size(); ++v) all[v].value(j) = values[v];
    }
  }
  return all;
}

struct Binned {
  double explained = -1.0;
  std::vector<double> centre, mean, deviation;
};

// Eight bins of equal count; what their means account for in the half of the time they were not made from.
Binned binned(const Eigen::VectorXd& variable, const Eigen::VectorXd& forcing,
              const std::vector<Blocks::Block>& blocks) {
  constexpr std::size_t bins = 8;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(variable.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return variable(a) < variable(b); });
  Binned result;
  std::vector<std::size_t> bin_of(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) bin_of[static_cast<std::size_t>(order[i])] = i * bins / order.size();
  const auto half = [&](Eigen::Index i) {
    return static_cast<std::size_t>(blocks[static_cast<std::size_t>(i)].time_s / (2.0 * bootstrap_block_s)) % 2;
  };
  std::array<std::array<double, bins>, 2> sum{}, count{};
  std::array<double, bins> centre{}, square{};
  for (Eigen::Index i = 0; i < variable.size(); ++i) {
    const std::size_t bin = bin_of[static_cast<std::size_t>(i)];
    sum[half(i)][bin] += forcing(i);
    count[half(i)][bin] += 1.0;
    centre[bin] += variable(i);
    square[bin] += forcing(i) * forcing(i);
  }
  const double mean = forcing.mean();
  double left = 0.0, whole = 0.0;
  for (Eigen::Index i = 0; i < variable.size(); ++i) {
    const std::size_t bin = bin_of[static_cast<std::size_t>(i)], other = 1 - half(i);
    const double predicted = count[other][bin] > 0.0 ? sum[other][bin] / count[other][bin] : mean;
    left += (forcing(i) - predicted) * (forcing(i) - predicted);
    whole += (forcing(i) - mean) * (forcing(i) - mean);
  }
  result.explained = whole > 0.0 ? 1.0 - left / whole : 0.0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double n = count[0][bin] + count[1][bin];
    if (n == 0.0) continue;
    const double m = (sum[0][bin] + sum[1][bin]) / n;
    result.centre.push_back(centre[bin] / n);
    result.mean.push_back(m);
    result.deviation.push_back(std::sqrt(std::max(0.0, square[bin] / n - m * m)));
  }
  return result;
}

}  // namespace

std::vector<std::string> places_of(Forcing forcing) {
  using plant::Place;
  const auto text = [](Place place) { return std::string(plant::text_of(place)); };
  switch (forcing) {
    case Forcing::air:
      return {};
    case Forcing::heat:
      return {text(Place::thermal), text(Place::actuation)};
    case Forcing::transformation:
      return {text(Place::transformation)};
    case Forcing::moment:
      return {text(Place::mechanics)};
    case Forcing::temperature_reading:
      return {text(Place::sensor_temperature)};
    case Forcing::angle_reading:
      return {text(Place::sensor_angle)};
  }
  return {};
}

Dependence depends_on(const Explanation& at, const Eigen::VectorXd& series, std::size_t coil) {
  Dependence result;
  for (const Variable& variable : variables_of(at, coil == on_the_beam ? 0 : coil, coil != on_the_beam)) {
    const Binned found = binned(variable.value, series, at.blocks->blocks());
    if (found.explained <= result.explained_share) continue;
    result = {variable.name, variable.unit, found.explained, found.centre, found.mean, found.deviation};
  }
  return result;
}

LeftOver left_over(const Explanation& at, Forcing forcing, double most_air_K) {
  LeftOver result;
  result.forcing = forcing;
  ForcingSize size{};
  static_cast<void>(likelihood_with(at, air_and(forcing), most_air_K, &size));
  Path path;
  if (!follow(*at.problem, at.z.data(), Want::points, path)) return result;
  StateNoise noise(*at.problem, *at.blocks, at.z.data(), path);
  noise.set(size);
  if (size[static_cast<std::size_t>(forcing)] == 0.0) return result;
  const Smoothed smoothed = noise.smooth(at.residual);
  // The residual is model - measured, so what the limb has and the model has not is the forcing's opposite.
  for (std::size_t e = 0; e < forcing_entries; ++e) {
    if (forcing_entry[e].forcing != forcing) continue;
    const bool on_a_wire = forcings[static_cast<std::size_t>(forcing)].entries == 2;
    const Dependence found = depends_on(at, -smoothed.forcing[e], on_a_wire ? forcing_entry[e].coil : on_the_beam);
    if (found.explained_share <= result.explained_share) continue;
    static_cast<Dependence&>(result) = found;
    result.coil = forcing_entry[e].coil;
  }
  return result;
}

Located locate(const Explanation& core, const std::vector<sim::Recording>& recordings, double most_air_K,
               std::uint64_t seed) {
  Located result;
  const auto& rows = core.blocks->rows();
  const auto& blocks = core.blocks->blocks();
  std::vector<PerChannel> squares(recordings.size(), PerChannel{}), counts(recordings.size(), PerChannel{});
  PerChannel all_squares{}, all_counts{};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double r = core.residual(static_cast<Eigen::Index>(i));
    squares[rows[i].recording][rows[i].channel] += r * r * rows[i].count;
    counts[rows[i].recording][rows[i].channel] += rows[i].count;
  }
  double worst = -1.0;
  for (std::size_t c = 0; c < channel_count; ++c) {
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      const double deviation = core.problem->data()[r].deviation[c];
      all_squares[c] += squares[r][c] * deviation * deviation;
      all_counts[c] += counts[r][c];
      result.noise[c] += deviation / static_cast<double>(recordings.size());
      if (counts[r][c] > 0.0 && squares[r][c] / counts[r][c] > worst) {
        worst = squares[r][c] / counts[r][c];
        result.channel = c;
        result.worst_recording = r;
      }
    }
    result.rmse[c] = all_counts[c] > 0.0 ? std::sqrt(all_squares[c] / all_counts[c]) : std::nan("");
  }
  const FitData& data = core.problem->data()[result.worst_recording];
  const Comparison comparison =
      compare(core.limb(), core.start(result.worst_recording), recordings[result.worst_recording], data.deviation,
              1e300, core.problem->numerics());
  result.worst = comparison.worst[result.channel];
  result.while_words = describe(recordings[result.worst_recording], result.worst.windows_s);

  Path path;
  if (!follow(*core.problem, core.z.data(), Want::points, path)) return result;
  StateNoise noise(*core.problem, *core.blocks, core.z.data(), path);
  noise.set(core.forcing);
  const Smoothed smoothed = noise.smooth(core.residual);
  // Squares of each forcing's response by stretch of time, for the bootstrap.
  std::vector<std::array<double, forcing_count>> stretches;
  double stretch_end_s = -1e300;
  std::size_t recording = static_cast<std::size_t>(-1);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (blocks[b].recording != recording || blocks[b].time_s > stretch_end_s) {
      stretches.push_back({});
      recording = blocks[b].recording;
      stretch_end_s = blocks[b].time_s + bootstrap_block_s;
    }
    for (std::size_t c = 0; c < channel_count; ++c)
      if (blocks[b].row[c] != Blocks::no_row)
        for (std::size_t q = 1; q < forcing_count; ++q) {
          const double y = smoothed.response(static_cast<Eigen::Index>(blocks[b].row[c]), static_cast<Eigen::Index>(q));
          stretches.back()[q] += y * y;
        }
  }
  const auto shares_of = [&](auto&& index_of) {
    std::array<double, forcing_count> sum{};
    double total = 0.0;
    for (std::size_t s = 0; s < stretches.size(); ++s) {
      const std::size_t picked = index_of(s);
      for (std::size_t q = 1; q < forcing_count; ++q) {
        sum[q] += stretches[picked][q];
        total += stretches[picked][q];
      }
    }
    for (double& value : sum) value = total > 0.0 ? value / total : 0.0;
    return sum;
  };
  const auto share = shares_of([](std::size_t s) { return s; });
  const sim::RandomStream chance(seed, "diagnose.locate");
  std::array<std::vector<double>, forcing_count> drawn;
  std::uint64_t index = 0;
  for (int d = 0; d < bootstrap_draws; ++d) {
    const auto again = shares_of([&](std::size_t) {
      return std::min(stretches.size() - 1,
                      static_cast<std::size_t>(chance.uniform(index++) * static_cast<double>(stretches.size())));
    });
    for (std::size_t q = 1; q < forcing_count; ++q) drawn[q].push_back(again[q]);
  }
  for (std::size_t q = 1; q < forcing_count; ++q) {
    std::sort(drawn[q].begin(), drawn[q].end());
    result.shares.push_back({static_cast<Forcing>(q), share[q], drawn[q][bootstrap_draws / 40],
                             drawn[q][bootstrap_draws - 1 - bootstrap_draws / 40],
                             likelihood_with(core, air_and(static_cast<Forcing>(q)), most_air_K)});
  }
  std::stable_sort(result.shares.begin(), result.shares.end(),
                   [](const PlaceShare& a, const PlaceShare& b) { return a.log_likelihood > b.log_likelihood; });
  for (const PlaceShare& place : result.shares)
    if (place.forcing != result.shares.front().forcing &&
        place.log_likelihood > result.shares.front().log_likelihood - 3.0)
      for (const std::string& text : places_of(place.forcing)) result.cannot_be_told_from.push_back(text);
  return result;
}

}  // namespace sinew::diagnose
