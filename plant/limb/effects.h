// SPDX-License-Identifier: Apache-2.0
// Every effect, in the order in which its terms are added. Floating-point sums depend on their order, so the order is
// part of the result and stands here alone. A new effect is its own file, its test, and its line here.
#pragma once

#include <tuple>

#include "plant/limb/effects/airflow_change.h"
#include "plant/limb/effects/ambient_drift.h"
#include "plant/limb/effects/angle_sensor_drift.h"
#include "plant/limb/effects/angle_sensor_lag.h"
#include "plant/limb/effects/angle_sensor_saturation.h"
#include "plant/limb/effects/angle_sensor_second_order.h"
#include "plant/limb/effects/body_heat_storage.h"
#include "plant/limb/effects/coil_slack.h"
#include "plant/limb/effects/convection_nonlinearity.h"
#include "plant/limb/effects/cross_heating.h"
#include "plant/limb/effects/cubic_stiffening.h"
#include "plant/limb/effects/driver_lag.h"
#include "plant/limb/effects/dry_friction.h"
#include "plant/limb/effects/duty_deadband.h"
#include "plant/limb/effects/fatigue.h"
#include "plant/limb/effects/gravity_load.h"
#include "plant/limb/effects/hard_stop.h"
#include "plant/limb/effects/input_delay.h"
#include "plant/limb/effects/junction.h"
#include "plant/limb/effects/junction_layer.h"
#include "plant/limb/effects/latent_heat.h"
#include "plant/limb/effects/minor_loops.h"
#include "plant/limb/effects/r_phase.h"
#include "plant/limb/effects/resistance_change.h"
#include "plant/limb/effects/sheath_heat_storage.h"
#include "plant/limb/effects/stress_shift.h"
#include "plant/limb/effects/stress_shift_curved.h"
#include "plant/limb/effects/stress_shift_two_slopes.h"
#include "plant/limb/effects/supply_sag.h"
#include "plant/limb/effects/thermocouple_heat_sink.h"
#include "plant/limb/effects/thermocouple_lag.h"
#include "plant/limb/effects/thermocouple_two_lags.h"
#include "plant/limb/effects/viscoelastic_creep.h"

namespace sinew::plant {

template <class S>
using Effects = std::tuple<Junction<S>, JunctionLayer<S>, ThermocoupleLag<S>, ThermocoupleTwoLags<S>, ThermocoupleHeatSink<S>,
                           BodyHeatStorage<S>, SheathHeatStorage<S>, CrossHeating<S>, LatentHeat<S>, AmbientDrift<S>,
                           ConvectionNonlinearity<S>, AirflowChange<S>, DriverLag<S>, DutyDeadband<S>, ResistanceChange<S>, SupplySag<S>,
                           InputDelay<S>, StressShift<S>, StressShiftCurved<S>, StressShiftTwoSlopes<S>, Fatigue<S>, MinorLoops<S>,
                           RPhase<S>, ViscoelasticCreep<S>, DryFriction<S>, CubicStiffening<S>, GravityLoad<S>, CoilSlack<S>, HardStop<S>,
                           AngleSensorLag<S>, AngleSensorSecondOrder<S>, AngleSensorSaturation<S>, AngleSensorDrift<S>>;

}  // namespace sinew::plant
