// SPDX-License-Identifier: Apache-2.0
/* The board's program: ATmega328P at 16 MHz. What decides is in supervisor.c; here are the pins, the clock and the wire.
 *
 *   PB1 (OC1A)  gate of coil A          PB4 MISO, PB5 SCK   both MAX31855
 *   PB2 (OC1B)  gate of coil B          PD5, PD6            their chip selects, A and B
 *   PC0 (ADC0)  bend sensor             PD7                 500 Hz while armed: for a cut-off relay behind a charge pump
 *   PD0, PD1    UART, 500000 Bd 8N1
 *
 * Three things take the duty away when the program does not come round: the millisecond interrupt after 20 ms, where
 * interrupts still run; the hardware watchdog after 60 ms, where they do not, by a reset that lets go of the pins; and the
 * resistors that pull the gates to ground. The watchdog is in its pure reset mode: in interrupt-first mode a program that
 * hangs with interrupts off would never be reset (data sheet, section 10.8.2: only the vector clears WDIE). */
#include <avr/boot.h>
#include <avr/eeprom.h>
#include <avr/fuse.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <string.h>

#include "firmware/board.h"
#include "firmware/latch.h"
#include "firmware/supervisor.h"
#include "firmware_hash.h"
#include "hil/frame.h"
#include "hil/heat_bound.h"
#include "hil/message.h"

#if BOARD_COILS != 2 || BOARD_THERMOCOUPLES != BOARD_COILS || BOARD_ANGLES != 1
#error "pins and timer below are those of two coils, their thermocouples and one bend sensor"
#endif

#define PWM_TOP 19999u /* 100 Hz with 16 MHz / 8 */
#define LATE_MAIN_LOOP_ms 20u
#define ADC_CONVERSIONS 16u
#define RECEIVE_BYTES 128u /* powers of two */
#define SEND_BYTES 128u

/* Survive a reset. Power-on leaves chance in them, and a supply that sags turns bits: hence words of 32 bits. A word that is neither the
 * mark nor zero was damaged, and counts as set. */
#define ARMED_MARK 0x5a17c3e9ul
#define HANG_MARK 0xb74e6d12ul
static volatile uint32_t armed_mark __attribute__((section(".noinit")));
static volatile uint32_t hang_mark __attribute__((section(".noinit")));

/* The bounds of the coils' heat, each with its complement: a reset must not make hot coils cool. */
static uint32_t kept_bound_uK[BOARD_COILS] __attribute__((section(".noinit")));
static uint32_t kept_bound_check[BOARD_COILS] __attribute__((section(".noinit")));

/* latch.h. What stands here goes into the file for the EEPROM, which is not flashed with the program: the cells of a new board are erased,
 * and it is tripped until somebody clears it. */
static uint8_t EEMEM latched_cause[LATCH_BYTES] = {LATCH_BYTE_0(TRIP_NONE), LATCH_BYTE_1(TRIP_NONE)};

/* What the fuses must be; it goes into the .elf and not into the .hex: a programmer writes them once (docs/hardware.md). Crystal of 16 MHz,
 * no bootloader, watchdog always on (a program cannot turn it off), EEPROM kept when the chip is erased, brown-out at 4.3 V. */
FUSES = {
    .low = 0xff,
    .high = FUSE_SPIEN & FUSE_WDTON & FUSE_EESAVE & FUSE_BOOTSZ0 & FUSE_BOOTSZ1,
    .extended = FUSE_BODLEVEL0 & FUSE_BODLEVEL1,
};
#define BROWN_OUT_MASK 0x07u
#define BROWN_OUT_4V3 0x04u /* ATmega328P data sheet, tables 28-6 and 29-12 */

static uint8_t reset_flags __attribute__((section(".noinit")));
void save_reset_flags(void) __attribute__((naked, used, section(".init3")));
void save_reset_flags(void) {
  reset_flags = MCUSR;
  MCUSR = 0;
  wdt_enable(WDTO_60MS);
}

static volatile uint32_t time_ms;
static volatile uint8_t ms_since_round; /* of the main loop */
static uint8_t relay_may_swing;         /* at the next tick: a pin that is stuck, high or low, opens the relay */
static volatile uint8_t receive[RECEIVE_BYTES], receive_in, receive_out;
static volatile uint8_t send[SEND_BYTES], send_in, send_out;
static volatile uint16_t lost_bytes;

static const struct board_parts board = {BOARD_COILS, BOARD_THERMOCOUPLES, BOARD_ANGLES};
static struct supervisor supervisor;
static struct frame_decoder decoder;
static struct frame frame; /* received, then reused for what is sent */
static uint16_t session, counters[DEVICE_COUNTERS - FRAME_FAULTS];
static uint32_t last_sequence, last_command, sequence;
static uint8_t telemetry_period_ms = 20, stored_cause, stored_bytes = LATCH_BYTES, reset_cause;
static uint16_t angle_raw;

static void pins_off(void) {
  PORTB &= (uint8_t) ~(_BV(PB1) | _BV(PB2));
  TCCR1A = _BV(WGM11); /* both pins let go of by the timer: low */
}

ISR(TIMER0_COMPA_vect) {
  ++time_ms;
  if (ms_since_round >= LATE_MAIN_LOOP_ms) {
    pins_off();
    PORTD &= (uint8_t)~_BV(PD7);
    hang_mark = HANG_MARK;
  } else {
    ++ms_since_round;
  }
}

ISR(USART_RX_vect) {
  const uint8_t status = UCSR0A, byte = UDR0, next = (uint8_t)((receive_in + 1u) % RECEIVE_BYTES);
  if ((status & (_BV(FE0) | _BV(DOR0))) || next == receive_out) {
    if (lost_bytes != 0xffffu) ++lost_bytes;
    if (next == receive_out) return;
  }
  receive[receive_in] = byte;
  receive_in = next;
}

ISR(USART_UDRE_vect) {
  if (send_out == send_in) {
    UCSR0B &= (uint8_t)~_BV(UDRIE0);
  } else {
    UDR0 = send[send_out];
    send_out = (uint8_t)((send_out + 1u) % SEND_BYTES);
  }
}

static uint32_t now_us(void) {
  uint32_t ms;
  uint8_t steps;
  const uint8_t status = SREG;
  cli();
  ms = time_ms;
  steps = TCNT0;
  if (TIFR0 & _BV(OCF0A)) { /* the millisecond is over, its interrupt not served */
    steps = TCNT0;
    ++ms;
  }
  SREG = status;
  return ms * 1000u + steps * 4u;
}

/* Nothing is sent in parts: a frame for which there is no room is left out; the next telemetry is not far. A zero goes before
 * it too, so that what was cut off or garbled ahead of it ends there. */
static void send_frame(uint32_t time_us) {
  uint8_t wire[1u + FRAME_WIRE_MOST], i, count;
  frame.version = FRAME_VERSION;
  frame.session = session;
  frame.sequence = ++sequence;
  frame.time_us = time_us;
  wire[0] = 0;
  count = (uint8_t)(1u + frame_encode(&frame, wire + 1));
  if ((uint8_t)((send_out - send_in - 1u) % SEND_BYTES) < count) return;
  for (i = 0; i < count; ++i) {
    send[send_in] = wire[i];
    send_in = (uint8_t)((send_in + 1u) % SEND_BYTES);
  }
  UCSR0B |= _BV(UDRIE0);
}

static void send_hello(uint32_t time_us) {
  const struct message_hello hello = {.firmware_hash = SINEW_FIRMWARE_HASH,
                                      .limits_hash = limits_hash(BOARD_COILS),
                                      .reset_cause = reset_cause,
                                      .state = supervisor.state,
                                      .trip_cause = supervisor.trip_cause,
                                      .parts = board,
                                      .wrong_settings = supervisor.wrong_settings};
  put_hello(&frame, &hello);
  send_frame(time_us);
}

static void send_answer(uint8_t type, uint8_t answer, uint32_t to, uint32_t time_us) {
  const struct message_answer message = {type, answer, to};
  put_answer(&frame, &message);
  send_frame(time_us);
}

static void send_telemetry(uint32_t time_us) {
  struct message_telemetry telemetry;
  uint8_t j;
  telemetry.last_sequence = last_command;
  telemetry.state = supervisor.state;
  telemetry.trip_cause = supervisor.trip_cause;
  for (j = 0; j < BOARD_COILS; ++j) {
    const struct thermocouple* const t = &supervisor.thermocouple[j];
    telemetry.sensor[j] = t->fault;
    telemetry.duty[j] = supervisor.duty[j];
    telemetry.thermocouple_raw[j] = t->raw;
    telemetry.temperature_cdegC[j] = t->temperature_cdegC;
    telemetry.bound_rise_cK[j] = heat_bound_cK(supervisor.bound_uK[j]);
  }
  telemetry.temperature_age_ms = (uint16_t)((time_us - supervisor.last_reading_us) / 1000u);
  telemetry.angle_raw[0] = angle_raw;
  telemetry.angle_fault[0] = supervisor.angle[0].fault;
  /* 16 conversions of 1023 over 180 degrees, zero in the middle; each is cut off, not rounded: half a step, 8 in all. */
  telemetry.angle_cdeg[0] = (int16_t)(((int32_t)angle_raw + 8 - 8184) * 18000 / 16368);
  for (j = 0; j < FRAME_FAULTS; ++j) telemetry.counters[j] = decoder.refused[j];
  for (; j < DEVICE_COUNTERS; ++j) telemetry.counters[j] = counters[j - FRAME_FAULTS];
  cli();
  telemetry.counters[COUNT_LOST_BYTES] = lost_bytes;
  sei();
  put_telemetry(&frame, &board, &telemetry);
  send_frame(time_us);
}

static void keep_bounds(void) {
  uint8_t j;
  for (j = 0; j < BOARD_COILS; ++j) {
    kept_bound_uK[j] = supervisor.bound_uK[j];
    kept_bound_check[j] = ~kept_bound_uK[j];
  }
}

/* After power-on, or a reset in the middle of keeping them, the supervisor's own beginning holds. */
static void take_kept_bounds(void) {
  uint8_t j;
  if (reset_flags & _BV(PORF)) return;
  for (j = 0; j < BOARD_COILS; ++j)
    if (kept_bound_uK[j] == ~kept_bound_check[j]) supervisor.bound_uK[j] = kept_bound_uK[j];
}

static void count(uint8_t counter) {
  if (counters[counter - FRAME_FAULTS] != 0xffffu) ++counters[counter - FRAME_FAULTS];
}

static uint8_t latch_is_stored(void) { return supervisor.trip_cause == stored_cause && stored_bytes == LATCH_BYTES && eeprom_is_ready(); }

/* Written anew at each tick: a register that a disturbance changed is right again a millisecond later. */
static void set_directions_and_timer(void) {
  DDRB = _BV(PB1) | _BV(PB2) | _BV(PB3) | _BV(PB5);
  DDRD = _BV(PD5) | _BV(PD6) | _BV(PD7);
  PORTB &= (uint8_t) ~(_BV(PB1) | _BV(PB2));
  ICR1 = PWM_TOP;
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS11);
}

static void set_pins(void) {
  uint16_t a, b;
  uint8_t connected = _BV(WGM11);
  a = supervisor.duty[0];
  b = supervisor.duty[1];
  /* A compare value of 0 would still give a pulse of one count, so zero duty lets go of the pin. */
  if (a) connected |= _BV(COM1A1);
  if (b) connected |= _BV(COM1B1);
  cli();
  set_directions_and_timer();
  if (hang_mark == 0) {
    if (a) OCR1A = (uint16_t)(a * 2u - 1u);
    if (b) OCR1B = (uint16_t)(b * 2u - 1u);
    TCCR1A = connected;
  }
  sei();
  if (supervisor.state == DEVICE_ARMED) {
    relay_may_swing = 1;
  } else {
    relay_may_swing = 0;
    PORTD &= (uint8_t)~_BV(PD7);
  }
  /* Until a trip is stored, a reset must still find that there was one: a cell reads as erased while it is written. */
  armed_mark = supervisor.state == DEVICE_ARMED || (supervisor.state == DEVICE_TRIPPED && !latch_is_stored()) ? ARMED_MARK : 0;
}

static void obey(uint32_t time_us) {
  const uint32_t heard = frame.sequence;
  const uint8_t type = frame.type;
  if (type >= FRAME_HELLO) { /* a device's frame: an echo on the line */
    count(COUNT_OTHER_SESSION);
    return;
  }
  if (type == FRAME_HELLO_REQUEST) {
    struct message_hello_request request;
    get_hello_request(&frame, &request);
    supervisor_disarm(&supervisor);
    set_pins();
    session = frame.session;
    last_sequence = heard;
    last_command = 0;
    telemetry_period_ms = request.telemetry_period_ms < 3u ? 3u : request.telemetry_period_ms;
    send_hello(time_us);
    return;
  }
  if (session == 0 || frame.session != session) {
    count(COUNT_OTHER_SESSION);
    return;
  }
  if ((int32_t)(heard - last_sequence) <= 0) {
    count(COUNT_OUT_OF_ORDER);
    return;
  }
  last_sequence = heard;
  if (type == FRAME_COMMAND) {
    struct message_command command;
    get_command(&frame, &board, &command);
    switch (supervisor_command(&supervisor, &command, frame.time_us, time_us)) {
      case COMMAND_TAKEN:
        last_command = heard;
        break;
      case COMMAND_STALE:
        count(COUNT_STALE);
        break;
      case COMMAND_NOT_ARMED:
        count(COUNT_NOT_ARMED);
        break;
      case COMMAND_TOO_MUCH:
        count(COUNT_TOO_MUCH_DUTY);
        break;
    }
  } else if (type == FRAME_ARM) {
    struct message_arm arm;
    enum answer answer;
    get_arm(&frame, &arm);
    /* One that lay somewhere on its way is of a host that may be gone. */
    if ((int32_t)(time_us - frame.time_us) >= (int32_t)(LIMIT_DEAD_MAN_ms * 1000ul)) {
      count(COUNT_STALE);
      return;
    }
    if (arm.firmware_hash != SINEW_FIRMWARE_HASH) {
      answer = ANSWER_WRONG_FIRMWARE;
    } else if (arm.limits_hash != limits_hash(BOARD_COILS)) {
      answer = ANSWER_WRONG_LIMITS;
    } else {
      supervisor.angle_faults_trip = arm.flags & ARM_ANGLE_FAULTS_TRIP;
      answer = supervisor_arm(&supervisor, time_us);
    }
    send_answer(type, answer, heard, time_us);
  } else if (type == FRAME_DISARM) {
    supervisor_disarm(&supervisor);
    set_pins();
    send_answer(type, ANSWER_DONE, heard, time_us);
  } else if (type == FRAME_CLEAR_TRIP) {
    struct message_clear_trip clear;
    get_clear_trip(&frame, &clear);
    send_answer(type, supervisor_clear_trip(&supervisor, clear.cause), heard, time_us);
  }
}

static uint8_t spi(void) {
  SPDR = 0;
  while (!(SPSR & _BV(SPIF))) {
  }
  return SPDR;
}

static uint32_t read_amplifier(uint8_t select) {
  uint32_t raw = 0;
  uint8_t i;
  PORTD &= (uint8_t)~select;
  for (i = 0; i < 4; ++i) raw = (raw << 8) | spi();
  PORTD |= select;
  return raw;
}

/* One conversion a millisecond, without waiting for it; the angle is the sum of the last sixteen. */
static void read_angle(void) {
  static uint16_t last[ADC_CONVERSIONS];
  static uint8_t at;
  if (ADCSRA & _BV(ADSC)) return;
  angle_raw = (uint16_t)(angle_raw - last[at]);
  last[at] = ADC;
  angle_raw = (uint16_t)(angle_raw + last[at]);
  at = (uint8_t)((at + 1u) % ADC_CONVERSIONS);
  ADCSRA |= _BV(ADSC);
}

/* One byte a round, and only when the cells are ready: a write takes 3.4 ms and must not hold up the loop. */
static void store_latch(void) {
  if (supervisor.trip_cause != stored_cause) {
    stored_cause = supervisor.trip_cause;
    stored_bytes = 0;
  }
  if (stored_bytes < LATCH_BYTES && eeprom_is_ready()) {
    eeprom_update_byte(&latched_cause[stored_bytes], latch_byte(stored_cause, stored_bytes));
    ++stored_bytes;
  }
}

static uint8_t cause_at_start(void) {
  const uint8_t was_armed = armed_mark != 0 && !(reset_flags & _BV(PORF));
  const uint8_t hung = hang_mark != 0 && !(reset_flags & _BV(PORF));
  const uint8_t latched = latch_cause(eeprom_read_byte(&latched_cause[0]), eeprom_read_byte(&latched_cause[1]));
  if (reset_flags & _BV(PORF)) {
    reset_cause = RESET_POWER_ON;
  } else if (reset_flags & _BV(WDRF)) {
    reset_cause = RESET_WATCHDOG;
  } else if (reset_flags & _BV(BORF)) {
    reset_cause = RESET_BROWN_OUT;
  } else if (reset_flags & _BV(EXTRF)) {
    reset_cause = RESET_EXTERNAL;
  } else {
    reset_cause = RESET_UNKNOWN;
  }
  uint8_t cause = latched;
  if (cause == TRIP_NONE) {
    if (hung) {
      cause = TRIP_MAIN_LOOP;
    } else if (reset_cause == RESET_WATCHDOG) {
      cause = TRIP_WATCHDOG;
    } else if (was_armed) {
      cause = reset_cause == RESET_BROWN_OUT ? TRIP_BROWN_OUT : TRIP_RESET_WHILE_ARMED;
    }
  }
  /* The next reset may come before this trip is stored. */
  armed_mark = cause == TRIP_NONE ? 0 : ARMED_MARK;
  hang_mark = 0;
  stored_cause = latched;
  return cause;
}

/* The fuses themselves, not what they should be. A bootloader is allowed. */
static uint8_t wrong_settings(void) {
  uint8_t wrong = 0;
  if ((boot_lock_fuse_bits_get(GET_EXTENDED_FUSE_BITS) & BROWN_OUT_MASK) != BROWN_OUT_4V3) wrong |= SETTING_BROWN_OUT;
  if (boot_lock_fuse_bits_get(GET_HIGH_FUSE_BITS) & (uint8_t)~FUSE_WDTON) wrong |= SETTING_WATCHDOG; /* 0: programmed */
  return wrong;
}

static void start_hardware(void) {
  PORTB = 0;
  PORTD = _BV(PD5) | _BV(PD6);
  SPCR = _BV(SPE) | _BV(MSTR) | _BV(SPR0); /* 1 MHz, mode 0 */
  ADMUX = _BV(REFS0);
  ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1); /* 250 kHz: 52 us a conversion */
  TCCR1A = _BV(WGM11);                                      /* fast PWM up to ICR1, pins not connected */
  set_directions_and_timer();
  OCR0A = 249; /* 1 ms */
  TCCR0A = _BV(WGM01);
  TCCR0B = _BV(CS01) | _BV(CS00);
  TIMSK0 = _BV(OCIE0A);
  UCSR0A = _BV(U2X0);
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UBRR0 = 3; /* 500000 Bd, exactly */
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

int main(void) {
  uint32_t last_ms = 0;
  uint16_t reading_in_ms = LIMIT_READING_PERIOD_ms; /* the first conversion needs its time */
  uint8_t telemetry_in_ms = 20;
  start_hardware();
  frame_decoder_start(&decoder, &board);
  supervisor_start(&supervisor, cause_at_start(), 0);
  take_kept_bounds();
  supervisor.wrong_settings = wrong_settings();
  set_sleep_mode(SLEEP_MODE_IDLE);
  sei();
  for (;;) {
    uint32_t ms;
    while (receive_out != receive_in) {
      const uint8_t byte = receive[receive_out];
      receive_out = (uint8_t)((receive_out + 1u) % RECEIVE_BYTES);
      if (frame_decoder_take(&decoder, byte, &frame) == FRAME_READY) obey(now_us());
    }
    cli();
    ms = time_ms;
    sei();
    if (ms != last_ms) {
      const uint8_t passed = (uint8_t)(ms - last_ms);
      last_ms = ms;
      if (hang_mark != 0) supervisor_trip(&supervisor, TRIP_MAIN_LOOP); /* came round after all, too late */
      supervisor_tick(&supervisor, now_us());
      keep_bounds();
      set_pins();
      if (reading_in_ms <= passed) {
        uint32_t raw[BOARD_COILS];
        raw[0] = read_amplifier(_BV(PD5));
        raw[1] = read_amplifier(_BV(PD6));
        supervisor_reading(&supervisor, raw, now_us());
        supervisor_angles(&supervisor, &angle_raw);
        set_pins();
        reading_in_ms = LIMIT_READING_PERIOD_ms;
      } else {
        reading_in_ms = (uint16_t)(reading_in_ms - passed);
      }
      read_angle();
      if (telemetry_in_ms <= passed) {
        if (session != 0) send_telemetry(now_us());
        telemetry_in_ms = telemetry_period_ms;
      } else {
        telemetry_in_ms = (uint8_t)(telemetry_in_ms - passed);
      }
      if (relay_may_swing) PIND = _BV(PD7); /* toggles */
      store_latch();
      if (supervisor.state == DEVICE_TRIPPED && latch_is_stored()) hang_mark = 0;
      ms_since_round = 0;
      wdt_reset();
    }
    cli();
    if (receive_out == receive_in && time_ms == last_ms) {
      sleep_enable();
      sei();
      sleep_cpu(); /* the instruction after sei runs before any interrupt */
      sleep_disable();
    }
    sei();
  }
}
