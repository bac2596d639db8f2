// SPDX-License-Identifier: Apache-2.0
// For tests of the small Systems: one instant of their equations, and what must hold for each of them.
#pragma once

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "plant/integrator.h"
#include "sim/input_error.h"
#include "sim/log_map.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"

namespace sinew::test::small {

using namespace sinew::plant;

// Worked by hand; the equations' result differs by the rounding of a dozen operations.
inline doctest::Approx near_exactly(double value) { return doctest::Approx(value).epsilon(1e-12).scale(std::abs(value)); }

inline Plant plant_from(const std::string& file) { return sim::read_plant_file(std::string(SINEW_SOURCE_DIR) + "/plant/" + file); }

inline void set(Plant& plant, std::string_view key, double value) {
  const ParameterId p = plant.system().parameter(key);
  plant.set_in_file_units(p, value);
  if (plant.system().parameters()[p].effect) plant.turn(*plant.system().parameters()[p].effect, true);
}

inline void turn_on_typical(Plant& plant, EffectId effect) {
  plant.turn(effect, true);
  for (const ParameterId p : plant.system().effects()[effect].parameters)
    plant.set_in_file_units(p, plant.system().parameters()[p].declaration.typical);
}

struct AtOnce {
  std::vector<double> rates, readings;
};
inline AtOnce at_once(const Plant& plant, double input, const std::vector<double>& state) {
  Situation given;
  given.inputs = {input};
  const auto equations = plant.equations();
  AtOnce result{std::vector<double>(state.size()), std::vector<double>(plant.system().channels().size())};
  equations->rates(given, state.data(), result.rates.data());
  equations->readings(state.data(), result.readings.data());
  return result;
}

// `state`: of the core. States of effects are put at rest.
inline std::vector<double> with_effects_at_rest(const Plant& plant, double input, const std::vector<double>& state) {
  Situation given;
  given.inputs = {input};
  std::vector<std::optional<double>> known(state.begin(), state.end());
  known.resize(plant.states().size());
  return plant.equations()->rest(given, known);
}

// Each effect, at its null and all else of it typical, leaves rates and readings as they are to the last bit, and at its
// typical strength does not, in one of the states at least.
inline void check_nulls(const Plant& core, double input, const std::vector<std::vector<double>>& states) {
  const System& system = core.system();
  for (const EffectId e : system.effects().ids()) {
    const EffectInfo& info = system.effects()[e];
    CAPTURE(info.name);
    bool acts = false;
    int nulls = 0;
    for (const ParameterId p : info.parameters) nulls += system.parameters()[p].declaration.null_value.has_value();
    CHECK(nulls == 1);
    for (const auto& state : states) {
      const AtOnce without = at_once(core, input, state);
      Plant plant = core;
      turn_on_typical(plant, e);
      const AtOnce with = at_once(plant, input, with_effects_at_rest(plant, input, state));
      acts = acts || plant.equations()->input_delay_s() > 0.0 || plant.states().size() > state.size();
      plant.set_in_file_units(info.strength, *system.parameters()[info.strength].declaration.null_value);
      CHECK(plant.equations()->input_delay_s() == 0.0);
      const AtOnce at_null = at_once(plant, input, with_effects_at_rest(plant, input, state));
      for (std::size_t i = 0; i < state.size(); ++i) {
        CHECK(at_null.rates[i] == without.rates[i]);
        acts = acts || with.rates[i] != without.rates[i];
      }
      CHECK(at_null.readings == without.readings);
      acts = acts || with.readings != without.readings;
    }
    CHECK(acts);
  }
}

// Sensitivities of the readings to every parameter that is fitted and to every first value, against central differences, after
// inputs that change at each sample. All effects are on at typical values, but for `but`.
inline void check_sensitivities(Plant plant, const std::vector<double>& start, const std::vector<double>& inputs, double period_s,
                                std::initializer_list<std::string_view> but = {}) {
  const System& system = plant.system();
  for (const EffectId e : system.effects().ids())
    if (std::find(but.begin(), but.end(), system.effects()[e].name) == but.end()) turn_on_typical(plant, e);
  const std::vector<double> first = with_effects_at_rest(plant, inputs.front(), start);
  std::vector<sim::Sample> samples;
  for (std::size_t k = 0; k < inputs.size(); ++k) samples.push_back({period_s * static_cast<double>(k), {inputs[k]}, {0.0}});
  SensitivityRequest request;
  for (const ParameterId p : system.parameters().ids()) {
    const ParameterInfo& info = system.parameters()[p];
    if (info.declaration.prior_deviation > 0.0 && (!info.effect || plant.is_on(*info.effect))) request.parameters.push_back(p);
  }
  for (const StateId i : plant.states().ids()) request.initial_states.push_back(i);
  const NumericalSettings settings{.method = Method::arkode, .relative_tolerance = 1e-11};
  const auto run = [&](const Plant& of, const std::vector<double>& from, const SensitivityRequest& wanted, auto&& at_end) {
    Integrator integrator(of, {std::vector<std::optional<double>>(from.begin(), from.end()), {inputs.front()}}, settings, wanted);
    REQUIRE(!sim::replay(integrator, system, samples, [](std::size_t) {}));
    at_end(integrator);
  };
  std::vector<double> readings;
  Eigen::MatrixXd sensitivity;
  run(plant, first, request, [&](const Integrator& at) { at.readings_with_sensitivity(readings, sensitivity); });
  double step = 0.0;
  const auto difference = [&](std::size_t column) {
    double ends[2];
    for (const int side : {0, 1}) {
      Plant moved = plant;
      std::vector<double> from = first;
      if (column < request.parameters.size()) {
        const Declaration& declared = system.parameters()[request.parameters[column]].declaration;
        step = 1e-4 * declared.prior_deviation * declared.unit.internal_per_unit;
        moved.set(request.parameters[column], plant.get(request.parameters[column]) + (side ? step : -step));
      } else {
        step = 1e-5 * plant.states()[request.initial_states[column - request.parameters.size()]].scale;
        from[column - request.parameters.size()] += side ? step : -step;
      }
      run(moved, from, {}, [&](const Integrator& at) { ends[side] = at.readings().front(); });
    }
    return (ends[1] - ends[0]) / (2.0 * step);
  };
  for (std::size_t k = 0; k < request.columns(); ++k) {
    const std::string name = k < request.parameters.size() ? system.parameters()[request.parameters[k]].key()
                                                           : plant.states()[request.initial_states[k - request.parameters.size()]].key;
    CAPTURE(name);
    const double expected = difference(k);
    // Four digits, and what runs at a tolerance of 1e-11 leave to differences.
    const double rounding = 1e-8 * plant.states()[StateId{0}].scale / step;
    CHECK(std::abs(sensitivity(0, static_cast<Eigen::Index>(k)) - expected) < 1e-3 * std::abs(expected) + rounding);
  }
}

// What holds for every small System: its file reads back as it was written, entries and beliefs are complete, bad structure is
// refused.
inline void check_lists(const Plant& plant, const std::string& name) {
  const System& system = plant.system();
  CHECK(system.name() == name);
  CHECK(system.averaging_s() == 0.0);
  std::size_t on_readings = 0;
  for (const Entry& entry : system.entries()) {
    CHECK((entry.state.has_value() != entry.channel.has_value()));
    CHECK(entry.may_depend_on.size() == system.variables().size());
    on_readings += entry.channel.has_value();
  }
  CHECK(on_readings == system.channels().size());
  CHECK(system.entry_groups().size() == system.entries().size());
  // Every effect enters somewhere, and is a function of what there is.
  for (const EffectInfo& effect : system.effects()) {
    std::size_t found = 0;
    for (const EntryGroup& group : system.entry_groups())
      found += static_cast<std::size_t>(std::count(group.places.begin(), group.places.end(), effect.place));
    CHECK(found > 0);
    const auto is_it = [&](const VariableInfo& variable) { return variable.name == effect.argument; };
    CHECK((effect.argument.empty() || std::any_of(system.variables().begin(), system.variables().end(), is_it)));
  }
  for (const ParameterInfo& info : system.parameters()) {
    CAPTURE(info.key());
    const Declaration& declared = info.declaration;
    CHECK(declared.range.contains(declared.typical));
    if (declared.null_value) CHECK(declared.range.contains(*declared.null_value));
    CHECK(!declared.meaning.empty());
  }
  Plant all = plant;
  for (const EffectId e : system.effects().ids()) turn_on_typical(all, e);
  const auto file = std::filesystem::temp_directory_path() / ("sinew_" + name + "_" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(file) << sim::plant_file_text(all);
  CHECK(sim::read_plant_file(file) == all);
  std::ofstream(file) << "format: 2\n" << name << ": {coils: 2}\n";
  CHECK_THROWS_WITH_AS(sim::read_plant_file(file), doctest::Contains(("write " + name + ": {}").c_str()), sim::InputError);
  std::filesystem::remove(file);
  const std::vector<double> nothing(system.channels().size(), std::nan(""));
  CHECK(system.start_beliefs(all, nothing).size() == all.states().size());
}

// A benchmark's recording. It is given and not in this repository: nothing where there is none.
inline std::optional<sim::Recording> benchmark(const System& system, const std::string& file) {
  const std::filesystem::path source(SINEW_SOURCE_DIR), log = source.parent_path() / "shared/data" / file;
  if (!std::filesystem::exists(log)) {
    std::printf("SKIPPED: no %s\n", log.c_str());
    return std::nullopt;
  }
  const std::string name(system.name());
  const sim::Conversion converted = sim::convert_log(log, sim::read_log_map(source / "plant" / name / (name + ".map.yaml")));
  return sim::parse_recording(sim::to_csv(converted.table), log.string(), sim::columns_of(system));
}

// RMS of reading less recording, open loop from `start` (first values of the core's states), in the unit of the file. Parameters by
// key. Nothing where there is no recording.
inline std::optional<double> open_loop_rms(Plant plant, const std::map<std::string, double>& parameters, const std::vector<double>& start,
                                           const std::string& file) {
  const std::optional<sim::Recording> given = benchmark(plant.system(), file);
  if (!given) return std::nullopt;
  const sim::Recording& recording = *given;
  for (const auto& [key, value] : parameters) set(plant, key, value);
  const std::vector<double>& first = recording.samples.front().inputs;
  const std::vector<double> from = with_effects_at_rest(plant, first.front(), start);
  Integrator integrator(plant, {std::vector<std::optional<double>>(from.begin(), from.end()), first},
                        {.method = Method::arkode, .relative_tolerance = 1e-6});
  double sum = 0.0;
  REQUIRE(!sim::replay(integrator, plant.system(), recording.samples, [&](std::size_t k) {
    const double error = sim::in_file_units(plant.system(), integrator.readings()).front() - recording.samples[k].channels.front();
    sum += error * error;
  }));
  return std::sqrt(sum / static_cast<double>(recording.samples.size()));
}

}  // namespace sinew::test::small
