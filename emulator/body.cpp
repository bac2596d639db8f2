// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulator/body.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "prove/generator_effects.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::emulator {
namespace {

std::string what_is(const plant::Plant& plant) { return "the scenario's plant " + sim::sha256(sim::plant_file_text(plant)).substr(0, 16); }

void check_same(const Left& before, std::string_view what, std::size_t states) {
  if (before.what != what || before.state.size() != states)
    throw sim::InputError({.key = "--goes-on-from",
                           .value = before.what + ", " + std::to_string(before.state.size()) + " states",
                           .advice = "is another limb; here is " + std::string(what) + ", " + std::to_string(states) + " states"});
}

plant::Start start_of(const sim::Scenario& scenario, const std::optional<Left>& before) {
  if (!before) return {scenario.start, {}};
  check_same(*before, what_is(scenario.plant), scenario.plant.states().size());
  return {{before->state.begin(), before->state.end()}, {}};
}

class PlantBody : public Body {
 public:
  PlantBody(const sim::Scenario& scenario, const std::optional<Left>& before)
      : scenario_(scenario),
        begin_s_(before ? before->time_s : 0.0),
        first_session_s_(before ? before->first_session_s : scenario.duration_s),
        integrator_(scenario.plant, start_of(scenario, before), {plant::Method::automatic, 1e-7}) {
    const plant::States states = scenario.plant.states();
    for (const plant::InputInfo& input : scenario.plant.system().inputs())
      for (const plant::StateId s : states.ids())
        if (states[s].key == "temperature_" + input.name + "_degC") wires_.push_back(s);
  }
  void advance_to(double time_s) override {
    if (const auto failure = integrator_.advance_to(time_s))
      throw std::runtime_error("the plant behind the board failed: " + failure->reason);
  }
  void hold(const std::vector<double>& duty_fraction) override { integrator_.hold(duty_fraction); }
  std::vector<double> readings() const override { return sim::in_file_units(scenario_.plant.system(), integrator_.readings()); }
  std::vector<double> wires_degC() const override {
    std::vector<double> values;
    for (const plant::StateId wire : wires_) values.push_back(integrator_.state()[wire.index]);
    return values;
  }
  Left left() const override {
    const auto& state = integrator_.state();
    return {what_is(scenario_.plant), begin_s_ + integrator_.time_s(), first_session_s_, {state.begin(), state.end()}};
  }

 private:
  const sim::Scenario& scenario_;
  double begin_s_, first_session_s_;
  plant::Integrator integrator_;
  std::vector<plant::StateId> wires_;
};

class ConcealedBody : public Body {
 public:
  ConcealedBody(prove::Run run, const plant::System& system, std::string what, double first_session_s)
      : run_(std::move(run)), system_(system), what_(std::move(what)), begin_s_(run_.time_s()), first_session_s_(first_session_s) {}
  void advance_to(double time_s) override { run_.advance_to(begin_s_ + time_s); }
  void hold(const std::vector<double>& duty_fraction) override { run_.hold({duty_fraction[0], duty_fraction[1]}); }
  std::vector<double> readings() const override {
    const prove::Shown shown = run_.shown();
    std::vector<double> values;
    for (const plant::ChannelInfo& channel : system_.channels())
      values.push_back(channel.driven_by ? shown.temperature_degC[channel.driven_by->index] : shown.angle_deg);
    return values;
  }
  std::vector<double> wires_degC() const override {
    const auto both = run_.wire_temperature_degC();
    return {both.begin(), both.end()};
  }
  Left left() const override {
    const prove::Run::Left left = run_.left();
    return {what_, left.time_s, first_session_s_, left.state};
  }

 private:
  prove::Run run_;
  const plant::System& system_;
  std::string what_;
  double begin_s_, first_session_s_;
};

}  // namespace

std::string to_text(const Left& left) {
  const nlohmann::ordered_json json{{"note", "The emulated limb as a session left it. Only the emulator reads this file."},
                                    {"limb", left.what},
                                    {"time_s", left.time_s},
                                    {"first_session_s", left.first_session_s},
                                    {"state", left.state}};
  return json.dump(1) + "\n";
}

Left read_left(const std::filesystem::path& file) {
  try {
    const auto json = nlohmann::ordered_json::parse(sim::read_file(file));
    const Left left{json.at("limb"), json.at("time_s"), json.at("first_session_s"), json.at("state").get<std::vector<double>>()};
    if (left.time_s < 0.0 || left.first_session_s <= 0.0)
      throw sim::InputError({.file = file.string(), .key = "time_s, first_session_s", .advice = "must be 0 or more, and more than 0"});
    return left;
  } catch (const nlohmann::json::exception& e) {
    throw sim::InputError({.file = file.string(), .advice = std::string("is no limb as a session left it: ") + e.what()});
  }
}

std::unique_ptr<Body> plant_body(const sim::Scenario& scenario, const std::optional<Left>& before) {
  return std::make_unique<PlantBody>(scenario, before);
}

std::unique_ptr<Body> concealed_body(const Concealed& concealed, const sim::Scenario& scenario, const std::optional<Left>& before) {
  constexpr double longest_over_s = 60.0;  // that a session takes beyond its scenario
  const std::string what = concealed.kind + " " + std::to_string(concealed.seed) + " " + sim::shortest(concealed.strength);
  std::optional<prove::Run::Left> left;
  if (before) {
    check_same(*before, what, before->state.size());
    left = prove::Run::Left{before->time_s, before->state};
  }
  prove::Settings settings;
  settings.strength = concealed.strength;
  const double first_session_s = before ? before->first_session_s : scenario.duration_s;
  settings.training_s = settings.heldout_s = first_session_s;
  try {
    return std::make_unique<ConcealedBody>(prove::concealed_run(prove::kind_of_name(concealed.kind), concealed.seed, settings,
                                                                "emulated " + std::to_string(concealed.recording),
                                                                scenario.duration_s + longest_over_s, left),
                                           scenario.plant.system(), what, first_session_s);
  } catch (const std::invalid_argument& e) {
    throw sim::InputError({.key = "--concealed", .value = concealed.kind, .advice = e.what()});
  }
}

}  // namespace sinew::emulator
