// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulator/body.h"

#include <stdexcept>

#include "prove/generator_effects.h"
#include "sim/input_error.h"
#include "sim/simulation.h"

namespace sinew::emulator {
namespace {

class PlantBody : public Body {
 public:
  explicit PlantBody(const sim::Scenario& scenario)
      : scenario_(scenario), integrator_(scenario.plant, plant::Start{scenario.start, {}}, {plant::Method::automatic, 1e-7}) {
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

 private:
  const sim::Scenario& scenario_;
  plant::Integrator integrator_;
  std::vector<plant::StateId> wires_;
};

class ConcealedBody : public Body {
 public:
  ConcealedBody(prove::Run run, const plant::System& system) : run_(std::move(run)), system_(system) {}
  void advance_to(double time_s) override { run_.advance_to(time_s); }
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

 private:
  prove::Run run_;
  const plant::System& system_;
};

}  // namespace

std::unique_ptr<Body> plant_body(const sim::Scenario& scenario) { return std::make_unique<PlantBody>(scenario); }

std::unique_ptr<Body> concealed_body(const Concealed& concealed, const sim::Scenario& scenario) {
  prove::Settings settings;
  settings.strength = concealed.strength;
  // What begins within a recording does so within the emulated one.
  settings.training_s = settings.heldout_s = scenario.duration_s;
  try {
    return std::make_unique<ConcealedBody>(prove::concealed_run(prove::kind_of_name(concealed.kind), concealed.seed, settings,
                                                                "emulated " + std::to_string(concealed.recording),
                                                                scenario.duration_s + 60.0),
                                           scenario.plant.system());
  } catch (const std::invalid_argument& e) {
    throw sim::InputError({.key = "--concealed", .value = concealed.kind, .advice = e.what()});
  }
}

}  // namespace sinew::emulator
