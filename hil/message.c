// SPDX-License-Identifier: Apache-2.0
#include "hil/message.h"

void put_u16(uint8_t* bytes, uint8_t* at, uint16_t value) {
  bytes[(*at)++] = (uint8_t)value;
  bytes[(*at)++] = (uint8_t)(value >> 8);
}
void put_u32(uint8_t* bytes, uint8_t* at, uint32_t value) {
  put_u16(bytes, at, (uint16_t)value);
  put_u16(bytes, at, (uint16_t)(value >> 16));
}
uint16_t get_u16(const uint8_t* bytes, uint8_t* at) {
  const uint16_t low = bytes[(*at)++];
  const uint16_t high = bytes[(*at)++];
  return (uint16_t)(low | (uint16_t)(high << 8));
}
uint32_t get_u32(const uint8_t* bytes, uint8_t* at) {
  const uint32_t low = get_u16(bytes, at);
  const uint32_t high = get_u16(bytes, at);
  return low | (high << 16);
}

void put_hello_request(struct frame* frame, const struct message_hello_request* message) {
  frame->type = FRAME_HELLO_REQUEST;
  frame->length = MESSAGE_HELLO_REQUEST_BYTES;
  frame->payload[0] = message->telemetry_period_ms;
}
void get_hello_request(const struct frame* frame, struct message_hello_request* message) {
  message->telemetry_period_ms = frame->payload[0];
}

void put_arm(struct frame* frame, const struct message_arm* message) {
  uint8_t at = 0;
  frame->type = FRAME_ARM;
  put_u32(frame->payload, &at, message->firmware_hash);
  put_u32(frame->payload, &at, message->limits_hash);
  frame->payload[at++] = message->flags;
  frame->length = at;
}
void get_arm(const struct frame* frame, struct message_arm* message) {
  uint8_t at = 0;
  message->firmware_hash = get_u32(frame->payload, &at);
  message->limits_hash = get_u32(frame->payload, &at);
  message->flags = frame->payload[at++];
}

void put_disarm(struct frame* frame) {
  frame->type = FRAME_DISARM;
  frame->length = 0;
}

void put_command(struct frame* frame, const struct board_parts* parts, const struct message_command* message) {
  uint8_t at = 0, i;
  frame->type = FRAME_COMMAND;
  for (i = 0; i < parts->coils; ++i) put_u16(frame->payload, &at, message->duty[i]);
  put_u16(frame->payload, &at, message->time_to_live_ms);
  frame->length = at;
}
void get_command(const struct frame* frame, const struct board_parts* parts, struct message_command* message) {
  uint8_t at = 0, i;
  for (i = 0; i < parts->coils; ++i) message->duty[i] = get_u16(frame->payload, &at);
  message->time_to_live_ms = get_u16(frame->payload, &at);
}

void put_clear_trip(struct frame* frame, const struct message_clear_trip* message) {
  frame->type = FRAME_CLEAR_TRIP;
  frame->length = MESSAGE_CLEAR_TRIP_BYTES;
  frame->payload[0] = message->cause;
}
void get_clear_trip(const struct frame* frame, struct message_clear_trip* message) { message->cause = frame->payload[0]; }

void put_hello(struct frame* frame, const struct message_hello* message) {
  uint8_t at = 0;
  frame->type = FRAME_HELLO;
  put_u32(frame->payload, &at, message->firmware_hash);
  put_u32(frame->payload, &at, message->limits_hash);
  frame->payload[at++] = message->reset_cause;
  frame->payload[at++] = message->state;
  frame->payload[at++] = message->trip_cause;
  frame->payload[at++] = message->parts.coils;
  frame->payload[at++] = message->parts.thermocouples;
  frame->payload[at++] = message->parts.angles;
  frame->payload[at++] = message->wrong_settings;
  frame->length = at;
}
void get_hello(const struct frame* frame, struct message_hello* message) {
  uint8_t at = 0;
  message->firmware_hash = get_u32(frame->payload, &at);
  message->limits_hash = get_u32(frame->payload, &at);
  message->reset_cause = frame->payload[at++];
  message->state = frame->payload[at++];
  message->trip_cause = frame->payload[at++];
  message->parts.coils = frame->payload[at++];
  message->parts.thermocouples = frame->payload[at++];
  message->parts.angles = frame->payload[at++];
  message->wrong_settings = frame->payload[at++];
}

void put_answer(struct frame* frame, const struct message_answer* message) {
  uint8_t at = 0;
  frame->type = FRAME_ANSWER;
  frame->payload[at++] = message->type;
  frame->payload[at++] = message->answer;
  put_u32(frame->payload, &at, message->sequence);
  frame->length = at;
}
void get_answer(const struct frame* frame, struct message_answer* message) {
  uint8_t at = 0;
  message->type = frame->payload[at++];
  message->answer = frame->payload[at++];
  message->sequence = get_u32(frame->payload, &at);
}

void put_telemetry(struct frame* frame, const struct board_parts* parts, const struct message_telemetry* message) {
  uint8_t at = 0, i;
  frame->type = FRAME_TELEMETRY;
  put_u32(frame->payload, &at, message->last_sequence);
  frame->payload[at++] = message->state;
  frame->payload[at++] = message->trip_cause;
  for (i = 0; i < parts->thermocouples; ++i) frame->payload[at++] = message->sensor[i];
  for (i = 0; i < parts->angles; ++i) frame->payload[at++] = message->angle_fault[i];
  for (i = 0; i < parts->coils; ++i) put_u16(frame->payload, &at, message->duty[i]);
  for (i = 0; i < parts->thermocouples; ++i) put_u32(frame->payload, &at, message->thermocouple_raw[i]);
  for (i = 0; i < parts->thermocouples; ++i) put_u32(frame->payload, &at, (uint32_t)message->temperature_cdegC[i]);
  for (i = 0; i < parts->coils; ++i) put_u16(frame->payload, &at, message->bound_rise_cK[i]);
  put_u16(frame->payload, &at, message->temperature_age_ms);
  for (i = 0; i < parts->angles; ++i) put_u16(frame->payload, &at, message->angle_raw[i]);
  for (i = 0; i < parts->angles; ++i) put_u16(frame->payload, &at, (uint16_t)message->angle_cdeg[i]);
  for (i = 0; i < DEVICE_COUNTERS; ++i) put_u16(frame->payload, &at, message->counters[i]);
  frame->length = at;
}
void get_telemetry(const struct frame* frame, const struct board_parts* parts, struct message_telemetry* message) {
  uint8_t at = 0, i;
  message->last_sequence = get_u32(frame->payload, &at);
  message->state = frame->payload[at++];
  message->trip_cause = frame->payload[at++];
  for (i = 0; i < parts->thermocouples; ++i) message->sensor[i] = frame->payload[at++];
  for (i = 0; i < parts->angles; ++i) message->angle_fault[i] = frame->payload[at++];
  for (i = 0; i < parts->coils; ++i) message->duty[i] = get_u16(frame->payload, &at);
  for (i = 0; i < parts->thermocouples; ++i) message->thermocouple_raw[i] = get_u32(frame->payload, &at);
  for (i = 0; i < parts->thermocouples; ++i) message->temperature_cdegC[i] = (int32_t)get_u32(frame->payload, &at);
  for (i = 0; i < parts->coils; ++i) message->bound_rise_cK[i] = get_u16(frame->payload, &at);
  message->temperature_age_ms = get_u16(frame->payload, &at);
  for (i = 0; i < parts->angles; ++i) message->angle_raw[i] = get_u16(frame->payload, &at);
  for (i = 0; i < parts->angles; ++i) message->angle_cdeg[i] = (int16_t)get_u16(frame->payload, &at);
  for (i = 0; i < DEVICE_COUNTERS; ++i) message->counters[i] = get_u16(frame->payload, &at);
}
