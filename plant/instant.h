// SPDX-License-Identifier: Apache-2.0
// The limb at one instant: what the equations compute on the way from a state to its rate of change.
//
// `Limb::evaluate` fills it from top to bottom in the stages below. Each stage first applies the core's law, then lets
// every effect that is on change the result, in the order of effects.h. An effect takes part in a stage by having a
// member function of the stage's name, `void heat(Instant<S>&) const`, or, where it has states of its own,
// `void heat(Instant<S>&, const S* own) const`.
#pragma once

#include "plant/core.h"

namespace sinew::plant {

// What is given from outside, in plain numbers.
struct Situation {
  double time_s = 0.0;  // since the start of the scenario or recording
  // When the held duty or a switch in time last changed: within such a segment the right-hand side is smooth in time.
  double segment_start_s = 0.0;
  PerCoil<double> duty_fraction{};
};

template <class S>
struct Instant {
  Situation given;
  const Core<S>* core = nullptr;

  // From the state.
  PerCoil<S> temperature_degC;
  PerCoil<S> martensite_fraction;
  S angle_rad;
  S angular_velocity_rad_s;

  // Stage `environment`.
  S ambient_temperature_degC;
  PerCoil<S> heat_loss_W_K;

  // Stage `stretch`: tension is k(xi) (stretch - longer_share * transformation_stretch).
  PerCoil<S> stretch_m;
  PerCoil<S> longer_share;  // share of the transformation stretch that is there now; the core's is xi
  PerCoil<S> transformation_stretch_m;

  // Stage `tension`.
  PerCoil<S> tension_N;

  // Stage `envelopes`: first the midpoints can be moved, ...
  PerCoil<S> heating_midpoint_degC;
  PerCoil<S> cooling_midpoint_degC;
  // ... then, in stage `transformation`, the rate: dxi/dt = pull_1_s + slope_1_K dT/dt. There are two slopes,
  // one while the wire warms and one while it cools; the core has neither.
  PerCoil<S> heating_envelope;
  PerCoil<S> cooling_envelope;
  PerCoil<S> pull_1_s;
  PerCoil<S> warming_slope_1_K;
  PerCoil<S> cooling_slope_1_K;

  // Stage `electrics`.
  PerCoil<S> duty_fraction;
  PerCoil<S> resistance_Ohm;
  S supply_voltage_V;
  PerCoil<S> joule_heat_W;

  // Stage `heat`: heat that flows into each wire, and the heat that the transformation absorbs: C dT/dt = heat + L dxi/dt.
  PerCoil<S> heat_W;
  PerCoil<S> latent_heat_J;
  S heat_to_surroundings_W;  // all of it, for the balance; nothing in the equations reads it

  // What follows from both laws together.
  PerCoil<S> temperature_rate_K_s;
  PerCoil<S> martensite_rate_1_s;

  // Stage `moment`: sum of the moments on the beam, positive towards positive angles.
  S moment_Nm;
};

// Stage `reading`: what the sensors would show without noise, steps and faults. Starts as the true temperature and the
// true angle; the core's offset of the angle is added after the effects.
template <class S>
struct Reading {
  PerCoil<S> temperature_degC;
  S angle_rad;
};

enum class Place { sensor_temperature, thermal, actuation, transformation, mechanics, sensor_angle };

constexpr std::string_view text_of(Place place) {
  switch (place) {
    case Place::sensor_temperature: return "sensor.temperature";
    case Place::thermal: return "thermal";
    case Place::actuation: return "actuation";
    case Place::transformation: return "transformation";
    case Place::mechanics: return "mechanics";
    case Place::sensor_angle: return "sensor.angle";
  }
  return "";
}

// An entry of the state vector.
struct StateDeclaration {
  std::string_view name;  // unique within its owner; ends in its unit
  Unit unit;
  double scale;  // a change of this size is large: sets the absolute tolerance and the prior of an unknown start
  bool free_at_start = true;  // whether a recording that begins in mid-motion leaves its first value open
};

// Smoothing that is not physics. Strictly positive; never a switch.
struct Smoothing {
  // A sensor lag below this is applied to first order, T - tau dT/dt, which is exact in the limit and needs no state.
  static constexpr double shortest_lag_s = 1.0e-3;
  // Depth inside the hysteresis loop, in martensite fraction, over which `minor_loops` fades in.
  static constexpr double loop_edge_fraction = 1.0e-3;
};

}  // namespace sinew::plant
