// SPDX-License-Identifier: Apache-2.0
// Recordings of a limb of two planar segments in series, base and tip, with two antagonistic coils on each: four coils, four
// thermocouples, two bend sensors. A second limb with physics of its own, as generator.h has one with two coils.
//
// Each segment is a beam of constant curvature with the core's equations (design/plant.md, section 1). The angle of the tip is relative to
// the base; weight acts by the absolute angle, the sum of both; segments exchange no heat, and their inertias are not coupled.
//
// A recording of it has the columns of plant/limbs/series_limb.yaml, from which a diagnosis starts: time_s, duty_<coil>,
// temperature_<coil>_degC, angle_<segment>_deg, in the order of series_coils and series_segments.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "prove/generator.h"

namespace sinew::prove {

inline constexpr std::array<std::string_view, 4> series_coils{"base_A", "base_B", "tip_A", "tip_B"};  // A bends towards positive angles
inline constexpr std::array<std::string_view, 2> series_segments{"base", "tip"};

// As Sample is: what the sensors showed at time_s, and the duty commanded on that.
struct SeriesSample {
  double time_s = 0.0;
  std::array<double, series_coils.size()> duty{}, temperature_degC{};
  std::array<double, series_segments.size()> angle_deg{};  // of the tip: relative to the base
};
std::vector<std::string> series_columns();                // in the order of series_row
std::vector<double> series_row(const SeriesSample& row);  // all of it, by columns

// What can be concealed: nothing, or one effect of the catalogue, with the same values on every part: thermocouple_lag, cross_heating
// (between the coils of a segment), viscoelastic_creep, stress_shift, gravity_load (by the absolute angle).
std::vector<Kind> series_kinds();

struct SeriesConcealed {
  std::vector<SeriesSample> training, heldout;
  std::map<std::string, double> core_parameters;  // true ones, all, YAML names of the plant file
  std::vector<TruthEffect> effects;
  std::vector<SeriesSample> training_without_noise, heldout_without_noise;
};

// As `make`, of which Settings keep their meaning, with babbling on both segments, each with setpoints of its own. Throws
// std::invalid_argument for an effect that it does not have, and for a protocol or a disturbance other than moving air, which it does not
// have either.
SeriesConcealed make_series(const Kind& kind, std::uint64_t seed, const Settings& settings = {});

// As `simulate`.
std::vector<SeriesSample> simulate_series(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& effects,
                                          const std::vector<SeriesSample>& samples);

}  // namespace sinew::prove
