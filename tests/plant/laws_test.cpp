// SPDX-License-Identifier: Apache-2.0
#include "plant/laws.h"

#include <doctest/doctest.h>

#include <cmath>

#include "plant/integrator.h"
#include "plant/limb/limb.h"
#include "plant/systems.h"

namespace plant_laws_test {

using namespace sinew::plant;

namespace {

VariableId variable(const System& system, std::string_view name) {
  for (const VariableId v : system.variables().ids())
    if (system.variables()[v].name == name) return v;
  throw std::out_of_range(std::string(name));
}
EntryGroupId group(const System& system, std::string_view name) {
  for (const EntryGroupId g : system.entry_groups().ids())
    if (system.entry_groups()[g].name == name) return g;
  throw std::out_of_range(std::string(name));
}

// A known law: a straight line through (from, at_from) and (to, at_to).
Law line(const char* entry, const std::vector<std::string>& of, double from, double at_from, double to, double at_to) {
  const System& system = *two_coil_limb();
  Law law{.entry = group(system, entry), .argument = {}, .factor = {}, .knots = {from, to}, .curve = Eigen::Vector2d(at_from, at_to)};
  for (const std::string& name : of) law.argument.push_back(variable(system, name));
  return law;
}
Plant with(const Law& law, const Plant& plant = default_plant()) { return with_laws_on(plant, {law}); }

// Duties that step, and stop; every half second the readings.
std::vector<std::vector<double>> run(const Plant& plant, double until_s = 40.0) {
  Integrator integrator(plant, Start{}, {Method::cvode, 1e-9});
  std::vector<std::vector<double>> readings;
  for (int k = 0; k < static_cast<int>(2.0 * until_s); ++k) {
    integrator.hold(k < 16 ? std::vector{0.6, 0.0} : k < 40 ? std::vector{0.0, 0.5} : std::vector{0.0, 0.0});
    REQUIRE_FALSE(integrator.advance_to(0.5 * (k + 1)));
    readings.push_back(integrator.readings());
  }
  return readings;
}
double largest_difference(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b, std::size_t from = 0) {
  double largest = 0.0;
  for (std::size_t k = from; k < a.size(); ++k)
    for (std::size_t c = 0; c < a[k].size(); ++c) largest = std::max(largest, std::abs(a[k][c] - b[k][c]));
  return largest;
}
Plant changed(const char* key, double factor) {
  Plant plant = default_plant();
  const ParameterId p = plant.system().parameter(key);
  plant.set(p, factor * plant.get(p));
  return plant;
}

}  // namespace

TEST_CASE("laws: one that is off is exactly nothing, and ids of what was there stay") {
  const Plant plain = default_plant();
  Plant lawful = with(line("moment", {"angle"}, -40.0, 1e-3, 40.0, -1e-3));
  CHECK(run(lawful) != run(plain));
  const EffectId law{plain.system().effects().size()};
  CHECK(lawful.system().effects()[law].law == 0);
  lawful.turn(law, false);
  CHECK(run(lawful) == run(plain));
  CHECK(lawful.states().size() == plain.states().size());
  for (const ParameterId p : plain.system().parameters().ids())
    CHECK(lawful.system().parameters()[p].key() == plain.system().parameters()[p].key());
  CHECK(lawful.system().without_laws() == plain.shared_system());
}

TEST_CASE("laws: a line in the moment is a stiffer beam, a level in the heat of the air more heat loss, one of a reading an offset") {
  const double stiffness = default_plant().get(default_plant().system().parameter("beam_stiffness_Nm_rad"));
  // 0.3 of the stiffness at 1 rad.
  const double degrees = 1.0 / radians_per_degree;
  CHECK(largest_difference(run(with(line("moment", {"angle"}, -2.0 * degrees, 0.6 * stiffness, 2.0 * degrees, -0.6 * stiffness))),
                           run(changed("beam_stiffness_Nm_rad", 1.3))) < 1e-5);

  Law more_loss = line("heat", {"temperature A", "temperature B"}, 0.0, 0.5, 200.0, 0.5);
  more_loss.factor = {variable(*two_coil_limb(), "heat from the air A"), variable(*two_coil_limb(), "heat from the air B")};
  Plant both = changed("heat_loss_A_W_K", 1.5);
  both.set(both.system().parameter("heat_loss_B_W_K"), 1.5 * both.get(both.system().parameter("heat_loss_B_W_K")));
  CHECK(largest_difference(run(with(more_loss)), run(both)) < 1e-4);

  const auto shifted = run(with(line("angle_reading", {"angle"}, -10.0, 0.02, 10.0, 0.02))), plain = run(default_plant());
  for (std::size_t k = 0; k < plain.size(); ++k) CHECK(shifted[k][2] - plain[k][2] == doctest::Approx(0.02));
}

TEST_CASE("laws: a reading less what its variable has moved lately is a lag, with states of its own") {
  // g(a) = -a, a = T - T_slow: what is shown is T_slow.
  Law law = line("temperature_reading", {"temperature A", "temperature B"}, -500.0, 500.0, 500.0, -500.0);
  law.fading_memory_s = 3.0;
  const Plant lawful = with(law);
  CHECK(lawful.states().size() == default_plant().states().size() + 2);
  Plant lagging = default_plant();
  const EffectId lag = lagging.system().effect("thermocouple_lag");
  lagging.turn(lag, true);
  lagging.set(lagging.system().parameter("thermocouple_lag.time_constant_s"), 3.0);
  CHECK(largest_difference(run(lawful), run(lagging)) < 1e-4);
}

TEST_CASE("laws: straight between knots, held beyond") {
  Law law = line("angle_reading", {"time"}, 0.0, 0.0, 1.0, 0.0);
  law.knots = {5.0, 10.0, 20.0};
  law.curve = Eigen::Vector3d(1.0, 2.0, -1.0);
  const auto lawful = run(with(law)), plain = run(default_plant());
  for (std::size_t k = 0; k < plain.size(); ++k) {
    const double t = 0.5 * static_cast<double>(k + 1);
    const double expected = t < 5.0 ? 1.0 : t < 10.0 ? 1.0 + (t - 5.0) / 5.0 : t < 20.0 ? 2.0 - 0.3 * (t - 10.0) : -1.0;
    CHECK(lawful[k][2] - plain[k][2] == doctest::Approx(expected));
  }
}

TEST_CASE("laws: derivatives of the readings are those of differences") {
  Law law = line("heat", {"temperature A", "temperature B"}, 20.0, 0.1, 90.0, -0.4);
  law.curve = Eigen::Matrix2d{{0.3, 0.1}, {-0.2, 0.4}};
  law.is_sought = true;
  law.fading_memory_s = 8.0;
  Plant plant = carried_into(default_plant(), with_laws(default_plant().shared_system(), {law}));
  const EffectId effect{default_plant().system().effects().size()};
  const EffectInfo& info = plant.system().effects()[effect];
  plant.turn(effect, true);
  plant.set(info.strength, 1.0);
  plant.set(info.parameters[1], 0.7);
  plant.set(info.parameters[2], -0.4);
  CHECK(values_of(plant, effect).isApprox(Eigen::Vector2d(0.17, -0.3)));
  const auto readings_at = [&](const Plant& of, const SensitivityRequest& request, Eigen::MatrixXd* sensitivity) {
    Integrator integrator(of, Start{}, {Method::cvode, 1e-10}, request);
    integrator.hold({0.6, 0.1});
    REQUIRE_FALSE(integrator.advance_to(12.0));
    std::vector<double> readings = integrator.readings();
    if (sensitivity) integrator.readings_with_sensitivity(readings, *sensitivity);
    return readings;
  };
  Eigen::MatrixXd sensitivity;
  static_cast<void>(readings_at(plant, {{info.parameters[1], info.parameters[2]}, {}}, &sensitivity));
  for (Eigen::Index p = 0; p < 2; ++p) {
    const double step = 1e-3;
    Plant more = plant, less = plant;
    const ParameterId weight = info.parameters[static_cast<std::size_t>(p) + 1];
    more.set(weight, plant.get(weight) + step), less.set(weight, plant.get(weight) - step);
    const auto high = readings_at(more, {}, nullptr), low = readings_at(less, {}, nullptr);
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      CHECK(sensitivity(c, p) == doctest::Approx((high[i] - low[i]) / (2.0 * step)).epsilon(1e-3));
    }
  }

  // What a file keeps: the curve, without weights.
  const Plant known = as_in_file(plant);
  CHECK(known.system().laws().size() == 1);
  CHECK_FALSE(known.system().laws()[0].is_sought);
  CHECK(largest_difference(run(known, 5.0), run(plant, 5.0)) < 1e-6);
  plant.turn(effect, false);
  CHECK(as_in_file(plant) == default_plant());
}

TEST_CASE("laws: any System may have them") {
  for (const SystemMaker& maker : systems()) {
    CAPTURE(maker.name);
    const Plant plain(maker.make({}, {}));
    for (const EntryGroupId g : plain.system().entry_groups().ids()) {
      Law law{.entry = g, .argument = {}, .factor = {}, .knots = {-1e6, 1e6}, .curve = Eigen::Vector2d(1.0, 1.0)};
      bool possible = false;
      for (const Entry& entry : plain.system().entries())
        if (entry.group == g && (entry.state || entry.channel)) {
          law.argument.push_back(entry.may_depend_on.front());
          possible = true;
        }
      if (!possible) {
        CHECK_THROWS_AS(with_laws(plain.shared_system(), {law}), std::invalid_argument);
        continue;
      }
      const Plant lawful = with_laws_on(plain, {law});
      const auto equations = lawful.equations(), without = plain.equations();
      const std::size_t n = lawful.states().size();
      Situation given;
      given.inputs.assign(plain.system().inputs().size(), 0.1);
      std::vector<double> y(n, 0.2), rates(n), plain_rates(n);
      std::vector<double> readings(plain.system().channels().size()), plain_readings = readings;
      equations->rates(given, y.data(), rates.data());
      without->rates(given, y.data(), plain_rates.data());
      equations->readings(y.data(), readings.data());
      without->readings(y.data(), plain_readings.data());
      // A constant 1 at each entry of the group, and nowhere else.
      for (const Entry& entry : plain.system().entries()) {
        const double expected = entry.group == g ? 1.0 / (entry.divided_by ? plain.get(*entry.divided_by) : 1.0) : 0.0;
        if (entry.state) CHECK(rates[entry.state->index] - plain_rates[entry.state->index] == doctest::Approx(expected));
        if (entry.channel) CHECK(readings[entry.channel->index] - plain_readings[entry.channel->index] == doctest::Approx(expected));
      }
    }
  }
}

TEST_CASE("laws: what does not fit a System is refused") {
  const auto base = two_coil_limb();
  const Law good = line("heat", {"temperature A", "temperature B"}, 0.0, 1.0, 1.0, 2.0);
  CHECK_NOTHROW(with_laws(base, {good}));
  const auto refused = [&](auto&& spoil) {
    Law law = good;
    spoil(law);
    CHECK_THROWS_AS(with_laws(base, {law}), std::invalid_argument);
  };
  refused([](Law& law) { law.argument.pop_back(); });
  refused([](Law& law) { law.argument[1] = VariableId{1000}; });
  refused([](Law& law) { law.factor = {law.argument[0]}; });
  refused([](Law& law) { law.knots = {1.0, 1.0}; });
  refused([](Law& law) { law.knots = {1.0}; });
  refused([](Law& law) { law.curve = Eigen::Vector3d(1.0, 2.0, 3.0); });
  refused([&](Law& law) { law.entry = group(*base, "air"); });
}

}  // namespace plant_laws_test
