// SPDX-License-Identifier: Apache-2.0
// sinew hil: a scenario on the physical limb, or on its firmware in the emulator. sinew replay: a session again.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "apps/app.h"
#include "apps/handover.h"
#include "apps/limb_link.h"
#include "apps/live_page.h"
#include "apps/outputs.h"
#include "apps/terminal.h"
#include "apps/training.h"
#include "hil/limb_parts.h"
#include "hil/limits.h"
#include "hil/lock_step_link.h"
#include "hil/port.h"
#include "hil/replay.h"
#include "hil/session.h"
#include "hil/wire_log.h"
#include "model/predictor.h"
#include "model/weights_file.h"
#include "report/console.h"
#include "report/number.h"
#include "sim/input_error.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct HilArguments {
  std::string scenario, port, out, twin, predict;
  std::vector<std::string> faults;
  std::int64_t seed = -1;
  double corrupt_share = 0.0;
  std::optional<int> page;
  bool emulate = false, clear_trip = false, ignore_bend_sensor = false, allow_overruns = false, relay = false, dividers = false,
       measure_board = false, overwrite = false;
};

const char* difference_unit(const plant::ChannelInfo& channel) { return channel.kind == "temperature" ? "K" : "deg"; }

std::string words_of(const hil::Departure& one, const hil::SessionView& view, const plant::System& system) {
  const plant::ChannelInfo& channel = system.channels()[one.channel];
  char text[160];
  std::snprintf(text, sizeof text, "at %.1f s: %s has left the twin by more than noise since %.1f s (now %+.2f %s)", one.said_s,
                channel.short_name.c_str(), one.onset_s, (*view.residual)[one.channel.index], difference_unit(channel));
  return text;
}

// The lines of a session: in a terminal they update in place, otherwise one goes out now and then.
class View {
 public:
  View(const plant::Plant& limb, double duration_s, double line_every_s)
      : system_(limb.shared_system()),
        parts_(hil::parts_of(limb)),
        in_place_(may_move_cursor()),
        duration_s_(duration_s),
        line_every_s_(line_every_s) {}
  ~View() { settle(); }

  void say(const std::string& line) {
    settle();
    std::fprintf(stderr, "%s\n", line.c_str());
  }

  void show(const hil::SessionView& v, std::optional<double> predicted_deg) {
    for (const hil::Departure& one : v.departures) say(words_of(one, v, *system_));
    if (in_place_) {
      // Ten a second at most: a terminal is slower than lock step.
      const auto now = std::chrono::steady_clock::now();
      if (now - shown_ < std::chrono::milliseconds(90) && v.time_s < duration_s_) return;
      shown_ = now;
      erase();
      std::fprintf(stderr, "%7.1f s of %.0f s   %s%s\n", v.time_s, duration_s_, state_of(v), v.lowered ? ", duty lowered by the host" : "");
      for (std::size_t j = 0; j < parts_.coils.size(); ++j)
        std::fprintf(stderr, "  %s  %6.2f degC  duty %.3f  predicted %6.1f degC%s\n", parts_.coils[j].name.c_str(),
                     v.measured.channels[parts_.coils[j].shown.index], v.duty_fraction[j], v.predicted_degC[j],
                     residual(v, parts_.coils[j].shown).c_str());
      for (const plant::ChannelId angle : parts_.angles)
        std::fprintf(stderr, "  %s %7.2f deg%s%s\n", info(angle).words.c_str(), v.measured.channels[angle.index],
                     residual(v, angle).c_str(), angle == parts_.angles.front() ? off_prediction(v, predicted_deg).c_str() : "");
      lines_ = 1 + static_cast<int>(parts_.coils.size() + parts_.angles.size());
    } else if (v.time_s + 1e-9 >= next_line_s_) {
      next_line_s_ += line_every_s_;
      std::fprintf(stderr, "%8.1f s", v.time_s);
      for (std::size_t j = 0; j < parts_.coils.size(); ++j)
        std::fprintf(stderr, "  %s %6.2f degC %.3f", parts_.coils[j].name.c_str(), v.measured.channels[parts_.coils[j].shown.index],
                     v.duty_fraction[j]);
      for (const plant::ChannelId angle : parts_.angles) std::fprintf(stderr, "  %7.2f deg", v.measured.channels[angle.index]);
      std::fprintf(stderr, "  %s%s", state_of(v), v.lowered ? " lowered" : "");
      for (const plant::ChannelId c : system_->channels().ids()) std::fprintf(stderr, "%s", residual(v, c).c_str());
      std::fprintf(stderr, "%s\n", off_prediction(v, predicted_deg).c_str());
    }
  }

 private:
  static const char* state_of(const hil::SessionView& v) {
    return v.state == DEVICE_ARMED ? "armed" : v.state == DEVICE_TRIPPED ? "TRIPPED" : "disarmed";
  }
  const plant::ChannelInfo& info(plant::ChannelId c) const { return system_->channels()[c]; }
  std::string residual(const hil::SessionView& v, plant::ChannelId channel) const {
    if (!v.residual) return "";
    char text[48];
    std::snprintf(text, sizeof text, "  %s%+.2f %s", "off the twin ", (*v.residual)[channel.index], difference_unit(info(channel)));
    return text;
  }
  std::string off_prediction(const hil::SessionView& v, std::optional<double> predicted_deg) const {
    if (!predicted_deg || parts_.angles.empty()) return "";
    char text[48];
    std::snprintf(text, sizeof text, "  off the prediction %+.2f deg", v.measured.channels[parts_.angles.front().index] - *predicted_deg);
    return text;
  }
  void erase() {
    for (; lines_ > 0; --lines_) std::fputs("\033[A\033[2K", stderr);
  }
  void settle() { lines_ = 0; }
  std::shared_ptr<const plant::System> system_;
  hil::LimbParts parts_;
  bool in_place_;
  double duration_s_, line_every_s_, next_line_s_ = 0.0;
  int lines_ = 0;
  std::chrono::steady_clock::time_point shown_{};
};

// Draws in a thread of ordinary priority, for a terminal may take its time: the loop hands over, and what finds no room is not drawn.
class ViewApart {
 public:
  explicit ViewApart(View& view) : view_(view), thread_([this] { draw(); }) {}
  ~ViewApart() {
    ended_.store(true, std::memory_order_release);
    thread_.join();
  }
  void show(const hil::SessionView& now, std::optional<double> predicted_deg) {
    slots_.put([&](Slot& slot) {
      slot.line.clear();
      slot.view = now;
      slot.predicted_deg = predicted_deg;
    });
  }
  void say(const std::string& line) {
    slots_.put([&](Slot& slot) { slot.line = line; });
  }

 private:
  struct Slot {
    std::string line;  // not empty: this, and not the view
    hil::SessionView view;
    std::optional<double> predicted_deg;
  };
  void draw() {
    give_priority_back();
    for (;;) {
      const bool last = ended_.load(std::memory_order_acquire);
      slots_.take([this](const Slot& slot) {
        if (slot.line.empty())
          view_.show(slot.view, slot.predicted_deg);
        else
          view_.say(slot.line);
      });
      if (last) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  View& view_;
  Handover<Slot> slots_{1024};
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

// A predictor beside the session, open loop from the first value that is measured. It sees what its task sees, and holds what is
// missing. Says when the session leaves what it was trained on.
class Companion {
 public:
  Companion(std::unique_ptr<model::Predictor> predictor, const plant::Plant& plant, double duration_s)
      : places_(model::places_in(sim::columns_of(plant.system()), predictor->about().task, "--predict")),
        predictor_(std::move(predictor)),
        v_(static_cast<Eigen::Index>(places_.features.size())) {
    v_.setConstant(std::nan(""));
    const model::AboutPredictor& about = predictor_->about();
    csv_ = "# open loop from the first measured value, beside the session\ntime_s," + about.task.predicted.name + "," +
           predicted_name(about.task.predicted, "_predicted");
    const auto samples = static_cast<model::Index>(duration_s / model::period_s) + 2;
    if (const auto* steps = about.intervals ? about.intervals->steps_for(model::Beginning::at_first) : nullptr) {
      trust_.interval = Trust::Interval{.promised_share = model::promised_share(*steps),
                                        .open_loop = model::half_widths(*steps, false, samples),
                                        .one_step = model::half_widths(*steps, true, samples)};
      csv_ += "," + predicted_name(about.task.predicted, "_lowest") + "," + predicted_name(about.task.predicted, "_highest");
    }
    if (about.region) {
      watch_.emplace(*about.region);
      trust_.departures.emplace(*about.region);
      trust_.departures->is_outside.reserve(static_cast<std::size_t>(samples));
      csv_ += ",outside";
    }
    csv_ += '\n';
  }
  // What is predicted at this tick; nothing before it and all else that the task needs was measured once. `say` is told once of a session
  // that leaves what was trained on.
  template <class Say>
  std::optional<double> at(const hil::SessionView& view, Say&& say) {
    for (std::size_t c = 0; c < places_.features.size(); ++c) {
      const auto& place = places_.features[c];
      const double value = place.measured ? view.measured.channels[place.index] : view.duty_fraction.at(place.index);
      if (!std::isnan(value)) v_(static_cast<Eigen::Index>(c)) = value;
    }
    const double measured = view.measured.channels[places_.predicted];
    bool outside = false;
    if (!predicted_) {
      if (std::isnan(measured) || v_.hasNaN()) return std::nullopt;
      predictor_->begin({"session", view.time_s, v_, model::Vector<double>::Constant(1, measured)});
      predicted_ = measured;
      first_s_ = view.time_s;
      if (watch_) watch_->begin(v_);
    } else {
      predicted_ = predictor_->step(v_);
      ++steps_;
      if (watch_) {
        const std::optional<model::OutsidePoint> found = watch_->outside(v_, *predicted_);
        outside = found.has_value();
        trust_.departures->add(steps_, found);
        if (outside && trust_.departures->outside == 1) {
          const model::AboutPredictor& about = predictor_->about();
          say("at " + report::fixed(view.time_s, 1) +
              " s: outside of what the predictor was trained on: " + model::words_of(*found, *about.region, about.task));
        }
      }
    }
    put(view.time_s);
    put(measured);
    put(*predicted_);
    if (trust_.interval) {
      const double half_width = trust_.interval->open_loop(std::min(steps_, trust_.interval->open_loop.size() - 1));
      put(*predicted_ - half_width);
      put(*predicted_ + half_width);
      if (steps_ > 0 && !std::isnan(measured)) inside_ += std::abs(measured - *predicted_) <= half_width;
    }
    if (steps_ > 0 && !std::isnan(measured)) {
      ++counted_;
      squares_ += (measured - *predicted_) * (measured - *predicted_);
    }
    if (watch_) put(outside ? 1.0 : 0.0);
    csv_ += '\n';
    return predicted_;
  }
  const std::string& csv() const { return csv_; }
  // How far it was to be trusted: keys as in the JSON of `rollout`; and a sentence.
  std::string json() const {
    nlohmann::ordered_json json{{"method", predictor_->about().kind},
                                {"samples", steps_},
                                {key_in_unit("rollout_rmse", predictor_->about().task.predicted), rmse()},
                                {"interval", nullptr},
                                {"outside", nullptr}};
    if (trust_.interval)
      json["interval"] = {{"share", model::interval_share},
                          {"promised_share", trust_.interval->promised_share},
                          {"inside_open_loop", inside_ / counted_}};
    if (trust_.departures) json["outside"] = outside_json(*trust_.departures, predictor_->about(), first_s_);
    return json.dump(1) + "\n";
  }
  std::string sentence() const {
    const model::AboutPredictor& about = predictor_->about();
    if (counted_ == 0.0) return "Nothing was measured that it could be compared with. " + departure_sentence(trust_, about, first_s_);
    std::string text = "It is " + report::significant(rmse(), 3) + unit_words(about.task.predicted) + " off (root mean square)";
    if (trust_.interval)
      text += ", and " + report::significant(100.0 * inside_ / counted_, 3) +
              " % of the samples lie inside the interval, which was made for " +
              report::significant(100.0 * trust_.interval->promised_share, 2) + " %. ";
    else
      text += ". " + interval_sentence(trust_, about) + " ";
    return text + departure_sentence(trust_, about, first_s_);
  }

 private:
  double rmse() const { return std::sqrt(squares_ / counted_); }
  void put(double value) {
    if (csv_.back() != '\n') csv_ += ',';
    if (!std::isnan(value)) sim::append_shortest(csv_, value);
  }
  // "angle_deg" -> "angle_predicted_deg".
  static std::string predicted_name(const sim::Column& column, const char* what) {
    std::string name = column.name;
    const std::size_t unit = column.unit.empty() ? name.size() : name.rfind("_" + column.unit);
    return name.insert(unit, what);
  }
  model::Places places_;
  std::unique_ptr<model::Predictor> predictor_;
  model::Vector<double> v_;
  std::optional<double> predicted_;
  std::string csv_;
  Trust trust_;  // its departures grow
  std::optional<model::RegionWatch> watch_;
  model::Index steps_ = 0;
  double first_s_ = 0.0, inside_ = 0.0, counted_ = 0.0, squares_ = 0.0;
};

// The first of results/session_001, _002, ... that is not there.
// Made here, so that no other session takes it meanwhile.
std::filesystem::path free_folder() {
  std::filesystem::create_directories("results");
  for (int k = 1;; ++k) {
    char name[32];
    std::snprintf(name, sizeof name, "session_%03d", k);
    std::filesystem::path folder = std::filesystem::path("results") / name;
    if (std::filesystem::create_directory(folder)) return folder;
  }
}

const std::vector<std::string> session_files{"recording.csv", "timed.csv",      "scenario.yaml",   "twin.yaml",
                                             "wire.bin",      "prediction.csv", "prediction.json", "session.json"};

void write_session(Outputs& outputs, const std::map<std::string, std::string>& files) {
  for (const auto& [name, content] : files)
    if (name != "session.json") outputs.stage(name, content);
  outputs.stage("session.json", files.at("session.json"));  // last: it says that all are there
  outputs.commit();
}

int hil_command(const HilArguments& arguments) {
  if (arguments.emulate == !arguments.port.empty())
    throw sim::InputError({.key = "--port, --emulate", .advice = "one of the two: the limb at a port, or the firmware in the emulator"});
  if (!arguments.emulate &&
      (!arguments.faults.empty() || arguments.corrupt_share > 0.0 || arguments.relay || arguments.dividers || arguments.measure_board))
    throw sim::InputError(
        {.key = "--fault, --corrupt, --relay, --dividers, --measure-board", .advice = "are for --emulate: the limb is not made to fail"});
  const InputPaths read{.files = {arguments.predict}, .yaml = {arguments.scenario, arguments.twin}};
  std::optional<Outputs> outputs;
  if (!arguments.out.empty()) {
    outputs.emplace(arguments.out, read, arguments.overwrite);
    outputs->claim(session_files);
  }
  sim::Scenario scenario = sim::read_scenario(arguments.scenario);
  if (arguments.seed >= 0) scenario.seed = arguments.seed;
  hil::parts_of(scenario.plant, arguments.scenario);  // an error names the file
  hil::check_period(scenario, arguments.scenario);
  hil::SessionSettings settings;
  std::map<std::string, std::string> files{{"scenario.yaml", sim::to_yaml(scenario)}};
  if (!arguments.twin.empty()) {
    settings.twin = sim::read_plant_file(arguments.twin);
    files["twin.yaml"] = "# The plant that ran beside the limb.\n" + sim::plant_file_text(*settings.twin);
  }
  std::optional<Companion> companion;
  if (!arguments.predict.empty()) {
    if (std::abs(scenario.sample_period_s - model::period_s) > 1e-12)
      throw sim::InputError({.file = arguments.scenario,
                             .key = "sample_period_s",
                             .value = sim::shortest(scenario.sample_period_s),
                             .advice = "must be 0.1 with --predict: the predictor works at 10 Hz"});
    companion.emplace(read_predictor_at(arguments.predict), scenario.plant, scenario.duration_s);
  }

  // Before anything is said to the board, and before the loop takes its priority: the page's thread has none.
  std::optional<LivePage> page;
  if (arguments.page)
    page.emplace(*arguments.page, scenario.plant,
                 LivePage::Shows{"Session: " + std::filesystem::path(arguments.scenario).stem().string(), settings.twin.has_value(),
                                 companion.has_value()});

  const hil::MonotonicClock clock;
  std::unique_ptr<hil::Link> link;
  std::unique_ptr<hil::TamperedLink> tampered;
  std::int64_t damaged = 0;
  std::string limb = arguments.port;
  if (arguments.emulate) {
    limb = emulated_limb;
    std::vector<std::string> command = emulator_command(arguments.scenario, arguments.faults);
    command.insert(command.end(), {"--seed", std::to_string(scenario.seed)});
    if (arguments.relay) command.push_back("--relay");
    if (arguments.dividers) command.push_back("--dividers");
    if (arguments.measure_board) command.push_back("--measure");
    link = std::make_unique<hil::LockStepLink>(command);
    if (arguments.corrupt_share > 0.0) {
      const auto seed = static_cast<std::uint64_t>(scenario.seed);
      tampered = std::make_unique<hil::TamperedLink>(*link, hil::corrupt_share(arguments.corrupt_share, seed, "link.down", damaged),
                                                     hil::corrupt_share(arguments.corrupt_share, seed, "link.up", damaged));
    }
  } else {
    stay_in_memory();
    settings.real_time_priority = take_real_time_priority();
    link = std::make_unique<hil::Port>(arguments.port, clock);  // its thread has the priority too
    settings.session = static_cast<std::uint16_t>(1 + (clock.now_us() / 1000 + getpid()) % 65000);
    settings.time_zero_s = seconds_since_1970();
    std::signal(SIGPIPE, SIG_IGN);  // whoever reads along may go away, a session must not end by that
  }
  hil::LoggedLink logged(tampered ? *tampered : *link);
  logged.reserve(static_cast<std::size_t>(std::min(scenario.duration_s, 3600.0)) * 8192u);
  View view(scenario.plant, scenario.duration_s, arguments.emulate ? 60.0 : 1.0);
  std::optional<ViewApart> apart;
  if (!arguments.emulate) apart.emplace(view);
  settings.clear_trip = arguments.clear_trip;
  settings.angle_faults_end = !arguments.ignore_bend_sensor;
  settings.allow_overruns = arguments.allow_overruns;
  settings.should_stop = [](std::int64_t) { return interrupted(); };
  settings.show = [&](const hil::SessionView& now) {
    const std::optional<double> predicted_deg = companion ? companion->at(now, settings.say) : std::nullopt;
    apart ? apart->show(now, predicted_deg) : view.show(now, predicted_deg);
    if (!page) return;
    for (const hil::Departure& one : now.departures) page->say(words_of(one, now, scenario.plant.system()));
    page->show(now, predicted_deg);
  };
  settings.say = [&](const std::string& line) {
    apart ? apart->say(line) : view.say(line);
    if (page) page->say(line);
  };
  if (page) page->begin(std::filesystem::path(arguments.scenario).filename().string(), scenario.duration_s);
  hil::SessionResult result;
  if (!outputs) {
    outputs.emplace(free_folder(), read, false, true);
    outputs->claim(session_files);
  }
  const std::filesystem::path& out = outputs->folder();
  const auto not_armed = [&](const std::string& why) {
    apart.reset();
    if (page) page->end("Not armed: " + why);
    std::fprintf(stderr, "not armed: %s\n", why.c_str());
    return 1;
  };
  try {
    result = hil::run_session(scenario, logged, settings);
  } catch (const hil::Refused& refused) {
    return not_armed(refused.what());
  } catch (const hil::LinkLost& lost) {
    return not_armed(std::string("the link was lost: ") + lost.what());
  }
  apart.reset();
  if (settings.real_time_priority) give_priority_back();
  if (page) page->end("The session has ended: " + std::string(hil::words(result.status)) + (result.why.empty() ? "" : ", " + result.why));
  files["recording.csv"] = result.recording_csv;
  files["timed.csv"] = sim::to_csv(result.timed);
  files["wire.bin"] = logged.log();
  files["session.json"] = hil::session_json(scenario, settings, result, limb, files);
  if (companion) {
    outputs->stage("prediction.csv", companion->csv());
    outputs->stage("prediction.json", companion->json());
  }
  write_session(*outputs, files);
  std::printf("%lld samples, %s\n", static_cast<long long>(result.ticks), std::string(hil::words(result.status)).c_str());
  if (arguments.corrupt_share > 0.0) std::printf("%lld frames were damaged on purpose\n", static_cast<long long>(damaged));
  std::printf("written: %s/{%s}\n", out.string().c_str(),
              [&] {
                std::string names;
                for (const auto& [name, content] : files) names += (names.empty() ? "" : ", ") + name;
                return names + (companion ? ", prediction.csv, prediction.json" : "");
              }()
                  .c_str());
  if (companion) std::printf("%s\n", report::wrap("The prediction: " + companion->sentence()).c_str());
  const bool finished = result.status == hil::SessionStatus::finished;
  if (finished && result.brought_to_rest) return 0;
  if (!finished) std::fprintf(stderr, "%s\n", result.why.c_str());
  if (!result.brought_to_rest)
    std::fprintf(stderr, "the device did not confirm that it is disarmed; its dead-man takes the duty away within %u ms\n",
                 static_cast<unsigned>(LIMIT_DEAD_MAN_ms));
  return result.status == hil::SessionStatus::stopped ? interrupted_exit_code : 1;
}

struct ReplayArguments {
  std::string folder, out;
  bool overwrite = false;
};

int replay_command(const ReplayArguments& arguments) {
  std::optional<Outputs> outputs;
  const InputPaths read{.files = {arguments.folder}};
  if (arguments.out.empty()) {
    finish_interrupted(read);
  } else {
    outputs.emplace(arguments.out, read, arguments.overwrite);
    outputs->claim(session_files);
  }
  hil::Replayed replayed;
  try {
    replayed = hil::replay_session(arguments.folder);
  } catch (const hil::ReplayDiffers& differs) {
    std::fprintf(stderr, "the replay takes another course: %s\n  was the session made by another version of this program?\n",
                 differs.what());
    return 1;
  }
  if (outputs) {
    for (const auto& [name, content] : replayed.files) outputs->claim({name});  // a session may have others than are usual
    write_session(*outputs, replayed.files);
  }
  bool same = true;
  for (const auto& [name, content] : replayed.files) {
    const bool equal = content == replayed.stored.at(name);
    if (!equal) std::printf("%s differs\n", name.c_str());
    same = same && equal;
  }
  std::printf("%lld samples, %s; %s\n", static_cast<long long>(replayed.result.ticks),
              std::string(hil::words(replayed.result.status)).c_str(), same ? "the same bytes" : "not the same bytes");
  return same ? 0 : 1;
}

}  // namespace

void add_hil(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<HilArguments>();
  CLI::App* command = program.add_subcommand("hil", "Run a scenario on the physical limb, or on its firmware in the emulator.");
  command->add_option("scenario", arguments->scenario, "scenario in YAML; its plant is what the host's supervisor predicts with")
      ->required();
  command->add_option("--port", arguments->port, "the limb's serial port, best /dev/serial/by-id/...");
  command->add_flag("--emulate", arguments->emulate, "the real firmware in the emulator, in lock step");
  command->add_option("--out", arguments->out,
                      "folder for recording.csv, timed.csv, session.json, wire.bin, scenario.yaml [results/session_NNN]");
  command->add_option("--seed", arguments->seed, "instead of the scenario's own")->check(CLI::NonNegativeNumber);
  command->add_option("--twin", arguments->twin, "plant in YAML that runs alongside; says when the limb leaves it");
  command->add_option("--predict", arguments->predict,
                      "weights.h5, or the folder of `train`: a predictor of any kind that runs alongside, open loop");
  command->add_flag("--clear-trip", arguments->clear_trip, "clear the trip that the device has latched, once its coils are cool");
  command->add_flag("--ignore-bend-sensor", arguments->ignore_bend_sensor,
                    "a bend sensor that is not believed (0 V, 5 V, stuck) does not end the session; its samples are missing then");
  command->add_flag("--allow-overruns", arguments->allow_overruns, "go on when a deadline is missed by a whole period");
  command->add_option("--fault", arguments->faults, "--emulate: what goes wrong, and when; `sinew-emulator --help` lists them");
  command->add_option("--corrupt", arguments->corrupt_share, "--emulate: share of the frames in which a bit is turned")
      ->check(CLI::Range(0.0, 1.0));
  command->add_flag("--relay", arguments->relay, "--emulate: a cut-off relay behind a charge pump on PD7");
  command->add_flag("--dividers", arguments->dividers, "--emulate: dividers that show the board the drains of its switches");
  command->add_flag("--measure-board", arguments->measure_board,
                    "--emulate: at the end, the stack that the board's program used, and its interrupts' longest times");
  add_page(*command, arguments->page);
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n  sinew hil scenarios/babble_bidirectional.yaml --port /dev/serial/by-id/usb-... --out results/today\n"
      "  sinew hil scenarios/babble_bidirectional.yaml --emulate --twin plant/limbs/paper_limb.yaml\n"
      "  sinew hil scenarios/babble_bidirectional.yaml --emulate --predict results/lstm4\n"
      "  sinew hil scenarios/babble_bidirectional.yaml --port /dev/serial/by-id/usb-... --page 8765   # http://127.0.0.1:8765/\n"
      "  sinew hil scenarios/step.yaml --emulate --fault sensor_open:A@3.0");
  command->callback([arguments, &exit_code] { exit_code = hil_command(*arguments); });
}

void add_replay(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command = program.add_subcommand("replay", "Play a session of `hil` again, without hardware, and compare the bytes.");
  command->add_option("folder", arguments->folder, "the session's folder")->required();
  command->add_option("--out", arguments->out, "folder for what is made now");
  add_overwrite(*command, arguments->overwrite);
  command->footer("Example:\n  sinew replay results/session_001");
  command->callback([arguments, &exit_code] { exit_code = replay_command(*arguments); });
}

}  // namespace sinew::apps
