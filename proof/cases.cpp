// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>

#include "proof/cases.h"
#include "prove/series_limb.h"

namespace sinew::proof {
namespace {

struct Variant {
  const char* name;
  bool prove::Disturbances::*on;
};
constexpr std::array<Variant, 5> variants{{{"coarse", &prove::Disturbances::coarse_steps},
                                           {"gaps", &prove::Disturbances::gaps},
                                           {"outliers", &prove::Disturbances::outliers},
                                           {"clock", &prove::Disturbances::clock_drift},
                                           {"mid_motion", &prove::Disturbances::mid_motion}}};
// In what a recording can differ from babbling at 10 Hz in air that both wires share, of a limb that is off by 8 %.
struct Elsewhere {
  const char* name;
  std::function<void(prove::Settings&)> make;
};
const std::vector<Elsewhere>& elsewhere() {
  using prove::AirMotion;
  using prove::Protocol;
  using prove::Settings;
  const auto rate = [](double sample_rate_Hz) { return [=](Settings& settings) { settings.sample_rate_Hz = sample_rate_Hz; }; };
  const auto air = [](AirMotion motion) { return [=](Settings& settings) { settings.air = motion; }; };
  const auto protocol = [](Protocol what) { return [=](Settings& settings) { settings.protocol = what; }; };
  const auto lasting = [](double training_s, double heldout_s) {
    return [=](Settings& settings) { settings.training_s = training_s, settings.heldout_s = heldout_s; };
  };
  static const std::vector<Elsewhere> all{{"2Hz", rate(2.0)},
                                          {"5Hz", rate(5.0)},
                                          {"20Hz", rate(20.0)},
                                          {"50Hz", rate(50.0)},
                                          {"still_air", [](Settings& settings) { settings.disturbances.moving_air = false; }},
                                          {"separate_air", air(AirMotion::separate)},
                                          {"slow_air", air(AirMotion::slow)},
                                          {"fast_air", air(AirMotion::fast)},
                                          {"steps", protocol(Protocol::steps)},
                                          {"slow_ramps", protocol(Protocol::slow_ramps)},
                                          {"random_binary", protocol(Protocol::random_binary)},
                                          {"one_sided", protocol(Protocol::one_sided)},
                                          {"core_15", [](Settings& settings) { settings.core_spread = 0.15; }},
                                          {"2min", lasting(120.0, 120.0)},
                                          {"10min", lasting(600.0, 300.0)},
                                          {"20min", lasting(1200.0, 600.0)}};
  return all;
}

constexpr std::array<double, 5> strengths{1.0, 0.5, 0.25, 1.0, 0.5};
constexpr int begun_warm = 4;        // mid_motion, of the variants
constexpr int removed_from = 500;    // seeds of what is taken out of the catalogue, from the first one on
constexpr int elsewhere_from = 500;  // of recordings elsewhere, from the first clean one on

const std::vector<prove::Kind>& further() {
  static const std::vector<prove::Kind> all = prove::further_kinds();
  return all;
}

// What stores heat under the thermocouple is begun cold and begun warm.
bool has_junction(const prove::Kind& kind) {
  return std::ranges::any_of(kind.effects, [](const std::string& effect) { return effect.starts_with("junction"); });
}
// The cases of these come last: they leave the others as they were. Turns outside had two cases in the catalogue, and have two here.
bool comes_last(const prove::Kind& kind) { return has_junction(kind) && kind.name != "junction.outer_turns"; }
// And those of these after them.
bool is_further(const prove::Kind& kind) { return std::ranges::find(further(), kind.name, &prove::Kind::name) != further().end(); }

std::string text_of(double strength) { return strength == 1.0 ? "1" : strength == 0.5 ? "0.5" : "0.25"; }

}  // namespace

std::string ProofCase::family() const {
  if (series) return "series_limb";
  return removed ? "removed" : elsewhere ? "elsewhere" : std::string(prove::name_of(kind.family));
}

std::string ProofCase::id() const {
  return family() + "-" + kind.name + "-" + variant + "-" + text_of(settings.strength) + "-" + std::to_string(seed);
}

std::vector<ProofCase> proof_cases(FirstSeeds first, int seeds, int clean, double training_s, double held_out_s) {
  std::vector<ProofCase> cases;
  const auto add = [&](const prove::Kind& kind, int index, double strength, int variant, bool removed) {
    const std::uint64_t from = kind.family == prove::Family::clean ? first.clean : first.concealed;
    ProofCase one{kind, from + static_cast<std::uint64_t>(index), {}, "plain", removed};
    one.settings.training_s = training_s;
    one.settings.heldout_s = held_out_s;
    one.settings.strength = strength;
    if (variant >= 0) {
      one.variant = variants[static_cast<std::size_t>(variant)].name;
      one.settings.disturbances.*variants[static_cast<std::size_t>(variant)].on = true;
    }
    cases.push_back(one);
  };
  const auto add_clean = [&](const prove::Kind& kind, int index) {
    const int turn = index % clean_per_seed;
    add(kind, index, 1.0, turn < 3 ? -1 : turn - 3, false);
  };
  for (int s = 0; s < seeds; ++s)
    for (const prove::Kind& kind : prove::kinds()) {
      if (comes_last(kind) || is_further(kind)) continue;
      const std::size_t before = cases.size();
      const double strength = strengths[static_cast<std::size_t>(s) % strengths.size()];
      switch (kind.family) {
        case prove::Family::clean:
          for (int i = 0; i < clean_per_seed; ++i) add_clean(kind, clean_per_seed * s + i);
          break;
        case prove::Family::catalogue: {
          add(kind, s, strength, s == 3 ? static_cast<int>(cases.size() % variants.size()) : -1, false);
          // Stands for an effect that the catalogue lacks: plain, or there would be nothing to be wrong about.
          add(kind, removed_from + s, s % 2 == 0 ? 1.0 : 0.5, -1, true);
          break;
        }
        case prove::Family::other_form:
        case prove::Family::outside:
        case prove::Family::pair:
        case prove::Family::triple:
        case prove::Family::unlike:
          add(kind, s, s % 2 == 0 ? 1.0 : 0.5, -1, false);
          if (has_junction(kind)) add(kind, s, s % 2 == 0 ? 1.0 : 0.5, begun_warm, false);
          break;
      }
      for (std::size_t i = before; i < cases.size(); ++i) cases[i].with_baselines = s == 0;
    }
  for (const prove::Kind& kind : prove::kinds())
    if (kind.family == prove::Family::clean)
      for (int i = clean_per_seed * seeds; i < clean; ++i) add_clean(kind, i);
  for (int s = 0; s < seeds; ++s)
    for (const prove::Kind& kind : prove::kinds()) {
      if (!comes_last(kind)) continue;
      const bool named = kind.family == prove::Family::catalogue;
      const double strength = named ? strengths[static_cast<std::size_t>(s) % strengths.size()] : s % 2 == 0 ? 1.0 : 0.5;
      const std::size_t before = cases.size();
      add(kind, s, strength, -1, false);
      add(kind, s, strength, begun_warm, false);
      if (named) add(kind, removed_from + s, s % 2 == 0 ? 1.0 : 0.5, -1, true);
      for (std::size_t i = before; i < cases.size(); ++i) cases[i].with_baselines = s == 0;
    }
  for (int s = 0; s < seeds; ++s) {
    const std::size_t before = cases.size();
    for (const prove::Kind& kind : further()) add(kind, s, s % 2 == 0 ? 1.0 : 0.5, -1, false);
    for (std::size_t i = before; i < cases.size(); ++i) cases[i].with_baselines = s == 0;
    const int sorts = static_cast<int>(elsewhere().size());
    for (int i = 0; i < sorts; ++i) {
      add(prove::kinds().front(), elsewhere_from + sorts * s + i, 1.0, -1, false);
      cases.back().elsewhere = true;
      cases.back().variant = elsewhere()[static_cast<std::size_t>(i)].name;
      elsewhere()[static_cast<std::size_t>(i)].make(cases.back().settings);
    }
  }
  return cases;
}

std::vector<ProofCase> series_proof_cases(FirstSeeds first, int seeds, double training_s, double held_out_s) {
  std::vector<ProofCase> cases;
  for (int s = 0; s < seeds; ++s)
    for (const prove::Kind& kind : prove::series_kinds()) {
      const bool clean = kind.family == prove::Family::clean;
      ProofCase one{kind, (clean ? first.clean : first.concealed) + static_cast<std::uint64_t>(s), {}, "plain"};
      one.settings.training_s = training_s;
      one.settings.heldout_s = held_out_s;
      if (!clean) one.settings.strength = strengths[static_cast<std::size_t>(s) % strengths.size()];
      one.series = true;
      cases.push_back(one);
    }
  return cases;
}

std::vector<ProofCase> unlike_proof_cases(FirstSeeds first, int seeds, double training_s, double held_out_s) {
  std::vector<ProofCase> cases;
  for (int s = 0; s < seeds; ++s)
    for (const prove::Kind& kind : prove::unlike_kinds()) {
      ProofCase one{kind, first.concealed + static_cast<std::uint64_t>(s), {}, "plain"};
      one.settings.training_s = training_s;
      one.settings.heldout_s = held_out_s;
      one.settings.strength = s % 2 == 0 ? 1.0 : 0.5;
      cases.push_back(one);
    }
  return cases;
}

std::vector<ProofCase> few_proof_cases(double training_s, double held_out_s) {
  const std::vector<std::string> wanted{"clean-core-plain",        "clean-core-gaps",
                                        "clean-core-outliers",     "catalogue-thermocouple_lag-",
                                        "catalogue-latent_heat-",  "catalogue-viscoelastic_creep-",
                                        "catalogue-dry_friction-", "catalogue-supply_sag-",
                                        "catalogue-fatigue-",      "other_form-viscoelastic_creep",
                                        "outside-bend_cooling",    "outside-motion_cooling"};
  std::vector<ProofCase> few;
  for (const std::string& prefix : wanted)
    for (const ProofCase& one : proof_cases(development_seeds, 1, clean_per_seed, training_s, held_out_s))
      if (one.id().starts_with(prefix)) {
        few.push_back(one);
        few.back().with_baselines = few.size() % 4 == 1;
        break;
      }
  return few;
}

nlohmann::ordered_json answer_of(const ProofCase& one, const prove::Concealed& concealed) {
  nlohmann::ordered_json answer;
  // Scored by what is concealed, wherever that is.
  answer["family"] = one.elsewhere || one.series ? std::string(prove::name_of(one.kind.family)) : one.family();
  answer["kind"] = one.kind.name;
  answer["variant"] = one.variant;
  answer["strength"] = one.settings.strength;
  answer["seed"] = one.seed;
  answer["effects"] = nlohmann::ordered_json::array();
  for (const prove::TruthEffect& effect : concealed.effects)
    answer["effects"].push_back({{"name", effect.name},
                                 {"form", effect.form},
                                 {"place", effect.place},
                                 {"in_catalogue", effect.in_catalogue},
                                 {"parameters", effect.parameters},
                                 {"words", effect.words}});
  answer["core"] = concealed.core_parameters;
  return answer;
}

}  // namespace sinew::proof
