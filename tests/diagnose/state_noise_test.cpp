// SPDX-License-Identifier: Apache-2.0
#include "diagnose/state_noise.h"

#include <doctest/doctest.h>

#include <Eigen/Cholesky>

#include "diagnose/calibrate.h"
#include "sim/random.h"
#include "tests/diagnose/one_limb.h"
#include "tests/plant/limb/general.h"

namespace diagnose_state_noise_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

struct Setting {
  sim::Recording recording;
  FitProblem problem;
  Blocks blocks;
  std::vector<double> z;
  Path path;

  explicit Setting(double duration_s)
      : recording(testing::recorded(testing::babbling(duration_s))),
        problem(plant::default_plant(), fittable_parameters(plant::default_plant()), testing::data_of(recording), StartPolicy::estimated,
                {plant::Method::automatic, 1e-6}),
        blocks(problem),
        z(problem.unknowns().size(), 0.0) {
    REQUIRE(follow(problem, z.data(), Want::everything, path));
  }
  StateNoise noise() const { return StateNoise(problem, blocks, z.data(), path); }
  Eigen::VectorXd column(const std::string& name) const {
    const Eigen::MatrixXd all = blocks.means(path.jacobian.data(), problem.unknowns().size());
    for (std::size_t u = 0; u < problem.unknowns().size(); ++u)
      if (problem.unknowns()[u].name == name) return all.col(static_cast<Eigen::Index>(u));
    FAIL("no unknown " << name);
    return {};
  }
};

constexpr plant::EntryGroupId air{0}, heat{1};
ForcingSize forcing(double of_air, double of_heat) {
  ForcingSize size = no_forcing(testing::limb_system());
  size[air] = of_air;
  size[heat] = of_heat;
  return size;
}

}  // namespace

TEST_CASE("state noise: without forcing, whitening weighs a mean of five samples as five samples") {
  const Setting setting(30.0);
  StateNoise noise = setting.noise();
  noise.set(no_forcing(testing::limb_system()));
  Eigen::MatrixXd ones = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(setting.blocks.rows().size()), 1);
  noise.whiten(ones);
  for (std::size_t i = 0; i < setting.blocks.rows().size(); ++i)
    CHECK(ones(static_cast<Eigen::Index>(i), 0) == doctest::Approx(std::sqrt(setting.blocks.rows()[i].count)).epsilon(1e-12));
  CHECK(noise.log_determinant() == doctest::Approx(0.0));
}

TEST_CASE("state noise: groups that have no size may be left out, and nothing changes") {
  const Setting setting(30.0);
  StateNoise all = setting.noise();
  const ForcingSize of_air = only_nuisance(testing::limb_system(), 0.3);
  const StateNoise few_made(setting.problem, setting.blocks, setting.z.data(), setting.path, nullptr, with_a_size(of_air));
  StateNoise few = few_made;
  all.set(of_air);
  few.set(of_air);
  Eigen::MatrixXd one = setting.column("ambient_temperature_degC"), other = one;
  all.whiten(one);
  few.whiten(other);
  CHECK((one - other).norm() < 1e-9 * one.norm());
  CHECK(few.log_determinant() == doctest::Approx(all.log_determinant()).epsilon(1e-9));
}

TEST_CASE("state noise: moving air hides a change of ambient but for what its own mean does not wander") {
  const Setting setting(120.0);
  StateNoise noise = setting.noise();
  noise.set(only_nuisance(testing::limb_system(), 0.3));
  Eigen::MatrixXd ambient = setting.column("ambient_temperature_degC");
  noise.whiten(ambient);
  // By hand: the mean of an Ornstein-Uhlenbeck process of 0.3 K and 30 s, weighted best over T = 120 s, has the variance
  // 0.09 / (1 + T / 60 s) = 0.03 K^2; the column is that of 3 K (the prior's deviation): 3 / sqrt(0.03) = 17.3.
  // A few per cent: the air steps every half second, and the sensors' own noise takes some away.
  CHECK(ambient.norm() == doctest::Approx(17.3).epsilon(0.04));
}

TEST_CASE("state noise: the size of a forcing is found from what it does, and the smoother gives it back") {
  const Setting setting(120.0);
  // A slow wave of heat into wire A, through the linear equations along the path, and the sensors' noise.
  StateNoise noise = setting.noise();
  noise.set(forcing(0.0, 0.5));
  const Eigen::Index rows = static_cast<Eigen::Index>(setting.blocks.rows().size());
  const sim::RandomStream chance(5, "test.state_noise");
  Eigen::VectorXd residual(rows);
  for (Eigen::Index i = 0; i < rows; ++i)
    residual(i) = chance.normal(static_cast<std::uint64_t>(i)) / std::sqrt(setting.blocks.rows()[static_cast<std::size_t>(i)].count);
  const Eigen::VectorXd sensors_alone = residual;
  residual += 2.0 * setting.column("heat_loss_A_W_K") * 0.05;
  REQUIRE(testing::limb_system().entry_groups()[heat].name == "heat");
  const FreeForcings air_and_heat = nuisance_and(testing::limb_system(), heat);
  const ForcingSize found = noise.maximise(residual, forcing(0.05, 0.05), air_and_heat, 1.3);
  CHECK(found[heat] > 0.01);
  const Smoothed smoothed = noise.smooth(residual);
  // What the forcings are said to do accounts for what is there beyond noise.
  const Eigen::VectorXd left = residual - smoothed.response.rowwise().sum();
  CHECK(left.squaredNorm() < 1.3 * sensors_alone.squaredNorm());
  CHECK(residual.squaredNorm() > 3.0 * sensors_alone.squaredNorm());
  // Noise alone needs no forcing.
  const ForcingSize none = noise.maximise(sensors_alone, forcing(0.05, 0.05), air_and_heat, 1.3);
  CHECK(none[heat] < 0.02);
}

namespace {

// Two segments, four coils, a thermocouple on each and a bend sensor on both: 12 states and 17 entries.
const std::string large_limb =
    "format: 2\n"
    "limb:\n"
    "  segments: [{name: base}, {name: tip}]\n"
    "  coils:\n"
    "    - {name: A, segment: base, direction_deg: 0}\n"
    "    - {name: B, segment: base, direction_deg: 180}\n"
    "    - {name: C, segment: tip, direction_deg: 0}\n"
    "    - {name: D, segment: tip, direction_deg: 180}\n"
    "  channels:\n"
    "    - {column: temperature_A_degC, thermocouple: A}\n"
    "    - {column: temperature_B_degC, thermocouple: B}\n"
    "    - {column: temperature_C_degC, thermocouple: C}\n"
    "    - {column: temperature_D_degC, thermocouple: D}\n"
    "    - {column: angle_base_deg, bend: base}\n"
    "    - {column: angle_tip_deg, bend: tip}\n";

// Two short recordings, the second begun in mid-motion, with samples missing; and a strength that varies, made up.
struct Large {
  plant::Plant plant;
  sim::Recording first, second;
  FitProblem problem;
  Blocks blocks;
  std::vector<double> z;
  Path path;
  VaryingPush varying;

  explicit Large(const plant::Plant& of)
      : plant(of),
        first(part_of(of, 0, 63)),
        second(part_of(of, 80, 121)),
        problem(of, {}, {data_of(first), data_of(second)}, StartPolicy::estimated, {plant::Method::automatic, 1e-6}),
        blocks(problem),
        z(problem.unknowns().size(), 0.1) {
    REQUIRE(follow(problem, z.data(), Want::points, path));
    varying.correlation_time_s = 3.0;
    const auto n = static_cast<Eigen::Index>(plant.states().size()), channels = static_cast<Eigen::Index>(plant.system().channels().size());
    const sim::RandomStream chance(11, "test.varying");
    std::uint64_t draw = 0;
    const auto random = [&](Eigen::Index size) {
      return Eigen::VectorXd::NullaryExpr(size, [&] { return 0.1 * chance.normal(draw++); }).eval();
    };
    for (const sim::Recording* recording : {&first, &second}) {
      varying.rates.emplace_back();
      varying.readings.emplace_back();
      for (std::size_t k = 0; k < recording->samples.size(); ++k) {
        varying.rates.back().push_back(random(n));
        varying.readings.back().push_back(random(channels));
      }
    }
  }

  static sim::Recording part_of(const plant::Plant& of, std::size_t from, std::size_t until) {
    sim::Recording part = testing::recorded(testing::babbling(13.0, of));
    part.samples.erase(part.samples.begin() + static_cast<std::ptrdiff_t>(until), part.samples.end());
    part.samples.erase(part.samples.begin(), part.samples.begin() + static_cast<std::ptrdiff_t>(from));
    for (std::size_t k = 20; k < 27; ++k) part.samples[k].channels[1] = std::nan("");
    part.samples[31].channels.back() = std::nan("");
    return part;
  }
  static FitData data_of(const sim::Recording& recording) {
    PerChannel noise;
    for (std::size_t c = 0; c < recording.columns.channels.size(); ++c) noise.push_back(0.05 + 0.01 * static_cast<double>(c));
    return {&recording, recording.samples.size(), noise};
  }
};

// Everything that the filter and the smoother say, from dense matrices: each forcing in each block is set off by a shock of its own.
struct Dense {
  struct Shock {
    std::size_t entry, block;  // the last entry is what varies
    double variance;
  };
  std::vector<Shock> shocks;
  Eigen::MatrixXd response;      // [rows x shocks]: what a shock of 1 does to the means over blocks
  Eigen::MatrixXd sensors, all;  // covariances of the rows

  Dense(const Large& of, const ForcingSize& size, double varying_size) {
    const plant::System& system = of.plant.system();
    const auto& entries = system.entries();
    const auto rows = static_cast<Eigen::Index>(of.blocks.rows().size());
    std::vector<Eigen::VectorXd> columns;
    for (std::size_t e = 0; e <= entries.size(); ++e)
      for (std::size_t b = 0; b < of.blocks.blocks().size(); ++b) {
        const double deviation = e < entries.size() ? size[entries[e].group] : varying_size;
        const bool is_first = b == 0 || of.blocks.blocks()[b - 1].recording != of.blocks.blocks()[b].recording;
        const double kept = is_first ? 0.0 : decay(of, e, of.blocks.blocks()[b - 1].first_sample, of.blocks.blocks()[b].first_sample, b);
        shocks.push_back({e, b, deviation * deviation * (1.0 - kept * kept)});
        columns.push_back(response_to(of, e, b));
      }
    response.resize(rows, static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i) response.col(static_cast<Eigen::Index>(i)) = columns[i];
    Eigen::VectorXd variance(response.cols());
    for (std::size_t i = 0; i < shocks.size(); ++i) variance(static_cast<Eigen::Index>(i)) = shocks[i].variance;
    sensors = Eigen::MatrixXd::Zero(rows, rows);
    for (Eigen::Index i = 0; i < rows; ++i) sensors(i, i) = 1.0 / of.blocks.rows()[static_cast<std::size_t>(i)].count;
    all = sensors + response * variance.asDiagonal() * response.transpose();
  }

  static double time_constant_s(const Large& of, std::size_t entry) {
    const auto& entries = of.plant.system().entries();
    return entry < entries.size() ? of.plant.system().entry_groups()[entries[entry].group].correlation_time_s
                                  : of.varying.correlation_time_s;
  }
  static double decay(const Large& of, std::size_t entry, std::size_t from, std::size_t to, std::size_t block) {
    const auto& samples = of.problem.data()[of.blocks.blocks()[block].recording].recording->samples;
    return std::exp(-(samples[to].time_s - samples[from].time_s) / time_constant_s(of, entry));
  }

  // A forcing that is 1 from a block's first sample and decays, constant between samples.
  static Eigen::VectorXd response_to(const Large& of, std::size_t entry, std::size_t block) {
    const plant::System& system = of.plant.system();
    const std::size_t recording = of.blocks.blocks()[block].recording, first = of.blocks.blocks()[block].first_sample;
    const auto& points = of.path.points[recording];
    const auto n = static_cast<Eigen::Index>(of.plant.states().size());
    const bool varies = entry == system.entries().size();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    Eigen::VectorXd means = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(of.blocks.rows().size()));
    std::vector<std::size_t> block_of(points.size());
    for (std::size_t b = 0; b < of.blocks.blocks().size(); ++b)
      if (of.blocks.blocks()[b].recording == recording)
        for (std::size_t k = of.blocks.blocks()[b].first_sample; k <= of.blocks.blocks()[b].last_sample; ++k) block_of[k] = b;
    for (std::size_t k = first; k < points.size(); ++k) {
      const double forcing = decay(of, entry, first, k, block);
      Eigen::VectorXd shown = points[k].reading * x, push = Eigen::VectorXd::Zero(n);
      if (varies) {
        shown += of.varying.readings[recording][k] * forcing;
        push = of.varying.rates[recording][k];
      } else {
        const plant::Entry& at = system.entries()[entry];
        if (at.channel) shown(static_cast<Eigen::Index>(at.channel->index)) += forcing;
        if (at.parameter) {
          shown += points[k].reading_ambient * forcing;
          if (points[k].ambient.size() > 0) push = points[k].ambient;
        }
        if (at.state) push(static_cast<Eigen::Index>(at.state->index)) = at.divided_by ? 1.0 / of.plant.get(*at.divided_by) : 1.0;
      }
      const Blocks::Block& in = of.blocks.blocks()[block_of[k]];
      for (const plant::ChannelId c : system.channels().ids())
        if (in.row[c] != Blocks::no_row)
          means(static_cast<Eigen::Index>(in.row[c])) +=
              shown(static_cast<Eigen::Index>(c.index)) / system.channels()[c].unit.internal_per_unit /
              of.problem.data()[recording].deviation[c] / static_cast<double>(in.last_sample - in.first_sample + 1);
      if (points[k].transition.size() > 0) x = points[k].transition * x + points[k].integral * push * forcing;
    }
    return means;
  }
};

double largest(const Eigen::MatrixXd& matrix) { return matrix.cwiseAbs().maxCoeff(); }

void check_against_dense(const plant::Plant& plant) {
  const Large of(plant);
  const plant::System& system = plant.system();
  ForcingSize size;
  for (const plant::EntryGroup& group : system.entry_groups()) size.push_back(group.typical);
  const double varying_size = 0.7;
  StateNoise noise(of.problem, of.blocks, of.z.data(), of.path, &of.varying);
  noise.set(size, varying_size);
  const Dense dense(of, size, varying_size);
  const auto rows = static_cast<Eigen::Index>(of.blocks.rows().size());

  Eigen::MatrixXd whitening = Eigen::MatrixXd::Identity(rows, rows);
  noise.whiten(whitening);
  CHECK(largest(whitening * dense.all * whitening.transpose() - Eigen::MatrixXd::Identity(rows, rows)) < 1e-7);
  CHECK(largest(dense.all - dense.sensors) > 1.0);  // the forcings are no small matter
  // log det V, against that of the sensors alone.
  const Eigen::LLT<Eigen::MatrixXd> root(dense.all);
  const double log_determinant =
      2.0 * Eigen::MatrixXd(root.matrixL()).diagonal().array().log().sum() - dense.sensors.diagonal().array().log().sum();
  CHECK(noise.log_determinant() == doctest::Approx(log_determinant).epsilon(1e-9));

  const sim::RandomStream chance(12, "test.residual");
  std::uint64_t draw = 0;
  const Eigen::VectorXd residual = Eigen::VectorXd::NullaryExpr(rows, [&] { return 3.0 * chance.normal(draw++); });
  CHECK(noise.log_likelihood(residual) == doctest::Approx(-0.5 * (residual.dot(root.solve(residual)) + log_determinant)).epsilon(1e-9));

  // The forcings given the residual: of a shock, variance response^T V^-1 residual; a forcing is the sum of its shocks, each decayed.
  const Smoothed smoothed = noise.smooth(residual);
  const std::size_t blocks = of.blocks.blocks().size();
  REQUIRE(smoothed.forcing.size() == system.entries().size());
  const Eigen::VectorXd estimates = dense.response.transpose() * root.solve(residual);  // of the shocks, over their variances
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(rows, smoothed.response.cols());
  for (std::size_t i = 0; i < dense.shocks.size(); ++i) {
    const Dense::Shock& shock = dense.shocks[i];
    const auto column = static_cast<Eigen::Index>(i);
    if (shock.entry < system.entries().size())
      response.col(static_cast<Eigen::Index>(system.entries()[shock.entry].group.index)) +=
          dense.response.col(column) * (shock.variance * estimates(column));
  }
  CHECK(largest(smoothed.response - response) < 1e-6 * largest(response));
  for (std::size_t e = 0; e <= system.entries().size(); ++e) {
    CAPTURE(e);
    double worst = 0.0, worst_deviation = 0.0;
    const double scale = e < system.entries().size() ? size[system.entries()[e].group] : varying_size;
    for (std::size_t b = 0; b < blocks; ++b) {
      Eigen::VectorXd share = Eigen::VectorXd::Zero(dense.response.cols());  // variance of each shock, times its part in this forcing
      for (std::size_t from = 0; from <= b; ++from) {
        if (of.blocks.blocks()[from].recording != of.blocks.blocks()[b].recording) continue;
        const auto i = static_cast<Eigen::Index>(e * blocks + from);
        share(i) = dense.shocks[static_cast<std::size_t>(i)].variance *
                   Dense::decay(of, e, of.blocks.blocks()[from].first_sample, of.blocks.blocks()[b].first_sample, b);
      }
      const Eigen::VectorXd across = dense.response * share;  // covariance with the rows
      const double estimate = across.dot(root.solve(residual));
      const double deviation = std::sqrt(scale * scale - across.dot(root.solve(across)));
      const auto& found = e < system.entries().size() ? smoothed.forcing[e] : smoothed.varying;
      const auto& found_deviation = e < system.entries().size() ? smoothed.deviation[e] : smoothed.varying_deviation;
      worst = std::max(worst, std::abs(found(static_cast<Eigen::Index>(b)) - estimate) / scale);
      worst_deviation = std::max(worst_deviation, std::abs(found_deviation(static_cast<Eigen::Index>(b)) - deviation) / scale);
    }
    CHECK(worst < 1e-6);
    CHECK(worst_deviation < 1e-6);
  }
}

plant::Plant with_effects(plant::Plant plant, const std::vector<const char*>& effects) {
  for (const char* name : effects) {
    plant = with_effect(plant, plant.system().effect(name));
    const plant::ParameterId strength = plant.system().effects()[plant.system().effect(name)].strength;
    plant.set_in_file_units(strength, plant.system().parameters()[strength].declaration.typical);
  }
  return plant;
}

}  // namespace

TEST_CASE("state noise: filter and smoother say what dense matrices do, for plants of every size that is unrolled") {
  const std::pair<std::size_t, std::vector<const char*>> sizes[] = {
      {6, {}},
      {10, {"thermocouple_lag", "angle_sensor_lag", "viscoelastic_creep"}},
      {14, {"thermocouple_lag", "angle_sensor_lag", "viscoelastic_creep", "sheath_heat_storage", "junction"}}};
  for (const auto& [states, effects] : sizes) {
    CAPTURE(states);
    const plant::Plant plant = with_effects(plant::default_plant(), effects);
    REQUIRE(plant.states().size() == states);
    check_against_dense(plant);
  }
}

TEST_CASE("state noise: and for plants that are larger, in forcings, in states or in both") {
  const plant::Plant many_forcings = test::plant_of(large_limb);
  REQUIRE(many_forcings.states().size() == 12);
  REQUIRE(many_forcings.system().entries().size() == 17);
  check_against_dense(many_forcings);
  const plant::Plant many_states =
      with_effects(plant::default_plant(), {"thermocouple_lag", "angle_sensor_lag", "viscoelastic_creep", "sheath_heat_storage", "junction",
                                            "body_heat_storage", "fatigue"});
  REQUIRE(many_states.states().size() > 16);
  check_against_dense(many_states);
  const plant::Plant many_of_both = with_effects(many_forcings, {"thermocouple_lag", "angle_sensor_lag", "viscoelastic_creep"});
  REQUIRE(many_of_both.states().size() == 20);
  check_against_dense(many_of_both);
}

}  // namespace diagnose_state_noise_test
