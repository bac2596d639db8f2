// SPDX-License-Identifier: Apache-2.0
#include "hil/supervisor.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "hil/limits.h"
#include "hil/twin.h"
#include "plant/systems.h"
#include "sim/simulation.h"

namespace hil_supervisor_test {

using namespace sinew;
using hil::HostSupervisor;

namespace {

constexpr double period_s = 0.1, missing = std::numeric_limits<double>::quiet_NaN();

std::uint32_t word(double temperature_degC) {
  return (static_cast<std::uint32_t>(std::lround(temperature_degC * 4.0) & 0x3fff) << 18) | (400u << 4);
}

std::vector<std::uint32_t> words(const std::vector<double>& temperatures_degC) {
  std::vector<std::uint32_t> all;
  for (const double one : temperatures_degC) all.push_back(word(one));
  return all;
}

// The simulated limb under the host's supervisor: wants this much on A for so long. Returns the hottest the coil gets.
double hottest(const plant::Plant& real, const plant::Plant& believed, double wanted, double duration_s, HostSupervisor* given = nullptr) {
  sim::Scenario scenario;
  scenario.plant = real;
  scenario.start.assign(real.states().size(), std::nullopt);
  sim::SimulatedBackend limb(scenario);
  HostSupervisor own(believed, {}, period_s);
  HostSupervisor& supervisor = given ? *given : own;
  sim::Measurement measured = limb.begin();
  const std::size_t wire = hil::parts_of(real).coils.front().temperature.index;
  double most_degC = 0.0;
  for (std::int64_t tick = 0; static_cast<double>(tick) * period_s < duration_s; ++tick) {
    supervisor.look(measured, words({measured.channels[0], measured.channels[1]}));
    const auto duty = supervisor.lower({wanted, 0.0}, measured);
    measured = limb.exchange({tick, duty});
    supervisor.applied(duty);
    most_degC = std::max(most_degC, limb.integrator().state()[wire]);
  }
  return most_degC;
}

}  // namespace

TEST_CASE("host supervisor: small duties pass as they are") {
  HostSupervisor supervisor(plant::default_plant(), {}, period_s);
  const auto duty = supervisor.lower({0.3, 0.2}, {0, {25.0, 25.0, 0.0}});
  CHECK(duty[0] == 0.3);
  CHECK(duty[1] == 0.2);
  CHECK(supervisor.lowered() == 0);
}

TEST_CASE("host supervisor: more than the highest duty is cut to it") {
  HostSupervisor supervisor(plant::default_plant(), {}, period_s);
  CHECK(supervisor.lower({1.0, 0.0}, {0, {25.0, 25.0, 0.0}})[0] == LIMIT_HIGHEST_DUTY / 10000.0);
  CHECK(supervisor.lowered() == 1);
}

TEST_CASE("host supervisor: a coil that is driven without end stays under the host's limit, and comes near what the heat's bound allows") {
  const plant::Plant limb = plant::default_plant();
  const double most_degC = hottest(limb, limb, 0.3, 40.0);
  // Noise of the thermocouple is 0.1 K and its steps 0.25 K; the correction follows them up at once.
  CHECK(most_degC < LIMIT_HOST_cdegC / 100.0 + 0.5);
  // By hand: the bound stays at 124.5 K with a mean duty of 124.5 * 0.045 / 30.1 = 0.186; this limb has 490 K of rise a duty: 116 degC.
  CHECK(most_degC > 110.0);
  CHECK(most_degC < 116.5);
}

TEST_CASE("host supervisor: a limb that heats by a third more than is believed stays under the device's trip") {
  plant::Plant real = plant::default_plant();
  for (const char* key : {"heat_capacity_A_J_K", "heat_capacity_B_J_K"}) real.set(real.system().parameter(key), 0.64);
  CHECK(hottest(real, plant::default_plant(), 0.6, 30.0) < LIMIT_TRIP_cdegC / 100.0);
}

TEST_CASE("host supervisor: the budget of duty in the window is kept below the device's") {
  plant::Plant cold = plant::default_plant();
  // Never gets hot, so that only the budget counts.
  for (const char* key : {"heat_loss_A_W_K", "heat_loss_B_W_K"}) cold.set(cold.system().parameter(key), 0.5);
  HostSupervisor supervisor(cold, {}, period_s);
  std::vector<double> on;
  for (int k = 0; k < 600; ++k) {
    const auto duty = supervisor.lower({0.6, 0.0}, {k, {missing, missing, missing}});
    supervisor.applied(duty);
    on.push_back(duty[0] * period_s);
    double sum_s = 0.0;
    for (std::size_t i = on.size() > 200 ? on.size() - 200 : 0; i < on.size(); ++i) sum_s += on[i];
    REQUIRE(sum_s <= LIMIT_ON_TIME_ms / 1000.0 - 0.3);
  }
}

TEST_CASE("host supervisor: a command that is not a number is zero duty and the end") {
  HostSupervisor supervisor(plant::default_plant(), {}, period_s);
  const auto duty = supervisor.lower({missing, 0.5}, {0, {25.0, 25.0, 0.0}});
  CHECK(duty[0] == 0.0);
  CHECK(duty[1] == 0.0);
  CHECK(supervisor.objection().value().find("not a number") != std::string::npos);
}

TEST_CASE("host supervisor: a sensor's number that cannot be is objected to") {
  const auto objection = [](double first_degC, double then_degC, std::uint32_t raw) {
    HostSupervisor supervisor(plant::default_plant(), {}, period_s);
    supervisor.look({0, {first_degC, 25.0, 0.0}}, words({first_degC, 25.0}));
    REQUIRE_FALSE(supervisor.objection());
    supervisor.look({1, {then_degC, 25.0, 0.0}}, std::vector{raw, word(25.0)});
    return supervisor.objection().value_or("");
  };
  CHECK(objection(25.0, 25.25, word(25.25)).empty());
  CHECK(objection(25.0, 25.0, 0).find("all bits") != std::string::npos);
  CHECK(objection(25.0, 25.0, 0xffffffffu).find("all bits") != std::string::npos);
  CHECK(objection(25.0, 25.0, word(25.0) | 0x00010001u).find("reports a fault") != std::string::npos);
  CHECK(objection(25.0, 25.25, word(25.0)).find("differ") != std::string::npos);
  CHECK(objection(25.0, 65.0, word(65.0)).find("jumped") != std::string::npos);
}

TEST_CASE("host supervisor: a thermocouple that falls silent is objected to after half a second") {
  HostSupervisor supervisor(plant::default_plant(), {}, period_s);
  int ticks = 0;
  while (!supervisor.objection() && ticks < 100) supervisor.look({ticks++, {missing, 25.0, 0.0}}, words({25.0, 25.0}));
  CHECK(ticks == 6);
}

TEST_CASE("host supervisor: a thermocouple that reads cold while its coil is driven is found out by the plant") {
  HostSupervisor supervisor(plant::default_plant(), {}, period_s);
  int ticks = 0;
  while (!supervisor.objection() && ticks < 200) {
    const sim::Measurement measured{ticks++, {25.0, 25.0, 0.0}};
    supervisor.look(measured, words({25.0, 25.0}));
    const auto duty = supervisor.lower({0.4, 0.0}, measured);
    supervisor.applied(duty);
  }
  // 0.4 heats at 9.2 K/s: 30 K after some 3.5 s, and a second more.
  CHECK(ticks > 35);
  CHECK(ticks < 55);
}

TEST_CASE("host supervisor: a bend sensor at an end of its range is objected to, and one that is 45 degrees from the plant for a second") {
  HostSupervisor ends(plant::default_plant(), {}, period_s);
  ends.look_at_angles({0, {25.0, 25.0, -90.0}}, std::vector<std::uint16_t>{0});
  CHECK(ends.objection().value_or("").find("a wire is off") != std::string::npos);
  HostSupervisor far(plant::default_plant(), {}, period_s);
  int ticks = 0;
  while (!far.objection() && ticks < 100) far.look_at_angles({ticks++, {25.0, 25.0, 50.0}}, std::vector<std::uint16_t>{12'731});
  CHECK(ticks == 11);
  HostSupervisor near(plant::default_plant(), {}, period_s);
  for (ticks = 0; ticks < 100; ++ticks) near.look_at_angles({ticks, {25.0, 25.0, 40.0}}, std::vector<std::uint16_t>{11'821});
  CHECK_FALSE(near.objection());
}

TEST_CASE("twin: a limb that is the twin never leaves it in an hour, one that loses more heat is caught and dated") {
  for (const bool other : {false, true}) {
    sim::Scenario scenario;
    scenario.duration_s = other ? 120.0 : 3600.0;
    scenario.input = sim::BabbleInput{};
    if (other) {
      const plant::System& system = scenario.plant.system();
      scenario.plant.turn(system.effect("airflow_change"), true);
      scenario.plant.set(system.parameter("airflow_change.relative_change"), 0.5);
      scenario.plant.set(system.parameter("airflow_change.onset_s"), 30.0);
    }
    scenario.start.assign(scenario.plant.states().size(), std::nullopt);
    sim::SimulatedBackend limb(scenario);
    sim::Driver driver(scenario.plant.system(), scenario.input, 1, period_s);
    hil::Twin twin(plant::default_plant(), {}, scenario.sensors, period_s);
    sim::Measurement measured = limb.begin();
    std::vector<hil::Departure> all;
    for (std::int64_t tick = 0; tick < scenario.ticks() - 1; ++tick) {
      for (const auto& one : twin.compare(measured, 0.0, 0.0)) all.push_back(one);
      auto command = driver.command(measured, scenario.time_s(tick));
      for (double& duty : command.inputs) duty = std::min(duty, 0.25);
      measured = limb.exchange({tick, command.inputs});
      twin.applied(command.inputs);
    }
    if (!other) {
      CHECK(all.empty());
    } else {
      REQUIRE_FALSE(all.empty());
      CHECK(all.front().onset_s >= 29.0);
      CHECK(all.front().said_s < 45.0);
      CHECK(all.front().onset_s < all.front().said_s);
    }
  }
}

}  // namespace hil_supervisor_test
