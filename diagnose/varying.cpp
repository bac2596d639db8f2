// SPDX-License-Identifier: Apache-2.0
#include "diagnose/varying.h"

#include <algorithm>

namespace sinew::diagnose {
namespace {

// What begins at some moment or grows with time does what it does after ten minutes.
constexpr double long_since_s = 600.0;
constexpr double per_cent = 0.01;

plant::Limb<double> changed(const plant::Limb<double>& limb, const Wanderer& by) {
  plant::Limb<double> result = limb;
  if (by.effect != plant::no_effect) {
    result.on[by.effect] = true;
    for (const std::size_t p : plant::effects()[by.effect].parameters)
      plant::set_in_file_units(result, p, plant::parameters()[p].declaration.typical);
  }
  const auto fields = plant::fields(result);
  for (const std::size_t p : by.parameters)
    if (by.unit == "%")
      *fields[p] *= 1.0 + per_cent * by.scale;
    else
      *fields[p] += by.scale * plant::parameters()[p].declaration.unit.internal_per_unit;
  return result;
}

// What is said of an effect: its strength; of one that grows with time, what it has grown to.
Wanderer strength_of(std::size_t effect) {
  const plant::EffectInfo& info = plant::effects()[effect];
  const auto& declared = plant::parameters()[info.strength].declaration;
  Wanderer one{"the strength of " + std::string(info.name), info.place, effect, {}, -1};
  one.centre = declared.null_value.value_or(0.0);
  one.scale = declared.typical - one.centre;
  one.unit = std::string(declared.unit.text);
  const auto grown = [&](const char* words, const char* unit) {
    one.words = words;
    one.scale *= long_since_s;
    one.unit = unit;
  };
  if (info.name == "ambient_drift") grown("the temperature of the surroundings", "K");
  if (info.name == "angle_sensor_drift") grown("the zero of the bend sensor", "deg");
  return one;
}

}  // namespace

std::vector<Wanderer> wanderers(const plant::Limb<double>& limb, const std::vector<std::size_t>& without) {
  using plant::Place;
  std::vector<Wanderer> all;
  const std::size_t states = plant::layout_of(limb.on).size();
  for (std::size_t e = 0; e < plant::effect_count; ++e) {
    if (limb.on[e] || std::find(without.begin(), without.end(), e) != without.end()) continue;
    const Wanderer one = strength_of(e);
    const plant::Limb<double> with = changed(limb, one);
    const bool toggle = plant::parameters()[plant::effects()[e].strength].declaration.kind == plant::Kind::toggle;
    if (toggle || one.place == Place::sensor_temperature || plant::layout_of(with.on).size() != states ||
        plant::Equations<double>(with).command_delay_s() != plant::Equations<double>(limb).command_delay_s())
      continue;
    all.push_back(one);
  }
  const auto core = [&](std::string words, Place place, const std::vector<const char*>& names) {
    Wanderer one{std::move(words), place, plant::no_effect, {}, -1};
    for (const char* name : names) one.parameters.push_back(plant::parameter_index(name));
    all.push_back(one);
  };
  core("the supply's voltage", Place::actuation, {"supply_voltage_V"});
  core("the wires' heat capacity", Place::thermal, {"heat_capacity_A_J_K", "heat_capacity_B_J_K"});
  core("the level of the transformation temperatures", Place::transformation,
       {"heating_midpoint_degC", "cooling_midpoint_degC"});
  all.back().scale = 5.0;
  all.back().unit = "K";
  core("the stretch that the transformation makes", Place::transformation, {"transformation_stretch_m"});
  core("the stiffness of austenite", Place::mechanics, {"austenite_stiffness_N_m"});
  core("the stiffness of martensite", Place::mechanics, {"martensite_stiffness_N_m"});
  core("the beam's stiffness", Place::mechanics, {"beam_stiffness_Nm_rad"});
  core("the beam's damping", Place::mechanics, {"beam_damping_Nms_rad"});
  all.push_back({"the thermocouples' gain", Place::sensor_temperature, plant::no_effect, {}, 0});
  all.push_back({"the bend sensor's gain", Place::sensor_angle, plant::no_effect, {}, 1});
  return all;
}

bool varying_push(const FitProblem& problem, const double* z, const Varying& varying, VaryingPush& push) {
  const plant::Limb<double> limb = problem.limb_at(z);
  const plant::Equations<double> as_it_is(limb), changed_so(changed(limb, varying.of));
  const std::size_t states = as_it_is.layout().size();
  push = {varying.correlation_time_s, {}, {}};
  for (std::size_t r = 0; r < problem.data().size(); ++r) {
    const FitData& data = problem.data()[r];
    const auto& samples = data.recording->samples;
    plant::Integrator integrator(limb, problem.start_at(z, r), problem.numerics());
    push.rates.emplace_back();
    push.readings.emplace_back();
    for (std::size_t k = 0; k < data.sample_count; ++k) {
      if (integrator.advance_to(samples[k].time_s - samples.front().time_s)) return false;
      integrator.hold(samples[k].duty_fraction);
      plant::Situation given = integrator.instant().given;
      if (varying.of.effect != plant::no_effect) given.time_s = given.segment_start_s = long_since_s;
      Eigen::VectorXd was(static_cast<Eigen::Index>(states)), is(was);
      plant::Instant<double> now, now_changed;
      as_it_is.evaluate(given, integrator.state().data(), now, was.data());
      changed_so.evaluate(given, integrator.state().data(), now_changed, is.data());
      push.rates.back().push_back(is - was);
      const plant::Reading<double> shown = as_it_is.reading(now, integrator.state().data());
      Eigen::Vector3d reading = Eigen::Vector3d::Zero();
      if (varying.of.sensor == 0) {
        for (const std::size_t j : plant::coils)
          reading(static_cast<Eigen::Index>(j)) =
              per_cent * varying.of.scale * (shown.temperature_degC[j] - limb.core.ambient_temperature_degC);
      } else if (varying.of.sensor == 1) {
        reading(2) = per_cent * varying.of.scale * shown.angle_rad;
      } else {
        const plant::Reading<double> other = changed_so.reading(now_changed, integrator.state().data());
        for (const std::size_t j : plant::coils)
          reading(static_cast<Eigen::Index>(j)) = other.temperature_degC[j] - shown.temperature_degC[j];
        reading(2) = other.angle_rad - shown.angle_rad;
      }
      push.readings.back().push_back(reading);
    }
  }
  return true;
}

}  // namespace sinew::diagnose
