// SPDX-License-Identifier: Apache-2.0
// sinew hil-false-trips: how often the device's supervisor takes the duty away from a limb that is well.
//
// The supervisor is the code that the board runs, compiled for this machine (firmware/supervisor.c): emulating the processor as well
// costs a thousand times as much, and adds nothing to what trips. The limbs are those of the catalogue, one effect each at its typical
// value, and some with a thermocouple that is as slow as is allowed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "apps/app.h"
#include "apps/outputs.h"
#include "firmware/supervisor.h"
#include "hil/device.h"
#include "hil/heat_bound.h"
#include "hil/limb_parts.h"
#include "hil/limits.h"
#include "plant/integrator.h"
#include "report/markdown.h"
#include "sim/input_error.h"
#include "sim/parallel.h"
#include "sim/random.h"
#include "sim/scenario.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

constexpr int tick_us = 5000, ticks_per_command = 20, ticks_per_reading = LIMIT_READING_PERIOD_ms / 5;
constexpr double session_s = 300.0;
constexpr std::array<double, 5> noises_K{0.0, 0.4, 1.0, 1.5, 3.0};
constexpr plant::NumericalSettings numerics{plant::Method::automatic, 1e-5};

struct WellLimb {
  std::string name;
  plant::Plant plant;
};

// Nothing, each effect, and lags up to the longest that the limits allow.
std::vector<WellLimb> well_limbs() {
  const plant::Plant base = plant::default_plant();
  const plant::System& system = base.system();
  std::vector<WellLimb> all{{"the paper's limb as it is", base}};
  const auto turn_on = [&](plant::Plant& limb, plant::EffectId e) {
    for (const plant::ParameterId p : system.effects()[e].parameters) limb.set_in_file_units(p, system.parameters()[p].declaration.typical);
    limb.turn(e, true);
  };
  for (const plant::EffectId e : system.effects().ids()) {
    const plant::EffectInfo& effect = system.effects()[e];
    if (effect.law) continue;
    WellLimb one{std::string(effect.name), base};
    if (effect.needs) turn_on(one.plant, *effect.needs);
    turn_on(one.plant, e);
    all.push_back(std::move(one));
  }
  const plant::ParameterId lag = system.parameter("thermocouple_lag.time_constant_s");
  for (const double lag_s : {0.5, 1.0, 2.0}) {
    WellLimb one{"thermocouple_lag of " + sim::shortest(lag_s) + " s", base};
    turn_on(one.plant, system.effect("thermocouple_lag"));
    one.plant.set_in_file_units(lag, lag_s);
    all.push_back(std::move(one));
  }
  return all;
}

// What a session commands: each needs what it has measured, and the stream of its own.
enum class Drive { held, steps, random_binary, babbling };
constexpr std::array<std::string_view, 4> drive_words{"held", "steps", "random", "babbling"};

class Commander {
 public:
  Commander(Drive drive, const plant::System& system, std::uint64_t seed) : drive_(drive), chance_(seed, "duty") {
    if (drive == Drive::babbling) driver_.emplace(system, babbling_, seed, 0.1);
  }
  std::vector<double> duty(const sim::Measurement& measured, double time_s, const std::vector<double>& shown_degC) {
    std::vector<double> duty(shown_degC.size(), 0.0);
    if (driver_) return driver_->command(measured, time_s).inputs;
    if (time_s >= until_s_) next(time_s, duty.size());
    for (std::size_t j = 0; j < duty.size(); ++j) {
      // A step goes on until the coil is at 100 degC, and the next waits for 40.
      if (drive_ == Drive::steps) cooling_[j] = shown_degC[j] > 100.0 || (cooling_[j] && shown_degC[j] > 40.0);
      duty[j] = drive_ == Drive::steps && cooling_[j] ? 0.0 : level_[j];
    }
    return duty;
  }

 private:
  void next(double time_s, std::size_t coils) {
    level_.assign(coils, 0.0);
    cooling_.resize(coils, false);
    const auto one = [&] { return chance_.uniform(drawn_++); };
    if (drive_ == Drive::held) {  // for minutes, so that a coil comes to rest
      until_s_ = time_s + 40.0 + 80.0 * one();
      for (double& level : level_) level = one() < 0.3 ? 0.0 : 0.03 + 0.15 * one();
    } else if (drive_ == Drive::steps) {
      until_s_ = time_s + 15.0 + 30.0 * one();
      level_[static_cast<std::size_t>(one() * static_cast<double>(coils))] = 0.1 + 0.6 * one();
    } else {
      until_s_ = time_s + 4.0;
      for (double& level : level_) level = one() < 1.0 / 3.0 ? 0.25 + 0.45 * one() : 0.0;
    }
  }
  const sim::Input babbling_ = sim::BabbleInput{};
  Drive drive_;
  sim::RandomStream chance_;
  std::uint64_t drawn_ = 0;
  double until_s_ = 0.0;
  std::vector<double> level_;
  std::vector<bool> cooling_;
  std::optional<sim::Driver> driver_;
};

std::uint32_t amplifier_word(double temperature_degC, double junction_degC) {
  const auto hot = static_cast<std::int32_t>(std::lround(std::clamp(temperature_degC, -270.0, 1800.0) * 4.0));
  const auto cold = static_cast<std::int32_t>(std::lround(junction_degC * 16.0));
  return (static_cast<std::uint32_t>(hot & 0x3fff) << 18) | (static_cast<std::uint32_t>(cold & 0xfff) << 4);
}

struct Watched {
  double armed_s = 0.0;
  std::uint8_t cause = TRIP_NONE;
  double hottest_degC = 0.0;  // wire
  std::string failure;
};

// A host that keeps what `sinew hil` keeps: the bound of the heat, the budget of on-time, and no duty for a coil that shows 110 degC.
class Keeper {
 public:
  explicit Keeper(std::size_t coils) : on_s_(coils) {}
  double kept(double wanted, std::size_t j, double shown_degC, std::uint32_t bound_uK) {
    constexpr std::uint32_t most_uK = (LIMIT_BOUND_RISE_cK - 50) * 10'000u;
    constexpr double held_ms = 100.0 + LIMIT_DEAD_MAN_ms, budget_s = LIMIT_ON_TIME_ms / 1000.0 - 0.4;
    const std::uint32_t without_uK = heat_bound_after(bound_uK, 0, static_cast<std::uint16_t>(held_ms));
    const double by_bound = without_uK >= most_uK ? 0.0 : (most_uK - without_uK) / (held_ms * LIMIT_BOUND_HEATING_mK_s);
    double sum_s = 0.0;
    for (const double one : on_s_[j]) sum_s += one;
    double duty =
        shown_degC > 110.0 ? 0.0 : std::min({wanted, LIMIT_HIGHEST_DUTY / 10000.0, by_bound, std::max(0.0, budget_s - sum_s) / 0.1});
    duty = std::floor(std::max(0.0, duty) * DUTY_ONE) / DUTY_ONE;
    on_s_[j][at_[j]++ % on_s_[j].size()] = duty * 0.1;
    return duty;
  }

 private:
  std::vector<std::array<double, 210>> on_s_;  // 21 s
  std::map<std::size_t, std::size_t> at_;
};

Watched watch(const WellLimb& limb, double noise_K, Drive drive, std::uint64_t seed) {
  Watched result;
  const plant::System& system = limb.plant.system();
  const hil::LimbParts parts = hil::parts_of(limb.plant);
  plant::Integrator body(limb.plant, plant::Start{}, numerics);
  std::vector<sim::RandomStream> noise;
  for (const plant::ChannelId c : system.channels().ids()) noise.emplace_back(seed, system.channels()[c].short_name + ".noise");
  Commander commander(drive, system, seed);
  Keeper keeper(parts.coils.size());
  supervisor s;
  supervisor_start(&s, TRIP_NONE, 0);
  sim::Measurement measured;
  measured.channels.assign(system.channels().size(), 25.0);
  std::array<std::uint16_t, BOARD_COILS> held{};
  std::uint64_t reading = 0;
  const auto ticks = static_cast<std::int64_t>(session_s * 1e6 / tick_us);
  bool armed = false;
  std::int64_t armed_at = 0;
  for (std::int64_t k = 1; k <= ticks; ++k) {
    const auto now_us = static_cast<std::uint32_t>(k * tick_us);
    const double now_s = static_cast<double>(k) * tick_us / 1e6;
    if (armed && (k - armed_at) % ticks_per_command == 0) {
      message_command command{};
      command.time_to_live_ms = LIMIT_DEAD_MAN_ms;
      std::vector<double> shown_degC;
      for (const hil::Coil& coil : parts.coils) shown_degC.push_back(measured.channels[coil.shown.index]);
      measured.tick = (k - armed_at) / ticks_per_command;
      const std::vector<double> wanted = commander.duty(measured, static_cast<double>(measured.tick) * 0.1, shown_degC);
      for (std::size_t j = 0; j < parts.coils.size(); ++j)
        command.duty[j] = static_cast<std::uint16_t>(std::lround(keeper.kept(wanted[j], j, shown_degC[j], s.bound_uK[j]) * DUTY_ONE));
      supervisor_command(&s, &command, now_us, now_us);
    }
    supervisor_tick(&s, now_us);
    const bool reads = k % ticks_per_reading == 0, changed = !std::equal(held.begin(), held.end(), s.duty);
    if (reads || changed) {
      if (const auto failure = body.advance_to(now_s)) {
        result.failure = failure->reason;
        return result;
      }
    }
    if (changed) {
      std::copy_n(s.duty, BOARD_COILS, held.begin());
      body.hold({held[0] / static_cast<double>(DUTY_ONE), held[1] / static_cast<double>(DUTY_ONE)});
    }
    if (!reads) continue;
    const std::vector<double> shows = sim::in_file_units(system, body.readings());
    std::array<std::uint32_t, BOARD_COILS> raw{};
    for (std::size_t j = 0; j < parts.coils.size(); ++j) {
      const std::size_t c = parts.coils[j].shown.index;
      raw[j] = amplifier_word(shows[c] + noise_K * noise[c].normal(reading), limb.plant.get(parts.ambient_temperature));
      measured.channels[c] = (static_cast<std::int32_t>(raw[j]) >> 18) * 0.25;
      result.hottest_degC = std::max(result.hottest_degC, body.state()[parts.coils[j].temperature.index]);
    }
    const std::size_t angle = parts.angles.front().index;
    // Of the bend sensor the usual noise, where there is any.
    const double noise_deg = noise_K > 0.0 ? system.channels()[parts.angles.front()].noise : 0.0;
    measured.channels[angle] = shows[angle] + noise_deg * noise[angle].normal(reading);
    const auto angle_raw = static_cast<std::uint16_t>(std::clamp(8184.0 + measured.channels[angle] * 16368.0 / 180.0, 0.0, 16368.0));
    ++reading;
    supervisor_reading(&s, raw.data(), now_us);
    supervisor_angles(&s, &angle_raw);
    if (!armed && reading == 3) {
      armed = supervisor_arm(&s, now_us) == ANSWER_DONE;
      armed_at = k;
    }
    if (s.state == DEVICE_TRIPPED || !armed) {
      result.cause = s.state == DEVICE_TRIPPED ? s.trip_cause : result.cause;
      if (s.state == DEVICE_TRIPPED) break;
    }
  }
  result.armed_s = armed ? static_cast<double>(s.last_tick_us) / 1e6 - static_cast<double>(armed_at) * tick_us / 1e6 : 0.0;
  return result;
}

int false_trips_command(const std::string& out_name, double hours, int threads, const std::string& only, bool overwrite) {
  Outputs outputs(out_name, {}, overwrite);
  if (only.empty()) outputs.claim({"false_trips.md", "false_trips.csv"});
  const std::vector<WellLimb> limbs = well_limbs();
  struct Session {
    std::size_t limb, noise;
    Drive drive;
    std::uint64_t seed;
    Watched watched{};
  };
  std::vector<Session> sessions;
  // Every limb, noise and drive in each round, until the hours are full.
  for (std::uint64_t round = 1; sessions.empty() || static_cast<double>(sessions.size()) * session_s < hours * 3600.0; ++round) {
    const std::size_t before = sessions.size();
    for (std::size_t l = 0; l < limbs.size(); ++l) {
      if (limbs[l].name.find(only) == std::string::npos) continue;
      for (std::size_t n = 0; n < noises_K.size(); ++n)
        for (std::size_t d = 0; d < drive_words.size(); ++d) sessions.push_back({l, n, static_cast<Drive>(d), round});
    }
    if (sessions.size() == before) throw sim::InputError({.key = "--only", .value = only, .advice = "no limb has this in its name"});
  }
  sim::in_parallel(sessions.size(), threads, [&](std::size_t i) {
    if (interrupted()) return;
    Session& one = sessions[i];
    one.watched = watch(limbs[one.limb], noises_K[one.noise], one.drive, one.seed);
  });
  if (interrupted()) return interrupted_exit_code;

  std::string csv = "limb,noise_K,drive,seed,armed_s,trip,hottest_wire_degC\n";
  struct Sum {
    double armed_s = 0.0, hottest_degC = 0.0;
    int sessions = 0, trips = 0;
    std::map<std::string, int> causes;
  };
  std::vector<Sum> by_noise(noises_K.size());
  std::map<std::size_t, Sum> by_limb;
  Sum all;
  for (const Session& one : sessions) {
    if (!one.watched.failure.empty()) throw std::runtime_error(limbs[one.limb].name + ": " + one.watched.failure);
    const std::string cause{hil::words(static_cast<trip_cause>(one.watched.cause))};
    csv += limbs[one.limb].name + "," + sim::shortest(noises_K[one.noise]) + "," +
           std::string(drive_words[static_cast<std::size_t>(one.drive)]) + "," + std::to_string(one.seed) + "," +
           sim::shortest(one.watched.armed_s) + "," + cause + "," + sim::shortest(std::round(one.watched.hottest_degC * 100.0) / 100.0) +
           "\n";
    for (Sum* sum : {&all, &by_noise[one.noise], &by_limb[one.limb]}) {
      sum->armed_s += one.watched.armed_s;
      sum->hottest_degC = std::max(sum->hottest_degC, one.watched.hottest_degC);
      ++sum->sessions;
      if (one.watched.cause == TRIP_NONE) continue;
      ++sum->trips;
      ++sum->causes[cause];
    }
  }
  report::Table noise_table, limb_table;
  noise_table.header = {"noise [K]", "sessions", "hours armed", "false trips", "of which", "hottest wire [°C]"};
  limb_table.header = noise_table.header;
  limb_table.header.front() = "limb";
  const auto row = [](const std::string& name, const Sum& sum) {
    std::string causes;
    for (const auto& [cause, count] : sum.causes) causes += (causes.empty() ? "" : ", ") + cause + " " + std::to_string(count);
    std::array<char, 32> hours_text{}, hottest{};
    std::snprintf(hours_text.data(), hours_text.size(), "%.2f", sum.armed_s / 3600.0);
    std::snprintf(hottest.data(), hottest.size(), "%.1f", sum.hottest_degC);
    std::printf("%-40s %5d sessions %8s h %4d false trips %s\n", name.c_str(), sum.sessions, hours_text.data(), sum.trips, causes.c_str());
    return report::Row{
        {name, std::to_string(sum.sessions), hours_text.data(), std::to_string(sum.trips), causes.empty() ? "–" : causes, hottest.data()}};
  };
  for (const auto& [l, sum] : by_limb) limb_table.rows.push_back(row(limbs[l].name, sum));
  for (std::size_t n = 0; n < noises_K.size(); ++n) noise_table.rows.push_back(row(sim::shortest(noises_K[n]) + " K", by_noise[n]));
  noise_table.rows.push_back(row("all", all));
  if (only.empty()) {
    outputs.stage("false_trips.md", "# How often a limb that is well is taken for one that is not\n\n    sinew hil-false-trips --out " +
                                        out_name + (hours == 100.0 ? "" : " --hours " + sim::shortest(hours)) +
                                        "\n\nmade this page and `false_trips.csv`: sessions of five minutes from cold, of the paper's "
                                        "limb, of one with each effect of the\n"
                                        "catalogue at its typical value, and of some whose thermocouples lag. Coils are held for minutes, "
                                        "stepped to 100 °C, driven at\n"
                                        "random, and babble. The device's supervisor is the firmware's own code, compiled for this "
                                        "machine, and without the dividers at\n"
                                        "the drains; the host is one that keeps the bound of the heat, the on-time, and gives a coil that "
                                        "shows 110 °C no duty. A trip\n"
                                        "ends its session. Goal: none in 100 hours.\n\n" +
                                        report::to_markdown(noise_table) + "\n" + report::to_markdown(limb_table));
    outputs.stage("false_trips.csv", csv);
  }
  outputs.commit();
  std::printf("%.2f hours armed, %d false trips\n", all.armed_s / 3600.0, all.trips);
  return all.trips ? 1 : 0;
}

}  // namespace

void add_hil_false_trips(CLI::App& program, int& exit_code) {
  auto out = std::make_shared<std::string>();
  auto only = std::make_shared<std::string>();
  auto hours = std::make_shared<double>(100.0);
  auto threads = std::make_shared<int>(1);
  auto overwrite = std::make_shared<bool>(false);
  CLI::App* command =
      program.add_subcommand("hil-false-trips", "How often the device's supervisor trips on limbs that are well, over the catalogue.");
  command->add_option("--out", *out, "folder for false_trips.md and false_trips.csv")->required();
  command->add_option("--hours", *hours, "of sessions, rounded up to whole rounds of all limbs, noises and drives")
      ->check(CLI::Range(0.01, 10000.0))
      ->capture_default_str();
  command->add_option("--threads", *threads, "sessions at a time; the result is the same")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--only", *only, "limbs whose name has this in it; nothing is written then");
  add_overwrite(*command, *overwrite);
  command->footer("Example:\n  sinew hil-false-trips --out results/hil --overwrite");
  command->callback([=, &exit_code] { exit_code = false_trips_command(*out, *hours, *threads, *only, *overwrite); });
}

}  // namespace sinew::apps
