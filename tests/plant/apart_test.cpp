// SPDX-License-Identifier: Apache-2.0
#include "plant/apart.h"

#include <doctest/doctest.h>

#include <cmath>

#include "plant/integrator.h"
#include "plant/laws.h"
#include "plant/limb/limb.h"

namespace plant_apart_test {

using namespace sinew::plant;

namespace {

void set(Plant& plant, const char* key, double value) { plant.set(plant.system().parameter(key), value); }
double get(const Plant& plant, const char* key) { return plant.get(plant.system().parameter(key)); }

std::size_t sharing(const System& system, std::string_view words) {
  for (std::size_t s = 0; s < system.sharings().size(); ++s)
    if (system.sharings()[s].words == words) return s;
  throw std::out_of_range(std::string(words));
}
EffectId apart(const System& system, std::string_view words) {
  for (const EffectId e : system.effects().ids())
    if (system.effects()[e].sharing == sharing(system, words)) return e;
  throw std::out_of_range(std::string(words));
}

// Both coils are driven in turn; every half second all states, or what the sensors show.
std::vector<double> run(const Plant& plant) {
  Integrator integrator(plant, Start{}, {Method::cvode, 1e-9});
  std::vector<double> readings;
  for (int k = 0; k < 80; ++k) {
    integrator.hold(k < 16 ? std::vector{0.6, 0.0} : k < 40 ? std::vector{0.0, 0.6} : std::vector{0.0, 0.0});
    REQUIRE_FALSE(integrator.advance_to(0.5 * (k + 1)));
    for (const double reading : integrator.readings()) readings.push_back(reading);
  }
  return readings;
}

Plant apart_in(std::string_view words, const Plant& base = Plant(two_coil_limb())) {
  Plant plant = carried_into(base, with_parts_apart(base.shared_system()));
  const EffectId e = apart(plant.system(), words);
  plant.turn(e, true);
  plant.set(plant.system().effects()[e].strength, 1.0);
  return plant;
}
ParameterId weight(const Plant& plant, std::string_view words, std::size_t which) {
  return plant.system().effects()[apart(plant.system(), words)].parameters[1 + which];
}

}  // namespace

TEST_CASE("apart: a coil's own value acts in that coil alone") {
  // Each coil as it is where all have its value.
  const auto coil = [](double heating_A, double heating_B) {
    Plant plant(two_coil_limb()->with_own({sharing(*two_coil_limb(), "the transformation temperatures")}));
    set(plant, "heating_midpoint_A_degC", heating_A);
    set(plant, "heating_midpoint_B_degC", heating_B);
    const auto equations = plant.equations();
    // 72 degrees and 0.5 in both: between the branches of the nominal loop.
    const std::vector<double> y{72.0, 72.0, 0.5, 0.5, 0.0, 0.0};
    std::vector<double> rates(y.size());
    Situation given;
    given.inputs = {0.0, 0.0};
    equations->rates(given, y.data(), rates.data());
    return std::pair(rates[2], rates[3]);
  };
  const auto both_low = coil(60.0, 60.0), both_high = coil(80.0, 80.0), mixed = coil(60.0, 80.0);
  CHECK(both_low.first == both_low.second);
  CHECK(both_high.first == both_high.second);
  CHECK(both_low.first != both_high.first);
  CHECK(mixed.first == both_low.first);
  CHECK(mixed.second == both_high.second);
}

TEST_CASE("apart: own values that are the shared ones are nothing, for every sharing, to the bit") {
  const auto system = with_parts_apart(two_coil_limb());
  Plant base(two_coil_limb());
  for (const EffectId e : base.system().effects().ids()) {
    // One of those that are on at their typical strength would do; a heat network is the one with most parts.
    if (base.system().effects()[e].name != "junction") continue;
    base.turn(e, true);
    set(base, "junction.heat_capacity_J_K", 0.3);
  }
  const std::vector<double> plain = run(base);
  CHECK(run(carried_into(base, system)) == plain);
  for (const char* words :
       {"the transformation temperatures", "the widths of the transformation", "the stretch that the transformation makes", "junction"}) {
    CAPTURE(words);
    CHECK(run(apart_in(words, base)) == plain);
  }
}

TEST_CASE("apart: weights move a part by what is declared, and a file describes the same plant") {
  Plant base(two_coil_limb());
  base.turn(base.system().effect("junction"), true);
  set(base, "junction.heat_capacity_J_K", 0.3);
  Plant plant = apart_in("junction", base);
  plant.set(weight(plant, "junction", 0), 1.0);   // of A's heat capacity
  plant.set(weight(plant, "junction", 3), -2.0);  // of B's conductance
  const EffectId temperatures = apart(plant.system(), "the transformation temperatures");
  plant.turn(temperatures, true);
  plant.set(weight(plant, "the transformation temperatures", 1), 0.5);  // of B

  const Plant file = as_in_file(plant);
  // Half of the prior's deviation: of 0.4 around 0.4, of 0.8 around 0.08, of 10 around 75 and 60.
  const auto step = [](double share) { return 0.5 * std::sqrt(std::log1p(share * share)); };
  CHECK(get(file, "junction.A.heat_capacity_J_K") == doctest::Approx(0.3 * std::exp(step(1.0))).epsilon(1e-12));
  CHECK(get(file, "junction.B.heat_capacity_J_K") == 0.3);
  CHECK(get(file, "junction.B.conductance_W_K") == doctest::Approx(0.08 * std::exp(-2.0 * step(10.0))).epsilon(1e-12));
  CHECK(get(file, "heating_midpoint_A_degC") == 75.0);
  // A temperature in degC has no natural zero: both by the same kelvins.
  CHECK(get(file, "heating_midpoint_B_degC") == doctest::Approx(77.5).epsilon(1e-12));
  CHECK(get(file, "cooling_midpoint_B_degC") == doctest::Approx(62.5).epsilon(1e-12));
  CHECK(run(file) == run(plant));
  CHECK(run(file) != run(base));
  CHECK_FALSE(file.system().find_parameter("heating_width_A_K"));  // alike
}

TEST_CASE("apart: what is known of a shared value is known of each part's, and a value that nothing has is not fitted") {
  Plant base(two_coil_limb());
  base.set_own_deviation(base.system().parameter("cooling_midpoint_degC"), 2.0);
  const Plant file = as_in_file(apart_in("the transformation temperatures", base));
  const auto deviation = [&](const char* key) { return file.deviation(file.system().parameter(key)); };
  CHECK(deviation("cooling_midpoint_A_degC") == 2.0);
  CHECK(deviation("heating_midpoint_A_degC") == 10.0);
  CHECK(deviation("cooling_midpoint_degC") == 0.0);
  CHECK(deviation("heating_midpoint_degC") == 0.0);
}

TEST_CASE("apart: of each coil cooling is below heating, whichever of the two it has of its own") {
  const auto above = [](std::vector<OwnValues> own, const char* key) {
    const LimbSystem system(two_coil_shape(), own);
    return system.parameters()[system.parameter(key)].declaration.less_than;
  };
  using Keys = std::vector<std::string>;
  const OwnValues heating_A{"", "", "", "heating_midpoint_A_degC"}, heating_B{"", "", "", "heating_midpoint_B_degC"},
      cooling_A{"", "", "", "cooling_midpoint_A_degC"};
  CHECK(above({}, "cooling_midpoint_degC") == Keys{"heating_midpoint_degC"});
  CHECK(above({cooling_A}, "cooling_midpoint_A_degC") == Keys{"heating_midpoint_degC"});
  CHECK(above({heating_A}, "cooling_midpoint_degC") == Keys{"heating_midpoint_A_degC", "heating_midpoint_degC"});
  CHECK(above({heating_A, cooling_A}, "cooling_midpoint_A_degC") == Keys{"heating_midpoint_A_degC"});
  CHECK(above({heating_A, cooling_A}, "cooling_midpoint_degC") == Keys{"heating_midpoint_degC"});
  CHECK(above({heating_A, heating_B}, "cooling_midpoint_degC") == Keys{"heating_midpoint_A_degC", "heating_midpoint_B_degC"});
}

TEST_CASE("apart: derivatives of own values are those of their definition") {
  Plant plant = apart_in("the transformation temperatures");
  plant.set(weight(plant, "the transformation temperatures", 0), 0.7);
  const EffectId e = apart(plant.system(), "the transformation temperatures");
  for (const ApartValue& one : values_apart(plant, e)) {
    const auto value_with = [&](ParameterId p, double change) {
      Plant moved = plant;
      moved.set(p, moved.get(p) + change);
      for (const ApartValue& other : values_apart(moved, e))
        if (other.shared == one.shared && other.part == one.part) return other.value;
      return std::nan("");
    };
    const auto slope = [&](ParameterId p) { return (value_with(p, 1e-4) - value_with(p, -1e-4)) / 2e-4; };
    CHECK(one.by_shared == doctest::Approx(slope(one.shared)).epsilon(1e-7));
    CHECK(one.by_weight == doctest::Approx(slope(one.weight)).epsilon(1e-7));
  }
}

TEST_CASE("apart: what a file says is known is not each part's own") {
  Plant plant(two_coil_limb());
  const Sharing& temperatures = plant.system().sharings()[sharing(plant.system(), "the transformation temperatures")];
  CHECK(may_differ(plant, temperatures));
  plant.set_own_deviation(plant.system().parameter("cooling_midpoint_degC"), 2.0);
  CHECK(may_differ(plant, temperatures));
  plant.set_own_deviation(plant.system().parameter("cooling_midpoint_degC"), 0.0);
  CHECK_FALSE(may_differ(plant, temperatures));
  CHECK(may_differ(plant, plant.system().sharings()[sharing(plant.system(), "the widths of the transformation")]));
}

TEST_CASE("apart: beside laws, before them and after") {
  const auto with_law = [](const Plant& plant, double fading_memory_s = 0.0) {
    const System& system = plant.system();
    Law law{.entry = EntryGroupId{1}, .argument = {}, .factor = {}, .knots = {20.0, 100.0}, .curve = Eigen::Vector2d(0.0, 0.1)};
    law.fading_memory_s = fading_memory_s;
    for (const VariableId v : system.variables().ids())
      if (system.variables()[v].name.starts_with("temperature ")) law.argument.push_back(v);
    return with_laws_on(plant, {law});
  };
  Plant before = with_law(apart_in("the transformation temperatures"));
  before.set(weight(before, "the transformation temperatures", 0), 1.0);
  Plant after = apart_in("the transformation temperatures", with_law(Plant(two_coil_limb())));
  after.set(weight(after, "the transformation temperatures", 0), 1.0);
  const std::vector<double> shown = run(before);
  CHECK(run(after) == shown);
  CHECK(run(as_in_file(before)) == shown);
  CHECK(run(as_in_file(after)) == shown);
  CHECK(run(as_in_file(before)) != run(with_law(Plant(two_coil_limb()))));
  // One first value a state, those of a law's memory among them.
  const Plant remembers = apart_in("the transformation temperatures", with_law(Plant(two_coil_limb()), 10.0));
  const std::vector<double> first(remembers.system().channels().size(), 25.0);
  CHECK(remembers.states().size() == Plant(two_coil_limb()).states().size() + 2);
  CHECK(remembers.system().start_beliefs(remembers, first).size() == remembers.states().size());
}

}  // namespace plant_apart_test
