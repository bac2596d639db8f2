// SPDX-License-Identifier: Apache-2.0
#include "hil/limits.h"

#include "hil/message.h"

uint32_t limits_hash(uint8_t coils) {
  static const int32_t values[] = {LIMIT_COIL_cdegC,
                                   LIMIT_TRIP_cdegC,
                                   LIMIT_HOST_cdegC,
                                   LIMIT_COOL_cdegC,
                                   LIMIT_COLDEST_cdegC,
                                   LIMIT_HIGHEST_DUTY,
                                   LIMIT_DEAD_MAN_ms,
                                   LIMIT_RISE_cK_s,
                                   LIMIT_JUMP_cK,
                                   LIMIT_JUNCTION_COLDEST_cdegC,
                                   LIMIT_JUNCTION_HOTTEST_cdegC,
                                   LIMIT_JUNCTION_JUMP_cK,
                                   LIMIT_STUCK_DEADBAND,
                                   LIMIT_STUCK_mK,
                                   LIMIT_STUCK_SURE_100,
                                   LIMIT_HEATING_mK_s,
                                   LIMIT_COOLING_1_ks,
                                   LIMIT_FOLLOW_WINDOW_ms,
                                   LIMIT_FOLLOW_LAG_ms,
                                   LIMIT_FOLLOW_EXPECTED_mK,
                                   LIMIT_UNEXPECTED_mK,
                                   LIMIT_FOLLOW_READINGS,
                                   LIMIT_UNEXPECTED_READINGS,
                                   LIMIT_BOUND_HEATING_mK_s,
                                   LIMIT_BOUND_COOLING_1_ks,
                                   LIMIT_BOUND_RISE_cK,
                                   LIMIT_BOUND_START_cK,
                                   LIMIT_ANGLE_LEAST_raw,
                                   LIMIT_ANGLE_MOST_raw,
                                   LIMIT_ANGLE_MOVED_raw,
                                   LIMIT_ANGLE_RANGE_cK,
                                   LIMIT_ANGLE_OTHERS_cK,
                                   LIMIT_ON_TIME_ms,
                                   LIMIT_ON_TIME_WINDOW_s,
                                   LIMIT_DRAIN_LOW_cV,
                                   LIMIT_DRAIN_LOW_ms,
                                   LIMIT_SUPPLY_cV,
                                   LIMIT_DRAIN_SETTLING_ms,
                                   LIMIT_READING_PERIOD_ms,
                                   LIMIT_READING_SILENCE_ms};
  uint8_t bytes[4 * (sizeof values / sizeof values[0] + 1)];
  uint8_t at = 0, i;
  for (i = 0; i < sizeof values / sizeof values[0]; ++i) put_u32(bytes, &at, (uint32_t)values[i]);
  put_u32(bytes, &at, coils);
  return frame_crc32(bytes, at);
}
