// SPDX-License-Identifier: Apache-2.0
#include "diagnose/search.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/calibrate.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_search_test {

using namespace sinew;
using namespace sinew::diagnose;

namespace {

sim::Recording recorded_with(const std::string& key, double value, double duration_s = 120.0) {
  sim::Scenario scenario = testing::babbling(duration_s);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());  // the paper's
  if (!key.empty()) {
    scenario.plant = with_effect(scenario.plant, testing::effect(key.substr(0, key.find('.'))));
    scenario.plant.set(testing::parameter(key), value);
  }
  scenario.plant.set(testing::parameter("heat_loss_A_W_K"), 0.043);
  scenario.plant.set(testing::parameter("beam_stiffness_Nm_rad"), 0.047);
  return testing::recorded(scenario);
}

std::vector<FitData> data_of(const sim::Recording& recording) { return testing::data_of(recording, testing::noise_of(recording)); }

}  // namespace

TEST_CASE("score: a thermocouple's gain cannot be seen, since calibration imitates it; a lag can") {
  const sim::Recording recording = recorded_with("", 0.0);
  const Explanation core = explain(plant::default_plant(), data_of(recording), {}, {});
  REQUIRE(core.usable);
  const Scores scores = score(core, {testing::effect("thermocouple_heat_sink"), testing::effect("thermocouple_lag")}, 1);
  REQUIRE(scores.all.size() == 2);
  CHECK(scores.all[0].visible_share < 1e-3);
  CHECK(scores.all[1].visible_share > 0.1);
  CHECK(scores.all[1].smallest_seen < 0.1);  // a tenth of a second would be seen
}

TEST_CASE("score: at a small strength the score test says what was put in") {
  const sim::Recording recording = recorded_with("duty_deadband.threshold_fraction", 0.002);
  const Explanation core = explain(plant::default_plant(), data_of(recording), {}, {});
  const Scores scores = score(core, {testing::effect("duty_deadband"), testing::effect("cubic_stiffening")}, 2);
  const Score& found = scores.all[scores.best.front()];
  CHECK(testing::limb_system().effects()[found.effect].name == "duty_deadband");
  // Five standard deviations are `smallest_seen`, so two of them are 0.4 of it.
  CHECK(std::abs(found.strength - 0.002) < 0.4 * found.smallest_seen + 0.0005);
}

TEST_CASE("score: a gain of nothing is certain to come by chance, a large one hardly ever" * long_when_sanitized) {
  const sim::Recording recording = recorded_with("", 0.0);
  const Explanation core = explain(plant::default_plant(), data_of(recording), {}, {});
  std::vector<plant::EffectId> all;
  for (const plant::EffectId e : testing::limb_system().effects().ids()) all.push_back(e);
  const Scores scores = score(core, all, 2);
  CHECK(family_wise_probability(scores, 0.0, 1) == 1.0);
  CHECK(family_wise_probability(scores, 40.0, 1) < 1e-6);
  // More columns reach further than one: chi-squared with one degree reaches 6.6 in 1 % of cases.
  CHECK(family_wise_probability(scores, 6.6, 1) > 0.02);
  for (const Score& one : scores.all) {
    if (one.effect == testing::effect("latent_heat")) CHECK_FALSE(one.two_sided);  // never negative
    if (one.effect == testing::effect("ambient_drift")) CHECK(one.two_sided);
  }
  // Threads and repetition change nothing.
  const Scores again = score(core, all, 1);
  for (std::size_t i = 0; i < scores.all.size(); ++i) CHECK(scores.all[i].statistic == again.all[i].statistic);
}

TEST_CASE("score: where the derivative at the null says nothing, a difference at half the typical strength speaks") {
  const sim::Recording recording = recorded_with("driver_lag.time_constant_s", 0.15);
  const Explanation core = explain(plant::default_plant(), data_of(recording), {}, {});
  const Scores scores =
      score(core, {testing::effect("driver_lag"), testing::effect("angle_sensor_second_order"), testing::effect("duty_deadband")}, 2);
  for (const Score& one : scores.all) {
    CHECK(one.is_difference == (one.effect != testing::effect("duty_deadband")));
    CHECK(one.column.size() > 0);
  }
  const Score& found = scores.all[scores.best.front()];
  CHECK(found.effect == testing::effect("driver_lag"));
  CHECK(found.statistic > 100.0);
  CHECK(std::abs(found.strength - 0.15) < 0.05);  // half the typical strength is 0.15 s
}

TEST_CASE("search: a driver's lag is found as a form of the delay of the inputs" * long_when_sanitized) {
  const sim::Recording lagging = recorded_with("driver_lag.time_constant_s", 0.5);
  const Search found = search(plant::default_plant(), data_of(lagging), {});
  REQUIRE(found.best.effects() == std::vector<plant::EffectId>{testing::effect("driver_lag")});
  CHECK(plant::family_of(testing::limb_system().effects(), testing::effect("driver_lag")) == testing::effect("input_delay"));
  SearchSettings without;
  without.without = {testing::effect("input_delay")};
  const Search unnamed = search(plant::default_plant(), data_of(lagging), without);
  for (const plant::EffectId e : unnamed.best.effects()) CHECK(e != testing::effect("driver_lag"));
}

TEST_CASE("start: guesses on the branches of the hysteresis where the loop is open, near each other where both coils are cold") {
  const sim::Recording whole = testing::recorded(testing::babbling(60.0));
  const auto guesses_from = [&](std::size_t first) {
    sim::Recording part{.name = "part"};
    part.samples.assign(whole.samples.begin() + static_cast<std::ptrdiff_t>(first),
                        whole.samples.begin() + static_cast<std::ptrdiff_t>(first) + 100);
    return diagnose::with_other_starts(diagnose::explain(plant::default_plant(), testing::data_of(part), {}, {}));
  };
  const auto cold = guesses_from(0);
  diagnose::ExplanationSettings at_rest;
  at_rest.start = diagnose::StartPolicy::at_rest;
  CHECK(diagnose::with_other_starts(diagnose::explain(plant::default_plant(), {{&whole, 100, testing::paper_noise}}, {}, at_rest)).empty());
  std::size_t warm = 0;
  for (std::size_t k = 0; k < 400; ++k)
    if (whole.samples[k].channels[0] > whole.samples[warm].channels[0]) warm = k;
  const auto guesses = guesses_from(warm + 20);
  REQUIRE(guesses.size() == 4);
  const auto fraction_A = [&](std::size_t g) { return guesses[g].values.at("start.martensite_A_fraction"); };
  REQUIRE(cold.size() == 4);
  const auto cold_fraction_A = [&](std::size_t g) { return cold[g].values.at("start.martensite_A_fraction"); };
  CHECK(cold_fraction_A(0) > cold_fraction_A(1) + 0.003);
  CHECK(cold_fraction_A(0) < cold_fraction_A(1) + 0.02);
  CHECK(fraction_A(0) > fraction_A(1) + 0.02);
  CHECK(fraction_A(0) == fraction_A(2));
  CHECK(fraction_A(1) == fraction_A(3));
  CHECK(guesses[0].values.at("start.martensite_B_fraction") >= guesses[2].values.at("start.martensite_B_fraction"));
}

TEST_CASE("search: names what was left out and its size, and finds nothing where nothing is" * long_when_sanitized) {
  SearchSettings settings;
  settings.threads = 2;
  const sim::Recording nothing = recorded_with("", 0.0);
  const Search clean = search(plant::default_plant(), data_of(nothing), settings);
  CHECK(clean.best.effects().empty());
  CHECK(clean.best.process_noise < 40.0);

  const sim::Recording lagging = recorded_with("thermocouple_lag.time_constant_s", 0.8);
  const Search found = search(plant::default_plant(), data_of(lagging), settings);
  REQUIRE(found.best.effects() == std::vector<plant::EffectId>{testing::effect("thermocouple_lag")});
  for (std::size_t u = 0; u < found.best.problem->unknowns().size(); ++u)
    if (found.best.problem->unknowns()[u].name == "thermocouple_lag.time_constant_s")
      CHECK(std::abs(found.best.value(u) - 0.8) < 3.0 * found.best.deviation(u));
  CHECK(found.best.process_noise < 40.0);
}

TEST_CASE("search: what is taken out of the catalogue is not found, and what is left does not look like noise" * long_when_sanitized) {
  SearchSettings settings;
  settings.threads = 2;
  settings.without = {testing::effect("thermocouple_lag"), testing::effect("junction")};  // a junction without current lags, too
  const sim::Recording lagging = recorded_with("thermocouple_lag.time_constant_s", 0.8);
  const Search without = search(plant::default_plant(), data_of(lagging), settings);
  CHECK(without.best.process_noise > 1000.0);
}

// The temperatures of both coils are 7 K off, each to its own side.
sim::Recording recorded_unlike() {
  const plant::System& limb = testing::limb_system();
  std::size_t temperatures = 0;
  while (limb.sharings()[temperatures].words != "the transformation temperatures") ++temperatures;
  plant::Plant plant(limb.with_own({temperatures}));
  for (const auto& [key, by_K] : {std::pair("heating_midpoint_A_degC", -7.0),
                                  {"cooling_midpoint_A_degC", -7.0},
                                  {"heating_midpoint_B_degC", 7.0},
                                  {"cooling_midpoint_B_degC", 7.0}}) {
    const plant::ParameterId p = plant.system().parameter(key);
    plant.set(p, plant.get(p) + by_K);
  }
  sim::Scenario scenario = testing::babbling(120.0, plant);
  scenario.sensors = sim::usual_sensors(plant.system());
  return testing::recorded(scenario);
}

// Few effects, so that it is quick.
SearchSettings few_effects() {
  SearchSettings settings;
  settings.threads = 2;
  for (const plant::EffectId e : testing::limb_system().effects().ids())
    if (e != testing::effect("cubic_stiffening") && e != testing::effect("coil_slack")) settings.without.push_back(e);
  return settings;
}

std::vector<std::string> apart_in(const Explanation& explanation) {
  std::vector<std::string> words;
  for (const plant::EffectId e : explanation.effects())
    if (const auto sharing = explanation.system().effects()[e].sharing) words.emplace_back(explanation.system().sharings()[*sharing].words);
  return words;
}

TEST_CASE("search: coils that are not alike are found to be so, beside no name, and not where a file knows their value" *
          long_when_sanitized) {
  const sim::Recording unlike = recorded_unlike();
  const Search found = search(plant::default_plant(), data_of(unlike), few_effects());
  CHECK(apart_in(found.best) == std::vector<std::string>{"the transformation temperatures"});
  CHECK(found.best.effects().size() == 1);
  CHECK(found.apart_log_odds > 100.0);
  CHECK(found.best.process_noise < 40.0);

  plant::Plant known = plant::default_plant();
  known.set_own_deviation(testing::parameter("heating_midpoint_degC"), 0.0);
  CHECK(apart_in(search(known, data_of(unlike), few_effects()).best) != std::vector<std::string>{"the transformation temperatures"});

  CHECK(apart_in(search(plant::default_plant(), data_of(recorded_with("", 0.0)), few_effects()).best).empty());
}

TEST_CASE("search: what else could be there is asked beside the answer, also where a later round added what the answer leaves out") {
  const testing::FittedCore core(testing::babbling(20.0));
  const auto beside_core = [&](std::string_view effect) {
    Explanation with = core.core;
    with.problem = std::make_shared<FitProblem>(with_effect(core.core.problem->centres(), testing::effect(effect)),
                                                core.core.problem->parameters(), core.data, core.settings.start, core.settings.numerics);
    return with;
  };
  const Explanation with = beside_core("latent_heat");
  Search search;
  search.rounds.resize(2);
  search.rounds[0].before = core.core;
  search.rounds[1].before = with;
  CHECK(&round_from(search, core.core) == &search.rounds[0]);
  CHECK(&round_from(search, with) == &search.rounds[1]);
  // Where no round began with the answer: the last that began with a part of it.
  const Explanation other = beside_core("dry_friction");
  CHECK(&round_from(search, other) == &search.rounds[0]);
}

TEST_CASE("search: a junction that alone looks poor is found together with the layer round it" * long_when_sanitized) {
  sim::Scenario scenario = testing::babbling(60.0);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());
  scenario.plant = with_effect(with_effect(scenario.plant, testing::effect("junction")), testing::effect("junction_layer"));
  const std::vector<std::pair<std::string, double>> values{
      {"junction.heat_capacity_J_K", 0.23},    {"junction.conductance_W_K", 0.08},        {"junction.relative_power", 0.95},
      {"junction.cooling_rate_1_s", 0.02},     {"junction_layer.conductance_W_K", 0.047}, {"junction_layer.heat_capacity_J_K", 0.44},
      {"junction_layer.heat_loss_W_K", 0.0023}};
  for (const auto& [key, value] : values) scenario.plant.set_in_file_units(testing::parameter(key), value);
  const sim::Recording recording = testing::recorded(scenario);
  SearchSettings settings;
  settings.threads = 2;
  settings.most_laws = 0;
  for (const plant::EffectId e : testing::limb_system().effects().ids())
    if (const std::string_view name = testing::limb_system().effects()[e].name;
        name != "junction" && name != "junction_layer" && name != "sheath_heat_storage")
      settings.without.push_back(e);
  const Search found = search(plant::default_plant(), data_of(recording), settings);
  // By evidence alone a sheath round the whole wire would come first.
  const auto& candidates = found.rounds.front().candidates;
  const auto evidence_of = [&](std::string_view name) {
    const auto of =
        std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return c.effect == testing::effect(name); });
    REQUIRE(of != candidates.end());
    return of->explanation.log_evidence;
  };
  CHECK(evidence_of("sheath_heat_storage") > evidence_of("junction"));
  CHECK(found.best.effects() == std::vector<plant::EffectId>{testing::effect("junction"), testing::effect("junction_layer")});
  CHECK(found.best.process_noise < 20.0);
}

}  // namespace diagnose_search_test
