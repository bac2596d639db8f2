// SPDX-License-Identifier: Apache-2.0
#include "model/dataset.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/fields.h"
#include "sim/plant_file.h"

namespace sinew::model {
namespace {

constexpr double cut_deviations = 2.5;
constexpr std::int64_t seeds_apart = 1000003;

// A number of a sensor: its key without the unit of the channel, which follows where `unit` says so.
struct SensorKey {
  std::string_view name;
  bool unit;
  plant::Range range;
  double& (*field)(sim::SensorSettings&);
};
sim::Stuck& stuck(sim::SensorSettings& sensor) { return sensor.stuck ? *sensor.stuck : sensor.stuck.emplace(); }
constexpr SensorKey sensor_keys[] = {
    {"noise", true, {0.0, 100.0}, [](sim::SensorSettings& s) -> double& { return s.noise; }},
    {"step", true, {0.0, 100.0}, [](sim::SensorSettings& s) -> double& { return s.step; }},
    {"bias", true, {-1000.0, 1000.0}, [](sim::SensorSettings& s) -> double& { return s.bias; }},
    {"dropout_fraction", false, sim::fraction, [](sim::SensorSettings& s) -> double& { return s.dropout_fraction; }},
    {"stuck_from_s", false, sim::any_time_s, [](sim::SensorSettings& s) -> double& { return stuck(s).from_s; }},
    {"stuck_until_s", false, sim::any_time_s, [](sim::SensorSettings& s) -> double& { return stuck(s).until_s; }}};

// Null where there is none.
const SensorKey* sensor_key(const plant::ChannelInfo& channel, std::string_view key) {
  for (const SensorKey& one : sensor_keys)
    if (key == std::string(one.name) + (one.unit ? "_" + std::string(channel.unit.text) : "")) return &one;
  return nullptr;
}

Draw read_draw(const sim::YamlValue& value, const plant::Range& range) {
  if (value.kind == sim::YamlValue::Kind::scalar) {
    const double always = value.number_in(range);
    return {{}, {}, always, always};
  }
  sim::YamlMap map(value);
  Draw draw;
  const auto* relative = map.find("relative_deviation");
  const auto* absolute = map.find("deviation");
  const auto* lowest = map.find("lowest");
  const auto* highest = map.find("highest");
  map.finish();
  if ((relative != nullptr) + (absolute != nullptr) + (lowest && highest) != 1 || (lowest != nullptr) != (highest != nullptr))
    value.complain("must give relative_deviation, or deviation, or lowest and highest");
  if (relative) draw.relative_deviation = relative->number_in({0.0, 1.0});
  if (absolute) draw.deviation = absolute->number_in({0.0, range.highest - range.lowest});
  if (lowest) {
    draw.lowest = lowest->number_in(range);
    draw.highest = highest->number_in(range);
    if (draw.lowest > draw.highest) highest->complain("must not lie below lowest = " + sim::shortest(draw.lowest));
  }
  return draw;
}

double drawn(const Draw& draw, double nominal, const plant::Range& range, std::uint64_t seed, const std::string& name) {
  const sim::RandomStream chance(seed, "domain." + name);
  if (!draw.relative_deviation && !draw.deviation) return draw.lowest + (draw.highest - draw.lowest) * chance.uniform(0);
  const double deviation = draw.deviation ? *draw.deviation : *draw.relative_deviation * std::abs(nominal);
  for (std::uint64_t n = 0; n < 1000; ++n) {
    const double z = chance.normal(n), value = nominal + deviation * z;
    if (std::abs(z) <= cut_deviations && range.contains(value)) return value;
  }
  throw std::runtime_error(name + ": no draw around " + sim::shortest(nominal) + " lies in its range");
}

plant::ParameterId parameter_named(const plant::System& system, const std::string& owner, std::string_view name,
                                   const sim::YamlValue& value) {
  std::vector<std::string_view> known;
  for (const plant::ParameterId p : system.parameters().ids()) {
    const plant::ParameterInfo& info = system.parameters()[p];
    if (info.owner != owner || info.declaration.kind != plant::Kind::real) continue;
    if (info.declaration.name == name) return p;
    known.push_back(info.declaration.name);
  }
  const std::string near = sim::nearest(name, known);
  value.complain("no such number to draw" + (near.empty() ? std::string() : "; did you mean " + near + "?"));
}

// "a, b and c"
std::string names_of_sensors(const plant::System& system) {
  std::string text;
  for (const plant::ChannelId c : system.channels().ids()) {
    const bool last = c.index + 1 == system.channels().size();
    text += (c.index == 0 ? "" : last ? " and " : ", ") + system.channels()[c].short_name;
  }
  return text;
}

}  // namespace

Domain read_domain(const std::filesystem::path& file, const plant::System& system) { return read_domain(sim::read_yaml(file), system); }

Domain read_domain(const sim::YamlValue& root, const plant::System& system) {
  sim::YamlMap map(root);
  if (const auto* format = map.find("format"); format && format->whole_number() != 1)
    format->complain("must be 1, the format that this version reads");
  const auto *parameters = map.find("parameters"), *effects = map.find("effects"), *sensors = map.find("sensors"),
             *input = map.find("input");
  map.finish();
  Domain domain;
  const auto each = [](const sim::YamlValue* value, auto&& take) {
    if (!value) return;
    sim::YamlMap entries(*value);
    for (const auto& entry : value->map) take(entry.key, entry.value);
  };
  each(parameters, [&](const std::string& name, const sim::YamlValue& value) {
    const plant::ParameterId p = parameter_named(system, "", name, value);
    domain.parameters.emplace_back(p, read_draw(value, system.parameters()[p].declaration.range));
  });
  each(effects, [&](const std::string& name, const sim::YamlValue& value) {
    Domain::Effect effect;
    std::vector<std::string_view> known;
    for (const auto& one : system.effects()) known.push_back(one.name);
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) {
      const std::string near = sim::nearest(name, known);
      value.complain("no such effect" + (near.empty() ? std::string() : "; did you mean " + near + "?") +
                     " `sinew effects` lists all of them");
    }
    effect.effect = plant::EffectId{static_cast<std::size_t>(found - known.begin())};
    each(&value, [&](const std::string& key, const sim::YamlValue& one) {
      if (key == "probability") {
        effect.probability = one.number_in(sim::fraction);
        return;
      }
      const plant::ParameterId p = parameter_named(system, name, key, one);
      effect.parameters.emplace_back(p, read_draw(one, system.parameters()[p].declaration.range));
    });
    domain.effects.push_back(effect);
  });
  each(sensors, [&](const std::string& name, const sim::YamlValue& value) {
    const auto found =
        std::find_if(system.channels().begin(), system.channels().end(), [&](const auto& one) { return one.short_name == name; });
    if (found == system.channels().end()) value.complain("no such sensor; there are " + names_of_sensors(system));
    const plant::ChannelId channel{static_cast<std::size_t>(found - system.channels().begin())};
    each(&value, [&](const std::string& key, const sim::YamlValue& one) {
      const SensorKey* known = sensor_key(*found, key);
      if (!known)
        one.complain(
            "no such number of this sensor; there are noise, step and bias, each with its unit, dropout_fraction, stuck_from_s and "
            "stuck_until_s");
      domain.sensors.push_back({channel, key, read_draw(one, known->range)});
    });
  });
  each(input, [&](const std::string& name, const sim::YamlValue& value) {
    sim::BabbleInput babble;
    bool found = false;
    sim::BabbleInput::fields(babble, [&](auto& field, const sim::Key& key) {
      if constexpr (std::is_same_v<std::remove_reference_t<decltype(field)>, double>)
        if (key.name == name) {
          found = true;
          domain.input.emplace_back(name, read_draw(value, key.range));
        }
    });
    if (!found) value.complain("no such number of a babbling input");
  });
  return domain;
}

DrawnRun drawn_run(const sim::Scenario& scenario, const Domain& domain, std::int64_t run) {
  DrawnRun result{scenario, {}};
  sim::Scenario& one = result.scenario;
  one.seed = scenario.seed * seeds_apart + run;
  const auto seed = static_cast<std::uint64_t>(one.seed);
  const plant::System& system = one.plant.system();
  const auto draw_parameter = [&](plant::ParameterId p, const Draw& draw) {
    const plant::ParameterInfo& info = system.parameters()[p];
    const double value = drawn(draw, one.plant.get_in_file_units(p), info.declaration.range, seed, info.key());
    one.plant.set_in_file_units(p, value);
    result.drawn.emplace_back(info.key(), value);
  };
  for (const auto& [p, draw] : domain.parameters) draw_parameter(p, draw);
  for (const Domain::Effect& effect : domain.effects) {
    const plant::EffectInfo& info = system.effects()[effect.effect];
    if (sim::RandomStream(seed, "domain." + std::string(info.name)).uniform(0) >= effect.probability) continue;
    one.plant.turn(effect.effect, true);
    for (const plant::ParameterId p : info.parameters) one.plant.set_in_file_units(p, system.parameters()[p].declaration.typical);
    for (const auto& [p, draw] : effect.parameters) draw_parameter(p, draw);
  }
  // An effect that came brings states of its own, at rest.
  const plant::States before = scenario.plant.states(), after = one.plant.states();
  if (!scenario.start.empty()) {
    one.start.assign(after.size(), std::nullopt);
    for (const plant::StateId i : after.ids())
      for (const plant::StateId k : before.ids())
        if (after[i].key == before[k].key) one.start[i.index] = scenario.start[k.index];
  }
  for (const auto& [channel, key_name, draw] : domain.sensors) {
    const plant::ChannelInfo& info = system.channels()[channel];
    const std::string name = info.short_name + "." + key_name;
    const SensorKey& key = *sensor_key(info, key_name);
    double& field = key.field(one.sensors[channel.index]);
    const double value = field = drawn(draw, field, key.range, seed, "sensors." + name);
    result.drawn.emplace_back(name, value);
  }
  if (auto* babble = std::get_if<sim::BabbleInput>(&one.input))
    for (const auto& [name, draw] : domain.input)
      sim::BabbleInput::fields(*babble, [&](auto& field, const sim::Key& key) {
        if constexpr (std::is_same_v<std::remove_reference_t<decltype(field)>, double>)
          if (key.name == name) {
            field = drawn(draw, field, key.range, seed, "input." + name);
            result.drawn.emplace_back(name, field);
          }
      });
  // What was drawn must be a scenario together too: a begin before its end, a lowest below its highest.
  static_cast<void>(sim::parse_scenario(sim::to_yaml(one), "run " + std::to_string(run) + " of the domain"));
  return result;
}

}  // namespace sinew::model
