// SPDX-License-Identifier: Apache-2.0
// An investigation: recordings, what is believed after each, the experiment that is asked next, and why it ends.
//
// `Investigation` is the state as plain values; it is written after every change, so that a later call goes on where this one was
// stopped. `investigate` moves it on: diagnose all recordings together, decide, record, again. What it needs from outside it is given: a
// `Limb` that records a scenario, and hooks that save, show and ask. Nothing here reads a clock, and equal recordings give equal states.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hil/session.h"
#include "investigate/design.h"

namespace sinew::investigate {

// What the limb's time is used for. All but the first are for comparison: they plan the whole budget ahead and look once more, at its end.
enum class Use {
  designed,  // each experiment by what is believed then
  babbling,  // the paper's, all the time
  random,    // programmes whose shape is drawn by chance, within the same limits
  once,      // the one that is designed after the first recording, again and again
};
std::string_view text_of(Use use);
std::optional<Use> use_of(std::string_view text);

// What an investigation is asked for: until one answer has so much, within so many seconds of the limb's time (cooling included;
// recordings that are given do not count).
struct Asked {
  // The diagnosis gives 0.9 only to a name that gains above 170, is not faint, has no law beside it and no values that no one believes
  // (diagnose/confidence.cpp).
  double probability = 0.9, budget_s = 1800.0;
  bool operator==(const Asked&) const = default;
};

struct Settings {
  Use use = Use::designed;
  Asked asked;
  std::map<std::string, Asked> asked_then;  // of a replay: when each step was planned, by its name
  double first_s = 120.0;                   // of babbling, where no recording is given
  double longest_s = 160.0;                 // that an experiment drives the limb
  // Where the best experiment is expected to take away less than this share of the entropy, none tells.
  double least_share = 0.08;
  // So many experiments in a row that told less than a tenth of what was expected: none tells.
  int most_idle = 2;
  std::int64_t seed = 1;
  int threads = 2;
  diagnose::DiagnosisSettings diagnosis;
};

// What a belief looks like in a file: words, and no ids.
struct Believed {
  struct Answer {
    std::string key, kind;
    double probability = 0.0;
  };
  std::vector<Answer> answers;  // most probable first
  std::string verdict;
  std::vector<std::string> unseen;
  double entropy_bit = 0.0;
  std::vector<std::pair<std::string, double>> values;  // of the first answer's parameters, in the units of files
};

// What was learned from one belief to the next: the relative entropy of the later to the earlier one. On average over what may come back
// that is what an experiment is expected to tell; a belief that was wrong and is shaken is less certain than before, and has learned, too.
// What an earlier belief does not have, or excludes, counts there as one in ten thousand.
// Source: Lindley 1956, Annals of Mathematical Statistics 27:986.
double told_bit(const Believed& before, const Believed& after);

struct Plan {
  std::string words, family;  // what it will do
  std::string apart, from;    // which answers it is to tell apart
  double duration_s = 0.0, cool_s = 0.0;
  double expected_bit = 0.0;  // by which the entropy is expected to fall
  double separation = 0.0;    // of the two, in standard deviations
  double highest_degC = 0.0;
  std::size_t tried = 0;  // programmes that were simulated
  std::string scenario_yaml;
};

std::string folder_name(std::size_t number);  // "recording_01": of the first

struct Step {
  std::string name;    // of its folder
  std::string origin;  // "given", "babbling", "experiment"
  std::optional<Plan> plan;
  // Of what was recorded; none: it is still to be.
  std::optional<std::string> status;  // "finished", or how a session ended
  std::string why;
  double duration_s = 0.0;        // that were recorded
  double highest_degC = 0.0;      // measured
  std::int64_t lowered = 0;       // commands that the host's supervisor lowered
  bool used = true;               // long enough to be diagnosed
  std::optional<Believed> after;  // what was believed then
  std::optional<Asked> asked;     // what was asked for when it was planned
};

enum class Ending {
  resolved,     // one answer has the probability that was asked
  cannot_tell,  // no experiment within the limits would
  budget,       // no time is left for one
  stopped,      // by a person; can be gone on with
  interrupted,  // by a supervisor, or the link was lost; can be gone on with
};
std::string_view text_of(Ending ending);

struct Investigation {
  std::vector<Step> steps;
  std::optional<Ending> ending;
  std::string ending_words;
  std::vector<std::string> measure;  // where duty cannot tell: what would have to be measured
  double spent_s() const;            // of the limb's time
  Step* next();                      // the first that is planned and not recorded; null: none
};
// Experiments at the end that told less than a tenth of what was expected of them. One that was cut short says nothing of that, nor does
// what was planned before another probability or budget was asked for.
int idle(const Investigation& investigation, const Asked& asked);
nlohmann::ordered_json to_json(const Investigation& investigation);
Investigation from_json(const nlohmann::ordered_json& json);  // throws nlohmann::json::exception

struct Recorded {
  sim::Recording recording;  // readings at the time they were made (hil/timed_recording.h)
  hil::SessionStatus status = hil::SessionStatus::finished;
  std::string why;
  std::int64_t lowered = 0;
};

// Who records.
class Limb {
 public:
  virtual ~Limb() = default;
  // A session of the scenario, whose files are kept as `name`. Throws hil::Refused where the board was not armed.
  virtual Recorded record(const sim::Scenario& scenario, const std::string& name) = 0;
  // One that is kept already.
  virtual sim::Recording read(const std::string& name) = 0;
};

struct Hooks {
  std::function<void(const Investigation&)> save;  // after every change
  std::function<void(const Investigation&)> show;  // after every belief
  std::function<bool(const Step&)> confirm;        // before each session; false: a person stops it
  std::function<bool()> should_stop;
  std::function<void(double share, const std::string& doing)> progress;
  // Around what can take long and cannot always be asked to stop.
  std::function<void(bool begins)> computing;
};

// Goes on until it ends, or, `dry`, until the first session would begin. Throws what the limb throws; diagnose::Stopped where a person
// stopped a computation.
void investigate(Investigation& investigation, const plant::Plant& nominal, const Settings& settings, Limb& limb, const Hooks& hooks,
                 bool dry);

}  // namespace sinew::investigate
