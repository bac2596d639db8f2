// SPDX-License-Identifier: Apache-2.0
// Parameters of the core plant: two SMA coils in a silicone beam. Equations: wire.h, coil.h, beam.h.
//
// Defaults are the limb of Sabelhaus, Mehta, Wertz, Majidi 2022 (doi 10.3389/frobt.2022.888261): 0.51 mm Flexinol wire,
// about 0.6 m a side, coiled to about 3 mm, in a body of Smooth-Sil 945.
#pragma once

#include "plant/parameter.h"
#include "plant/scalar.h"

namespace sinew::plant {

template <class S>
struct Core {
  S supply_voltage_V{7.0};
  PerCoil<S> resistance_Ohm{S(2.5), S(2.5)};
  PerCoil<S> heat_capacity_J_K{S(0.85), S(0.85)};
  PerCoil<S> heat_loss_W_K{S(0.040), S(0.040)};
  S ambient_temperature_degC{25.0};
  S heating_midpoint_degC{75.0};
  S heating_width_K{7.0};
  S cooling_midpoint_degC{60.0};
  S cooling_width_K{7.0};
  S transformation_time_s{0.10};
  S austenite_stiffness_N_m{313.0};
  S martensite_stiffness_N_m{113.0};
  S coil_stretch_m{0.030};
  S transformation_stretch_m{0.028};
  PerCoil<S> moment_arm_m{S(0.006), S(0.006)};
  S beam_stiffness_Nm_rad{0.050};
  S beam_damping_Nms_rad{0.004};
  S beam_inertia_kgm2{2.0e-5};
  S angle_offset_rad{0.0};
  S bend_sign{1.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    constexpr std::string_view build = "Sabelhaus et al. 2022, methods";
    constexpr std::string_view spring = "k = G d^4 / (8 D^3 N), G of 25 (austenite) and 9 GPa (martensite), 25 turns";
    visit(self.supply_voltage_V,
          Declaration{.name = "supply_voltage_V", .symbol = "V_s", .unit = units::V, .range = {0.5, 60.0}, .typical = 7.0,
                      .meaning = "voltage across a coil while its switch is closed", .source = build});
    for (const std::size_t j : coils)
      visit(self.resistance_Ohm[j],
            Declaration{.name = j == A ? "resistance_A_Ohm" : "resistance_B_Ohm", .symbol = j == A ? "R_A" : "R_B",
                        .unit = units::Ohm, .range = {0.05, 100.0}, .typical = 2.5, .prior_deviation = 0.25,
                        .meaning = "electrical resistance of the whole wire of this side",
                        .source = "Flexinol data sheet, 4.3 Ohm/m at 0.51 mm, 0.6 m"});
    for (const std::size_t j : coils)
      visit(self.heat_capacity_J_K[j],
            Declaration{.name = j == A ? "heat_capacity_A_J_K" : "heat_capacity_B_J_K",
                        .symbol = j == A ? "C_w,A" : "C_w,B", .unit = units::J_K, .range = {0.05, 20.0}, .typical = 0.85,
                        .prior_deviation = 0.4, .meaning = "heat that warms the wire of this side by one kelvin",
                        .source = "0.8 g of Ni-Ti and what is glued to it"});
    for (const std::size_t j : coils)
      visit(self.heat_loss_W_K[j],
            Declaration{.name = j == A ? "heat_loss_A_W_K" : "heat_loss_B_W_K", .symbol = j == A ? "h_A" : "h_B",
                        .unit = units::W_K, .range = {0.002, 1.0}, .typical = 0.040, .prior_deviation = 0.02,
                        .meaning = "heat lost to the surroundings for each kelvin above ambient",
                        .source = "cooling time constant of about 21 s"});
    visit(self.ambient_temperature_degC,
          Declaration{.name = "ambient_temperature_degC", .symbol = "T_inf", .unit = units::degC, .range = {-20.0, 60.0},
                      .typical = 25.0, .prior_deviation = 3.0, .meaning = "temperature of the surroundings",
                      .source = "room"});
    visit(self.heating_midpoint_degC,
          Declaration{.name = "heating_midpoint_degC", .symbol = "T_heat", .unit = units::degC, .range = {0.0, 200.0},
                      .typical = 75.0, .prior_deviation = 10.0,
                      .meaning = "temperature at which half of the martensite is gone on heating",
                      .source = "Flexinol 70 degC alloy data sheet"});
    visit(self.heating_width_K,
          Declaration{.name = "heating_width_K", .symbol = "w_heat", .unit = units::K, .range = {0.5, 50.0}, .typical = 7.0,
                      .prior_deviation = 3.0, .meaning = "width of the heating envelope", .source = "Flexinol data sheet"});
    visit(self.cooling_midpoint_degC,
          Declaration{.name = "cooling_midpoint_degC", .symbol = "T_cool", .unit = units::degC, .range = {0.0, 200.0},
                      .typical = 60.0, .prior_deviation = 10.0,
                      .meaning = "temperature at which half of the martensite is back on cooling",
                      .source = "Flexinol 70 degC alloy data sheet"});
    visit(self.cooling_width_K,
          Declaration{.name = "cooling_width_K", .symbol = "w_cool", .unit = units::K, .range = {0.5, 50.0}, .typical = 7.0,
                      .prior_deviation = 3.0, .meaning = "width of the cooling envelope", .source = "Flexinol data sheet"});
    visit(self.transformation_time_s,
          Declaration{.name = "transformation_time_s", .symbol = "tau_xi", .unit = units::s, .range = {0.005, 10.0},
                      .typical = 0.10, .prior_deviation = 0.05,
                      .meaning = "time in which the fraction is pulled back to an envelope that passed it",
                      .source = "regularised play operator"});
    visit(self.austenite_stiffness_N_m,
          Declaration{.name = "austenite_stiffness_N_m", .symbol = "k_a", .unit = units::N_m, .range = {1.0, 5000.0},
                      .typical = 313.0, .prior_deviation = 90.0, .meaning = "stiffness of a hot coil spring",
                      .source = spring});
    visit(self.martensite_stiffness_N_m,
          Declaration{.name = "martensite_stiffness_N_m", .symbol = "k_m", .unit = units::N_m, .range = {1.0, 5000.0},
                      .typical = 113.0, .prior_deviation = 35.0, .meaning = "stiffness of a cold coil spring",
                      .source = spring});
    visit(self.coil_stretch_m,
          Declaration{.name = "coil_stretch_m", .symbol = "delta_0", .unit = units::m, .range = {0.0, 0.3}, .typical = 0.030,
                      .prior_deviation = 0.006, .meaning = "stretch of a hot coil over its free length when the limb is straight",
                      .source = build});
    visit(self.transformation_stretch_m,
          Declaration{.name = "transformation_stretch_m", .symbol = "delta_t", .unit = units::m, .range = {0.0, 0.3},
                      .typical = 0.028, .prior_deviation = 0.006, .meaning = "by how much a cold coil is longer than a hot one",
                      .source = build});
    for (const std::size_t j : coils)
      visit(self.moment_arm_m[j],
            Declaration{.name = j == A ? "moment_arm_A_m" : "moment_arm_B_m", .symbol = j == A ? "r_A" : "r_B",
                        .unit = units::m, .range = {0.0005, 0.1}, .typical = 0.006, .prior_deviation = 0.001,
                        .meaning = "distance of the coil from the beam's neutral line", .source = build});
    visit(self.beam_stiffness_Nm_rad,
          Declaration{.name = "beam_stiffness_Nm_rad", .symbol = "k_b", .unit = units::Nm_rad, .range = {0.001, 5.0},
                      .typical = 0.050, .prior_deviation = 0.025, .meaning = "bending stiffness of the silicone body",
                      .source = "E I / L of Smooth-Sil 945"});
    visit(self.beam_damping_Nms_rad,
          Declaration{.name = "beam_damping_Nms_rad", .symbol = "c", .unit = units::Nms_rad, .range = {1e-5, 1.0},
                      .typical = 0.004, .prior_deviation = 0.004, .meaning = "viscous damping of bending",
                      .source = "loss factor of silicone"});
    visit(self.beam_inertia_kgm2,
          Declaration{.name = "beam_inertia_kgm2", .symbol = "J", .unit = units::kgm2, .range = {1e-7, 1e-2},
                      .typical = 2.0e-5, .meaning = "moment of inertia of the body about its base", .source = "m L^2 / 3"});
    visit(self.angle_offset_rad,
          Declaration{.name = "angle_offset_deg", .symbol = "theta_0", .unit = units::deg, .range = {-90.0, 90.0},
                      .typical = 0.0, .prior_deviation = 3.0, .meaning = "what the bend sensor reports when the limb is straight",
                      .source = "bend sensor, accuracy of a few degrees"});
    visit(self.bend_sign,
          Declaration{.name = "bend_sign", .symbol = "sign", .unit = units::none, .kind = Kind::sign, .range = {-1.0, 1.0},
                      .typical = 1.0, .meaning = "+1 where coil A bends the limb towards positive angles",
                      .source = "wiring"});
  }
};

}  // namespace sinew::plant
