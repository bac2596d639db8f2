// SPDX-License-Identifier: Apache-2.0
/* What this board has: its hello says so, and a host with the plant of another limb refuses it. Pins: main.c. */
#pragma once

#define BOARD_COILS 2u
#define BOARD_THERMOCOUPLES BOARD_COILS /* the supervisor watches each coil by one */
#define BOARD_ANGLES 1u
