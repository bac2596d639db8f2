// SPDX-License-Identifier: Apache-2.0
#include "diagnose/proposals.h"

#include <doctest/doctest.h>

#include <cmath>

#include "plant/laws.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"
#include "tests/plant/small_system_test.h"

namespace diagnose_proposals_test {

using namespace sinew;
using diagnose::Fitted;
using diagnose::Proposals;

namespace {

std::vector<std::string> names_of(const Proposals& proposals, std::size_t which) {
  std::vector<std::string> names;
  for (const plant::EffectId e : proposals.all[which].effects) names.emplace_back(proposals.system->effects()[e].name);
  return names;
}

// Two of the catalogue and two of its rivals, so that a test is short.
diagnose::ProposalSettings among(const std::vector<std::string>& names) {
  diagnose::ProposalSettings settings;
  settings.most_effects = 2;
  settings.starts = 2;
  settings.most_laws = 0;
  for (const plant::EffectId e : testing::limb_system().effects().ids())
    if (std::find(names.begin(), names.end(), testing::limb_system().effects()[e].name) == names.end()) settings.without.push_back(e);
  return settings;
}

sim::Scenario with_junctions() {
  sim::Scenario scenario = testing::babbling(60.0);
  scenario.plant = diagnose::with_effect(plant::default_plant(), testing::effect("junction"));
  scenario.plant.set(testing::parameter("junction.heat_capacity_J_K"), 0.4);
  return scenario;
}

}  // namespace

TEST_CASE("proposals: what needs another effect can be added only where that is on") {
  const plant::Plant core = plant::default_plant();
  const auto has = [](const std::vector<plant::EffectId>& all, const char* name) {
    return std::find(all.begin(), all.end(), testing::effect(name)) != all.end();
  };
  CHECK(has(diagnose::addable(core, {}), "junction"));
  CHECK_FALSE(has(diagnose::addable(core, {}), "junction_layer"));
  CHECK_FALSE(has(diagnose::addable(core, {testing::effect("junction")}), "junction"));
  const plant::Plant with = diagnose::with_effect(core, testing::effect("junction"));
  CHECK(has(diagnose::addable(with, {}), "junction_layer"));
  CHECK_FALSE(has(diagnose::addable(with, {}), "junction"));
  // And what is asked for brings what it needs.
  CHECK(diagnose::with_effect(core, testing::effect("junction_layer")).is_on(testing::effect("junction")));
}

TEST_CASE("proposals: a junction is found among its look-alikes, and nothing is added once it is there" * long_when_sanitized) {
  const testing::FittedCore limb(with_junctions());
  const Fitted core = diagnose::polished(limb.core, limb.data, limb.settings);
  const auto settings = among({"junction", "thermocouple_lag", "sheath_heat_storage"});
  const Proposals found = diagnose::propose(core, limb.data, settings, limb.settings);
  REQUIRE_FALSE(found.all.empty());
  CHECK(names_of(found, found.answer) == std::vector<std::string>{"junction"});
  double with_junction = 0.0;
  for (std::size_t p = 0; p < found.all.size(); ++p)
    if (const std::vector<std::string> names = names_of(found, p); std::find(names.begin(), names.end(), "junction") != names.end())
      with_junction += found.all[p].probability;
  CHECK(with_junction > 0.99);

  const plant::Plant repaired = found.fit.model();
  CHECK(repaired.get(testing::parameter("junction.heat_capacity_J_K")) == doctest::Approx(0.4).epsilon(0.05));
  double sum = 0.0;
  for (const diagnose::Proposal& one : found.all) sum += one.probability;
  CHECK(sum == doctest::Approx(1.0));
  for (std::size_t i = 1; i < found.all.size(); ++i) CHECK(found.all[i].log_odds <= found.all[i - 1].log_odds);

  const Fitted with = diagnose::fitted(found.fit);
  const Proposals again = diagnose::propose(with, limb.data, settings, limb.settings);
  CHECK(again.all[again.answer].effects.empty());  // beside what is on
}

TEST_CASE("proposals: the same whatever the number of threads" * long_when_sanitized) {
  const testing::FittedCore limb(with_junctions());
  const Fitted core = diagnose::polished(limb.core, limb.data, limb.settings);
  auto settings = among({"junction", "cubic_stiffening"});
  settings.most_effects = 1;
  settings.threads = 1;
  const Proposals one = diagnose::propose(core, limb.data, settings, limb.settings);
  settings.threads = 3;
  const Proposals three = diagnose::propose(core, limb.data, settings, limb.settings);
  REQUIRE(one.all.size() == three.all.size());
  for (std::size_t i = 0; i < one.all.size(); ++i) {
    CHECK(names_of(one, i) == names_of(three, i));
    CHECK(one.all[i].log_odds == three.all[i].log_odds);
  }
}

TEST_CASE("proposals: coils that transform at temperatures of their own are told from an effect, and the values of each" *
          long_when_sanitized) {
  plant::Plant plant(plant::two_coil_limb()->with_own({0}));  // the transformation temperatures
  REQUIRE(plant.system().find_parameter("heating_midpoint_A_degC"));
  const auto set = [&](const char* key, double value) { plant.set(plant.system().parameter(key), value); };
  set("heating_midpoint_A_degC", 68.0), set("cooling_midpoint_A_degC", 53.0);
  set("heating_midpoint_B_degC", 82.0), set("cooling_midpoint_B_degC", 67.0);
  const testing::FittedCore limb(testing::babbling(60.0, plant));
  const Fitted core = diagnose::polished(limb.core, limb.data, limb.settings);
  const Proposals found = diagnose::propose(core, limb.data, among({"stress_shift", "cross_heating"}), limb.settings);
  REQUIRE_FALSE(found.all.empty());
  CHECK(names_of(found, found.answer) == std::vector<std::string>{"the transformation temperatures of each coil"});
  const plant::Plant described = plant::as_in_file(found.fit.model());
  for (const char* key : {"heating_midpoint_A_degC", "cooling_midpoint_A_degC", "heating_midpoint_B_degC", "cooling_midpoint_B_degC"})
    CHECK(described.get(described.system().parameter(key)) == doctest::Approx(plant.get(plant.system().parameter(key))).epsilon(0.02));
}

TEST_CASE("proposals: what predicts better is added, though an axis that drifts away leaves hardly an independent error" *
          long_when_sanitized) {
  // Of the benchmark every tenth sample. Without dry friction and an offset the axis is 80 mm off, all along.
  const plant::Plant axis = test::small::plant_from("emps/rigid_axis.yaml");
  std::optional<sim::Recording> recording = test::small::benchmark(axis.system(), "emps/DATA_EMPS.mat");
  if (!recording) return;
  std::vector<sim::Sample> few;
  for (std::size_t k = 0; k < recording->samples.size(); k += 10) few.push_back(recording->samples[k]);
  recording->samples = few;
  const std::vector<diagnose::FitData> data{{&*recording, few.size(), diagnose::noise_of(axis.system(), *recording)}};
  diagnose::ExplanationSettings fit;
  fit.start = diagnose::StartPolicy::at_rest;
  diagnose::ProposalSettings settings;
  settings.most_laws = 0;
  const Fitted core = diagnose::polished(diagnose::explain(axis, data, {}, fit), data, fit);
  const Proposals found = diagnose::propose(core, data, settings, fit);
  REQUIRE_FALSE(found.all.empty());
  // The offset, or a spring that is never slack: this few samples hardly tell. Beside either friction pays.
  const std::vector<std::string> names = names_of(found, found.answer);
  REQUIRE(names.size() == 2);
  CHECK(names.front() == "dry_friction");
  CHECK((names.back() == "force_offset" || names.back() == "centring_spring"));
  for (std::size_t p = 0; p < found.all.size(); ++p)
    if (names_of(found, p).empty()) CHECK(found.all[p].probability < 0.01);
}

}  // namespace diagnose_proposals_test
