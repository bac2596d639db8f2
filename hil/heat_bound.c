// SPDX-License-Identifier: Apache-2.0
#include "hil/heat_bound.h"

#include "hil/limits.h"

uint32_t heat_bound_after(uint32_t rise_uK, uint32_t duty_ms, uint16_t step_ms) {
  /* Duty 1 over a millisecond is H mK/s * 1 ms = H uK. Both are divided by 100 first, so that products stay below 2^32. */
  const uint32_t heat_uK = (duty_ms + 99u) / 100u * (uint32_t)(LIMIT_BOUND_HEATING_mK_s / 100);
  const uint32_t loss_uK = rise_uK / 1000u * (uint32_t)LIMIT_BOUND_COOLING_1_ks / 10u * step_ms / 100u;
  return rise_uK - loss_uK + heat_uK;
}

uint16_t heat_bound_cK(uint32_t rise_uK) {
  const uint32_t rise_cK = (rise_uK + 9999u) / 10000u;
  return rise_cK > 0xffffu ? (uint16_t)0xffffu : (uint16_t)rise_cK;
}
