// SPDX-License-Identifier: Apache-2.0
// Parameters of the core of a limb: SMA coils along silicone beams. Equations: wire.h, coil.h, beam.h.
//
// A quantity of each coil, segment or bend has the part's name in its own ("heat_loss_A_W_K"), unless there is only one. What
// coils share a coil may have of its own, where the file says so ("heating_midpoint_A_degC").
// Defaults are the limb of Sabelhaus, Mehta, Wertz, Majidi 2022 (doi 10.3389/frobt.2022.888261): 0.51 mm Flexinol wire,
// about 0.6 m a side, coiled to about 3 mm, in a body of Smooth-Sil 945.
#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "plant/limb/shape.h"
#include "plant/parameter.h"
#include "plant/scalar.h"

namespace sinew::plant {

// "heat_loss" + "A" + "_W_K"; the symbol "h" + "_A". Nothing in between where there is only one part.
inline std::string with_part(std::string_view before, const std::string& part, std::string_view unit) {
  return std::string(before) + (part.empty() ? "" : "_" + part) + std::string(unit);
}

// A quantity that coils share, but for those that have a value of their own.
template <class S>
struct OfCoils {
  OfCoils(std::string_view of, double shared) : quantity(of), values{S(shared)} {}
  std::string_view quantity;       // "heating_midpoint"
  std::vector<S> values;           // what is shared, then what coils have of their own, in their order
  std::vector<std::size_t> which;  // [coils]: of `values`
  const S& operator[](std::size_t coil) const { return values[which[coil]]; }
  std::string own_key(std::string_view key, const std::string& coil) const {
    return with_part(quantity, coil, key.substr(quantity.size()));
  }
};

template <class S>
struct Core {
  explicit Core(const Shape& of) : shape(&of) {
    const std::size_t coils = of.coils.size(), segments = of.segments.size(), bends = of.bends.size();
    for (auto* per_coil : {&resistance_Ohm, &heat_capacity_J_K, &heat_loss_W_K, &moment_arm_m}) per_coil->resize(coils);
    for (auto* per_segment : {&beam_stiffness_Nm_rad, &beam_damping_Nms_rad, &beam_inertia_kgm2}) per_segment->resize(segments);
    angle_offset_rad.resize(bends);
    bend_sign.resize(bends, S(1.0));
    each_of_coils(*this, [&](OfCoils<S>& shared, std::string_view) {
      for (std::size_t j = 0; j < coils; ++j) {
        const bool own = of.is_own(shared.quantity, j);
        shared.which.push_back(own ? shared.values.size() : 0);
        if (own) shared.values.push_back(shared.values.front());
      }
    });
  }

  const Shape* shape;  // must outlive this
  S supply_voltage_V{7.0};
  std::vector<S> resistance_Ohm;     // [coils]
  std::vector<S> heat_capacity_J_K;  // [coils]
  std::vector<S> heat_loss_W_K;      // [coils]
  S ambient_temperature_degC{25.0};
  OfCoils<S> heating_midpoint_degC{"heating_midpoint", 75.0};
  OfCoils<S> heating_width_K{"heating_width", 7.0};
  OfCoils<S> cooling_midpoint_degC{"cooling_midpoint", 60.0};
  OfCoils<S> cooling_width_K{"cooling_width", 7.0};
  OfCoils<S> transformation_time_s{"transformation_time", 0.10};
  OfCoils<S> austenite_stiffness_N_m{"austenite_stiffness", 313.0};
  OfCoils<S> martensite_stiffness_N_m{"martensite_stiffness", 113.0};
  OfCoils<S> coil_stretch_m{"coil_stretch", 0.030};
  OfCoils<S> transformation_stretch_m{"transformation_stretch", 0.028};
  std::vector<S> moment_arm_m;           // [coils]
  std::vector<S> beam_stiffness_Nm_rad;  // [segments]
  std::vector<S> beam_damping_Nms_rad;   // [segments]
  std::vector<S> beam_inertia_kgm2;      // [segments]
  std::vector<S> angle_offset_rad;       // [bends]
  std::vector<S> bend_sign;              // [bends]

  // visit(quantity, the key of what is shared), for each that coils share.
  template <class Self, class Visitor>
  static void each_of_coils(Self& self, Visitor&& visit) {
    visit(self.heating_midpoint_degC, "heating_midpoint_degC");
    visit(self.heating_width_K, "heating_width_K");
    visit(self.cooling_midpoint_degC, "cooling_midpoint_degC");
    visit(self.cooling_width_K, "cooling_width_K");
    visit(self.transformation_time_s, "transformation_time_s");
    visit(self.austenite_stiffness_N_m, "austenite_stiffness_N_m");
    visit(self.martensite_stiffness_N_m, "martensite_stiffness_N_m");
    visit(self.coil_stretch_m, "coil_stretch_m");
    visit(self.transformation_stretch_m, "transformation_stretch_m");
  }

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    const Shape& shape = *self.shape;
    const auto& named = with_part;
    // The keys under which these coils have what is above a quantity.
    const auto above = [&](const std::vector<std::string>& shared_keys, const std::vector<std::size_t>& coils) {
      std::set<std::string> keys;
      each_of_coils(self, [&](const auto& upper, std::string_view key) {
        for (const std::size_t j : coils)
          if (std::find(shared_keys.begin(), shared_keys.end(), key) != shared_keys.end())
            keys.insert(upper.which[j] == 0 ? std::string(key) : upper.own_key(key, shape.coils[j].name));
      });
      return std::vector<std::string>(keys.begin(), keys.end());
    };
    const auto of_coils = [&](auto& field, const Declaration& declared) {
      std::vector<std::size_t> sharing;
      for (std::size_t j = 0; j < field.which.size(); ++j)
        if (field.which[j] == 0) sharing.push_back(j);
      Declaration shared = declared;
      if (!declared.less_than.empty()) shared.less_than = above(declared.less_than, sharing);
      if (sharing.empty()) shared.prior_deviation = 0.0;  // nothing is of that value
      visit(field.values.front(), shared);
      for (std::size_t j = 0; j < field.which.size(); ++j) {
        if (field.which[j] == 0) continue;
        Declaration own = declared;
        own.name = field.own_key(declared.name, shape.coils[j].name);
        own.symbol += "," + shape.coils[j].name;
        if (!declared.less_than.empty()) own.less_than = above(declared.less_than, {j});
        visit(field.values[field.which[j]], own);
      }
    };
    constexpr std::string_view build = "Sabelhaus et al. 2022, methods";
    constexpr std::string_view spring = "k = G d^4 / (8 D^3 N), G of 25 (austenite) and 9 GPa (martensite), 25 turns";
    visit(self.supply_voltage_V, Declaration{.name = "supply_voltage_V",
                                             .symbol = "V_s",
                                             .unit = units::V,
                                             .range = {0.5, 60.0},
                                             .typical = 7.0,
                                             .meaning = "voltage across a coil while its switch is closed",
                                             .source = build});
    for (std::size_t j = 0; j < shape.coils.size(); ++j)
      visit(self.resistance_Ohm[j], Declaration{.name = named("resistance", shape.coils[j].name, "_Ohm"),
                                                .symbol = named("R", shape.coils[j].name, ""),
                                                .unit = units::Ohm,
                                                .range = {0.05, 100.0},
                                                .typical = 2.5,
                                                .prior_deviation = 0.25,
                                                .meaning = "electrical resistance of the whole wire of this side",
                                                .source = "Flexinol data sheet, 4.3 Ohm/m at 0.51 mm, 0.6 m"});
    for (std::size_t j = 0; j < shape.coils.size(); ++j)
      visit(self.heat_capacity_J_K[j], Declaration{.name = named("heat_capacity", shape.coils[j].name, "_J_K"),
                                                   .symbol = "C_w," + shape.coils[j].name,
                                                   .unit = units::J_K,
                                                   .range = {0.05, 20.0},
                                                   .typical = 0.85,
                                                   .prior_deviation = 0.4,
                                                   .meaning = "heat that warms the wire of this side by one kelvin",
                                                   .source = "0.8 g of Ni-Ti and what is glued to it"});
    for (std::size_t j = 0; j < shape.coils.size(); ++j)
      visit(self.heat_loss_W_K[j], Declaration{.name = named("heat_loss", shape.coils[j].name, "_W_K"),
                                               .symbol = named("h", shape.coils[j].name, ""),
                                               .unit = units::W_K,
                                               .range = {0.002, 1.0},
                                               .typical = 0.040,
                                               .prior_deviation = 0.02,
                                               .meaning = "heat lost to the surroundings for each kelvin above ambient",
                                               .source = "cooling time constant of about 21 s"});
    visit(self.ambient_temperature_degC, Declaration{.name = "ambient_temperature_degC",
                                                     .symbol = "T_inf",
                                                     .unit = units::degC,
                                                     .range = {-20.0, 60.0},
                                                     .typical = 25.0,
                                                     .prior_deviation = 3.0,
                                                     .meaning = "temperature of the surroundings",
                                                     .source = "room"});
    of_coils(self.heating_midpoint_degC, Declaration{.name = "heating_midpoint_degC",
                                                     .symbol = "T_heat",
                                                     .unit = units::degC,
                                                     .range = {0.0, 200.0},
                                                     .typical = 75.0,
                                                     .prior_deviation = 10.0,
                                                     .meaning = "temperature at which half of the martensite is gone on heating",
                                                     .source = "Flexinol 70 degC alloy data sheet"});
    of_coils(self.heating_width_K, Declaration{.name = "heating_width_K",
                                               .symbol = "w_heat",
                                               .unit = units::K,
                                               .range = {0.5, 50.0},
                                               .typical = 7.0,
                                               .prior_deviation = 3.0,
                                               .meaning = "width of the heating envelope",
                                               .source = "Flexinol data sheet"});
    of_coils(self.cooling_midpoint_degC, Declaration{.name = "cooling_midpoint_degC",
                                                     .symbol = "T_cool",
                                                     .unit = units::degC,
                                                     .range = {0.0, 200.0},
                                                     .typical = 60.0,
                                                     .prior_deviation = 10.0,
                                                     .less_than = {"heating_midpoint_degC"},
                                                     .meaning = "temperature at which half of the martensite is back on cooling",
                                                     .source = "Flexinol 70 degC alloy data sheet"});
    of_coils(self.cooling_width_K, Declaration{.name = "cooling_width_K",
                                               .symbol = "w_cool",
                                               .unit = units::K,
                                               .range = {0.5, 50.0},
                                               .typical = 7.0,
                                               .prior_deviation = 3.0,
                                               .meaning = "width of the cooling envelope",
                                               .source = "Flexinol data sheet"});
    of_coils(self.transformation_time_s, Declaration{.name = "transformation_time_s",
                                                     .symbol = "tau_xi",
                                                     .unit = units::s,
                                                     .range = {0.005, 10.0},
                                                     .typical = 0.10,
                                                     .prior_deviation = 0.05,
                                                     .meaning = "time in which the fraction is pulled back to an envelope that passed it",
                                                     .source = "regularised play operator"});
    of_coils(self.austenite_stiffness_N_m, Declaration{.name = "austenite_stiffness_N_m",
                                                       .symbol = "k_a",
                                                       .unit = units::N_m,
                                                       .range = {1.0, 5000.0},
                                                       .typical = 313.0,
                                                       .prior_deviation = 90.0,
                                                       .meaning = "stiffness of a hot coil spring",
                                                       .source = spring});
    of_coils(self.martensite_stiffness_N_m, Declaration{.name = "martensite_stiffness_N_m",
                                                        .symbol = "k_m",
                                                        .unit = units::N_m,
                                                        .range = {1.0, 5000.0},
                                                        .typical = 113.0,
                                                        .prior_deviation = 35.0,
                                                        .meaning = "stiffness of a cold coil spring",
                                                        .source = spring});
    of_coils(self.coil_stretch_m, Declaration{.name = "coil_stretch_m",
                                              .symbol = "delta_0",
                                              .unit = units::m,
                                              .range = {0.0, 0.3},
                                              .typical = 0.030,
                                              .prior_deviation = 0.006,
                                              .meaning = "stretch of a hot coil over its free length when the limb is straight",
                                              .source = build});
    of_coils(self.transformation_stretch_m, Declaration{.name = "transformation_stretch_m",
                                                        .symbol = "delta_t",
                                                        .unit = units::m,
                                                        .range = {0.0, 0.3},
                                                        .typical = 0.028,
                                                        .prior_deviation = 0.006,
                                                        .meaning = "by how much a cold coil is longer than a hot one",
                                                        .source = build});
    for (std::size_t j = 0; j < shape.coils.size(); ++j)
      visit(self.moment_arm_m[j], Declaration{.name = named("moment_arm", shape.coils[j].name, "_m"),
                                              .symbol = named("r", shape.coils[j].name, ""),
                                              .unit = units::m,
                                              .range = {0.0005, 0.1},
                                              .typical = 0.006,
                                              .prior_deviation = 0.001,
                                              .meaning = "distance of the coil from the beam's neutral line",
                                              .source = build});
    for (std::size_t s = 0; s < shape.segments.size(); ++s)
      visit(self.beam_stiffness_Nm_rad[s], Declaration{.name = named("beam_stiffness", shape.segment_names[s], "_Nm_rad"),
                                                       .symbol = named("k_b", shape.segment_names[s], ""),
                                                       .unit = units::Nm_rad,
                                                       .range = {0.001, 5.0},
                                                       .typical = 0.050,
                                                       .prior_deviation = 0.025,
                                                       .meaning = "bending stiffness of the silicone body",
                                                       .source = "E I / L of Smooth-Sil 945"});
    for (std::size_t s = 0; s < shape.segments.size(); ++s)
      visit(self.beam_damping_Nms_rad[s], Declaration{.name = named("beam_damping", shape.segment_names[s], "_Nms_rad"),
                                                      .symbol = named("c", shape.segment_names[s], ""),
                                                      .unit = units::Nms_rad,
                                                      .range = {1e-5, 1.0},
                                                      .typical = 0.004,
                                                      .prior_deviation = 0.004,
                                                      .meaning = "viscous damping of bending",
                                                      .source = "loss factor of silicone"});
    for (std::size_t s = 0; s < shape.segments.size(); ++s)
      visit(self.beam_inertia_kgm2[s], Declaration{.name = named("beam_inertia", shape.segment_names[s], "_kgm2"),
                                                   .symbol = named("J", shape.segment_names[s], ""),
                                                   .unit = units::kgm2,
                                                   .range = {1e-7, 1e-2},
                                                   .typical = 2.0e-5,
                                                   .meaning = "moment of inertia of the body about its base",
                                                   .source = "m L^2 / 3"});
    for (std::size_t b = 0; b < shape.bends.size(); ++b)
      visit(self.angle_offset_rad[b], Declaration{.name = named("angle_offset", shape.bends[b].name, "_deg"),
                                                  .symbol = named("theta_0", shape.bends[b].name, ""),
                                                  .unit = units::deg,
                                                  .range = {-90.0, 90.0},
                                                  .typical = 0.0,
                                                  .prior_deviation = 3.0,
                                                  .meaning = "what the bend sensor reports when the limb is straight",
                                                  .source = "bend sensor, accuracy of a few degrees"});
    for (std::size_t b = 0; b < shape.bends.size(); ++b)
      visit(self.bend_sign[b], Declaration{.name = named("bend_sign", shape.bends[b].name, ""),
                                           .symbol = named("sign", shape.bends[b].name, ""),
                                           .unit = units::none,
                                           .kind = Kind::sign,
                                           .range = {-1.0, 1.0},
                                           .typical = 1.0,
                                           .meaning = "+1 where a coil at direction 0 bends the limb towards positive angles",
                                           .source = "wiring"});
  }
};

}  // namespace sinew::plant
