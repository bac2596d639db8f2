// SPDX-License-Identifier: Apache-2.0
#include "diagnose/varying.h"

#include <algorithm>

#include "diagnose/proposals.h"
#include "plant/contains.h"
#include "sim/simulation.h"

namespace sinew::diagnose {
namespace {

// What begins at some moment or grows with time does what it does after ten minutes.
constexpr double long_since_s = 600.0;
constexpr double per_cent = 0.01;

plant::Plant changed(const plant::Plant& plant, const Wanderer& by) {
  plant::Plant result = plant;
  const auto& parameters = plant.system().parameters();
  if (by.effect) {
    result.turn(*by.effect, true);
    for (const plant::ParameterId p : plant.system().effects()[*by.effect].parameters)
      result.set_in_file_units(p, parameters[p].declaration.typical);
  }
  if (by.constant)
    for (const plant::ParameterId p : by.constant->parameters)
      result.set(p, by.unit == "%" ? plant.get(p) * (1.0 + per_cent * by.scale)
                                   : plant.get(p) + by.scale * parameters[p].declaration.unit.internal_per_unit);
  return result;
}

// What is said of an effect: its strength; of one that grows with time, what it has grown to.
Wanderer strength_of(const plant::System& system, plant::EffectId effect) {
  const plant::EffectInfo& info = system.effects()[effect];
  const auto& declared = system.parameters()[info.strength].declaration;
  Wanderer one{.words = "the strength of " + std::string(info.name), .place = info.place, .effect = effect, .constant = {}};
  one.centre = declared.null_value.value_or(0.0);
  one.scale = declared.typical - one.centre;
  one.unit = std::string(declared.unit.text);
  if (!info.grown_words.empty()) {
    one.words = info.grown_words;
    one.scale *= long_since_s;
    one.unit = info.grown_unit;
  }
  return one;
}

bool is_upstream_sensor(const plant::System& system, std::string_view place) {
  const auto& upstream = system.upstream_places();
  return place.starts_with("sensor.") && contains(upstream, place);
}

}  // namespace

std::vector<Wanderer> wanderers(const plant::Plant& plant, const std::vector<plant::EffectId>& without) {
  const plant::System& system = plant.system();
  std::vector<Wanderer> all;
  const std::size_t states = plant.states().size();
  const double delay_s = plant.equations()->input_delay_s();
  for (const plant::EffectId e : system.effects().ids()) {
    if (plant.is_on(e) || is_left_out(system, e, without)) continue;
    const Wanderer one = strength_of(system, e);
    const plant::Plant with = changed(plant, one);
    const bool toggle = system.parameters()[system.effects()[e].strength].declaration.kind == plant::Kind::toggle;
    const bool remembers = with.states().size() != states && system.effects()[e].grown_words.empty();  // more than a time
    if (toggle || is_upstream_sensor(system, one.place) || remembers || with.equations()->input_delay_s() != delay_s) continue;
    all.push_back(one);
  }
  for (const plant::Constant& constant : system.constants())
    all.push_back({.words = constant.words,
                   .place = constant.place,
                   .effect = {},
                   .constant = constant,
                   .scale = constant.scale,
                   .unit = constant.unit});
  return all;
}

bool varying_push(const FitProblem& problem, const double* z, const Varying& varying, VaryingPush& push) {
  const plant::System& system = problem.system();
  const plant::Plant plant = problem.plant_at(z);
  const plant::Plant with = changed(plant, varying.of);
  const auto as_it_is = plant.equations(), changed_so = with.equations();
  const std::size_t states = plant.states().size(), channels = system.channels().size();
  // Where the plant's states are among those of the changed one, whose others are the time since what grows began to.
  std::vector<std::size_t> place;
  const plant::States more = with.states();
  for (const plant::StateId i : plant.states().ids())
    place.push_back(std::find_if(more.begin(), more.end(), [&](const auto& one) { return one.key == plant.states()[i].key; }) -
                    more.begin());
  std::vector<double> y_with(more.size(), long_since_s), rates_with(more.size());
  const auto& constant = varying.of.constant;
  push = {varying.correlation_time_s, {}, {}};
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const auto& samples = data.recording->samples;
    plant::Integrator integrator(plant, problem.start_at(z, r), problem.numerics());
    push.rates.emplace_back();
    push.readings.emplace_back();
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(samples[k].time_s - samples.front().time_s)) return false;
      problem.follow_course(integrator, r, k);
      sim::command_sample(integrator, system, samples, k);
      plant::Situation given = integrator.situation();
      if (varying.of.effect) {
        given.inputs_from_s += long_since_s - given.time_s;  // inputs that change go on as they are
        given.time_s = given.segment_start_s = long_since_s;
      }
      Eigen::VectorXd was(static_cast<Eigen::Index>(states)), is(was);
      const double* y = integrator.state().data();
      as_it_is->rates(given, y, was.data());
      for (std::size_t i = 0; i < states; ++i) y_with[place[i]] = y[i];
      changed_so->rates(given, y_with.data(), rates_with.data());
      for (std::size_t i = 0; i < states; ++i) is(static_cast<Eigen::Index>(i)) = rates_with[place[i]];
      push.rates.back().push_back(is - was);
      Eigen::VectorXd shown(static_cast<Eigen::Index>(channels)), other(shown);
      as_it_is->readings(y, shown.data());
      changed_so->readings(y_with.data(), other.data());
      other -= shown;
      if (constant) {
        const double about = constant->about ? plant.get(*constant->about) : 0.0;
        for (const plant::ChannelId c : constant->channels) {
          const auto channel = static_cast<Eigen::Index>(c.index);
          other(channel) = per_cent * varying.of.scale * (shown(channel) - about);
        }
      }
      push.readings.back().push_back(other);
    }
  }
  return true;
}

}  // namespace sinew::diagnose
