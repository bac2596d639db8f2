// SPDX-License-Identifier: Apache-2.0
// What holds for every effect of the list, so that a new one is covered the moment it is listed.
#include "plant/effects.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <random>
#include <set>

#include "plant/integrator.h"
#include "tests/plant/one_instant.h"

#ifndef SINEW_SOURCE_DIR
#define SINEW_SOURCE_DIR "."
#endif

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
Limb<double> any_limb(Chance& chance) {
  Limb<double> limb;
  for (std::size_t p = 0; p < parameters().size(); ++p) {
    const Declaration& declared = parameters()[p].declaration;
    if (parameters()[p].effect != no_effect) continue;
    if (declared.kind == Kind::sign)
      set(limb, p, chance.between(-1.0, 1.0) < 0.0 ? -1.0 : 1.0);
    else
      set(limb, p, get(limb, p) * chance.between(0.67, 1.33));
  }
  return limb;
}

// States from cold to burning hot, on and beside both envelopes, bent up to 60 degrees, moving.
std::vector<double> any_core_state(Chance& chance) {
  return {chance.between(0.0, 150.0), chance.between(0.0, 150.0), chance.between(-0.01, 1.01),
          chance.between(-0.01, 1.01), chance.between(-1.0, 1.0), chance.between(-5.0, 5.0)};
}

Situation any_situation(Chance& chance) {
  Situation given{.time_s = chance.between(0.0, 900.0)};
  given.segment_start_s = chance.between(0.0, given.time_s);
  for (const std::size_t j : coils)
    given.duty_fraction[j] = chance.between(0.0, 1.0) < 0.3 ? 0.0 : chance.between(0.0, 1.0);
  return given;
}

// Adds the states of the effects that are on: anything at all.
std::vector<double> with_own_states(const Limb<double>& limb, std::vector<double> y, Chance& chance) {
  const Layout layout = layout_of(limb.on);
  for (std::size_t i = y.size(); i < layout.size(); ++i)
    y.push_back(layout.entries[i].declaration.scale * chance.between(-3.0, 3.0));
  return y;
}

void set_to_null(Limb<double>& limb, std::size_t effect) {
  const std::size_t strength = effects()[effect].strength;
  set_in_file_units(limb, strength, *parameters()[strength].declaration.null_value);
}

bool same_bits(double left, double right) { return std::bit_cast<std::uint64_t>(left) == std::bit_cast<std::uint64_t>(right); }

// The same rates of the core's states and the same readings, to the last bit.
bool same_as_core(const OneInstant& with, const OneInstant& core) {
  bool same = same_bits(with.reading.angle_rad, core.reading.angle_rad);
  for (std::size_t i = 0; i < core_state::count; ++i) same = same && same_bits(with.rates[i], core.rates[i]);
  for (const std::size_t j : coils)
    same = same && same_bits(with.reading.temperature_degC[j], core.reading.temperature_degC[j]);
  return same;
}

// A minute of jumps in both coils; the states at every half second.
std::vector<std::vector<double>> run(const Limb<double>& limb, Method method) {
  Integrator limb_in_time(limb, Start{}, {.method = method, .relative_tolerance = 1e-7});
  std::vector<std::vector<double>> states;
  for (int tick = 0; tick < 40; ++tick) {
    const double duty = 0.3 + 0.3 * ((tick * 7) % 5) / 4.0;
    limb_in_time.hold(tick < 16 ? PerCoil<double>{duty, 0.0} : PerCoil<double>{0.0, 0.8 * duty});
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
  for (std::size_t e = 0; e < effect_count; ++e) {
    Chance chance(4711 + e);
    int different = 0;
    for (int n = 0; n < 400; ++n) {
      const Limb<double> core = any_limb(chance);
      Limb<double> limb = core;
      for (const std::size_t p : effects()[e].parameters) {
        const Declaration& declared = parameters()[p].declaration;
        set_in_file_units(limb, p, std::clamp(declared.typical * chance.between(0.5, 1.5), declared.range.lowest, declared.range.highest));
      }
      set_to_null(limb, e);
      limb.on[e] = true;
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
    const Limb<double> core = any_limb(chance);
    Limb<double> limb = core;
    limb.on.fill(true);
    const std::vector<double> y = any_core_state(chance);
    const Situation given = any_situation(chance);
    REQUIRE(same_as_core(at_one_instant(limb, given, with_own_states(limb, y, chance)), at_one_instant(core, given, y)));
    REQUIRE(Equations<double>(limb).command_delay_s() == 0.0);
  }
}

TEST_CASE("an effect that is off takes no part, whatever its values") {
  Chance chance(15);
  for (int n = 0; n < 100; ++n) {
    const Limb<double> core = any_limb(chance);
    Limb<double> limb = core;
    for (std::size_t e = 0; e < effect_count; ++e) turn_on_typical(limb, e);
    limb.on.fill(false);
    const std::vector<double> y = any_core_state(chance);
    const Situation given = any_situation(chance);
    REQUIRE(same_as_core(at_one_instant(limb, given, y), at_one_instant(core, given, y)));
    REQUIRE(Equations<double>(limb).switch_times_s().empty());
  }
}

TEST_CASE("a run with every effect named at its null value is the core's run, bit for bit") {
  Limb<double> named;
  for (std::size_t e = 0; e < effect_count; ++e) {
    turn_on_typical(named, e);
    set_to_null(named, e);
  }
  turn_on_by_strength(named);
  for (const bool on : named.on) CHECK_FALSE(on);
  for (const Method method : {Method::cvode, Method::arkode}) CHECK(run(named, method) == run(Limb<double>{}, method));
}

TEST_CASE("a run with an effect forced on at its null value is the core's run: to the bit, or to the solver's tolerance") {
  // An effect with states takes part in the choice of steps, so that only its size of error can be promised: the solver is
  // given 1e-7 of each state's scale a step, and the beam is the state that feels the steps most.
  constexpr double solver = 1e-3;
  for (const Method method : {Method::cvode, Method::arkode}) {
    const auto core = run(Limb<double>{}, method);
    for (std::size_t e = 0; e < effect_count; ++e) {
      INFO(effects()[e].name);
      Limb<double> limb;
      limb.on[e] = true;
      const auto forced = run(limb, method);
      if (layout_of(limb.on).size() == core_state::count) {
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
  for (std::size_t e = 0; e < effect_count; ++e) {
    Chance chance(16 + e);
    Limb<double> limb;
    turn_on_typical(limb, e);
    int different = 0;
    for (int n = 0; n < 400; ++n) {
      const std::vector<double> y = any_core_state(chance);
      const Situation given = any_situation(chance);
      if (!same_as_core(at_one_instant(limb, given, with_own_states(limb, y, chance)), at_one_instant(Limb<double>{}, given, y)))
        ++different;
    }
    const bool other_time = Equations<double>(limb).command_delay_s() > 0.0;
    INFO(effects()[e].name);
    CHECK((different > 0 || other_time));
  }
}

TEST_CASE("every effect vanishes as its strength goes to null: half the strength, about half of what it does") {
  for (std::size_t e = 0; e < effect_count; ++e) {
    const std::size_t strength = effects()[e].strength;
    const Declaration& declared = parameters()[strength].declaration;
    if (declared.kind != Kind::real) continue;
    const auto what_it_does = [&](double share) {
      Limb<double> limb;
      turn_on_typical(limb, e);
      set_in_file_units(limb, strength, *declared.null_value + share * (declared.typical - *declared.null_value));
      Chance chance(23 + e);
      double sum = Equations<double>(limb).command_delay_s();
      for (int n = 0; n < 100; ++n) {
        const std::vector<double> y = any_core_state(chance);
        const Situation given = any_situation(chance);
        const auto with = at_one_instant(limb, given, with_own_states(limb, y, chance));
        const auto core = at_one_instant(Limb<double>{}, given, y);
        for (std::size_t i = 0; i < core_state::count; ++i) sum += std::abs(with.rates[i] - core.rates[i]);
        for (const std::size_t j : coils)
          sum += std::abs(with.reading.temperature_degC[j] - core.reading.temperature_degC[j]);
        sum += std::abs(with.reading.angle_rad - core.reading.angle_rad);
      }
      return sum;
    };
    INFO(effects()[e].name);
    // Near null the response is its derivative: at 1e-4 of the strength the next term is of that size.
    const double once = what_it_does(1e-4), twice = what_it_does(2e-4);
    CHECK(once > 0.0);
    CHECK(twice == doctest::Approx(2.0 * once).epsilon(1e-2).scale(once));
  }
}

TEST_CASE("every effect has one strength, a place, words and a file of its own with its tests") {
  CHECK(effects().size() == effect_count);
  std::set<std::string_view> names;
  for (const EffectInfo& effect : effects()) {
    INFO(effect.name);
    CHECK(names.insert(effect.name).second);
    CHECK_FALSE(text_of(effect.place).empty());
    CHECK_FALSE(effect.equation.empty());
    CHECK_FALSE(effect.words.empty());
    CHECK(std::count_if(effect.parameters.begin(), effect.parameters.end(),
                        [](std::size_t p) { return parameters()[p].declaration.null_value.has_value(); }) == 1);
    CHECK(parameters()[effect.strength].declaration.null_value);
    CHECK(parameters()[effect.strength].owner == effect.name);
    const std::filesystem::path source = SINEW_SOURCE_DIR;
    CHECK(std::filesystem::exists(source / "plant/effects" / (std::string(effect.name) + ".h")));
    CHECK(std::filesystem::exists(source / "tests/plant/effects" / (std::string(effect.name) + "_test.cpp")));
  }
}

TEST_CASE("every parameter is declared with a name that carries its unit, a range, a meaning and a value within the range") {
  const Limb<double> limb;
  std::set<std::string> keys;
  std::set<std::string> suffixes;
  for (const ParameterInfo& parameter : parameters()) suffixes.insert(suffix_of(parameter.declaration.unit));
  suffixes.erase("");
  for (std::size_t p = 0; p < parameters().size(); ++p) {
    const Declaration& declared = parameters()[p].declaration;
    INFO(parameters()[p].key());
    CHECK(keys.insert(parameters()[p].key()).second);
    CHECK(parameter_index(parameters()[p].key()) == p);
    CHECK_FALSE(declared.symbol.empty());
    CHECK_FALSE(declared.meaning.empty());
    CHECK(declared.range.lowest < declared.range.highest);
    CHECK(declared.range.contains(declared.typical));
    CHECK(declared.range.contains(get_in_file_units(limb, p)));
    CHECK(declared.prior_deviation >= 0.0);
    if (declared.null_value) {
      CHECK(declared.range.contains(*declared.null_value));
      CHECK(*declared.null_value != declared.typical);
      CHECK(get_in_file_units(limb, p) == *declared.null_value);  // a default-constructed effect is null
    } else {
      // The core is paper_limb, and what goes with a strength starts where a real limb could be.
      CHECK(get_in_file_units(limb, p) == doctest::Approx(declared.typical).epsilon(1e-15));
    }
    CHECK((parameters()[p].effect == no_effect) == parameters()[p].owner.empty());
    if (parameters()[p].effect == no_effect) CHECK_FALSE(declared.null_value);
    if (declared.unit.text.empty())
      for (const std::string& suffix : suffixes) CHECK_FALSE(declared.name.ends_with(suffix));
    else
      CHECK(declared.name.ends_with(suffix_of(declared.unit)));
    if (declared.kind != Kind::real) CHECK(declared.prior_deviation == 0.0);
  }
}

TEST_CASE("every state of an effect is named with its unit and has a size") {
  std::array<bool, effect_count> on;
  on.fill(true);
  const Layout layout = layout_of(on);
  CHECK(layout.size() == largest_state_count);
  std::set<std::string> keys;
  for (const Layout::Entry& entry : layout.entries) {
    INFO(entry.key);
    CHECK(keys.insert(entry.key).second);
    CHECK(entry.declaration.scale > 0.0);
    CHECK(entry.key.ends_with(suffix_of(entry.declaration.unit)));
  }
}
