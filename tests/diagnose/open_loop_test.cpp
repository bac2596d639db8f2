// SPDX-License-Identifier: Apache-2.0
#include "diagnose/open_loop.h"

#include <doctest/doctest.h>

#include "diagnose/score.h"
#include "tests/diagnose/one_limb.h"

namespace diagnose_open_loop_test {

using namespace sinew;
using diagnose::Fitted;

namespace {

sim::Scenario lagging_thermocouples() {
  sim::Scenario scenario = testing::babbling(60.0);
  scenario.plant = diagnose::with_effect(plant::default_plant(), testing::effect("thermocouple_lag"));
  scenario.plant.set(testing::parameter("thermocouple_lag.time_constant_s"), 2.5);
  return scenario;
}

}  // namespace

TEST_CASE("open loop: the polished path is no further from the recording than the explanation's own") {
  const testing::FittedCore limb(lagging_thermocouples());
  REQUIRE(limb.core.usable);
  const Fitted polished = diagnose::polished(limb.core, limb.data, limb.settings);
  const auto& numerics = limb.settings.numerics;
  CHECK(diagnose::spread_of(polished, limb.data, numerics).log_sum <=
        diagnose::spread_of(diagnose::fitted(limb.core), limb.data, numerics).log_sum);
  // What is missing is far more than noise, whatever the core's parameters.
  CHECK(diagnose::spread_of(polished, limb.data, numerics).rmse[0][testing::temperature_A] >
        5.0 * testing::paper_noise[testing::temperature_A]);
}

TEST_CASE("joint score: of two columns it is what least squares on both explains, and forbids what physics does") {
  diagnose::Score one, other;
  one.effect = testing::effect("latent_heat");  // never negative
  other.effect = testing::effect("ambient_drift");
  other.two_sided = true;  // of either sign
  const double cosine = 0.6;
  one.column = other.column = Eigen::VectorXd::Zero(16);
  one.column(0) = 1.0;
  other.column(0) = cosine;
  other.column(1) = 0.8;
  Eigen::VectorXd data = 3.0 * one.column - 2.0 * other.column;
  data(2) = 7.0;
  one.root = one.column.dot(data);
  other.root = other.column.dot(data);
  const diagnose::JointScore both = diagnose::joint(one, other);
  CHECK(both.root == doctest::Approx(3.0));
  CHECK(both.other_root == doctest::Approx(-2.0));
  CHECK(both.statistic == doctest::Approx(data.squaredNorm() - 49.0));  // all but what is orthogonal to both
  one.root = -one.root;
  other.root = -other.root;
  CHECK(diagnose::joint(one, other).statistic == 0.0);
}

}  // namespace diagnose_open_loop_test
