// SPDX-License-Identifier: Apache-2.0
// `sinew conform` finds what is wrong with a board, and nothing wrong with one that is right.
#include "hil/conform.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/hil/fake_board.h"

namespace hil_conform_test {

using namespace sinew::hil;

namespace {

struct Heard {
  ConformResult result;
  std::vector<std::string> bad;
};

Heard asked(FakeBoard& board, bool coils_disconnected = false) {
  Heard heard;
  ConformSettings settings;
  settings.clear_trip = true;
  settings.coils_disconnected = coils_disconnected;
  settings.say = [&](const ConformFinding& finding) {
    INFO(finding.what, ": ", finding.detail);
    if (finding.verdict == ConformFinding::Verdict::bad) heard.bad.push_back(finding.what);
  };
  heard.result = conform(board, settings);
  return heard;
}

bool names(const Heard& heard, const std::string& words) {
  for (const std::string& one : heard.bad)
    if (one.find(words) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("conform: a board as the page says passes, and no coil of it had duty") {
  FakeBoard board;
  const Heard heard = asked(board);
  CHECK_MESSAGE(heard.bad.empty(), (heard.bad.empty() ? "" : heard.bad.front()));
  CHECK(heard.result.good > 50);
  CHECK(heard.result.left_out == 1);  // too much duty
  CHECK(board.last_on_us == -1);
  CHECK(board.s.state == DEVICE_DISARMED);
}

TEST_CASE("conform: a board that answers and never speaks of itself fails, and breaks nothing") {
  FakeBoard board;
  board.says_nothing = board.arms_for_anybody = board.never_silent = true;
  const Heard heard = asked(board, true);
  CHECK(names(heard, "telemetry: comes"));
  CHECK(names(heard, "command: of too much duty"));
  CHECK(board.s.state != DEVICE_ARMED);
}

TEST_CASE("conform: asked to stop, at whatever moment, it asks nothing more and disarms the board") {
  FakeBoard whole;
  asked(whole);
  for (int share_100 = 0; share_100 < 100; share_100 += 3) {
    const std::int64_t after_us = whole.now_us * share_100 / 100;
    CAPTURE(after_us);
    FakeBoard board;
    ConformSettings settings;
    bool said_after = false, stop = false;
    settings.should_stop = [&] {
      stop = stop || board.now_us >= after_us;
      return stop;
    };
    settings.say = [&](const ConformFinding&) { said_after = said_after || stop; };
    const ConformResult result = conform(board, settings);
    CHECK(result.stopped);
    CHECK_FALSE(said_after);
    CHECK(result.brought_to_rest == (after_us > 0));
    CHECK(board.s.state != DEVICE_ARMED);
  }
}

TEST_CASE("conform: with the coils off, too much duty is tried too") {
  FakeBoard board;
  const Heard heard = asked(board, true);
  CHECK(heard.bad.empty());
  CHECK(heard.result.left_out == 0);
  CHECK(board.counters[COUNT_TOO_MUCH_DUTY] == 1);
}

TEST_CASE("conform: a board that is tripped is cleared by name, and its refusals are asked for first") {
  FakeBoard board;
  supervisor_trip(&board.s, TRIP_SENSOR_OPEN);
  const Heard heard = asked(board);
  CHECK(heard.bad.empty());
  CHECK(heard.result.left_out == 1);
}

TEST_CASE("conform: each fault of a board is found under its name") {
  struct Case {
    const char* words;
    void (*break_it)(FakeBoard&);
  };
  for (const Case& one : {
           Case{"clock is within 1 %", [](FakeBoard& b) { b.device_rate = 1.03; }},
           Case{"disarm: is answered", [](FakeBoard& b) { b.swallow_answers_to = FRAME_DISARM; }},
           Case{"hash of its limits", [](FakeBoard& b) { b.limits ^= 1u; }},
           Case{"1 to 8 coils", [](FakeBoard& b) { b.parts.coils = 9; }},
           Case{"for another firmware", [](FakeBoard& b) { b.arms_for_anybody = true; }},
           Case{"comes again is dropped", [](FakeBoard& b) { b.takes_again = true; }},
           Case{"trips after 60 ms", [](FakeBoard& b) { b.never_silent = true; }},
           Case{"says hello", [](FakeBoard& b) { b.swallows_all = true; }},
       }) {
    FakeBoard board;
    one.break_it(board);
    const Heard heard = asked(board);
    CHECK_MESSAGE(names(heard, one.words), one.words);
    CHECK(board.last_on_us == -1);
  }
}

}  // namespace hil_conform_test
