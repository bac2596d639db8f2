#include "diagnose/open_loop.h"

#include <doctest/doctest.h>

#include <cmath>

#include "diagnose/score.h"
#include "tests/diagnose/one_limb.h"

using namespace sinew;
using diagnose::Explanation;
using diagnose::Fitted;
using diagnose::Lead;

namespace {

// A recording of a limb whose thermocouples lag, and the core fitted to it.
struct Lagging {
  sim::Recording recording;
  std::vector<diagnose::FitData> data;
  diagnose::ExplanationSettings settings;
  Explanation core;

  Lagging() {
    sim::Scenario scenario = testing::babbling(60.0);
    scenario.limb = diagnose::with_effect({}, plant::effect_index("thermocouple_lag"));
    plant::set(scenario.limb, plant::parameter_index("thermocouple_lag.time_constant_s"), 2.5);
    recording = testing::recorded(scenario);
    data = {{&recording, recording.samples.size(), testing::paper_noise}};
    settings.start = diagnose::StartPolicy::at_rest;
    core = diagnose::explain({}, data, {}, settings);
  }
};

diagnose::PathSearch search_that(bool holds) {
  return {{}, 1, 24.0, 2, [holds](const Fitted&, const Fitted&) { return holds; }};
}

}  // namespace

TEST_CASE("open loop: the polished path is no further from the recording than the explanation's own") {
  const Lagging limb;
  REQUIRE(limb.core.usable);
  const Fitted polished = diagnose::polished(limb.core, limb.data, limb.settings);
  const auto& numerics = limb.settings.numerics;
  CHECK(diagnose::spread_of(polished, limb.data, numerics).log_sum <=
        diagnose::spread_of(diagnose::fitted(limb.core), limb.data, numerics).log_sum);
  // What is missing is far more than noise, whatever the core's parameters.
  CHECK(diagnose::spread_of(polished, limb.data, numerics).rmse[0][0] > 5.0 * testing::paper_noise[0]);
}

TEST_CASE("open loop: following whole paths finds what is missing, unless it does not hold on other data") {
  const Lagging limb;
  const Fitted core = diagnose::polished(limb.core, limb.data, limb.settings);
  const Lead lead = diagnose::follow_paths(core, limb.data, search_that(true), limb.settings);
  REQUIRE(lead.effects.size() == 1);
  CHECK(plant::effects()[lead.effects[0]].name == "thermocouple_lag");
  CHECK(lead.gains[0] > 24.0);
  CHECK(plant::get_in_file_units(lead.path.limb, plant::parameter_index("thermocouple_lag.time_constant_s")) ==
        doctest::Approx(2.5).epsilon(0.05));
  CHECK(diagnose::follow_paths(core, limb.data, search_that(false), limb.settings).effects.empty());
}

TEST_CASE("joint score: of two columns it is what least squares on both explains, and forbids what physics does") {
  diagnose::Score one, other;
  one.effect = plant::effect_index("latent_heat");      // never negative
  other.effect = plant::effect_index("ambient_drift");  // of either sign
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
