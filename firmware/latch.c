// SPDX-License-Identifier: Apache-2.0
#include "firmware/latch.h"

#include "hil/message.h"

typedef char causes_fit_beside_the_mark[TRIP_CAUSES <= 0x20 ? 1 : -1];

uint8_t latch_byte(uint8_t cause, uint8_t at) { return at == 0 ? LATCH_BYTE_0(cause) : LATCH_BYTE_1(cause); }

uint8_t latch_cause(uint8_t byte_0, uint8_t byte_1) {
  const uint8_t cause = (uint8_t)(byte_0 & (uint8_t)~LATCH_MARK);
  if (!(byte_0 & LATCH_MARK) || (byte_0 ^ byte_1) != 0xff || cause >= TRIP_CAUSES) return TRIP_LATCH_DAMAGED;
  return cause;
}
