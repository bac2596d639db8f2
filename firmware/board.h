// SPDX-License-Identifier: Apache-2.0
/* What a board has, and what it must offer to the program (program.h), which decides and knows no register. A board of another processor is
 * one file that defines these functions and main(): atmega328p.c for the chip, linux.c for a program on a pseudo-terminal.
 *
 * Only board_gates() gives power. It must also be taken away without the program: by the board's own timer when board_round_done()
 * stays away for LATE_ROUND_ms, by a watchdog after some more, and by whatever pulls the gates down when the pins are let go of. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The hello says so, and a host with the plant of another limb refuses it. */
#define BOARD_COILS 2u
#define BOARD_THERMOCOUPLES BOARD_COILS /* the supervisor watches each coil by one */
#define BOARD_ANGLES 1u

#define LATE_ROUND_ms 20u

/* The clock, since the start: both wrap, and agree. */
uint32_t board_ms(void);
uint32_t board_us(void);

/* Duty in ten-thousandths to the gates, 0: the pin is low and the timer lets go of it. Asked every millisecond: directions and timer are
 * written anew each time, so that a register that a disturbance changed is right again. Nothing reaches the pins while board_hung(). */
void board_gates(const uint16_t duty[BOARD_COILS]);
/* The relay's pin: swings by each call with 1, and is low from one with 0 on. A pin that stands still opens the relay. */
void board_relay(uint8_t swing);

/* The 32 bits of each MAX31855, at once. */
void board_amplifiers(uint32_t raw[BOARD_THERMOCOUPLES]);
/* Asked every millisecond: the sums of the last 16 conversions of each angle, without waiting for one. */
void board_angles(uint16_t raw[BOARD_ANGLES]);

/* An option of the board: dividers from the drain of each switch. What they showed since this was asked last, a sample of each every
 * millisecond, taken by the board itself whatever the program does meanwhile. Returns 0 where they are not fitted. */
struct board_drain {
  uint8_t samples, low; /* of these below LIMIT_DRAIN_LOW_cV */
  uint16_t highest_cV;
};
uint8_t board_drains(struct board_drain drains[BOARD_COILS]);

/* The serial port: the next byte, or -1; how many can be put now; puts them. Bytes that were lost on the way in are counted up to 65535. */
int16_t board_receive(void);
uint8_t board_send_room(void);
void board_send(const uint8_t* bytes, uint8_t count);
uint16_t board_lost_bytes(void);

/* The program has come round: the watchdog begins anew. */
void board_round_done(void);
/* The board took the power away since the program was late, perhaps before a reset; until board_forget_hung(). */
uint8_t board_hung(void);
void board_forget_hung(void);

uint8_t board_reset_cause(void);    /* enum reset_cause */
uint8_t board_wrong_settings(void); /* bits of enum board_setting */

/* Words that a reset leaves as they are, and that power-on fills with chance. */
#define BOARD_KEPT_WORDS (1u + 2u * BOARD_COILS)
volatile uint32_t* board_kept(void);

/* Bytes that power-off leaves as they are, LATCH_BYTES of them (latch.h). One is put only where the store is ready, and takes its time. */
uint8_t board_stored(uint8_t at);
uint8_t board_store_ready(void);
void board_store(uint8_t at, uint8_t value);

#ifdef __cplusplus
}
#endif
