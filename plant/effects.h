// SPDX-License-Identifier: Apache-2.0
// Every effect, in the order in which its terms are added. Floating-point sums depend on their order, so the order is
// part of the result and stands here alone. A new effect is its own file, its test, and its line here.
#pragma once

#include <tuple>

#include "plant/effects/airflow_change.h"
#include "plant/effects/ambient_drift.h"
#include "plant/effects/angle_sensor_drift.h"
#include "plant/effects/angle_sensor_lag.h"
#include "plant/effects/body_heat_storage.h"
#include "plant/effects/coil_slack.h"
#include "plant/effects/convection_nonlinearity.h"
#include "plant/effects/cross_heating.h"
#include "plant/effects/cubic_stiffening.h"
#include "plant/effects/dry_friction.h"
#include "plant/effects/duty_deadband.h"
#include "plant/effects/fatigue.h"
#include "plant/effects/gravity_load.h"
#include "plant/effects/hard_stop.h"
#include "plant/effects/input_delay.h"
#include "plant/effects/latent_heat.h"
#include "plant/effects/minor_loops.h"
#include "plant/effects/outer_turns.h"
#include "plant/effects/r_phase.h"
#include "plant/effects/resistance_change.h"
#include "plant/effects/sheath_heat_storage.h"
#include "plant/effects/stress_shift.h"
#include "plant/effects/supply_sag.h"
#include "plant/effects/thermocouple_heat_sink.h"
#include "plant/effects/thermocouple_lag.h"
#include "plant/effects/viscoelastic_creep.h"

namespace sinew::plant {

template <class S>
using Effects =
    std::tuple<ThermocoupleLag<S>, OuterTurns<S>, ThermocoupleHeatSink<S>, BodyHeatStorage<S>, SheathHeatStorage<S>, CrossHeating<S>,
               LatentHeat<S>, AmbientDrift<S>, ConvectionNonlinearity<S>, AirflowChange<S>, DutyDeadband<S>,
               ResistanceChange<S>, SupplySag<S>, InputDelay<S>, StressShift<S>, Fatigue<S>, MinorLoops<S>, RPhase<S>,
               ViscoelasticCreep<S>, DryFriction<S>, CubicStiffening<S>, GravityLoad<S>, CoilSlack<S>, HardStop<S>,
               AngleSensorLag<S>, AngleSensorDrift<S>>;

inline constexpr std::size_t effect_count = std::tuple_size_v<Effects<double>>;

}  // namespace sinew::plant
