// SPDX-License-Identifier: Apache-2.0
#include "diagnose/state_noise.h"

#include <doctest/doctest.h>

#include "diagnose/calibrate.h"
#include "sim/random.h"
#include "tests/diagnose/one_limb.h"

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
        problem(plant::default_plant(), fittable_parameters(plant::default_plant()), testing::data_of(recording),
                StartPolicy::estimated, {plant::Method::automatic, 1e-6}),
        blocks(problem), z(problem.unknowns().size(), 0.0) {
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
