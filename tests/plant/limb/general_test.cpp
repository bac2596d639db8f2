// SPDX-License-Identifier: Apache-2.0
// Limbs of any number of segments and coils: what their parts do to each other, and what they leave alone.
#include <bit>
#include <random>

#include "plant/integrator.h"
#include "sim/simulation.h"
#include "tests/long_when_sanitized.h"
#include "tests/plant/limb/general.h"
#include "tests/plant/limb/limb_with_junctions.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_general_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

constexpr Method methods[] = {Method::cvode, Method::arkode};

// Core states of two_segments: temperatures of A to D, their fractions, angles of base and tip, their velocities.
constexpr std::size_t C = 2, D = 3;
namespace two {
constexpr std::size_t temperature = 0, martensite = 4, angle = 8, angular_velocity = 10, count = 12;
}
// Of three_coils: temperatures of A to C, their fractions, angles about x and y, their velocities.
namespace three {
constexpr std::size_t temperature = 0, martensite = 3, angle = 6, angular_velocity = 8, count = 10;
}

bool same_bits(const std::vector<double>& left, const std::vector<double>& right) {
  return std::ranges::equal(left, right,
                            [](double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); });
}

// Something else at every call, the same everywhere.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : bits_(seed) {}
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(bits_() >> 11) * 0x1p-53); }

 private:
  std::mt19937_64 bits_;
};

std::vector<double> any_state(const Plant& limb, Chance& chance) {
  std::vector<double> y;
  for (const StateInfo& state : limb.states()) {
    const bool warm = state.key.find("temperature") == 0, fraction = state.key.find("martensite") == 0;
    y.push_back(warm ? chance.between(10.0, 120.0) : fraction ? chance.between(0.0, 1.0) : state.scale * chance.between(-1.0, 1.0));
  }
  return y;
}

std::vector<double> any_inputs(const Plant& limb, Chance& chance) {
  std::vector<double> inputs;
  for (std::size_t i = 0; i < limb.system().inputs().size(); ++i) inputs.push_back(chance.between(0.0, 1.0));
  return inputs;
}

// Coils drive in turn; the state at every half second.
std::vector<std::vector<double>> run(const Plant& limb, const std::vector<std::vector<double>>& inputs, Method method) {
  Integrator in_time(limb, Start{}, {.method = method, .relative_tolerance = 1e-9});
  std::vector<std::vector<double>> states;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    in_time.hold(inputs[k]);
    REQUIRE_FALSE(in_time.advance_to(0.5 * static_cast<double>(k + 1)));
    states.push_back(in_time.state());
  }
  return states;
}

}  // namespace

TEST_CASE("general limb: the two-coil limb in format 2 has the rates and readings of format 1, bit for bit, with any effects") {
  const Plant written = plant_of(two_coils);
  Chance chance(4711);
  for (int n = 0; n < 200; ++n) {
    Plant one = default_plant(), other = written;
    for (const ParameterId p : parameters().ids()) {
      if (parameters()[p].declaration.kind != Kind::real) continue;
      const double value = parameters()[p].declaration.typical * chance.between(0.8, 1.2);
      one.set_in_file_units(p, value);
      other.set_in_file_units(other.system().parameter(parameters()[p].key()), value);
    }
    for (const EffectId e : effects().ids()) {
      const bool on = chance.between(0.0, 1.0) < 0.4;
      one.turn(e, on);
      other.turn(other.system().effect(effects()[e].name), on);
    }
    REQUIRE(one.states().size() == other.states().size());
    const std::vector<double> y = any_state(one, chance);
    const Situation given{.time_s = chance.between(0.0, 500.0), .segment_start_s = 1.0, .inputs = any_inputs(one, chance)};
    const auto left = at_one_instant(one, given, y), right = at_one_instant(other, given, y);
    REQUIRE(same_bits(left.rates, right.rates));
    REQUIRE(same_bits(left.reading, right.reading));
    REQUIRE(same_bits({left.stored_heat_J}, {right.stored_heat_J}));
  }
  const std::vector<std::vector<double>> inputs{{0.5, 0.0}, {0.6, 0.0}, {0.6, 0.0}, {0.6, 0.0}, {0.2, 0.3}, {0.0, 0.6}, {0.0, 0.6}};
  for (const Method method : methods) CHECK(run(written, inputs, method) == run(default_plant(), inputs, method));
}

TEST_CASE("general limb: two segments in series have the rates of two single limbs, and heat in one is none in the other") {
  const Plant pair = plant_of(two_segments), single = default_plant();
  Chance chance(7);
  for (int n = 0; n < 100; ++n) {
    const std::vector<double> y = any_state(pair, chance), inputs = any_inputs(pair, chance);
    const auto both = at_one_instant(pair, {.inputs = inputs}, y);
    for (const std::size_t s : {0, 1}) {
      const auto alone = at_one_instant(single, {.inputs = {inputs[2 * s], inputs[2 * s + 1]}},
                                        {y[2 * s], y[2 * s + 1], y[two::martensite + 2 * s], y[two::martensite + 2 * s + 1],
                                         y[two::angle + s], y[two::angular_velocity + s]});
      for (const std::size_t j : coils) {
        CHECK(both.rates[2 * s + j] == alone.rates[j]);
        CHECK(both.rates[two::martensite + 2 * s + j] == alone.rates[core_state::martensite + j]);
      }
      CHECK(both.rates[two::angle + s] == alone.rates[core_state::angle]);
      CHECK(both.rates[two::angular_velocity + s] == alone.rates[core_state::angular_velocity]);
    }
  }
}

TEST_CASE("general limb: over time each of two segments bends as a single limb does, and the one that is not driven stays at rest") {
  const Plant pair = plant_of(two_segments), single = default_plant();
  std::vector<std::vector<double>> base_driven, tip_driven, alone;
  for (int k = 0; k < 24; ++k) {
    const double duty = k < 14 ? 0.5 + 0.02 * (k % 3) : 0.0;
    base_driven.push_back({duty, 0.1, 0.0, 0.0});
    tip_driven.push_back({0.0, 0.0, duty, 0.1});
    alone.push_back({duty, 0.1});
  }
  for (const Method method : methods) {
    const auto base = run(pair, base_driven, method), tip = run(pair, tip_driven, method), one = run(single, alone, method);
    double most_rad = 0.0;
    for (std::size_t k = 0; k < one.size(); ++k) {
      // Steps differ, since errors are averaged over more states: 1e-9 a step, over some hundreds of steps.
      CHECK(std::abs(base[k][two::angle] - one[k][core_state::angle]) < 1e-5);
      CHECK(std::abs(tip[k][two::angle + 1] - one[k][core_state::angle]) < 1e-5);
      CHECK(std::abs(base[k][A] - one[k][A]) < 1e-4);
      CHECK(std::abs(tip[k][C] - one[k][A]) < 1e-4);
      CHECK(base[k][C] == 25.0);
      CHECK(base[k][D] == 25.0);
      CHECK(tip[k][A] == 25.0);
      // At rest to what rest() leaves, 1e-13 of a radian.
      CHECK(std::abs(base[k][two::angle + 1]) < 1e-9);
      CHECK(std::abs(tip[k][two::angle]) < 1e-9);
      most_rad = std::max(most_rad, one[k][core_state::angle]);
    }
    CHECK(most_rad > 0.4);
  }
}

TEST_CASE("general limb: readings go by their sensors; a camera sees past the bend sensor's faults, and both carry the offset") {
  Plant limb = plant_of(
      "format: 2\nlimb:\n  segments: [{name: base}, {name: tip}]\n  coils: [{name: A, segment: base, direction_deg: 0}]\n"
      "  channels:\n    - {column: seen_deg, camera: tip}\n    - {column: felt_deg, bend: tip}\n    - {column: t_degC, thermocouple: A}\n"
      "parameters: { angle_offset_tip_deg: 3, angle_offset_base_deg: 50 }\n"
      "effects: { angle_sensor_drift: { rate_deg_s: 0.1 }, thermocouple_heat_sink: { gain: 0.5 } }\n");
  const auto at = at_one_instant(limb, {.time_s = 20.0}, {65.0, 0.5, 0.7, 0.2, 0.0, 0.0, 20.0});
  CHECK(at.reading[0] == by_hand(0.2 + 3.0 * radians_per_degree));
  CHECK(at.reading[1] == by_hand(0.2 + 5.0 * radians_per_degree));
  CHECK(at.reading[2] == by_hand(45.0));  // half-way from 65 to 25
  const std::vector<double> shown = sinew::sim::in_file_units(limb.system(), at.reading);
  CHECK(shown[2] == at.reading[2]);
  CHECK(shown[1] == doctest::Approx(0.2 / radians_per_degree + 5.0).epsilon(1e-13));
}

TEST_CASE("general limb: about two axes, a coil at 0 degrees bends x alone, one at 90 y alone, one at 45 both alike") {
  const auto pulled = [](const char* direction_deg) {
    const Plant limb = plant_of(one_coil_at(direction_deg));
    return at_one_instant(limb, {}, {100.0, 0.0, 0.0, 0.0, 0.0, 0.0});
  };
  const double full_Nm = 0.006 * 9.39;  // by hand: 313 N/m * 30 mm on an arm of 6 mm
  const auto x = pulled("0"), y = pulled("90"), both = pulled("45"), back = pulled("180"), oblique = pulled("30");
  CHECK(x.now.moment_Nm[0] == by_hand(full_Nm));
  CHECK(x.now.moment_Nm[1] == 0.0);
  CHECK(y.now.moment_Nm[0] == 0.0);
  CHECK(y.now.moment_Nm[1] == by_hand(full_Nm));
  CHECK(both.now.moment_Nm[0] == both.now.moment_Nm[1]);
  CHECK(both.now.moment_Nm[0] == by_hand(full_Nm * std::sqrt(0.5)));
  CHECK(back.now.moment_Nm[0] == -x.now.moment_Nm[0]);
  CHECK(oblique.now.moment_Nm[0] == by_hand(full_Nm * std::sqrt(0.75)));
  CHECK(oblique.now.moment_Nm[1] == by_hand(full_Nm * 0.5));
}

TEST_CASE("general limb: a bend stretches a coil by what it shares with it, and does no work on one at a right angle") {
  const Plant limb = plant_of(one_coil_at("30"));
  const auto at = at_one_instant(limb, {}, {25.0, 1.0, 0.5, -0.2, 0.0, 0.0});
  CHECK(at.now.stretch_m[0] == by_hand(0.030 - 0.006 * (0.5 * std::sqrt(0.75) - 0.2 * 0.5)));
  const auto across = at_one_instant(plant_of(one_coil_at("90")), {}, {25.0, 1.0, 0.5, 0.0, 0.0, 0.0});
  CHECK(across.now.stretch_m[0] == 0.030);
  // The moment about an axis is the coil's tension times what a bend about it takes from its stretch.
  for (const char* direction_deg : {"0", "17", "90", "133", "240"}) {
    const Plant any = plant_of(one_coil_at(direction_deg));
    const auto here = at_one_instant(any, {}, {60.0, 0.4, 0.3, 0.1, 0.0, 0.0});
    for (const std::size_t b : {0, 1}) {
      std::vector<double> y{60.0, 0.4, 0.3, 0.1, 0.0, 0.0};
      y[2 + b] += 1.0;
      const double taken_m = here.now.stretch_m[0] - at_one_instant(any, {}, y).now.stretch_m[0];
      CHECK(here.now.moment_Nm[b] ==
            doctest::Approx(here.now.tension_N[0] * taken_m - 0.05 * (b == 0 ? 0.3 : 0.1)).epsilon(1e-12).scale(0.05));
    }
  }
}

TEST_CASE("general limb: three coils at 120 degrees that pull alike do not bend it; one that pulls more bends it its own way") {
  const Plant limb = plant_of(three_coils);
  const std::vector<double> even{70.0, 70.0, 70.0, 0.4, 0.4, 0.4, 0.0, 0.0, 0.0, 0.0};
  const auto balanced = at_one_instant(limb, {.inputs = {0.3, 0.3, 0.3}}, even);
  CHECK(balanced.now.tension_N[0] > 1.0);
  CHECK(balanced.rates[three::angular_velocity] == 0.0);
  CHECK(balanced.rates[three::angular_velocity + 1] == 0.0);
  // And stays so while all three are heated alike.
  for (const Method method : methods) {
    Integrator run(limb, Start{}, {.method = method});
    run.hold({0.5, 0.5, 0.5});
    REQUIRE_FALSE(run.advance_to(10.0));
    CHECK(run.state()[three::martensite] < 0.1);
    CHECK(std::abs(run.state()[three::angle]) < 1e-9);
    CHECK(std::abs(run.state()[three::angle + 1]) < 1e-9);
  }
  // At rest with one of them hot it stands where that one pulls: the direction of (cos, sin) of 120 degrees.
  std::vector<std::optional<double>> hot(three::count);
  hot[1] = 110.0;
  hot[three::martensite + 1] = 0.01;
  const auto y = at_rest(limb, hot);
  CHECK(y[three::angle] < -0.1);
  CHECK(y[three::angle + 1] == doctest::Approx(-std::sqrt(3.0) * y[three::angle]).epsilon(1e-10));
  const auto settled = at_one_instant(limb, {}, y);
  CHECK(std::abs(settled.now.moment_Nm[0]) < 1e-13);
  CHECK(std::abs(settled.now.moment_Nm[1]) < 1e-13);
}

TEST_CASE("general limb: with three coils it does not matter which is which, only where they are") {
  // Turned by 120 degrees: A's part is taken by B. Angles turn with it.
  const Plant limb = plant_of(three_coils);
  const auto at = at_one_instant(limb, {}, {90.0, 40.0, 30.0, 0.1, 0.9, 1.0, 0.0, 0.0, 0.0, 0.0});
  const auto turned = at_one_instant(limb, {}, {30.0, 90.0, 40.0, 1.0, 0.1, 0.9, 0.0, 0.0, 0.0, 0.0});
  const double x = at.now.moment_Nm[0], y = at.now.moment_Nm[1], s = std::sqrt(0.75);
  CHECK(turned.now.moment_Nm[0] == doctest::Approx(-0.5 * x - s * y).epsilon(1e-13));
  CHECK(turned.now.moment_Nm[1] == doctest::Approx(s * x - 0.5 * y).epsilon(1e-13));
}

TEST_CASE("gravity load: on the second of two segments it acts by the angle to the room, the sum of both") {
  Plant limb = plant_of(two_segments);
  std::vector<double> y(two::count, 0.0);
  for (std::size_t j = 0; j < 4; ++j) y[j] = 25.0, y[two::martensite + j] = 1.0;
  y[two::angle] = 0.3;
  y[two::angle + 1] = -0.1;
  const auto without = at_one_instant(limb, {}, y);
  turn_on(limb, "gravity_load", {{"moment_Nm", 0.02}, {"tilt_deg", 30.0}});
  const auto with = at_one_instant(limb, {}, y);
  const double tilt_rad = 30.0 * radians_per_degree;
  CHECK(with.now.moment_Nm[0] - without.now.moment_Nm[0] == doctest::Approx(-0.02 * std::sin(0.3 + tilt_rad)).epsilon(1e-12));
  CHECK(with.now.moment_Nm[1] - without.now.moment_Nm[1] == doctest::Approx(-0.02 * std::sin(0.2 + tilt_rad)).epsilon(1e-12));
  // At rest both balance.
  const auto rest = at_one_instant(limb, {}, at_rest(limb));
  CHECK(std::abs(rest.now.moment_Nm[0]) < 1e-13);
  CHECK(std::abs(rest.now.moment_Nm[1]) < 1e-13);
}

TEST_CASE("cross heating: heat goes between each two coils of one segment and to no other, and none is lost") {
  {
    Plant limb = plant_of(two_segments);
    turn_on(limb, "cross_heating", {{"conductance_W_K", 0.012}});
    // 30 K between A and B, 10 K between D and C, more across segments.
    std::vector<double> y{85.0, 55.0, 30.0, 40.0, 0.2, 0.5, 0.9, 0.8, 0.0, 0.0, 0.0, 0.0};
    const auto with = at_one_instant(limb, {}, y), without = at_one_instant(plant_of(two_segments), {}, y);
    const double expected_W[] = {-0.36, 0.36, 0.12, -0.12};
    double sum_W = 0.0;
    for (std::size_t j = 0; j < 4; ++j) {
      CHECK(with.now.heat_W[j] - without.now.heat_W[j] == doctest::Approx(expected_W[j]).epsilon(1e-12));
      sum_W += with.now.heat_W[j] - without.now.heat_W[j];
    }
    CHECK(std::abs(sum_W) < 1e-14);
    CHECK(with.now.heat_to_surroundings_W == without.now.heat_to_surroundings_W);
  }
  {
    Plant limb = plant_of(three_coils);
    turn_on(limb, "cross_heating", {{"conductance_W_K", 0.01}});
    const std::vector<double> y{85.0, 55.0, 35.0, 0.2, 0.5, 0.9, 0.0, 0.0, 0.0, 0.0};
    const auto with = at_one_instant(limb, {}, y), without = at_one_instant(plant_of(three_coils), {}, y);
    // By hand: A gives 30 K and 50 K, B takes 30 K and gives 20 K, C takes 50 K and 20 K.
    const double expected_W[] = {-0.8, 0.1, 0.7};
    for (std::size_t j = 0; j < 3; ++j) CHECK(with.now.heat_W[j] - without.now.heat_W[j] == doctest::Approx(expected_W[j]).epsilon(1e-12));
  }
}

TEST_CASE("body heat storage: one node a segment, warmed by that segment's coils; over time heat in is heat stored and heat lost") {
  Plant limb = plant_of(two_segments);
  turn_on(limb, "body_heat_storage", {{"conductance_W_K", 0.01}, {"heat_capacity_J_K", 8.0}, {"heat_loss_W_K", 0.05}});
  REQUIRE(limb.states().size() == two::count + 2);
  CHECK(limb.states()[StateId{two::count}].key == "body_heat_storage.temperature_base_degC");
  const std::vector<double> y{85.0, 55.0, 25.0, 45.0, 0.2, 0.5, 1.0, 0.9, 0.0, 0.0, 0.0, 0.0, 35.0, 25.0};
  const auto at = at_one_instant(limb, {}, y);
  // By hand: 0.01 * (50 + 20) - 0.05 * 10 = 0.2 W, and 0.01 * (0 + 20) - 0 = 0.2 W, into 8 J/K.
  CHECK(at.rates[two::count] == by_hand(0.025));
  CHECK(at.rates[two::count + 1] == by_hand(0.025));
  CHECK(at.now.heat_W[C] == 0.0);
  // Stored: what flows in less what flows out, by the rates themselves.
  const Situation heating{.inputs = {0.5, 0.2, 0.0, 0.4}};
  const auto heated = at_one_instant(limb, heating, y);
  double stored_rate_W = 8.0 * (heated.rates[two::count] + heated.rates[two::count + 1]), in_W = 0.0;
  for (std::size_t j = 0; j < 4; ++j) {
    stored_rate_W += 0.85 * heated.rates[j];
    in_W += heated.now.joule_heat_W[j];
  }
  CHECK(in_W == by_hand(1.1 * 49.0 / 2.5));
  CHECK(stored_rate_W == doctest::Approx(in_W - heated.now.heat_to_surroundings_W).epsilon(1e-13));
}

TEST_CASE("general limb: with every effect on, heat in is heat stored and heat lost, at any instant") {
  for (const std::string& text : {two_segments, three_coils}) {
    Plant limb = plant_of(text);
    for (const EffectId e : limb.system().effects().ids()) turn_on_typical(limb, e);
    Chance chance(19);
    for (int n = 0; n < 50; ++n) {
      const std::vector<double> y = any_state(limb, chance);
      const Situation given{.time_s = 3.0, .inputs = any_inputs(limb, chance)};
      const auto at = at_one_instant(limb, given, y);
      // What is stored changes by its derivative along the rates: central differences of a function that is nearly linear.
      const double h = 1e-6;
      const auto stored_J = [&](double by_s) {
        std::vector<double> moved = y;
        for (std::size_t i = 0; i < y.size(); ++i) moved[i] += by_s * at.rates[i];
        return at_one_instant(limb, given, moved).stored_heat_J;
      };
      double in_W = 0.0;
      for (const double heat_W : at.now.joule_heat_W) in_W += heat_W;
      const double change_W = (stored_J(h) - stored_J(-h)) / (2.0 * h);
      CHECK(change_W == doctest::Approx(in_W - at.now.heat_to_surroundings_W).epsilon(1e-5).scale(10.0));
    }
  }
}

TEST_CASE("supply sag: the source feels the currents of all coils") {
  for (const std::string& text : {two_segments, three_coils}) {
    Plant limb = plant_of(text);
    turn_on(limb, "supply_sag", {{"source_resistance_Ohm", 0.25}});
    const std::size_t coils = limb.system().inputs().size();
    std::vector<double> y = at_rest(limb), inputs(coils, 0.5);
    const double volts = 7.0 / (1.0 + 0.25 * static_cast<double>(coils) * 0.2);  // by hand: 0.5 / 2.5 Ohm each
    const auto at = at_one_instant(limb, {.inputs = inputs}, y);
    CHECK(at.now.supply_voltage_V == by_hand(volts));
    for (std::size_t j = 0; j < coils; ++j) CHECK(at.now.joule_heat_W[j] == by_hand(0.2 * volts * volts));
  }
}

TEST_CASE("own values: a part's own act on that part alone, the shared ones on all others") {
  const std::vector<double> y{85.0, 85.0, 85.0, 85.0, 0.5, 0.5, 0.5, 0.5, 0.2, 0.2, 0.1, 0.1};
  const auto with = [&](const std::string& effects) {
    return at_one_instant(plant_of(two_segments + "effects: { " + effects + " }\n"), {}, y);
  };
  const auto without = at_one_instant(plant_of(two_segments), {}, y);

  const auto convection = with("convection_nonlinearity: { slope_1_K: 0.002, C: { slope_1_K: 0.01 } }");
  // By hand: 0.04 W/K * 60 K * (1 + 60 K * slope).
  for (std::size_t j = 0; j < 4; ++j) CHECK(convection.now.heat_W[j] == by_hand(-2.4 * (1.0 + 60.0 * (j == C ? 0.01 : 0.002))));

  const auto stiffening = with("cubic_stiffening: { stiffness_Nm_rad3: 0, tip: { stiffness_Nm_rad3: 0.5 } }");
  CHECK(stiffening.now.moment_Nm[0] == without.now.moment_Nm[0]);
  CHECK(stiffening.now.moment_Nm[1] == doctest::Approx(without.now.moment_Nm[1] - 0.5 * 0.008).epsilon(1e-12));

  std::vector<double> uneven = y;
  uneven[A] = uneven[C] = 95.0;
  const Plant crossing = plant_of(two_segments + "effects: { cross_heating: { conductance_W_K: 0.01, C_D: { conductance_W_K: 0 } } }\n");
  const auto cross = at_one_instant(crossing, {}, uneven), core = at_one_instant(plant_of(two_segments), {}, uneven);
  CHECK(cross.now.heat_W[B] - core.now.heat_W[B] == doctest::Approx(0.1).epsilon(1e-12));
  CHECK(cross.now.heat_W[C] == core.now.heat_W[C]);
  CHECK(cross.now.heat_W[D] == core.now.heat_W[D]);
}

TEST_CASE("own values: of an effect with states and several parameters, in the two-coil limb; lanes of derivatives go by part, too") {
  const Plant limb = plant_of(
      "format: 2\neffects:\n  thermocouple_lag: { time_constant_s: 1.5, B: { time_constant_s: 3 } }\n"
      "  sheath_heat_storage:\n    conductance_W_K: 0.04\n    heat_capacity_J_K: 2\n    heat_loss_W_K: 0.03\n"
      "    A: { conductance_W_K: 0.02, heat_capacity_J_K: 4, heat_loss_W_K: 0 }\n");
  // Beads of A and B, then sheaths of A and B.
  const std::vector<double> y{80.0, 60.0, 0.2, 1.0, 0.0, 0.0, 50.0, 30.0, 30.0, 30.0};
  const auto at = at_one_instant(limb, {}, y);
  CHECK(at.rates[6] == by_hand(20.0));
  CHECK(at.rates[7] == by_hand(10.0));
  CHECK(at.rates[8] == by_hand(0.02 * 50.0 / 4.0));
  CHECK(at.rates[9] == by_hand((0.04 * 30.0 - 0.03 * 5.0) / 2.0));
  const auto& system = limb.system();
  const auto equations = limb.equations_with_derivatives(
      {{system.parameter("thermocouple_lag.time_constant_s"), 0}, {system.parameter("thermocouple_lag.B.time_constant_s"), 1}});
  std::vector<Jet> lifted(y.begin(), y.end()), rates(y.size());
  equations->rates(idle(limb), lifted.data(), rates.data());
  CHECK(rates[6].v[0] == by_hand(-30.0 / 2.25));
  CHECK(rates[6].v[1] == 0.0);
  CHECK(rates[7].v[0] == 0.0);
  CHECK(rates[7].v[1] == by_hand(-30.0 / 9.0));
}

TEST_CASE("own values: an effect is on when any part's strength is not at its null") {
  const Plant limb = plant_of("format: 2\neffects: { latent_heat: { latent_heat_J: 0, B: { latent_heat_J: 15 } } }\n");
  CHECK(limb.is_on(limb.system().effect("latent_heat")));
  const Plant off = plant_of("format: 2\neffects: { latent_heat: { latent_heat_J: 0, B: { latent_heat_J: 0 } } }\n");
  CHECK_FALSE(off.is_on(off.system().effect("latent_heat")));
}

TEST_CASE("own values: plants are equal only where the same part has the same value") {
  const auto plant = [](const char* part, const char* value) {
    return plant_of("format: 2\neffects: { latent_heat: { latent_heat_J: 12, " + std::string(part) + ": { latent_heat_J: " + value +
                    " } } }\n");
  };
  CHECK(plant("A", "15") == plant("A", "15"));
  CHECK_FALSE(plant("A", "15") == plant("A", "16"));
  CHECK_FALSE(plant("A", "15") == plant("B", "15"));
  CHECK_FALSE(plant("A", "15") == default_plant());
}

TEST_CASE("general limb: sensitivities of two segments are what differences say, with values of a part's own" * long_when_sanitized) {
  const std::string text =
      two_segments +
      "effects:\n  cross_heating: { conductance_W_K: 0.01, C_D: { conductance_W_K: 0.02 } }\n"
      "  gravity_load: { moment_Nm: 0.01, tilt_deg: 20 }\n"
      "  viscoelastic_creep: { stiffness_Nm_rad: 0.01, time_constant_s: 4, tip: { stiffness_Nm_rad: 0.02, time_constant_s: 2 } }\n";
  const Plant limb = plant_of(text);
  const auto& system = limb.system();
  SensitivityRequest request;
  // More columns than one pass carries.
  for (const char* key :
       {"supply_voltage_V", "resistance_A_Ohm", "heat_capacity_C_J_K", "heat_loss_D_W_K", "ambient_temperature_degC",
        "heating_midpoint_degC", "austenite_stiffness_N_m", "moment_arm_C_m", "beam_stiffness_base_Nm_rad", "beam_stiffness_tip_Nm_rad",
        "beam_damping_tip_Nms_rad", "angle_offset_tip_deg", "cross_heating.conductance_W_K", "cross_heating.C_D.conductance_W_K",
        "gravity_load.moment_Nm", "gravity_load.tilt_deg", "viscoelastic_creep.stiffness_Nm_rad", "viscoelastic_creep.tip.stiffness_Nm_rad",
        "viscoelastic_creep.tip.time_constant_s"})
    request.parameters.push_back(system.parameter(key));
  std::vector<std::optional<double>> given(limb.states().size());
  given[C] = 40.0;
  given[two::angle] = 0.1;
  request.initial_states = {StateId{C}, StateId{two::angle}};
  REQUIRE(request.columns() > static_cast<std::size_t>(jet_width));

  const auto integrated = [&](const Plant& plant, const std::vector<std::optional<double>>& start, Method method,
                              const SensitivityRequest& of) {
    Integrator run(plant, Start{start, {}}, {.method = method, .relative_tolerance = 1e-11, .most_steps = 1000000}, of);
    run.hold({0.6, 0.0, 0.5, 0.1});
    REQUIRE_FALSE(run.advance_to(3.0));
    run.hold({0.0, 0.4, 0.3, 0.0});
    REQUIRE_FALSE(run.advance_to(6.0));
    return run;
  };
  for (const Method method : methods) {
    const Integrator run = integrated(limb, given, method, request);
    std::vector<double> readings;
    Eigen::MatrixXd of_readings;
    run.readings_with_sensitivity(readings, of_readings);
    REQUIRE(of_readings.rows() == 3);
    REQUIRE(of_readings.cols() == static_cast<Eigen::Index>(request.columns()));
    for (std::size_t column = 0; column < request.columns(); ++column) {
      const bool parameter = column < request.parameters.size();
      const double size = parameter ? system.parameters()[request.parameters[column]].declaration.typical *
                                          system.parameters()[request.parameters[column]].declaration.unit.internal_per_unit
                                    : 1.0;
      const double step = 1e-4 * (size == 0.0 ? 1.0 : size);
      const auto moved = [&](double by) {
        Plant other = limb;
        auto start = given;
        if (parameter)
          other.set(request.parameters[column], other.get(request.parameters[column]) + by);
        else
          *start[request.initial_states[column - request.parameters.size()].index] += by;
        return integrated(other, start, method, {}).readings();
      };
      const auto above = moved(step), below = moved(-step);
      CAPTURE(method);
      CAPTURE(column);
      for (std::size_t c = 0; c < 3; ++c) {
        // As in validation/sensitivity_test.cpp: a fraction that meets its envelope has a corner, and differences see it late.
        const double expected = (above[c] - below[c]) / (2.0 * step), scale = c == 2 ? 1.0 : 0.01;
        const double found = of_readings(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(column));
        CHECK(std::abs(found - expected) * step * 1e4 < 3e-3 * (std::abs(expected) * step * 1e4 + scale));
      }
    }
  }
}

TEST_CASE("general limb: a run of two segments that goes on from a checkpoint ends as the run without one, to the last bit") {
  Plant limb = plant_of(two_segments + "effects: { latent_heat: { latent_heat_J: 12, C: { latent_heat_J: 15 } } }\n");
  turn_on_typical(limb, limb.system().effect("body_heat_storage"));
  turn_on(limb, "input_delay", {{"delay_s", 0.7}});
  for (const Method method : methods) {
    const auto begun = [&] {
      Integrator run(limb, Start{}, {.method = method});
      for (int k = 0; k < 8; ++k) {
        run.hold({0.1 * k, 0.0, 0.5 - 0.05 * k, 0.2});
        REQUIRE_FALSE(run.advance_to(0.5 * (k + 1)));
      }
      run.restart();
      return run;
    };
    const auto finish = [&](Integrator& run) {
      for (int k = 8; k < 20; ++k) {
        run.hold({0.0, 0.05 * k, 0.3, 0.02 * k});
        REQUIRE_FALSE(run.advance_to(0.5 * (k + 1)));
      }
      return run.state();
    };
    Integrator whole = begun(), stopped = begun();
    const Checkpoint checkpoint = stopped.checkpoint();
    CHECK(checkpoint.held_inputs.size() == 4);
    CHECK(checkpoint.commands_under_way.size() == 1);
    Integrator resumed(limb, checkpoint, {.method = method});
    const std::vector<double> expected = finish(whole);
    CHECK(finish(stopped) == expected);
    CHECK(finish(resumed) == expected);
    CHECK(resumed.counters() == whole.counters());
  }
}

TEST_CASE("general limb: where readings are alike at first, what shows none is believed to be no further off") {
  const Plant limb = limb_with_junctions();
  const System& system = limb.system();
  const auto deviations = [&](double temperature_A_degC, double temperature_B_degC) {
    std::vector<double> measured(system.channels().size(), 0.0);
    measured[0] = temperature_A_degC;
    measured[1] = temperature_B_degC;
    std::vector<double> result;
    for (const StartBelief& belief : system.start_beliefs(limb, measured)) result.push_back(belief.deviation);
    return result;
  };
  const double ambient_degC = limb.get(system.parameter("ambient_temperature_degC"));
  const std::vector<double> cold = deviations(ambient_degC, ambient_degC + 0.5), cool = deviations(ambient_degC - 6.0, ambient_degC - 5.0),
                            warm = deviations(ambient_degC + 5.0, ambient_degC + 60.0), unknown = deviations(NAN, NAN);
  std::size_t bodies = 0;
  for (const StateId i : limb.states().ids()) {
    if (limb.states()[i].unit.text != units::degC.text) {
      CHECK(cold[i.index] >= 0.05);
      continue;
    }
    ++bodies;
    CHECK(cold[i.index] == 1.0);
    CHECK(cool[i.index] == 3.0);
    CHECK(warm[i.index] >= 5.0);
    CHECK(warm[i.index] == unknown[i.index]);
  }
  CHECK(bodies == 4);  // two wires, two junctions
}

TEST_CASE("general limb: what is believed of first values, and other starts, are one a state for any shape") {
  for (const std::string& text : {two_segments, three_coils}) {
    const Plant limb = plant_of(text);
    const std::vector<double> measured(limb.system().channels().size(), 0.1);
    CHECK(limb.system().start_beliefs(limb, measured).size() == limb.states().size());
    std::vector<std::optional<double>> start(limb.states().size());
    CHECK(limb.system().other_starts(limb, start).empty());
    start[0] = 65.0;  // of one coil alone: nothing can be said of the others
    CHECK(limb.system().other_starts(limb, start).empty());
    const std::size_t coils = limb.system().inputs().size();
    for (std::size_t j = 0; j < coils; ++j) start[j] = 65.0;
    const auto others = limb.system().other_starts(limb, start);
    CHECK(others.size() == (coils == 3 ? 8 : 2));  // all combinations, or all coils on one branch
    for (const auto& other : others) CHECK(other.size() == coils);
    // A cold loop is open by less than a hundredth, which shows in the angle; far below it is closed.
    for (std::size_t j = 0; j < coils; ++j) start[j] = 25.0;
    CHECK(limb.system().other_starts(limb, start).size() == others.size());
    for (std::size_t j = 0; j < coils; ++j) start[j] = -20.0;
    CHECK(limb.system().other_starts(limb, start).empty());
  }
}

}  // namespace plant_limb_general_test
