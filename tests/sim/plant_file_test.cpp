// SPDX-License-Identifier: Apache-2.0
#include "sim/plant_file.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <string_view>

#include "plant/laws.h"
#include "sim/text.h"

namespace sim_plant_file_test {

namespace fs = std::filesystem;
namespace plant = sinew::plant;
using namespace sinew::sim;

namespace {

plant::Plant read(const std::string& text, const fs::path& folder = ".") { return read_plant(parse_yaml(text, "p.yaml"), folder); }

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}
std::string reading_error(const std::string& text) {
  return error_of([&] { read(text); });
}

double value(const plant::Plant& limb, std::string_view key) { return limb.get(limb.system().parameter(key)); }
bool is_on(const plant::Plant& limb, std::string_view effect) { return limb.is_on(limb.system().effect(effect)); }

// Parameters and what is on, bit by bit.
bool same_bits(const plant::Plant& left, const plant::Plant& right) {
  const auto same = [](double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); };
  for (const plant::ParameterId p : left.system().parameters().ids())
    if (left.own_deviation(p) != right.own_deviation(p)) return false;
  return std::ranges::equal(left.values(), right.values(), same) && left.on() == right.on();
}

// Bits of std::mt19937_64 are the same everywhere; the standard's distributions are not.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : bits_(seed) {}
  double unit() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  // Mostly anywhere in the range, sometimes its ends, sometimes a number of few digits.
  double in(const plant::Range& range) {
    const double kind = unit();
    if (kind < 0.05) return range.lowest;
    if (kind < 0.1) return range.highest;
    const double anywhere = range.lowest + (range.highest - range.lowest) * unit();
    return kind < 0.2 ? std::clamp(std::round(anywhere), range.lowest, range.highest) : anywhere;
  }

 private:
  std::mt19937_64 bits_;
};

// As if read from a file with any value for every parameter of the core and of any set of effects.
plant::Plant any_limb(Chance& chance) {
  plant::Plant limb = plant::default_plant();
  const auto& parameters = limb.system().parameters();
  const auto give = [&](plant::ParameterId p) {
    const plant::Declaration& declared = parameters[p].declaration;
    double given = chance.in(declared.range);
    if (declared.kind == plant::Kind::sign) given = chance.unit() < 0.5 ? -1.0 : 1.0;
    if (declared.kind == plant::Kind::toggle) given = 1.0;
    if (declared.null_value && given == *declared.null_value) given = declared.typical;
    limb.set_in_file_units(p, given);
    if (!parameters[p].effect && declared.kind == plant::Kind::real && chance.unit() < 0.2)
      limb.set_own_deviation(p, chance.in({0.0, declared.range.highest - declared.range.lowest}) * declared.unit.internal_per_unit);
  };
  for (const plant::ParameterId p : parameters.ids())
    if (!parameters[p].effect) give(p);
  for (const auto& effect : limb.system().effects()) {
    const bool possible = !effect.needs || limb.is_on(*effect.needs);
    if (chance.unit() < 0.4 && possible)
      for (const plant::ParameterId p : effect.parameters) give(p);
    limb.turn_on_by_strength();
  }
  return limb;
}

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("sinew_plant_file_test_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

TEST_CASE("plant file: any limb that is written reads back bit for bit") {
  Chance chance(20221);
  std::size_t effects_on = 0;
  for (int i = 0; i < 1000; ++i) {
    const plant::Plant limb = any_limb(chance);
    for (const bool on : limb.on()) effects_on += on;
    const std::string text = plant_to_yaml(limb);
    const plant::Plant back = read(text);
    if (!same_bits(back, limb)) FAIL(text);
    CHECK(plant_to_yaml(back) == text);
  }
  CHECK(effects_on > 1000);
}

TEST_CASE("plant file: written with a margin it reads back inside another map") {
  Chance chance(7);
  for (int i = 0; i < 20; ++i) {
    const plant::Plant limb = any_limb(chance);
    const YamlValue root = parse_yaml("plant:\n" + plant_to_yaml(limb, 2), "s.yaml");
    CHECK(same_bits(read_plant(*YamlMap(root).find("plant"), "."), limb));
  }
}

TEST_CASE("plant file: laws stand in a list, are on, and read back bit for bit; a base's come first") {
  const std::string moment =
      "laws:\n  - entry: moment\n    argument: angle\n    fading_memory_s: 20\n    knots: [-20, 5, 20]\n    values: [0.001, 0, -0.002]\n";
  const std::string heat =
      "laws:\n  - entry: heat\n    argument: [duty A, duty B]\n    times: [heat of the current A, heat of the current B]\n"
      "    knots: [0, 1]\n    values: [0, -0.25]\n";
  const plant::Plant limb = read("format: 2\n" + moment);
  REQUIRE(limb.system().laws().size() == 1);
  CHECK(limb.system().laws()[0].fading_memory_s == 20.0);
  CHECK(limb.is_on(limb.system().effect("law_1")));
  CHECK(limb.states().size() == plant::default_plant().states().size() + 1);
  const std::string text = plant_file_text(limb);
  CHECK(text.starts_with("format: 2\n"));
  CHECK(read(text) == limb);
  CHECK(plant_file_text(read(text)) == text);

  const Folder folder;
  folder.write("base.yaml", "format: 2\n" + moment);
  const plant::Plant both =
      read("format: 2\nbase: base.yaml\n" + heat + "effects: { latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } } }\n",
           folder.path());
  REQUIRE(both.system().laws().size() == 2);
  CHECK(both.system().laws()[0] == limb.system().laws()[0]);
  CHECK(both.system().laws()[1].factor.size() == 2);
  CHECK(plant_file_text(read(plant_file_text(both))) == plant_file_text(both));
}

TEST_CASE("plant file: a law that cannot be is refused at its place") {
  const auto with = [](const std::string& entry, const std::string& argument, const std::string& knots, const std::string& values) {
    return "format: 2\nlaws:\n  - entry: " + entry + "\n    argument: " + argument + "\n    knots: " + knots + "\n    values: " + values +
           "\n";
  };
  const auto complains = [](const std::string& text, const std::string& place, const std::string& words) {
    const std::string error = reading_error(text);
    CAPTURE(error);
    CHECK(error.find(place) != std::string::npos);
    CHECK(error.find(words) != std::string::npos);
  };
  CHECK_NOTHROW(read(with("moment", "angle", "[0, 1]", "[1, 2]")));
  complains(with("momentum", "angle", "[0, 1]", "[1, 2]"), "p.yaml:3:12", "no such entry; there are heat, transformation");
  complains(with("air", "time", "[0, 1]", "[1, 2]"), "p.yaml:3:12", "no such entry");
  complains(with("moment", "bend", "[0, 1]", "[1, 2]"), "p.yaml:4:15", "no such variable; there are temperature A");
  complains(with("heat", "temperature A", "[0, 1]", "[1, 2]"), "p.yaml:4:15", "needs 2 variables");
  complains(with("moment", "angle", "[0, 0]", "[1, 2]"), "p.yaml:5:16", "above the knot before it");
  complains(with("moment", "angle", "[0]", "[1]"), "p.yaml:5:12", "two knots or more");
  complains(with("moment", "angle", "[0, 1]", "[1, 2, 3]"), "p.yaml:6:13", "as many values as knots: 2");
  complains("format: 2\nlaws: { entry: moment }\n", "p.yaml:2:7", "must be a list of laws");
  complains("format: 1\nlaws: []\n", "p.yaml:2:7", "needs `format: 2`");
  complains("format: 2\nlaws:\n  - entry: moment\n    argumen: angle\n    knots: [0, 1]\n    values: [0, 1]\n", "p.yaml", "argument");
}

TEST_CASE("plant file: angles are degrees in the file and radians inside") {
  const plant::Plant limb = read("parameters: { angle_offset_deg: 90 }\neffects: { angle_sensor_drift: { rate_deg_s: -0.5 } }\n");
  // pi/2, and -0.5 * pi/180; one rounding each.
  CHECK(value(limb, "angle_offset_deg") == doctest::Approx(1.5707963267948966).epsilon(3e-16));
  CHECK(value(limb, "angle_sensor_drift.rate_deg_s") == doctest::Approx(-0.008726646259971648).epsilon(3e-16));
}

TEST_CASE("plant file: whole degrees are written as whole degrees") {
  plant::Plant limb = plant::default_plant();
  const plant::ParameterId tilt = limb.system().parameter("gravity_load.tilt_deg");
  for (int degrees = -180; degrees <= 180; ++degrees) {
    limb.set_in_file_units(tilt, degrees);
    CHECK(parameter_text(limb, tilt) == std::to_string(degrees));
  }
}

TEST_CASE("plant file: a number has its shortest form, a toggle is a word") {
  plant::Plant limb = read("parameters: { heat_loss_A_W_K: 0.0375, beam_inertia_kgm2: 2.5e-5, bend_sign: -1 }");
  const auto text = [&](std::string_view key) { return parameter_text(limb, limb.system().parameter(key)); };
  CHECK(text("heat_loss_A_W_K") == "0.0375");
  CHECK(text("beam_inertia_kgm2") == "2.5e-05");
  CHECK(text("bend_sign") == "-1");
  CHECK(text("coil_slack.enabled") == "false");
  limb = read("effects: { coil_slack: { enabled: true } }");
  CHECK(text("coil_slack.enabled") == "true");
}

TEST_CASE("plant file: what is left out has the default of the paper's limb") {
  CHECK(read("") == plant::default_plant());
  CHECK(read("base: paper_limb\nparameters: {}\neffects: {}\n") == plant::default_plant());
  const plant::Plant limb = read("parameters: { ambient_temperature_degC: 22.5 }");
  CHECK(value(limb, "ambient_temperature_degC") == 22.5);
  CHECK(value(limb, "heat_loss_A_W_K") == 0.040);
  CHECK(value(limb, "supply_voltage_V") == 7.0);
}

TEST_CASE("plant file: the shipped paper_limb is the default") {
  CHECK(read_plant_file(fs::path(SINEW_SOURCE_DIR) / "plant/limbs/paper_limb.yaml") == plant::default_plant());
}

TEST_CASE("plant file: an effect that is named is on with its values, the others are off") {
  const plant::Plant limb = read("effects:\n  viscoelastic_creep: { stiffness_Nm_rad: 0.02, time_constant_s: 25.0 }\n");
  CHECK(value(limb, "viscoelastic_creep.stiffness_Nm_rad") == 0.02);
  CHECK(value(limb, "viscoelastic_creep.time_constant_s") == 25.0);
  for (const plant::EffectId e : limb.system().effects().ids())
    CHECK(limb.is_on(e) == (limb.system().effects()[e].name == "viscoelastic_creep"));
}

TEST_CASE("plant file: a null value turns an effect off") {
  CHECK_FALSE(is_on(read("effects: { thermocouple_lag: { time_constant_s: 0 } }"), "thermocouple_lag"));
  CHECK(is_on(read("effects: { thermocouple_lag: { time_constant_s: 0.1 } }"), "thermocouple_lag"));
  CHECK_FALSE(is_on(read("effects: { thermocouple_heat_sink: { gain: 1.0 } }"), "thermocouple_heat_sink"));
  CHECK(is_on(read("effects: { thermocouple_heat_sink: { gain: 0.99 } }"), "thermocouple_heat_sink"));
  CHECK_FALSE(is_on(read("effects: { airflow_change: { relative_change: 0, onset_s: 10 } }"), "airflow_change"));
  CHECK(plant_to_yaml(read("effects: { airflow_change: { relative_change: 0, onset_s: 10 } }")) == plant_to_yaml(plant::default_plant()));
}

TEST_CASE("plant file: a toggle is true or false") {
  CHECK(is_on(read("effects: { coil_slack: { enabled: true } }"), "coil_slack"));
  CHECK_FALSE(is_on(read("effects: { coil_slack: { enabled: false } }"), "coil_slack"));
  CHECK(reading_error("effects: { coil_slack: { enabled: 1 } }") == "p.yaml:1:35: effects.coil_slack.enabled = 1\n  must be true or false");
}

TEST_CASE("plant file: a sign is 1 or -1") {
  CHECK(value(read("parameters: { bend_sign: -1 }"), "bend_sign") == -1.0);
  CHECK(reading_error("parameters:\n  bend_sign: 0.5\n") == "p.yaml:2:14: parameters.bend_sign = 0.5\n  must be 1 or -1");
  CHECK(reading_error("parameters:\n  bend_sign: 0\n") == "p.yaml:2:14: parameters.bend_sign = 0\n  must be 1 or -1");
}

TEST_CASE("plant file: an unknown effect is an error with the nearest one") {
  CHECK(reading_error("effects:\n  cross_heating: { conductance_W_K: 0.01 }\n  thermocuple_lag: { time_constant_s: 1 }\n") ==
        "p.yaml:3:3: effects.thermocuple_lag\n  no such key here; did you mean thermocouple_lag?\n"
        "  `sinew effects` lists all effects");
}

TEST_CASE("plant file: an unknown parameter is an error with the nearest one") {
  CHECK(reading_error("parameters: { heat_los_A_W_K: 0.04 }") ==
        "p.yaml:1:15: parameters.heat_los_A_W_K\n  no such key here; did you mean heat_loss_A_W_K?\n"
        "  `sinew effects --core` lists the parameters of the core");
  CHECK(reading_error("parameters: { ambient_temperature_K: 298 }") ==
        "p.yaml:1:15: parameters.ambient_temperature_K\n  no such key here; did you mean ambient_temperature_degC?\n"
        "  `sinew effects --core` lists the parameters of the core");
  CHECK(reading_error("effects:\n  thermocouple_lag: { time_constant_ms: 1200 }\n") ==
        "p.yaml:2:23: effects.thermocouple_lag.time_constant_ms\n  no such key here; did you mean time_constant_s?");
  CHECK(reading_error("paramters: {}") == "p.yaml:1:1: paramters\n  no such key here; did you mean parameters?");
}

TEST_CASE("plant file: an effect that is named gives all its parameters") {
  CHECK(reading_error("effects:\n  viscoelastic_creep: { stiffness_Nm_rad: 0.02 }\n") ==
        "p.yaml:2:23: effects.viscoelastic_creep.time_constant_s\n"
        "  is missing: an effect that is named gives all its parameters; time in which it relaxes");
  CHECK(reading_error("effects: { thermocouple_lag: }") ==
        "p.yaml:1:12: effects.thermocouple_lag.time_constant_s\n"
        "  is missing: an effect that is named gives all its parameters; time constant of the bead");
}

TEST_CASE("plant file: a value out of its range is an error with the range, the unit and what turns the effect off") {
  CHECK(reading_error("effects:\n  thermocouple_lag: { time_constant_s: -1.2 }\n") ==
        "p.yaml:2:40: effects.thermocouple_lag.time_constant_s = -1.2\n  must lie in [0, 30] s; 0 turns thermocouple_lag off");
  CHECK(reading_error("effects: { thermocouple_heat_sink: { gain: 1.5 } }") ==
        "p.yaml:1:44: effects.thermocouple_heat_sink.gain = 1.5\n  must lie in [0.2, 1]; 1 turns thermocouple_heat_sink off");
  // Not the parameter that carries the strength, and the core: nothing to turn off.
  CHECK(reading_error("effects: { viscoelastic_creep: { stiffness_Nm_rad: 0.02, time_constant_s: 0 } }") ==
        "p.yaml:1:75: effects.viscoelastic_creep.time_constant_s = 0\n  must lie in [0.05, 5000] s");
  CHECK(reading_error("parameters: { angle_offset_deg: 91 }") ==
        "p.yaml:1:33: parameters.angle_offset_deg = 91\n  must lie in [-90, 90] deg");
}

TEST_CASE("plant file: both ends of every range can be read, and nothing beyond") {
  const plant::Plant limb = plant::default_plant();
  for (const auto& info : limb.system().parameters()) {
    if (info.effect || info.declaration.kind != plant::Kind::real) continue;
    const plant::Declaration& declared = info.declaration;
    const auto text = [&](double v) { return "parameters: { " + std::string(declared.name) + ": " + shortest(v) + " }"; };
    CAPTURE(declared.name);
    CHECK(reading_error(text(declared.range.lowest)) == "nothing was thrown");
    CHECK(reading_error(text(declared.range.highest)) == "nothing was thrown");
    const double beyond = 1e-9 * (declared.range.highest - declared.range.lowest);
    CHECK(reading_error(text(declared.range.lowest - beyond)).find("must lie in [") != std::string::npos);
    CHECK(reading_error(text(declared.range.highest + beyond)).find("must lie in [") != std::string::npos);
  }
}

TEST_CASE("plant file: a value may say how well it is known") {
  const plant::Plant limb =
      read("parameters: { heat_capacity_A_J_K: {value: 0.45, deviation: 0.2}, angle_offset_deg: {value: 3, deviation: 0} }");
  const plant::ParameterId capacity = limb.system().parameter("heat_capacity_A_J_K"), offset = limb.system().parameter("angle_offset_deg");
  CHECK(limb.get(capacity) == 0.45);
  CHECK(limb.deviation(capacity) == 0.2);
  CHECK(limb.deviation(offset) == 0.0);
  CHECK(limb.deviation(limb.system().parameter("heat_capacity_B_J_K")) == 0.4);
  CHECK(limb != read("parameters: { heat_capacity_A_J_K: 0.45, angle_offset_deg: 3 }"));
  const std::string text = plant_to_yaml(limb);
  CHECK(text.find("heat_capacity_A_J_K: {value: 0.45, deviation: 0.2}\n") != std::string::npos);

  // A file that gives the value alone says nothing of how well it is known, whatever its base says.
  const Folder folder;
  folder.write("known.yaml", text);
  const plant::Plant further = read("base: known.yaml\nparameters: { angle_offset_deg: 4 }", folder.path());
  CHECK(further.deviation(capacity) == 0.2);
  CHECK_FALSE(further.own_deviation(offset));

  CHECK(reading_error("parameters: { heat_capacity_A_J_K: {value: 0.45} }")
            .find("parameters.heat_capacity_A_J_K.deviation\n  is missing: one standard deviation") != std::string::npos);
  CHECK(reading_error("parameters: { heat_capacity_A_J_K: {value: 0.45, deviation: -0.1} }") ==
        "p.yaml:1:61: parameters.heat_capacity_A_J_K.deviation = -0.1\n  must lie in [0, 19.95] J/K");
  CHECK(reading_error("parameters: { heat_capacity_A_J_K: {value: 0.45, sd: 0.1} }").find("parameters.heat_capacity_A_J_K") !=
        std::string::npos);
  CHECK(reading_error("parameters: { bend_sign: {value: 1, deviation: 0} }").find("has no deviation") != std::string::npos);
}

TEST_CASE("plant file: a coil may have a value of its own of what coils share") {
  const plant::Plant limb =
      read("format: 2\nparameters: { heating_midpoint_degC: 76, heating_midpoint_B_degC: {value: 68, deviation: 2} }");
  CHECK(value(limb, "heating_midpoint_degC") == 76.0);
  CHECK(value(limb, "heating_midpoint_B_degC") == 68.0);
  CHECK(limb.deviation(limb.system().parameter("heating_midpoint_B_degC")) == 2.0);
  CHECK_FALSE(limb.system().find_parameter("heating_midpoint_A_degC"));
  CHECK(limb != read("parameters: { heating_midpoint_degC: 76 }"));
  const std::string text = plant_file_text(limb);
  CHECK(text.starts_with("format: 2\n"));
  CHECK(text.find("heating_midpoint_B_degC: {value: 68, deviation: 2}\n") != std::string::npos);
  CHECK(read(text) == limb);

  // Beside an effect's, and in a file whose base has one.
  const Folder folder;
  folder.write("base.yaml", text);
  const plant::Plant further = read(
      "base: base.yaml\nparameters: { coil_stretch_A_m: 0.02 }\neffects: { junction: { heat_capacity_J_K: 0.4, "
      "conductance_W_K: 0.08, relative_power: 0.5, cooling_rate_1_s: 0.02, A: { heat_capacity_J_K: 0.2, "
      "conductance_W_K: 0.08, relative_power: 0.5, cooling_rate_1_s: 0.02 } } }",
      folder.path());
  CHECK(value(further, "heating_midpoint_B_degC") == 68.0);
  CHECK(value(further, "coil_stretch_A_m") == 0.02);
  CHECK(value(further, "junction.A.heat_capacity_J_K") == 0.2);
  CHECK(read(plant_file_text(further)) == further);

  CHECK(reading_error("format: 1\nparameters: { heating_midpoint_B_degC: 68 }").find("needs `format: 2`") != std::string::npos);
  CHECK(reading_error("format: 2\nparameters: { heating_midpoint_C_degC: 68 }").find("did you mean heating_midpoint_A_degC?") !=
        std::string::npos);
  CHECK(reading_error("format: 2\nparameters: { heating_midpoint_B_degC: 680 }").find("must lie in [0, 200]") != std::string::npos);
}

TEST_CASE("plant file: maps where lists or words stand are errors") {
  CHECK(reading_error("effects: [ thermocouple_lag ]") == "p.yaml:1:10: effects = [ a list ]\n  must be a map");
  CHECK(reading_error("effects: { thermocouple_lag: 1.2 }") == "p.yaml:1:30: effects.thermocouple_lag = 1.2\n  must be a map");
  CHECK(reading_error("parameters: [ 1, 2 ]") == "p.yaml:1:13: parameters = [ a list ]\n  must be a map");
  CHECK(reading_error("parameters: { heat_loss_A_W_K: 0.04 W/K }") ==
        "p.yaml:1:32: parameters.heat_loss_A_W_K = 0.04 W/K\n  must be a number alone; its unit stands in the key");
}

TEST_CASE("plant file: a file of another format is refused") {
  CHECK(read("format: 1\n") == plant::default_plant());
  CHECK(read("format: 2\n") == plant::default_plant());
  CHECK(reading_error("format: 3\nparameters: {}\n") == "p.yaml:1:9: format = 3\n  must be 1 or 2, the formats that this version reads");
}

TEST_CASE("plant file: a base gives what the file leaves out, and the file has the last word") {
  const Folder folder;
  folder.write("limbs/warm.yaml",
               "parameters: { ambient_temperature_degC: 30, heat_loss_A_W_K: 0.05 }\n"
               "effects:\n  thermocouple_lag: { time_constant_s: 2 }\n  cross_heating: { conductance_W_K: 0.01 }\n");
  const fs::path file = folder.write("mine.yaml",
                                     "base: limbs/warm.yaml\nparameters: { heat_loss_A_W_K: 0.06 }\n"
                                     "effects:\n  thermocouple_lag: { time_constant_s: 3 }\n"
                                     "  latent_heat: { latent_heat_J: 9 }\n");
  const plant::Plant limb = read_plant_file(file);
  CHECK(value(limb, "ambient_temperature_degC") == 30.0);
  CHECK(value(limb, "heat_loss_A_W_K") == 0.06);
  CHECK(value(limb, "heat_loss_B_W_K") == 0.040);
  CHECK(value(limb, "thermocouple_lag.time_constant_s") == 3.0);
  CHECK(value(limb, "cross_heating.conductance_W_K") == 0.01);
  CHECK(is_on(limb, "cross_heating"));
  CHECK(is_on(limb, "latent_heat"));
}

TEST_CASE("plant file: an effect of the base is turned off by its null") {
  const Folder folder;
  folder.write("lagging.yaml", "effects: { thermocouple_lag: { time_constant_s: 2 } }");
  CHECK(is_on(read("base: lagging.yaml", folder.path()), "thermocouple_lag"));
  CHECK_FALSE(is_on(read("base: lagging.yaml\neffects: { thermocouple_lag: { time_constant_s: 0 } }", folder.path()), "thermocouple_lag"));
}

TEST_CASE("plant file: an effect that acts on what another brings is refused without that one") {
  const std::string junction =
      "  junction: { heat_capacity_J_K: 0.4, conductance_W_K: 0.08, relative_power: 0.5, cooling_rate_1_s: 0.02 }\n";
  const std::string layer = "  junction_layer: { conductance_W_K: 0.03, heat_capacity_J_K: 0.5, heat_loss_W_K: 0.01 }\n";
  const std::string off = "  junction: { heat_capacity_J_K: 0, conductance_W_K: 0.08, relative_power: 0.5, cooling_rate_1_s: 0.02 }\n";
  const std::string words = "\n  junction_layer acts on what junction brings, and junction is off here; switch it on, too";
  const plant::Plant both = read("effects:\n" + layer + junction);
  CHECK(is_on(both, "junction"));
  CHECK(is_on(both, "junction_layer"));
  CHECK(reading_error("effects:\n" + layer) == "p.yaml:2:19: effects.junction_layer = { a map }" + words);
  CHECK(reading_error("effects:\n" + off + layer) == "p.yaml:3:19: effects.junction_layer = { a map }" + words);
  // A layer that is off itself needs nothing.
  CHECK_FALSE(
      is_on(read("effects: { junction_layer: { conductance_W_K: 0, heat_capacity_J_K: 0.5, heat_loss_W_K: 0.01 } }"), "junction_layer"));
  // In a coil that has a junction of its own, too.
  const std::string own_off =
      "  junction: { heat_capacity_J_K: 0.4, conductance_W_K: 0.08, relative_power: 0.5, cooling_rate_1_s: 0.02, "
      "A: { heat_capacity_J_K: 0, conductance_W_K: 0.08, relative_power: 0.5, cooling_rate_1_s: 0.02 } }\n";
  CHECK(reading_error("format: 2\neffects:\n" + own_off + layer) ==
        "p.yaml:4:19: effects.junction_layer = { a map }\n  junction_layer acts on what junction brings, and junction is off at A; switch "
        "it on "
        "there, or junction_layer off");
  const std::string layer_off_at_A =
      "  junction_layer: { conductance_W_K: 0.03, heat_capacity_J_K: 0.5, heat_loss_W_K: 0.01, "
      "A: { conductance_W_K: 0, heat_capacity_J_K: 0.5, heat_loss_W_K: 0.01 } }\n";
  CHECK(is_on(read("format: 2\neffects:\n" + own_off + layer_off_at_A), "junction_layer"));
  // Either may stand in the base; where the file turns the junction off that its base's layer needs, it points at its own effects.
  const Folder folder;
  folder.write("junction.yaml", "effects:\n" + junction);
  folder.write("both.yaml", "effects:\n" + junction + layer);
  CHECK(is_on(read("base: junction.yaml\neffects:\n" + layer, folder.path()), "junction_layer"));
  CHECK(error_of([&] { read("base: both.yaml\neffects:\n" + off, folder.path()); }) == "p.yaml:3:3: effects = { a map }" + words);
}

TEST_CASE("plant file: a base is looked for beside the file that names it, at every step") {
  const Folder folder;
  folder.write("a/first.yaml", "base: ../b/second.yaml\n");
  folder.write("b/second.yaml", "base: third.yaml\n");
  folder.write("b/third.yaml", "parameters: { heat_loss_A_W_K: 0.055 }\n");
  CHECK(value(read("base: a/first.yaml", folder.path()), "heat_loss_A_W_K") == 0.055);
}

TEST_CASE("plant file: an error in a base points into the base") {
  const Folder folder;
  const fs::path base = folder.write("base.yaml", "parameters:\n  heat_loss_A_W_K: 7\n");
  CHECK(error_of([&] { read("base: base.yaml", folder.path()); }) ==
        base.string() + ":2:20: parameters.heat_loss_A_W_K = 7\n  must lie in [0.002, 1] W/K");
}

TEST_CASE("plant file: a base that is not there is an error where it is named") {
  CHECK(reading_error("parameters: {}\nbase: nowhere.yaml\n") ==
        "p.yaml:2:7: base = nowhere.yaml\n  no such file; a base is paper_limb or a plant file, looked for beside this one");
  CHECK(reading_error("base: [ a, b ]\n") == "p.yaml:1:7: base = [ a list ]\n  must be a word");
}

TEST_CASE("plant file: an empty file is an error, a format alone is the paper's limb") {
  const Folder folder;
  const fs::path file = folder.write("empty.yaml", "# nothing yet\n");
  CHECK(error_of([&] { read_plant_file(file); }).find("holds no plant") != std::string::npos);
  CHECK(read_plant_file(folder.write("least.yaml", "format: 1\n")) == plant::default_plant());
}

TEST_CASE("plant file: a plant cannot be its own base, at whatever distance") {
  const Folder folder;
  const fs::path self = folder.write("self.yaml", "base: self.yaml\n");
  CHECK(error_of([&] { read_plant_file(self); }) == self.string() + ":1:7: base = self.yaml\n  a plant cannot be its own base");
  const fs::path dotted = folder.write("dotted.yaml", "base: ./dotted.yaml\n");
  CHECK(error_of([&] { read_plant_file(dotted); }) == dotted.string() + ":1:7: base = ./dotted.yaml\n  a plant cannot be its own base");
  const fs::path one = folder.write("one.yaml", "base: two.yaml\n");
  const fs::path two = folder.write("two.yaml", "base: one.yaml\n");
  CHECK(error_of([&] { read_plant_file(one); }) == two.string() + ":1:7: base = one.yaml\n  a plant cannot be its own base");
  // Twice the same base on two ways is no circle.
  folder.write("root.yaml", "parameters: { heat_loss_A_W_K: 0.05 }\n");
  folder.write("left.yaml", "base: root.yaml\n");
  CHECK(value(read("base: left.yaml", folder.path()), "heat_loss_A_W_K") == 0.05);
  CHECK(value(read("base: root.yaml", folder.path()), "heat_loss_A_W_K") == 0.05);
}

namespace {

// Two segments in series, four coils; names the file's own way.
const std::string robot =
    "format: 2\n"
    "limb:\n"
    "  segments:\n"
    "    - {name: base, axes: 2}\n"
    "    - {name: tip, axes: 1}\n"
    "  coils:\n"
    "    - {name: A, segment: base, direction_deg: 0}\n"
    "    - {name: B, segment: base, direction_deg: 122.5}\n"
    "    - {name: C, segment: tip, direction_deg: 0}\n"
    "    - {name: D, segment: tip, direction_deg: 180}\n"
    "  channels:\n"
    "    - {column: angle_x_deg, camera: base, axis: x}\n"
    "    - {column: angle_y_deg, bend: base, axis: y}\n"
    "    - {column: angle_tip_deg, camera: tip}\n"
    "    - {column: temperature_C_degC, thermocouple: C}\n";

const std::string two_coils_written =
    "limb:\n  segments: [{name: limb, axes: 1}]\n"
    "  coils: [{name: A, segment: limb, direction_deg: 0}, {name: B, segment: limb, direction_deg: 180}]\n"
    "  channels: [{column: temperature_A_degC, thermocouple: A}, {column: angle_deg, bend: limb}]\n";

}  // namespace

TEST_CASE("plant file, format 2: a structure is read, written and read back the same") {
  const plant::Plant limb = read(robot +
                                 "parameters: { heat_loss_D_W_K: 0.05, bend_sign_tip: -1, angle_offset_base_y_deg: 2.5 }\n"
                                 "effects:\n  latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } }\n"
                                 "  gravity_load: { moment_Nm: 0.01, tilt_deg: 29 }\n");
  CHECK(limb.system().inputs().size() == 4);
  CHECK(limb.system().channels().size() == 4);
  CHECK(value(limb, "heat_loss_D_W_K") == 0.05);
  CHECK(value(limb, "bend_sign_tip") == -1.0);
  CHECK(value(limb, "angle_offset_base_y_deg") == doctest::Approx(2.5 * 0.017453292519943295).epsilon(1e-15));
  CHECK(value(limb, "latent_heat.latent_heat_J") == 12.0);
  CHECK(value(limb, "latent_heat.B.latent_heat_J") == 15.0);
  const std::string text = plant_file_text(limb);
  CHECK(text.starts_with(robot + "parameters:\n"));
  CHECK(text.find("  latent_heat:\n    latent_heat_J: 12\n    B:\n      latent_heat_J: 15\n") != std::string::npos);
  const plant::Plant back = read(text);
  CHECK(back == limb);
  CHECK(same_bits(back, limb));
  CHECK(plant_file_text(back) == text);
}

TEST_CASE("plant file, format 2: any values of any structure that are written read back bit for bit") {
  Chance chance(81);
  const std::string own =
      "effects:\n  thermocouple_lag: { time_constant_s: 1, C: { time_constant_s: 2 } }\n"
      "  cubic_stiffening: { stiffness_Nm_rad3: 0.1, tip: { stiffness_Nm_rad3: 0.2 }, base_x: { stiffness_Nm_rad3: 0.3 } }\n";
  const plant::Plant shaped = read(robot + own);
  for (int i = 0; i < 200; ++i) {
    plant::Plant limb = shaped;
    const auto& all = limb.system().parameters();
    for (const plant::ParameterId p : all.ids())
      if (all[p].declaration.kind == plant::Kind::real && (!all[p].effect || limb.is_on(*all[p].effect)))
        limb.set_in_file_units(p, std::nextafter(chance.in(all[p].declaration.range), all[p].declaration.typical));
    const std::string text = plant_file_text(limb);
    const plant::Plant back = read(text);
    if (!same_bits(back, limb)) FAIL(text);
    CHECK(plant_file_text(back) == text);
  }
}

TEST_CASE("plant file, format 2: a file says so where it needs it, and only there") {
  CHECK(plant_file_text(plant::default_plant()).starts_with("format: 1\nparameters:\n"));
  CHECK(plant_file_text(read("effects: { latent_heat: { latent_heat_J: 12 } }")).starts_with("format: 1\n"));
  CHECK(plant_file_text(read("format: 2\neffects: { latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } } }"))
            .starts_with("format: 2\nparameters:"));
  CHECK(plant_file_text(read("format: 2\n" + two_coils_written)).starts_with("format: 2\nlimb:\n"));
  // What is off is not written, and needs nothing.
  const plant::Plant off = read("format: 2\neffects: { latent_heat: { latent_heat_J: 0, B: { latent_heat_J: 0 } } }");
  CHECK(plant_file_text(off).starts_with("format: 1\n"));
}

TEST_CASE("plant file, format 2: the two-coil limb written out is another plant than that of format 1, with the same values") {
  const plant::Plant written = read("format: 2\n" + two_coils_written);
  CHECK_FALSE(written == plant::default_plant());
  CHECK(written.values() == plant::default_plant().values());
  CHECK(read("format: 2\nparameters: {}") == plant::default_plant());
}

TEST_CASE("plant file, format 1: a structure, and values of a part's own, need format 2") {
  CHECK(reading_error("format: 1\n" + two_coils_written).starts_with("p.yaml:3:3: limb = { a map }\n  needs `format: 2`"));
  CHECK(reading_error("format: 1\neffects:\n  latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } }\n") ==
        "p.yaml:3:40: effects.latent_heat.B = { a map }\n  needs `format: 2`");
}

TEST_CASE("plant file, format 2: an error of the structure points at the word that is wrong") {
  CHECK(reading_error("format: 2\nlimb:\n  segments: [{name: arm}]\n  coils:\n    - {name: A, direction_deg: 0}\n"
                      "    - {name: B, segment: leg, direction_deg: 180}\n  channels: [{column: angle_deg, bend: arm}]\n") ==
        "p.yaml:6:26: limb.coils[1].segment = leg\n  no such segment; there are arm");
  CHECK(reading_error("format: 2\nlimb:\n  segments: [{name: arm, axis: 2}]\n  coils: [{name: A, direction_deg: 0}]\n"
                      "  channels: [{column: angle_deg, bend: arm}]\n") ==
        "p.yaml:3:32: limb.segments[0].axis = 2\n  unknown key; may stand here: axes, name");
  CHECK(reading_error("format: 2\nlimb:\n  segments: [{name: arm}]\n  coils: [{name: A, direction_deg: 0}]\n"
                      "  channels: [{column: angle_deg, bend: arm}, {column: angle_deg, camera: arm}]\n") ==
        "p.yaml:5:55: limb.channels[1].column = angle_deg\n  this name stands twice");
  CHECK(reading_error("format: 2\nlimb:\n").find("limb = (nothing)\n  must be a map: segments, coils, channels") != std::string::npos);
  CHECK(reading_error("format: 2\nlimb: {}\n") == "p.yaml:2:7: limb = { a map }\n  needs `segments`: [{name: limb, axes: 1}]");
  // Inside a scenario the path begins with the plant.
  const YamlValue root = parse_yaml("plant:\n  limb: { segments: 1, coils: 2, channels: 3 }\n", "s.yaml");
  CHECK(error_of([&] {
          read_plant(*YamlMap(root).find("plant"), ".");
        }).starts_with("s.yaml:2:21: plant.limb.segments = 1\n  must be a list"));
}

TEST_CASE("plant file, format 2: parameters go by the names of the parts that are there") {
  CHECK(reading_error(robot + "parameters: { beam_stiffness_Nm_rad: 0.05 }\n").find("no such key here; did you mean beam_stiffness_") !=
        std::string::npos);
  CHECK(reading_error(robot + "parameters: { heat_loss_E_W_K: 0.05 }\n").find("no such key here; did you mean heat_loss_") !=
        std::string::npos);
  CHECK(reading_error("format: 2\n" + two_coils_written + "parameters: { heat_loss_B_W_K: 7 }\n") ==
        "p.yaml:6:32: parameters.heat_loss_B_W_K = 7\n  must lie in [0.002, 1] W/K");
}

TEST_CASE("plant file: values of a part's own need a part that the effect acts on") {
  CHECK(reading_error("effects: { latent_heat: { latent_heat_J: 12, C: { latent_heat_J: 15 } } }") ==
        "p.yaml:1:49: effects.latent_heat.C = { a map }\n  no such parameter, and no part that this effect acts on; these are A, B");
  CHECK(reading_error("effects: { cross_heating: { conductance_W_K: 0.01, B_A: { conductance_W_K: 0.02 } } }") ==
        "p.yaml:1:57: effects.cross_heating.B_A = { a map }\n  no such parameter, and no part that this effect acts on; these are A_B");
  CHECK(reading_error("effects: { latent_heet: { latent_heat_J: 12, B: { latent_heat_J: 15 } } }") ==
        "p.yaml:1:12: effects.latent_heet\n  no such key here; did you mean latent_heat?\n  `sinew effects` lists all effects");
  CHECK(reading_error("parametres: {}\neffects: { latent_heet: { B: { latent_heat_J: 15 } } }") ==
        "p.yaml:1:1: parametres\n  no such key here; did you mean parameters?");
}

TEST_CASE("plant file: values of a part's own are complete, known and in their range, beside complete shared ones") {
  CHECK(reading_error("effects:\n  viscoelastic_creep: { stiffness_Nm_rad: 0.02, time_constant_s: 25 }\n"
                      "  sheath_heat_storage:\n    { conductance_W_K: 0.04, heat_capacity_J_K: 2, heat_loss_W_K: 0.03, A: { "
                      "conductance_W_K: 0.02 } }\n") ==
        "p.yaml:4:76: effects.sheath_heat_storage.A.heat_capacity_J_K\n"
        "  is missing: an effect that is named gives all its parameters; heat that warms one sheath by one kelvin");
  CHECK(reading_error("effects: { latent_heat: { B: { latent_heat_J: 15 } } }") ==
        "p.yaml:1:25: effects.latent_heat.latent_heat_J\n"
        "  is missing: an effect that is named gives all its parameters; latent heat of one whole wire");
  CHECK(reading_error("effects: { latent_heat: { latent_heat_J: 12, B: { latent_heet_J: 15 } } }") ==
        "p.yaml:1:51: effects.latent_heat.B.latent_heet_J\n  no such key here; did you mean latent_heat_J?");
  CHECK(reading_error("effects: { latent_heat: { latent_heat_J: 12, B: { latent_heat_J: -1 } } }") ==
        "p.yaml:1:66: effects.latent_heat.B.latent_heat_J = -1\n  must lie in [0, 100] J; 0 turns latent_heat off");
}

TEST_CASE("plant file: a file may give a part of its base values of its own, and keeps those that the base gives") {
  const Folder folder;
  folder.write("base.yaml", robot +
                                "parameters: { heat_loss_C_W_K: 0.055, angle_offset_tip_deg: 7.7 }\n"
                                "effects:\n  latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 15 } }\n"
                                "  gravity_load: { moment_Nm: 0.01, tilt_deg: 29 }\n");
  const plant::Plant base = read("base: base.yaml", folder.path());
  const plant::Plant limb = read(
      "format: 2\nbase: base.yaml\nparameters: { heat_loss_D_W_K: 0.06 }\n"
      "effects:\n  latent_heat: { latent_heat_J: 10, C: { latent_heat_J: 18 } }\n"
      "  thermocouple_lag: { time_constant_s: 1, C: { time_constant_s: 2 } }\n",
      folder.path());
  CHECK(limb.system().structure_yaml() == base.system().structure_yaml());
  CHECK(value(limb, "heat_loss_C_W_K") == 0.055);
  CHECK(value(limb, "heat_loss_D_W_K") == 0.06);
  CHECK(value(limb, "angle_offset_tip_deg") == value(base, "angle_offset_tip_deg"));
  CHECK(value(limb, "gravity_load.tilt_deg") == value(base, "gravity_load.tilt_deg"));
  CHECK(is_on(limb, "gravity_load"));
  CHECK(value(limb, "latent_heat.latent_heat_J") == 10.0);
  CHECK(value(limb, "latent_heat.B.latent_heat_J") == 15.0);
  CHECK(value(limb, "latent_heat.C.latent_heat_J") == 18.0);
  CHECK(value(limb, "thermocouple_lag.C.time_constant_s") == 2.0);
  // A part that has values of its own already is given others.
  const plant::Plant again =
      read("base: base.yaml\neffects: { latent_heat: { latent_heat_J: 12, B: { latent_heat_J: 16 } } }", folder.path());
  CHECK(value(again, "latent_heat.B.latent_heat_J") == 16.0);
  CHECK(plant_file_text(read(plant_file_text(limb))) == plant_file_text(limb));
}

TEST_CASE("plant file: a structure stands in one place, the file or its base") {
  const Folder folder;
  folder.write("base.yaml", robot);
  CHECK(error_of([&] { read("format: 2\nbase: base.yaml\n" + two_coils_written, folder.path()); }) ==
        "p.yaml:4:3: limb = { a map }\n  a plant has its structure from its base; leave out one of the two");
  // An error in values of a base's part points into the file that gives them.
  CHECK(
      error_of([&] { read("base: base.yaml\neffects: { latent_heat: { latent_heat_J: 1, E: { latent_heat_J: 2 } } }", folder.path()); }) ==
      "p.yaml:2:48: effects.latent_heat.E = { a map }\n  no such parameter, and no part that this effect acts on; these are A, B, C, D");
}

}  // namespace sim_plant_file_test
