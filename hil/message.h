// SPDX-License-Identifier: Apache-2.0
/* What the payloads of frames say. Plain C, shared by host and firmware. Integers on the wire; units in the names:
 * duty in ten-thousandths, temperatures in hundredths of a degree Celsius, angles in hundredths of a degree. */
#pragma once

#include <stdint.h>

#include "hil/frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DUTY_ONE 10000u /* full on */

enum device_state { DEVICE_DISARMED = 0, DEVICE_ARMED = 1, DEVICE_TRIPPED = 2 };

/* Why the device took the duty away and will not give it back without being told to. */
enum trip_cause {
  TRIP_NONE = 0,
  TRIP_SILENCE = 1, /* no valid command for the time the last one was good for */
  TRIP_OVER_TEMPERATURE = 2,
  TRIP_RATE_OF_RISE = 3,
  TRIP_SENSOR_OPEN = 4,
  TRIP_SENSOR_SHORT_TO_GROUND = 5,
  TRIP_SENSOR_SHORT_TO_SUPPLY = 6,
  TRIP_SENSOR_ZEROS = 7,        /* all bits 0: no amplifier, or one without supply */
  TRIP_SENSOR_ONES = 8,         /* all bits 1: the data line hangs high */
  TRIP_SENSOR_GARBLED = 9,      /* a bit set that is always 0 */
  TRIP_SENSOR_RANGE = 10,       /* colder or hotter than the limb can be */
  TRIP_SENSOR_JUMP = 11,        /* faster than heat can do */
  TRIP_JUNCTION = 12,           /* cold junction out of range, or it jumped */
  TRIP_SENSOR_STUCK = 13,       /* the same reading over much heating */
  TRIP_NOT_FOLLOWING = 14,      /* heated and does not warm: swapped, fallen off, coil open */
  TRIP_UNEXPECTED_HEATING = 15, /* warms without duty: switch welded, sensors swapped */
  TRIP_ON_TIME = 16,            /* too much duty in the window */
  TRIP_SENSOR_SILENT = 17,      /* no reading in time */
  TRIP_MAIN_LOOP = 18,          /* the program did not come round; said by the timer's interrupt */
  TRIP_WATCHDOG = 19,           /* the same, said by the hardware watchdog */
  TRIP_BROWN_OUT = 20,
  TRIP_RESET_WHILE_ARMED = 21,
  TRIP_LATCH_DAMAGED = 22, /* the stored cause cannot be read: taken for a trip */
  TRIP_HEAT_BOUND = 23,    /* so much duty that a coil might be too hot, whatever its thermocouple says: heat_bound.h */
  TRIP_ANGLE_RANGE = 24,   /* an angle at the end of its range: 0 V or 5 V, unplugged */
  TRIP_ANGLE_STUCK = 25,   /* an angle that stays where heat must have moved it */
  TRIP_DRAIN_LOW = 26,     /* the drain of a switch stays low: it conducts unasked, or its coil is open, or there is no supply */
  TRIP_SUPPLY_HIGH = 27,   /* the drains show more supply than the bound of the heat allows for */
  TRIP_CAUSES
};

enum reset_cause { RESET_POWER_ON = 0, RESET_EXTERNAL = 1, RESET_BROWN_OUT = 2, RESET_WATCHDOG = 3, RESET_UNKNOWN = 4 };

/* What the device answers to arm, disarm and clear_trip. */
enum answer {
  ANSWER_DONE = 0,
  ANSWER_WRONG_FIRMWARE = 1,
  ANSWER_WRONG_LIMITS = 2,
  ANSWER_TRIPPED = 3,     /* clear the trip first */
  ANSWER_HOT = 4,         /* a coil is not cool yet */
  ANSWER_SENSOR = 5,      /* a sensor is not believed */
  ANSWER_OTHER_CAUSE = 6, /* the trip is another than the one that was to be cleared */
  ANSWER_SETTINGS = 7     /* the board itself is set wrongly: board_setting */
};

/* What a board found wrong with itself when it started, in bits: what its safety rests on and no program can mend. On an AVR these are
 * its fuses. */
enum board_setting {
  SETTING_BROWN_OUT = 1, /* the detector of a falling supply is off, or set lower than the processor needs at its clock */
  SETTING_WATCHDOG = 2   /* the watchdog may be turned off by the program, so by a program that has gone astray */
};

/* Counters of the device, each of 16 bits that stop at 65535: first the decoder's, then these. */
enum device_counter {
  COUNT_STALE = FRAME_FAULTS, /* older than its time to live, or from the future */
  COUNT_OUT_OF_ORDER,         /* repeated, or behind one that came before */
  COUNT_OTHER_SESSION,
  COUNT_NOT_ARMED,     /* a command while disarmed or tripped */
  COUNT_TOO_MUCH_DUTY, /* a command beyond the highest duty: dropped whole */
  COUNT_LOST_BYTES,    /* receive buffer full, overrun or framing error in the UART */
  DEVICE_COUNTERS
};

struct message_hello_request {
  uint8_t telemetry_period_ms;
};
struct message_arm {
  uint32_t firmware_hash;
  uint32_t limits_hash;
  uint8_t flags;
};
#define ARM_ANGLE_FAULTS_TRIP 1u /* in flags: an angle that is not believed ends the session, and refuses to arm; else it is said only */
struct message_command {
  uint16_t duty[BOARD_PARTS_MOST]; /* of each coil */
  uint16_t time_to_live_ms;        /* from the frame's time_us on */
};
struct message_clear_trip {
  uint8_t cause; /* the one that is to be cleared */
};
struct message_hello {
  uint32_t firmware_hash;
  uint32_t limits_hash;
  uint8_t reset_cause;
  uint8_t state;
  uint8_t trip_cause;
  struct board_parts parts;
  uint8_t wrong_settings; /* bits of board_setting; 0: none */
};
struct message_answer {
  uint8_t type; /* of the frame that is answered */
  uint8_t answer;
  uint32_t sequence; /* of the frame that is answered */
};
struct message_telemetry {
  uint32_t last_sequence; /* of the last command that was taken */
  uint8_t state;
  uint8_t trip_cause;
  /* Of each thermocouple: a trip_cause, why it is not believed; TRIP_NONE: it is. */
  uint8_t sensor[BOARD_PARTS_MOST];
  uint8_t angle_fault[BOARD_PARTS_MOST];       /* of each angle: the same */
  uint16_t duty[BOARD_PARTS_MOST];             /* of each coil, at the pins */
  uint32_t thermocouple_raw[BOARD_PARTS_MOST]; /* of each thermocouple, the 32 bits of the MAX31855 */
  int32_t temperature_cdegC[BOARD_PARTS_MOST];
  uint16_t bound_rise_cK[BOARD_PARTS_MOST]; /* of each coil, its rise over the room at the most: heat_bound.h */
  uint16_t temperature_age_ms;              /* since they were read from the amplifiers */
  uint16_t angle_raw[BOARD_PARTS_MOST];     /* of each angle, sum of ADC conversions */
  int16_t angle_cdeg[BOARD_PARTS_MOST];
  uint16_t counters[DEVICE_COUNTERS];
};

#define MESSAGE_HELLO_REQUEST_BYTES 1u
#define MESSAGE_ARM_BYTES 9u
#define MESSAGE_COMMAND_BYTES(parts) ((uint8_t)(2u + 2u * (parts)->coils))
#define MESSAGE_CLEAR_TRIP_BYTES 1u
#define MESSAGE_HELLO_BYTES 15u
#define MESSAGE_HELLO_COILS_AT 11u /* the byte of the payload at which `parts` begin */
#define MESSAGE_ANSWER_BYTES 6u
#define MESSAGE_TELEMETRY_BYTES(parts) \
  ((uint8_t)(8u + 4u * (parts)->coils + 9u * (parts)->thermocouples + 5u * (parts)->angles + 2u * (unsigned)DEVICE_COUNTERS))

/* Each put_ fills type, length and payload of a frame; each get_ reads the payload of a frame of that type. `parts` must fit, and for
 * get_ be those that the decoder of the frame had. */
void put_hello_request(struct frame* frame, const struct message_hello_request* message);
void put_arm(struct frame* frame, const struct message_arm* message);
void put_disarm(struct frame* frame);
void put_command(struct frame* frame, const struct board_parts* parts, const struct message_command* message);
void put_clear_trip(struct frame* frame, const struct message_clear_trip* message);
void put_hello(struct frame* frame, const struct message_hello* message);
void put_answer(struct frame* frame, const struct message_answer* message);
void put_telemetry(struct frame* frame, const struct board_parts* parts, const struct message_telemetry* message);

void get_hello_request(const struct frame* frame, struct message_hello_request* message);
void get_arm(const struct frame* frame, struct message_arm* message);
void get_command(const struct frame* frame, const struct board_parts* parts, struct message_command* message);
void get_clear_trip(const struct frame* frame, struct message_clear_trip* message);
void get_hello(const struct frame* frame, struct message_hello* message);
void get_answer(const struct frame* frame, struct message_answer* message);
void get_telemetry(const struct frame* frame, const struct board_parts* parts, struct message_telemetry* message);

/* Little endian; `at` moves on. */
void put_u16(uint8_t* bytes, uint8_t* at, uint16_t value);
void put_u32(uint8_t* bytes, uint8_t* at, uint32_t value);
uint16_t get_u16(const uint8_t* bytes, uint8_t* at);
uint32_t get_u32(const uint8_t* bytes, uint8_t* at);

#ifdef __cplusplus
}
#endif
