// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/shape.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>

#include "plant/limb/limb.h"

namespace plant_limb_shape_test {

using namespace sinew::plant;

namespace {

// Descriptions by hand: a word, a list, a map. Paths are given from the root by `placed`.
Description word(std::string text) {
  return {.kind = Description::Kind::scalar, .path = "", .scalar = std::move(text), .map = {}, .list = {}};
}
Description list(std::vector<Description> values) {
  return {.kind = Description::Kind::list, .path = "", .scalar = "", .map = {}, .list = std::move(values)};
}
Description map(std::vector<Description::Entry> values) {
  return {.kind = Description::Kind::map, .path = "", .scalar = "", .map = std::move(values), .list = {}};
}
// As in a file: "limb", "limb.coils", "limb.coils[1]", "limb.coils[1].segment".
Description placed(Description at, const std::string& path = "limb") {
  at.path = path;
  for (auto& [key, value] : at.map) value = placed(value, path + "." + key);
  for (std::size_t i = 0; i < at.list.size(); ++i) at.list[i] = placed(at.list[i], path + "[" + std::to_string(i) + "]");
  return at;
}

Description segment(const std::string& name, const std::string& axes = "1") { return map({{"name", word(name)}, {"axes", word(axes)}}); }
Description coil(const std::string& name, const std::string& on, const std::string& direction_deg) {
  return map({{"name", word(name)}, {"segment", word(on)}, {"direction_deg", word(direction_deg)}});
}
Description thermocouple(const std::string& column, const std::string& on) {
  return map({{"column", word(column)}, {"thermocouple", word(on)}});
}
Description bend(const std::string& column, const std::string& on) { return map({{"column", word(column)}, {"bend", word(on)}}); }
Description bend(const std::string& column, const std::string& on, const std::string& axis) {
  return map({{"column", word(column)}, {"bend", word(on)}, {"axis", word(axis)}});
}

// Mutable pieces of a limb.
struct Parts {
  std::vector<Description> segments, coils, channels;
  Description limb() const { return placed(map({{"segments", list(segments)}, {"coils", list(coils)}, {"channels", list(channels)}})); }
};

Parts two_coil_parts() {
  return {{segment("limb")},
          {coil("A", "limb", "0"), coil("B", "limb", "180")},
          {thermocouple("temperature_A_degC", "A"), thermocouple("temperature_B_degC", "B"), bend("angle_deg", "limb")}};
}
Parts three_coil_parts() {
  return {{segment("arm", "2")},
          {coil("A", "arm", "0"), coil("B", "arm", "120"), coil("C", "arm", "240")},
          {bend("angle_x_deg", "arm", "x"), bend("angle_y_deg", "arm", "y"), thermocouple("temperature_C_degC", "C")}};
}
Parts two_segment_parts() {
  return {{segment("base"), segment("tip")},
          {coil("A", "base", "0"), coil("B", "base", "180"), coil("C", "tip", "0"), coil("D", "tip", "180")},
          {map({{"column", word("angle_base_deg")}, {"camera", word("base")}}), bend("angle_tip_deg", "tip")}};
}

std::shared_ptr<const LimbSystem> limb_of(const Parts& parts) {
  return std::make_shared<const LimbSystem>(shape_of(parts.limb()), std::vector<OwnValues>{});
}

// "limb.coils[1].segment: no such segment; there are limb"
std::string error_of(const Description& limb) {
  try {
    shape_of(limb);
  } catch (const DescriptionError& error) {
    return error.path + ": " + error.what();
  }
  return "nothing was thrown";
}
std::string error_of(const Parts& parts) { return error_of(parts.limb()); }

template <class List, class Name>
std::vector<std::string> names_in(const List& all, Name&& name) {
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(name(one));
  return names;
}
using Names = std::vector<std::string>;

Names input_columns(const System& system) {
  return names_in(system.inputs(), [](const auto& i) { return i.column; });
}
Names channel_columns(const System& system) {
  return names_in(system.channels(), [](const auto& c) { return c.column; });
}
Names core_keys(const System& system) {
  Names keys;
  for (const ParameterInfo& info : system.parameters())
    if (!info.effect) keys.push_back(info.key());
  return keys;
}
Names state_keys(const System& system, const std::vector<std::string>& effects = {}) {
  EffectsOn on(system.effects().size(), false);
  for (const std::string& name : effects) on[system.effect(name).index] = true;
  return names_in(system.states(on), [](const auto& s) { return s.key; });
}
std::size_t count_of(const Names& names, const std::string& part) {
  std::size_t count = 0;
  for (const std::string& name : names) count += name.find(part) != std::string::npos;
  return count;
}

double cosine(const Shape& shape, std::size_t coil, std::size_t bend) {
  for (const Shape::Coupling& one : shape.couplings)
    if (one.coil == coil && one.bend == bend) return one.cosine;
  return 0.0;
}

}  // namespace

TEST_CASE("shape: the two-coil limb as a description is composed like that of format 1") {
  const Shape described = shape_of(two_coil_parts().limb()), built_in = two_coil_shape();
  CHECK_FALSE(described.is_two_coil_limb);
  CHECK(built_in.is_two_coil_limb);
  CHECK(yaml_of(described) == yaml_of(built_in));
  const auto one = limb_of(two_coil_parts());
  CHECK(core_keys(*one) == core_keys(*two_coil_limb()));
  CHECK(state_keys(*one, {"thermocouple_lag", "body_heat_storage"}) ==
        state_keys(*two_coil_limb(), {"thermocouple_lag", "body_heat_storage"}));
  CHECK(input_columns(*one) == input_columns(*two_coil_limb()));
  CHECK(channel_columns(*one) == channel_columns(*two_coil_limb()));
  CHECK(one->entries().size() == two_coil_limb()->entries().size());
  CHECK(one->variables().size() == two_coil_limb()->variables().size());
  CHECK(two_coil_limb()->structure_yaml().empty());
  CHECK(one->structure_yaml() == yaml_of(described));
}

TEST_CASE("shape: three coils around a segment with two axes") {
  const Shape shape = shape_of(three_coil_parts().limb());
  REQUIRE(shape.bends.size() == 2);
  CHECK(shape.bends[0].name == "x");
  CHECK(shape.bends[1].name == "y");
  CHECK(shape.pairs.size() == 3);
  CHECK(shape.coils_of == std::vector<std::vector<std::size_t>>{{0, 1, 2}});
  CHECK(shape.bends_before == std::vector<std::vector<std::size_t>>{{0}, {1}});
  // By hand: cosines of 0, 120, 240 degrees, and of these less 90. A is at a right angle to y: no coupling at all.
  CHECK(shape.couplings.size() == 5);
  CHECK(cosine(shape, 0, 0) == 1.0);
  CHECK(cosine(shape, 0, 1) == 0.0);
  CHECK(cosine(shape, 1, 0) == -0.5);
  CHECK(cosine(shape, 2, 0) == -0.5);
  CHECK(cosine(shape, 1, 1) == doctest::Approx(std::sqrt(0.75)).epsilon(1e-15));
  CHECK(cosine(shape, 2, 1) == -cosine(shape, 1, 1));

  const auto limb = limb_of(three_coil_parts());
  CHECK(input_columns(*limb) == Names{"duty_A", "duty_B", "duty_C"});
  CHECK(channel_columns(*limb) == Names{"angle_x_deg", "angle_y_deg", "temperature_C_degC"});
  CHECK(state_keys(*limb) == Names{"temperature_A_degC", "temperature_B_degC", "temperature_C_degC", "martensite_A_fraction",
                                   "martensite_B_fraction", "martensite_C_fraction", "angle_x_rad", "angle_y_rad",
                                   "angular_velocity_x_rad_s", "angular_velocity_y_rad_s"});
  // One value a coil, one a bend, and no infix where there is one segment.
  const Names keys = core_keys(*limb);
  CHECK(count_of(keys, "heat_loss_") == 3);
  CHECK(count_of(keys, "angle_offset_") == 2);
  CHECK(limb->find_parameter("angle_offset_y_deg"));
  CHECK(limb->find_parameter("bend_sign_x"));
  CHECK(limb->find_parameter("beam_stiffness_Nm_rad"));
  // Effects have states for what they act on: a thermocouple on C alone, both bends, the one body.
  const Names with = state_keys(*limb, {"thermocouple_lag", "viscoelastic_creep", "body_heat_storage"});
  CHECK(Names(with.begin() + 10, with.end()) == Names{"thermocouple_lag.temperature_C_degC", "body_heat_storage.temperature_degC",
                                                      "viscoelastic_creep.angle_x_rad", "viscoelastic_creep.angle_y_rad"});
}

TEST_CASE("shape: two segments in series with two coils each") {
  const Shape shape = shape_of(two_segment_parts().limb());
  CHECK(shape.segment_names == Names{"base", "tip"});
  REQUIRE(shape.bends.size() == 2);
  CHECK(shape.bends[1].name == "tip");
  CHECK(shape.coils_of == std::vector<std::vector<std::size_t>>{{0, 1}, {2, 3}});
  REQUIRE(shape.pairs.size() == 2);  // no pair across segments
  CHECK(shape.pairs[0].first == 0);
  CHECK(shape.pairs[0].second == 1);
  CHECK(shape.pairs[1].first == 2);
  CHECK(shape.pairs[1].second == 3);
  CHECK(shape.bends_before == std::vector<std::vector<std::size_t>>{{0}, {0, 1}});
  CHECK(shape.couplings.size() == 4);
  CHECK(cosine(shape, 0, 1) == 0.0);
  CHECK(cosine(shape, 3, 1) == -1.0);
  CHECK(shape.thermocouple_coils.empty());
  CHECK(shape.sensor_bends == std::vector<std::size_t>{1});  // a camera is no bend sensor

  const auto limb = limb_of(two_segment_parts());
  CHECK(input_columns(*limb) == Names{"duty_A", "duty_B", "duty_C", "duty_D"});
  CHECK(limb->inputs()[InputId{2}].name == "C");
  const Names keys = core_keys(*limb);
  for (const char* key : {"beam_stiffness_base_Nm_rad", "beam_damping_tip_Nms_rad", "beam_inertia_tip_kgm2", "angle_offset_base_deg",
                          "bend_sign_tip", "moment_arm_D_m", "heat_capacity_C_J_K"})
    CHECK(count_of(keys, key) == 1);
  const Names with = state_keys(*limb, {"body_heat_storage", "angle_sensor_lag"});
  CHECK(Names(with.begin() + 12, with.end()) ==
        Names{"body_heat_storage.temperature_base_degC", "body_heat_storage.temperature_tip_degC", "angle_sensor_lag.angle_tip_rad"});
  // Every equation and every reading may be pushed: the air, four wires twice, two beams, two angles.
  CHECK(limb->entries().size() == 1 + 4 + 4 + 2 + 2);
  for (const Entry& entry : limb->entries()) {
    if (entry.state) CHECK(entry.state->index < state_keys(*limb).size());
    if (entry.channel) CHECK(entry.channel->index < 2);
    for (const VariableId v : entry.may_depend_on) CHECK(v.index < limb->variables().size());
  }
  // A controller of the tip's angle knows C and D, and their senses.
  REQUIRE(limb->drives().size() == 4);
  CHECK(limb->drives()[3].channel == ChannelId{1});
  CHECK(limb->drives()[3].input == InputId{3});
  CHECK(limb->drives()[3].sense == -1.0);
}

TEST_CASE("shape: segments with one axis and with two, in series; angles add up axis by axis") {
  const Parts parts{{segment("a", "2"), segment("b"), segment("c", "2")},
                    {coil("A", "a", "0"), coil("B", "b", "0"), coil("C", "c", "90")},
                    {bend("c_y_deg", "c", "y"), bend("c_x_deg", "c", "x"), bend("b_deg", "b"), bend("b_again_deg", "b", "x")}};
  const Shape shape = shape_of(parts.limb());
  CHECK(names_in(shape.bends, [](const auto& b) { return b.name; }) == Names{"a_x", "a_y", "b", "c_x", "c_y"});
  CHECK(shape.bends_before == std::vector<std::vector<std::size_t>>{{0}, {1}, {0, 2}, {0, 2, 3}, {1, 4}});
  CHECK(shape.sensor_bends == std::vector<std::size_t>{4, 3, 2});  // each once
  CHECK(shape.sensors[0].part == 4);
  CHECK(shape.sensors[3].part == 2);
}

TEST_CASE("shape: couplings are exact at right angles, whatever way the direction is written") {
  struct Case {
    const char* direction_deg;
    double x, y;
  };
  for (const auto& [direction_deg, x, y] : {Case{"0", 1, 0},
                                            {"90", 0, 1},
                                            {"180", -1, 0},
                                            {"270", 0, -1},
                                            {"-90", 0, -1},
                                            {"-180", -1, 0},
                                            {"360", 1, 0},
                                            {"-360", 1, 0},
                                            {"-270", 0, 1},
                                            {"9e1", 0, 1}}) {
    CAPTURE(direction_deg);
    const Shape shape = shape_of(Parts{{segment("arm", "2")}, {coil("A", "arm", direction_deg)}, {bend("x_deg", "arm", "x")}}.limb());
    CHECK(shape.couplings.size() == 1);  // none is kept for what is at a right angle
    CHECK(cosine(shape, 0, 0) == x);
    CHECK(cosine(shape, 0, 1) == y);
  }
}

TEST_CASE("shape: opposite coils couple by the same size to the last bit, at any direction, and 45 degrees to both axes alike") {
  for (int degrees = 0; degrees < 180; ++degrees) {
    const Shape shape = shape_of(Parts{
        {segment("arm", "2")},
        {coil("A", "arm", std::to_string(degrees)), coil("B", "arm", std::to_string(degrees + 180))},
        {bend("x_deg", "arm", "x")}}.limb());
    CAPTURE(degrees);
    CHECK(cosine(shape, 0, 0) == -cosine(shape, 1, 0));
    CHECK(cosine(shape, 0, 1) == -cosine(shape, 1, 1));
    CHECK(cosine(shape, 0, 0) == doctest::Approx(std::cos(degrees * 0.017453292519943295)).epsilon(1e-14).scale(1.0));
    CHECK(cosine(shape, 0, 1) == doctest::Approx(std::sin(degrees * 0.017453292519943295)).epsilon(1e-14).scale(1.0));
    if (degrees == 45) CHECK(cosine(shape, 0, 0) == cosine(shape, 0, 1));
  }
}

TEST_CASE("shape: what is written has every part, and a number in its shortest form") {
  Parts parts = three_coil_parts();
  parts.coils[1] = coil("B", "arm", "117.5");
  CHECK(yaml_of(shape_of(parts.limb())) ==
        "limb:\n  segments:\n    - {name: arm, axes: 2}\n  coils:\n"
        "    - {name: A, segment: arm, direction_deg: 0}\n    - {name: B, segment: arm, direction_deg: 117.5}\n"
        "    - {name: C, segment: arm, direction_deg: 240}\n  channels:\n    - {column: angle_x_deg, bend: arm, axis: x}\n"
        "    - {column: angle_y_deg, bend: arm, axis: y}\n    - {column: temperature_C_degC, thermocouple: C}\n");
}

TEST_CASE("shape: the defaults of a segment's axes and of a coil's segment") {
  const Parts parts{{map({{"name", word("limb")}})},
                    {map({{"name", word("A")}, {"direction_deg", word("0")}})},
                    {thermocouple("t_degC", "A")}};
  const Shape shape = shape_of(parts.limb());
  CHECK(shape.segments[0].axes == 1);
  CHECK(shape.coils[0].segment == 0);
}

TEST_CASE("shape: a limb that is no map, or lacks a list, is an error at the limb") {
  CHECK(error_of(placed(word("two coils"))) == "limb: must be a map: segments, coils, channels");
  CHECK(error_of(placed(Description{})) == "limb: must be a map: segments, coils, channels");
  const Parts all = two_coil_parts();
  CHECK(error_of(placed(map({{"coils", list(all.coils)}, {"channels", list(all.channels)}}))) ==
        "limb: needs `segments`: [{name: limb, axes: 1}]");
  CHECK(error_of(placed(map({{"segments", list(all.segments)}, {"channels", list(all.channels)}}))) ==
        "limb: needs `coils`: [{name: A, segment: limb, direction_deg: 0}]");
  CHECK(error_of(placed(map({{"segments", list(all.segments)}, {"coils", list(all.coils)}}))) ==
        "limb: needs `channels`: [{column: temperature_A_degC, thermocouple: A}]");
}

TEST_CASE("shape: an unknown key is an error at the key, with those that may stand there") {
  const Parts all = two_coil_parts();
  CHECK(error_of(placed(
            map({{"segments", list(all.segments)}, {"coils", list(all.coils)}, {"channels", list(all.channels)}, {"wires", word("2")}}))) ==
        "limb.wires: unknown key; may stand here: channels, coils, segments");
  Parts parts = two_coil_parts();
  parts.segments[0].map.emplace_back("length_m", word("0.1"));
  CHECK(error_of(parts) == "limb.segments[0].length_m: unknown key; may stand here: axes, name");
  parts = two_coil_parts();
  parts.coils[1].map.emplace_back("radius_m", word("0.006"));
  CHECK(error_of(parts) == "limb.coils[1].radius_m: unknown key; may stand here: direction_deg, name, segment");
  parts = two_coil_parts();
  parts.channels[2].map.emplace_back("noise_deg", word("1"));
  CHECK(error_of(parts) == "limb.channels[2].noise_deg: unknown key; may stand here: axis, bend, camera, column, thermocouple");
}

TEST_CASE("shape: empty lists, and what is no list, are errors") {
  for (const char* key : {"segments", "coils", "channels"}) {
    for (const Description& wrong : {list({}), word("none"), map({}), Description{}}) {
      Description limb = two_coil_parts().limb();
      for (auto& [name, value] : limb.map)
        if (name == key) value = wrong;
      CHECK(error_of(placed(limb)).starts_with("limb." + std::string(key) + ": must be a list of at least one: "));
    }
  }
  Parts parts = two_coil_parts();
  parts.coils[0] = word("A");
  CHECK(error_of(parts) == "limb.coils[0]: must be a map: {name: A, segment: limb, direction_deg: 0}");
}

TEST_CASE("shape: names are there, are letters, digits and underscores, and stand once") {
  Parts parts = two_coil_parts();
  parts.segments[0].map.erase(parts.segments[0].map.begin());
  CHECK(error_of(parts) == "limb.segments[0]: needs `name`: that coils and channels refer to");
  parts = two_coil_parts();
  parts.coils[1].map.erase(parts.coils[1].map.begin());
  CHECK(error_of(parts) == "limb.coils[1]: needs `name`: parameters and columns have it in theirs");
  parts = two_coil_parts();
  parts.channels[0].map.erase(parts.channels[0].map.begin());
  CHECK(error_of(parts) == "limb.channels[0]: needs `column`: in recordings");
  for (const char* wrong : {"", "left coil", "A.B", "\xc3\xa4", "a,b", "01234567890123456789012345678901234567890"}) {
    parts = two_coil_parts();
    parts.coils[1] = coil(wrong, "limb", "180");
    CHECK(error_of(parts) == "limb.coils[1].name: a name is up to 40 letters, digits and underscores");
  }
  parts = two_coil_parts();
  parts.coils[1] = coil("A", "limb", "180");
  CHECK(error_of(parts) == "limb.coils[1].name: this name stands twice");
  parts = two_segment_parts();
  parts.segments[1] = segment("base");
  CHECK(error_of(parts) == "limb.segments[1].name: this name stands twice");
  parts = two_coil_parts();
  parts.channels[1] = thermocouple("temperature_A_degC", "B");
  CHECK(error_of(parts) == "limb.channels[1].column: this name stands twice");
}

TEST_CASE("shape: names that are put together must be apart, too") {
  const Parts bends{{segment("base", "2"), segment("base_x")}, {coil("A", "base", "0")}, {thermocouple("t_degC", "A")}};
  CHECK(error_of(bends) == "limb.segments[1].name: another segment's axis is called base_x, too");
  const Parts pairs{{segment("limb")},
                    {coil("A", "limb", "0"), coil("B_C", "limb", "90"), coil("A_B", "limb", "180"), coil("C", "limb", "270")},
                    {thermocouple("t_degC", "A")}};
  CHECK(error_of(pairs) == "limb.coils[3].name: another pair of coils is called A_B_C, too");
  Parts columns = two_coil_parts();
  columns.coils[0] = coil("A_deg", "limb", "0");
  columns.channels = {bend("duty_A_deg", "limb")};
  CHECK(error_of(columns) == "limb.channels[0].column: is the column of a coil's duty");
  columns = two_coil_parts();
  columns.channels = {thermocouple("tip_degC", "A"), bend("tip_deg", "limb")};
  CHECK(error_of(columns) == "limb.channels[1].column: must differ from the other columns in more than its unit");
}

TEST_CASE("shape: a segment bends about one axis or two") {
  for (const char* wrong : {"0", "3", "two", "1.0", "-1", ""}) {
    Parts parts = two_coil_parts();
    parts.segments[0] = segment("limb", wrong);
    CHECK(error_of(parts) == "limb.segments[0].axes: a segment bends about 1 axis or 2");
  }
}

TEST_CASE("shape: a coil is on a segment that exists, and says on which where there are several") {
  Parts parts = two_coil_parts();
  parts.coils[1] = coil("B", "arm", "180");
  CHECK(error_of(parts) == "limb.coils[1].segment: no such segment; there are limb");
  parts = two_segment_parts();
  parts.coils[2] = map({{"name", word("C")}, {"direction_deg", word("0")}});
  CHECK(error_of(parts) == "limb.coils[2]: needs `segment`: the one that this coil bends");
  parts.coils[2] = coil("C", "top", "0");
  CHECK(error_of(parts) == "limb.coils[2].segment: no such segment; there are base, tip");
}

TEST_CASE("shape: a coil has a direction, a number of degrees") {
  Parts parts = two_coil_parts();
  parts.coils[0] = map({{"name", word("A")}, {"segment", word("limb")}});
  CHECK(error_of(parts) == "limb.coils[0]: needs `direction_deg`: towards which it bends the segment, 0 to 360");
  for (const char* wrong : {"up", "361", "-361", "nan", "inf", "90 deg", ""}) {
    parts.coils[0] = coil("A", "limb", wrong);
    CHECK(error_of(parts) == "limb.coils[0].direction_deg: must be a number from -360 to 360");
  }
}

TEST_CASE("shape: a channel is one of a thermocouple, a bend sensor and a camera, on a part that exists") {
  Parts parts = two_coil_parts();
  parts.channels[2] = map({{"column", word("angle_deg")}});
  CHECK(error_of(parts) == "limb.channels[2]: needs one of thermocouple: COIL, bend: SEGMENT, camera: SEGMENT");
  parts.channels[2] = map({{"column", word("angle_deg")}, {"bend", word("limb")}, {"camera", word("limb")}});
  CHECK(error_of(parts) == "limb.channels[2].camera: a channel is one of thermocouple, bend, camera");
  parts.channels[2] = map({{"column", word("angle_deg")}, {"gyroscope", word("limb")}});
  CHECK(error_of(parts) == "limb.channels[2].gyroscope: unknown key; may stand here: axis, bend, camera, column, thermocouple");
  parts.channels[2] = bend("angle_deg", "A");
  CHECK(error_of(parts) == "limb.channels[2].bend: no such segment; there are limb");
  parts.channels[2] = thermocouple("t_degC", "limb");
  CHECK(error_of(parts) == "limb.channels[2].thermocouple: no such coil; there are A, B");
  parts.channels[2] = map({{"column", word("angle_deg")}, {"camera", word("arm")}});
  CHECK(error_of(parts) == "limb.channels[2].camera: no such segment; there are limb");
}

TEST_CASE("shape: a column ends in its unit") {
  Parts parts = two_coil_parts();
  parts.channels[0] = thermocouple("temperature_A", "A");
  CHECK(error_of(parts) == "limb.channels[0].column: must end in its unit, _degC");
  parts.channels[0] = thermocouple("temperature_A_deg", "A");
  CHECK(error_of(parts) == "limb.channels[0].column: must end in its unit, _degC");
  parts = two_coil_parts();
  parts.channels[2] = bend("angle_degC", "limb");
  CHECK(error_of(parts) == "limb.channels[2].column: must end in its unit, _deg");
}

TEST_CASE("shape: the axis of a sensor is x or y, is there where a segment has two, and not where it has none") {
  Parts parts = three_coil_parts();
  parts.channels[0] = bend("angle_x_deg", "arm", "z");
  CHECK(error_of(parts) == "limb.channels[0].axis: must be x or y");
  parts.channels[0] = bend("angle_x_deg", "arm");
  CHECK(error_of(parts) == "limb.channels[0]: needs `axis`: x or y, since this segment bends about two");
  parts = two_coil_parts();
  parts.channels[2] = bend("angle_deg", "limb", "y");
  CHECK(error_of(parts) == "limb.channels[2].axis: this segment bends about one axis, x");
  parts.channels[2] = bend("angle_deg", "limb", "x");
  CHECK(error_of(parts) == "nothing was thrown");
  parts.channels[0] = map({{"column", word("t_degC")}, {"thermocouple", word("A")}, {"axis", word("x")}});
  CHECK(error_of(parts) == "limb.channels[0].axis: a thermocouple has no axis");
}

TEST_CASE("shape: a limb has at most 64 segments and 256 coils") {
  Parts parts = two_coil_parts();
  for (int s = 1; s < 65; ++s) parts.segments.push_back(segment("s" + std::to_string(s)));
  CHECK(error_of(parts) == "limb.segments: at most 64 segments");
  parts = two_coil_parts();
  for (int j = 2; j < 257; ++j) parts.coils.push_back(coil("c" + std::to_string(j), "limb", "0"));
  CHECK(error_of(parts) == "limb.coils: at most 256 coils");
}

TEST_CASE("shape: values of a part's own need an effect and a part that it acts on") {
  const Shape shape = shape_of(two_segment_parts().limb());
  const auto error = [&](const char* effect, const char* part) -> std::string {
    try {
      LimbSystem(shape, {{"effects.here", effect, part}});
    } catch (const DescriptionError& e) {
      return e.path + ": " + e.what();
    }
    return "nothing was thrown";
  };
  CHECK(error("latent_heat", "C") == "nothing was thrown");
  CHECK(error("cross_heating", "C_D") == "nothing was thrown");
  CHECK(error("gravity_load", "tip") == "nothing was thrown");
  CHECK(error("latent_heat", "E") == "effects.here: no such parameter, and no part that this effect acts on; these are A, B, C, D");
  CHECK(error("cross_heating", "A_C") == "effects.here: no such parameter, and no part that this effect acts on; these are A_B, C_D");
  CHECK(error("supply_sag", "A") == "effects.here: no such parameter, and no part that this effect acts on; these are (the only one)");
  CHECK(error("thermocouple_lag", "A") == "effects.here: no such parameter, and no part that this effect acts on; there is none here");
  CHECK(error("latent_heet", "A") == "effects.here: no such effect");
}

}  // namespace plant_limb_shape_test
