// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/limb.h"

#include <numbers>
#include <stdexcept>

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_limb_test {

using namespace sinew::plant;
using namespace sinew::test;

TEST_CASE("limb: the core's parameters and their values are those of docs/plant.md, in its order of magnitude and unit") {
  // Copied by hand from the table of section 1.
  const std::vector<std::pair<std::string_view, double>> table{
      {"supply_voltage_V", 7.0},       {"resistance_A_Ohm", 2.5},           {"resistance_B_Ohm", 2.5},
      {"heat_capacity_A_J_K", 0.85},   {"heat_capacity_B_J_K", 0.85},       {"heat_loss_A_W_K", 0.040},
      {"heat_loss_B_W_K", 0.040},      {"ambient_temperature_degC", 25.0},  {"heating_midpoint_degC", 75.0},
      {"heating_width_K", 7.0},        {"cooling_midpoint_degC", 60.0},     {"cooling_width_K", 7.0},
      {"transformation_time_s", 0.10}, {"austenite_stiffness_N_m", 313.0},  {"martensite_stiffness_N_m", 113.0},
      {"coil_stretch_m", 0.030},       {"transformation_stretch_m", 0.028}, {"moment_arm_A_m", 0.006},
      {"moment_arm_B_m", 0.006},       {"beam_stiffness_Nm_rad", 0.050},    {"beam_damping_Nms_rad", 0.004},
      {"beam_inertia_kgm2", 2.0e-5},   {"angle_offset_deg", 0.0},           {"bend_sign", 1.0}};
  const Plant limb = default_plant();
  std::size_t of_core = 0;
  for (const ParameterInfo& parameter : parameters()) of_core += !parameter.effect;
  CHECK(of_core == table.size());
  for (const auto& [key, value] : table) {
    INFO(key);
    CHECK(limb.get_in_file_units(parameter_id(key)) == value);
  }
}

TEST_CASE("limb: the catalogue of docs/plant.md is there, effect by effect, parameter by parameter, with its nulls") {
  struct Row {
    std::string_view effect, place;
    std::vector<std::string_view> parameters;  // the strength first
    double null_value;
  };
  // Copied by hand from the table of section 2.
  const std::vector<Row> table{{"thermocouple_lag", "sensor.temperature", {"time_constant_s"}, 0.0},
                               {"thermocouple_heat_sink", "sensor.temperature", {"gain"}, 1.0},
                               {"body_heat_storage", "thermal", {"conductance_W_K", "heat_capacity_J_K", "heat_loss_W_K"}, 0.0},
                               {"cross_heating", "thermal", {"conductance_W_K"}, 0.0},
                               {"latent_heat", "thermal", {"latent_heat_J"}, 0.0},
                               {"convection_nonlinearity", "thermal", {"slope_1_K"}, 0.0},
                               {"airflow_change", "thermal", {"relative_change", "onset_s"}, 0.0},
                               {"ambient_drift", "thermal", {"rate_K_s"}, 0.0},
                               {"resistance_change", "actuation", {"relative_increase"}, 0.0},
                               {"supply_sag", "actuation", {"source_resistance_Ohm"}, 0.0},
                               {"duty_deadband", "actuation", {"threshold_fraction"}, 0.0},
                               {"input_delay", "actuation", {"delay_s"}, 0.0},
                               {"stress_shift", "transformation", {"shift_K_N"}, 0.0},
                               {"fatigue", "transformation", {"loss_per_cycle"}, 0.0},
                               {"minor_loops", "transformation", {"slope_share"}, 0.0},
                               {"r_phase", "transformation", {"share", "midpoint_degC", "width_K"}, 0.0},
                               {"viscoelastic_creep", "mechanics", {"stiffness_Nm_rad", "time_constant_s"}, 0.0},
                               {"dry_friction", "mechanics", {"moment_Nm", "smoothing_rad_s"}, 0.0},
                               {"cubic_stiffening", "mechanics", {"stiffness_Nm_rad3"}, 0.0},
                               {"gravity_load", "mechanics", {"moment_Nm", "tilt_deg"}, 0.0},
                               {"coil_slack", "mechanics", {"enabled"}, 0.0},
                               {"hard_stop", "mechanics", {"stiffness_Nm_rad", "angle_deg"}, 0.0},
                               {"angle_sensor_lag", "sensor.angle", {"time_constant_s"}, 0.0},
                               {"angle_sensor_drift", "sensor.angle", {"rate_deg_s"}, 0.0}};
  CHECK(effects().size() >= table.size());  // the catalogue is open
  for (const Row& row : table) {
    INFO(row.effect);
    const EffectInfo& effect = effects()[effect_id(row.effect)];
    CHECK(effect.place == row.place);
    REQUIRE(effect.parameters.size() == row.parameters.size());
    for (std::size_t k = 0; k < row.parameters.size(); ++k) CHECK(parameters()[effect.parameters[k]].declaration.name == row.parameters[k]);
    CHECK(effect.strength == effect.parameters.front());
    CHECK(parameters()[effect.strength].declaration.null_value == row.null_value);
  }
}

TEST_CASE("limb: what is set in the units of files is read back, and degrees are radians inside") {
  Plant limb = default_plant();
  set_in_file_units(limb, "angle_offset_deg", 30.0);
  CHECK(get(limb, "angle_offset_deg") == by_hand(std::numbers::pi / 6.0));
  set_in_file_units(limb, "angle_sensor_drift.rate_deg_s", -0.18);
  CHECK(get(limb, "angle_sensor_drift.rate_deg_s") == by_hand(-std::numbers::pi / 1000.0));
  set_in_file_units(limb, "hard_stop.angle_deg", 90.0);
  CHECK(get(limb, "hard_stop.angle_deg") == by_hand(std::numbers::pi / 2.0));
  for (const ParameterId p : parameters().ids()) {
    INFO(parameters()[p].key());
    const Range range = parameters()[p].declaration.range;
    for (const double share : {0.0, 0.37, 1.0}) {
      const double value = range.lowest + share * (range.highest - range.lowest);
      limb.set_in_file_units(p, value);
      // Degrees to radians and back rounds twice.
      CHECK(limb.get_in_file_units(p) == doctest::Approx(value).epsilon(4e-16).scale(std::abs(value) + 1e-300));
      // What is written and read again is the same limb, to the bit.
      const double inside = limb.get(p);
      limb.set_in_file_units(p, limb.get_in_file_units(p));
      CHECK(limb.get(p) == inside);
    }
  }
}

TEST_CASE("limb: a parameter is known by its key, and an unknown key is an error that names it") {
  CHECK(parameters()[parameter_id("heat_loss_B_W_K")].key() == "heat_loss_B_W_K");
  CHECK(parameters()[parameter_id("thermocouple_lag.time_constant_s")].key() == "thermocouple_lag.time_constant_s");
  CHECK(parameter_id("thermocouple_lag.time_constant_s") != parameter_id("angle_sensor_lag.time_constant_s"));
  CHECK_THROWS_WITH_AS(parameter_id("time_constant_s"), "no such parameter: time_constant_s", std::out_of_range);
  CHECK_THROWS_WITH_AS(effect_id("thermocuple_lag"), "no such effect: thermocuple_lag", std::out_of_range);
}

TEST_CASE("limb: setting one parameter moves that one alone") {
  for (const ParameterId p : parameters().ids()) {
    Plant limb = default_plant();
    limb.set(p, 1234.5);
    for (const ParameterId other : parameters().ids()) CHECK(limb.get(other) == (other == p ? 1234.5 : default_plant().get(other)));
  }
}

TEST_CASE("limb: two limbs are equal when every value and every switch is") {
  Plant left = default_plant(), right = default_plant();
  CHECK(left == right);
  for (const ParameterId p : parameters().ids()) {
    right = left;
    right.set(p, right.get(p) + 0.5);
    CHECK_FALSE(left == right);
  }
  right = left;
  right.turn(effect_id("coil_slack"), true);
  CHECK_FALSE(left == right);
}

TEST_CASE("limb: an effect is on when its strength is not at its null") {
  Plant limb = default_plant();
  set_in_file_units(limb, "thermocouple_heat_sink.gain", 0.9);
  set_in_file_units(limb, "angle_sensor_drift.rate_deg_s", -0.01);
  set_in_file_units(limb, "coil_slack.enabled", 1.0);
  set_in_file_units(limb, "r_phase.width_K", 9.0);  // no strength
  turn_on(limb, "r_phase");
  limb.turn_on_by_strength();
  for (const EffectId e : effects().ids()) {
    INFO(effects()[e].name);
    const auto name = effects()[e].name;
    CHECK(limb.is_on(e) == (name == "thermocouple_heat_sink" || name == "angle_sensor_drift" || name == "coil_slack"));
  }
}

TEST_CASE("limb: lifted into Jets, equations give the same rates and readings, and derivatives only where they were asked for") {
  Plant limb = default_plant();
  turn_on_typical(limb, effect_id("cross_heating"));
  const std::vector<double> y{80.0, 30.0, 0.2, 0.9, 0.4, 1.5};
  const std::vector<Jet> lifted(y.begin(), y.end());
  const Situation given{.inputs = {0.5, 0.1}};
  const auto equations = limb.equations_with_derivatives({{parameter_id("cross_heating.conductance_W_K"), 2}});
  std::vector<Jet> rates(6), readings(3);
  equations->rates(given, lifted.data(), rates.data());
  equations->readings(lifted.data(), readings.data());
  const auto plain = at_one_instant(limb, given, y);
  for (std::size_t i = 0; i < rates.size(); ++i) {
    CHECK(rates[i].a == plain.rates[i]);
    for (int lane = 0; lane < jet_width; ++lane)
      if (lane != 2) CHECK(rates[i].v[lane] == 0.0);
  }
  CHECK(rates[0].v[2] == by_hand(-50.0 / 0.85));  // by hand: 50 K between the wires
  CHECK(rates[1].v[2] == by_hand(50.0 / 0.85));
  for (std::size_t c = 0; c < readings.size(); ++c) {
    CHECK(readings[c].a == plain.reading[c]);
    CHECK(readings[c].v.isZero(0.0));
  }
}

}  // namespace plant_limb_limb_test
