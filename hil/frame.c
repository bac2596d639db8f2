// SPDX-License-Identifier: Apache-2.0
#include "hil/frame.h"

#include <string.h>

#include "hil/message.h"

/* Four bits a step: a table of 64 bytes instead of one of a kilobyte, of which the device has two. */
uint32_t frame_crc32(const uint8_t* bytes, uint16_t count) {
  static const uint32_t table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                     0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
  uint32_t crc = 0xffffffffu;
  while (count--) {
    crc ^= *bytes++;
    crc = (crc >> 4) ^ table[crc & 15u];
    crc = (crc >> 4) ^ table[crc & 15u];
  }
  return ~crc;
}

uint8_t board_parts_fit(const struct board_parts* parts) {
  return parts->coils >= 1 && parts->coils <= BOARD_PARTS_MOST && parts->thermocouples <= BOARD_PARTS_MOST &&
         parts->angles <= BOARD_PARTS_MOST;
}

uint8_t frame_payload_length(uint8_t type, const struct board_parts* parts) {
  switch (type) {
    case FRAME_HELLO_REQUEST:
      return MESSAGE_HELLO_REQUEST_BYTES;
    case FRAME_ARM:
      return MESSAGE_ARM_BYTES;
    case FRAME_DISARM:
      return 0;
    case FRAME_COMMAND:
      return board_parts_fit(parts) ? MESSAGE_COMMAND_BYTES(parts) : FRAME_ANY_LENGTH;
    case FRAME_CLEAR_TRIP:
      return MESSAGE_CLEAR_TRIP_BYTES;
    case FRAME_HELLO:
      return MESSAGE_HELLO_BYTES;
    case FRAME_ANSWER:
      return MESSAGE_ANSWER_BYTES;
    case FRAME_TELEMETRY:
      return board_parts_fit(parts) ? MESSAGE_TELEMETRY_BYTES(parts) : FRAME_ANY_LENGTH;
    default:
      return FRAME_NO_TYPE;
  }
}

uint8_t frame_encode(const struct frame* frame, uint8_t* wire) {
  uint8_t plain[FRAME_PLAIN_MOST];
  uint8_t count = 0, i, length_at = 0, out = 1;
  plain[count++] = frame->version;
  plain[count++] = frame->type;
  put_u16(plain, &count, frame->session);
  put_u32(plain, &count, frame->sequence);
  put_u32(plain, &count, frame->time_us);
  memcpy(plain + count, frame->payload, frame->length);
  count = (uint8_t)(count + frame->length);
  put_u32(plain, &count, frame_crc32(plain, count));
  /* Every zero becomes the distance to the next; none is left. */
  for (i = 0; i < count; ++i) {
    if (plain[i] == 0) {
      wire[length_at] = (uint8_t)(out - length_at);
      length_at = out++;
    } else {
      wire[out++] = plain[i];
    }
  }
  wire[length_at] = (uint8_t)(out - length_at);
  wire[out++] = 0;
  return out;
}

void frame_decoder_start(struct frame_decoder* decoder, const struct board_parts* parts) {
  memset(decoder, 0, sizeof *decoder);
  if (parts) decoder->parts = *parts;
}

static enum frame_result refuse(struct frame_decoder* decoder, enum frame_fault fault) {
  if (decoder->refused[fault] != 0xffffu) ++decoder->refused[fault];
  return FRAME_REFUSED;
}

/* In place: what is written never passes what is read. Returns 0 where the stuffing is wrong. */
static uint8_t unstuff(uint8_t* bytes, uint8_t count) {
  uint8_t in = 0, out = 0;
  while (in < count) {
    const uint8_t distance = bytes[in++];
    uint8_t i;
    if ((uint16_t)in + distance - 1u > count) return 0;
    for (i = 1; i < distance; ++i) bytes[out++] = bytes[in++];
    if (in < count) bytes[out++] = 0;
  }
  return out;
}

static enum frame_result finish(struct frame_decoder* decoder, struct frame* frame) {
  uint8_t* const bytes = decoder->bytes;
  uint8_t at = 0, check_at, length, due;
  const uint8_t stuffed = decoder->fill;
  decoder->fill = 0;
  if (decoder->overflowed) {
    decoder->overflowed = 0;
    return refuse(decoder, FRAME_TOO_LONG);
  }
  if (stuffed == 0) return FRAME_NOTHING;
  length = unstuff(bytes, stuffed);
  if (length == 0) return refuse(decoder, stuffed == 1 && bytes[0] == 1 ? FRAME_TOO_SHORT : FRAME_BAD_STUFFING);
  if (length < FRAME_HEADER_BYTES + FRAME_CHECK_BYTES) return refuse(decoder, FRAME_TOO_SHORT);
  check_at = (uint8_t)(length - FRAME_CHECK_BYTES);
  if (get_u32(bytes, &check_at) != frame_crc32(bytes, (uint16_t)(length - FRAME_CHECK_BYTES))) return refuse(decoder, FRAME_BAD_CHECK);
  if (bytes[0] != FRAME_VERSION) return refuse(decoder, FRAME_OTHER_VERSION);
  due = frame_payload_length(bytes[1], &decoder->parts);
  if (due == FRAME_NO_TYPE) return refuse(decoder, FRAME_UNKNOWN_TYPE);
  if (due != FRAME_ANY_LENGTH && length - FRAME_HEADER_BYTES - FRAME_CHECK_BYTES != due) return refuse(decoder, FRAME_BAD_LENGTH);
  frame->version = bytes[at++];
  frame->type = bytes[at++];
  frame->session = get_u16(bytes, &at);
  frame->sequence = get_u32(bytes, &at);
  frame->time_us = get_u32(bytes, &at);
  frame->length = (uint8_t)(length - FRAME_HEADER_BYTES - FRAME_CHECK_BYTES);
  memcpy(frame->payload, bytes + FRAME_HEADER_BYTES, frame->length);
  return FRAME_READY;
}

enum frame_result frame_decoder_take(struct frame_decoder* decoder, uint8_t byte, struct frame* frame) {
  if (byte == 0) return finish(decoder, frame);
  if (decoder->fill >= FRAME_WIRE_MOST - 1u) {
    decoder->overflowed = 1;
  } else {
    decoder->bytes[decoder->fill++] = byte;
  }
  return FRAME_NOTHING;
}
