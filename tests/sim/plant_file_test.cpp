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

#include "sim/text.h"

#ifndef SINEW_SOURCE_DIR
#define SINEW_SOURCE_DIR "."
#endif

namespace fs = std::filesystem;
namespace plant = sinew::plant;
using namespace sinew::sim;

namespace {

plant::Plant read(const std::string& text, const fs::path& folder = ".") {
  return read_plant(parse_yaml(text, "p.yaml"), folder);
}

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
  };
  for (const plant::ParameterId p : parameters.ids())
    if (!parameters[p].effect) give(p);
  for (const auto& effect : limb.system().effects())
    if (chance.unit() < 0.4)
      for (const plant::ParameterId p : effect.parameters) give(p);
  limb.turn_on_by_strength();
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

TEST_CASE("plant file: angles are degrees in the file and radians inside") {
  const plant::Plant limb =
      read("parameters: { angle_offset_deg: 90 }\neffects: { angle_sensor_drift: { rate_deg_s: -0.5 } }\n");
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
  CHECK(reading_error("effects: { coil_slack: { enabled: 1 } }") ==
        "p.yaml:1:35: effects.coil_slack.enabled = 1\n  must be true or false");
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

TEST_CASE("plant file: maps where lists or words stand are errors") {
  CHECK(reading_error("effects: [ thermocouple_lag ]") == "p.yaml:1:10: effects = [ a list ]\n  must be a map");
  CHECK(reading_error("effects: { thermocouple_lag: 1.2 }") ==
        "p.yaml:1:30: effects.thermocouple_lag = 1.2\n  must be a map");
  CHECK(reading_error("parameters: [ 1, 2 ]") == "p.yaml:1:13: parameters = [ a list ]\n  must be a map");
  CHECK(reading_error("parameters: { heat_loss_A_W_K: 0.04 W/K }") ==
        "p.yaml:1:32: parameters.heat_loss_A_W_K = 0.04 W/K\n  must be a number alone; its unit stands in the key");
}

TEST_CASE("plant file: a file of another format is refused") {
  CHECK(read("format: 1\n") == plant::default_plant());
  CHECK(read("format: 2\n") == plant::default_plant());
  CHECK(reading_error("format: 3\nparameters: {}\n") ==
        "p.yaml:1:9: format = 3\n  must be 1 or 2, the formats that this version reads");
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
  CHECK_FALSE(is_on(read("base: lagging.yaml\neffects: { thermocouple_lag: { time_constant_s: 0 } }", folder.path()),
                    "thermocouple_lag"));
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
  CHECK(error_of([&] { read_plant_file(dotted); }) ==
        dotted.string() + ":1:7: base = ./dotted.yaml\n  a plant cannot be its own base");
  const fs::path one = folder.write("one.yaml", "base: two.yaml\n");
  const fs::path two = folder.write("two.yaml", "base: one.yaml\n");
  CHECK(error_of([&] { read_plant_file(one); }) == two.string() + ":1:7: base = one.yaml\n  a plant cannot be its own base");
  // Twice the same base on two ways is no circle.
  folder.write("root.yaml", "parameters: { heat_loss_A_W_K: 0.05 }\n");
  folder.write("left.yaml", "base: root.yaml\n");
  CHECK(value(read("base: left.yaml", folder.path()), "heat_loss_A_W_K") == 0.05);
  CHECK(value(read("base: root.yaml", folder.path()), "heat_loss_A_W_K") == 0.05);
}
