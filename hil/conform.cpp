// SPDX-License-Identifier: Apache-2.0
#include "hil/conform.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <optional>

#include "hil/device.h"
#include "hil/limits.h"
#include "hil/message.h"

namespace sinew::hil {
namespace {

constexpr std::int64_t ms = 1000;

// Near the end of its range, so that it wraps in the first session.
constexpr std::uint32_t first_sequence = 0xfffffff0u;

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    char two[4];
    std::snprintf(two, sizeof two, "%s%02x", text.empty() ? "" : " ", byte);
    text += two;
  }
  return text;
}

Bytes stuffed(std::span<const std::uint8_t> plain) {
  Bytes wire{0, 1};
  std::size_t length_at = 1;
  for (const std::uint8_t byte : plain) {
    if (byte == 0) {
      length_at = wire.size();
      wire.push_back(1);
    } else {
      wire.push_back(byte);
      ++wire[length_at];
    }
  }
  wire.push_back(0);
  return wire;
}

Bytes wire_of(const frame& f) {
  Bytes wire(1 + FRAME_WIRE_MOST, 0);
  wire.resize(1u + frame_encode(&f, wire.data() + 1));
  return wire;
}

struct Heard {
  frame f;
  std::int64_t at_us;
};

class Conformance {
 public:
  Conformance(Link& link, const ConformSettings& settings) : link_(link), settings_(settings) { frame_decoder_start(&decoder_, nullptr); }

  ConformResult run() {
    try {
      ask();
    } catch (const Stopped&) {
      result_.stopped = true;
    }
    fed_ = false;
    if (begun_ && !result_.stopped)
      expect(foreign_ == 0, "all that it sends is of the session", std::to_string(foreign_) + " frames were not");
    stopping_ = true;
    for (int k = 0; k < 3 && begun_ && !result_.brought_to_rest; ++k) result_.brought_to_rest = answer_to(disarm()) == ANSWER_DONE;
    return result_;
  }

 private:
  struct Stopped {};

  void ask() {
    if (!begin()) return;
    telemetry_format();
    refusals();
    on_the_line();
    numbers();
    times();
    while_disarmed();
    if (can_arm()) {
      while_armed();
      silence(60, 60);
      silence(10'000, LIMIT_DEAD_MAN_ms);
    }
  }

  using Verdict = ConformFinding::Verdict;

  void say(Verdict verdict, const std::string& what, const std::string& detail = "") {
    ++(verdict == Verdict::good ? result_.good : verdict == Verdict::bad ? result_.bad : result_.left_out);
    if (settings_.say) settings_.say({verdict, what, detail});
  }
  bool expect(bool good, const std::string& what, const std::string& instead) {
    say(good ? Verdict::good : Verdict::bad, what, good ? "" : instead + (last_sent_.empty() ? "" : "\nsent last: " + hex(last_sent_)));
    return good;
  }

  // ---- the wire ----

  void put(Bytes wire) {
    now_us_ = link_.send(wire);
    last_sent_ = std::move(wire);
  }
  frame made(std::uint8_t type) {
    frame f{};
    f.version = FRAME_VERSION;
    f.type = type;
    f.session = session_;
    f.sequence = ++sequence_;
    f.time_us = board_now_us();
    return f;
  }
  // The board's clock now, by the telemetry that came last: some milliseconds behind.
  std::uint32_t board_now_us() const {
    return telemetry_ ? telemetry_frame_.time_us + static_cast<std::uint32_t>(now_us_ - telemetry_at_us_) : 0;
  }
  template <class Message>
  frame with(std::uint8_t type, void (*put_message)(frame*, const Message*), const Message& message) {
    frame f = made(type);
    put_message(&f, &message);
    return f;
  }
  frame command(std::uint16_t time_to_live_ms, std::uint16_t duty = 0) {
    message_command message{};
    std::fill_n(message.duty, parts_.coils, duty);
    message.time_to_live_ms = time_to_live_ms;
    frame f = made(FRAME_COMMAND);
    put_command(&f, &parts_, &message);
    return f;
  }
  frame arm(std::uint32_t firmware_hash, std::uint32_t limits) { return with<message_arm>(FRAME_ARM, put_arm, {firmware_hash, limits, 0}); }
  frame disarm() {
    frame f = made(FRAME_DISARM);
    put_disarm(&f);
    return f;
  }

  // In parts, so that a request to stop waits for none of the long ones.
  void take(std::int64_t deadline_us) {
    constexpr std::int64_t longest_us = 50 * ms;
    if (!stopping_ && settings_.should_stop && settings_.should_stop()) throw Stopped();
    take_until(std::min(deadline_us, now_us_ + longest_us));
  }
  void take_until(std::int64_t deadline_us) {
    const Received received = link_.receive_until(deadline_us);
    now_us_ = received.now_us;
    for (const std::uint8_t byte : received.bytes) {
      frame f{};
      const frame_result result = frame_decoder_take(&decoder_, byte, &f);
      refused_ += result == FRAME_REFUSED;
      if (result != FRAME_READY) continue;
      if (f.session != session_ || f.type < FRAME_HELLO) {
        foreign_ += f.session != session_;
        continue;
      }
      if (f.type == FRAME_TELEMETRY && board_parts_fit(&parts_)) {
        if (telemetry_ && f.sequence != telemetry_frame_sequence_seen_ + 1) ++gaps_;
        telemetry_.emplace();
        get_telemetry(&f, &parts_, &*telemetry_);
        telemetry_frame_ = f;
        telemetry_at_us_ = now_us_;
        ++telemetry_count_;
      }
      telemetry_frame_sequence_seen_ = f.sequence;
      heard_.push_back({f, now_us_});
    }
  }
  // Time passes; an armed board is fed with commands of no duty.
  void wait_us(std::int64_t time_us) {
    const std::int64_t until_us = now_us_ + time_us;
    while (now_us_ < until_us) {
      if (fed_ && now_us_ >= feed_at_us_) {
        const Bytes kept = last_sent_;
        put(wire_of(command(LIMIT_DEAD_MAN_ms)));
        last_sent_ = kept;
        feed_at_us_ = now_us_ + 40 * ms;
      }
      take(std::min(until_us, fed_ ? feed_at_us_ : until_us));
    }
  }
  std::optional<Heard> hear(std::uint8_t type, std::int64_t within_us) {
    const std::int64_t until_us = now_us_ + within_us;
    for (;;) {
      while (!heard_.empty()) {
        const Heard one = heard_.front();
        heard_.pop_front();
        if (one.f.type == type) return one;
      }
      if (now_us_ >= until_us) return std::nullopt;
      take(until_us);
    }
  }
  // What the board says from now on: the second telemetry frame, since the next may be on its way.
  const message_telemetry* fresh() {
    heard_.clear();
    for (int k = 0; k < 2; ++k)
      if (!hear(FRAME_TELEMETRY, 500 * ms)) return nullptr;
    return &*telemetry_;
  }
  std::optional<std::uint8_t> answer_to(const frame& f, std::int64_t within_us = 300 * ms) {
    heard_.clear();
    put(wire_of(f));
    while (const auto got = hear(FRAME_ANSWER, within_us)) {
      message_answer message;
      get_answer(&got->f, &message);
      if (message.type == f.type && message.sequence == f.sequence) return message.answer;
    }
    return std::nullopt;
  }
  bool answers(const frame& f, enum answer due, const std::string& what) {
    const auto got = answer_to(f);
    return expect(got == due, what, got ? "it answered " + std::to_string(*got) + " (" + said(*got) + ")" : "no answer within 300 ms");
  }
  static std::string said(std::uint8_t value) { return value <= ANSWER_SETTINGS ? std::string(words(static_cast<answer>(value))) : "?"; }

  // What is put adds to that counter and to no other; the board stays as it is.
  void counts(int counter, const std::string& what, const std::function<void()>& does, std::uint16_t by = 1) {
    const message_telemetry* const first = fresh();
    if (!first) return void(expect(false, what, "no telemetry"));
    const message_telemetry before = *first;
    does();
    const message_telemetry* const after = fresh();
    if (!after) return void(expect(false, what, "no telemetry afterwards"));
    std::string other;
    for (int k = 0; k < DEVICE_COUNTERS; ++k) {
      const int grew = after->counters[k] - before.counters[k];
      if (grew != (k == counter ? by : 0))
        other += (other.empty() ? "" : ", ") + std::string(counter_names[static_cast<std::size_t>(k)]) + " " + std::to_string(grew);
    }
    std::string changed;
    if (after->state != before.state)
      changed = "its state went from " + std::to_string(before.state) + " to " + std::to_string(after->state);
    expect(other.empty() && changed.empty(), what, changed.empty() ? "counters grew by: " + other : changed);
  }

  // ---- what is asked ----

  std::optional<message_hello> hello(std::uint8_t period_ms, std::int64_t within_us) {
    heard_.clear();
    put(wire_of(with<message_hello_request>(FRAME_HELLO_REQUEST, put_hello_request, {period_ms})));
    const std::int64_t asked_us = now_us_;
    const int foreign_before = foreign_;
    const auto got = hear(FRAME_HELLO, within_us);
    if (!got) return std::nullopt;
    foreign_ = foreign_before;  // what was on its way is of the session before
    hello_took_us_ = got->at_us - asked_us;
    message_hello message;
    get_hello(&got->f, &message);
    return message;
  }

  bool begin() {
    std::optional<message_hello> first;
    take(0);
    sequence_ = first_sequence;
    for (int k = 0; k < 25 && !first; ++k) first = hello(20, 200 * ms);
    if (!expect(first.has_value(), "hello_request: it says hello",
                decoder_.refused[FRAME_OTHER_VERSION] ? "it speaks another version than " + std::to_string(FRAME_VERSION)
                : refused_                            ? "bytes come, and no valid frame of this session among them"
                                                      : "nothing came within 5 s"))
      return false;
    const std::string misfit = misfit_of(first->parts);
    if (!expect(misfit.empty(), "hello: 1 to 8 coils, at most 8 thermocouples and angles", misfit)) return false;
    parts_ = decoder_.parts = first->parts;
    begun_ = true;
    wait_us(300 * ms);
    std::optional<message_hello> again;
    for (int k = 0; k < 3 && (!again || hello_took_us_ > 100 * ms); ++k) again = hello(20, 500 * ms);
    expect(again && hello_took_us_ <= 100 * ms, "hello: within 100 ms", again ? std::to_string(hello_took_us_ / ms) + " ms" : "none came");
    hello_ = again.value_or(*first);
    expect(hello_.state <= DEVICE_TRIPPED && hello_.trip_cause < TRIP_CAUSES && hello_.reset_cause <= RESET_UNKNOWN &&
               (hello_.state == DEVICE_TRIPPED) == (hello_.trip_cause != TRIP_NONE),
           "hello: state, trip cause and reset cause are among those of the page, and a cause there where it is tripped",
           "state " + std::to_string(hello_.state) + ", trip cause " + std::to_string(hello_.trip_cause) + ", reset cause " +
               std::to_string(hello_.reset_cause));
    expect(hello_.state != DEVICE_ARMED, "hello: a session begins disarmed", "it is armed");
    expect(hello_.limits_hash == limits_hash(parts_.coils), "hello: the hash of its limits is that of hil/limits.h for its coils",
           "it is another: `sinew hil` will not arm it");
    return true;
  }

  void telemetry_format() {
    const message_telemetry* const t = fresh();
    if (!expect(t != nullptr, "telemetry: comes, with the length for its parts",
                decoder_.refused[FRAME_BAD_LENGTH] ? "telemetry of another length" : "none within 500 ms"))
      return;
    std::string wrong;
    for (unsigned k = 0; k < parts_.coils; ++k)
      if (t->duty[k] != 0) wrong += " duty of coil " + std::to_string(k + 1) + " is " + std::to_string(t->duty[k]) + ";";
    expect(wrong.empty(), "telemetry: no duty while disarmed", wrong);
    wrong.clear();
    for (unsigned k = 0; k < parts_.thermocouples; ++k) {
      const auto shown = (static_cast<std::int32_t>(t->thermocouple_raw[k]) >> 18) * 25;
      if (t->sensor[k] >= TRIP_CAUSES) wrong += " unknown cause " + std::to_string(t->sensor[k]) + ";";
      if (t->sensor[k] == TRIP_NONE && t->temperature_cdegC[k] != shown)
        wrong += " thermocouple " + std::to_string(k + 1) + ": word says " + std::to_string(shown) + ", number " +
                 std::to_string(t->temperature_cdegC[k]) + ";";
    }
    expect(wrong.empty(), "telemetry: of each thermocouple the number is what its 32 bits say", wrong);
    wrong.clear();
    for (unsigned k = 0; k < parts_.angles; ++k)
      if (t->angle_fault[k] >= TRIP_CAUSES || t->angle_raw[k] > 16u * 1023u || std::abs(t->angle_cdeg[k]) > 18000)
        wrong += " angle " + std::to_string(k + 1) + ";";
    expect(wrong.empty(), "telemetry: angles within their ranges", wrong);
    std::uint16_t oldest_ms = 0;
    bool renewed = false;
    std::uint16_t last_ms = t->temperature_age_ms;
    for (int k = 0; k < 30 && hear(FRAME_TELEMETRY, 500 * ms); ++k) {
      oldest_ms = std::max(oldest_ms, telemetry_->temperature_age_ms);
      renewed = renewed || telemetry_->temperature_age_ms < last_ms;
      last_ms = telemetry_->temperature_age_ms;
    }
    expect(renewed && oldest_ms < LIMIT_READING_SILENCE_ms, "telemetry: readings are renewed, and none is 240 ms old",
           renewed ? std::to_string(oldest_ms) + " ms" : "they are not renewed");
  }

  void refusals() {
    const auto put_frame = [&](const std::function<void(frame&)>& change) {
      return [this, change] {
        frame f = disarm();
        change(f);
        put(wire_of(f));
      };
    };
    counts(FRAME_OTHER_VERSION, "another version is refused", put_frame([](frame& f) { f.version = FRAME_VERSION + 1; }));
    counts(FRAME_UNKNOWN_TYPE, "an unknown type is refused", put_frame([](frame& f) { f.type = 0x66; }));
    counts(FRAME_BAD_LENGTH, "a payload longer than its type's is refused", put_frame([](frame& f) { f.length = 1; }));
    counts(FRAME_BAD_LENGTH, "a command for one coil more is refused", [this] {
      frame f = command(LIMIT_DEAD_MAN_ms);
      f.length = static_cast<std::uint8_t>(f.length + 2);
      put(wire_of(f));
    });
    counts(FRAME_BAD_CHECK, "a frame with one bit turned is refused", [this] {
      Bytes wire = wire_of(disarm());
      // The type's byte: neither a zero nor a length before or after.
      wire[3] ^= 0x40;
      put(wire);
    });
    counts(FRAME_BAD_STUFFING, "a length of COBS that points past the end is refused", [this] { put({0, 5, 1, 0}); });
    counts(FRAME_TOO_SHORT, "a frame without room for header and check is refused", [this] { put(stuffed(Bytes{4, 3, 2, 1})); });
    counts(FRAME_TOO_LONG, "250 bytes without a zero are refused", [this] {
      Bytes wire(250, 0x55);
      wire.insert(wire.begin(), 0);
      wire.push_back(0);
      put(wire);
    });
  }

  void on_the_line() {
    counts(DEVICE_COUNTERS, "empty frames are nothing", [this] { put(Bytes(20, 0)); });
    const auto disarms = [&](const std::string& what, const std::function<void(const Bytes&)>& way) {
      const frame f = disarm();
      heard_.clear();
      way(wire_of(f));
      std::optional<std::uint8_t> got;
      while (const auto one = hear(FRAME_ANSWER, 300 * ms)) {
        message_answer message;
        get_answer(&one->f, &message);
        if (message.sequence == f.sequence && message.type == FRAME_DISARM) {
          got = message.answer;
          break;
        }
      }
      expect(got == ANSWER_DONE, what, got ? "it answered " + std::to_string(*got) : "no answer within 300 ms");
    };
    disarms("disarm: is answered with 0", [this](const Bytes& wire) { put(wire); });
    disarms("a frame that comes byte by byte is taken", [this](const Bytes& wire) {
      for (const std::uint8_t byte : wire) {
        put({byte});
        wait_us(2 * ms);
      }
    });
    disarms("half a frame, silence, and then a whole one: that is taken", [this](const Bytes& wire) {
      put({wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(wire.size() / 2)});
      wait_us(60 * ms);
      put(wire);
    });
    disarms("garbage before a frame takes no frame with it", [this](const Bytes& wire) {
      Bytes all{0x91, 0x02, 0xfe, 0x37, 0x11};
      all.insert(all.end(), wire.begin(), wire.end());
      put(all);
    });
  }

  void numbers() {
    counts(COUNT_OTHER_SESSION, "a frame of another session is dropped", [this] {
      frame f = disarm();
      f.session = static_cast<std::uint16_t>(session_ + 1);
      put(wire_of(f));
    });
    const Bytes same = wire_of(disarm());
    put(same);
    wait_us(60 * ms);
    counts(COUNT_OUT_OF_ORDER, "a frame that comes again is dropped", [&] { put(same); });
    counts(COUNT_OUT_OF_ORDER, "a sequence number behind the last one is dropped", [this] {
      frame f = disarm();
      f.sequence -= 5;
      put(wire_of(f));
    });
    // Across the end of the range, whatever has been sent until here.
    session_ = static_cast<std::uint16_t>(session_ + 1);
    sequence_ = 0xfffffffdu;
    expect(hello(20, 500 * ms).has_value(), "a new session forgets the sequence numbers of the one before", "no hello");
    bool all = true;
    for (int k = 0; k < 4; ++k) all = answer_to(disarm()) == ANSWER_DONE && all;
    expect(all, "sequence numbers wrap", "a disarm frame near the wrap was not answered");
  }

  void times() {
    for (const auto& [asked_ms, due] : {std::pair{20, 100}, std::pair{5, 400}}) {
      if (!hello(static_cast<std::uint8_t>(asked_ms), 500 * ms)) return void(expect(false, "hello again", "none"));
      wait_us(100 * ms);
      const int before = telemetry_count_, gaps = gaps_, refused = refused_;
      const std::uint32_t board_us = telemetry_frame_.time_us;
      const std::int64_t began_us = telemetry_at_us_;
      wait_us(2'000 * ms);
      const int came = telemetry_count_ - before;
      const double rate = (telemetry_frame_.time_us - board_us) / static_cast<double>(telemetry_at_us_ - began_us);
      const std::string period = std::to_string(asked_ms) + " ms";
      char text[80];
      std::snprintf(text, sizeof text, "%d in 2 s, %d gaps in their numbers, %d refused", came, gaps_ - gaps, refused_ - refused);
      expect(came >= due * 95 / 100 && came <= due * 105 / 100 && gaps_ == gaps && refused_ == refused,
             "telemetry: every " + period + ", numbered one by one, where that is asked", text);
      if (asked_ms != 20) continue;
      std::snprintf(text, sizeof text, "it gains %.2f %%", 100.0 * (rate - 1.0));
      expect(rate > 0.985 && rate < 1.015, "its clock is within 1 % of this machine's (measured to half a percent)", text);
    }
  }

  void while_disarmed() {
    counts(COUNT_NOT_ARMED, "a command while disarmed is dropped", [this] { put(wire_of(command(LIMIT_DEAD_MAN_ms))); });
    const message_telemetry* const t = fresh();
    expect(t && t->last_sequence != sequence_, "... and is not told as taken", "last_sequence is that of the dropped command");
    const auto wrong_settings = hello_.wrong_settings;
    if (hello_.state == DEVICE_TRIPPED) {
      const auto other = static_cast<std::uint8_t>(hello_.trip_cause == 1 ? 2 : 1);
      answers(with<message_clear_trip>(FRAME_CLEAR_TRIP, put_clear_trip, {other}), ANSWER_OTHER_CAUSE,
              "clear_trip of another cause: answered with 6");
      answers(arm(hello_.firmware_hash, hello_.limits_hash), wrong_settings ? ANSWER_SETTINGS : ANSWER_TRIPPED,
              wrong_settings ? "arm: with wrong settings, answered with 7" : "arm: while tripped, answered with 3");
    }
    answers(arm(hello_.firmware_hash ^ 1u, hello_.limits_hash), ANSWER_WRONG_FIRMWARE, "arm: for another firmware, answered with 1");
    answers(arm(hello_.firmware_hash, hello_.limits_hash ^ 1u), ANSWER_WRONG_LIMITS, "arm: for other limits, answered with 2");
    counts(COUNT_STALE, "arm: one that lay on its way for 300 ms is dropped", [this] {
      frame f = arm(hello_.firmware_hash, hello_.limits_hash);
      f.time_us -= 300'000;
      put(wire_of(f));
      heard_.clear();
    });
  }

  bool can_arm() {
    if (hello_.state == DEVICE_TRIPPED) {
      const std::string cause{words(static_cast<trip_cause>(hello_.trip_cause))};
      if (!settings_.clear_trip) {
        say(Verdict::left_out, "arming, commands and silence",
            "the board is tripped: " + cause + "; --clear-trip clears that, with cool coils");
        return false;
      }
      if (!answers(with<message_clear_trip>(FRAME_CLEAR_TRIP, put_clear_trip, {hello_.trip_cause}), ANSWER_DONE,
                   "clear_trip of its cause (" + cause + "): answered with 0"))
        return false;
    }
    const frame f = arm(hello_.firmware_hash, hello_.limits_hash);
    const auto got = answer_to(f);
    if (got == ANSWER_HOT || got == ANSWER_SENSOR || got == ANSWER_SETTINGS) {
      say(Verdict::left_out, "arming, commands and silence", "the board does not arm: " + said(*got));
      return false;
    }
    fed_ = got == ANSWER_DONE;
    return expect(got == ANSWER_DONE, "arm: with both hashes, answered with 0", got ? said(*got) : "no answer within 300 ms");
  }

  bool armed() {
    const message_telemetry* const t = fresh_fed();
    return t && t->state == DEVICE_ARMED;
  }
  const message_telemetry* fresh_fed() {
    wait_us(50 * ms);
    heard_.clear();
    return telemetry_ ? &*telemetry_ : nullptr;
  }
  // While it is fed: a frame that must be dropped adds to that counter, and is not told as taken.
  void dropped(int counter, const std::string& what, const std::function<void(frame&)>& change, std::uint16_t duty = 0) {
    if (!fresh_fed()) return void(expect(false, what, "no telemetry"));
    const message_telemetry before = *telemetry_;
    frame f = command(LIMIT_DEAD_MAN_ms, duty);
    change(f);
    put(wire_of(f));
    const message_telemetry after = *fresh_fed();
    const int grew = after.counters[counter] - before.counters[counter];
    expect(grew == 1 && after.state == DEVICE_ARMED, what,
           after.state != DEVICE_ARMED ? "it is no longer armed" : "its counter grew by " + std::to_string(grew));
  }

  void while_armed() {
    expect(armed(), "it is armed, and stays so while commands come", "state " + std::to_string(telemetry_ ? telemetry_->state : 255));
    const frame taken = command(LIMIT_DEAD_MAN_ms);
    put(wire_of(taken));
    feed_at_us_ = now_us_ + 100 * ms;
    bool told = false;
    for (int k = 0; k < 8 && !told && hear(FRAME_TELEMETRY, 50 * ms); ++k) told = telemetry_->last_sequence == taken.sequence;
    expect(told, "command: one of no duty is taken, and telemetry tells its number", "last_sequence stays another");
    dropped(COUNT_STALE, "command: older than its time to live, dropped", [](frame& f) { f.time_us -= 400'000; });
    dropped(COUNT_STALE, "command: 200 ms from the future, dropped", [](frame& f) { f.time_us += 200'000; });
    dropped(COUNT_OUT_OF_ORDER, "command: behind the last one, dropped", [](frame& f) { f.sequence -= 3; });
    dropped(COUNT_OTHER_SESSION, "command: of another session, dropped",
            [](frame& f) { f.session = static_cast<std::uint16_t>(f.session + 7); });
    if (settings_.coils_disconnected) {
      dropped(
          COUNT_TOO_MUCH_DUTY, "command: of too much duty, dropped whole", [](frame&) {}, LIMIT_HIGHEST_DUTY + 1);
    } else {
      say(Verdict::left_out, "command: of too much duty, dropped whole",
          "a board that is wrong would heat; --coils-disconnected says that it cannot");
    }
    session_ = static_cast<std::uint16_t>(session_ + 1);
    fed_ = false;
    const auto anew = hello(5, 500 * ms);
    expect(anew && anew->state == DEVICE_DISARMED, "hello_request: disarms an armed board",
           anew ? "state " + std::to_string(anew->state) : "none");
    wait_us(100 * ms);
    if (answers(arm(hello_.firmware_hash, hello_.limits_hash), ANSWER_DONE, "arm: again in the new session")) {
      answers(disarm(), ANSWER_DONE, "disarm: an armed board, answered with 0");
      wait_us(400 * ms);
      const message_telemetry* const t = fresh();
      expect(t && t->state == DEVICE_DISARMED, "disarm: what follows is no silence",
             t ? "state " + std::to_string(t->state) : "no telemetry");
    }
  }

  // Of one command's life, by the board's own clock: 5 ms of telemetry, and as much again.
  void silence(std::uint16_t asked_ms, std::uint16_t due_ms) {
    const std::string after = "a command of " + std::to_string(asked_ms) + " ms, then silence: ";
    if (answer_to(arm(hello_.firmware_hash, hello_.limits_hash)) != ANSWER_DONE) return void(expect(false, after + "arming", "not done"));
    fresh();
    const frame last = command(asked_ms);
    heard_.clear();
    put(wire_of(last));
    std::optional<double> tripped_ms;
    double armed_ms = 0.0;
    while (const auto got = hear(FRAME_TELEMETRY, 400 * ms)) {
      message_telemetry t{};
      get_telemetry(&got->f, &parts_, &t);
      const double passed_ms = static_cast<std::int32_t>(got->f.time_us - last.time_us) / 1e3;
      if (t.state == DEVICE_ARMED) armed_ms = passed_ms;
      if (t.state != DEVICE_ARMED) {
        tripped_ms = passed_ms;
        break;
      }
      if (passed_ms > 1000.0) break;
    }
    char text[96];
    std::snprintf(text, sizeof text, "armed until %.1f ms after it was made, %s %.1f ms", armed_ms,
                  tripped_ms ? "tripped at" : "and not tripped at", tripped_ms.value_or(armed_ms));
    expect(tripped_ms && telemetry_->state == DEVICE_TRIPPED && telemetry_->trip_cause == TRIP_SILENCE && *tripped_ms <= due_ms + 10.0 &&
               *tripped_ms >= due_ms - 5.0,
           after + "trips after " + std::to_string(due_ms) + " ms", text);
    answers(arm(hello_.firmware_hash, hello_.limits_hash), ANSWER_TRIPPED, after + "no arming, answered with 3");
    answers(with<message_clear_trip>(FRAME_CLEAR_TRIP, put_clear_trip, {TRIP_BROWN_OUT}), ANSWER_OTHER_CAUSE,
            after + "clear_trip of another cause, answered with 6");
    answers(with<message_clear_trip>(FRAME_CLEAR_TRIP, put_clear_trip, {TRIP_SILENCE}), ANSWER_DONE, after + "clear_trip, answered with 0");
    const message_telemetry* const t = fresh();
    expect(t && t->state == DEVICE_DISARMED && t->trip_cause == TRIP_NONE, after + "cleared, it is disarmed and not armed",
           t ? "state " + std::to_string(t->state) : "no telemetry");
  }

  Link& link_;
  const ConformSettings& settings_;
  ConformResult result_;
  frame_decoder decoder_{};
  board_parts parts_{};
  std::uint16_t session_ = 0x5101;
  std::uint32_t sequence_ = 0;
  std::int64_t now_us_ = 0;
  Bytes last_sent_;
  std::deque<Heard> heard_;
  message_hello hello_{};
  std::int64_t hello_took_us_ = 0;
  std::optional<message_telemetry> telemetry_;
  frame telemetry_frame_{};
  std::uint32_t telemetry_frame_sequence_seen_ = 0;
  std::int64_t telemetry_at_us_ = 0;
  int telemetry_count_ = 0, gaps_ = 0, refused_ = 0, foreign_ = 0;
  bool fed_ = false, begun_ = false, stopping_ = false;
  std::int64_t feed_at_us_ = 0;
};

}  // namespace

ConformResult conform(Link& link, const ConformSettings& settings) { return Conformance(link, settings).run(); }

}  // namespace sinew::hil
