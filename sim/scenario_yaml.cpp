// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/plain_text.h"
#include "sim/plant_file.h"
#include "sim/scenario_fields.h"
#include "sim/text.h"
#include "sim/yaml.h"

namespace sinew::sim {
namespace {

void complain_unless_ordered(const YamlValue& value, double from, double until, std::string_view from_key, std::string_view until_key) {
  if (!(from < until)) {
    for (const auto& entry : value.map)
      if (entry.key == until_key) entry.value.complain("must lie after " + std::string(from_key) + " = " + shortest(from));
    value.complain(std::string(from_key) + " must lie before " + std::string(until_key));
  }
}

Signal read_signal(const YamlValue& value, const plant::InputInfo& input) {
  YamlMap map(value);
  std::optional<Signal> signal;
  const auto take = [&]<class One>(std::type_identity<One>) {
    if (const YamlValue* given = map.find(One::name)) {
      if (signal) given->complain("one signal a map; write a list for a sum of signals");
      One one;
      read_fields(*given, [&](auto&& visit) { One::fields(one, [&](auto& field, const Key& key) { visit(field, key_for(input, key)); }); });
      if constexpr (requires { one.until_s; }) complain_unless_ordered(*given, one.from_s, one.until_s, "from_s", "until_s");
      signal = one;
    }
  };
  [&]<class... All>(std::type_identity<std::variant<All...>>) { (take(std::type_identity<All>{}), ...); }(std::type_identity<Signal>{});
  map.finish();
  if (!signal) value.complain("must be one of constant, step, ramp, sine, chirp, prbs");
  return *signal;
}

std::vector<Signal> read_signals(const YamlValue& value, const plant::InputInfo& input) {
  std::vector<Signal> signals;
  if (value.kind == YamlValue::Kind::list)
    for (const YamlValue& one : value.list) signals.push_back(read_signal(one, input));
  else
    signals.push_back(read_signal(value, input));
  return signals;
}

Input read_input(const YamlValue& value, const std::filesystem::path& folder, const plant::System& system) {
  YamlMap map(value);
  const YamlValue* babble = map.find(BabbleInput::name);
  const YamlValue* replay = map.find(ReplayInput::name);
  std::vector<const YamlValue*> signals;
  std::string columns;
  bool any_signal = false;
  for (const plant::InputInfo& input : system.inputs()) {
    signals.push_back(map.find(input.column));
    any_signal = any_signal || signals.back();
    columns += (columns.empty() ? "" : " and ") + input.column;
  }
  map.finish();
  if ((babble != nullptr) + (replay != nullptr) + any_signal > 1) value.complain("one of babble, replay, or " + columns);
  if (babble) {
    BabbleInput input;
    read_fields_of(input, *babble);
    complain_unless_ordered(*babble, input.lowest_deg, input.highest_deg, "lowest_deg", "highest_deg");
    complain_unless_ordered(*babble, input.shortest_hold_s, input.longest_hold_s, "shortest_hold_s", "longest_hold_s");
    if (system.drives().empty()) babble->complain("needs a channel that an input is known to drive; this plant has none");
    std::string names;
    bool known = input.positive_drives.empty();
    for (const plant::InputInfo& one : system.inputs()) {
      names += (names.empty() ? "" : " or ") + one.name;
      known = known || one.name == input.positive_drives;
    }
    for (const auto& entry : babble->map)
      if (entry.key == "positive_drives" && !known) entry.value.complain("must be " + names);
    if (input.positive_drives.empty()) input.positive_drives = system.inputs()[system.drives().front().input].name;
    return input;
  }
  if (replay) {
    ReplayInput input;
    YamlMap inner(*replay);
    inner.find("recording");
    inner.finish();
    const YamlValue& file = inner.require("recording", "a recording's file, looked for beside this one");
    std::filesystem::path path = folder / file.text();
    if (!std::filesystem::exists(path)) file.complain("no such file; looked for " + path.string());
    input.recording = read_recording(path, system);
    input.recording_path = std::filesystem::absolute(path).lexically_normal().string();
    if (!is_plain_text(input.recording_path))
      file.complain("lies in a folder whose name is not UTF-8 without control characters: " + printable(input.recording_path, 4096));
    return input;
  }
  OpenLoopInput input;
  input.signals.resize(signals.size());
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (signals[i]) input.signals[i] = read_signals(*signals[i], system.inputs()[plant::InputId{i}]);
  return input;
}

SensorSettings read_sensor(const YamlValue& value, SensorSettings settings, const std::string& unit) {
  YamlMap map(value);
  sensor_fields(settings, unit, Assign{map});
  if (const YamlValue* given = map.find("stuck")) {
    Stuck stuck;
    read_fields(*given, [&](auto&& visit) { stuck_fields(stuck, visit); });
    complain_unless_ordered(*given, stuck.from_s, stuck.until_s, "from_s", "until_s");
    settings.stuck = stuck;
  }
  map.finish();
  return settings;
}

double start_unit(const plant::StateInfo& state) {
  const auto& unit = state.unit.text;
  return unit == plant::units::rad.text || unit == plant::units::rad_s.text ? plant::radians_per_degree : 1.0;
}

std::vector<std::string> comments_of(std::string_view text) {
  std::vector<std::string> comments;
  while (!text.empty() && text.front() == '#') {
    const std::size_t end = std::min(text.find('\n'), text.size());
    comments.emplace_back(trimmed(text.substr(1, end - 1)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return comments;
}

// As YAML's single quotes want it: a quote inside stands twice.
std::string single_quoted(std::string_view path) {
  std::string text = "'";
  for (const char c : path) text += c == '\'' ? std::string("''") : std::string(1, c);
  return text + "'";
}

void write_sensor(std::string& text, const std::string& name, const SensorSettings& settings, const std::string& unit) {
  text += "  " + name + ":\n";
  sensor_fields(settings, unit, Write{text, "    "});
  if (settings.stuck) {
    text += "    stuck:\n";
    stuck_fields(*settings.stuck, Write{text, "      "});
  }
}

}  // namespace

Key key_for(const plant::InputInfo& input, const Key& key) {
  constexpr std::string_view any = "_fraction";
  if (!key.name.ends_with(any) || input.unit.text.empty()) return key;
  Key result = key;
  result.name.replace(key.name.size() - any.size(), any.size(), "_" + std::string(input.unit.text));
  result.range = input.range;
  return result;
}

std::string start_key(const plant::StateInfo& state) {
  std::string key = state.key;
  const std::size_t at = key.rfind("_rad");
  if (at != std::string::npos) key.replace(at, 4, "_deg");
  return key;
}
plant::Range start_range(const plant::StateInfo& state) {
  if (state.key.ends_with("_fraction")) return fraction;
  return {-1000.0, 1000.0};
}

std::int64_t Scenario::ticks() const { return std::llround(duration_s / sample_period_s) + 1; }
std::int64_t Scenario::restart_ticks() const { return std::max<std::int64_t>(1, std::llround(restart_period_s / sample_period_s)); }
double Scenario::time_s(std::int64_t tick) const {
  // A period of 0.1 is not exact in binary; its rate of 10 is, and the quotient is rounded once.
  const double rate_Hz = std::round(1.0 / sample_period_s);
  if (std::abs(rate_Hz * sample_period_s - 1.0) < 1e-12) return static_cast<double>(tick) / rate_Hz;
  return static_cast<double>(tick) * sample_period_s;
}

Scenario parse_scenario(std::string_view text, const std::filesystem::path& file) {
  const YamlValue root = parse_yaml(text, file.string());
  const std::filesystem::path folder = file.parent_path();
  Scenario scenario;
  scenario.comments = comments_of(text);
  YamlMap map(root);
  // A file of another format may have other keys; otherwise unknown keys come first, then what is missing.
  if (const YamlValue* format = map.find("format"); format && format->whole_number() != 1)
    format->complain("must be 1, the format that this version reads");
  const YamlValue *seed = map.find("seed"), *duration = map.find("duration_s"), *period = map.find("sample_period_s"),
                  *plant = map.find("plant"), *input = map.find("input"), *sensors = map.find("sensors"), *numerics = map.find("numerics"),
                  *start = map.find("start");
  map.finish();
  map.require("format", "format: 1");
  map.require("duration_s", "how long the scenario lasts");
  if (seed) {
    scenario.seed = seed->whole_number();
    if (scenario.seed < 0) seed->complain("must not be negative");
  }
  scenario.duration_s = duration->number_in(durations_s);
  if (period) scenario.sample_period_s = period->number_in(sample_periods_s);
  if (plant) scenario.plant = read_plant(*plant, folder);
  const plant::System& system = scenario.plant.system();
  scenario.sensors = usual_sensors(system);
  if (input) scenario.input = read_input(*input, folder, system);
  if (sensors) {
    YamlMap inner(*sensors);
    for (const plant::ChannelId c : system.channels().ids()) {
      const plant::ChannelInfo& channel = system.channels()[c];
      if (const YamlValue* one = inner.find(channel.short_name))
        scenario.sensors[c.index] = read_sensor(*one, scenario.sensors[c.index], std::string(channel.unit.text));
    }
    inner.finish();
  }
  if (numerics) {
    YamlMap inner(*numerics);
    numerics_fields(scenario, Assign{inner});
    inner.finish();
  }
  const plant::States states = scenario.plant.states();
  scenario.start.assign(states.size(), std::nullopt);
  if (start) {
    YamlMap inner(*start);
    for (const plant::StateId i : states.ids())
      if (const YamlValue* one = inner.find(start_key(states[i])))
        scenario.start[i.index] = one->number_in(start_range(states[i])) * start_unit(states[i]);
    inner.finish("a state that is left out is at rest");
  }
  if (scenario.ticks() > 20'000'000) root.complain("more than 20 million samples; shorten duration_s or lengthen sample_period_s");
  return scenario;
}

Scenario read_scenario(const std::filesystem::path& file) { return parse_scenario(read_file(file), file); }

std::string to_yaml(const Scenario& scenario) {
  std::string text;
  for (const std::string& comment : scenario.comments) text += "# " + comment + "\n";
  text += "format: 1\nseed: " + std::to_string(scenario.seed) + "\nduration_s: " + shortest(scenario.duration_s) +
          "\nsample_period_s: " + shortest(scenario.sample_period_s) + "\nplant:\n" + plant_to_yaml(scenario.plant, 2);
  const plant::System& system = scenario.plant.system();
  const plant::States states = scenario.plant.states();
  std::string start;
  for (const plant::StateId i : states.ids())
    if (i.index < scenario.start.size() && scenario.start[i.index])
      start += "  " + start_key(states[i]) + ": " + text_in_unit(*scenario.start[i.index], start_unit(states[i])) + "\n";
  text += start.empty() ? "start: {}\n" : "start:\n" + start;
  text += "input:";
  if (const auto* babble = std::get_if<BabbleInput>(&scenario.input)) {
    text += "\n  babble:\n";
    BabbleInput::fields(*babble, Write{text, "    "});
  } else if (const auto* replay = std::get_if<ReplayInput>(&scenario.input)) {
    text += "\n  replay: { recording: " + single_quoted(replay->recording_path) + " }\n";
  } else {
    const auto& open_loop = std::get<OpenLoopInput>(scenario.input);
    std::string signals;
    for (const plant::InputId i : system.inputs().ids()) {
      if (i.index >= open_loop.signals.size() || open_loop.signals[i.index].empty()) continue;
      signals += "  " + system.inputs()[i].column + ":\n";
      for (const Signal& signal : open_loop.signals[i.index])
        std::visit(
            [&]<class One>(const One& one) {
              signals += "    - " + std::string(One::name) + ":\n";
              const Write write{signals, "        "};
              One::fields(one, [&](const auto& field, const Key& key) { write(field, key_for(system.inputs()[i], key)); });
            },
            signal);
    }
    text += signals.empty() ? " {}\n" : "\n" + signals;
  }
  text += "sensors:\n";
  for (const plant::ChannelId c : system.channels().ids())
    write_sensor(text, system.channels()[c].short_name, scenario.sensors.at(c.index), std::string(system.channels()[c].unit.text));
  text += "numerics:\n";
  numerics_fields(scenario, Write{text, "  "});
  return text;
}

}  // namespace sinew::sim
