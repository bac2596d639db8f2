// SPDX-License-Identifier: Apache-2.0
#include "hil/session.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "firmware_hash.h"
#include "hil/limits.h"
#include "hil/timed_recording.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/recording.h"
#include "sim/text.h"

namespace sinew::hil {
namespace {

using Json = nlohmann::ordered_json;

// Sorted shares, and how many lie in each bin; a bin ends where the next begins.
Json histogram(std::vector<std::int64_t> all_us) {
  Json json;
  std::sort(all_us.begin(), all_us.end());
  json["count"] = all_us.size();
  if (all_us.empty()) return json;
  const auto share_us = [&](double share) {
    return all_us[std::min(all_us.size() - 1, static_cast<std::size_t>(share * static_cast<double>(all_us.size())))];
  };
  json["median_us"] = share_us(0.5);
  json["share_99_us"] = share_us(0.99);
  json["share_99_9_us"] = share_us(0.999);
  json["most_us"] = all_us.back();
  constexpr std::array<std::int64_t, 11> edges{100, 200, 500, 1000, 2000, 5000, 10'000, 20'000, 50'000, 100'000, 1'000'000};
  auto from = all_us.begin();
  for (const std::int64_t edge : edges) {
    const auto to = std::lower_bound(from, all_us.end(), edge);
    if (to != from) json["under_us"][std::to_string(edge)] = to - from;
    from = to;
  }
  if (from != all_us.end()) json["under_us"]["more"] = all_us.end() - from;
  return json;
}

std::string hexadecimal(std::uint32_t value) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", value);
  return text.data();
}

std::string degrees(double value_degC) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f degC", value_degC);
  return text.data();
}

class Session {
 public:
  Session(const sim::Scenario& scenario, Link& link, const SessionSettings& settings)
      : scenario_(scenario),
        settings_(settings),
        period_us_(std::llround(scenario.sample_period_s * 1e6)),
        link_(link),
        parts_(parts_of(scenario.plant)),
        device_(link, settings.session),
        backend_(device_, parts_, period_us_),
        driver_(scenario.plant.system(), scenario.input, static_cast<std::uint64_t>(scenario.seed), scenario.sample_period_s),
        timed_(scenario.plant) {
    check_period(scenario);
    if (settings.twin && sim::columns_of(settings.twin->system()) != sim::columns_of(scenario.plant.system()))
      throw sim::InputError({.key = "twin", .advice = "its inputs and channels must be those of the scenario's plant"});
  }

  SessionResult run() {
    greet();
    ready();
    result_.recording_csv = sim::time_zero_comment(settings_.time_zero_s) + sim::header_of(sim::columns_of(scenario_.plant.system()));
    // What grows tick by tick gets its room before the limb is armed.
    const auto ticks = static_cast<std::size_t>(std::min<std::int64_t>(scenario_.ticks(), 1'000'000));
    result_.recording_csv.reserve(result_.recording_csv.size() + ticks * 64);
    lateness_us_.reserve(ticks);
    ages_us_.reserve(ticks);
    device_.round_trips_us().reserve(2 * ticks);
    // From here on the device may be armed, whatever its answer.
    bool begun = false;
    try {
      arm();
      supervisor_.emplace(scenario_.plant, start_of(scenario_.plant, scenario_.start),
                          scenario_.sample_period_s / static_cast<double>(backend_.parts_of_period()));
      if (settings_.twin) twin_.emplace(*settings_.twin, start_of(*settings_.twin, {}), scenario_.sensors, scenario_.sample_period_s);
      begun = true;
      loop();
    } catch (const LinkLost& lost) {
      if (!begun) {
        bring_to_rest();
        throw;
      }
      end(SessionStatus::link_lost, lost.what());
    } catch (...) {
      bring_to_rest();
      throw;
    }
    bring_to_rest();
    result_.timed = timed_.recording();
    result_.timed.time_zero_s = settings_.time_zero_s;
    result_.report_json = report().dump();
    return std::move(result_);
  }

 private:
  void say(const std::string& line) {
    if (settings_.say) settings_.say(line);
  }
  void end(SessionStatus status, const std::string& why) {
    if (result_.status != SessionStatus::finished) return;
    result_.status = status;
    result_.why = why;
  }

  void greet() {
    const auto hello = device_.hello(telemetry_period_ms(period_us_));
    if (!hello) {
      if (device_.other_version())
        throw Refused("the device speaks another version of the protocol than " + std::to_string(FRAME_VERSION) +
                      "\n  flash the firmware that belongs to this program: docs/hardware.md");
      const auto& refused = device_.counters().refused;
      const bool noise = std::any_of(refused.begin(), refused.end(), [](std::int64_t n) { return n > 0; });
      throw Refused(
          noise
              ? "what answers is no limb's board: bytes come, and no frame among them is valid\n  is it another device, or other firmware?"
              : "no answer to the hello\n  is the board powered, and is this its port? `sinew doctor --port ...` looks further");
    }
    hello_ = *hello;
    if (const std::string misfit = misfit_of(hello_.parts); !misfit.empty())
      throw Refused(misfit + "\n  flash the firmware that belongs to this program: docs/hardware.md");
    std::string others;
    const auto same = [&](const char* what, std::size_t of_plant, std::size_t of_board) {
      if (of_plant != of_board)
        others += (others.empty() ? "the plant has " : "; the plant has ") + std::to_string(of_plant) + " " + what + ", the board " +
                  std::to_string(of_board);
    };
    same("coils", parts_.coils.size(), hello_.parts.coils);
    same("thermocouples", parts_.thermocouples.size(), hello_.parts.thermocouples);
    same("angles", parts_.angles.size(), hello_.parts.angles);
    if (!others.empty()) throw Refused(others + "\n  the scenario's plant must be that of the limb at this board");
    if (hello_.firmware_hash != SINEW_FIRMWARE_HASH)
      throw Refused("the device's firmware is " + hexadecimal(hello_.firmware_hash) + ", this program's is " +
                    hexadecimal(SINEW_FIRMWARE_HASH) + "\n  flash the firmware that belongs to this program: docs/hardware.md");
    const std::uint32_t limits = limits_hash(hello_.parts.coils);
    if (hello_.limits_hash != limits)
      throw Refused("the device's limits (" + hexadecimal(hello_.limits_hash) + ") are not this program's (" + hexadecimal(limits) +
                    ")\n  build and flash both from the same hil/limits.h");
    if (hello_.wrong_settings != 0) {
      std::string wrong;
      for (const std::string& one : words_of_settings(hello_.wrong_settings)) wrong += (wrong.empty() ? "" : "; ") + one;
      throw Refused("the board's fuses are wrong: " + wrong + "\n  set them once, by a programmer: docs/hardware.md, Fuses");
    }
    if (hello_.reset_cause == RESET_WATCHDOG || hello_.reset_cause == RESET_BROWN_OUT)
      say("the device's last reset: " + std::string(words(static_cast<reset_cause>(hello_.reset_cause))));
  }

  // Telemetry of both sensors is there, and no trip.
  void ready() {
    // Thermocouples are believed from their second conversion on.
    const auto believed = [&] {
      const auto& t = device_.telemetry();
      return t &&
             std::all_of(t->said.sensor, t->said.sensor + parts_.thermocouples.size(), [](std::uint8_t why) { return why == TRIP_NONE; });
    };
    const std::int64_t give_up_us = device_.now_us() + 1'000'000;
    while (!believed() && device_.now_us() < give_up_us) device_.listen_until(give_up_us, FRAME_TELEMETRY);
    if (!device_.telemetry()) throw Refused("the device says hello and then nothing: no telemetry within 1 s");
    if (hello_.state == DEVICE_TRIPPED) {
      const std::string cause{words(static_cast<trip_cause>(hello_.trip_cause))};
      if (!settings_.clear_trip)
        throw Refused("the device is tripped: " + cause + "\n  find out why; then give --clear-trip, with all coils below " +
                      degrees(LIMIT_COOL_cdegC / 100.0));
      must(device_.clear_trip(hello_.trip_cause), "clearing the trip (" + cause + ")");
      say("trip cleared: " + cause);
    }
  }

  void arm() {
    must(device_.arm(SINEW_FIRMWARE_HASH, limits_hash(hello_.parts.coils), settings_.angle_faults_end ? ARM_ANGLE_FAULTS_TRIP : 0),
         "arming");
    // Telemetry that was on its way still tells of before. Where the line is slow, the device must not take the wait for silence.
    const std::int64_t wait_until_us = device_.now_us() + LIMIT_DEAD_MAN_ms * 1000;
    while (device_.telemetry()->said.state != DEVICE_ARMED && device_.now_us() < wait_until_us) {
      device_.command(std::vector<std::uint16_t>(parts_.coils.size(), 0), LIMIT_DEAD_MAN_ms);
      device_.listen_until(std::min(wait_until_us, device_.now_us() + 40'000), FRAME_TELEMETRY);
    }
    begun_device_us_ = device_.clock().device_us_since_begin();
  }

  void must(const std::optional<answer>& got, const std::string& what) {
    if (!got) throw Refused(what + ": the device did not answer");
    if (*got == ANSWER_DONE) return;
    std::string why = what + ": " + std::string(words(*got));
    const message_telemetry& said = device_.telemetry()->said;
    const char* between = "\n  ";
    for (const Coil& coil : parts_.coils) {
      if (*got != ANSWER_HOT && *got != ANSWER_SENSOR) break;
      why += between + coil.name + " ";
      between = ", ";
      why += *got == ANSWER_HOT ? degrees(said.temperature_cdegC[coil.thermocouple] / 100.0)
                                : std::string(words(static_cast<trip_cause>(said.sensor[coil.thermocouple])));
    }
    for (std::size_t k = 0; k < parts_.angles.size() && *got == ANSWER_SENSOR; ++k)
      why += ", bend sensor " + std::string(words(static_cast<trip_cause>(said.angle_fault[k])));
    if (*got == ANSWER_HOT) why += "; must be below " + degrees(LIMIT_COOL_cdegC / 100.0);
    throw Refused(why);
  }

  // As the scenario says, but for wires that are found at another temperature: warm from the session before.
  plant::Start start_of(const plant::Plant& limb, std::vector<std::optional<double>> given) const {
    constexpr double same_K = 2.0;
    const LimbParts parts = parts_of(limb);
    given.resize(limb.states().size());
    for (const Coil& coil : parts.coils) {
      std::optional<double>& wire_degC = given[coil.temperature.index];
      const double found_degC = device_.telemetry()->said.temperature_cdegC[coil.thermocouple] / 100.0;
      if (std::abs(found_degC - wire_degC.value_or(limb.get(parts.ambient_temperature))) > same_K) wire_degC = found_degC;
    }
    return {given, {}};
  }

  void loop() {
    sim::Measurement measured = backend_.begin();
    std::vector<std::vector<double>> pins;  // of each part of the period
    std::vector<double> wanted, sent;       // by the scenario; after the supervisor
    backend_.before_repetition = [&](const sim::Measurement& now, sim::Command& command) {
      pins.push_back(duty_at_pins(sent));
      supervisor_->applied(pins.back());
      supervisor_->look(now, backend_.telemetry()->said.thermocouple_raw);
      supervisor_->bound_said(backend_.telemetry()->said.bound_rise_cK);
      if (settings_.angle_faults_end) supervisor_->look_at_angles(now, backend_.telemetry()->said.angle_raw);
      if (should_stop(command.tick)) end(SessionStatus::stopped, "stopped by request");
      command.inputs = sent = supervisor_->lower(wanted, now);
      object();
      return result_.status == SessionStatus::finished;
    };
    const std::int64_t last = scenario_.ticks() - 1;
    for (std::int64_t tick = 0; tick <= last; ++tick) {
      SessionView view;
      view.time_s = scenario_.time_s(tick);
      view.measured = measured;
      const Telemetry before = *backend_.telemetry();
      if (!backend_.heard()) ++ticks_without_telemetry_;
      supervisor_->look(measured, before.said.thermocouple_raw);
      supervisor_->bound_said(before.said.bound_rise_cK);
      if (settings_.angle_faults_end) supervisor_->look_at_angles(measured, before.said.angle_raw);
      const double age_s = static_cast<double>(backend_.deadline_us(tick) - before.made_us) / 1e6;
      view.temperature_age_s = before.said.temperature_age_ms / 1e3 + age_s;
      view.angle_age_s = age_s + 0.008;  // the middle of its conversions
      if (twin_) {
        view.departures = twin_->compare(measured, view.temperature_age_s, view.angle_age_s);
        for (const Departure& one : view.departures) departures_.push_back(one);
        view.residual = twin_->residual();
      }
      if (before.said.state == DEVICE_TRIPPED)
        end(SessionStatus::tripped, "the device tripped: " + std::string(words(static_cast<trip_cause>(before.said.trip_cause))));
      if (should_stop(tick)) end(SessionStatus::stopped, "stopped by request");
      sim::Command command = driver_.command(measured, view.time_s);
      const std::int64_t lowered = supervisor_->lowered();
      wanted = command.inputs;
      command.inputs = supervisor_->lower(wanted, measured);
      command.tick = tick;
      object();
      bool ends = tick == last || result_.status != SessionStatus::finished;
      if (ends) command.inputs.assign(command.inputs.size(), 0.0);
      view.predicted_degC = supervisor_->predicted_degC();
      view.duty_fraction = sent = command.inputs;
      if (!ends) {
        try {
          measured = backend_.exchange(command);
        } catch (...) {
          row(view);
          throw;
        }
        const Telemetry& now = *backend_.telemetry();
        ends = result_.status != SessionStatus::finished;  // in the middle of the period
        if (!ends) {
          pins.push_back(duty_at_pins(sent));
          supervisor_->applied(pins.back());
        }
        view.duty_fraction = mean_of(pins);
        pins.clear();
        if (twin_) twin_->applied(view.duty_fraction);
        if (ends) {
          finish(view, lowered);
          break;
        }
        const std::int64_t late_us = device_.now_us() - backend_.deadline_us(tick + 1);
        lateness_us_.push_back(backend_.written_us() - backend_.deadline_us(tick));
        ages_us_.push_back(device_.now_us() - now.made_us);
        if (late_us >= period_us_) {
          ++overruns_;
          if (!settings_.allow_overruns)
            end(SessionStatus::overrun, "tick " + std::to_string(tick + 1) + " came " + std::to_string(late_us / 1000) +
                                            " ms late, a period or more\n  is the machine busy? --allow-overruns goes on");
        }
        if (device_.now_us() - device_.last_heard_us() > std::max<std::int64_t>(500'000, 3 * period_us_))
          end(SessionStatus::link_lost, "nothing heard for " + std::to_string((device_.now_us() - device_.last_heard_us()) / 1000) + " ms");
      }
      finish(view, lowered);
      if (ends) break;
    }
  }

  bool should_stop(std::int64_t tick) {
    if (!settings_.should_stop) return false;
    ++result_.asked_to_stop;
    return settings_.should_stop(tick);
  }

  void finish(SessionView& view, std::int64_t lowered_before) {
    view.lowered = supervisor_->lowered() > lowered_before;
    ticks_lowered_ += view.lowered;
    view.state = backend_.telemetry()->said.state;
    row(view);
    if (settings_.show) settings_.show(view);
  }

  void object() {
    if (supervisor_->objection()) end(SessionStatus::objected, "the host's supervisor objects: " + *supervisor_->objection());
  }

  // The pins' own word on the part of the period that is over; where it did not come, what was sent.
  std::vector<double> duty_at_pins(std::vector<double> sent) const {
    if (backend_.heard_in_part())
      for (std::size_t j = 0; j < parts_.coils.size(); ++j) sent[j] = backend_.telemetry()->said.duty[j] / static_cast<double>(DUTY_ONE);
    return sent;
  }

  // Parts of one length; where the duty stayed the same, that number to the bit.
  static std::vector<double> mean_of(const std::vector<std::vector<double>>& parts) {
    std::vector<double> mean = parts.front();
    for (std::size_t j = 0; j < mean.size(); ++j) {
      double beyond_first = 0.0;
      for (const std::vector<double>& part : parts) beyond_first += part[j] - parts.front()[j];
      mean[j] += beyond_first / static_cast<double>(parts.size());
    }
    return mean;
  }

  void row(const SessionView& view) {
    std::string& csv = result_.recording_csv;
    const auto put = [&](double value) {
      if (!std::isnan(value)) sim::append_shortest(csv, value);
      csv += ',';
    };
    put(view.time_s);
    for (const double value : view.duty_fraction) put(value);
    for (const double value : view.measured.channels) put(value);
    csv.back() = '\n';
    timed_.add(view);
    ++result_.ticks;
  }

  // Zero duty, then disarm. Where nothing answers, the device's own dead-man has done it; a device that was reset is asked
  // why.
  void bring_to_rest() noexcept {
    try {
      if (const auto& t = device_.telemetry()) counters_at_end_ = t->said;
      device_.command(std::vector<std::uint16_t>(parts_.coils.size(), 0), LIMIT_DEAD_MAN_ms);
      const auto answered = device_.disarm();
      result_.brought_to_rest = answered.has_value();
      if (answered) {
        device_.listen_until(device_.now_us() + 3000 * telemetry_period_ms(period_us_), FRAME_TELEMETRY);
        counters_at_end_ = device_.telemetry()->said;
        if (counters_at_end_->state == DEVICE_TRIPPED)  // on the last tick, or by what was sent last
          end(SessionStatus::tripped, "the device tripped: " + std::string(words(static_cast<trip_cause>(counters_at_end_->trip_cause))));
        return;
      }
      Device anew(link_, static_cast<std::uint16_t>(settings_.session + 1));
      if (const auto hello = anew.hello(100)) {
        result_.brought_to_rest = true;
        result_.why += "\n  the device was reset: " + std::string(words(static_cast<reset_cause>(hello->reset_cause)));
        if (hello->state == DEVICE_TRIPPED) {
          result_.why += "; it is tripped: " + std::string(words(static_cast<trip_cause>(hello->trip_cause)));
          reset_trip_ = std::string(words(static_cast<trip_cause>(hello->trip_cause)));
        }
      }
    } catch (const std::exception&) {
      // The link is gone; the device goes to zero duty by itself when the last command's time is up.
    }
  }

  Json report() const {
    Json json;
    json["status"] = words(result_.status);
    if (!result_.why.empty()) json["why"] = result_.why;
    if (reset_trip_) json["trip_after_reset"] = *reset_trip_;
    json["brought_to_rest"] = result_.brought_to_rest;
    json["ticks"] = result_.ticks;
    json["ticks_without_telemetry"] = ticks_without_telemetry_;
    json["commands_lowered_by_host"] = ticks_lowered_;
    json["overruns"] = overruns_;
    json["device"] = {{"firmware_hash", hexadecimal(hello_.firmware_hash)},
                      {"limits_hash", hexadecimal(hello_.limits_hash)},
                      {"reset_cause", words(static_cast<reset_cause>(hello_.reset_cause))}};
    Json& link = json["link"];
    const LinkCounters& counters = device_.counters();
    link["frames_sent"] = counters.sent;
    link["frames_received"] = counters.received;
    link["frames_missing"] = counters.missing;
    std::int64_t refused = 0;
    for (std::size_t i = 0; i < FRAME_FAULTS; ++i) {
      refused += counters.refused[i];
      link["refused_by_host"][counter_names[i]] = counters.refused[i];
    }
    link["refused_by_host_in_all"] = refused;
    link["out_of_order"] = counters.out_of_order;
    link["other_session"] = counters.other_session;
    if (counters_at_end_)
      for (std::size_t i = 0; i < DEVICE_COUNTERS; ++i) link["counted_by_device"][counter_names[i]] = counters_at_end_->counters[i];
    json["clock"] = {{"skew_ppm", std::round(device_.clock().skew() * 1e8) / 100.0},
                     {"device_s", static_cast<double>(device_.clock().device_us_since_begin() - begun_device_us_) / 1e6}};
    json["lateness"] = histogram(lateness_us_);
    if (!lateness_us_.empty())
      json["lateness"]["share_within_5_ms"] =
          static_cast<double>(std::count_if(lateness_us_.begin(), lateness_us_.end(), [](std::int64_t l) { return l <= 5000; })) /
          static_cast<double>(lateness_us_.size());
    auto round_trips = const_cast<Device&>(device_).round_trips_us();
    json["round_trip"] = histogram(std::move(round_trips));
    json["age_of_data"] = histogram(ages_us_);
    for (const Departure& one : departures_)
      json["departures_from_twin"].push_back(
          {{"channel", scenario_.plant.system().channels()[one.channel].short_name}, {"onset_s", one.onset_s}, {"said_s", one.said_s}});
    return json;
  }

  const sim::Scenario& scenario_;
  const SessionSettings& settings_;
  std::int64_t period_us_;
  Link& link_;
  LimbParts parts_;
  Device device_;
  SerialBackend backend_;
  std::optional<HostSupervisor> supervisor_;
  sim::Driver driver_;
  TimedRecording timed_;
  std::optional<Twin> twin_;
  message_hello hello_{};
  std::int64_t begun_device_us_ = 0, ticks_lowered_ = 0, ticks_without_telemetry_ = 0, overruns_ = 0;
  std::vector<std::int64_t> lateness_us_, ages_us_;
  std::vector<Departure> departures_;
  std::optional<message_telemetry> counters_at_end_;
  std::optional<std::string> reset_trip_;
  SessionResult result_;
};

}  // namespace

std::string_view words(SessionStatus status) {
  constexpr std::array<std::string_view, 6> all{"finished", "stopped", "tripped", "objected", "overrun", "link_lost"};
  return all[static_cast<std::size_t>(status)];
}

void check_period(const sim::Scenario& scenario, const std::string& file) {
  if (scenario.sample_period_s >= shortest_period_s && scenario.sample_period_s <= longest_period_s) return;
  throw sim::InputError(
      {.file = file,
       .key = "sample_period_s",
       .value = sim::shortest(scenario.sample_period_s),
       .advice = scenario.sample_period_s < shortest_period_s
                     ? "must be " + sim::shortest(shortest_period_s) + " or more: the device speaks up to 200 times a second"
                     : "must be " + sim::shortest(longest_period_s) + " or less beside a coil that can be too hot in seconds"});
}

SessionResult run_session(const sim::Scenario& scenario, Link& link, const SessionSettings& settings) {
  return Session(scenario, link, settings).run();
}

std::string session_json(const sim::Scenario& scenario, const SessionSettings& settings, const SessionResult& result,
                         const std::string& limb, const std::map<std::string, std::string>& files) {
  const sim::Build build = sim::this_build();
  Json json;
  json["program"] = "sinew " + build.version;
  json["commit"] = build.commit;
  json["limb"] = limb;
  json["seed"] = scenario.seed;
  json["session"] = settings.session;
  json["clear_trip"] = settings.clear_trip;
  json["allow_overruns"] = settings.allow_overruns;
  json["real_time_priority"] = settings.real_time_priority;
  json["angle_faults_end"] = settings.angle_faults_end;
  json["twin"] = settings.twin.has_value();
  if (settings.time_zero_s) json["time_zero_s"] = *settings.time_zero_s;
  json.update(Json::parse(result.report_json));
  if (result.status == SessionStatus::stopped) json["asked_to_stop"] = result.asked_to_stop;
  for (const auto& [name, content] : files) json["sha256"][name] = sim::sha256(content);
  return json.dump(2) + "\n";
}

}  // namespace sinew::hil
