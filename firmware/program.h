// SPDX-License-Identifier: Apache-2.0
/* The board's program without the board: the wire, the order of things, the latch. What decides about duty is in supervisor.h. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* After the board's pins, clock and port work. */
void program_start(void);

/* Takes the bytes that have come, and each millisecond does what is due; to be called whenever either may have. */
void program_round(void);

#ifdef __cplusplus
}
#endif
