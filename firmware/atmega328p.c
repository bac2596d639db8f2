// SPDX-License-Identifier: Apache-2.0
/* The board with an ATmega328P at 16 MHz: pins, clock, port, watchdog and EEPROM.
 *
 *   PB1 (OC1A)  gate of coil A          PB4 MISO, PB5 SCK   both MAX31855
 *   PB2 (OC1B)  gate of coil B          PD5, PD6            their chip selects, A and B
 *   PC0 (ADC0)  bend sensor             PD7                 500 Hz while armed: for a cut-off relay behind a charge pump
 *   PC1, PC2    an option: the drains of both switches by dividers of 22 k and 10 k; PC3 to ground says that they are there
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

#include "firmware/board.h"
#include "firmware/latch.h"
#include "firmware/program.h"
#include "hil/limits.h"
#include "hil/message.h"

#if BOARD_COILS != 2 || BOARD_THERMOCOUPLES != BOARD_COILS || BOARD_ANGLES != 1
#error "pins and timer below are those of two coils, their thermocouples and one bend sensor"
#endif

#define PWM_TOP 19999u /* 100 Hz with 16 MHz / 8 */
#define ADC_CONVERSIONS 16u
#define RECEIVE_BYTES 128u /* powers of two */
#define SEND_BYTES 128u

/* Survive a reset. A word that is neither the mark nor zero was damaged, and counts as set. */
#define HANG_MARK 0xb74e6d12ul
static volatile uint32_t hang_mark __attribute__((section(".noinit")));
static volatile uint32_t kept[BOARD_KEPT_WORDS] __attribute__((section(".noinit")));

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
static volatile uint8_t receive[RECEIVE_BYTES], receive_in, receive_out;
static volatile uint8_t send[SEND_BYTES], send_in, send_out;
static volatile uint32_t lost_bytes; /* up to 65535 */

/* One after the other each millisecond: the bend sensor, and the drains where there are dividers. */
static volatile uint8_t converting; /* the ADC's channel */
static volatile uint16_t bend;
static volatile uint8_t bend_converted;
static volatile struct {
  uint8_t samples, low;
  uint16_t highest;
} drains[BOARD_COILS];
/* 5 V are 1024, and the dividers show 10 of 32. */
#define DRAIN_cV(raw) ((uint16_t)((raw)*25u / 16u))
#define DRAIN_LOW (LIMIT_DRAIN_LOW_cV * 16u / 25u)

static uint8_t has_dividers(void) { return (PINC & _BV(PC3)) == 0; }

ISR(ADC_vect) {
  const uint16_t raw = ADC;
  const uint8_t channel = converting;
  if (channel == 0) {
    bend = raw;
    bend_converted = 1;
  } else if (drains[channel - 1u].samples != 255u) {
    ++drains[channel - 1u].samples;
    if (raw < DRAIN_LOW) ++drains[channel - 1u].low;
    if (raw > drains[channel - 1u].highest) drains[channel - 1u].highest = raw;
  }
  converting = channel < BOARD_COILS && has_dividers() ? (uint8_t)(channel + 1u) : 0;
  ADMUX = (uint8_t)(_BV(REFS0) | converting);
  if (converting) ADCSRA |= _BV(ADSC);
}

ISR(TIMER0_COMPA_vect) {
  ++time_ms;
  /* Writing to ADCSRA would take back a conversion's interrupt that waits. */
  if (!(ADCSRA & (_BV(ADSC) | _BV(ADIF)))) ADCSRA |= _BV(ADSC);
  if (ms_since_round >= LATE_ROUND_ms) {
    PORTB &= (uint8_t) ~(_BV(PB1) | _BV(PB2));
    TCCR1A = _BV(WGM11); /* both pins let go of by the timer: low */
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

/* A word that an interrupt writes. */
static uint32_t whole(const volatile uint32_t* word) {
  uint32_t value;
  cli();
  value = *word;
  sei();
  return value;
}

uint32_t board_ms(void) { return whole(&time_ms); }

uint32_t board_us(void) {
  uint32_t ms;
  uint8_t steps;
  cli();
  ms = time_ms;
  steps = TCNT0;
  if (TIFR0 & _BV(OCF0A)) { /* the millisecond is over, its interrupt not served */
    steps = TCNT0;
    ++ms;
  }
  sei();
  return ms * 1000u + steps * 4u;
}

/* Written anew at each tick: a register that a disturbance changed is right again a millisecond later. */
static void set_directions_and_timer(void) {
  DDRC = 0;
  PORTC = _BV(PC3);
  DDRB = _BV(PB1) | _BV(PB2) | _BV(PB3) | _BV(PB5);
  DDRD = _BV(PD5) | _BV(PD6) | _BV(PD7);
  PORTB &= (uint8_t) ~(_BV(PB1) | _BV(PB2));
  ICR1 = PWM_TOP;
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS11);
}

void board_gates(const uint16_t duty[BOARD_COILS]) {
  const uint16_t a = duty[0], b = duty[1];
  uint8_t connected = _BV(WGM11);
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
}

void board_relay(uint8_t swing) {
  if (swing) {
    PIND = _BV(PD7); /* toggles */
  } else {
    PORTD &= (uint8_t)~_BV(PD7);
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

void board_amplifiers(uint32_t raw[BOARD_THERMOCOUPLES]) {
  raw[0] = read_amplifier(_BV(PD5));
  raw[1] = read_amplifier(_BV(PD6));
}

void board_angles(uint16_t raw[BOARD_ANGLES]) {
  static uint16_t last[ADC_CONVERSIONS];
  static uint8_t at;
  uint16_t now;
  if (!bend_converted) return;
  cli();
  now = bend;
  bend_converted = 0;
  sei();
  raw[0] = (uint16_t)(raw[0] - last[at] + now);
  last[at] = now;
  at = (uint8_t)((at + 1u) % ADC_CONVERSIONS);
}

uint8_t board_drains(struct board_drain shown[BOARD_COILS]) {
  uint8_t j;
  if (!has_dividers()) return 0;
  for (j = 0; j < BOARD_COILS; ++j) {
    uint16_t highest;
    cli();
    shown[j].samples = drains[j].samples;
    shown[j].low = drains[j].low;
    highest = drains[j].highest;
    drains[j].samples = drains[j].low = 0;
    drains[j].highest = 0;
    sei();
    shown[j].highest_cV = DRAIN_cV(highest);
  }
  return 1;
}

int16_t board_receive(void) {
  uint8_t byte;
  if (receive_out == receive_in) return -1;
  byte = receive[receive_out];
  receive_out = (uint8_t)((receive_out + 1u) % RECEIVE_BYTES);
  return byte;
}

uint8_t board_send_room(void) { return (uint8_t)((send_out - send_in - 1u) % SEND_BYTES); }

void board_send(const uint8_t* bytes, uint8_t count) {
  uint8_t i;
  for (i = 0; i < count; ++i) {
    send[send_in] = bytes[i];
    send_in = (uint8_t)((send_in + 1u) % SEND_BYTES);
  }
  UCSR0B |= _BV(UDRIE0);
}

uint16_t board_lost_bytes(void) { return (uint16_t)whole(&lost_bytes); }

void board_round_done(void) {
  ms_since_round = 0;
  wdt_reset();
}
uint8_t board_hung(void) { return hang_mark != 0; }
void board_forget_hung(void) { hang_mark = 0; }

uint8_t board_reset_cause(void) {
  if (reset_flags & _BV(PORF)) return RESET_POWER_ON;
  if (reset_flags & _BV(WDRF)) return RESET_WATCHDOG;
  if (reset_flags & _BV(BORF)) return RESET_BROWN_OUT;
  if (reset_flags & _BV(EXTRF)) return RESET_EXTERNAL;
  return RESET_UNKNOWN;
}

/* The fuses themselves, not what they should be. A bootloader is allowed. */
uint8_t board_wrong_settings(void) {
  uint8_t wrong = 0;
  if ((boot_lock_fuse_bits_get(GET_EXTENDED_FUSE_BITS) & BROWN_OUT_MASK) != BROWN_OUT_4V3) wrong |= SETTING_BROWN_OUT;
  if (boot_lock_fuse_bits_get(GET_HIGH_FUSE_BITS) & (uint8_t)~FUSE_WDTON) wrong |= SETTING_WATCHDOG; /* 0: programmed */
  return wrong;
}

volatile uint32_t* board_kept(void) { return kept; }

uint8_t board_stored(uint8_t at) { return eeprom_read_byte(&latched_cause[at]); }
uint8_t board_store_ready(void) { return eeprom_is_ready() != 0; }
void board_store(uint8_t at, uint8_t value) { eeprom_update_byte(&latched_cause[at], value); }

static void start_hardware(void) {
  PORTB = 0;
  PORTD = _BV(PD5) | _BV(PD6);
  SPCR = _BV(SPE) | _BV(MSTR) | _BV(SPR0); /* 1 MHz, mode 0 */
  ADMUX = _BV(REFS0);
  ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS1); /* 250 kHz: 52 us a conversion */
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
  uint32_t rested_ms = 0;
  start_hardware();
  program_start();
  set_sleep_mode(SLEEP_MODE_IDLE);
  sei();
  for (;;) {
    program_round();
    cli();
    if (receive_out == receive_in && time_ms == rested_ms) {
      sleep_enable();
      sei();
      sleep_cpu(); /* the instruction after sei runs before any interrupt */
      sleep_disable();
    }
    rested_ms = time_ms;
    sei();
  }
}
