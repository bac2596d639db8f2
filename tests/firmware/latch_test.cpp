// SPDX-License-Identifier: Apache-2.0
#include "firmware/latch.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include "hil/message.h"

namespace firmware_latch_test {

namespace {

// All that a byte may read as while it goes from one value to another: bits are set by the erasing in any order, and cleared by the
// programming in any order; power may go at each.
std::vector<std::uint8_t> on_the_way(std::uint8_t from, std::uint8_t to) {
  std::vector<std::uint8_t> all;
  for (int value = 0; value < 256; ++value)
    if ((value & from) == from || (value & to) == to) all.push_back(static_cast<std::uint8_t>(value));
  return all;
}

}  // namespace

TEST_CASE("latch: every cause reads back, and an erased or a zeroed pair of bytes is a trip") {
  for (std::uint8_t cause = 0; cause < TRIP_CAUSES; ++cause) CHECK(latch_cause(latch_byte(cause, 0), latch_byte(cause, 1)) == cause);
  CHECK(latch_cause(0xff, 0xff) == TRIP_LATCH_DAMAGED);
  CHECK(latch_cause(0x00, 0xff) == TRIP_LATCH_DAMAGED);  // what said "no trip" once
  CHECK(latch_cause(0x00, 0x00) == TRIP_LATCH_DAMAGED);
}

TEST_CASE("latch: of all 65536 pairs of bytes one alone says that there is no trip, and none with an erased byte is valid") {
  int none = 0;
  for (int pair = 0; pair < 0x10000; ++pair) {
    const auto first = static_cast<std::uint8_t>(pair >> 8), second = static_cast<std::uint8_t>(pair);
    const std::uint8_t cause = latch_cause(first, second);
    none += cause == TRIP_NONE;
    REQUIRE((cause == TRIP_LATCH_DAMAGED || (first != 0xff && second != 0xff)));
    REQUIRE(cause < TRIP_CAUSES);
  }
  CHECK(none == 1);
}

TEST_CASE("latch: power that goes at any step of storing a trip leaves a trip, once the first bit has changed") {
  for (std::uint8_t cause = 1; cause < TRIP_CAUSES; ++cause) {
    for (const std::uint8_t first : on_the_way(latch_byte(TRIP_NONE, 0), latch_byte(cause, 0))) {
      REQUIRE((first == latch_byte(TRIP_NONE, 0) || latch_cause(first, latch_byte(TRIP_NONE, 1)) != TRIP_NONE));
    }
    for (const std::uint8_t second : on_the_way(latch_byte(TRIP_NONE, 1), latch_byte(cause, 1))) {
      REQUIRE(latch_cause(latch_byte(cause, 0), second) != TRIP_NONE);
    }
  }
}

TEST_CASE("latch: power that goes while one cause is stored over another, or while a new board's first is, leaves a trip") {
  for (std::uint8_t before = 1; before < TRIP_CAUSES; ++before)
    for (std::uint8_t cause = 1; cause < TRIP_CAUSES; ++cause) {
      for (const std::uint8_t first : on_the_way(latch_byte(before, 0), latch_byte(cause, 0))) {
        REQUIRE((latch_cause(first, latch_byte(before, 1)) != TRIP_NONE));
      }
      for (const std::uint8_t second : on_the_way(latch_byte(before, 1), latch_byte(cause, 1))) {
        REQUIRE(latch_cause(latch_byte(cause, 0), second) != TRIP_NONE);
      }
    }
  for (std::uint8_t cause = 1; cause < TRIP_CAUSES; ++cause)
    for (const std::uint8_t first : on_the_way(0xff, latch_byte(cause, 0))) {
      REQUIRE(latch_cause(first, 0xff) == TRIP_LATCH_DAMAGED);
    }
}

TEST_CASE("latch: power that goes while a trip is cleared leaves a trip until the second byte says that there is none") {
  for (std::uint8_t before = 1; before < TRIP_CAUSES; ++before) {
    for (const std::uint8_t first : on_the_way(latch_byte(before, 0), latch_byte(TRIP_NONE, 0))) {
      REQUIRE((latch_cause(first, latch_byte(before, 1)) != TRIP_NONE));
    }
    for (const std::uint8_t second : on_the_way(latch_byte(before, 1), latch_byte(TRIP_NONE, 1))) {
      REQUIRE((second == latch_byte(TRIP_NONE, 1) || latch_cause(latch_byte(TRIP_NONE, 0), second) == TRIP_LATCH_DAMAGED));
    }
  }
}

}  // namespace firmware_latch_test
