// SPDX-License-Identifier: Apache-2.0
/* How the cause of a trip lies in two bytes of EEPROM. Plain C without hardware, so that the host's tests run it.
 *
 * A byte is erased to 0xff and then programmed: power that goes away meanwhile leaves any bits of it set. So no byte of a valid latch
 * is 0xff, the second is the complement of the first, and what is no valid latch is a trip: a board that was never cleared, too. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LATCH_BYTES 2u
#define LATCH_MARK 0x40u /* in the first byte, beside the cause; TRIP_NONE has no bit that another cause lacks */
#define LATCH_BYTE_0(cause) ((uint8_t)(LATCH_MARK | (cause)))
#define LATCH_BYTE_1(cause) ((uint8_t) ~(LATCH_MARK | (cause)))

/* The byte at `at`, 0 or 1. The first is written first. */
uint8_t latch_byte(uint8_t cause, uint8_t at);

/* The cause, TRIP_NONE or another; what is not valid is TRIP_LATCH_DAMAGED. */
uint8_t latch_cause(uint8_t byte_0, uint8_t byte_1);

#ifdef __cplusplus
}
#endif
