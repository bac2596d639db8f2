// SPDX-License-Identifier: Apache-2.0
// sinew investigate: asks the limb, or its firmware in the emulator, until it knows what the plant leaves out.
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "apps/app.h"
#include "apps/comparison_page.h"
#include "apps/diagnose.h"
#include "apps/ends_soon.h"
#include "apps/investigation_page.h"
#include "apps/limb_link.h"
#include "apps/live_page.h"
#include "apps/outputs.h"
#include "apps/terminal.h"
#include "diagnose/calibrate.h"
#include "hil/limb_parts.h"
#include "hil/lock_step_link.h"
#include "hil/port.h"
#include "hil/replay.h"
#include "hil/wire_log.h"
#include "plant/contains.h"
#include "prove/generator.h"
#include "report/console.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view state_file = "investigation.json";
constexpr std::string_view emulated_limb_file = "emulated_limb.json";  // as a session left it
constexpr int state_format = 3;
// Between two sessions on an emulated limb: for a diagnosis, and for coils that babbling left hot.
constexpr double emulated_pause_s = 60.0;

struct InvestigateArguments {
  std::string plant, port, out, budget = "30min", effect, use = "designed";
  std::vector<std::string> training, without, faults;
  double probability = 0.9, first_s = 120.0, longest_s = 160.0, strength = 1.0;
  std::optional<int> page;
  std::int64_t seed = 1, limb_seed = 1;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool emulate = false, dry = false, ask = false, clear_trip = false, replay = false, overwrite = false;
};

// "30min", "1800s", "0.5h".
double seconds_of(const std::string& text) {
  std::size_t end = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  const std::string unit = text.substr(end);
  const double factor = unit == "s" ? 1.0 : unit == "min" ? 60.0 : unit == "h" ? 3600.0 : 0.0;
  if (end == 0 || factor == 0.0 || !std::isfinite(value) || value * factor < 60.0 || value * factor > 86400.0)
    throw sim::InputError({.key = "--budget", .value = text, .advice = "must be a time of 1 min to 24 h: 30min, 900s, 1.5h"});
  return value * factor;
}

std::string concealed_text(const InvestigateArguments& arguments) {
  prove::Settings how;
  how.strength = arguments.strength;
  how.training_s = how.heldout_s = arguments.first_s;  // what begins within a recording does so within the first one
  const prove::ConcealedLimb limb =
      prove::conceal(prove::kind_of_name(arguments.effect), static_cast<std::uint64_t>(arguments.limb_seed), how);
  Json truth{{"note", "What is concealed in the emulated limb. No computation reads this file."},
             {"kind", arguments.effect},
             {"seed", arguments.limb_seed},
             {"strength", arguments.strength},
             {"effects", Json::array()}};
  for (const prove::TruthEffect& effect : limb.effects)
    truth["effects"].push_back({{"name", effect.name},
                                {"form", effect.form},
                                {"place", effect.place},
                                {"in_catalogue", effect.in_catalogue},
                                {"parameters", effect.parameters},
                                {"words", effect.words}});
  truth["core"] = limb.core_parameters;
  return truth.dump(2) + "\n";
}

// What decides the course: a later call must be given the same.
Json identity_of(const InvestigateArguments& arguments, const std::string& plant_yaml) {
  Json json{{"plant_sha256", sim::sha256(plant_yaml)},
            {"limb", arguments.emulate ? "emulated" : "port"},
            {"seed", arguments.seed},
            {"first_s", arguments.first_s},
            {"longest_s", arguments.longest_s},
            {"without", arguments.without},
            {"given", Json::array()}};
  if (arguments.use != "designed") json["use"] = arguments.use;
  // By a checksum: what a later call reads does not say what is concealed.
  if (!arguments.effect.empty()) json["concealed_sha256"] = sim::sha256(concealed_text(arguments));
  for (const std::string& path : arguments.training) json["given"].push_back(sim::sha256(sim::read_file(path)));
  return json;
}

// What is believed, as bars, and what is going on: on standard error, in place where that is a terminal. The page, if there is one, gets
// sessions, lines and beliefs.
class Board {
 public:
  explicit Board(LivePage* page) : in_place_(may_move_cursor()), page_(page) {}
  ~Board() { settle(); }
  void say(const std::string& text) {
    const std::lock_guard lock(mutex_);
    if (page_) page_->say(text);
    erase();
    std::fprintf(stderr, "%s\n", report::wrap(text).c_str());
    draw();
  }
  void believe(const investigate::Believed& believed) {
    const std::lock_guard lock(mutex_);
    erase();
    bars_.clear();
    constexpr int width = 40;
    std::size_t shown = 0;
    std::string line_of_page;
    for (const auto& answer : believed.answers) {
      if (answer.probability < 0.01 || ++shown > 8) break;
      std::string bar;
      for (int k = 0; k < static_cast<int>(std::lround(width * answer.probability)); ++k) bar += "█";
      char line[128];
      std::snprintf(line, sizeof line, "  %-34.34s %5.1f %%  ", answer.key.c_str(), 100.0 * answer.probability);
      bars_.push_back(line + bar);
      std::snprintf(line, sizeof line, "%s%.60s %.1f %%", line_of_page.empty() ? "Believed: " : ", ", answer.key.c_str(),
                    100.0 * answer.probability);
      line_of_page += line;
    }
    if (page_ && !line_of_page.empty()) page_->say(line_of_page);
    if (!in_place_) {
      for (const std::string& bar : bars_) std::fprintf(stderr, "%s\n", bar.c_str());
      bars_.clear();
    }
    draw();
  }
  void session(const std::string& name, double duration_s) {
    const std::lock_guard lock(mutex_);
    if (page_) page_->begin(name, duration_s);
  }
  void sample(const hil::SessionView& view) {
    const std::lock_guard lock(mutex_);
    if (page_) page_->show(view, std::nullopt);
  }
  void now(const std::string& line) {
    const std::lock_guard lock(mutex_);
    if (!in_place_) return;
    const auto time = std::chrono::steady_clock::now();
    if (time - shown_ < std::chrono::milliseconds(90)) return;
    shown_ = time;
    erase();
    now_ = line;
    draw();
  }
  void settle() {
    const std::lock_guard lock(mutex_);
    erase();
    now_.clear();
    draw();
    lines_ = 0;
    bars_.clear();
  }

 private:
  void erase() {
    for (; lines_ > 0; --lines_) std::fputs("\033[A\033[2K", stderr);
  }
  void draw() {
    if (!in_place_) return;
    for (const std::string& bar : bars_) std::fprintf(stderr, "%s\n", bar.c_str());
    lines_ = static_cast<int>(bars_.size());
    if (!now_.empty()) std::fprintf(stderr, "%.99s\n", now_.c_str()), ++lines_;
  }
  bool in_place_;
  LivePage* page_;
  std::mutex mutex_;
  std::vector<std::string> bars_;
  std::string now_;
  int lines_ = 0;
  std::chrono::steady_clock::time_point shown_{};
};

std::string line_of(const std::string& name, const hil::SessionView& view, double duration_s, const hil::LimbParts& parts) {
  char text[64];
  std::snprintf(text, sizeof text, "%s  %.1f s of %.0f s", name.c_str(), view.time_s, duration_s);
  std::string line = text;
  for (std::size_t j = 0; j < parts.coils.size(); ++j) {
    std::snprintf(text, sizeof text, "  %s %.1f degC %.2f", parts.coils[j].name.c_str(), view.measured.channels[parts.coils[j].shown.index],
                  view.duty_fraction[j]);
    line += text;
  }
  for (const plant::ChannelId angle : parts.angles) {
    std::snprintf(text, sizeof text, "  %.1f deg", view.measured.channels[angle.index]);
    line += text;
  }
  return line;
}

investigate::Step given_step(const std::string& name) {
  investigate::Step step;
  step.name = name;
  step.origin = "given";
  step.status = "given";
  return step;
}

// Of one recording, in a folder of its own; the one that says that all are there is last.
std::vector<std::string> files_of_recording() {
  return {"scenario.yaml", "recording.csv", "wire.bin", "timed.csv", std::string(emulated_limb_file), "session.json"};
}

// Without the emulated limb as its last session left it, none can go on.
void check_limb_is_there(const fs::path& out, const investigate::Investigation& state) {
  for (const investigate::Step& step : state.steps) {
    const fs::path file = out / step.name / emulated_limb_file;
    if (step.status && step.origin != "given" && !fs::exists(file))
      throw sim::InputError({.file = file.string(),
                             .advice = "is not there: the emulator was killed in that session, and its limb is gone with it.\n"
                                       "Begin another investigation, with another --out"});
  }
}

// Files of recordings in `out` that this investigation has not made: another one's, or a person's.
std::vector<std::string> files_of_others(const fs::path& out, const investigate::Investigation& state) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(out)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory() || !name.starts_with("recording_") ||
        std::any_of(state.steps.begin(), state.steps.end(), [&](const auto& step) { return step.status && step.name == name; }))
      continue;
    for (const std::string& file : files_of_recording())
      if (fs::exists(fs::symlink_status(entry.path() / file))) names.push_back((fs::path(name) / file).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::int64_t number_of(const std::string& name) { return std::stoll(name.substr(name.rfind('_') + 1)); }

// A session's, each reading at its time; or one that was given.
sim::Recording read_kept(const fs::path& folder, const plant::Plant& plant) {
  return sim::read_recording(folder / (fs::exists(folder / "session.json") ? "timed.csv" : "recording.csv"), plant.system());
}

// A session each, with the board at a port or in the emulator; files in a folder each.
class SessionLimb : public investigate::Limb {
 public:
  // `read`: what the command reads. `unwritten`: given recordings that are not in `out`, by the names of their steps.
  SessionLimb(const InvestigateArguments& arguments, const plant::Plant& plant, const fs::path& out, const InputPaths& read,
              std::map<std::string, sim::Recording> unwritten, Board& board)
      : arguments_(arguments), plant_(plant), out_(out), read_(read), unwritten_(std::move(unwritten)), board_(board) {}

  investigate::Recorded record(const sim::Scenario& scenario, const std::string& name) override {
    Outputs outputs(out_ / name, read_, arguments_.overwrite);
    outputs.claim(files_of_recording());
    std::map<std::string, std::string> files{{"scenario.yaml", sim::to_yaml(scenario)}};
    const fs::path scenario_file = outputs.stage("scenario.yaml", files["scenario.yaml"]);
    const hil::MonotonicClock clock;
    hil::SessionSettings settings;
    std::unique_ptr<hil::Link> link;
    std::string limb = arguments_.port;
    const fs::path left = outputs.scratch(std::string(emulated_limb_file));
    if (arguments_.emulate) {
      limb = emulated_limb;
      std::vector<std::string> command = emulator_command(scenario_file.string(), first_ ? arguments_.faults : std::vector<std::string>{});
      command.insert(command.end(), {"--seed", std::to_string(scenario.seed)});
      if (!arguments_.effect.empty())
        command.insert(command.end(),
                       {"--concealed", arguments_.effect, "--concealed-seed", std::to_string(arguments_.limb_seed), "--concealed-strength",
                        sim::shortest(arguments_.strength), "--concealed-recording", std::to_string(number_of(name))});
      command.insert(command.end(), {"--leaves", left.string(), "--pause", sim::shortest(emulated_pause_s)});
      settings.time_zero_s = 0.0;
      if (const auto before = session_before(name)) {
        command.insert(command.end(), {"--goes-on-from", (*before / emulated_limb_file).string()});
        settings.time_zero_s = ended_s(*before) + emulated_pause_s;
      }
      link = std::make_unique<hil::LockStepLink>(command);
    } else {
      link = std::make_unique<hil::Port>(arguments_.port, clock);
      settings.session = static_cast<std::uint16_t>(1 + (clock.now_us() / 1000 + getpid()) % 65000);
      settings.time_zero_s = seconds_since_1970();
      std::signal(SIGPIPE, SIG_IGN);
    }
    hil::LoggedLink logged(*link);
    const hil::LimbParts parts = hil::parts_of(scenario.plant);
    settings.clear_trip = arguments_.clear_trip && first_;
    first_ = false;
    settings.should_stop = [](std::int64_t) { return interrupted(); };
    settings.show = [&](const hil::SessionView& view) {
      board_.sample(view);
      board_.now(line_of(name, view, scenario.duration_s, parts));
    };
    settings.say = [&](const std::string& line) { board_.say(line); };
    board_.session(name, scenario.duration_s);
    hil::SessionResult result = hil::run_session(scenario, logged, settings);
    files["recording.csv"] = result.recording_csv;
    files["wire.bin"] = logged.log();
    link.reset();  // the emulator ends, and leaves its limb
    files["timed.csv"] = sim::to_csv(result.timed);
    if (fs::exists(left)) files[std::string(emulated_limb_file)] = sim::read_file(left);  // not where the emulator was killed
    for (const auto& [file, content] : files)
      if (file != "scenario.yaml") outputs.stage(file, content);
    outputs.stage("session.json", hil::session_json(scenario, settings, result, limb, files));
    outputs.commit();
    if (!result.brought_to_rest) board_.say("the device did not confirm that it is disarmed; its dead-man takes the duty away by itself");
    return {std::move(result.timed), result.status, result.why,
            Json::parse(result.report_json).value("commands_lowered_by_host", std::int64_t{0})};
  }
  sim::Recording read(const std::string& name) override {
    const auto kept = unwritten_.find(name);
    return kept == unwritten_.end() ? read_kept(out_ / name, plant_) : kept->second;
  }

 private:
  // When a session ended, on the emulated limb's clock. One that was stopped at once has no recording that could be read.
  double ended_s(const fs::path& folder) const {
    const Json session = Json::parse(sim::read_file(folder / "session.json"));
    if (session.at("ticks").get<std::int64_t>() < 2) return session.at("time_zero_s");
    const sim::Recording recording = read_kept(folder, plant_);
    return recording.begins_s().value() + recording.duration_s();
  }

  // The last session on the emulated limb before this one: its folder.
  std::optional<fs::path> session_before(const std::string& name) const {
    for (std::int64_t number = number_of(name) - 1; number > 0; --number) {
      const fs::path folder = out_ / investigate::folder_name(static_cast<std::size_t>(number));
      if (fs::exists(folder / "session.json")) return folder;
    }
    return std::nullopt;
  }

  const InvestigateArguments& arguments_;
  const plant::Plant& plant_;
  fs::path out_;
  InputPaths read_;
  std::map<std::string, sim::Recording> unwritten_;
  Board& board_;
  bool first_ = true;
};

// The sessions that are kept, again from their wires.
class KeptLimb : public investigate::Limb {
 public:
  KeptLimb(const plant::Plant& plant, const fs::path& out) : plant_(plant), out_(out) {}
  investigate::Recorded record(const sim::Scenario& scenario, const std::string& name) override {
    const fs::path folder = out_ / name;
    if (sim::read_file(folder / "scenario.yaml") != sim::to_yaml(scenario)) differs((folder / "scenario.yaml").string());
    const hil::Replayed replayed = hil::replay_session(folder);
    for (const auto& [file, content] : replayed.stored)
      if (replayed.files.at(file) != content) differs((folder / file).string());
    return {replayed.result.timed, replayed.result.status, replayed.result.why,
            Json::parse(replayed.result.report_json).value("commands_lowered_by_host", std::int64_t{0})};
  }
  sim::Recording read(const std::string& name) override { return read_kept(out_ / name, plant_); }
  void differs(const std::string& file) {
    if (!contains(different_, file)) different_.push_back(file);
  }
  const std::vector<std::string>& different() const { return different_; }

 private:
  const plant::Plant& plant_;
  fs::path out_;
  std::vector<std::string> different_;
};

// What is written beside the recordings, from the state alone.
std::map<std::string, std::string> reports_of(const investigate::Investigation& state, const plant::Plant& plant, const fs::path& out) {
  std::vector<sim::Recording> recordings;
  for (const investigate::Step& step : state.steps)
    if (step.status) recordings.push_back(step.duration_s > 0.0 ? read_kept(out / step.name, plant) : sim::Recording{});
  return {{"story.txt", investigate::to_text(investigate::story_of(state, plant.system()))},
          {"report.html", report::to_html(investigation_page(state, plant.system(), recordings))}};
}

std::string state_text(const Json& identity, const investigate::Settings& settings, const investigate::Investigation& state) {
  Json json{{"format", state_format},
            {"identity", identity},
            {"probability", settings.asked.probability},
            {"budget_s", settings.asked.budget_s}};
  json.update(investigate::to_json(state));
  return json.dump(2) + "\n";
}

Json read_state(const fs::path& file) {
  try {
    Json json = Json::parse(sim::read_file(file));
    if (json.at("format") != state_format)
      throw sim::InputError({.file = file.string(), .key = "format", .advice = "is that of another version"});
    static_cast<void>(json.at("identity"));
    return json;
  } catch (const nlohmann::json::exception& e) {
    throw sim::InputError({.file = file.string(), .advice = std::string("is no state of an investigation: ") + e.what()});
  }
}

investigate::Settings settings_of(const InvestigateArguments& arguments, const plant::Plant& plant) {
  investigate::Settings settings;
  settings.asked = {.probability = arguments.probability, .budget_s = seconds_of(arguments.budget)};
  settings.first_s = arguments.first_s;
  settings.longest_s = arguments.longest_s;
  settings.seed = arguments.seed;
  settings.threads = arguments.threads;
  settings.use = *investigate::use_of(arguments.use);
  settings.diagnosis.search.without = chosen_effects(arguments.without, plant.system());
  return settings;
}

int print_end(const investigate::Investigation& state, const plant::Plant& plant, const fs::path& out) {
  const investigate::Story story = investigate::story_of(state, plant.system());
  for (const investigate::Chapter& chapter : story.chapters) {
    std::printf("%s\n", chapter.heading.c_str());
    for (const std::string& paragraph : chapter.paragraphs)
      std::printf("%s\n", report::wrap(paragraph, report::terminal_columns, 2).c_str());
  }
  std::printf("\n%s\n", report::wrap(story.end).c_str());
  for (const std::string& one : story.next) std::printf("%s\n", report::wrap(one).c_str());
  std::printf("\nreport: %s\n", (out / "report.html").string().c_str());
  if (state.ending == investigate::Ending::stopped) return interrupted_exit_code;
  return state.ending == investigate::Ending::interrupted ? 1 : 0;
}

int replay_investigation(const fs::path& out, int threads) {
  const Json stored = read_state(out / state_file);
  const plant::Plant plant = sim::read_plant_file(out / "plant.yaml");
  InvestigateArguments arguments;
  const Json& identity = stored["identity"];
  try {
    arguments.probability = stored.at("probability");
    arguments.budget = sim::shortest(stored.at("budget_s").get<double>()) + "s";
    arguments.first_s = identity.at("first_s");
    arguments.longest_s = identity.at("longest_s");
    arguments.seed = identity.at("seed");
    arguments.without = identity.at("without").get<std::vector<std::string>>();
    arguments.emulate = identity.at("limb") == "emulated";
    arguments.use = identity.value("use", arguments.use);
    if (!investigate::use_of(arguments.use))
      throw sim::InputError({.file = (out / state_file).string(), .key = "use", .value = arguments.use, .advice = "is none"});
    arguments.training.resize(identity.at("given").size());
  } catch (const nlohmann::json::exception& e) {
    throw sim::InputError({.file = (out / state_file).string(), .advice = e.what()});
  }
  arguments.threads = threads;
  investigate::Settings settings = settings_of(arguments, plant);
  const investigate::Investigation then = investigate::from_json(stored);
  for (const investigate::Step& step : then.steps)
    if (step.asked) settings.asked_then[step.name] = *step.asked;
  investigate::Investigation now;
  for (const investigate::Step& step : then.steps)
    if (step.origin == "given") now.steps.push_back(given_step(step.name));
  KeptLimb limb(plant, out);
  investigate::Hooks hooks;
  Progress progress("replay");
  std::mutex one_at_a_time;
  hooks.progress = [&](double share, const std::string& doing) {
    const std::lock_guard lock(one_at_a_time);
    progress.show(share, std::to_string(now.steps.size()) + " of " + std::to_string(then.steps.size()) + ": " + doing);
  };
  hooks.should_stop = interrupted;
  // What is not recorded yet ends the replay: as then, a person stopped.
  hooks.confirm = [&](const investigate::Step& step) {
    return std::any_of(then.steps.begin(), then.steps.end(), [&](const auto& one) { return one.status && one.name == step.name; });
  };
  const auto recorded = [](const investigate::Investigation& one) {
    return std::count_if(one.steps.begin(), one.steps.end(), [](const investigate::Step& s) { return s.status.has_value(); });
  };
  for (auto before = recorded(now) - 1; recorded(now) > before && (recorded(now) < recorded(then) || !now.ending);) {
    before = recorded(now);
    investigate::investigate(now, plant, settings, limb, hooks, false);
  }
  now.ending = then.ending;  // by whom it was stopped is no result
  now.ending_words = then.ending_words;
  if (state_text(identity, settings, now) != sim::read_file(out / state_file)) limb.differs((out / state_file).string());
  for (const auto& [name, content] : reports_of(now, plant, out))
    if (sim::read_file(out / name) != content) limb.differs((out / name).string());
  if (limb.different().empty()) {
    std::printf("%zu recordings, their diagnoses and the experiments between them: the same bytes\n", now.steps.size());
    return 0;
  }
  for (const std::string& file : limb.different()) std::fprintf(stderr, "differs: %s\n", file.c_str());
  return 1;
}

// What a later call is given is what the investigation was begun with.
void check_same(const Json& begun_with, const Json& now, const fs::path& file) {
  static const std::map<std::string, std::string> options{{"plant_sha256", "--plant"},
                                                          {"limb", "--emulate, --port"},
                                                          {"seed", "--seed"},
                                                          {"first_s", "--first"},
                                                          {"longest_s", "--longest"},
                                                          {"without", "--without"},
                                                          {"given", "--train"},
                                                          {"use", "--use"},
                                                          {"concealed_sha256", "--effect, --limb-seed, --strength"}};
  std::set<std::string> keys;
  for (const Json* one : {&begun_with, &now})
    for (const auto& [key, value] : one->items()) keys.insert(key);
  for (const std::string& key : keys) {
    const Json then = begun_with.value(key, Json()), given = now.value(key, Json());
    if (then == given) continue;
    const bool says_little = key == "given" || key.ends_with("_sha256") || then.is_null() || given.is_null();
    throw sim::InputError({.file = file.string(),
                           .key = options.contains(key) ? options.at(key) : key,
                           .value = says_little ? "" : given.dump(),
                           .advice = (says_little ? "is not what this investigation was begun with" : "it was begun with " + then.dump()) +
                                     "\ngive what it was begun with, or another --out"});
  }
}

int investigate_command(InvestigateArguments arguments) {
  if (arguments.page && (arguments.replay || arguments.dry))
    throw sim::InputError({.key = "--page", .advice = "shows sessions, and --dry-run and --replay run none"});
  if (arguments.replay) return replay_investigation(arguments.out, arguments.threads);
  if (arguments.plant.empty()) throw sim::InputError({.key = "--plant", .advice = "is needed: the plant to begin from, in YAML"});
  if (arguments.emulate == !arguments.port.empty())
    throw sim::InputError({.key = "--port, --emulate", .advice = "one of the two: the limb at a port, or the firmware in the emulator"});
  if (!arguments.emulate && (!arguments.effect.empty() || !arguments.faults.empty()))
    throw sim::InputError(
        {.key = "--effect, --fault", .advice = "are for --emulate: nothing is concealed in a limb at a port, and it is not made to fail"});
  if (!arguments.emulate && arguments.use != "designed")
    throw sim::InputError({.key = "--use", .value = arguments.use, .advice = "is for --emulate: it is there for comparison"});
  const plant::Plant plant = sim::read_plant_file(arguments.plant);
  hil::parts_of(plant, arguments.plant);
  std::vector<std::string> all_effects;
  const investigate::Settings settings = settings_of(arguments, plant);
  if (arguments.training.empty() && settings.first_s > settings.asked.budget_s)
    throw sim::InputError({.key = "--first",
                           .value = sim::shortest(settings.first_s) + " s",
                           .advice = "is more than the budget, " + sim::shortest(settings.asked.budget_s) + " s"});
  if ((arguments.training.empty() || settings.use == investigate::Use::babbling) && plant.system().drives().empty())
    throw sim::InputError(
        {.file = arguments.plant,
         .advice = "shows no bend that babbling could follow\ngive a first recording with --train; experiments follow none"});
  if (!arguments.effect.empty()) check_concealed_kind("--effect", arguments.effect);
  if (arguments.emulate) emulator_command(arguments.plant, {});  // says so where it is not built
  check_given_once({{"--train", arguments.training}});
  std::vector<sim::Recording> given;
  std::size_t samples = 0;
  for (const std::string& path : arguments.training) {
    given.push_back(read_recording_of(path, plant));
    samples += given.back().samples.size();
    if (given.back().duration_s() < 20.0)
      throw sim::InputError(
          {.file = path, .key = "--train", .value = sim::shortest(given.back().duration_s()) + " s", .advice = "must last 20 s or more"});
  }
  if (!given.empty()) check_fitted_samples(samples, arguments.training.front(), "give fewer recordings, or the first part of them");

  const InputPaths read{.files = arguments.training, .yaml = {arguments.plant}};
  Outputs outputs(arguments.out, read, arguments.overwrite);
  const fs::path out = outputs.folder();
  const std::string plant_yaml = "# The plant that the investigation began from.\n" + sim::plant_file_text(plant);
  const Json identity = identity_of(arguments, plant_yaml);
  const bool goes_on = fs::exists(out / state_file);
  investigate::Investigation state;
  if (goes_on) {
    const Json stored = read_state(out / state_file);
    check_same(stored["identity"], identity, out / state_file);
    try {
      state = investigate::from_json(stored);
      const bool more = stored.at("budget_s") != settings.asked.budget_s || stored.at("probability") != settings.asked.probability;
      if (state.ending && more) {
        state.ending.reset();
        state.measure.clear();
      }
    } catch (const nlohmann::json::exception& e) {
      throw sim::InputError({.file = (out / state_file).string(), .advice = e.what()});
    }
  }
  if (arguments.emulate &&
      (!state.ending || state.ending == investigate::Ending::stopped || state.ending == investigate::Ending::interrupted))
    check_limb_is_there(out, state);
  outputs.claim({"plant.yaml", std::string(state_file), "story.txt", "report.html", "concealed.json"}, goes_on);
  outputs.claim(files_of_others(out, state));
  std::map<std::string, sim::Recording> unwritten;
  if (!goes_on)
    for (std::size_t k = 0; k < given.size(); ++k) {
      const std::string name = investigate::folder_name(k + 1);
      state.steps.push_back(given_step(name));
      unwritten.emplace(name, given[k]);
    }

  std::optional<LivePage> page;
  if (arguments.page)
    page.emplace(*arguments.page, plant, LivePage::Shows{.title = "Investigation of " + fs::path(arguments.plant).stem().string()});
  Board board(page ? &*page : nullptr);
  if (!goes_on && !arguments.dry) {
    outputs.stage("plant.yaml", plant_yaml);
    if (!arguments.effect.empty()) outputs.stage("concealed.json", concealed_text(arguments));
    for (const auto& [name, recording] : unwritten) {
      const std::string file = name + "/recording.csv";
      outputs.claim({file});
      outputs.stage(file, sim::to_csv(recording));
    }
    unwritten.clear();
    outputs.stage(std::string(state_file), state_text(identity, settings, state));
    outputs.commit();
  }

  SessionLimb limb(arguments, plant, out, read, std::move(unwritten), board);
  std::optional<EndsSoon> ends_soon;
  investigate::Hooks hooks;
  const auto save = [&](const investigate::Investigation& now) {
    if (arguments.dry) return;
    sim::write_file_whole(out / state_file, state_text(identity, settings, now));
  };
  hooks.save = save;
  hooks.should_stop = interrupted;
  hooks.show = [&](const investigate::Investigation& now) {
    const investigate::Step& last = now.steps.back();
    if (!last.after) return;
    board.say("after " + last.name + ": " + investigate::words_of(*last.after));
    board.believe(*last.after);
  };
  hooks.confirm = [&](const investigate::Step& step) {
    board.say("next, " + investigate::announcement_of(step));
    if (!arguments.ask) return true;
    board.settle();
    std::fputs("run it? [y/n] ", stderr);
    std::string answer;
    return static_cast<bool>(std::getline(std::cin, answer)) && (answer == "y" || answer == "yes");
  };
  hooks.progress = [&](double share, const std::string& doing) {
    char text[96];
    std::snprintf(text, sizeof text, "%3.0f %%  %.80s", 100.0 * share, doing.c_str());
    board.now(text);
  };
  hooks.computing = [&](bool begins) {
    if (begins)
      ends_soon.emplace(&outputs);
    else
      ends_soon.reset();
  };
  const auto finish = [&] {
    ends_soon.reset();
    board.settle();
    if (page) page->end("The investigation has ended. " + state.ending_words);
    if (arguments.dry) return;
    save(state);
    for (const auto& [name, content] : reports_of(state, plant, out)) sim::write_file_whole(out / name, content);
  };
  try {
    investigate::investigate(state, plant, settings, limb, hooks, arguments.dry);
  } catch (const hil::Refused& refused) {
    state.ending = investigate::Ending::interrupted;
    state.ending_words = std::string("The board was not armed: ") + refused.what();
  } catch (const hil::LinkLost& lost) {
    state.ending = investigate::Ending::interrupted;
    state.ending_words = std::string("The link was lost: ") + lost.what();
  } catch (const diagnose::Stopped&) {
    state.ending = investigate::Ending::stopped;
    state.ending_words = "A person stopped it during a diagnosis.";
  }
  finish();
  if (arguments.dry) {
    const investigate::Step* next = state.next();
    if (!next || state.ending)
      std::printf("%s\n", report::wrap(state.ending ? state.ending_words : "nothing to do").c_str());
    else
      std::printf("%s\n\n%s", report::wrap("would run " + investigate::announcement_of(*next)).c_str(), next->plan->scenario_yaml.c_str());
    return 0;
  }
  return print_end(state, plant, out);
}

}  // namespace

void add_investigate(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<InvestigateArguments>();
  CLI::App* command =
      program.add_subcommand("investigate", "Ask the limb, experiment by experiment, until it is known what its plant leaves out.");
  command->add_option("--plant", arguments->plant, "the plant to begin from, in YAML");
  command->add_option("--port", arguments->port, "serial port of the limb's board");
  command->add_flag("--emulate", arguments->emulate, "the firmware in the emulator instead, in lock step");
  command->add_option("--budget", arguments->budget, "of the limb's time, cooling included: 30min, 900s, 1h")->capture_default_str();
  command->add_option("--out", arguments->out, "folder for investigation.json, report.html, story.txt and a folder a recording")
      ->required();
  command->add_option("--train", arguments->training, "recordings of the limb to begin with, instead of babbling")->expected(1, 100);
  command->add_option("--first", arguments->first_s, "seconds of babbling to begin with")
      ->check(CLI::Range(30.0, 1800.0))
      ->capture_default_str();
  command->add_option("--longest", arguments->longest_s, "seconds that an experiment drives the limb at most")
      ->check(CLI::Range(30.0, 1800.0))
      ->capture_default_str();
  command->add_option("--probability", arguments->probability, "of one answer, at which it ends")
      ->check(CLI::Range(0.5, 0.999))
      ->capture_default_str();
  command->add_option("--without", arguments->without, "effects that may not be named")->delimiter(',')->expected(1, 1000);
  command->add_option("--seed", arguments->seed, "of the babbling, the emulated sensors' noise and the draws of the diagnosis")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--effect", arguments->effect,
                      "conceal this in the emulated limb: a kind of `sinew prove`'s generator; core: nothing");
  command->add_option("--limb-seed", arguments->limb_seed, "which limb of that kind")->check(CLI::NonNegativeNumber)->capture_default_str();
  command->add_option("--strength", arguments->strength, "of what is concealed")->check(CLI::Range(0.05, 4.0))->capture_default_str();
  command
      ->add_option(
          "--use", arguments->use,
          "of the limb's time: designed; or, for comparison, babbling, random (programmes by chance) or once (one design, repeated), "
          "each with one look at the end of the budget")
      ->check(CLI::IsMember({"designed", "babbling", "random", "once"}))
      ->capture_default_str();
  command->add_option("--fault", arguments->faults,
                      "makes the emulated board fail, in the first session of this call (sinew-emulator --help)");
  command->add_option("--threads", arguments->threads, "the result does not depend on it")->check(CLI::Range(1, 1024));
  command->add_flag("--dry-run", arguments->dry, "say what would be done next, and write nothing");
  command->add_flag("--ask", arguments->ask, "wait for a yes before each session");
  command->add_flag("--clear-trip", arguments->clear_trip, "clear a trip that the board remembers, in the first session");
  command->add_flag("--replay", arguments->replay, "make everything in --out again from its wires and recordings, and compare the bytes");
  add_page(*command, arguments->page);
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Given the same --out again, it goes on where it was stopped.\n"
      "Examples:\n"
      "  sinew investigate --plant plant/limbs/paper_limb_on_board.yaml --emulate --budget 30min --out results/asked\n"
      "  sinew investigate --plant plant/limbs/paper_limb_on_board.yaml --emulate --effect latent_heat --limb-seed 7 --out "
      "results/concealed\n"
      "  sinew investigate --plant mine.yaml --port /dev/serial/by-id/usb-1a86 --train first.csv --ask --out results/bench\n"
      "  sinew investigate --plant mine.yaml --port /dev/serial/by-id/usb-1a86 --page 8765 --out results/bench   # "
      "http://127.0.0.1:8765/\n"
      "  sinew investigate --replay --out results/mine");
  command->callback([arguments, &exit_code] { exit_code = investigate_command(*arguments); });
}

}  // namespace sinew::apps
