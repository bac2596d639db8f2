// SPDX-License-Identifier: Apache-2.0
/* The board without a board: the whole program as a Linux process on a pseudo-terminal, for whoever has none. Behind its pins are two coils
 * that warm as hil/limits.h says and a limb that bends between them; for a limb of physics there is the emulator.
 *
 * Its time goes on in steps of a millisecond, each as soon as it is due; one that is late is caught up with. So a process that was stopped
 * finds its commands too old, as a board that heard nothing would, and it is never late by its own clock: what takes the power away from a
 * program that hangs, board_hung() and the watchdog, is not here, and neither is a reset. Nothing is heated. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pty.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "firmware/board.h"
#include "firmware/latch.h"
#include "firmware/program.h"
#include "hil/limits.h"
#include "hil/message.h"

#define BYTES_PER_ms 50 /* of the wire, at 500000 Bd */
static const double room_degC = 25.0;

static uint32_t time_ms;
static int port = -1;
static uint8_t received[BYTES_PER_ms], sent[1024];
static int received_count, received_at, sent_count;
static uint32_t kept[BOARD_KEPT_WORDS];
static uint8_t store[LATCH_BYTES] = {LATCH_BYTE_0(TRIP_NONE), LATCH_BYTE_1(TRIP_NONE)};
static const char* store_file;
static double duty_fraction[BOARD_COILS], coil_degC[BOARD_COILS];
static volatile sig_atomic_t stop;

uint32_t board_ms(void) { return time_ms; }
uint32_t board_us(void) { return time_ms * 1000u; }

void board_gates(const uint16_t duty[BOARD_COILS]) {
  for (unsigned j = 0; j < BOARD_COILS; ++j) duty_fraction[j] = duty[j] / (double)DUTY_ONE;
}
void board_relay(uint8_t swing) { (void)swing; }

/* What a MAX31855 would say: quarters of a degree, sixteenths for the cold junction. */
void board_amplifiers(uint32_t raw[BOARD_THERMOCOUPLES]) {
  for (unsigned j = 0; j < BOARD_THERMOCOUPLES; ++j)
    raw[j] = ((uint32_t)lround(coil_degC[j] * 4.0) & 0x3fffu) << 18 | ((uint32_t)lround(room_degC * 16.0) & 0xfffu) << 4;
}

/* Each coil pulls to its side as its wire turns to austenite: 45 degrees at most. */
void board_angles(uint16_t raw[BOARD_ANGLES]) {
  double pull[BOARD_COILS];
  for (unsigned j = 0; j < BOARD_COILS; ++j) pull[j] = 1.0 / (1.0 + exp((75.0 - coil_degC[j]) / 8.0));
  raw[0] = (uint16_t)lround(8184.0 + 45.0 * (pull[0] - pull[1]) * 16368.0 / 180.0);
}

uint8_t board_drains(struct board_drain drains[BOARD_COILS]) {
  (void)drains;
  return 0;
}

int16_t board_receive(void) { return received_at < received_count ? received[received_at++] : -1; }
uint8_t board_send_room(void) { return sent_count + 255 <= (int)sizeof sent ? 255 : 0; }
void board_send(const uint8_t* bytes, uint8_t count) {
  memcpy(sent + sent_count, bytes, count);
  sent_count += count;
}
uint16_t board_lost_bytes(void) { return 0; }

void board_round_done(void) {}
uint8_t board_hung(void) { return 0; }
void board_forget_hung(void) {}
uint8_t board_reset_cause(void) { return RESET_POWER_ON; }
uint8_t board_wrong_settings(void) { return 0; }
volatile uint32_t* board_kept(void) { return kept; }

uint8_t board_stored(uint8_t at) { return store[at]; }
uint8_t board_store_ready(void) { return 1; }
void board_store(uint8_t at, uint8_t value) {
  store[at] = value;
  if (store_file) {
    FILE* file = fopen(store_file, "wb");
    if (!file || fwrite(store, 1, sizeof store, file) != sizeof store) fprintf(stderr, "%s: cannot be written\n", store_file);
    if (file) fclose(file);
  }
}

static void move_limb(double step_s) {
  for (unsigned j = 0; j < BOARD_COILS; ++j)
    coil_degC[j] += step_s * 1e-3 * (LIMIT_HEATING_mK_s * duty_fraction[j] - LIMIT_COOLING_1_ks * (coil_degC[j] - room_degC));
}

static void on_signal(int signal) {
  (void)signal;
  stop = 1;
}

static int open_port(const char* link) {
  struct termios raw;
  char name[256];
  int theirs;
  memset(&raw, 0, sizeof raw);
  cfmakeraw(&raw);
  if (openpty(&port, &theirs, name, &raw, NULL) != 0) { /* `theirs` stays open, so that a host may come and go */
    fprintf(stderr, "sinew-board: no pseudo-terminal: %s\n", strerror(errno));
    return 1;
  }
  fcntl(port, F_SETFL, O_NONBLOCK);
  if (link) {
    struct stat there;
    /* A link of a board before, which was killed, goes; what anybody wrote stays. */
    if (lstat(link, &there) == 0 && S_ISLNK(there.st_mode)) unlink(link);
    if (symlink(name, link) != 0) {
      fprintf(stderr, "%s: cannot be made: %s\n", link, strerror(errno));
      return 2;
    }
  }
  printf("%s\n", link ? link : name);
  fflush(stdout);
  return 0;
}

/* Of a board that was never cleared where the file is not there yet. */
static void read_store(void) {
  FILE* file = fopen(store_file, "rb");
  memset(store, 0xff, sizeof store);
  if (!file) return;
  if (fread(store, 1, sizeof store, file) != sizeof store) memset(store, 0xff, sizeof store);
  fclose(file);
}

int main(int argc, char** argv) {
  const char* link = NULL;
  struct timespec next;
  for (int i = 1; i < argc; ++i) {
    if (strcmp(argv[i], "--link") == 0 && i + 1 < argc) {
      link = argv[++i];
    } else if (strcmp(argv[i], "--store") == 0 && i + 1 < argc) {
      store_file = argv[++i];
    } else {
      const int asked = strcmp(argv[i], "--help") == 0;
      fprintf(asked ? stdout : stderr,
              "usage: sinew-board [--link NAME] [--store FILE]\n"
              "The board's program on a pseudo-terminal, with two coils that warm as its limits say; prints its port.\n"
              "  --link NAME   a symbolic link to the pseudo-terminal\n"
              "  --store FILE  keeps the cause of a trip, as a board's EEPROM does; not there: a board that was never cleared\n"
              "Example:\n  sinew-board --link /tmp/limb &\n  sinew hil scenarios/step.yaml --port /tmp/limb\n");
      return asked ? 0 : 2;
    }
  }
  if (store_file) read_store();
  for (unsigned j = 0; j < BOARD_COILS; ++j) coil_degC[j] = room_degC;
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = on_signal;
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGHUP, &action, NULL);
  const int failed = open_port(link);
  if (failed) return failed;
  program_start();
  clock_gettime(CLOCK_MONOTONIC, &next);
  while (!stop) {
    next.tv_nsec += 1000000;
    if (next.tv_nsec >= 1000000000) {
      next.tv_nsec -= 1000000000;
      ++next.tv_sec;
    }
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
    const ssize_t got = read(port, received, sizeof received);
    received_count = got > 0 ? (int)got : 0;
    received_at = 0;
    ++time_ms;
    program_round();
    move_limb(1e-3);
    /* Nobody listens: lost, as on a wire. */
    if (sent_count > 0 && write(port, sent, (size_t)sent_count) < 0 && errno != EAGAIN && errno != EINTR) break;
    sent_count = 0;
  }
  if (link) unlink(link);
  return 0;
}
