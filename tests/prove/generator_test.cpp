// SPDX-License-Identifier: Apache-2.0
// The generator of concealed recordings. It shares nothing with the plant; here, and nowhere else, the two are
// compared.
#include "prove/generator.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plant/integrator.h"
#include "plant/limb/limb.h"
#include "plant/systems.h"
#include "prove/generator_random.h"
#include "prove/series_limb.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"
#include "tests/long_when_sanitized.h"

namespace prove_generator_test {

using namespace sinew;
using prove::Concealed;
using prove::Family;
using prove::Kind;
using prove::Settings;

namespace {

Kind kind_named(std::string_view name) {
  const std::vector<Kind> all = prove::kinds();
  const auto found = std::ranges::find(all, name, &Kind::name);
  REQUIRE(found != all.end());
  return *found;
}

Settings still(double training_s, double heldout_s) {
  Settings settings{training_s, heldout_s, 1.0, {}};
  settings.disturbances.moving_air = false;
  return settings;
}

// The System whose plants the generator makes by its own equations.
const plant::System& catalogue() { return *plant::two_coil_limb(); }

plant::Plant plant_of(const Concealed& concealed) {
  plant::Plant plant = plant::default_plant();
  for (const auto& [name, value] : concealed.core_parameters) plant.set_in_file_units(catalogue().parameter(name), value);
  for (const prove::TruthEffect& effect : concealed.effects) {
    plant.turn(catalogue().effect(effect.name), true);
    for (const auto& [name, value] : effect.parameters) plant.set_in_file_units(catalogue().parameter(effect.name + "." + name), value);
  }
  return plant;
}

struct Difference {
  double temperature_K = 0.0, angle_deg = 0.0;
};

Difference between(const std::vector<prove::Sample>& one, const std::vector<prove::Sample>& other) {
  REQUIRE(one.size() == other.size());
  Difference largest;
  for (std::size_t k = 0; k < one.size(); ++k) {
    for (std::size_t j = 0; j < 2; ++j)
      largest.temperature_K = std::max(largest.temperature_K, std::abs(one[k].temperature_degC[j] - other[k].temperature_degC[j]));
    largest.angle_deg = std::max(largest.angle_deg, std::abs(one[k].angle_deg - other[k].angle_deg));
  }
  return largest;
}

// Largest difference between the plant's replay of the training recording's duty and what the generator's limb did.
Difference difference_from(const plant::Plant& plant, const Concealed& concealed) {
  std::vector<sim::Sample> samples;
  for (const prove::Sample& row : concealed.training)
    samples.push_back({.time_s = row.time_s, .inputs = {row.duty.begin(), row.duty.end()}, .channels = {}});
  plant::Integrator run(plant, plant::Start{}, {.method = plant::Method::arkode, .relative_tolerance = 1e-9});
  std::vector<prove::Sample> rows;
  const auto failure = sim::replay(run, catalogue(), samples, [&](std::size_t k) {
    const std::vector<double> shown = run.readings();
    rows.push_back({samples[k].time_s, concealed.training[k].duty, {shown[0], shown[1]}, shown[2] * 180.0 / std::numbers::pi});
  });
  CHECK_FALSE(failure.has_value());
  return between(rows, concealed.training_without_noise);
}
Difference from_plant(const Concealed& concealed) { return difference_from(plant_of(concealed), concealed); }

// As bits, so that a missing sample equals a missing sample.
bool same_bytes(const std::vector<prove::Sample>& one, const std::vector<prove::Sample>& other) {
  return one.size() == other.size() && std::memcmp(one.data(), other.data(), one.size() * sizeof(prove::Sample)) == 0;
}

double channel(const prove::Sample& row, std::size_t c) { return c < 2 ? row.temperature_degC[c] : row.angle_deg; }

bool is_multiple(double value, double step) { return std::abs(std::remainder(value, step)) < 1e-9; }

}  // namespace

TEST_CASE("generator: its limb is the plant's limb, for the core, every effect of the catalogue and every pair" * long_when_sanitized) {
  // 120 s of babbling. Largest seen, with either solver of the plant: 1e-5 K, 1e-5 deg. The exception are minor loops:
  // they begin at the edge of the loop, where the right-hand side jumps; the plant fades them in over a thousandth of
  // the fraction, the generator over a fifth of that. Seen 0.028 deg; tests/golden/README.md has the same tolerance.
  for (const Kind& kind : prove::kinds()) {
    if (kind.family == Family::other_form || kind.family == Family::outside) continue;
    CAPTURE(kind.name);
    const bool minor_loops = kind.name.find("minor_loops") != std::string::npos;
    const Concealed made = prove::make(kind, 3, still(120.0, 60.0));
    const Difference from_the_plant = from_plant(made);
    CHECK(from_the_plant.temperature_K < 5e-5);
    CHECK(from_the_plant.angle_deg < (minor_loops ? 0.04 : 5e-5));
    if (kind.family == Family::clean) continue;
    // An agreement in which the effect had no part would say nothing.
    const Difference from_the_core = between(prove::simulate(made.core_parameters, {}, made.training), made.training_without_noise);
    CHECK(std::max(from_the_core.temperature_K, from_the_core.angle_deg) > 0.2);
  }
}

TEST_CASE("generator: other forms become the catalogue's where they should" * long_when_sanitized) {
  using Parameters = std::map<std::string, double>;
  const auto duty = prove::make(kind_named("core"), 3, still(120.0, 1.0)).training;
  const auto run = [&](std::string name, std::string form, Parameters parameters) {
    return prove::simulate({}, {{std::move(name), std::move(form), "", std::move(parameters), form.empty(), ""}}, duty);
  };
  const auto agree = [&](const std::string& name, const std::string& form, const Parameters& parameters, const Parameters& catalogue,
                         double tolerance) {
    CAPTURE(form);
    const Difference largest = between(run(name, form, parameters), run(name, "", catalogue));
    CHECK(largest.temperature_K < tolerance);
    CHECK(largest.angle_deg < tolerance);
  };
  constexpr double rounding = 1e-7;
  agree("supply_sag", "battery", {{"prompt_resistance_Ohm", 0.3}, {"slow_resistance_Ohm", 0.0}, {"recovery_s", 9.0}},
        {{"source_resistance_Ohm", 0.3}}, rounding);
  agree("latent_heat", "directional", {{"heating_J", 8.0}, {"cooling_J", 8.0}}, {{"latent_heat_J", 8.0}}, rounding);
  agree("dry_friction", "stribeck", {{"moment_Nm", 0.005}, {"smoothing_rad_s", 0.05}, {"peak", 0.0}, {"peak_speed_rad_s", 0.1}},
        {{"moment_Nm", 0.005}, {"smoothing_rad_s", 0.05}}, rounding);
  // Series in the small: x^3/3 of a ratio of 10 N to 1e5 N, x^2/2 of 10 cycles to 1e5, and of 120 s to 1e7 s.
  agree("stress_shift", "saturating", {{"shift_K_N", 3.0}, {"tension_N", 1e5}}, {{"shift_K_N", 3.0}}, 1e-5);
  agree("fatigue", "shakedown", {{"loss", 1e3}, {"cycles", 1e5}}, {{"loss_per_cycle", 0.01}}, 1e-3);
  // s = 0.002 / deg: tanh(x) = x - x^3/3, and x / sqrt(1 + c x^2 / s^2) = x - c x^3 / (2 s^2), so that c = 2 s^2 / 3, in radians.
  agree("angle_sensor_saturation", "tanh", {{"slope_1_deg", 0.002}}, {{"saturation_1_rad2", 0.0087538}}, 1e-3);
  agree("angle_sensor_drift", "settling", {{"shift_deg", 1e5}, {"time_constant_s", 1e7}}, {{"rate_deg_s", 0.01}}, 1e-4);
  // Nodes so well joined that they are one: 60 W/K against the 0.05 W/K that leave it.
  agree("body_heat_storage", "ladder",
        {{"conductance_W_K", 0.012}, {"heat_capacity_J_K", 6.0}, {"heat_loss_W_K", 0.05}, {"inner_conductance_W_K", 60.0}},
        {{"conductance_W_K", 0.012}, {"heat_capacity_J_K", 6.0}, {"heat_loss_W_K", 0.05}}, 0.02);
}

TEST_CASE("generator: effects outside the catalogue follow their law, by hand" * long_when_sanitized) {
  using Parameters = std::map<std::string, double>;
  // The core at a constant duty of 0.1 in coil A until nothing changes: 0.1 * 49 V^2 / 2.5 Ohm / 0.04 W/K = 49 K.
  // 500 s are 23 time constants of a wire.
  std::vector<prove::Sample> steady(5001);
  for (std::size_t k = 0; k < steady.size(); ++k) steady[k] = {0.1 * static_cast<double>(k), {0.1, 0.0}, {}, 0.0};
  const auto run = [&](std::string name, Parameters parameters) {
    return prove::simulate({}, {{std::move(name), "", "", std::move(parameters), false, ""}}, steady);
  };
  static const auto core = prove::simulate({}, {}, steady);
  const auto by_hand = [](double value) { return doctest::Approx(value).epsilon(1e-8); };
  CHECK(core.back().temperature_degC[0] == by_hand(74.0));

  SUBCASE("resistance that rises with temperature: x (1 + a x) = 49 K") {
    // a = 0.005: x = (sqrt(1 + 4 * 0.005 * 49) - 1) / 0.01 = (sqrt(1.98) - 1) / 0.01.
    CHECK(run("hot_resistance", {{"slope_1_K", 0.005}}).back().temperature_degC[0] == by_hand(25.0 + (std::sqrt(1.98) - 1.0) / 0.01));
  }
  SUBCASE("a switch that fades: 0.1 / 0.6 of 30 % are lost, 5 %") {
    CHECK(run("pulse_fade", {{"loss_fraction", 0.3}, {"time_constant_s", 6.0}}).back().temperature_degC[0] == by_hand(25.0 + 0.95 * 49.0));
  }
  SUBCASE("a switch that wakes: at half of 0.2 half of the dead angle is left") {
    CHECK(run("waking_switch", {{"angle_fraction", 0.04}, {"time_constant_s", 3.0}}).back().temperature_degC[0] ==
          by_hand(25.0 + 0.8 * 49.0));
  }
  SUBCASE("a bend that cools the outer wire and warms the inner one") {
    const auto rows = run("bend_cooling", {{"slope_1_rad", 0.5}});
    const double theta = rows.back().angle_deg * std::numbers::pi / 180.0;
    CHECK(theta > 0.1);
    CHECK(rows.back().temperature_degC[0] == by_hand(25.0 + 49.0 / (1.0 + 0.5 * theta)));
  }
  SUBCASE("a limb at rest is not fanned by its motion, one that moves is cooler") {
    const auto rows = run("motion_cooling", {{"slope_s_rad", 4.0}});
    CHECK(rows.back().temperature_degC[0] == by_hand(74.0));
    CHECK(rows[400].temperature_degC[0] < core[400].temperature_degC[0] - 0.01);
  }
  SUBCASE("sensors that are wrong show a function of what is there") {
    const auto bow = run("thermocouple_bow", {{"bow_K", 4.0}});
    // At 74 degC, x = 49/80: 4 * 4 * 0.6125 * 0.3875 = 3.7975 K; at 25 degC nothing.
    CHECK(bow.back().temperature_degC[0] == by_hand(74.0 + 3.7975));
    CHECK(bow.front().temperature_degC[0] == 25.0);
    const auto warm = run("angle_temperature", {{"slope_deg_K", 0.08}});
    // Half of 49 K, wire B being cold.
    CHECK(warm.back().angle_deg == by_hand(core.back().angle_deg + 0.08 * 24.5));
    const auto saturated = prove::simulate({}, {{"angle_sensor_saturation", "tanh", "", {{"slope_1_deg", 0.02}}, false, ""}}, steady);
    CHECK(saturated.back().angle_deg == by_hand(50.0 * std::tanh(core.back().angle_deg / 50.0)));
  }
  SUBCASE("martensite that stays stabilised is the core with a higher heating midpoint") {
    const auto rows = run("martensite_stabilisation", {{"shift_K", 5.0}, {"time_constant_s", 1e12}});
    // At rest the fraction is that of the cooling envelope at 25 degC, 1 / (1 + exp(-5)).
    const auto shifted = prove::simulate({{"heating_midpoint_degC", 75.0 + 5.0 / (1.0 + std::exp(-5.0))}}, {}, steady);
    CHECK(between(rows, shifted).angle_deg < 1e-6);
    CHECK(between(rows, core).angle_deg > 1.0);
  }
  SUBCASE("a loss that grows with speed leaves the resting place and delays the way there") {
    const auto rows = run("speed_loss", {{"moment_Nms2_rad2", 2.0}});
    CHECK(rows.back().angle_deg == doctest::Approx(core.back().angle_deg).epsilon(1e-3));
    CHECK(rows[100].angle_deg < core[100].angle_deg);
  }
  SUBCASE("austenite is as stiff as in the core at 75 degC, and stiffer below") {
    const auto rows = run("austenite_softening", {{"slope_1_K", 0.006}});
    CHECK(rows.back().angle_deg > core.back().angle_deg);
  }
}

TEST_CASE("generator: further forms become the catalogue's where they should" * long_when_sanitized) {
  using Parameters = std::map<std::string, double>;
  const auto duty = prove::make(kind_named("core"), 3, still(120.0, 1.0)).training;
  const auto agree = [&](const std::string& name, const std::string& form, const Parameters& parameters, const Parameters& own,
                         double tolerance) {
    CAPTURE(name + "." + form);
    const auto here = prove::simulate({}, {{name, form, "", parameters, false, ""}}, duty);
    const auto there = prove::simulate({}, {{name, "", "", own, true, ""}}, duty), core = prove::simulate({}, {}, duty);
    const Difference largest = between(here, there), from_core = between(core, there);
    CHECK(largest.temperature_K < tolerance);
    CHECK(largest.angle_deg < tolerance);
    CHECK(std::max(from_core.temperature_K, from_core.angle_deg) > std::max(0.15, 10.0 * tolerance));
  };
  constexpr double rounding = 1e-7;
  agree("thermocouple_lag", "two_poles", {{"outer_time_s", 1.2}, {"inner_time_s", 0.0}}, {{"time_constant_s", 1.2}}, rounding);
  agree("thermocouple_lag", "two_poles", {{"outer_time_s", 0.0}, {"inner_time_s", 1.2}}, {{"time_constant_s", 1.2}}, rounding);
  agree("angle_sensor_lag", "two_poles", {{"film_s", 0.5}, {"filter_s", 0.0}}, {{"time_constant_s", 0.5}}, rounding);
  agree("angle_sensor_lag", "two_poles", {{"film_s", 0.0}, {"filter_s", 0.5}}, {{"time_constant_s", 0.5}}, rounding);
  agree("latent_heat", "broad", {{"latent_heat_J", 8.0}, {"width_factor", 1.0}}, {{"latent_heat_J", 8.0}}, rounding);
  agree("supply_sag", "limit", {{"droop_resistance_Ohm", 0.4}, {"current_A", 0.0}}, {{"source_resistance_Ohm", 0.4}}, rounding);
  agree("stress_shift", "two_slopes", {{"heating_shift_K_N", 2.0}, {"cooling_shift_K_N", 2.0}}, {{"shift_K_N", 2.0}}, rounding);
  agree("stress_shift", "threshold", {{"shift_K_N", 2.0}, {"threshold_N", 0.0}}, {{"shift_K_N", 2.0}}, rounding);
  agree("stress_shift", "torsion", {{"shift_K_N", 2.0}, {"core_share", 1.0}}, {{"shift_K_N", 2.0}}, rounding);
  agree("viscoelastic_creep", "two_times", {{"stiffness_Nm_rad", 0.02}, {"fast_s", 8.0}, {"slow_s", 8.0}},
        {{"stiffness_Nm_rad", 0.02}, {"time_constant_s", 8.0}}, rounding);
  // A cubed ratio of 1 rad to 1e4 deg, over six; squared, of 10 cycles to 1e5.
  agree("viscoelastic_creep", "eyring", {{"stiffness_Nm_rad", 0.02}, {"time_constant_s", 8.0}, {"angle_deg", 1e4}},
        {{"stiffness_Nm_rad", 0.02}, {"time_constant_s", 8.0}}, 1e-4);
  agree("fatigue", "logarithmic", {{"loss", 1e3}, {"cycles", 1e5}}, {{"loss_per_cycle", 0.01}}, 1e-3);
  // A supply that follows within 2 ms, silicone that stores the heat of 0.05 K per watt-second, a knee of a thousandth.
  agree("supply_sag", "slow", {{"source_resistance_Ohm", 0.4}, {"time_constant_s", 0.002}}, {{"source_resistance_Ohm", 0.4}}, 0.03);
  // Silicone between the wires is a body that loses nothing, and one that stores nothing is heat from wire to wire.
  agree("body_heat_storage", "between", {{"conductance_W_K", 0.008}, {"heat_capacity_J_K", 0.8}},
        {{"conductance_W_K", 0.016}, {"heat_capacity_J_K", 0.8}, {"heat_loss_W_K", 0.0}}, rounding);
  const auto stores_nothing =
      prove::simulate({}, {{"body_heat_storage", "between", "", {{"conductance_W_K", 0.008}, {"heat_capacity_J_K", 1e-3}}, false, ""}},
                      duty);
  const Difference from_wire_to_wire =
      between(stores_nothing, prove::simulate({}, {{"cross_heating", "", "", {{"conductance_W_K", 0.008}}, true, ""}}, duty));
  CHECK(from_wire_to_wire.temperature_K < 0.03);
  CHECK(from_wire_to_wire.angle_deg < 0.03);
  agree("duty_deadband", "knee", {{"threshold_fraction", 0.05}, {"knee_share", 1e-3}}, {{"threshold_fraction", 0.05}}, 0.03);
}

TEST_CASE("generator: further effects are exactly nothing at no strength, and something at a plain one" * long_when_sanitized) {
  Settings nothing = still(60.0, 1.0);
  nothing.strength = 0.0;
  std::size_t seen = 0;
  for (const Kind& kind : prove::further_kinds()) {
    if (kind.family == Family::triple || kind.family == Family::pair) continue;
    CAPTURE(kind.name);
    const Concealed none = prove::make(kind, 4, nothing), plain = prove::make(kind, 4, still(60.0, 1.0));
    CHECK(same_bytes(none.training_without_noise, prove::simulate(none.core_parameters, {}, none.training)));
    const Difference shown = between(plain.training_without_noise, prove::simulate(plain.core_parameters, {}, plain.training));
    CHECK(std::max(shown.temperature_K, shown.angle_deg) > 0.5);
    ++seen;
  }
  CHECK(seen == 29);
}

TEST_CASE("generator: coils that are not alike are the plant's with values of their own" * long_when_sanitized) {
  std::vector<std::string> seen;
  for (const Kind& kind : prove::unlike_kinds()) {
    CAPTURE(kind.name);
    Concealed made = prove::make(kind, 3, still(120.0, 60.0));
    const prove::TruthEffect unlike = made.effects.front();
    REQUIRE(unlike.name == "unlike");
    CHECK_FALSE(unlike.in_catalogue);
    // Its plant: half of it less in A, half of it more in B.
    const double apart = unlike.parameters.begin()->second;
    const auto own = [&](double shared, double side) {
      if (unlike.form == "heating_midpoint_degC") return shared + side * apart;
      return unlike.form == "heating_width_K" ? shared * std::exp(side * apart) : shared * (1.0 + side * apart);
    };
    const std::vector<std::string> keys = unlike.form == "heating_midpoint_degC"
                                              ? std::vector<std::string>{"heating_midpoint", "cooling_midpoint"}
                                          : unlike.form == "heating_width_K" ? std::vector<std::string>{"heating_width", "cooling_width"}
                                                                             : std::vector<std::string>{"transformation_stretch"};
    std::vector<plant::OwnValues> own_values;
    for (const std::string& key : keys)
      for (const char* coil : {"A", "B"}) own_values.push_back({"", "", "", key + "_" + coil + unlike.form.substr(unlike.form.rfind('_'))});
    const auto limb = std::make_shared<const plant::LimbSystem>(plant::two_coil_shape(), own_values);
    Concealed others = made;
    others.effects.erase(others.effects.begin());
    const plant::Plant alike = plant_of(others);
    plant::Plant plant(limb);
    for (const plant::ParameterId p : alike.system().parameters().ids())
      plant.set(limb->parameter(alike.system().parameters()[p].key()), alike.get(p));
    for (const plant::EffectId e : alike.system().effects().ids()) plant.turn(e, alike.is_on(e));
    for (std::size_t i = 0; i < own_values.size(); ++i) {
      const std::string shared = keys[i / 2] + unlike.form.substr(unlike.form.rfind('_'));
      plant.set_in_file_units(limb->parameter(own_values[i].key), own(made.core_parameters.at(shared), i % 2 == 0 ? -0.5 : 0.5));
    }
    const Difference same = difference_from(plant, made), without = difference_from(alike, made);
    CHECK(same.temperature_K < 5e-5);
    CHECK(same.angle_deg < 5e-5);
    CHECK(without.angle_deg > 0.3);
    if (made.effects.size() == 1) seen.push_back(unlike.form);
    CHECK(std::ranges::count(prove::kinds(), kind.name, &Kind::name) == 0);
    CHECK(prove::kind_of_name(kind.name).effects == kind.effects);
  }
  CHECK(seen == std::vector<std::string>{"heating_midpoint_degC", "heating_width_K", "transformation_stretch_m"});
  CHECK(prove::unlike_kinds().size() == 6);
}

TEST_CASE("generator: each triple has three effects of the catalogue, of three places") {
  std::size_t triples = 0;
  for (const Kind& kind : prove::kinds()) {
    if (kind.family != Family::triple) continue;
    CAPTURE(kind.name);
    const Concealed made = prove::make(kind, 1, still(0.1, 0.1));
    REQUIRE(made.effects.size() == 3);
    std::set<std::string> places;
    for (const prove::TruthEffect& effect : made.effects) {
      CHECK(effect.in_catalogue);
      places.insert(effect.place);
    }
    CHECK(places.size() == 3);
    ++triples;
  }
  CHECK(triples == 8);
  CHECK(prove::name_of(Family::triple) == "triple");
}

TEST_CASE("generator: further forms and effects follow their law, by hand" * long_when_sanitized) {
  using Parameters = std::map<std::string, double>;
  // As above: 1.96 W in coil A until nothing changes, after 25 time constants of the wire. All goes one way: wire A on its upper
  // envelope, wire B on its lower one at 25 degC, the beam at rest.
  std::vector<prove::Sample> steady(5251);
  for (std::size_t k = 0; k < steady.size(); ++k) steady[k] = {0.1 * static_cast<double>(k), {0.1, 0.0}, {}, 0.0};
  const auto run = [&](std::string name, std::string form, Parameters parameters) {
    return prove::simulate({}, {{std::move(name), std::move(form), "", std::move(parameters), false, ""}}, steady);
  };
  static const auto core = prove::simulate({}, {}, steady);
  const auto by_hand = [](double value) { return doctest::Approx(value).epsilon(1e-7); };
  const auto rise_K = [](const std::vector<prove::Sample>& rows) { return rows.back().temperature_degC[0] - 25.0; };
  const auto theta = [](const std::vector<prove::Sample>& rows) { return rows.back().angle_deg * std::numbers::pi / 180.0; };
  const auto on_heating = [](double temperature_degC, double shift_K) {
    return 1.0 / (1.0 + std::exp((temperature_degC - 75.0 - shift_K) / 7.0));
  };
  const auto on_cooling = [](double temperature_degC, double shift_K) {
    return 1.0 / (1.0 + std::exp((temperature_degC - 60.0 - shift_K) / 7.0));
  };
  const auto tension_N = [](double xi, double shortened_m) { return (313.0 - 200.0 * xi) * (0.030 - shortened_m - xi * 0.028); };
  // Of the core: what its coils add to the beam's stiffness of 0.05 Nm/rad.
  const double coils_Nm_rad = 0.006 * 0.006 * (626.0 - 200.0 * (on_heating(74.0, 0.0) + on_cooling(25.0, 0.0)));
  const double stiffness_Nm_rad = 0.05 + coils_Nm_rad;
  // A moment against the bend, from how much less it bends than the core.
  const auto moment_Nm = [&](const std::vector<prove::Sample>& rows) { return stiffness_Nm_rad * (theta(core) - theta(rows)); };
  REQUIRE(theta(core) > 0.2);

  SUBCASE("heat sink that grows: 49 K / (1 + 0.003 * 49)") {
    const auto rows = run("thermocouple_heat_sink", "convective", {{"slope_1_K", 0.003}});
    CHECK(rise_K(rows) == by_hand(49.0 / 1.147));
    CHECK(rows.back().angle_deg == core.back().angle_deg);
  }
  SUBCASE("two poles are later than each alone, and arrive where they are") {
    const auto both = run("thermocouple_lag", "two_poles", {{"outer_time_s", 1.0}, {"inner_time_s", 0.5}});
    const auto one = run("thermocouple_lag", "two_poles", {{"outer_time_s", 1.0}, {"inner_time_s", 0.0}});
    CHECK(both[50].temperature_degC[0] < one[50].temperature_degC[0] - 0.1);
    CHECK(rise_K(both) == by_hand(49.0));
    const auto angle = run("angle_sensor_lag", "two_poles", {{"film_s", 0.4}, {"filter_s", 0.3}});
    CHECK(angle[400].angle_deg < core[400].angle_deg);
    CHECK(angle.back().angle_deg == by_hand(core.back().angle_deg));
  }
  SUBCASE("heat loss by the root of the rise") {
    const double x = rise_K(run("convection_nonlinearity", "root", {{"slope_1_rtK", 0.05}}));
    CHECK(0.04 * x * (1.0 + 0.05 * std::sqrt(x)) == by_hand(1.96));
  }
  SUBCASE("radiation") {
    const double x = rise_K(run("convection_nonlinearity", "radiation", {{"coefficient_W_K4", 1e-10}}));
    CHECK(0.04 * x + 1e-10 * (std::pow(298.15 + x, 4) - std::pow(298.15, 4)) == by_hand(1.96));
  }
  SUBCASE("silicone between the wires: at rest 0.01 W/K, x_B = 0.2 x_A, 1.96 W = 0.048 W/K x_A") {
    const auto rows = run("body_heat_storage", "between", {{"conductance_W_K", 0.01}, {"heat_capacity_J_K", 0.8}});
    // The silicone makes the wires slower, 31 s: 17 of those.
    const auto at_rest = [](double value) { return doctest::Approx(value).epsilon(2e-5); };
    CHECK(rise_K(rows) == at_rest(1.96 / 0.048));
    CHECK(rows.back().temperature_degC[1] - 25.0 == at_rest(0.2 * 1.96 / 0.048));
    const auto prompt = run("cross_heating", "", {{"conductance_W_K", 0.01}});
    CHECK(rows[100].temperature_degC[1] < prompt[100].temperature_degC[1] - 0.1);
  }
  SUBCASE("broad latent heat: what the wire got is in its temperature and in the fraction by which heat goes") {
    // Nothing leaves; 1.96 W for 20 s.
    std::vector<prove::Sample> pulse(701);
    for (std::size_t k = 0; k < pulse.size(); ++k) pulse[k] = {0.1 * static_cast<double>(k), {k < 200 ? 0.1 : 0.0, 0.0}, {}, 0.0};
    const auto rows = prove::simulate({{"heat_loss_A_W_K", 0.0}, {"heat_capacity_A_J_K", 0.5}},
                                      {{"latent_heat", "broad", "", {{"latent_heat_J", 12.0}, {"width_factor", 1.8}}, false, ""}}, pulse);
    const double t = rows.back().temperature_degC[0];
    const double before = 1.0 / (1.0 + std::exp(-35.0 / 12.6)), after = 1.0 / (1.0 + std::exp((t - 75.0) / 12.6));
    CHECK(before - after > 0.3);
    CHECK(0.5 * (t - 25.0) + 12.0 * (before - after) == by_hand(39.2));
  }
  SUBCASE("supplies: 0.28 A of 7 V; the limit's droop, and what sags late") {
    const double volt = (7.0 + 0.9 * 0.2) / (1.0 + 0.9 * 0.04);
    CHECK(rise_K(run("supply_sag", "limit", {{"droop_resistance_Ohm", 0.9}, {"current_A", 0.2}})) == by_hand(volt * volt));
    CHECK(same_bytes(run("supply_sag", "limit", {{"droop_resistance_Ohm", 0.9}, {"current_A", 0.3}}), core));
    const auto slow = run("supply_sag", "slow", {{"source_resistance_Ohm", 0.5}, {"time_constant_s", 10.0}});
    CHECK(rise_K(slow) == by_hand(std::pow(7.0 / 1.02, 2)));
    CHECK(slow[1].temperature_degC[0] == doctest::Approx(core[1].temperature_degC[0]).epsilon(1e-5));
  }
  SUBCASE("dead band with a knee: 0.018 ln((1 + exp(0.04 / 0.018)) / (1 + exp(-0.06 / 0.018))) of 0.1") {
    const double left = 0.018 * std::log((1.0 + std::exp(0.04 / 0.018)) / (1.0 + std::exp(-0.06 / 0.018)));
    CHECK(left < 0.1 - 0.05);
    CHECK(rise_K(run("duty_deadband", "knee", {{"threshold_fraction", 0.06}, {"knee_share", 0.3}})) == by_hand(490.0 * left));
  }
  SUBCASE("resistance with a peak") {
    const double x = rise_K(run("resistance_change", "peak", {{"relative_peak", 0.2}})), xi = on_heating(25.0 + x, 0.0);
    CHECK(x < 45.0);
    CHECK(0.04 * x * (1.0 + 0.8 * xi * (1.0 - xi)) == by_hand(1.96));
  }
  SUBCASE("stress shifts: wire A on the envelope that its own tension moved") {
    const auto balanced = [&](const std::vector<prove::Sample>& rows, const auto& heating_K, const auto& cooling_K) {
      const double shortened = 0.006 * theta(rows);
      double cold = on_cooling(25.0, 0.0);
      for (int i = 0; i < 50; ++i) cold = on_cooling(25.0, cooling_K(tension_N(cold, -shortened), cold));
      const double hot_N = 0.05 * theta(rows) / 0.006 + tension_N(cold, -shortened);
      double hot = on_heating(74.0, 0.0);
      for (int i = 0; i < 50; ++i) hot = on_heating(74.0, heating_K(hot_N, hot));
      CHECK(hot_N > 1.0);
      CHECK(hot_N == by_hand(tension_N(hot, shortened)));
      CHECK(rows.back().angle_deg < core.back().angle_deg - 0.5);
    };
    const auto quadratic = [](double force, double) { return 0.25 * std::abs(force) * force; };
    balanced(run("stress_shift", "quadratic", {{"shift_K_N2", 0.25}}), quadratic, quadratic);
    balanced(
        run("stress_shift", "two_slopes", {{"heating_shift_K_N", 1.4}, {"cooling_shift_K_N", 2.6}}),
        [](double force, double) { return 1.4 * force; }, [](double force, double) { return 2.6 * force; });
    // The cold coil's half a newton is below the threshold.
    balanced(
        run("stress_shift", "threshold", {{"shift_K_N", 2.0}, {"threshold_N", 1.0}}),
        [](double force, double) { return 2.0 * (force - 1.0); }, [](double, double) { return 0.0; });
    CHECK(same_bytes(run("stress_shift", "threshold", {{"shift_K_N", 2.0}, {"threshold_N", 20.0}}), core));
    const auto torsion = [](double force, double xi) { return 2.4 * force * std::sqrt(1.0 - 0.8 * xi); };
    balanced(run("stress_shift", "torsion", {{"shift_K_N", 2.4}, {"core_share", 0.2}}), torsion, torsion);
  }
  SUBCASE("fatigue by the logarithm: half a cycle's share of a stroke") {
    const auto rows = run("fatigue", "logarithmic", {{"loss", 0.1}, {"cycles", 1.0}});
    const double hot = on_heating(74.0, 0.0), cold = on_cooling(25.0, 0.0), left = 1.0 - 0.1 * std::log(1.0 + 0.5 * (cold - hot));
    const double shortened = 0.006 * theta(rows);
    const double hot_N = (313.0 - 200.0 * hot) * (0.030 - shortened - hot * 0.028 * left);
    CHECK(0.05 * theta(rows) == by_hand(0.006 * (hot_N - tension_N(cold, -shortened))));
    CHECK(rows.back().angle_deg > core.back().angle_deg + 0.01);
  }
  SUBCASE("creep of two times, and creep that flows: late, and in the end nowhere else") {
    for (const auto& rows :
         {run("viscoelastic_creep", "two_times", {{"stiffness_Nm_rad", 0.02}, {"fast_s", 2.0}, {"slow_s", 20.0}}),
          run("viscoelastic_creep", "eyring", {{"stiffness_Nm_rad", 0.02}, {"time_constant_s", 20.0}, {"angle_deg", 4.0}})}) {
      CHECK(rows[400].angle_deg < core[400].angle_deg - 0.1);
      CHECK(rows.back().angle_deg == doctest::Approx(core.back().angle_deg).epsilon(1e-6));
    }
    // Heavily loaded it flows faster than a branch of the same time constant.
    const auto eyring = run("viscoelastic_creep", "eyring", {{"stiffness_Nm_rad", 0.02}, {"time_constant_s", 20.0}, {"angle_deg", 1.0}});
    const auto linear = run("viscoelastic_creep", "", {{"stiffness_Nm_rad", 0.02}, {"time_constant_s", 20.0}});
    CHECK(eyring[500].angle_deg > linear[500].angle_deg + 0.1);
  }
  SUBCASE("bristles: the whole moment after many times their give, less before") {
    const auto rows = run("dry_friction", "bristle", {{"moment_Nm", 0.002}, {"give_deg", 1.0}});
    CHECK(rows.back().angle_deg > 10.0);
    CHECK(moment_Nm(rows) == by_hand(0.002 * (1.0 - std::exp(-rows.back().angle_deg))));
    const auto stiff = run("dry_friction", "bristle", {{"moment_Nm", 0.002}, {"give_deg", 30.0}});
    CHECK(moment_Nm(stiff) == by_hand(0.002 * (1.0 - std::exp(-stiff.back().angle_deg / 30.0))));
  }
  SUBCASE("stiffening by the fourth power, and of chains that end") {
    const auto fourth = run("cubic_stiffening", "fourth_order", {{"stiffness_Nm_rad4", 0.2}});
    CHECK(moment_Nm(fourth) == by_hand(0.2 * std::pow(theta(fourth), 4)));
    const auto chain = run("cubic_stiffening", "limited_chain", {{"stiffness_Nm_rad", 0.03}, {"limit_deg", 80.0}});
    const double used = std::pow(chain.back().angle_deg / 80.0, 2);
    CHECK(moment_Nm(chain) == by_hand(0.03 * theta(chain) * used / (1.0 - used)));
    CHECK(moment_Nm(chain) > 1e-4);
    // Against the bend on either side: the mirror image bends as far.
    const auto mirrored =
        prove::simulate({{"bend_sign", -1.0}}, {{"cubic_stiffening", "fourth_order", "", {{"stiffness_Nm_rad4", 0.2}}, false, ""}}, steady);
    CHECK(mirrored.back().angle_deg == by_hand(-fourth.back().angle_deg));
  }
  SUBCASE("weight along the arc: the slope of its potential") {
    const double tilt = 40.0 * std::numbers::pi / 180.0;
    const auto rows = run("gravity_load", "spread", {{"moment_Nm", 0.06}, {"tilt_deg", 40.0}});
    const auto potential_Nm = [&](double angle) {
      // Mean height of 20000 pieces of an arc of length 1: cos(tilt) along the base's direction downwards, sin(tilt) across it upwards.
      double along = 0.0, across = 0.0;
      for (int i = 0; i < 20000; ++i) {
        const double u = (i + 0.5) / 20000.0;
        along += std::sin(angle * u) / angle / 20000.0;
        across += (1.0 - std::cos(angle * u)) / angle / 20000.0;
      }
      return -0.06 * (std::cos(tilt) * along - std::sin(tilt) * across);
    };
    const double slope = (potential_Nm(theta(rows) + 1e-3) - potential_Nm(theta(rows) - 1e-3)) / 2e-3;
    CHECK(slope > 1e-3);
    CHECK(moment_Nm(rows) == doctest::Approx(slope).epsilon(1e-5));
    // Straight, it hangs on a sixth of its weight's moment across. The other way round it bends the other way.
    CHECK(rows.front().angle_deg < 0.0);
    CHECK(run("gravity_load", "spread", {{"moment_Nm", 0.06}, {"tilt_deg", -40.0}}).front().angle_deg == by_hand(-rows.front().angle_deg));
  }
  SUBCASE("drift by the root of time: 0.2 * sqrt(400) degrees") {
    const auto rows = run("angle_sensor_drift", "root", {{"rate_deg_rts", 0.2}});
    CHECK(rows[4000].angle_deg == by_hand(core[4000].angle_deg + 4.0));
    CHECK(rows.front().angle_deg == core.front().angle_deg);
  }
  SUBCASE("a taut coil is cooler by its tension") {
    const auto rows = run("tension_cooling", "", {{"slope_1_N", 0.02}});
    const double x = rise_K(rows), force_N = tension_N(on_heating(25.0 + x, 0.0), 0.006 * theta(rows));
    CHECK(force_N > 1.0);
    CHECK(0.04 * x * (1.0 + 0.02 * force_N) == by_hand(1.96));
  }
  SUBCASE("silicone 24.5 K warmer is softer by 0.006 / K, and not at once") {
    const auto rows = run("silicone_softening", "", {{"slope_1_K", 0.006}, {"time_constant_s", 30.0}});
    CHECK(moment_Nm(rows) == doctest::Approx(-0.05 * 0.006 * 24.5 * theta(rows)).epsilon(1e-5));  // 17 time constants
    CHECK(rows[100].angle_deg - core[100].angle_deg < 0.1 * (rows.back().angle_deg - core.back().angle_deg));
  }
  SUBCASE("backlash: the coils feel half the play less, and nothing of a bend within it") {
    const auto rows = run("backlash", "", {{"play_deg", 6.0}});
    CHECK(moment_Nm(rows) == by_hand(-coils_Nm_rad * 3.0 * std::numbers::pi / 180.0));
    const auto loose = run("backlash", "", {{"play_deg", 90.0}});
    CHECK(moment_Nm(loose) == by_hand(-coils_Nm_rad * theta(loose)));
  }
  SUBCASE("hysteresis of the bend sensor: behind on the way up, ahead on the way down") {
    auto up_and_down = steady;
    for (std::size_t k = 3000; k < steady.size(); ++k) up_and_down[k].duty = {0.0, 0.0};
    const auto plain = prove::simulate({}, {}, up_and_down);
    const auto rows =
        prove::simulate({}, {{"angle_hysteresis", "", "", {{"half_width_deg", 1.5}, {"reversal_deg", 3.0}}, false, ""}}, up_and_down);
    CHECK(plain[2999].angle_deg - rows[2999].angle_deg == by_hand(1.5 * (1.0 - std::exp(-plain[2999].angle_deg / 3.0))));
    CHECK(rows.back().angle_deg - plain.back().angle_deg > 1.0);
  }
}

TEST_CASE("generator: minor loops in proportion to what is left change less than those of the catalogue, and more than none") {
  const auto duty = prove::make(kind_named("core"), 3, still(120.0, 1.0)).training;
  const auto off = [&](const std::string& form, double share) {
    const auto rows = prove::simulate({}, {{"minor_loops", form, "", {{"slope_share", share}}, form.empty(), ""}}, duty);
    const auto core = prove::simulate({}, {}, duty);
    double squares = 0.0;
    for (std::size_t k = 0; k < rows.size(); ++k) squares += std::pow(rows[k].angle_deg - core[k].angle_deg, 2);
    return std::sqrt(squares / static_cast<double>(rows.size()));
  };
  CHECK(off("proportional", 0.3) > 0.2);
  CHECK(off("proportional", 0.3) < off("", 0.3));
  CHECK(off("proportional", 0.15) < off("proportional", 0.3));
}

namespace {

using Parameters = std::map<std::string, double>;

prove::TruthEffect junction(Parameters parameters, std::string form = "") {
  return {"junction", std::move(form), "", std::move(parameters), true, ""};
}
// A junction by the heat that it loses and by its share of the current heat, on a wire of 0.85 J/K.
Parameters body_of(double capacity_J_K, double loss_W_K, double power_share, double conductance_W_K) {
  return {{"heat_capacity_J_K", capacity_J_K},
          {"cooling_rate_1_s", loss_W_K / capacity_J_K},
          {"relative_power", power_share * (0.85 + capacity_J_K) / capacity_J_K},
          {"conductance_W_K", conductance_W_K}};
}
Parameters with(Parameters parameters, const std::string& name, double value) {
  parameters[name] = value;
  return parameters;
}
prove::TruthEffect layer(Parameters parameters, std::string form = "") {
  return {"junction_layer", std::move(form), "", std::move(parameters), true, ""};
}
const prove::TruthEffect wire_shown{"angle_temperature", "", "", {{"slope_deg_K", 1.0}}, false, ""};

// Duty of 0.1 in coil A, 0.1 * 49 V^2 / 2.5 Ohm = 1.96 W, for so many seconds of `duration_s`.
std::vector<prove::Sample> heated_for(double heated_s, double duration_s) {
  std::vector<prove::Sample> rows(static_cast<std::size_t>(std::round(10.0 * duration_s)) + 1);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double time_s = static_cast<double>(k) / 10.0;
    rows[k] = {time_s, {time_s < heated_s ? 0.1 : 0.0, 0.0}, {}, 0.0};
  }
  return rows;
}

}  // namespace

TEST_CASE("generator: a junction and its layer end where the heat that comes leaves, in every form, by hand" * long_when_sanitized) {
  // Rises x of wire A and y of the body under its thermocouple. In all: 1.96 W = 0.04 x + 0.02 y. Into that body: 0.2 * 1.96 W + 0.08 (x -
  // y) = 0.02 y, so y = 3.92 + 0.8 x, 1.8816 = 0.056 x, x = 33.6 K, y = 30.8 K. 700 s are 20 time constants of the slowest.
  const auto steady = heated_for(1e9, 700.0);
  const auto ends = [&](std::vector<prove::TruthEffect> effects) {
    const auto shown = prove::simulate({}, effects, steady).back();
    effects.push_back(wire_shown);
    const auto with_wire = prove::simulate({}, effects, steady).back();
    constexpr double rest = 1e-6;
    CHECK(shown.temperature_degC[0] == doctest::Approx(55.8).epsilon(rest));
    CHECK(shown.temperature_degC[1] == doctest::Approx(25.0).epsilon(rest));
    // Half of 33.6 K, wire B being cold.
    CHECK(with_wire.angle_deg - shown.angle_deg == doctest::Approx(16.8).epsilon(rest));
  };
  const auto body = [](double loss_W_K) { return junction(body_of(0.3, loss_W_K, 0.2, 0.08)); };
  SUBCASE("junction") { ends({body(0.02)}); }
  SUBCASE("layer: 0.03 W/K and 0.006 W/K in a row are 0.005 W/K, beside 0.015 W/K") {
    ends({body(0.015), layer({{"conductance_W_K", 0.03}, {"heat_capacity_J_K", 0.3}, {"heat_loss_W_K", 0.006}})});
  }
  SUBCASE("diffusive layer: 1/0.03 + 3/0.09 + 1/0.0075 = 200 K/W") {
    ends({body(0.015),
          layer({{"conductance_W_K", 0.03}, {"heat_capacity_J_K", 0.3}, {"heat_loss_W_K", 0.0075}, {"inner_conductance_W_K", 0.09}},
                "diffusive")});
  }
  SUBCASE("conductance that grows: 0.05 W/K (1 + a 32.2 K) = 0.08 W/K") {
    ends({junction(with(body_of(0.3, 0.02, 0.2, 0.05), "slope_1_K", 0.6 / 32.2), "progressive")});
  }
  SUBCASE("two bodies: of 0.616 W that leave, 0.196 W arise in the first, at 32.8 K; 0.42 W flow there over 0.8 K, all goes on over 2 K") {
    ends({junction(with(body_of(0.3, 0.02, 0.1, 0.525), "inner_conductance_W_K", 0.308), "series")});
  }
}

TEST_CASE("generator: a junction and its layer keep what heat they get, in every form, by hand" * long_when_sanitized) {
  // Nothing leaves coil A. 1.96 W for 20 s are 39.2 J, in 1.4 J/K: 28 K, wherever the heat arose.
  const auto pulse = heated_for(20.0, 700.0);
  const auto keeps = [&](const std::vector<prove::TruthEffect>& effects) {
    const auto rows = prove::simulate({{"heat_loss_A_W_K", 0.0}, {"heat_capacity_A_J_K", 0.5}}, effects, pulse);
    CHECK(rows.back().temperature_degC[0] == doctest::Approx(53.0).epsilon(1e-7));
    // The coil beside it has no part in it.
    CHECK(rows.back().temperature_degC[1] == 25.0);
    CHECK(std::abs(rows[200].temperature_degC[0] - 53.0) > 0.5);
  };
  const auto body = [](double capacity_J_K) {
    return junction({{"heat_capacity_J_K", capacity_J_K}, {"relative_power", 0.6}, {"conductance_W_K", 0.08}});
  };
  SUBCASE("junction") { keeps({body(0.9)}); }
  SUBCASE("layer") { keeps({body(0.4), layer({{"conductance_W_K", 0.03}, {"heat_capacity_J_K", 0.5}})}); }
  SUBCASE("diffusive layer") {
    keeps({body(0.4), layer({{"conductance_W_K", 0.03}, {"heat_capacity_J_K", 0.5}, {"inner_conductance_W_K", 0.08}}, "diffusive")});
  }
  SUBCASE("conductance that grows") {
    keeps(
        {junction({{"heat_capacity_J_K", 0.9}, {"relative_power", 0.6}, {"conductance_W_K", 0.05}, {"slope_1_K", 0.012}}, "progressive")});
  }
  SUBCASE("two bodies") {
    keeps({junction({{"heat_capacity_J_K", 0.9}, {"relative_power", 0.6}, {"conductance_W_K", 0.08}, {"inner_conductance_W_K", 0.15}},
                    "series")});
  }
}

TEST_CASE("generator: a junction and its layer vanish where they should, and their forms become theirs" * long_when_sanitized) {
  const auto duty = prove::make(kind_named("core"), 3, still(120.0, 1.0)).training;
  const auto run = [&](const std::vector<prove::TruthEffect>& effects, const Parameters& core = {}) {
    return prove::simulate(core, effects, duty);
  };
  const auto largest = [](const Difference& difference) { return std::max(difference.temperature_K, difference.angle_deg); };
  const Parameters usual = body_of(0.4, 0.01, 0.25, 0.07);
  const Parameters around{{"conductance_W_K", 0.035}, {"heat_capacity_J_K", 0.5}, {"heat_loss_W_K", 0.004}};
  const auto plain = run({}), alone = run({junction(usual)}), layered = run({junction(usual), layer(around)});
  CHECK(largest(between(alone, plain)) > 2.0);
  CHECK(largest(between(layered, alone)) > 2.0);

  SUBCASE("no share, no loss and hardly any heat capacity: the plain limb") {
    // It follows late by its heat capacity over 0.07 W/K, 1.4 ms, while a wire warms by up to 14 K/s.
    const auto little = [&](double capacity_J_K) {
      return between(run({junction({{"heat_capacity_J_K", capacity_J_K}, {"conductance_W_K", 0.07}})}), plain);
    };
    CHECK(largest(little(1e-4)) < 0.05);
    CHECK(little(1e-4).temperature_K == doctest::Approx(0.1 * little(1e-3).temperature_K).epsilon(0.05));
    CHECK(same_bytes(run({junction(with(usual, "heat_capacity_J_K", 0.0))}), plain));
  }
  SUBCASE("heat gained and lost as its heat capacity asks for: as warm as the wire, and together they are the plain one") {
    // 0.85 J/K and 0.04 W/K, three parts in the wire and two in the junction, and of the current heat two of five.
    const Parameters wires{{"heat_capacity_A_J_K", 0.51},
                           {"heat_capacity_B_J_K", 0.51},
                           {"heat_loss_A_W_K", 0.024},
                           {"heat_loss_B_W_K", 0.024}};
    const auto parted =
        run({junction(
                {{"heat_capacity_J_K", 0.34}, {"cooling_rate_1_s", 0.016 / 0.34}, {"relative_power", 1.0}, {"conductance_W_K", 0.07}})},
            wires);
    CHECK(largest(between(parted, plain)) < 1e-7);
  }
  SUBCASE("a layer that touches nothing, or stores nothing") {
    CHECK(same_bytes(run({junction(usual), layer(with(around, "conductance_W_K", 0.0))}), alone));
    CHECK(largest(between(run({junction(usual), layer({{"conductance_W_K", 0.035}, {"heat_capacity_J_K", 1e-3}})}), alone)) < 0.2);
  }
  SUBCASE("conductance that does not grow") { CHECK(same_bytes(run({junction(with(usual, "slope_1_K", 0.0), "progressive")}), alone)); }
  // Nodes so well joined that they are one: 60 and 30 W/K against the 0.07 W/K by which the wire is.
  SUBCASE("two bodies that are one") {
    CHECK(largest(between(run({junction(with(usual, "inner_conductance_W_K", 60.0), "series")}), alone)) < 0.05);
  }
  SUBCASE("four nodes that are one") {
    CHECK(largest(between(run({junction(usual), layer(with(around, "inner_conductance_W_K", 30.0), "diffusive")}), layered)) < 0.02);
  }
}

namespace {

bool has_body(const Kind& kind) { return kind.name.starts_with("junction") && kind.name != "junction.outer_turns"; }

// Of the current heat, by the junction's share of the heat capacity, beside the mean of the two wires.
double power_share(const Concealed& made) {
  const Parameters& body = made.effects.front().parameters;
  const double wire_J_K = 0.5 * (made.core_parameters.at("heat_capacity_A_J_K") + made.core_parameters.at("heat_capacity_B_J_K"));
  return body.at("relative_power") * body.at("heat_capacity_J_K") / (wire_J_K + body.at("heat_capacity_J_K"));
}

}  // namespace

TEST_CASE("generator: a limb with a junction has the numbers of one, and a lighter wire" * long_when_sanitized) {
  for (const Kind& kind : prove::kinds()) {
    if (!has_body(kind)) continue;
    CAPTURE(kind.name);
    const bool layered = kind.effects.size() == 2;
    Settings barely = still(0.1, 0.1);
    barely.strength = 0.25;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      const Concealed made = prove::make(kind, seed, still(0.1, 0.1)), faint = prove::make(kind, seed, barely);
      CHECK(made.effects.front().name == "junction");
      const auto in = [](double value, double low, double high) { return value >= low && value <= high; };
      const Parameters& body = made.effects.front().parameters;
      CHECK(in(body.at("heat_capacity_J_K"), 0.2, 0.6));
      CHECK(in(power_share(made), 0.1, 0.35));
      CHECK(in(body.at("cooling_rate_1_s"), 0.01, 0.04));
      CHECK(in(body.at("conductance_W_K"), 0.03, 0.12));
      const Parameters& faint_body = faint.effects.front().parameters;
      CHECK(faint_body.at("heat_capacity_J_K") == doctest::Approx(0.25 * body.at("heat_capacity_J_K")).epsilon(1e-14));
      CHECK(power_share(faint) == doctest::Approx(0.25 * power_share(made)).epsilon(1e-14));
      for (const char* name : {"cooling_rate_1_s", "conductance_W_K"}) CHECK(faint_body.at(name) == body.at(name));
      if (layered) {
        const Parameters& around = made.effects.back().parameters;
        CHECK(made.effects.back().name == "junction_layer");
        CHECK(in(around.at("conductance_W_K"), 0.02, 0.05));
        CHECK(in(around.at("heat_capacity_J_K"), 0.3, 0.8));
        CHECK(in(around.at("heat_loss_W_K"), 0.002, 0.006));
        CHECK(faint.effects.back().parameters.at("conductance_W_K") == doctest::Approx(0.25 * around.at("conductance_W_K")).epsilon(1e-14));
        CHECK(faint.effects.back().parameters.at("heat_capacity_J_K") == around.at("heat_capacity_J_K"));
      }
      for (const char* name : {"heat_capacity_A_J_K", "heat_capacity_B_J_K"}) {
        CHECK(in(made.core_parameters.at(name) / 0.85, 0.5, 0.8));
        CHECK(in(faint.core_parameters.at(name) / 0.85, 0.85, 0.98));
      }
    }
  }
}

TEST_CASE("generator: what has another name than it had draws the numbers that it drew" * long_when_sanitized) {
  const auto varied = [](const std::string& stream, double plain, double variation) {
    return doctest::Approx(plain * prove::Stream(7, stream).uniform(0, 1.0 - variation, 1.0 + variation)).epsilon(1e-14);
  };
  const Concealed turns = prove::make(kind_named("junction.outer_turns"), 7, still(1.0, 1.0));
  // In its place, too, by which proof/cases.cpp gives out disturbances.
  CHECK(prove::kinds()[3].name == "junction.outer_turns");
  CHECK(turns.effects.front().name == "junction");
  CHECK(turns.effects.front().form == "outer_turns");
  CHECK(turns.effects.front().parameters.at("relative_heat_loss") == varied("outer_turns/outer_turns.relative_heat_loss", 0.4, 0.25));
  CHECK(turns.effects.front().parameters.at("power_share") == varied("outer_turns/outer_turns.power_share", 0.5, 0.25));
  // Its wire is as heavy as believed.
  CHECK(turns.core_parameters.at("heat_capacity_A_J_K") == varied("outer_turns/core.heat_capacity_A_J_K", 0.85, 0.08));
  const Concealed body = prove::make(kind_named("junction"), 7, still(1.0, 1.0));
  CHECK(body.effects.front().parameters.at("cooling_rate_1_s") == varied("junction/junction.heat_loss_W_K", 0.025, 0.6));
  CHECK(power_share(body) == varied("junction/junction.power_share", 0.225, 0.55));
}

TEST_CASE("generator: every effect of the catalogue is concealed by its name, place and parameters" * long_when_sanitized) {
  std::vector<std::string> concealed;
  for (const Kind& kind : prove::kinds()) {
    // A layer lies around a junction, and is concealed with it alone.
    const bool layered = kind.name == "junction+junction_layer";
    if (kind.family != Family::catalogue && !layered) continue;
    const Concealed made = prove::make(kind, 1, still(1.0, 1.0));
    REQUIRE(made.effects.size() == (layered ? 2 : 1));
    const prove::TruthEffect& truth = made.effects.back();
    CAPTURE(truth.name);
    CHECK(truth.name == (layered ? "junction_layer" : kind.name));
    CHECK(truth.in_catalogue);
    CHECK(truth.form.empty());
    const plant::EffectInfo& info = catalogue().effects()[catalogue().effect(truth.name)];
    CHECK(truth.place == info.place);
    CHECK(truth.parameters.size() == info.parameters.size());
    for (const auto& [name, value] : truth.parameters) {
      const plant::Declaration& declared = catalogue().parameters()[catalogue().parameter(truth.name + "." + name)].declaration;
      CHECK(value >= declared.range.lowest);
      CHECK(value <= declared.range.highest);
    }
    concealed.push_back(truth.name);
  }
  const auto& effects = catalogue().effects();
  std::size_t families = 0;
  for (const plant::EffectId e : effects.ids()) families += plant::family_of(effects, e) == e;
  CHECK(concealed.size() == families);
}

TEST_CASE("generator: other forms and effects outside the catalogue lie in every place" * long_when_sanitized) {
  std::set<std::string> names, places_of_forms, places_outside;
  for (const Kind& kind : prove::kinds()) {
    CAPTURE(kind.name);
    CHECK(names.insert(kind.name).second);
    const Concealed made = prove::make(kind, 1, still(1.0, 1.0));
    CHECK(made.effects.size() == kind.effects.size());
    if (kind.family != Family::other_form && kind.family != Family::outside) continue;
    const prove::TruthEffect& truth = made.effects.back();  // the others are what it needs
    CHECK_FALSE(truth.in_catalogue);
    const auto known = std::ranges::find(catalogue().effects(), truth.name, &plant::EffectInfo::name);
    if (kind.family == Family::other_form) {
      REQUIRE(known != catalogue().effects().end());
      CHECK(truth.place == known->place);
      CHECK_FALSE(truth.form.empty());
      places_of_forms.insert(truth.place);
    } else {
      CHECK(known == catalogue().effects().end());
      places_outside.insert(truth.place);
    }
  }
  CHECK(places_of_forms.size() == 6);
  CHECK(places_outside.size() == 6);
}

TEST_CASE("generator: the same kind, seed and settings make the same bytes, another seed others" * long_when_sanitized) {
  Settings settings{60.0, 30.0, 1.0, {}};
  settings.disturbances = {true, true, true, true, true, true};
  for (const char* name : {"latent_heat+viscoelastic_creep", "junction+junction_layer", "junction_layer.diffusive"}) {
    CAPTURE(name);
    const Kind kind = kind_named(name);
    const Concealed one = prove::make(kind, 5, settings), again = prove::make(kind, 5, settings);
    CHECK(same_bytes(one.training, again.training));
    CHECK(same_bytes(one.heldout, again.heldout));
    CHECK(same_bytes(one.training_without_noise, again.training_without_noise));
    CHECK(one.core_parameters == again.core_parameters);
    CHECK(one.effects.front().parameters == again.effects.front().parameters);
    CHECK(one.effects.back().parameters == again.effects.back().parameters);
    const Concealed other = prove::make(kind, 6, settings);
    CHECK_FALSE(same_bytes(one.training, other.training));
    CHECK(one.core_parameters != other.core_parameters);
  }
}

TEST_CASE("generator: the sealed truth is what was simulated" * long_when_sanitized) {
  for (const Kind& kind : prove::kinds()) {
    CAPTURE(kind.name);
    const Concealed made = prove::make(kind, 2, still(20.0, 10.0));
    CHECK(same_bytes(prove::simulate(made.core_parameters, made.effects, made.training), made.training_without_noise));
    CHECK(same_bytes(prove::simulate(made.core_parameters, made.effects, made.heldout), made.heldout_without_noise));
    for (const prove::Sample& row : made.training_without_noise)
      CHECK(std::isfinite(row.angle_deg + row.temperature_degC[0] + row.temperature_degC[1]));
  }
}

TEST_CASE("generator: rows follow the convention of recordings" * long_when_sanitized) {
  const Concealed made = prove::make(kind_named("core"), 1, Settings{30.0, 20.0, 1.0, {}});
  REQUIRE(made.training.size() == 301);
  CHECK(made.heldout.size() == 201);
  for (std::size_t k = 0; k < made.training.size(); ++k) {
    const prove::Sample& row = made.training[k];
    CHECK(row.time_s == static_cast<double>(k) * 0.1);
    CHECK(std::min(row.duty[0], row.duty[1]) == 0.0);
    CHECK(std::max(row.duty[0], row.duty[1]) <= 0.6);
    for (std::size_t j = 0; j < 2; ++j)
      if (row.temperature_degC[j] > 110.0) CHECK(row.duty[j] == 0.0);
    CHECK(made.training_without_noise[k].time_s == row.time_s);
    CHECK(made.training_without_noise[k].duty == row.duty);
  }
}

TEST_CASE("generator: noise and steps are those of the sensors" * long_when_sanitized) {
  // 8001 samples: a mean is right within 4/sqrt(8001) of the deviation, a deviation within 4/sqrt(16002) of itself.
  const Concealed made = prove::make(kind_named("core"), 4, Settings{400.0, 400.0, 1.0, {}});
  for (std::size_t c = 0; c < 3; ++c) {
    CAPTURE(c);
    const double step = c < 2 ? 0.25 : 1.0 / 32.0, noise = c < 2 ? 0.1 : 0.05;
    double sum = 0.0, squares = 0.0, n = 0.0;
    for (const auto& [rows, truth] :
         {std::pair{&made.training, &made.training_without_noise}, std::pair{&made.heldout, &made.heldout_without_noise}})
      for (std::size_t k = 0; k < rows->size(); ++k) {
        const double off = channel((*rows)[k], c) - channel((*truth)[k], c);
        CHECK(is_multiple(channel((*rows)[k], c), step));
        sum += off;
        squares += off * off;
        n += 1.0;
      }
    // A uniform error of a step has a variance of step^2 / 12.
    const double expected = std::sqrt(noise * noise + step * step / 12.0);
    CHECK(std::abs(sum / n) < 4.0 * expected / std::sqrt(n));
    CHECK(std::sqrt(squares / n) == doctest::Approx(expected).epsilon(4.0 / std::sqrt(2.0 * n)));
  }
}

TEST_CASE("generator: moving air wanders by a few tenths of a kelvin, in both wires alike" * long_when_sanitized) {
  const Concealed made = prove::make(kind_named("core"), 4, Settings{400.0, 200.0, 1.0, {}});
  const auto in_still_air = prove::simulate(made.core_parameters, made.effects, made.training);
  double squares = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < in_still_air.size(); ++k) {
    std::array<double, 2> off{};
    for (std::size_t j = 0; j < 2; ++j) off[j] = made.training_without_noise[k].temperature_degC[j] - in_still_air[k].temperature_degC[j];
    squares += 0.5 * (off[0] * off[0] + off[1] * off[1]);
    difference += (off[0] - off[1]) * (off[0] - off[1]);
  }
  const double n = static_cast<double>(in_still_air.size());
  // A wire with a time constant of 21 s follows air with a memory of 20 to 40 s by 0.3 sqrt(30/51) = 0.23 K; one
  // recording holds about ten independent values of it.
  CHECK(std::sqrt(squares / n) > 0.1);
  CHECK(std::sqrt(squares / n) < 0.4);
  // What differs is how fast each follows.
  CHECK(std::sqrt(difference / n) < 0.1);
}

TEST_CASE("generator: another sample rate is the same limb in the same air, sampled more or less often" * long_when_sanitized) {
  Settings usual{60.0, 30.0, 1.0, {}};
  usual.protocol = prove::Protocol::steps;
  const Kind kind = kind_named("latent_heat");
  const Concealed at_10_Hz = prove::make(kind, 6, usual);
  for (const double rate_Hz : {2.0, 5.0, 20.0, 50.0}) {
    CAPTURE(rate_Hz);
    Settings settings = usual;
    settings.sample_rate_Hz = rate_Hz;
    const Concealed made = prove::make(kind, 6, settings);
    CHECK(made.core_parameters == at_10_Hz.core_parameters);
    CHECK(made.effects.front().parameters == at_10_Hz.effects.front().parameters);
    REQUIRE(made.training.size() == static_cast<std::size_t>(60.0 * rate_Hz) + 1);
    CHECK(made.heldout.size() == static_cast<std::size_t>(30.0 * rate_Hz) + 1);
    CHECK(made.training.back().time_s == doctest::Approx(60.0).epsilon(1e-14));
    // Until the first level ends, after at least 8 s, the duty is the same, and so are air and limb; rows 2 s apart are rows of all
    // rates. What is left is the error of steps of up to 1 ms, which end elsewhere where the period is no multiple of them.
    for (std::size_t n = 0; n <= 3; ++n) {
      const auto row = static_cast<std::size_t>(std::lround(2.0 * static_cast<double>(n) * rate_Hz));
      const prove::Sample &here = made.training_without_noise[row], &there = at_10_Hz.training_without_noise[20 * n];
      REQUIRE(here.time_s == doctest::Approx(there.time_s).epsilon(1e-14));
      CHECK(here.duty == there.duty);
      CHECK(std::abs(here.temperature_degC[0] - there.temperature_degC[0]) < 1e-6);
      CHECK(std::abs(here.angle_deg - there.angle_deg) < 1e-6);
    }
    // However seldom it is looked at, the limb moves finely: with ten rows for each of these it does the same.
    std::vector<prove::Sample> finer;
    for (const prove::Sample& row : made.training)
      for (int i = 0; i < 10; ++i) finer.push_back({row.time_s + 0.1 * i / rate_Hz, row.duty, {}, 0.0});
    const auto fine = prove::simulate(made.core_parameters, made.effects, finer);
    const auto coarse = prove::simulate(made.core_parameters, made.effects, made.training);
    for (std::size_t k = 0; k < coarse.size(); ++k) {
      CHECK(std::abs(fine[10 * k].temperature_degC[0] - coarse[k].temperature_degC[0]) < 1e-6);
      CHECK(std::abs(fine[10 * k].angle_deg - coarse[k].angle_deg) < 1e-6);
    }
  }
  Settings impossible = usual;
  impossible.sample_rate_Hz = 0.5;
  CHECK_THROWS_WITH_AS(prove::make(kind, 6, impossible), "sample_rate_Hz is 0.500000, and must lie in [1.000000, 100.000000]",
                       std::invalid_argument);
}

TEST_CASE("generator: gaps last as long at any sample rate" * long_when_sanitized) {
  Settings settings = still(60.0, 1.0);
  settings.protocol = prove::Protocol::steps;
  settings.disturbances.gaps = true;
  const auto missing_s = [&](double rate_Hz) {
    settings.sample_rate_Hz = rate_Hz;
    const Concealed made = prove::make(kind_named("core"), 9, settings);
    return static_cast<double>(std::ranges::count_if(made.training, [](const prove::Sample& row) { return std::isnan(row.angle_deg); })) /
           rate_Hz;
  };
  // Each of three gaps is rounded to whole rows, at either end.
  CHECK(missing_s(50.0) > 1.5);
  CHECK(missing_s(5.0) == doctest::Approx(missing_s(50.0)).epsilon(3 * 0.2 / 1.5));
}

TEST_CASE("generator: each protocol drives the coils as it says, cool enough and hard enough" * long_when_sanitized) {
  const auto made = [](prove::Protocol protocol) {
    Settings settings = still(400.0, 200.0);
    settings.protocol = protocol;
    const Concealed concealed = prove::make(kind_named("core"), 4, settings);
    double hottest = 0.0;
    for (const auto* rows : {&concealed.training, &concealed.heldout})
      for (const prove::Sample& row : *rows)
        for (std::size_t j = 0; j < 2; ++j) {
          CHECK(row.duty[j] >= 0.0);
          CHECK(row.duty[j] <= 0.6);
          if (row.temperature_degC[j] > 110.0) CHECK(row.duty[j] == 0.0);
          hottest = std::max(hottest, row.temperature_degC[j]);
        }
    // Warm enough for the transformation, whose heating midpoint is 75 degC, to go most of its way.
    CHECK(hottest > 80.0);
    return concealed.training;
  };
  const auto driven = [](const prove::Sample& row) { return (row.duty[0] > 0.0 ? 1 : 0) + (row.duty[1] > 0.0 ? 2 : 0); };
  const auto changes = [](const std::vector<prove::Sample>& rows) {
    std::size_t count = 0;
    for (std::size_t k = 1; k < rows.size(); ++k) count += rows[k].duty != rows[k - 1].duty;
    return count;
  };
  SUBCASE("steps: A, B, both, none, each held for 8 to 30 s unless a wire is too hot") {
    const auto rows = made(prove::Protocol::steps);
    std::vector<int> turns;
    for (const prove::Sample& row : rows) {
      const bool cut = std::max(row.temperature_degC[0], row.temperature_degC[1]) > 110.0;
      if (!cut && (turns.empty() || turns.back() != driven(row))) turns.push_back(driven(row));
    }
    REQUIRE(turns.size() >= 12);
    for (std::size_t n = 0; n < 12; ++n) CHECK(turns[n] == std::array{1, 2, 3, 0}[n % 4]);
    // 400 s hold at least 13 levels and at most 50.
    std::set<double> levels;
    for (const prove::Sample& row : rows)
      for (const double duty : row.duty) levels.insert(duty);
    CHECK(levels.size() >= 12);
    CHECK(levels.size() <= 51);
    CHECK(*levels.rbegin() <= 0.35);
  }
  SUBCASE("slow ramps: one coil at a time, by less than 1.6e-3 from row to row") {
    const auto rows = made(prove::Protocol::slow_ramps);
    std::size_t both = 0, jumps = 0, rising = 0, falling = 0;
    for (std::size_t k = 1; k < rows.size(); ++k) {
      both += driven(rows[k]) == 3;
      const double by = rows[k].duty[0] - rows[k - 1].duty[0];
      rising += by > 0.0;
      falling += by < 0.0;
      // 0.22 in 30 s; where the thermostat cuts in, it falls to nothing.
      jumps += std::abs(by) > 0.22 / 30.0 * 0.1 * 1.001 && rows[k].duty[0] > 0.0 && rows[k - 1].duty[0] > 0.0;
    }
    CHECK(both == 0);
    CHECK(jumps == 0);
    CHECK(rising > 500);
    CHECK(falling > 500);
  }
  SUBCASE("random binary: two levels of each coil, a third of the time, on a clock of 4 s") {
    const auto rows = made(prove::Protocol::random_binary);
    for (std::size_t j = 0; j < 2; ++j) {
      std::set<double> levels;
      double on = 0.0;
      for (const prove::Sample& row : rows) levels.insert(row.duty[j]), on += row.duty[j] > 0.0;
      CHECK(levels.size() == 2);
      CHECK(*levels.rbegin() >= 0.25);
      CHECK(*levels.rbegin() <= 0.45);
      // 100 intervals: 33 on average, with a deviation of 4.7; the thermostat takes some away.
      CHECK(on / static_cast<double>(rows.size()) > 0.15);
      CHECK(on / static_cast<double>(rows.size()) < 0.5);
    }
    for (std::size_t k = 1; k < rows.size(); ++k)
      if (driven(rows[k]) != driven(rows[k - 1]) &&
          std::max(rows[k].temperature_degC[0], rows[k].temperature_degC[1]) < 100.0)  // far from the thermostat
        CHECK(k % 40 == 0);
  }
  SUBCASE("one coil: the other is never driven, and the limb bends towards the first") {
    const auto rows = made(prove::Protocol::one_sided);
    double largest_deg = 0.0;
    for (const prove::Sample& row : rows) {
      CHECK(row.duty[1] == 0.0);
      largest_deg = std::max(largest_deg, row.angle_deg);
    }
    CHECK(largest_deg > 15.0);
    CHECK(changes(rows) > 100);
  }
}

TEST_CASE("generator: air of each kind has its memory and its size, and wires of their own air differ" * long_when_sanitized) {
  // What the same duty does otherwise in still air is the air, behind the wire's own lag of about 21 s.
  const auto air = [](prove::AirMotion motion, bool moving) {
    Settings settings = still(1200.0, 1.0);
    settings.disturbances.moving_air = moving;
    settings.air = motion;
    const Concealed made = prove::make(kind_named("core"), 5, settings);
    const auto in_still_air = prove::simulate(made.core_parameters, made.effects, made.training);
    std::array<std::vector<double>, 2> off;
    for (std::size_t k = 0; k < in_still_air.size(); ++k)
      for (std::size_t j = 0; j < 2; ++j)
        off[j].push_back(made.training_without_noise[k].temperature_degC[j] - in_still_air[k].temperature_degC[j]);
    return off;
  };
  // How much of the variance moves within 20 s; one wire's lag is in all of them.
  const auto restless = [](const std::vector<double>& off) {
    double mean = 0.0, variance = 0.0, moved = 0.0;
    for (const double x : off) mean += x / static_cast<double>(off.size());
    for (const double x : off) variance += (x - mean) * (x - mean) / static_cast<double>(off.size());
    for (std::size_t k = 200; k < off.size(); ++k)
      moved += 0.5 * (off[k] - off[k - 200]) * (off[k] - off[k - 200]) / static_cast<double>(off.size() - 200);
    return moved / variance;
  };
  const auto correlation = [](const std::array<std::vector<double>, 2>& off) {
    double both = 0.0, a = 0.0, b = 0.0;
    for (std::size_t k = 0; k < off[0].size(); ++k) {
      both += off[0][k] * off[1][k];
      a += off[0][k] * off[0][k];
      b += off[1][k] * off[1][k];
    }
    return both / std::sqrt(a * b);
  };
  const auto none = air(prove::AirMotion::slow, false);
  CHECK(std::ranges::all_of(none[0], [](double x) { return x == 0.0; }));
  const auto shared = air(prove::AirMotion::shared, true), each = air(prove::AirMotion::separate, true),
             slow = air(prove::AirMotion::slow, true), fast = air(prove::AirMotion::fast, true);
  CHECK(correlation(shared) > 0.98);
  CHECK(correlation(slow) > 0.98);
  // About 25 independent values: a correlation of chance has a deviation of 0.2.
  CHECK(std::abs(correlation(each)) < 0.6);
  // By hand, of an air with memory m behind a lag of 21 s: what stays correlated over 20 s is (m e^(-20/m) - 21 e^(-20/21)) / (m - 21);
  // 0.90 at 150 s, 0.62 at 30 s, 0.50 at 5 s.
  CHECK(restless(slow[0]) < restless(shared[0]));
  CHECK(restless(shared[0]) < restless(fast[0]));
  CHECK(restless(slow[0]) < 0.25);
  CHECK(restless(fast[0]) > 0.35);
  // Wire A has the air that it had.
  double same = 0.0;
  for (std::size_t k = 0; k < 100; ++k) same = std::max(same, std::abs(each[0][k] - shared[0][k]));
  CHECK(same < 1e-3);
  CHECK(std::abs(each[1][99] - shared[1][99]) > 1e-3);
}

TEST_CASE("generator: another spread of the core scales what every parameter is off by" * long_when_sanitized) {
  Settings usual = still(0.1, 0.1), wide = usual, none = usual, impossible = usual;
  wide.core_spread = 0.15;
  none.core_spread = 0.0;
  impossible.core_spread = 0.4;
  const auto off = prove::make(kind_named("core"), 12, usual).core_parameters;
  const auto further = prove::make(kind_named("core"), 12, wide).core_parameters;
  const auto nominal = prove::make(kind_named("core"), 12, none).core_parameters;
  std::size_t scaled = 0;
  for (const auto& [name, value] : nominal) {
    CAPTURE(name);
    CHECK(value == doctest::Approx(plant::default_plant().get_in_file_units(catalogue().parameter(name))).epsilon(1e-14));
    CHECK(further.at(name) - value == doctest::Approx(0.15 / 0.08 * (off.at(name) - value)).epsilon(1e-9));
    scaled += off.at(name) != value;
  }
  CHECK(scaled == nominal.size() - 3);  // supply, inertia and sign are known
  CHECK_THROWS_WITH_AS(prove::make(kind_named("core"), 12, impossible), "core_spread is 0.400000, and must lie in [0.000000, 0.300000]",
                       std::invalid_argument);
}

TEST_CASE("generator: core parameters are off by up to 8 %, 3 K, 1 degree; what is known is not" * long_when_sanitized) {
  std::map<std::string, double> lowest, highest;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
    for (const auto& [name, value] : prove::make(kind_named("core"), seed, still(0.1, 0.1)).core_parameters) {
      lowest.try_emplace(name, value);
      highest.try_emplace(name, value);
      lowest[name] = std::min(lowest[name], value);
      highest[name] = std::max(highest[name], value);
    }
  std::size_t core_count = 0;
  for (const plant::ParameterInfo& info : catalogue().parameters()) core_count += !info.effect;
  CHECK(lowest.size() == core_count);
  for (const auto& [name, low] : lowest) {
    CAPTURE(name);
    const double nominal = plant::default_plant().get_in_file_units(catalogue().parameter(name));
    const double high = highest[name];
    double most = 0.08 * nominal;
    if (name.ends_with("_degC")) most = 3.0;
    if (name == "angle_offset_deg") most = 1.0;
    if (name == "supply_voltage_V" || name == "beam_inertia_kgm2" || name == "bend_sign") most = 0.0;
    // Rounding aside; 300 draws come within 5 % of both ends of their range.
    CHECK(low >= nominal - most * (1.0 + 1e-12));
    CHECK(high <= nominal + most * (1.0 + 1e-12));
    CHECK(low <= nominal - 0.9 * most);
    CHECK(high >= nominal + 0.9 * most);
  }
}

TEST_CASE("generator: strength multiplies what it should and leaves shapes and the core as they were" * long_when_sanitized) {
  Settings plain = still(1.0, 1.0), barely = plain;
  barely.strength = 0.25;
  const auto both = [&](std::string_view name) {
    return std::pair{prove::make(kind_named(name), 8, plain), prove::make(kind_named(name), 8, barely)};
  };
  const auto [creep, faint_creep] = both("viscoelastic_creep");
  CHECK(creep.core_parameters == faint_creep.core_parameters);
  CHECK(faint_creep.effects[0].parameters.at("stiffness_Nm_rad") ==
        doctest::Approx(0.25 * creep.effects[0].parameters.at("stiffness_Nm_rad")).epsilon(1e-14));
  CHECK(faint_creep.effects[0].parameters.at("time_constant_s") == creep.effects[0].parameters.at("time_constant_s"));
  const auto [sink, faint_sink] = both("thermocouple_heat_sink");
  CHECK(1.0 - faint_sink.effects[0].parameters.at("gain") ==
        doctest::Approx(0.25 * (1.0 - sink.effects[0].parameters.at("gain"))).epsilon(1e-13));
}

TEST_CASE("generator: every disturbance does what it says and leaves the limb alone" * long_when_sanitized) {
  const Kind kind = kind_named("stress_shift");
  Settings settings{200.0, 100.0, 1.0, {}};
  const Concealed usual = prove::make(kind, 9, settings);
  const auto with = [&](bool prove::Disturbances::*which) {
    Settings changed = settings;
    changed.disturbances.*which = true;
    Concealed made = prove::make(kind, 9, changed);
    CHECK(made.core_parameters == usual.core_parameters);
    CHECK(made.effects[0].parameters == usual.effects[0].parameters);
    return made;
  };
  const std::size_t rows = usual.training.size();

  SUBCASE("coarse steps") {
    for (const prove::Sample& row : with(&prove::Disturbances::coarse_steps).training) {
      CHECK(is_multiple(row.temperature_degC[0], 0.5));
      CHECK(is_multiple(row.angle_deg, 0.25));
    }
  }
  SUBCASE("gaps: in single channels, of duty and time never") {
    const Concealed made = with(&prove::Disturbances::gaps);
    for (std::size_t c = 0; c < 3; ++c) {
      std::size_t missing = 0;
      for (std::size_t k = 0; k < rows; ++k) {
        CHECK(made.training[k].duty == usual.training[k].duty);
        if (std::isnan(channel(made.training[k], c)))
          ++missing;
        else
          CHECK(channel(made.training[k], c) == channel(usual.training[k], c));
      }
      CHECK(missing >= 5);
      CHECK(missing <= 240);
    }
  }
  SUBCASE("outliers: 0.5 % of the samples, gross ones") {
    const Concealed made = with(&prove::Disturbances::outliers);
    for (std::size_t c = 0; c < 3; ++c) {
      std::size_t off = 0;
      for (std::size_t k = 0; k < rows; ++k) {
        CHECK(made.training[k].duty == usual.training[k].duty);
        const double by = std::abs(channel(made.training[k], c) - channel(usual.training[k], c));
        if (by == 0.0) continue;
        ++off;
        CHECK(by > (c < 2 ? 9.99 : 7.49));
        CHECK(by < (c < 2 ? 20.01 : 15.01));
      }
      // Ten are expected of 2001; a Poisson count lies in this range with a probability of 0.999.
      CHECK(off >= 2);
      CHECK(off <= 22);
    }
  }
  SUBCASE("clock drift") {
    const Concealed made = with(&prove::Disturbances::clock_drift);
    CHECK(made.training.back().time_s == doctest::Approx(202.0).epsilon(1e-14));
    CHECK(made.training.back().angle_deg == usual.training.back().angle_deg);
  }
  SUBCASE("mid-motion: the recording begins warm, at time 0, with as many rows") {
    const Concealed made = with(&prove::Disturbances::mid_motion);
    CHECK(made.training.size() == rows);
    CHECK(made.training.front().time_s == 0.0);
    const prove::Sample& first = made.training_without_noise.front();
    CHECK(std::max(first.temperature_degC[0], first.temperature_degC[1]) > 35.0);
  }
}

TEST_CASE("generator: begun in mid-motion, what nobody sees is as warm as the motion before made it" * long_when_sanitized) {
  Settings from_rest = still(100.0, 1.0), mid_motion = still(70.0, 1.0);
  mid_motion.disturbances.mid_motion = true;
  for (const Kind& kind : prove::kinds()) {
    if (!kind.name.starts_with("junction")) continue;
    CAPTURE(kind.name);
    const Concealed whole = prove::make(kind, 9, from_rest), cut = prove::make(kind, 9, mid_motion);
    // The same babbling: from 30 s on one is the other. Times are rounded differently.
    std::vector<prove::Sample> rest(whole.training_without_noise.begin() + 300, whole.training_without_noise.end());
    const Difference difference = between(rest, cut.training_without_noise);
    CHECK(difference.temperature_K < 1e-7);
    CHECK(difference.angle_deg < 1e-7);
    // Begun cold the same duty leads elsewhere, and not for a moment alone.
    const auto begun_cold = prove::simulate(cut.core_parameters, cut.effects, cut.training);
    CHECK(std::abs(begun_cold[100].temperature_degC[0] - cut.training_without_noise[100].temperature_degC[0]) +
              std::abs(begun_cold[100].temperature_degC[1] - cut.training_without_noise[100].temperature_degC[1]) >
          2.0);
  }
}

TEST_CASE("generator: what it does not know it says" * long_when_sanitized) {
  CHECK_THROWS_WITH_AS(prove::make({Family::catalogue, "x", {"latent_heta"}}, 1, still(1.0, 1.0)), "no such effect to conceal: latent_heta",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(prove::simulate({{"heat_loss_W_K", 1.0}}, {}, {}), "the core has no parameter heat_loss_W_K", std::invalid_argument);
  CHECK_THROWS_WITH_AS(prove::simulate({}, {{"latent_heat", "", "", {{"heat", 1.0}}, true, ""}}, {}), "latent_heat has no parameter heat",
                       std::invalid_argument);
}

namespace {

constexpr std::size_t series_channels = prove::series_coils.size() + prove::series_segments.size();

// Its measured columns, in their order.
std::vector<double> measured(const prove::SeriesSample& row) {
  const std::vector<double> all = prove::series_row(row);
  return {all.end() - static_cast<std::ptrdiff_t>(series_channels), all.end()};
}

double largest_between(const std::vector<prove::SeriesSample>& one, const std::vector<prove::SeriesSample>& other) {
  REQUIRE(one.size() == other.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k)
    for (std::size_t c = 0; c < series_channels; ++c) largest = std::max(largest, std::abs(measured(one[k])[c] - measured(other[k])[c]));
  return largest;
}

bool same_rows(const std::vector<prove::SeriesSample>& one, const std::vector<prove::SeriesSample>& other) {
  return std::ranges::equal(one, other, {}, prove::series_row, prove::series_row);
}

}  // namespace

TEST_CASE("series limb: it is the plant's limb of two segments, for the core and every effect that it can conceal" * long_when_sanitized) {
  const plant::Plant nominal = sim::read_plant_file(std::string(SINEW_SOURCE_DIR) + "/plant/limbs/series_limb.yaml");
  const plant::System& system = nominal.system();
  for (const Kind& kind : prove::series_kinds()) {
    CAPTURE(kind.name);
    const prove::SeriesConcealed made = prove::make_series(kind, 3, still(120.0, 1.0));
    plant::Plant plant = nominal;
    std::size_t core_count = 0;
    for (const plant::ParameterInfo& info : system.parameters()) core_count += !info.effect;
    CHECK(made.core_parameters.size() == core_count);
    for (const auto& [name, value] : made.core_parameters) plant.set_in_file_units(system.parameter(name), value);
    for (const prove::TruthEffect& effect : made.effects) {
      plant.turn(system.effect(effect.name), true);
      for (const auto& [name, value] : effect.parameters) plant.set_in_file_units(system.parameter(effect.name + "." + name), value);
    }
    std::vector<sim::Sample> samples;
    for (const prove::SeriesSample& row : made.training)
      samples.push_back({.time_s = row.time_s, .inputs = {row.duty.begin(), row.duty.end()}, .channels = {}});
    plant::Integrator run(plant, plant::Start{}, {.method = plant::Method::arkode, .relative_tolerance = 1e-9});
    double largest = 0.0;
    const auto failure = sim::replay(run, system, samples, [&](std::size_t k) {
      const std::vector<double> here = sim::in_file_units(system, run.readings()), there = measured(made.training_without_noise[k]);
      REQUIRE(here.size() == there.size());
      for (std::size_t c = 0; c < here.size(); ++c) largest = std::max(largest, std::abs(here[c] - there[c]));
    });
    CHECK_FALSE(failure.has_value());
    CHECK(largest < 5e-5);  // as for two coils; kelvins or degrees
    // An agreement in which the effect had no part would say nothing.
    if (!kind.effects.empty())
      CHECK(largest_between(prove::simulate_series(made.core_parameters, {}, made.training), made.training_without_noise) > 0.2);
  }
}

TEST_CASE("series limb: its columns are those of its plant file" * long_when_sanitized) {
  const plant::Plant nominal = sim::read_plant_file(std::string(SINEW_SOURCE_DIR) + "/plant/limbs/series_limb.yaml");
  const sim::Columns columns = sim::columns_of(nominal.system());
  std::vector<std::string> expected{"time_s"};
  for (const auto* part : {&columns.inputs, &columns.channels})
    for (const sim::Column& column : *part) expected.push_back(column.name);
  CHECK(prove::series_columns() == expected);
  CHECK(prove::series_row({}).size() == expected.size());
}

TEST_CASE("series limb: effects are exactly nothing at no strength" * long_when_sanitized) {
  Settings nothing = still(30.0, 1.0);
  nothing.strength = 0.0;
  for (const Kind& kind : prove::series_kinds()) {
    CAPTURE(kind.name);
    const prove::SeriesConcealed made = prove::make_series(kind, 4, nothing);
    CHECK(same_rows(made.training_without_noise, prove::simulate_series(made.core_parameters, {}, made.training)));
  }
}

TEST_CASE("series limb: both segments babble, each its own way, and the same seed makes the same rows" * long_when_sanitized) {
  Settings settings{120.0, 20.0, 1.0, {}};
  settings.sample_rate_Hz = 5.0;
  const Kind kind = prove::series_kinds().front();
  const prove::SeriesConcealed one = prove::make_series(kind, 5, settings), again = prove::make_series(kind, 5, settings),
                               other = prove::make_series(kind, 6, settings);
  CHECK(same_rows(one.training, again.training));
  CHECK(same_rows(one.heldout, again.heldout));
  CHECK_FALSE(same_rows(one.training, other.training));
  REQUIRE(one.training.size() == 601);
  CHECK(one.heldout.size() == 101);
  std::array<double, prove::series_coils.size()> driven{};
  std::size_t alike = 0;
  for (const prove::SeriesSample& row : one.training) {
    for (std::size_t j = 0; j < driven.size(); ++j) {
      CHECK(row.duty[j] <= 0.6);
      if (row.temperature_degC[j] > 110.0) CHECK(row.duty[j] == 0.0);
      driven[j] += row.duty[j] > 0.0;
    }
    alike += row.duty[0] == row.duty[2] && row.duty[1] == row.duty[3];
  }
  for (const double rows : driven) CHECK(rows > 20.0);
  CHECK(alike < 300);
}

TEST_CASE("series limb: weight acts by the absolute angle, heat crosses within a segment alone" * long_when_sanitized) {
  // The tip's coils are cold; those of the base are not.
  std::vector<prove::SeriesSample> rows(1201);
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = {0.1 * static_cast<double>(k), {0.1, 0.0, 0.0, 0.0}, {}, {}};
  const auto with = [&](const std::string& name, std::map<std::string, double> parameters) {
    return prove::simulate_series({}, {{name, "", "", std::move(parameters), true, ""}}, rows);
  };
  const auto core = prove::simulate_series({}, {}, rows);
  CHECK(core.back().angle_deg[0] > 5.0);
  CHECK(core.back().angle_deg[1] == core.front().angle_deg[1]);
  // Straight and untilted it has no weight; bent by the base the tip bends back.
  const auto heavy = with("gravity_load", {{"moment_Nm", 0.01}, {"tilt_deg", 0.0}});
  CHECK(std::abs(heavy.front().angle_deg[1]) < 1e-9);
  CHECK(heavy.back().angle_deg[0] < core.back().angle_deg[0] - 0.5);
  CHECK(heavy.back().angle_deg[1] < -0.5);
  const auto crossing = with("cross_heating", {{"conductance_W_K", 0.006}});
  CHECK(crossing.back().temperature_degC[1] > 25.0 + 1.0);
  CHECK(crossing.back().temperature_degC[2] == 25.0);
  CHECK(crossing.back().temperature_degC[3] == 25.0);
}

TEST_CASE("series limb: what it does not have it says" * long_when_sanitized) {
  Settings settings = still(1.0, 1.0);
  settings.disturbances.gaps = true;
  CHECK_THROWS_WITH_AS(prove::make_series(prove::series_kinds().front(), 1, settings),
                       "the limb of two segments has babbling alone, and of the disturbances moving air alone", std::invalid_argument);
  CHECK_THROWS_WITH_AS(prove::make_series({Family::catalogue, "latent_heat", {"latent_heat"}}, 1, still(1.0, 1.0)),
                       "the limb of two segments has no effect latent_heat", std::invalid_argument);
  CHECK_THROWS_WITH_AS(prove::simulate_series({{"heat_loss_A_W_K", 1.0}}, {}, {}),
                       "the core of the limb of two segments has no parameter heat_loss_A_W_K", std::invalid_argument);
}

TEST_CASE("generator: its chance is Philox4x32-10" * long_when_sanitized) {
  // Known answers of the authors' Random123 library.
  CHECK(prove::philox({0, 0, 0, 0}, {0, 0}) == std::array<std::uint32_t, 4>{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u});
  constexpr std::uint32_t ones = 0xffffffffu;
  CHECK(prove::philox({ones, ones, ones, ones}, {ones, ones}) ==
        std::array<std::uint32_t, 4>{0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu});
  // Streams of one seed differ by name.
  CHECK(prove::Stream(1, "a").uniform(0) != prove::Stream(1, "b").uniform(0));
  CHECK(prove::Stream(1, "a").uniform(0) != prove::Stream(2, "a").uniform(0));
}

}  // namespace prove_generator_test
