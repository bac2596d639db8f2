// SPDX-License-Identifier: Apache-2.0
// A limb at one instant: what the equations compute on the way from a state to its rate of change.
//
// `LimbEquations::rates` fills it from top to bottom in the stages below. Each stage first applies the core's law, then lets
// every effect that is on change the result, in the order of effects.h. An effect takes part in a stage by having a
// member function of the stage's name, `void heat(Instant<S>&, std::size_t part) const`, or, where it has states of its own,
// `void heat(Instant<S>&, std::size_t part, const S* own) const`. It is called for every part of its kind.
#pragma once

#include <array>
#include <vector>

#include "plant/effect_set.h"
#include "plant/limb/core.h"

namespace sinew::plant {

// Core quantities ("heat_loss", of all parts) that a recording shows less of where an effect is on, and by how much wider then
// is what is believed of them.
struct Hidden {
  std::string_view quantity;
  double factor;
};

// What an effect acts on, and what its `part` counts.
enum class Part {
  room,          // all of the limb; part is 0
  supply,        // the source of all coils; part is 0
  coil,          // index of the coil
  pair,          // of coils on one segment: index into Shape::pairs
  segment,       // index of the segment
  bend,          // one axis of a segment: index into Shape::bends
  thermocouple,  // index of the coil that it is on
  bend_sensor,   // index of the bend that it is on
};

template <class S>
struct Instant {
  explicit Instant(const Core<S>& of) : core(&of) {
    const std::size_t coils = of.shape->coils.size(), bends = of.shape->bends.size();
    for (auto* per_coil : {&temperature_degC,
                           &martensite_fraction,
                           &heat_loss_W_K,
                           &heat_capacity_J_K,
                           &sensor_body_degC,
                           &sensor_body_heat_W,
                           &sensor_body_rate_K_s,
                           &stretch_m,
                           &longer_share,
                           &transformation_stretch_m,
                           &tension_N,
                           &heating_midpoint_degC,
                           &cooling_midpoint_degC,
                           &heating_envelope,
                           &cooling_envelope,
                           &pull_1_s,
                           &warming_slope_1_K,
                           &cooling_slope_1_K,
                           &duty_fraction,
                           &resistance_Ohm,
                           &joule_heat_W,
                           &heat_W,
                           &latent_heat_J,
                           &temperature_rate_K_s,
                           &martensite_rate_1_s,
                           &shown_temperature_degC})
      per_coil->resize(coils);
    sensor_is_on_wire.resize(coils, true);
    for (auto* per_bend : {&angle_rad, &angular_velocity_rad_s, &moment_Nm, &shown_angle_rad}) per_bend->resize(bends);
  }

  const Core<S>* core;
  S mean_heat_capacity_J_K;  // of the wires, the core's
  const Situation* given = nullptr;
  const Shape& shape() const { return *core->shape; }

  // From the state. [coils], [bends].
  std::vector<S> temperature_degC;
  std::vector<S> martensite_fraction;
  std::vector<S> angle_rad;
  std::vector<S> angular_velocity_rad_s;

  // Stage `environment`.
  S ambient_temperature_degC;
  std::vector<S> heat_loss_W_K;
  std::vector<S> heat_capacity_J_K;
  // The body that a coil's thermocouple sits on. The core's is the wire; an effect may bring one of its own (junction.h), give its
  // temperature here, add to the heat that flows into it in stage `heat`, and say how fast it warms in stage `sensor_body`.
  std::vector<bool> sensor_is_on_wire;
  std::vector<S> sensor_body_degC, sensor_body_heat_W, sensor_body_rate_K_s;

  // Stage `stretch`: tension is k(xi) (stretch - longer_share * transformation_stretch).
  std::vector<S> stretch_m;
  std::vector<S> longer_share;  // share of the transformation stretch that is there now; the core's is xi
  std::vector<S> transformation_stretch_m;

  // Stage `tension`.
  std::vector<S> tension_N;

  // Stage `envelopes`: first the midpoints can be moved, ...
  std::vector<S> heating_midpoint_degC;
  std::vector<S> cooling_midpoint_degC;
  // ... then, in stage `transformation`, the rate: dxi/dt = pull_1_s + slope_1_K dT/dt. There are two slopes,
  // one while the wire warms and one while it cools; the core has neither.
  std::vector<S> heating_envelope;
  std::vector<S> cooling_envelope;
  std::vector<S> pull_1_s;
  std::vector<S> warming_slope_1_K;
  std::vector<S> cooling_slope_1_K;

  // Stage `electrics`.
  std::vector<S> duty_fraction;
  std::vector<S> resistance_Ohm;
  S supply_voltage_V;
  std::vector<S> joule_heat_W;

  // Stage `heat`: heat that flows into each wire, and the heat that the transformation absorbs: C dT/dt = heat + L dxi/dt.
  std::vector<S> heat_W;
  std::vector<S> latent_heat_J;
  S heat_to_surroundings_W;  // all of it, for the balance; nothing in the equations reads it

  // What follows from both laws together.
  std::vector<S> temperature_rate_K_s;
  std::vector<S> martensite_rate_1_s;

  // Stage `moment`: sum of the moments on each beam, positive towards positive angles.
  std::vector<S> moment_Nm;

  // Stage `reading`: what the sensors would show without noise, steps and faults. Starts as the true temperature of the coil
  // and the true angle; the core's offset of the angle is added after the effects.
  std::vector<S> shown_temperature_degC;  // [coils]
  std::vector<S> shown_angle_rad;         // [bends]
};

enum class Place { sensor_temperature, thermal, actuation, transformation, mechanics, sensor_angle };

constexpr std::string_view text_of(Place place) {
  switch (place) {
    case Place::sensor_temperature:
      return "sensor.temperature";
    case Place::thermal:
      return "thermal";
    case Place::actuation:
      return "actuation";
    case Place::transformation:
      return "transformation";
    case Place::mechanics:
      return "mechanics";
    case Place::sensor_angle:
      return "sensor.angle";
  }
  return "";
}

// Smoothing that is not physics. Strictly positive; never a switch.
struct Smoothing {
  // A sensor lag below this is applied to first order, T - tau dT/dt, which is exact in the limit and needs no state.
  static constexpr double shortest_lag_s = 1.0e-3;
  // Depth inside the hysteresis loop, in martensite fraction, over which `minor_loops` fades in.
  static constexpr double loop_edge_fraction = 1.0e-3;
};

}  // namespace sinew::plant
