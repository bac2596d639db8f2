// SPDX-License-Identifier: Apache-2.0
// One concealed case as the score sees it: what is true of it, and what the diagnosis reported. case_file.h reads both.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::proof {

// `removed`: an effect of the catalogue that was taken out of it beforehand, so that its name cannot be given.
// `unlike`: parts that are not alike, alone or beside an effect of the catalogue.
enum class CaseFamily { clean, catalogue, other_form, pair, triple, outside, removed, unlike };
inline constexpr std::initializer_list<CaseFamily> case_families{CaseFamily::clean,   CaseFamily::catalogue, CaseFamily::other_form,
                                                                 CaseFamily::pair,    CaseFamily::triple,    CaseFamily::outside,
                                                                 CaseFamily::removed, CaseFamily::unlike};
std::string_view text_of(CaseFamily family);  // as in answers.json

struct TrueEffect {
  std::string name, place;                   // place: the equation that it enters
  std::map<std::string, double> parameters;  // units of files
  std::string form = "";                     // of parts that are not alike: the first of the quantities in which they differ
};

struct Truth {
  CaseFamily family = CaseFamily::clean;
  std::string variant;  // "plain", or the disturbance that comes on top of moving air
  std::uint64_t seed = 0;
  std::vector<TrueEffect> effects;  // none in a clean case
};

// named_in_part: names, and something is left. failed: the diagnosis gave up.
enum class Verdict { consistent, missing_physics, named_in_part, unexplained, failed };
std::string_view text_of(Verdict verdict);  // as in a case's file

struct ReportedParameter {
  double value, lowest, highest;  // 95 %
  bool known;                     // not fitted
};

struct ReportedEffect {
  std::string name;
  double probability = 0.0;
  std::string strength;     // the parameter that says how much of the effect there is
  double null_value = 0.0;  // of the strength
  std::map<std::string, ReportedParameter> parameters;
};

// What simpler methods made of the same case (baselines.h). Errors as `HeldOut`.
struct ReportedBaselines {
  std::vector<std::string> bic_names;
  std::map<std::string, double> bic_weights;  // posterior probability of each effect tried, by BIC; empty in older files
  std::optional<double> bic_after;            // none where BIC's fit could not be used
  int sindy_terms = 0;                        // over all channels
  double sindy_after = 0.0, gaussian_process_after = 0.0;
};

// Open-loop error on the held-out recording: RMSE of the channels in units of their noise, as one number. NaN where a plant
// could not follow the recording to its end.
struct HeldOut {
  double before = 0.0, after = 0.0;  // of the calibrated plant as given, and repaired
  std::optional<double> refit;       // of the plant with the true effects of the catalogue, fitted by the diagnosis
  std::optional<double> oracle;      // of the generator's own law, fitted (oracle.h)
};

// A free law: physics without a name that was found at an equation.
struct ReportedLaw {
  std::string place, entry;
};

// That parts are not alike, in what: by the first quantity.
struct ReportedApart {
  std::string quantity;
  double probability = 0.0;  // none was given by earlier programs
};

struct Candidate {
  std::string name;
  double misfit;
};

struct Reported {
  Verdict verdict = Verdict::consistent;
  std::string why_failed;
  std::vector<ReportedEffect> effects;      // names given, strongest first
  std::vector<std::string> ambiguous_with;  // further names that cannot be told from those
  std::vector<std::string> cannot_be_seen;  // names of what this recording cannot show
  std::vector<ReportedLaw> laws;
  std::vector<ReportedApart> apart;
  std::string place;                      // the equation in which something is missing
  std::vector<std::string> places_alike;  // others that cannot be told from it
  // Where an answer that nothing is missing says how probable that is.
  std::optional<double> probability_of_nothing;
  double visibility = 0.0;  // d'
  double explained_share = 0.0;
  double process_noise_before = 0.0, process_noise_after = 0.0;
  double core_misfit = 0.0;
  std::vector<Candidate> first_candidates;  // as the first round of the search fitted each alone
  double largest_gain = 0.0;                // of any round, accepted or not
  std::vector<std::string> objections;
  HeldOut held_out;
  std::optional<ReportedBaselines> baselines;
  std::string made_by;  // which program
};

struct Case {
  std::string id;
  Truth truth;
  Reported reported;
};

}  // namespace sinew::proof
