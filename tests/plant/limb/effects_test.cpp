// SPDX-License-Identifier: Apache-2.0
// What holds for every effect of the list, so that a new one is covered the moment it is listed.
#include "plant/limb/effects.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <random>
#include <set>

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"

namespace plant_limb_effects_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// Bits of std::mt19937_64 are the same everywhere; the standard's distributions are not.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : bits_(seed) {}
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(bits_() >> 11) * 0x1p-53); }

 private:
  std::mt19937_64 bits_;
};

// Another limb each time: every core parameter within a third of its usual value, either sign of bending.
Plant any_limb(Chance& chance) {
  Plant limb = default_plant();
  for (const ParameterId p : parameters().ids()) {
    const Declaration& declared = parameters()[p].declaration;
    if (parameters()[p].effect) continue;
    if (declared.kind == Kind::sign)
      limb.set(p, chance.between(-1.0, 1.0) < 0.0 ? -1.0 : 1.0);
    else
      limb.set(p, limb.get(p) * chance.between(0.67, 1.33));
  }
  return limb;
}

// States from cold to burning hot, on and beside both envelopes, bent up to 60 degrees, moving.
std::vector<double> any_core_state(Chance& chance) {
  return {chance.between(0.0, 150.0),  chance.between(0.0, 150.0), chance.between(-0.01, 1.01),
          chance.between(-0.01, 1.01), chance.between(-1.0, 1.0),  chance.between(-5.0, 5.0)};
}

Situation any_situation(Chance& chance) {
  Situation given{.time_s = chance.between(0.0, 900.0), .inputs = {0.0, 0.0}};
  given.segment_start_s = chance.between(0.0, given.time_s);
  for (const std::size_t j : coils) given.inputs[j] = chance.between(0.0, 1.0) < 0.3 ? 0.0 : chance.between(0.0, 1.0);
  return given;
}

// Adds the states of the effects that are on: anything at all.
std::vector<double> with_own_states(const Plant& limb, std::vector<double> y, Chance& chance) {
  const States layout = limb.states();
  for (std::size_t i = y.size(); i < layout.size(); ++i) y.push_back(layout[StateId{i}].scale * chance.between(-3.0, 3.0));
  return y;
}

void set_to_null(Plant& limb, EffectId effect) {
  const ParameterId strength = effects()[effect].strength;
  limb.set_in_file_units(strength, *parameters()[strength].declaration.null_value);
}

bool same_bits(double left, double right) { return std::bit_cast<std::uint64_t>(left) == std::bit_cast<std::uint64_t>(right); }

// The same rates of the core's states and the same readings, to the last bit.
bool same_as_core(const OneInstant& with, const OneInstant& core) {
  bool same = same_bits(with.reading[angle], core.reading[angle]);
  for (std::size_t i = 0; i < core_state::count; ++i) same = same && same_bits(with.rates[i], core.rates[i]);
  for (const std::size_t j : coils) same = same && same_bits(with.reading[j], core.reading[j]);
  return same;
}

// A minute of jumps in both coils; the states at every half second.
std::vector<std::vector<double>> run(const Plant& limb, Method method) {
  Integrator limb_in_time(limb, Start{}, {.method = method, .relative_tolerance = 1e-7});
  std::vector<std::vector<double>> states;
  for (int tick = 0; tick < 40; ++tick) {
    const double duty = 0.3 + 0.3 * ((tick * 7) % 5) / 4.0;
    limb_in_time.hold(tick < 16 ? std::vector<double>{duty, 0.0} : std::vector<double>{0.0, 0.8 * duty});
    REQUIRE_FALSE(limb_in_time.advance_to(0.5 * (tick + 1)));
    states.push_back(limb_in_time.state());
  }
  return states;
}

// "N*m/rad" as names end in it: "_Nm_rad".
std::string suffix_of(const Unit& unit) {
  std::string suffix = unit.text.empty() ? "" : "_";
  for (const char c : unit.text)
    if (c == '/')
      suffix += '_';
    else if (c != '*' && c != '^')
      suffix += c;
  return suffix;
}

}  // namespace

TEST_CASE("every effect adds exactly nothing at its null value") {
  for (const EffectId e : effects().ids()) {
    Chance chance(4711 + e.index);
    int different = 0;
    for (int n = 0; n < 400; ++n) {
      const Plant core = any_limb(chance);
      Plant limb = core;
      for (const ParameterId p : effects()[e].parameters) {
        const Declaration& declared = parameters()[p].declaration;
        limb.set_in_file_units(p, std::clamp(declared.typical * chance.between(0.5, 1.5), declared.range.lowest, declared.range.highest));
      }
      set_to_null(limb, e);
      limb.turn(e, true);
      const std::vector<double> y = any_core_state(chance);
      const Situation given = any_situation(chance);
      if (!same_as_core(at_one_instant(limb, given, with_own_states(limb, y, chance)), at_one_instant(core, given, y))) ++different;
    }
    INFO(effects()[e].name);
    CHECK(different == 0);
  }
}

TEST_CASE("all effects together add exactly nothing at their null values") {
  Chance chance(8);
  for (int n = 0; n < 400; ++n) {
    const Plant core = any_limb(chance);
    Plant limb = core;
    for (const EffectId every : effects().ids()) limb.turn(every, true);
    const std::vector<double> y = any_core_state(chance);
    const Situation given = any_situation(chance);
    REQUIRE(same_as_core(at_one_instant(limb, given, with_own_states(limb, y, chance)), at_one_instant(core, given, y)));
    REQUIRE(limb.equations()->input_delay_s() == 0.0);
  }
}

TEST_CASE("an effect that is off takes no part, whatever its values") {
  Chance chance(15);
  for (int n = 0; n < 100; ++n) {
    const Plant core = any_limb(chance);
    Plant limb = core;
    for (const EffectId e : effects().ids()) turn_on_typical(limb, e);
    for (const EffectId every : effects().ids()) limb.turn(every, false);
    const std::vector<double> y = any_core_state(chance);
    const Situation given = any_situation(chance);
    REQUIRE(same_as_core(at_one_instant(limb, given, y), at_one_instant(core, given, y)));
    REQUIRE(limb.equations()->switch_times_s().empty());
  }
}

TEST_CASE("a run with every effect named at its null value is the core's run, bit for bit") {
  Plant named = default_plant();
  for (const EffectId e : effects().ids()) {
    turn_on_typical(named, e);
    set_to_null(named, e);
  }
  named.turn_on_by_strength();
  for (const bool on : named.on()) CHECK_FALSE(on);
  for (const Method method : {Method::cvode, Method::arkode}) CHECK(run(named, method) == run(default_plant(), method));
}

TEST_CASE("a run with an effect forced on at its null value is the core's run: to the bit, or to the solver's tolerance") {
  // An effect with states takes part in the choice of steps, so that only its size of error can be promised: the solver is
  // given 1e-7 of each state's scale a step, and the beam is the state that feels the steps most.
  constexpr double solver = 1e-3;
  for (const Method method : {Method::cvode, Method::arkode}) {
    const auto core = run(default_plant(), method);
    for (const EffectId e : effects().ids()) {
      INFO(effects()[e].name);
      Plant limb = default_plant();
      limb.turn(e, true);
      const auto forced = run(limb, method);
      if (limb.states().size() == core_state::count) {
        CHECK(forced == core);
        continue;
      }
      double worst = 0.0;
      for (std::size_t k = 0; k < core.size(); ++k)
        for (std::size_t i = 0; i < core_state::count; ++i) worst = std::max(worst, std::abs(forced[k][i] - core[k][i]));
      CHECK(worst < solver);
    }
  }
}

TEST_CASE("every effect changes a rate, a reading, or the moment at which something happens") {
  for (const EffectId e : effects().ids()) {
    Chance chance(16 + e.index);
    Plant limb = default_plant();
    turn_on_typical(limb, e);
    int different = 0;
    for (int n = 0; n < 400; ++n) {
      const std::vector<double> y = any_core_state(chance);
      const Situation given = any_situation(chance);
      if (!same_as_core(at_one_instant(limb, given, with_own_states(limb, y, chance)), at_one_instant(default_plant(), given, y)))
        ++different;
    }
    const bool other_time = limb.equations()->input_delay_s() > 0.0;
    INFO(effects()[e].name);
    CHECK((different > 0 || other_time));
  }
}

TEST_CASE("every effect vanishes as its strength goes to null: half the strength, about half of what it does") {
  for (const EffectId e : effects().ids()) {
    const ParameterId strength = effects()[e].strength;
    const Declaration& declared = parameters()[strength].declaration;
    if (declared.kind != Kind::real) continue;
    if (effects()[e].name == "driver_lag") continue;  // a held input passes a short lag as it is: nothing to first order
    const auto what_it_does = [&](double share) {
      Plant limb = default_plant();
      turn_on_typical(limb, e);
      limb.set_in_file_units(strength, *declared.null_value + share * (declared.typical - *declared.null_value));
      Chance chance(23 + e.index);
      double sum = limb.equations()->input_delay_s();
      for (int n = 0; n < 100; ++n) {
        const std::vector<double> y = any_core_state(chance);
        const Situation given = any_situation(chance);
        const auto with = at_one_instant(limb, given, with_own_states(limb, y, chance));
        const auto core = at_one_instant(default_plant(), given, y);
        for (std::size_t i = 0; i < core_state::count; ++i) sum += std::abs(with.rates[i] - core.rates[i]);
        for (const std::size_t j : coils) sum += std::abs(with.reading[j] - core.reading[j]);
        sum += std::abs(with.reading[angle] - core.reading[angle]);
      }
      return sum;
    };
    INFO(effects()[e].name);
    // Near null the response is its derivative: at 1e-4 of the strength the next term is of that size, and no lag has a state.
    const double once = what_it_does(0.5e-4), twice = what_it_does(1e-4);
    CHECK(once > 0.0);
    CHECK(twice == doctest::Approx(2.0 * once).epsilon(1e-2).scale(once));
  }
}

TEST_CASE("every effect has one strength, a place, words and a file of its own with its tests") {
  CHECK(effects().size() == std::tuple_size_v<Effects<double>>);
  std::set<std::string_view> names;
  for (const EffectInfo& effect : effects()) {
    INFO(effect.name);
    CHECK(names.insert(effect.name).second);
    CHECK_FALSE(effect.place.empty());
    CHECK_FALSE(effect.equation.empty());
    CHECK_FALSE(effect.words.empty());
    CHECK(std::count_if(effect.parameters.begin(), effect.parameters.end(),
                        [](ParameterId p) { return parameters()[p].declaration.null_value.has_value(); }) == 1);
    CHECK(parameters()[effect.strength].declaration.null_value);
    CHECK(parameters()[effect.strength].owner == effect.name);
    const std::filesystem::path source = SINEW_SOURCE_DIR;
    CHECK(std::filesystem::exists(source / "plant/limb/effects" / (std::string(effect.name) + ".h")));
    CHECK(std::filesystem::exists(source / "tests/plant/limb/effects" / (std::string(effect.name) + "_test.cpp")));
  }
}

TEST_CASE("every parameter is declared with a name that carries its unit, a range, a meaning and a value within the range") {
  const Plant limb = default_plant();
  std::set<std::string> keys;
  std::set<std::string> suffixes;
  for (const ParameterInfo& parameter : parameters()) suffixes.insert(suffix_of(parameter.declaration.unit));
  suffixes.erase("");
  for (const ParameterId p : parameters().ids()) {
    const Declaration& declared = parameters()[p].declaration;
    INFO(parameters()[p].key());
    CHECK(keys.insert(parameters()[p].key()).second);
    CHECK(parameter_id(parameters()[p].key()) == p);
    CHECK_FALSE(declared.symbol.empty());
    CHECK_FALSE(declared.meaning.empty());
    CHECK(declared.range.lowest < declared.range.highest);
    CHECK(declared.range.contains(declared.typical));
    CHECK(declared.range.contains(limb.get_in_file_units(p)));
    CHECK(declared.prior_deviation >= 0.0);
    if (declared.null_value) {
      CHECK(declared.range.contains(*declared.null_value));
      CHECK(*declared.null_value != declared.typical);
      CHECK(limb.get_in_file_units(p) == *declared.null_value);  // a default-constructed effect is null
    } else {
      // The core is paper_limb, and what goes with a strength starts where a real limb could be.
      CHECK(limb.get_in_file_units(p) == doctest::Approx(declared.typical).epsilon(1e-15));
    }
    CHECK(!parameters()[p].effect == parameters()[p].owner.empty());
    if (!parameters()[p].effect) CHECK_FALSE(declared.null_value);
    if (declared.unit.text.empty())
      for (const std::string& suffix : suffixes) CHECK_FALSE(declared.name.ends_with(suffix));
    else
      CHECK(declared.name.ends_with(suffix_of(declared.unit)));
    if (declared.kind != Kind::real) CHECK(declared.prior_deviation == 0.0);
  }
}

TEST_CASE("every state of an effect is named with its unit and has a size") {
  const States states = two_coil_limb()->states(EffectsOn(effects().size(), true));
  std::set<std::string> keys;
  for (const StateInfo& state : states) {
    INFO(state.key);
    CHECK(keys.insert(state.key).second);
    CHECK(state.scale > 0.0);
    CHECK(state.key.ends_with(suffix_of(state.unit)));
  }
}

}  // namespace plant_limb_effects_test
