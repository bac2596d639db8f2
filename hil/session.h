// SPDX-License-Identifier: Apache-2.0
// A session with the limb: hello, arm, the scenario's loop at absolute deadlines under both supervisors, disarm.
//
// It takes the time from its link alone, so the same link's bytes give the same session: replay.h.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "hil/serial_backend.h"
#include "hil/supervisor.h"
#include "hil/twin.h"
#include "sim/recording.h"
#include "sim/scenario.h"

namespace sinew::hil {

// The device was not armed: wrong version, firmware or limits, tripped, hot, a sensor. Nothing happened, nothing is written.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What a session shows while it runs.
struct SessionView {
  double time_s = 0.0;
  sim::Measurement measured;
  double temperature_age_s = 0.0;      // of the readings in `measured`: since the amplifiers were read
  double angle_age_s = 0.0;            // and since the telemetry with the angle was made
  std::vector<double> duty_fraction;   // at the pins, one a coil; the mean over the period where it was lowered within
  std::vector<double> predicted_degC;  // of each coil, by the host's supervisor, hottest over its horizon
  bool lowered = false;                // it lowered this command
  std::uint8_t state = DEVICE_DISARMED;
  std::optional<std::vector<double>> residual;  // against the twin, one a channel
  std::vector<Departure> departures;            // said now
};

// The periods of a scenario that a session takes, in seconds: a board speaks up to 200 times a second, and beside a coil no duty is decided
// for longer than 0.2 s. Throws sim::InputError.
inline constexpr double shortest_period_s = 0.005, longest_period_s = 0.2;
void check_period(const sim::Scenario& scenario, const std::string& file = "");

struct SessionSettings {
  std::uint16_t session = 1;
  bool clear_trip = false;
  bool allow_overruns = false;
  bool real_time_priority = false;    // of the host's loop; for the report
  bool angle_faults_end = true;       // a bend sensor that is not believed: false, its samples are missing, and the session goes on
  std::optional<double> time_zero_s;  // about when it begins, on a clock of sessions on this limb; for the recordings
  std::optional<plant::Plant> twin;   // with the inputs and channels of the scenario's plant
  std::function<bool(std::int64_t tick)> should_stop;  // asked before every repetition of a command: each 50 ms at least
  std::function<void(const SessionView&)> show;
  std::function<void(const std::string&)> say;  // a line that is worth keeping
};

enum class SessionStatus {
  finished,
  stopped,   // by who runs it
  tripped,   // by the device
  objected,  // by the host's supervisor
  overrun,   // a deadline was missed by a whole period
  link_lost,
};
std::string_view words(SessionStatus status);

struct SessionResult {
  SessionStatus status = SessionStatus::finished;
  std::string why;            // of what is not `finished`
  std::string recording_csv;  // as far as it came
  sim::Recording timed;       // the same, with each reading at the time at which it was made (timed_recording.h)
  std::string report_json;    // an object, without braces around other files' hashes: session_json adds those
  std::int64_t ticks = 0;
  std::int64_t asked_to_stop = 0;  // how often should_stop was asked: a session that was stopped ended at the last of these
  bool brought_to_rest = false;    // the device said that it is disarmed, or tripped
};

// Throws Refused, and LinkLost where not even the hello came through; sim::InputError where the plant or the twin is none of a
// board's (limb_parts.h), or the period too long or too short.
SessionResult run_session(const sim::Scenario& scenario, Link& link, const SessionSettings& settings);

// session.json: what happened, how the link and the clock did, and the hashes of the files beside it.
std::string session_json(const sim::Scenario& scenario, const SessionSettings& settings, const SessionResult& result,
                         const std::string& limb, const std::map<std::string, std::string>& files);

}  // namespace sinew::hil
