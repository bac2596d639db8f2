// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/limb.h"

#include "plant/contains.h"

namespace sinew::plant {
namespace {

// Order of entry_groups_.
struct Groups {
  enum : std::size_t { air, heat, transformation, moment, temperature_reading, angle_reading };
};

// One, and several.
std::pair<std::string_view, std::string_view> part_words(Part part) {
  switch (part) {
    case Part::coil:
    case Part::thermocouple:
      return {"coil", "coils"};
    case Part::pair:
      return {"pair of coils", "pairs of coils"};
    case Part::segment:
      return {"segment", "segments"};
    case Part::bend:
    case Part::bend_sensor:
      return {"bend", "bends"};
    case Part::room:
    case Part::supply:
      break;
  }
  return {"", ""};
}

std::string with_name(const std::string& words, const std::string& name) { return name.empty() ? words : words + " " + name; }

}  // namespace

std::size_t part_count(const Shape& shape, Part part) {
  switch (part) {
    case Part::room:
    case Part::supply:
      return 1;
    case Part::coil:
      return shape.coils.size();
    case Part::pair:
      return shape.pairs.size();
    case Part::segment:
      return shape.segments.size();
    case Part::bend:
      return shape.bends.size();
    case Part::thermocouple:
      return shape.thermocouple_coils.size();
    case Part::bend_sensor:
      return shape.sensor_bends.size();
  }
  return 0;
}

std::vector<std::string> part_names(const Shape& shape, Part part) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < part_count(shape, part); ++k) {
    const std::size_t p = part_of(shape, part, k);
    switch (part) {
      case Part::room:
      case Part::supply:
        names.emplace_back();
        break;
      case Part::coil:
      case Part::thermocouple:
        names.push_back(shape.coils[p].name);
        break;
      case Part::pair:
        names.push_back(shape.coils[shape.pairs[p].first].name + "_" + shape.coils[shape.pairs[p].second].name);
        break;
      case Part::segment:
        names.push_back(shape.segment_names[p]);
        break;
      case Part::bend:
      case Part::bend_sensor:
        names.push_back(shape.bends[p].name);
        break;
    }
  }
  return names;
}

namespace {

// The shape with what coils have of their own of the core; what effects have is left.
std::vector<OwnValues> take_own_of_core(Shape& shape, const std::vector<OwnValues>& own) {
  std::vector<OwnValues> of_effects;
  const Core<double> core(shape);
  for (const OwnValues& one : own) {
    if (!one.effect.empty()) {
      of_effects.push_back(one);
      continue;
    }
    const std::size_t before = shape.own.size();
    Core<double>::each_of_coils(core, [&](const OfCoils<double>& shared, std::string_view key) {
      for (std::size_t j = 0; j < shape.coils.size(); ++j)
        if (one.key == shared.own_key(key, shape.coils[j].name) && !shape.is_own(shared.quantity, j))
          shape.own.emplace_back(shared.quantity, j);
    });
    if (shape.own.size() == before) throw DescriptionError(one.path, "no such parameter");
  }
  return of_effects;
}

}  // namespace

LimbSystem::LimbSystem(Shape shape, const std::vector<OwnValues>& own) : shape_(std::move(shape)), own_values_(own) {
  name_ = "limb";
  words_ = "the limb";
  averaging_s_ = 0.5;
  parts_word_ = "coils";
  upstream_kind_ = "temperature";
  upstream_places_ = {text_of(Place::thermal), text_of(Place::actuation), text_of(Place::sensor_temperature)};
  const auto names = [&](Part part) { return part_names(shape_, part); };
  const std::vector<OwnValues> of_effects = take_own_of_core(shape_, own);
  own_ = own_parts_of(of_effects, LimbValues<double>(Core<double>(shape_), {}), names);
  list_parameters_and_effects(LimbValues<double>(Core<double>(shape_), own_), names, parameters_, effects_);
  for (const Shape::Coil& coil : shape_.coils)
    inputs_.push_back({"duty_" + coil.name, coil.name, "coil " + coil.name, "duty " + coil.name, units::none, {0.0, 1.0}});
  list_channels();
  list_entries();
  list_drives();
  list_sharings();
  if (shape_.is_two_coil_limb) list_loggers();

  const auto values_of = [&](const char* before, const char* unit, const std::vector<std::string>& parts) {
    std::vector<ParameterId> all;
    for (const std::string& part : parts) all.push_back(parameter(before + (part.empty() ? "" : "_" + part) + unit));
    return all;
  };
  const Core<double> core(shape_);
  const auto of_coils = [&](std::initializer_list<const char*> keys) {
    std::vector<ParameterId> all;
    for (const char* key : keys) {
      all.push_back(parameter(key));
      Core<double>::each_of_coils(core, [&](const OfCoils<double>& shared, std::string_view its_key) {
        for (std::size_t j = 0; j < shape_.coils.size(); ++j)
          if (its_key == key && shape_.is_own(shared.quantity, j)) all.push_back(parameter(shared.own_key(key, shape_.coils[j].name)));
      });
    }
    return all;
  };
  const auto constant = [&](std::string words, Place place, std::vector<ParameterId> which) {
    constants_.push_back({.words = std::move(words), .place = text_of(place), .parameters = std::move(which)});
  };
  constant("the supply's voltage", Place::actuation, {parameter("supply_voltage_V")});
  constant("the wires' heat capacity", Place::thermal, values_of("heat_capacity", "_J_K", names(Part::coil)));
  constant("the level of the transformation temperatures", Place::transformation,
           of_coils({"heating_midpoint_degC", "cooling_midpoint_degC"}));
  constants_.back().scale = 5.0;
  constants_.back().unit = "K";
  constant("the stretch that the transformation makes", Place::transformation, of_coils({"transformation_stretch_m"}));
  constant("the stiffness of austenite", Place::mechanics, of_coils({"austenite_stiffness_N_m"}));
  constant("the stiffness of martensite", Place::mechanics, of_coils({"martensite_stiffness_N_m"}));
  constant("the beam's stiffness", Place::mechanics, values_of("beam_stiffness", "_Nm_rad", names(Part::segment)));
  constant("the beam's damping", Place::mechanics, values_of("beam_damping", "_Nms_rad", names(Part::segment)));
  const auto gain = [&](std::string words, Place place, std::string_view kind, std::optional<ParameterId> about) {
    Constant one{.words = std::move(words), .place = text_of(place), .about = about};
    for (const ChannelId c : channels_.ids())
      if (channels_[c].kind == kind) one.channels.push_back(c);
    if (!one.channels.empty()) constants_.push_back(std::move(one));
  };
  gain("the thermocouples' gain", Place::sensor_temperature, "temperature", parameter("ambient_temperature_degC"));
  gain("the bend sensor's gain", Place::sensor_angle, "angle", std::nullopt);
}

void LimbSystem::list_sharings() {
  const std::vector<std::string> coils = part_names(shape_, Part::coil);
  const Core<double> core(shape_);
  const auto own_keys = [&](std::string_view wanted) {
    std::vector<std::string> keys;
    Core<double>::each_of_coils(core, [&](const OfCoils<double>& shared, std::string_view key) {
      if (wanted.empty() || key == wanted)
        for (const std::string& coil : coils) keys.push_back(shared.own_key(key, coil));
    });
    return keys;
  };
  own_keys_ = own_keys("");
  const auto of_core = [&](std::string words, std::initializer_list<const char*> keys) {
    Sharing one{std::move(words), std::nullopt, text_of(Place::transformation), "coil", "coils", coils, {{}}};
    bool shared_by_all = coils.size() > 1;
    for (const char* key : keys) {
      one.moves.front().push_back({parameter(key), own_keys(key)});
      for (const std::string& own : one.moves.front().back().own_keys) shared_by_all = shared_by_all && !find_parameter(own);
    }
    if (shared_by_all) sharings_.push_back(std::move(one));
  };
  of_core("the transformation temperatures", {"heating_midpoint_degC", "cooling_midpoint_degC"});
  of_core("the widths of the transformation", {"heating_width_K", "cooling_width_K"});
  of_core("the stretch that the transformation makes", {"transformation_stretch_m"});
  LimbValues<double>(core, own_).each_effect([&](auto index, const auto& instances) {
    using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
    const std::vector<std::string> parts = part_names(shape_, Effect::part);
    if (parts.size() < 2 || !instances.own_parts.empty()) return;
    const auto [part_word, parts_word] = part_words(Effect::part);
    Sharing one{std::string(Effect::name), EffectId{index}, text_of(Effect::place), part_word, parts_word, parts, {}};
    for (const ParameterId p : effects_[EffectId{index}].parameters) {
      const Declaration& declared = parameters_[p].declaration;
      if (declared.kind != Kind::real || declared.prior_deviation <= 0.0) continue;
      Sharing::Quantity quantity{p, {}};
      for (const std::string& part : parts) quantity.own_keys.push_back(std::string(Effect::name) + "." + part + "." + declared.name);
      one.moves.push_back({std::move(quantity)});
    }
    if (!one.moves.empty()) sharings_.push_back(std::move(one));
  });
}

std::shared_ptr<const System> LimbSystem::with_own(const std::vector<std::size_t>& sharings) const {
  std::vector<OwnValues> own = own_values_;
  for (const std::size_t s : sharings) {
    const Sharing& one = sharings_[s];
    if (one.effect)
      for (const std::string& part : one.parts) own.push_back({"", std::string(effects_[*one.effect].name), part});
    else
      for (const auto& move : one.moves)
        for (const Sharing::Quantity& quantity : move)
          for (const std::string& key : quantity.own_keys) own.push_back({"", "", "", key});
  }
  Shape plain = shape_;
  plain.own.clear();
  return std::make_shared<const LimbSystem>(std::move(plain), own);
}

void LimbSystem::list_channels() {
  for (const Shape::Sensor& sensor : shape_.sensors) {
    ChannelInfo info;
    info.column = sensor.column;
    info.short_name = sensor.column.substr(0, sensor.column.rfind('_'));
    info.words = info.short_name;
    std::replace(info.words.begin(), info.words.end(), '_', ' ');
    if (sensor.kind == Sensing::thermocouple) {
      // A MAX31855 amplifier.
      info.unit = units::degC, info.unit_words = "°C", info.range = {-273.15, 1e4}, info.noise = 0.1, info.step = 0.25;
      info.kind = "temperature";
      info.ordinary_disturbance = 0.6;
      info.driven_by = InputId{sensor.part};
      info.part = "coil " + shape_.coils[sensor.part].name;
      info.driven_words = "is heated";
      info.idle_words = "cools";
    } else {
      // A capacitive bend sensor; a camera is taken to be as good.
      info.unit = units::deg, info.unit_words = "°", info.range = {-360.0, 360.0}, info.noise = 0.05, info.step = 0.03125;
      info.kind = "angle";
      info.ordinary_disturbance = 0.5;
    }
    channels_.push_back(std::move(info));
  }
}

void LimbSystem::list_entries() {
  for (const Shape::Coil& coil : shape_.coils) {
    variables_.push_back({"temperature " + coil.name, "°C"});
    variables_.push_back({"rate of temperature " + coil.name, "K/s"});
    variables_.push_back({"martensite fraction " + coil.name, ""});
    variables_.push_back({"duty " + coil.name, "", true});
  }
  for (const Shape::Bend& bend : shape_.bends) {
    variables_.push_back({with_name("angle", bend.name), "°"});
    variables_.push_back({with_name("angular velocity", bend.name), "°/s"});
    variables_.push_back({with_name("speed of bending", bend.name), "°/s"});
  }
  variables_.push_back({"time", "s"});
  const VariableId time{variables_.size() - 1};
  for (const Shape::Coil& coil : shape_.coils) {
    variables_.push_back({"heat from the air " + coil.name, "W"});
    variables_.push_back({"heat of the current " + coil.name, "W", true});
  }
  const auto of_coil = [](std::size_t j, std::size_t k) { return VariableId{4 * j + k}; };
  const auto of_bend = [&](std::size_t b, std::size_t k) { return VariableId{4 * shape_.coils.size() + 3 * b + k}; };

  const auto text = [](Place place) { return text_of(place); };
  entry_groups_ = ListOf<EntryGroupId, EntryGroup>({
      {.name = "air",
       .words = "the air around the limb",
       .unit = "K",
       .typical = 0.3,
       .correlation_time_s = 30.0,
       .begin = 0.3,
       .ordinary = 0.6,
       .is_nuisance = true,
       .least = 0.05},
      {.name = "heat",
       .words = "the wires' heat balances",
       .unit = "W",
       .typical = 0.2,
       .correlation_time_s = 4.0,
       .places = {text(Place::thermal), text(Place::actuation)},
       .input_words = "the heating of the wires by their current",
       .begin = 0.2,
       .ordinary = 0.024},  // correlated over 4 s it moves a wire of 21 s by 0.24 K, as air of 0.3 K over 30 s does (deviations)
      {.name = "transformation",
       .words = "the transformation's rate",
       .unit = "1/s",
       .typical = 0.05,
       .correlation_time_s = 2.0,
       .places = {text(Place::transformation)},
       .begin = 0.02,
       .alike = "angle"},
      {.name = "moment",
       .words = "the beam's moment balance",
       .unit = "Nm",
       .typical = 5e-4,
       .correlation_time_s = 2.0,
       .places = {text(Place::mechanics)},
       .begin = 2e-4,
       .alike = "angle"},
      {.name = "temperature_reading",
       .words = "the thermocouples' readings",
       .unit = "K",
       .typical = 0.5,
       .correlation_time_s = 6.0,
       .places = {text(Place::sensor_temperature)},
       .begin = 0.2},
      {.name = "angle_reading",
       .words = "the bend sensor's reading",
       .unit = "rad",
       .typical = 0.01,
       .correlation_time_s = 6.0,
       .places = {text(Place::sensor_angle)},
       .begin = 4e-3,
       .alike = "angle"},
  });

  const CoreStates at(shape_);
  const auto on_a_wire = [&](std::size_t j) {
    std::vector<VariableId> list{of_coil(j, 0)};
    for (std::size_t other : shape_.coils_of[shape_.coils[j].segment])
      if (other != j) list.push_back(of_coil(other, 0));
    for (std::size_t k = 1; k < 4; ++k) list.push_back(of_coil(j, k));
    for (std::size_t b = 0; b < shape_.bends.size(); ++b)
      if (shape_.bends[b].segment == shape_.coils[j].segment)
        for (std::size_t k = 0; k < 3; ++k) list.push_back(of_bend(b, k));
    list.push_back(time);
    return list;
  };
  const auto on_a_beam = [&](std::size_t b) {
    std::vector<VariableId> list{of_bend(b, 0), of_bend(b, 1), of_bend(b, 2)};
    for (const std::size_t k : {std::size_t{0}, std::size_t{2}})
      for (const std::size_t j : shape_.coils_of[shape_.bends[b].segment]) list.push_back(of_coil(j, k));
    list.push_back(time);
    return list;
  };
  const auto all_coils = [&](auto&& add) {
    for (std::size_t j = 0; j < shape_.coils.size(); ++j) add(j);
  };
  const auto all_bends = [&](auto&& add) {
    for (std::size_t b = 0; b < shape_.bends.size(); ++b) add(b);
  };
  const std::vector<std::string> coil_names = part_names(shape_, Part::coil), segment_names = part_names(shape_, Part::segment);
  entries_.push_back({.group = {Groups::air}, .parameter = parameter("ambient_temperature_degC")});
  all_coils([&](std::size_t j) {
    entries_.push_back({.group = {Groups::heat},
                        .part = coil_names[j],
                        .state = StateId{at.temperature + j},
                        .divided_by = parameter("heat_capacity_" + coil_names[j] + "_J_K"),
                        .may_depend_on = on_a_wire(j),
                        .factors = {VariableId{time.index + 1 + 2 * j}, VariableId{time.index + 2 + 2 * j}}});
  });
  all_coils([&](std::size_t j) {
    entries_.push_back(
        {.group = {Groups::transformation}, .part = coil_names[j], .state = StateId{at.martensite + j}, .may_depend_on = on_a_wire(j)});
  });
  all_bends([&](std::size_t b) {
    const std::string& segment = segment_names[shape_.bends[b].segment];
    entries_.push_back({.group = {Groups::moment},
                        .part = shape_.bends[b].name,
                        .state = StateId{at.angular_velocity + b},
                        .divided_by = parameter("beam_inertia" + (segment.empty() ? "" : "_" + segment) + "_kgm2"),
                        .may_depend_on = on_a_beam(b)});
  });
  for (const Sensing kind : {Sensing::thermocouple, Sensing::bend})
    for (const ChannelId c : channels_.ids()) {
      const Shape::Sensor& sensor = shape_.sensors[c.index];
      if ((sensor.kind == Sensing::thermocouple) != (kind == Sensing::thermocouple)) continue;
      const bool wire = kind == Sensing::thermocouple;
      entries_.push_back({.group = {wire ? Groups::temperature_reading : Groups::angle_reading},
                          .part = wire ? coil_names[sensor.part] : shape_.bends[sensor.part].name,
                          .channel = c,
                          .may_depend_on = wire ? on_a_wire(sensor.part) : on_a_beam(sensor.part)});
    }
}

void LimbSystem::list_drives() {
  for (std::size_t b = 0; b < shape_.bends.size(); ++b) {
    const auto shows = [&](ChannelId c) {
      return shape_.sensors[c.index].kind != Sensing::thermocouple && shape_.sensors[c.index].part == b;
    };
    for (const ChannelId c : channels_.ids()) {
      if (!shows(c)) continue;
      for (const auto& [coil, bend, cosine] : shape_.couplings)
        if (bend == b) drives_.push_back({c, InputId{coil}, cosine});
      break;  // the first sensor of a bend
    }
  }
}

// docs/plant.md, section 4: 21 columns; Bl is the bend sensor.
void LimbSystem::list_loggers() {
  const std::vector<std::string_view> unused{"Test time", "theta_targ", "x_251", "y_251", "x_285",  "y_285",  "theta", "Vl",
                                             "Vr",        "Al",         "Ar",    "Br",    "T_time", "B_time", "pctime"};
  const auto with = [&](const char* pwm_a, const char* t_a, const char* pwm_b, const char* t_b) {
    loggers_.push_back(
        {"Timestamp (millisec since midnight today)",
         {{pwm_a, "duty_A"}, {pwm_b, "duty_B"}, {t_a, "temperature_A_degC"}, {t_b, "temperature_B_degC"}, {"Bl", "angle_deg"}},
         unused});
  };
  with("pwm_0", "Tl", "pwm_1", "Tr");
  with("pwm_1", "Tr", "pwm_0", "Tl");
}

States LimbSystem::states(const EffectsOn& on) const {
  States list;
  const auto names = [&](Part part) { return part_names(shape_, part); };
  const auto add = [&](std::string_view pattern, const std::string& part, Unit unit, double scale, AtStart at_start = AtStart::open) {
    list.push_back({name_in_part(pattern, part), unit, scale, at_start});
  };
  constexpr double hottest_degC = 110.0;
  for (const auto& name : names(Part::coil)) {
    add("temperature_{}_degC", name, units::degC, 50.0);
    list[StateId{list.size() - 1}].safe_until = hottest_degC;
  }
  for (const auto& name : names(Part::coil)) add("martensite_{}_fraction", name, units::none, 1.0);
  for (const auto& name : names(Part::bend)) add("angle_{}_rad", name, units::rad, 1.0, AtStart::balanced);
  for (const auto& name : names(Part::bend)) add("angular_velocity_{}_rad_s", name, units::rad_s, 1.0, AtStart::balanced);
  LimbValues<double>(Core<double>(shape_), own_).each_effect([&](auto index, const auto& instances) {
    using Effect = typename std::remove_cvref_t<decltype(instances.sets)>::value_type;
    if constexpr (HasStates<Effect>)
      if (on[index])
        for (const auto& part : names(Effect::part))
          for (const StateDeclaration& declared : Effect::states)
            list.push_back({std::string(Effect::name) + "." + name_in_part(declared.name, part), declared.unit, declared.scale,
                            declared.at_start, declared.start_deviation});
  });
  return list;
}

std::unique_ptr<Equations<double>> LimbSystem::equations(const std::vector<double>& values, const EffectsOn& on) const {
  return std::make_unique<LimbEquations<double>>(shared_from_this(), shape_, own_, values, on, states(on));
}
std::unique_ptr<Equations<Jet>> LimbSystem::equations(const std::vector<Jet>& values, const EffectsOn& on) const {
  return std::make_unique<LimbEquations<Jet>>(shared_from_this(), shape_, own_, values, on, states(on));
}
std::unique_ptr<LimbEquations<double>> LimbSystem::limb_equations(const Plant& plant) const {
  return std::make_unique<LimbEquations<double>>(shared_from_this(), shape_, own_, plant.values(), plant.on(), states(plant.on()));
}

Envelopes<double> LimbSystem::loop_at(const Plant& plant, std::size_t coil, double temperature_degC) const {
  LimbValues<double> values(Core<double>(shape_), own_);
  values.assign(plant.values());
  const Core<double>& core = values.core;
  return envelopes(temperature_degC, core.heating_midpoint_degC[coil], core.heating_width_K[coil], core.cooling_midpoint_degC[coil],
                   core.cooling_width_K[coil]);
}

// Temperatures near what is measured first, fractions within the hysteresis loop there, all else within its scale of rest. What shows no
// temperature is no further off than the temperatures that are known lie apart: a limb whose readings are alike has been left alone.
std::vector<StartBelief> LimbSystem::start_beliefs(const Plant& plant, std::span<const double> first_measured) const {
  const CoreStates at(shape_);
  const States list = states(plant.on());
  std::vector<std::optional<double>> known(list.size());
  const double ambient_degC = plant.get(parameter("ambient_temperature_degC"));
  double lowest_degC = ambient_degC, highest_degC = ambient_degC;
  bool shows_temperature = false;
  for (std::size_t j = 0; j < shape_.coils.size(); ++j) known[at.temperature + j] = ambient_degC;
  for (std::size_t b = 0; b < shape_.bends.size(); ++b) known[at.angle + b] = 0.0;
  for (std::size_t c = 0; c < shape_.sensors.size(); ++c) {
    const Shape::Sensor& sensor = shape_.sensors[c];
    if (std::isnan(first_measured[c])) continue;
    if (sensor.kind == Sensing::thermocouple) {
      known[at.temperature + sensor.part] = first_measured[c];
      lowest_degC = std::min(lowest_degC, first_measured[c]);
      highest_degC = std::max(highest_degC, first_measured[c]);
      shows_temperature = true;
    } else
      known[at.angle + sensor.part] = first_measured[c];
  }
  for (std::size_t b = 0; b < shape_.bends.size(); ++b) {
    const std::string& name = shape_.bends[b].name;
    *known[at.angle + b] -= plant.get(parameter("angle_offset" + (name.empty() ? "" : "_" + name) + "_deg"));
  }
  Situation given;
  given.inputs.assign(inputs_.size(), 0.0);
  const std::vector<double> rest = plant.equations()->rest(given, known);
  // What a thermocouple sits on is near what it shows; the wire is, if it sits on that.
  constexpr double near_shown_K = 5.0, near_body_K = 15.0, at_least_K = 1.0;
  const double apart_K =
      shows_temperature ? std::max(at_least_K, 0.5 * (highest_degC - lowest_degC)) : std::numeric_limits<double>::infinity();
  const std::string junction(Junction<double>::name);
  const bool has_junctions = plant.is_on(effect(junction));
  const auto sits_on_wire = [&](std::size_t coil) {
    const auto& with = shape_.thermocouple_coils;
    return !has_junctions || !contains(with, coil);
  };
  std::vector<StartBelief> beliefs;
  for (const StateId i : list.ids()) {
    StartBelief belief{rest[i.index], list[i].start_deviation};
    if (list[i].key.starts_with(junction + ".")) belief.deviation = near_shown_K;
    if (i.index < at.martensite) {
      belief.deviation = sits_on_wire(i.index - at.temperature) ? near_shown_K : near_body_K;
    } else if (i.index < at.angle) {
      const Envelopes<double> loop = loop_at(plant, i.index - at.martensite, *known[i.index - at.martensite]);
      belief = {0.5 * (loop.heating + loop.cooling), std::max(0.05, 0.5 * (loop.heating - loop.cooling)), 0.0, 1.0};
    }
    if (list[i].unit.text == units::degC.text) belief.deviation = std::min(belief.deviation, apart_K);
    beliefs.push_back(belief);
  }
  return beliefs;
}

// Where a recording begins in the middle of a motion, a coil's fraction may lie inside the hysteresis loop, where it stands
// still, or on one of the loop's branches, which a fit that begins inside does not feel. Fractions on the branches, in all
// combinations of up to `most_combined` coils whose loop is open; all coils on one branch where there are more.
std::vector<std::vector<std::pair<StateId, double>>> LimbSystem::other_starts(const Plant& plant,
                                                                              const std::vector<std::optional<double>>& start) const {
  constexpr double least_open = 0.003;  // martensite fraction; a first one off by 0.0066 makes a whole limb "unexplained"
  constexpr std::size_t most_combined = 3;
  const CoreStates at(shape_);
  for (std::size_t j = 0; j < shape_.coils.size(); ++j)
    if (start.empty() || !start[at.temperature + j]) return {};
  std::vector<Envelopes<double>> loops;
  bool is_open = false;
  for (std::size_t j = 0; j < shape_.coils.size(); ++j) {
    loops.push_back(loop_at(plant, j, *start[at.temperature + j]));
    is_open = is_open || loops[j].heating - loops[j].cooling > least_open;
  }
  if (!is_open) return {};
  const bool combined = loops.size() <= most_combined;
  std::vector<std::vector<std::pair<StateId, double>>> all;
  for (unsigned branches = 0; branches < (combined ? 1u << loops.size() : 2u); ++branches) {
    all.emplace_back();
    for (std::size_t j = 0; j < loops.size(); ++j)
      all.back().emplace_back(StateId{at.martensite + j}, (combined ? branches >> j : branches) & 1u ? loops[j].cooling : loops[j].heating);
  }
  return all;
}

std::string LimbSystem::structure_yaml() const { return shape_.is_two_coil_limb ? "" : yaml_of(shape_); }

const std::shared_ptr<const LimbSystem>& two_coil_limb() {
  static const auto shared = std::make_shared<const LimbSystem>(two_coil_shape(), std::vector<OwnValues>{});
  return shared;
}

template class LimbEquations<double>;
template class LimbEquations<Jet>;

}  // namespace sinew::plant
