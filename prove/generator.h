// SPDX-License-Identifier: Apache-2.0
// Recordings with something concealed in them, for putting the diagnosis to the proof: `make` gives a training and a
// held-out recording of one limb, and apart from them what is true of that limb.
//
// Written from the equations of design/plant.md alone. It shares no line with plant/, sim/ or diagnose/ (tests/layers
// sees to it): physics, integrator, chance and sensors are its own, so that a tool that explains these recordings is
// not recognising its own handwriting. tests/prove/generator_test.cpp is the one place where the two limbs meet.
//
// Everything is a function of (kind, seed, settings); the same binary on the same machine gives the same bits. Chance
// is split by consumer: a disturbance that is switched on leaves the limb, its setpoints and the other noise as they
// were (but for mid_motion, which cuts their beginning away). Another strength leaves all draws as they were, and so do another sample
// rate, another protocol, other air and another spread of the core.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::prove {

// A row as a recording keeps it: what the sensors showed at time_s, and the duty commanded on that, held until the next
// row. The duty of the last row has no consequence. A missing measurement is NaN; time and duty never are.
struct Sample {
  double time_s = 0.0;
  std::array<double, 2> duty{};  // of A and B, 0 to 1
  std::array<double, 2> temperature_degC{};
  double angle_deg = 0.0;
};

// What is true of a limb beyond the core.
struct TruthEffect {
  std::string name;   // of the catalogue, where the physics is the catalogue's; otherwise a name of its own
  std::string form;   // another functional form of the catalogue's effect; empty: the catalogue's own, or no form of any
  std::string place;  // sensor.temperature, thermal, actuation, transformation, mechanics, sensor.angle
  std::map<std::string, double> parameters;  // in_catalogue: YAML names; otherwise names of its own, units in them
  bool in_catalogue = true;                  // name, equation and parameters are those of the catalogue
  std::string words;
};

// unlike: the core, in which each coil has values of its own of what coils share; alone, or beside an effect of the catalogue.
enum class Family { clean, catalogue, other_form, pair, outside, triple, unlike };
std::string_view name_of(Family family);

struct Kind {
  Family family = Family::clean;
  std::string name;                  // unique: "core", "latent_heat", "dry_friction.stribeck", "a+b", "rate_shift"
  std::vector<std::string> effects;  // "name", or "name.form"
};

// Every kind of case, in a fixed order: clean, the catalogue in its order, other forms, pairs, outside; then the kinds with a junction,
// alone, with a layer around it (a layer is never alone), and in other forms. "junction.outer_turns" has the place, and draws the numbers,
// that it had when it was "outer_turns" of the catalogue. At last those of further_kinds.
std::vector<Kind> kinds();
// Those of them that come at the end: triples, further other forms, more that is outside, pairs that share a place, the other forms
// that came last, and what has a name in the catalogue since. The cases of all others stand before theirs.
std::vector<Kind> further_kinds();
// Coils that are not alike; not among kinds().
std::vector<Kind> unlike_kinds();

struct Disturbances {
  bool moving_air = true;     // ambient wanders; Settings::air says how
  bool coarse_steps = false;  // 0.5 K and 0.25 deg instead of 0.25 K and 1/32 deg; the controller sees them too
  bool gaps = false;          // stretches of 0.5 to 8 s are missing, each in one channel
  bool outliers = false;      // 0.5 % of the samples of each channel are off by 10 to 20 K, or 7.5 to 15 deg
  bool clock_drift = false;   // time_s runs 1 % fast; effects and parameters are in true time
  bool mid_motion = false;    // 30 s of babbling before the recording are cut away; t = 0 is where it starts, all that stores heat warm
};

// What drives the limb. Duty never passes 0.6, and a wire above 110 degC gets none, in all of them.
enum class Protocol {
  babbling,       // setpoints held for 1 to 30 s, in [-45, 45] deg, followed by the paper's PI law
  steps,          // open loop: held for 8 to 30 s at a duty of 0.05 to 0.35; coil A, coil B, both, none, and again
  slow_ramps,     // open loop: duty rises to 0.12 to 0.22 and falls back, over 60 to 120 s in all; coil A, coil B, and again
  random_binary,  // open loop: every 4 s each coil is on with a probability of 1/3, at a duty of 0.25 to 0.45 of its own
  one_sided       // babbling with setpoints in [0, 45] deg, of which coil A alone takes part
};

// How the ambient wanders where air moves: by 0.3 K (one standard deviation) in all of them.
enum class AirMotion {
  shared,    // over 20 to 40 s, the same for both wires
  separate,  // over 20 to 40 s, each wire in air of its own; what belongs to both feels the mean
  slow,      // over 150 s, the same for both wires
  fast       // over 5 s, the same for both wires
};

struct Settings {
  double training_s = 400.0;
  double heldout_s = 200.0;
  // Multiplies the strengths, of every effect: 1 plain, 0.5 moderate, 0.25 barely visible. Shapes (a time constant
  // beside a stiffness, a threshold) stay. A gain's distance from 1 is multiplied; a bend sensor that saturates has its limit
  // divided by the square root. coil_slack has no strength: here it is how much too long the cold coils are. Of a junction, heat
  // capacity, loss and share of the current heat are multiplied, and how much lighter than believed the wire is; its conductance stays.
  double strength = 1.0;
  Disturbances disturbances;
  // Of the controller and of the recording alike, 1 to 100. Physics and air do not know it; every row has a fresh reading.
  double sample_rate_Hz = 10.0;
  Protocol protocol = Protocol::babbling;
  AirMotion air = AirMotion::shared;  // none: Disturbances::moving_air
  // How far the core's parameters may be off, 0 to 0.3; temperatures and the angle's offset in proportion, 3 K and 1 deg at 0.08.
  double core_spread = 0.08;
};

struct Concealed {
  // Both begin cold and at rest (but for mid_motion), at time 0; the second is another babbling of the same limb with
  // its own air and noise. What depends on time begins anew with each recording.
  std::vector<Sample> training, heldout;
  std::map<std::string, double> core_parameters;  // true ones, all, YAML names
  std::vector<TruthEffect> effects;               // true ones, in the kind's order
  // The same rows before noise, steps, gaps and outliers: what perfect sensors would show, with effects and air.
  std::vector<Sample> training_without_noise, heldout_without_noise;
};

// The core's parameters are off their defaults by up to core_spread (8 %, 3 K, angle offset 1 deg); supply, inertia and sign are
// known. A limb with coil_slack has a shorter coil_stretch_m (0.0255) and a longer transformation_stretch_m (0.0335 at
// strength 1, both off by up to 3 %), or its coils would never slacken. One with a junction has lighter wires (heat_capacity_A_J_K and
// heat_capacity_B_J_K 0.5 to 0.8 of their defaults at strength 1), and one share of the current heat in both coils: its relative_power is
// that over its share of the heat capacity, beside the mean of the two wires. Strengths and shapes of effects vary by 25 %, those of a
// junction and its layer by more.
// Throws std::invalid_argument for an effect that there is not, and for a sample rate or a spread beyond its range.
Concealed make(const Kind& kind, std::uint64_t seed, const Settings& settings = {});

// What `make` conceals, without the recordings: for whoever drives the limb in another way (concealed_run in generator_effects.h).
struct ConcealedLimb {
  std::map<std::string, double> core_parameters;
  std::vector<TruthEffect> effects;
  double air_memory_s = 0.0;
};
ConcealedLimb conceal(const Kind& kind, std::uint64_t seed, const Settings& settings = {});

// The kind of that name, of kinds() or unlike_kinds(); throws std::invalid_argument, which names the nearest ones, where there is none.
Kind kind_of_name(std::string_view name);

// Perfect sensors on a limb that is driven by the duty of `samples`, at their times, from cold and rest in still air.
// Core parameters that are not named have their defaults; of effects, name, form and parameters are read, and the
// parameters that are not named are at their null. Throws std::invalid_argument for a name that there is not.
std::vector<Sample> simulate(const std::map<std::string, double>& core_parameters, const std::vector<TruthEffect>& effects,
                             const std::vector<Sample>& samples);

}  // namespace sinew::prove
