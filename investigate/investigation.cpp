// SPDX-License-Identifier: Apache-2.0
#include "investigate/investigation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "diagnose/calibrate.h"
#include "plant/contains.h"
#include "sim/text.h"

namespace sinew::investigate {
namespace {

using Json = nlohmann::ordered_json;

constexpr double least_used_s = 20.0;        // of a recording that is diagnosed
constexpr double least_experiment_s = 45.0;  // that must be left of the budget for another one
constexpr double idle_share = 0.1;
constexpr double least_believed = 1e-4;
constexpr double told_apart = 1.0;            // standard deviations: an experiment that sets two answers less apart tells nothing of them
constexpr double longest_babbling_s = 300.0;  // of one recording
constexpr int most_draws = 50;                // of a programme by chance, until one is within the limits

std::string percent(double probability) {
  char text[16];
  std::snprintf(text, sizeof text, "%.0f %%", 100.0 * probability);
  return text;
}

// What an instrument beside the usual ones would have to measure, by where two answers act.
std::string instrument_for(std::string_view place) {
  if (place == "sensor.temperature") return "the wire's temperature by another thermometer (infrared camera, or the wire's resistance)";
  if (place == "thermal")
    return "the temperature of the silicone, of the neighbouring wire's surroundings and of the room, by further thermometers";
  if (place == "actuation") return "the current through each coil and the supply's voltage (a shunt and a logger)";
  if (place == "transformation") return "the wire's resistance, which follows its martensite fraction";
  if (place == "mechanics") return "the force at the tip (a load cell), with the limb held at an angle";
  if (place == "sensor.angle") return "the angle by a camera";
  return "";
}

Believed believed(const Belief& belief, const diagnose::Diagnosis& diagnosis) {
  Believed result;
  const plant::System& system = diagnosis.search.core.system();
  for (const Hypothesis& one : belief.all) result.answers.push_back({one.key, std::string(text_of(one.kind)), one.probability});
  result.verdict = diagnose::text_of(belief.verdict);
  for (const plant::EffectId e : belief.unseen) result.unseen.emplace_back(system.effects()[e].name);
  result.entropy_bit = belief.entropy_bit();
  if (belief.first().kind != Kind::named) return result;
  for (const diagnose::FoundEffect& found : effects_in(diagnosis.answer))
    for (const auto& parameter : found.parameters)
      result.values.emplace_back(system.parameters()[parameter.parameter].key(), parameter.value);
  const plant::System& own = diagnosis.repaired.system();
  for (const diagnose::FoundApart& found : apart_in(diagnosis.answer))
    for (const auto& move : own.sharings()[*own.effects()[found.effect].sharing].moves)
      for (const plant::Sharing::Quantity& quantity : move)
        for (const diagnose::FoundApart::Value& value : found.values)
          if (value.parameter == quantity.parameter) result.values.emplace_back(quantity.own_keys[value.part], value.value);
  return result;
}

class Investigator {
 public:
  Investigator(Investigation& state, const plant::Plant& nominal, const Settings& settings, Limb& limb, const Hooks& hooks, bool dry)
      : state_(state), nominal_(nominal), settings_(settings), limb_(limb), hooks_(hooks), dry_(dry), asked_(settings.asked) {}

  void run() {
    if (state_.ending == Ending::stopped || state_.ending == Ending::interrupted) {
      state_.ending.reset();
      state_.ending_words.clear();
    }
    while (!state_.ending) {
      if (stopping()) return end(Ending::stopped, "A person stopped it.");
      if (state_.steps.empty()) babble();
      if (Step* next = state_.next()) {
        if (dry_) return;
        if (!record(*next)) return;
        continue;
      }
      decide();
    }
  }

 private:
  bool stopping() const { return hooks_.should_stop && hooks_.should_stop(); }
  void save() const {
    if (hooks_.save) hooks_.save(state_);
  }
  void end(Ending ending, const std::string& words) {
    state_.ending = ending;
    state_.ending_words = words;
    save();
  }
  std::optional<Believed> last_belief() const {
    for (auto step = state_.steps.rbegin(); step != state_.steps.rend(); ++step)
      if (step->after) return step->after;
    return std::nullopt;
  }

  double planned_s() const {
    double sum = state_.spent_s();
    for (const Step& step : state_.steps)
      if (!step.status && step.plan) sum += step.plan->duration_s;
    return sum;
  }
  // Of the budget, for what is not planned yet.
  double left_s() const { return asked_.budget_s - planned_s(); }
  std::int64_t next_seed() const { return settings_.seed + static_cast<std::int64_t>(state_.steps.size()); }

  // Of what is planned next.
  void look_what_is_asked() {
    const auto then = settings_.asked_then.find(folder_name(state_.steps.size() + 1));
    asked_ = then == settings_.asked_then.end() ? settings_.asked : then->second;
  }

  // A short one to begin with; for comparison as many as the budget holds.
  void babble() {
    look_what_is_asked();
    if (!state_.steps.empty() && left_s() < least_experiment_s)  // those before were cut short
      return end(Ending::budget, budget_words());
    state_.steps.push_back(babbling(std::min(settings_.first_s, std::floor(left_s()))));
    if (settings_.use == Use::babbling) babble_on();
  }
  void babble_on() {
    while (left_s() >= least_experiment_s) state_.steps.push_back(babbling(std::min(longest_babbling_s, std::floor(left_s()))));
  }

  // The paper's, with fresh setpoints of its own.
  Step babbling(double duration_s) const {
    Step step;
    const std::size_t number = state_.steps.size() + 1;
    step.name = folder_name(number);
    step.origin = "babbling";
    step.asked = asked_;
    Plan plan;
    sim::Scenario scenario;
    scenario.comments = {number == 1 ? "The first recording of an investigation: babbling." : "Babbling."};
    scenario.seed = next_seed();
    scenario.duration_s = duration_s;
    scenario.plant = nominal_;
    scenario.sensors = sim::usual_sensors(nominal_.system());
    scenario.start.assign(nominal_.states().size(), std::nullopt);
    sim::BabbleInput babble;
    babble.positive_drives = nominal_.system().inputs()[nominal_.system().drives().front().input].name;
    babble.longest_hold_s = std::min(babble.longest_hold_s, duration_s / 8.0);
    scenario.input = babble;
    plan.words = "babbling: random setpoints of the angle, followed by the paper's controller";
    plan.family = "babbling";
    plan.duration_s = duration_s;
    plan.highest_degC = std::numeric_limits<double>::quiet_NaN();
    plan.scenario_yaml = sim::to_yaml(scenario);
    step.plan = plan;
    return step;
  }

  bool record(Step& step) {
    save();
    if (hooks_.confirm && !hooks_.confirm(step)) {
      end(Ending::stopped, "A person said no to " + step.name + ".");
      return false;
    }
    const sim::Scenario scenario = sim::parse_scenario(step.plan->scenario_yaml, step.name + "/scenario.yaml");
    const Recorded recorded = limb_.record(scenario, step.name);
    take(step, recorded.recording);
    step.status = hil::words(recorded.status);
    step.why = recorded.why;
    step.lowered = recorded.lowered;
    if (recorded.status == hil::SessionStatus::finished) {
      save();
      return true;
    }
    // What was recorded until then is kept, and used when it goes on.
    if (recorded.status == hil::SessionStatus::stopped)
      end(Ending::stopped, "A person stopped it during " + step.name + ".");
    else
      end(Ending::interrupted, "During " + step.name + ": " + recorded.why);
    return false;
  }

  static void take(Step& step, const sim::Recording& recording) {
    step.duration_s = recording.duration_s();
    step.used = step.duration_s >= least_used_s;
    step.highest_degC = std::numeric_limits<double>::quiet_NaN();
    for (const sim::Sample& sample : recording.samples)
      for (std::size_t c = 0; c < sample.channels.size(); ++c)
        if (recording.columns.channels[c].unit == "degC") step.highest_degC = std::fmax(step.highest_degC, sample.channels[c]);
  }

  void tell(double share, const std::string& doing) const {
    if (hooks_.progress) hooks_.progress(share, doing);
  }

  // Diagnoses everything, and plans what comes next or ends.
  void decide() {
    Step& last = state_.steps.back();
    look_what_is_asked();
    std::vector<sim::Recording> recordings;
    for (Step& step : state_.steps) {
      const bool is_new = step.origin == "given" && step.duration_s == 0.0;
      if (!step.status || (!step.used && !is_new)) continue;
      sim::Recording recording = limb_.read(step.name);
      if (is_new) take(step, recording);
      // The loop's own recordings have no reading in their last row, and perhaps none in their first (hil/timed_recording.h).
      if (step.used) recordings.push_back(std::move(recording));
    }
    if (recordings.empty()) {  // what there is was cut short
      babble();
      return save();
    }
    if (hooks_.computing) hooks_.computing(true);
    diagnose::DiagnosisSettings diagnosis_settings = settings_.diagnosis;
    diagnosis_settings.search.seed = static_cast<std::uint64_t>(settings_.seed);
    diagnosis_settings.search.threads = settings_.threads;
    diagnosis_settings.search.fit.should_stop = hooks_.should_stop;
    const std::string of = std::to_string(recordings.size()) + (recordings.size() == 1 ? " recording" : " recordings");
    diagnosis_settings.search.progress = [&](double share, const std::string& doing) { tell(0.75 * share, of + ": " + doing); };
    const diagnose::Diagnosis diagnosis = diagnose::diagnose(nominal_, recordings, {}, diagnosis_settings);
    tell(0.8, of + ": what may be there though it is not named");
    const Belief belief = belief_of(diagnosis, diagnosis_settings);
    last.after = believed(belief, diagnosis);
    const double left_s = this->left_s();
    const bool an_answer =
        belief.first().kind == Kind::nothing || (belief.first().kind == Kind::named && belief.verdict != diagnose::Verdict::unexplained);
    const bool enough = an_answer && belief.first().probability >= asked_.probability;
    // That nothing is missing is no answer while experiments may yet show what no recording could.
    if (enough && (belief.first().kind != Kind::nothing || std::ranges::none_of(belief.all, Belief::may_yet_show))) {
      if (hooks_.computing) hooks_.computing(false);
      resolve(belief);
      return told();
    }
    const auto designed_within = [&](const Question& question, double longest_s) {
      DesignSettings design_settings;
      design_settings.longest_drive_s = std::min(settings_.longest_s, longest_s - 10.0);
      design_settings.longest_s = longest_s;
      design_settings.least_share = settings_.least_share;
      design_settings.threads = settings_.threads;
      design_settings.should_stop = hooks_.should_stop;
      design_settings.progress = [&](double share) { tell(0.9 + 0.1 * share, "simulating experiments"); };
      return design(question, design_settings);
    };
    const double any_s = settings_.longest_s + longest_cooling_s;  // if the budget did not end
    if (left_s < least_experiment_s) {
      if (enough) {
        resolve(belief);  // nothing is missing, or it would have ended above
        const Question question = question_of(diagnosis, belief, diagnosis_settings);
        ask_beside_nothing(question, designed_within(question, any_s));
      }
      if (hooks_.computing) hooks_.computing(false);
      if (enough) return told();
      state_.ending = Ending::budget;
      state_.ending_words = budget_words();
      return told();
    }
    if (settings_.use == Use::babbling) {
      if (hooks_.computing) hooks_.computing(false);
      told();
      babble_on();
      return save();
    }
    const Question question = question_of(diagnosis, belief, diagnosis_settings);
    if (settings_.use == Use::random) {
      told();
      draw(question, diagnosis);
      if (hooks_.computing) hooks_.computing(false);
      if (state_.next()) return save();
      state_.ending = Ending::budget;
      state_.ending_words = "No programme that was drawn by chance stays within the limits.";
      return save();
    }
    const Design designed = designed_within(question, left_s);
    const bool none_tells = !designed.tells || idle(state_, asked_) >= settings_.most_idle;
    if (enough && none_tells) {
      resolve(belief);
      ask_beside_nothing(question, left_s >= any_s ? designed : designed_within(question, any_s));
    }
    if (hooks_.computing) hooks_.computing(false);
    if (state_.ending) return told();
    if (none_tells && idle(state_, asked_) < settings_.most_idle && left_s < any_s && designed_within(question, any_s).tells) {
      state_.ending = Ending::budget;
      state_.ending_words =
          "The " + sim::shortest(std::round(left_s)) + " s that are left of the budget are too short for an experiment that would tell.";
      return told();
    }
    if (none_tells) {
      state_.ending = Ending::cannot_tell;
      state_.ending_words =
          !designed.best.possible ? "No experiment stays within the limits of temperature and time."
          : idle(state_, asked_) >= settings_.most_idle
              ? "The last " + std::to_string(settings_.most_idle) + " experiments told less than a tenth of what was expected of them."
              : "Of " + std::to_string(designed.tried) + " programmes of duty none is expected to tell the answers apart that are left.";
      ask_to_measure(belief, diagnosis);
      return told();
    }
    told();
    state_.steps.push_back(experiment(designed.best, designed.tried, diagnosis));
    if (settings_.use == Use::once) repeat();
    save();
  }

  // Programmes by chance, as many as the budget holds.
  void draw(const Question& question, const diagnose::Diagnosis& diagnosis) {
    std::uint64_t number = 0;
    while (left_s() >= least_experiment_s) {
      Expected expected;
      for (int k = 0; k < most_draws && !expected.possible; ++k) {
        if (stopping()) throw diagnose::Stopped{};
        const Shape shape = random_shape(question.alternatives.front().model.system(), std::min(settings_.longest_s, left_s() - 10.0),
                                         static_cast<std::uint64_t>(settings_.seed), number++);
        expected = expected_of(question, shape, left_s());
      }
      if (!expected.possible) return;
      expected.apart.clear();  // it is no answer to a question
      expected.from.clear();
      state_.steps.push_back(experiment(expected, 1, diagnosis));
    }
  }

  // The last one again, until the budget is planned; what does not fit whole is cut short.
  void repeat() {
    const Step first = state_.steps.back();
    while (left_s() >= least_experiment_s) {
      Step step = first;
      step.name = folder_name(state_.steps.size() + 1);
      sim::Scenario scenario = sim::parse_scenario(first.plan->scenario_yaml, step.name + "/scenario.yaml");
      scenario.seed = next_seed();
      const double cut_s = std::max(0.0, scenario.duration_s - std::floor(left_s()));
      scenario.duration_s -= cut_s;
      step.plan->duration_s -= cut_s;
      step.plan->cool_s = std::max(0.0, step.plan->cool_s - cut_s);
      step.plan->scenario_yaml = sim::to_yaml(scenario);
      state_.steps.push_back(std::move(step));
    }
  }

  void told() {
    save();
    if (hooks_.show) hooks_.show(state_);
  }

  Step experiment(const Expected& best, std::size_t tried, const diagnose::Diagnosis& diagnosis) const {
    Step step;
    const std::size_t number = state_.steps.size() + 1;
    step.name = folder_name(number);
    step.origin = "experiment";
    step.asked = asked_;
    Plan plan;
    plan.words = words_of(best.programme.shape, diagnosis.search.core.system());
    plan.family = text_of(best.programme.shape.family);
    plan.apart = best.apart;
    plan.from = best.from;
    plan.duration_s = best.programme.duration_s();
    plan.cool_s = best.programme.cool_s;
    plan.expected_bit = best.information_nat / std::log(2.0);
    plan.separation = best.separation;
    plan.highest_degC = best.highest_degC;
    plan.tried = tried;
    const std::string question = best.apart.empty() ? "What is there?" : "Is it " + best.apart + ", or " + best.from + "?";
    plan.scenario_yaml = sim::to_yaml(
        scenario_of(best.programme, nominal_, next_seed(),
                    {question + " " + plan.words + ", then " + sim::shortest(plan.cool_s) + " s to cool.",
                     settings_.use == Use::random ? "Drawn by chance by `sinew investigate`." : "Designed by `sinew investigate`."}));
    step.plan = std::move(plan);
    return step;
  }

  void measure_at(std::string_view place) {
    const std::string what = instrument_for(place);
    if (!what.empty() && !contains(state_.measure, what)) state_.measure.push_back(what);
  }
  void ask_to_measure(const Belief& belief, const diagnose::Diagnosis& diagnosis) {
    const plant::System& system = diagnosis.search.core.system();
    for (const Hypothesis& one : belief.all) {
      if (one.probability < 0.02) break;
      for (const plant::EffectId e : one.effects)
        if (e.index < system.effects().size()) measure_at(system.effects()[e].place);  // parts that are not alike are beyond
      if (one.kind == Kind::something_else) measure_at(diagnosis.located.place);
    }
  }
  void resolve(const Belief& belief) {
    state_.ending = Ending::resolved;
    state_.ending_words = "One answer has " + percent(belief.first().probability) + " (asked: " + percent(asked_.probability) + ").";
    if (diagnose::something_is_left(belief.verdict))
      state_.ending_words +=
          " Something is left that it does not explain: `sinew diagnose` on these recordings together says where, and what may be beside "
          "it.";
  }
  std::string budget_words() const {
    return "The budget is used: " + sim::shortest(std::round(state_.spent_s())) + " s of " + sim::shortest(asked_.budget_s) + " s.";
  }
  // That nothing is missing says nothing of what no duty can show.
  void ask_beside_nothing(const Question& question, const Design& designed) {
    if (!designed.best.possible) return;
    const plant::System& system = question.alternatives.front().model.system();
    std::string names;
    for (std::size_t j = 1; j < question.alternatives.size(); ++j) {
      if (designed.farthest[j] >= told_apart) continue;
      names += (names.empty() ? "" : " or ") + question.alternatives[j].key;
      measure_at(system.effects()[system.effect(question.alternatives[j].key)].place);
    }
    if (!names.empty()) state_.ending_words += " That is of what duty can show: whether there is " + names + " cannot be told by duty.";
  }

  Investigation& state_;
  const plant::Plant& nominal_;
  const Settings& settings_;
  Limb& limb_;
  const Hooks& hooks_;
  bool dry_;
  Asked asked_;
};

}  // namespace

std::string folder_name(std::size_t number) {
  char name[32];
  std::snprintf(name, sizeof name, "recording_%02zu", number);
  return name;
}

std::string_view text_of(Ending ending) {
  switch (ending) {
    case Ending::resolved:
      return "resolved";
    case Ending::cannot_tell:
      return "cannot_tell";
    case Ending::budget:
      return "budget";
    case Ending::stopped:
      return "stopped";
    case Ending::interrupted:
      return "interrupted";
  }
  return "";
}

std::string_view text_of(Use use) {
  switch (use) {
    case Use::designed:
      return "designed";
    case Use::babbling:
      return "babbling";
    case Use::random:
      return "random";
    case Use::once:
      return "once";
  }
  return "";
}

std::optional<Use> use_of(std::string_view text) {
  for (const Use use : {Use::designed, Use::babbling, Use::random, Use::once})
    if (text_of(use) == text) return use;
  return std::nullopt;
}

double told_bit(const Believed& before, const Believed& after) {
  double sum = 0.0;
  for (const Believed::Answer& now : after.answers) {
    const auto then = std::ranges::find(before.answers, now.key, &Believed::Answer::key);
    const double was = then == before.answers.end() ? 0.0 : then->probability;
    if (now.probability > 0.0) sum += now.probability * std::log2(now.probability / std::max(was, least_believed));
  }
  return std::max(0.0, sum);
}

int idle(const Investigation& investigation, const Asked& asked) {
  int count = 0;
  const std::vector<Step>& steps = investigation.steps;
  for (std::size_t k = steps.size(); k-- > 1;) {
    const Step& step = steps[k];
    if (step.asked && *step.asked != asked) break;
    if (step.origin != "experiment" || !step.after || !steps[k - 1].after) break;
    if (step.status != "finished") continue;
    if (told_bit(*steps[k - 1].after, *step.after) > idle_share * step.plan->expected_bit) break;
    ++count;
  }
  return count;
}

Step* Investigation::next() {
  const auto next = std::find_if(steps.begin(), steps.end(), [](const Step& step) { return !step.status; });
  return next == steps.end() ? nullptr : &*next;
}

double Investigation::spent_s() const {
  double sum = 0.0;
  for (const Step& step : steps)
    if (step.origin != "given" && step.status) sum += step.duration_s;
  return sum;
}

Json to_json(const Investigation& investigation) {
  Json json;
  json["spent_s"] = investigation.spent_s();
  if (investigation.ending) json["ending"] = {{"why", text_of(*investigation.ending)}, {"words", investigation.ending_words}};
  if (!investigation.measure.empty()) json["measure_instead"] = investigation.measure;
  json["recordings"] = Json::array();
  for (const Step& step : investigation.steps) {
    Json one{{"name", step.name}, {"origin", step.origin}};
    if (step.plan) {
      const Plan& plan = *step.plan;
      one["plan"] = {{"words", plan.words},
                     {"family", plan.family},
                     {"apart", plan.apart},
                     {"from", plan.from},
                     {"duration_s", plan.duration_s},
                     {"cool_s", plan.cool_s},
                     {"expected_bit", plan.expected_bit},
                     {"separation", plan.separation},
                     {"highest_degC", plan.highest_degC},
                     {"programmes_tried", plan.tried},
                     {"scenario_yaml", plan.scenario_yaml}};
    }
    if (step.status)
      one["recorded"] = {{"status", *step.status},
                         {"why", step.why},
                         {"duration_s", step.duration_s},
                         {"highest_degC", step.highest_degC},
                         {"commands_lowered_by_host", step.lowered},
                         {"used", step.used}};
    if (step.after) {
      const Believed& after = *step.after;
      Json believed{{"verdict", after.verdict}, {"entropy_bit", after.entropy_bit}, {"answers", Json::array()}};
      for (const Believed::Answer& answer : after.answers)
        believed["answers"].push_back({{"key", answer.key}, {"kind", answer.kind}, {"probability", answer.probability}});
      believed["could_not_be_seen"] = after.unseen;
      believed["parameters"] = Json::object();
      for (const auto& [name, value] : after.values) believed["parameters"][name] = value;
      one["believed"] = std::move(believed);
    }
    if (step.asked) one["asked"] = {{"probability", step.asked->probability}, {"budget_s", step.asked->budget_s}};
    json["recordings"].push_back(std::move(one));
  }
  return json;
}

Investigation from_json(const Json& json) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto number = [&](const Json& value) { return value.is_null() ? nan : value.get<double>(); };
  Investigation result;
  if (json.contains("ending")) {
    const std::string why = json["ending"].at("why");
    for (const Ending ending : {Ending::resolved, Ending::cannot_tell, Ending::budget, Ending::stopped, Ending::interrupted})
      if (text_of(ending) == why) result.ending = ending;
    result.ending_words = json["ending"].at("words");
  }
  if (json.contains("measure_instead")) result.measure = json["measure_instead"].get<std::vector<std::string>>();
  for (const Json& one : json.at("recordings")) {
    Step step;
    step.name = one.at("name");
    step.origin = one.at("origin");
    if (one.contains("plan")) {
      const Json& p = one["plan"];
      step.plan = Plan{.words = p.at("words"),
                       .family = p.at("family"),
                       .apart = p.at("apart"),
                       .from = p.at("from"),
                       .duration_s = p.at("duration_s"),
                       .cool_s = p.at("cool_s"),
                       .expected_bit = p.at("expected_bit"),
                       .separation = p.at("separation"),
                       .highest_degC = number(p.at("highest_degC")),
                       .tried = p.at("programmes_tried"),
                       .scenario_yaml = p.at("scenario_yaml")};
    }
    if (one.contains("recorded")) {
      const Json& r = one["recorded"];
      step.status = r.at("status").get<std::string>();
      step.why = r.at("why");
      step.duration_s = r.at("duration_s");
      step.highest_degC = number(r.at("highest_degC"));
      step.lowered = r.at("commands_lowered_by_host");
      step.used = r.at("used");
    }
    if (one.contains("believed")) {
      const Json& b = one["believed"];
      Believed after;
      after.verdict = b.at("verdict");
      after.entropy_bit = b.at("entropy_bit");
      for (const Json& answer : b.at("answers"))
        after.answers.push_back({answer.at("key"), answer.at("kind"), answer.at("probability").get<double>()});
      after.unseen = b.at("could_not_be_seen").get<std::vector<std::string>>();
      for (const auto& [name, value] : b.at("parameters").items()) after.values.emplace_back(name, value.get<double>());
      step.after = std::move(after);
    }
    if (one.contains("asked")) step.asked = Asked{one["asked"].at("probability"), one["asked"].at("budget_s")};
    result.steps.push_back(std::move(step));
  }
  return result;
}

void investigate(Investigation& investigation, const plant::Plant& nominal, const Settings& settings, Limb& limb, const Hooks& hooks,
                 bool dry) {
  Investigator(investigation, nominal, settings, limb, hooks, dry).run();
}

}  // namespace sinew::investigate
