// SPDX-License-Identifier: Apache-2.0
/* The limits of the limb, compiled into host and firmware alike: a device with others is not armed (limits_hash).
 *
 * For the limb of the paper: Ni-Ti wire of 0.51 mm in Smooth-Sil 945, 7 V. Another limb has other limits; after a change,
 * build and flash anew. Times in milliseconds, temperatures in hundredths of a degree, duty in ten-thousandths. */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The coil must never be hotter than this: Flexinol loses its memory and the silicone hardens. */
#define LIMIT_COIL_cdegC 15000
/* The device trips here already, by what it measures or will measure a quarter of a second on. */
#define LIMIT_TRIP_cdegC 14000
/* The host keeps its prediction below this. */
#define LIMIT_HOST_cdegC 13000
/* Arming wants all coils cooler than this. */
#define LIMIT_COOL_cdegC 5000
#define LIMIT_COLDEST_cdegC (-1000)

#define LIMIT_HIGHEST_DUTY 7000u
/* Silence: a command is good for its time to live, and never for longer than this. */
#define LIMIT_DEAD_MAN_ms 220u

/* The rules below hold for readings with white noise of up to 3 K (one standard deviation): none of them trips a good session for it in a
 * hundred hours, `sinew hil-false-trips`. */
/* By the line through the last eleven readings: noise of 3 K is 2.7 K/s of it. Full duty from cold is 23 K/s. */
#define LIMIT_RISE_cK_s 4000
/* Between two readings: 2.4 K by full duty, and six deviations of the difference of two readings with 3 K. */
#define LIMIT_JUMP_cK 2800
#define LIMIT_JUNCTION_COLDEST_cdegC (-1000)
#define LIMIT_JUNCTION_HOTTEST_cdegC 6000
#define LIMIT_JUNCTION_JUMP_cK 300

/* A reading that has not changed is stuck once heat must have moved it by this much: SURE hundredths of what the duty gives, less what the
 * shown rise loses. A coil in equilibrium is expected to stay, though it lose half as much again as below, or its thermocouple show 0.65 of
 * the rise, and a driver do nothing with the first DEADBAND ten-thousandths of duty. */
#define LIMIT_STUCK_DEADBAND ((int32_t)500)
#define LIMIT_STUCK_mK ((int32_t)6000)
#define LIMIT_STUCK_SURE_100 ((int32_t)65)

/* What a coil warms by, roughly: duty 1 heats at HEATING, and each kelvin above the cold junction cools at COOLING. */
#define LIMIT_HEATING_mK_s ((int32_t)23000)
#define LIMIT_COOLING_1_ks ((int32_t)47)
/* Warming is compared with what is expected over about this long. */
#define LIMIT_FOLLOW_WINDOW_ms ((int32_t)2000)
/* A thermocouple may lag by this much: what is expected of it is expected so much later. */
#define LIMIT_FOLLOW_LAG_ms ((int32_t)2000)
#define LIMIT_FOLLOW_EXPECTED_mK ((int32_t)6000) /* expected this much, and less than a quarter of it came: not following */
#define LIMIT_UNEXPECTED_mK ((int32_t)9000)      /* warmed this much more than twice what was expected */
/* For so many readings one after the other, since noise in one of them says nothing. */
#define LIMIT_FOLLOW_READINGS 12u
#define LIMIT_UNEXPECTED_READINGS 4u

/* Of an angle, in the sum of 16 ADC conversions of 1023 at most: at the ends its wire is off, or there is no supply. */
#define LIMIT_ANGLE_LEAST_raw 160u
#define LIMIT_ANGLE_MOST_raw 16208u
/* An angle that stays within MOVED (0.35 degrees) while one coil passes through RANGE and no other through OTHERS hangs. The limb of the
 * paper, heated from 25 to 110 degC and left to cool, passes through 25 K at the most before it moves by as much. */
#define LIMIT_ANGLE_MOVED_raw 32u
#define LIMIT_ANGLE_RANGE_cK 6000
#define LIMIT_ANGLE_OTHERS_cK 1500

/* Duty times time in the window. */
#define LIMIT_ON_TIME_ms 9000u
#define LIMIT_ON_TIME_WINDOW_s 20u

/* What a coil warms by at the very most, whatever the sensors say (heat_bound.h): duty 1 heats at BOUND_HEATING, the above at 8 V instead
 * of 7 (1.306 times) and rounded up to a hundred; each kelvin cools at BOUND_COOLING, the above less a twentieth. */
#define LIMIT_BOUND_HEATING_mK_s ((int32_t)30100)
#define LIMIT_BOUND_COOLING_1_ks ((int32_t)45)
/* The bound's rise over the room at which the device trips: that of the limit, in a room of 25 degC. */
#define LIMIT_BOUND_RISE_cK ((int32_t)12500)
/* The rise it begins with at power-on, when nothing is known: of a coil that reads COOL though its thermocouple shows 0.6 of its rise. */
#define LIMIT_BOUND_START_cK ((int32_t)4200)

/* Where dividers show the drain of each switch: below LOW it conducts, and otherwise it shows the supply. The board's own 5 V, by which
 * it is measured, may be 5 % off: 8.5 V shown are 8.1 to 8.9. The duty leaves it high for 3 ms of each 10 at the least. */
#define LIMIT_DRAIN_LOW_cV 200u
#define LIMIT_DRAIN_LOW_ms 40u
#define LIMIT_SUPPLY_cV 850u
/* After arming, until the relay has closed and the supply is there. */
#define LIMIT_DRAIN_SETTLING_ms 300u

/* The amplifiers convert in at most 100 ms, and reading stops a conversion: so they are read no more often than this. */
#define LIMIT_READING_PERIOD_ms 105u
#define LIMIT_READING_SILENCE_ms 240u

/* Over all of the above, and the number of coils that they are for. */
uint32_t limits_hash(uint8_t coils);

#ifdef __cplusplus
}
#endif
