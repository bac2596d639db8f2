// SPDX-License-Identifier: Apache-2.0
/* The wire: frames between host and device. Plain C, no heap, no clock, no port; host and firmware compile this file.
 *
 *   frame = COBS(header, payload, CRC-32) 0x00
 *
 * Header, 12 bytes, little endian as all numbers here: version u8, type u8, session u16, sequence u32, time_us u32.
 * The CRC is that of IEEE 802.3 over header and payload. A payload has the one length of its type and of what the board has:
 * its coils, thermocouples and angles. COBS: Cheshire and Baker 1999. What other boards must do with these: docs/protocol.md. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FRAME_VERSION 4u

enum frame_type {
  /* to the device */
  FRAME_HELLO_REQUEST = 0x01,
  FRAME_ARM = 0x02,
  FRAME_DISARM = 0x03,
  FRAME_COMMAND = 0x04,
  FRAME_CLEAR_TRIP = 0x05,
  /* from the device */
  FRAME_HELLO = 0x81,
  FRAME_ANSWER = 0x82,
  FRAME_TELEMETRY = 0x83
};

/* Ways in which a frame is refused. Each has a counter of its own. */
enum frame_fault {
  FRAME_TOO_LONG,     /* more bytes than any frame has, before its 0x00 */
  FRAME_BAD_STUFFING, /* a COBS length points past the end */
  FRAME_TOO_SHORT,    /* no room for header and CRC */
  FRAME_BAD_CHECK,    /* the CRC is another */
  FRAME_OTHER_VERSION,
  FRAME_UNKNOWN_TYPE,
  FRAME_BAD_LENGTH, /* not the length of its type, for what the board has */
  FRAME_FAULTS
};

#define FRAME_HEADER_BYTES 12u
#define FRAME_CHECK_BYTES 4u
#define FRAME_PAYLOAD_MOST 178u /* telemetry of a board that has the most of all */
#define FRAME_PLAIN_MOST (FRAME_HEADER_BYTES + FRAME_PAYLOAD_MOST + FRAME_CHECK_BYTES)
#define FRAME_WIRE_MOST (FRAME_PLAIN_MOST + 2u) /* one COBS length, for fewer than 254 bytes, and the 0x00 */

/* What a board has. Commands and telemetry have an element for each, in the board's order. */
#define BOARD_PARTS_MOST 8u
struct board_parts {
  uint8_t coils;         /* 1 to BOARD_PARTS_MOST */
  uint8_t thermocouples; /* at most BOARD_PARTS_MOST */
  uint8_t angles;        /* at most BOARD_PARTS_MOST */
};
/* 1 where the wire can carry it, else 0. */
uint8_t board_parts_fit(const struct board_parts* parts);

struct frame {
  uint8_t version;
  uint8_t type;
  uint16_t session;  /* chosen by the host in its hello; 0: none yet */
  uint32_t sequence; /* grows by one a frame, each direction on its own */
  uint32_t time_us;  /* device's clock, from the host as it estimates that clock; wraps */
  uint8_t length;    /* of the payload */
  uint8_t payload[FRAME_PAYLOAD_MOST];
};

uint32_t frame_crc32(const uint8_t* bytes, uint16_t count);

/* The length that a payload of that type has. */
#define FRAME_NO_TYPE 0xffu    /* no such type */
#define FRAME_ANY_LENGTH 0xfeu /* a command or telemetry of a board of which nothing fit is known */
uint8_t frame_payload_length(uint8_t type, const struct board_parts* parts);

/* Writes the frame as it goes over the wire, its 0x00 included; at most FRAME_WIRE_MOST bytes. Returns how many. */
uint8_t frame_encode(const struct frame* frame, uint8_t* wire);

enum frame_result { FRAME_NOTHING, FRAME_READY, FRAME_REFUSED };

struct frame_decoder {
  uint8_t fill;
  uint8_t overflowed;
  struct board_parts parts;       /* no coils: not known yet */
  uint16_t refused[FRAME_FAULTS]; /* each stops at 65535 */
  uint8_t bytes[FRAME_WIRE_MOST];
};

/* A board begins with its own parts. A host begins with none, and sets `parts` by the first hello that it believes; until then
 * commands and telemetry of any length are whole frames, whose payload must not be read. */
void frame_decoder_start(struct frame_decoder* decoder, const struct board_parts* parts);

/* Takes one byte. FRAME_READY: `frame` is whole and valid. An empty frame (0x00 after 0x00) is nothing. */
enum frame_result frame_decoder_take(struct frame_decoder* decoder, uint8_t byte, struct frame* frame);

#ifdef __cplusplus
}
#endif
