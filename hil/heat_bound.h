// SPDX-License-Identifier: Apache-2.0
/* An upper bound of a coil's temperature from its duty alone. No sensor comes into it, so none can talk it down.
 *
 *   dT/dt <= u H - c (T - T_room)        H: LIMIT_BOUND_HEATING, worst-case power over heat capacity
 *                                        c: LIMIT_BOUND_COOLING, least heat loss over heat capacity
 *
 * The device trips where the bound passes LIMIT_BOUND_RISE; the host lowers duty so that it need not. Plain C, shared by both.
 * Leaves out what neighbours and the room add: the room is taken to be at 25 degC. Integers; heat is rounded up, loss down. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The rise over the room `step_ms` later (at most 500), of a coil whose duty times time was `duty_ms` meanwhile: ten-thousandths
 * times milliseconds. In microkelvin; the loss is that of the rise at the beginning, which is less where the coil warms. */
uint32_t heat_bound_after(uint32_t rise_uK, uint32_t duty_ms, uint16_t step_ms);

/* The rise as the wire has it: hundredths of a kelvin, rounded up. */
uint16_t heat_bound_cK(uint32_t rise_uK);

#ifdef __cplusplus
}
#endif
