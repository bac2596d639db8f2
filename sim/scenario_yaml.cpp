// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/fields.h"
#include "sim/plant_file.h"
#include "sim/scenario.h"
#include "sim/text.h"
#include "sim/yaml.h"

namespace sinew::sim {
namespace {

template <class Self, class Visitor>
void sensor_fields(Self& self, const std::string& unit, Visitor&& visit) {
  visit(self.noise, Key{"noise_" + unit, {0.0, 100.0}, "standard deviation of white noise"});
  visit(self.step, Key{"step_" + unit, {0.0, 100.0}, "quantisation; 0: none"});
  visit(self.bias, Key{"bias_" + unit, {-1000.0, 1000.0}, "added to every sample"});
  visit(self.dropout_fraction, Key{"dropout_fraction", fraction, "share of samples that are missing"});
}
template <class Self, class Visitor>
void stuck_fields(Self& self, Visitor&& visit) {
  visit(self.from_s, Key{"from_s", any_time_s, "begin", true});
  visit(self.until_s, Key{"until_s", any_time_s, "end", true});
}
template <class Self, class Visitor>
void numerics_fields(Self& self, Visitor&& visit) {
  visit(self.numerics.method, Key{"method", {}, "cvode, arkode or automatic"});
  visit(self.numerics.relative_tolerance, Key{"relative_tolerance", {1e-13, 1e-2}, "of the integrator"});
  visit(self.restart_period_s, Key{"restart_period_s", {0.001, 1e6}, "checkpoints can be taken this often"});
}

void complain_unless_ordered(const YamlValue& value, double from, double until, std::string_view from_key,
                             std::string_view until_key) {
  if (!(from < until)) {
    for (const auto& entry : value.map)
      if (entry.key == until_key) entry.value.complain("must lie after " + std::string(from_key) + " = " + shortest(from));
    value.complain(std::string(from_key) + " must lie before " + std::string(until_key));
  }
}

Signal read_signal(const YamlValue& value) {
  YamlMap map(value);
  std::optional<Signal> signal;
  const auto take = [&]<class One>(std::type_identity<One>) {
    if (const YamlValue* given = map.find(One::name)) {
      if (signal) given->complain("one signal a map; write a list for a sum of signals");
      One one;
      read_fields_of(one, *given);
      if constexpr (requires { one.until_s; }) complain_unless_ordered(*given, one.from_s, one.until_s, "from_s", "until_s");
      signal = one;
    }
  };
  [&]<class... All>(std::type_identity<std::variant<All...>>) {
    (take(std::type_identity<All>{}), ...);
  }(std::type_identity<Signal>{});
  map.finish();
  if (!signal) value.complain("must be one of constant, step, ramp, sine, chirp, prbs");
  return *signal;
}

std::vector<Signal> read_signals(const YamlValue& value) {
  std::vector<Signal> signals;
  if (value.kind == YamlValue::Kind::list)
    for (const YamlValue& one : value.list) signals.push_back(read_signal(one));
  else
    signals.push_back(read_signal(value));
  return signals;
}

Input read_input(const YamlValue& value, const std::filesystem::path& folder) {
  YamlMap map(value);
  const YamlValue* babble = map.find(BabbleInput::name);
  const YamlValue* replay = map.find(ReplayInput::name);
  const plant::PerCoil<const YamlValue*> duty{map.find("duty_A"), map.find("duty_B")};
  map.finish();
  if ((babble != nullptr) + (replay != nullptr) + (duty[plant::A] || duty[plant::B]) > 1)
    value.complain("one of babble, replay, or duty_A and duty_B");
  if (babble) {
    BabbleInput input;
    read_fields_of(input, *babble);
    complain_unless_ordered(*babble, input.lowest_deg, input.highest_deg, "lowest_deg", "highest_deg");
    complain_unless_ordered(*babble, input.shortest_hold_s, input.longest_hold_s, "shortest_hold_s", "longest_hold_s");
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
    input.recording = read_recording(path);
    input.recording_path = std::filesystem::absolute(path).lexically_normal().string();
    return input;
  }
  OpenLoopInput input;
  for (const std::size_t j : plant::coils)
    if (duty[j]) input.duty[j] = read_signals(*duty[j]);
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

// Keys are those of the states, with angles in degrees as everywhere in files.
std::string start_key(const plant::Layout::Entry& entry) {
  std::string key = entry.key;
  const std::size_t at = key.rfind("_rad");
  if (at != std::string::npos) key.replace(at, 4, "_deg");
  return key;
}
plant::Range start_range(const plant::Layout::Entry& entry) {
  if (entry.key.ends_with("_fraction")) return fraction;
  return {-1000.0, 1000.0};
}
double start_unit(const plant::Layout::Entry& entry) {
  const auto& unit = entry.declaration.unit.text;
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

std::int64_t Scenario::ticks() const { return std::llround(duration_s / sample_period_s) + 1; }
std::int64_t Scenario::restart_ticks() const {
  return std::max<std::int64_t>(1, std::llround(restart_period_s / sample_period_s));
}
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
                  *limb = map.find("plant"), *input = map.find("input"), *sensors = map.find("sensors"),
                  *numerics = map.find("numerics"), *start = map.find("start");
  map.finish();
  map.require("format", "format: 1");
  map.require("duration_s", "how long the scenario lasts");
  if (seed) {
    scenario.seed = seed->whole_number();
    if (scenario.seed < 0) seed->complain("must not be negative");
  }
  scenario.duration_s = duration->number_in({0.1, 1e6});
  if (period) scenario.sample_period_s = period->number_in({0.001, 60.0});
  if (limb) scenario.limb = read_plant(*limb, folder);
  if (input) scenario.input = read_input(*input, folder);
  if (sensors) {
    YamlMap inner(*sensors);
    if (const YamlValue* one = inner.find("temperature_A"))
      scenario.sensors.temperature[plant::A] = read_sensor(*one, scenario.sensors.temperature[plant::A], "degC");
    if (const YamlValue* one = inner.find("temperature_B"))
      scenario.sensors.temperature[plant::B] = read_sensor(*one, scenario.sensors.temperature[plant::B], "degC");
    if (const YamlValue* one = inner.find("angle")) scenario.sensors.angle = read_sensor(*one, scenario.sensors.angle, "deg");
    inner.finish();
  }
  if (numerics) {
    YamlMap inner(*numerics);
    numerics_fields(scenario, Assign{inner});
    inner.finish();
  }
  const plant::Layout layout = plant::layout_of(scenario.limb.on);
  scenario.start.assign(layout.size(), std::nullopt);
  if (start) {
    YamlMap inner(*start);
    for (std::size_t i = 0; i < layout.size(); ++i)
      if (const YamlValue* one = inner.find(start_key(layout.entries[i])))
        scenario.start[i] = one->number_in(start_range(layout.entries[i])) * start_unit(layout.entries[i]);
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
          "\nsample_period_s: " + shortest(scenario.sample_period_s) + "\nplant:\n" + plant_to_yaml(scenario.limb, 2);
  const plant::Layout layout = plant::layout_of(scenario.limb.on);
  std::string start;
  for (std::size_t i = 0; i < scenario.start.size(); ++i)
    if (scenario.start[i])
      start += "  " + start_key(layout.entries[i]) + ": " + text_in_unit(*scenario.start[i], start_unit(layout.entries[i])) + "\n";
  text += start.empty() ? "start: {}\n" : "start:\n" + start;
  text += "input:";
  if (const auto* babble = std::get_if<BabbleInput>(&scenario.input)) {
    text += "\n  babble:\n";
    BabbleInput::fields(*babble, Write{text, "    "});
  } else if (const auto* replay = std::get_if<ReplayInput>(&scenario.input)) {
    text += "\n  replay: { recording: " + single_quoted(replay->recording_path) + " }\n";
  } else {
    const auto& open_loop = std::get<OpenLoopInput>(scenario.input);
    std::string duties;
    for (const std::size_t j : plant::coils) {
      if (open_loop.duty[j].empty()) continue;
      duties += j == plant::A ? "  duty_A:\n" : "  duty_B:\n";
      for (const Signal& signal : open_loop.duty[j])
        std::visit(
            [&]<class One>(const One& one) {
              duties += "    - " + std::string(One::name) + ":\n";
              One::fields(one, Write{duties, "        "});
            },
            signal);
    }
    text += duties.empty() ? " {}\n" : "\n" + duties;
  }
  text += "sensors:\n";
  write_sensor(text, "temperature_A", scenario.sensors.temperature[plant::A], "degC");
  write_sensor(text, "temperature_B", scenario.sensors.temperature[plant::B], "degC");
  write_sensor(text, "angle", scenario.sensors.angle, "deg");
  text += "numerics:\n";
  numerics_fields(scenario, Write{text, "  "});
  return text;
}

}  // namespace sinew::sim
