// SPDX-License-Identifier: Apache-2.0
#include "sim/plain_text.h"

#include <doctest/doctest.h>

namespace sim_plain_text_test {

using sinew::sim::is_plain_text;

TEST_CASE("plain text: names in UTF-8 are, line ends and other control characters are not") {
  CHECK(is_plain_text(""));
  CHECK(is_plain_text("recording 7.csv"));
  CHECK(is_plain_text("Übung/Größe/測定/\xf0\x9f\xa6\xbe.csv"));
  for (const char* text : {"a\nb", "a\tb", "\x1b[31m", "a\x7f", "\xc2\x85", "\xe2\x80\xa8"}) CHECK_FALSE(is_plain_text(text));
}

TEST_CASE("plain text: bytes that are no UTF-8 are not") {
  // Latin-1; cut short; a longer form than is needed; a surrogate; beyond the last character; a byte that only continues.
  for (const char* text : {"Gr\xf6\xdf"
                           "e",
                           "\xe2\x82", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\x80", "\xff"})
    CHECK_FALSE(is_plain_text(text));
}

}  // namespace sim_plain_text_test
