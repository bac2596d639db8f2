// SPDX-License-Identifier: Apache-2.0
// Diagnoses of limbs that a plant file of format 2 describes.
#include <doctest/doctest.h>

#include <cmath>

#include "diagnose/calibrate.h"
#include "diagnose/diagnosis.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"
#include "tests/plant/limb/general.h"

namespace diagnose_any_limb_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

// The two-coil limb without thermocouples.
const std::string bend_alone =
    "format: 2\n"
    "limb:\n"
    "  segments: [{name: limb}]\n"
    "  coils:\n"
    "    - {name: A, direction_deg: 0}\n"
    "    - {name: B, direction_deg: 180}\n"
    "  channels:\n"
    "    - {column: angle_deg, bend: limb}\n";

sim::Scenario measured(double duration_s, const plant::Plant& plant) {
  sim::Scenario scenario = testing::babbling(duration_s, plant);
  scenario.sensors = sim::usual_sensors(plant.system());
  return scenario;
}

}  // namespace

TEST_CASE("any limb: two coils written out are fitted as the limb of format 1, to the last bit") {
  const plant::Plant one = plant::default_plant(), other = test::plant_of(test::two_coils);
  REQUIRE(&one.system() != &other.system());
  plant::Plant lagging = with_effect(one, testing::effect("thermocouple_lag"));
  lagging.set(testing::parameter("thermocouple_lag.time_constant_s"), 0.6);
  sim::Recording recording = testing::recorded(measured(40.0, lagging));
  recording.samples.erase(recording.samples.begin(), recording.samples.begin() + 100);
  const std::vector<FitData> data = testing::data_of(recording);

  const FitProblem first(one, fittable_parameters(one), data, StartPolicy::estimated, {plant::Method::automatic, 1e-5});
  const FitProblem second(other, fittable_parameters(other), data, StartPolicy::estimated, {plant::Method::automatic, 1e-5});
  REQUIRE(first.unknowns().size() == second.unknowns().size());
  for (std::size_t u = 0; u < first.unknowns().size(); ++u) CHECK(first.unknowns()[u].name == second.unknowns()[u].name);
  std::vector<double> z(first.unknowns().size());
  for (std::size_t u = 0; u < z.size(); ++u) z[u] = 0.1 * static_cast<double>(u % 3) - 0.05;
  const auto of = [&](const FitProblem& problem) {
    std::vector<double> residuals(problem.residual_count()), jacobian(residuals.size() * z.size());
    REQUIRE(problem.evaluate(z.data(), residuals.data(), jacobian.data()));
    return std::pair(residuals, jacobian);
  };
  CHECK(of(first) == of(second));

  const Explanation explained = explain(one, data, {}, {}), again = explain(other, data, {}, {});
  REQUIRE(explained.usable);
  CHECK(explained.z == again.z);
  CHECK(explained.residual == again.residual);
  CHECK(explained.forcing == again.forcing);
  CHECK(explained.log_evidence == again.log_evidence);
  CHECK(explained.process_noise == again.process_noise);
  const std::vector<plant::EffectId> candidates{testing::effect("thermocouple_lag"), testing::effect("hard_stop"),
                                                testing::effect("input_delay")};
  const Scores scores = score(explained, candidates, 1), scores_again = score(again, candidates, 1);
  REQUIRE(scores.all.size() == scores_again.all.size());
  for (std::size_t i = 0; i < scores.all.size(); ++i) CHECK(scores.all[i].statistic == scores_again.all[i].statistic);
}

TEST_CASE("any limb: with a bend sensor alone it is calibrated") {
  const plant::Plant nominal = test::plant_of(bend_alone);
  const plant::System& system = nominal.system();
  REQUIRE(system.channels().size() == 1);
  const std::vector<plant::ParameterId> changed{system.parameter("heat_loss_A_W_K"), system.parameter("beam_stiffness_Nm_rad")};
  plant::Plant truth = nominal;
  truth.set(changed[0], 0.043);
  truth.set(changed[1], 0.054);
  const sim::Recording recording = testing::recorded(measured(120.0, truth));
  CalibrationSettings settings;
  settings.parameters = changed;
  settings.starts = 2;
  const Calibration result = calibrate(nominal, {{&recording, recording.samples.size(), noise_of(system, recording)}}, settings);
  CHECK(result.several_starts_agree);
  CHECK(result.flipped_signs.empty());
  for (std::size_t p = 0; p < changed.size(); ++p) {
    const Estimate& e = result.estimates[p];
    INFO(e.unknown.name << " = " << e.value << " +- " << e.standard_error);
    CHECK(e.told());
    CHECK(std::abs(e.value - truth.get(changed[p])) < 4.0 * e.standard_error);
    CHECK(e.standard_error < 0.1 * e.unknown.deviation);
  }
}

TEST_CASE("any limb: with a bend sensor alone it is diagnosed, and what was left out is found with its size" * long_when_sanitized) {
  const plant::Plant nominal = test::plant_of(bend_alone);
  const plant::System& system = nominal.system();
  const plant::EffectId missing = system.effect("viscoelastic_creep");
  const plant::ParameterId strength = system.effects()[missing].strength;
  plant::Plant truth = with_effect(nominal, missing);
  truth.set(strength, 0.01);
  const std::vector<sim::Recording> training{testing::recorded(measured(180.0, truth))};
  DiagnosisSettings settings;
  settings.start = StartPolicy::at_rest;
  const Diagnosis diagnosis = diagnose::diagnose(nominal, training, {}, settings);
  CHECK(verdict_of(diagnosis.answer) == Verdict::missing_physics);
  const std::vector<FoundEffect>& effects = effects_in(diagnosis.answer);
  REQUIRE(effects.size() == 1);
  CHECK(effects[0].effect == missing);
  CHECK(effects[0].confidence > 0.8);
  REQUIRE_FALSE(effects[0].parameters.empty());
  CHECK(effects[0].parameters[0].lowest < 0.01);
  CHECK(effects[0].parameters[0].highest > 0.01);
  CHECK(diagnosis.repaired.get(strength) == doctest::Approx(0.01).epsilon(0.1));
  CHECK(diagnosis.located.place == "mechanics");
  const plant::ChannelId angle{0};
  CHECK(diagnosis.located.channel == angle);
  CHECK(diagnosis.held_out.before[angle] > 1.0);
  CHECK(diagnosis.held_out.after[angle] < 1.2 * diagnosis.held_out.noise[angle]);
}

TEST_CASE("any limb: a name that is hardly believed is none, and what it does stands in for something else" * long_when_sanitized) {
  const plant::Plant nominal = test::plant_of(bend_alone);
  const plant::EffectId missing = nominal.system().effect("viscoelastic_creep");
  plant::Plant truth = with_effect(nominal, missing);
  truth.set(nominal.system().effects()[missing].strength, 0.01);
  DiagnosisSettings settings;
  settings.start = StartPolicy::at_rest;
  for (const plant::EffectId e : nominal.system().effects().ids())
    if (e != missing) settings.search.without.push_back(e);
  settings.thresholds.least_share = 1.0;  // more than any name has
  const Diagnosis diagnosis = diagnose::diagnose(nominal, {testing::recorded(measured(120.0, truth))}, {}, settings);
  CHECK(verdict_of(diagnosis.answer) == Verdict::unexplained);
  CHECK(effects_in(diagnosis.answer).empty());
  CHECK(ambiguous_in(diagnosis.answer).empty());
  CHECK(diagnosis.repaired.is_on(missing));
}

TEST_CASE("any limb: with a bend sensor alone, a limb that lacks nothing is consistent") {
  const plant::Plant nominal = test::plant_of(bend_alone);
  DiagnosisSettings settings;
  settings.start = StartPolicy::at_rest;
  CHECK(std::holds_alternative<NothingMissing>(
      diagnose::diagnose(nominal, {testing::recorded(measured(120.0, nominal))}, {}, settings).answer));
}

}  // namespace diagnose_any_limb_test
