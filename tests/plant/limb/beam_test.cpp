// SPDX-License-Identifier: Apache-2.0
#include "plant/limb/beam.h"

#include "tests/plant/limb/one_instant.h"

namespace plant_limb_beam_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

// The core of plant files of format 1, at its nominal values.
Core<double> two_coil_core() {
  static const Shape shape = two_coil_shape();
  Core<double> core(shape);
  core.moment_arm_m = {0.006, 0.006};
  core.beam_stiffness_Nm_rad = {0.05};
  core.beam_damping_Nms_rad = {0.004};
  core.beam_inertia_kgm2 = {2.0e-5};
  return core;
}

}  // namespace

TEST_CASE("beam: bending towards A shortens coil A by arm times angle and stretches coil B") {
  Core<double> core = two_coil_core();
  core.moment_arm_m = {0.006, 0.008};
  const auto coil_stretch_m = [&](std::size_t coil, double angle_rad) {
    Instant<double> now(core);
    now.angle_rad = {angle_rad};
    stretch_coils(now);
    return now.stretch_m[coil];
  };
  CHECK(coil_stretch_m(A, 0.5) == by_hand(0.027));
  CHECK(coil_stretch_m(B, 0.5) == by_hand(0.034));
  CHECK(coil_stretch_m(A, 0.0) == 0.030);
  core.bend_sign = {-1.0};
  CHECK(coil_stretch_m(A, 0.5) == by_hand(0.033));
  CHECK(coil_stretch_m(B, 0.5) == by_hand(0.026));
}

TEST_CASE("beam: coil A bends towards its side, spring and damper resist") {
  const Core<double> core = two_coil_core();
  const auto beam_moment_Nm = [&](std::vector<double> tension_N, double angle_rad, double angular_velocity_rad_s) {
    Instant<double> now(core);
    now.tension_N = std::move(tension_N);
    now.angle_rad = {angle_rad};
    now.angular_velocity_rad_s = {angular_velocity_rad_s};
    bend_beams(now);
    return now.moment_Nm[0];
  };
  // By hand: 0.006 * (9 - 1) - 0.004 * 2 - 0.05 * 0.5 = 0.048 - 0.008 - 0.025.
  CHECK(beam_moment_Nm({9.0, 1.0}, 0.5, 2.0) == doctest::Approx(0.015).epsilon(1e-13));
  CHECK(beam_moment_Nm({3.0, 3.0}, 0.0, 0.0) == 0.0);
}

TEST_CASE("beam: wired the other way round, coil A bends the other way, by as much") {
  Plant mirrored = default_plant();
  set(mirrored, "bend_sign", -1.0);
  const auto at = at_one_instant(default_plant(), {}, {80.0, 30.0, 0.2, 0.9, 0.4, 1.5});
  const auto mirror = at_one_instant(mirrored, {}, {80.0, 30.0, 0.2, 0.9, -0.4, -1.5});
  CHECK(mirror.rates[4] == -at.rates[4]);
  CHECK(mirror.rates[5] == by_hand(-at.rates[5]));
}

TEST_CASE("beam: the two sides are alike, so that exchanging all that is theirs turns the bend round") {
  const auto at = at_one_instant(default_plant(), {.inputs = {0.5, 0.1}}, {80.0, 30.0, 0.2, 0.9, 0.4, 1.5});
  const auto exchanged = at_one_instant(default_plant(), {.inputs = {0.1, 0.5}}, {30.0, 80.0, 0.9, 0.2, -0.4, -1.5});
  CHECK(exchanged.rates[0] == at.rates[1]);
  CHECK(exchanged.rates[2] == at.rates[3]);
  CHECK(exchanged.rates[5] == by_hand(-at.rates[5]));
}

TEST_CASE("beam: the angle that is read carries the offset, the angle that acts does not") {
  Plant limb = default_plant();
  set(limb, "angle_offset_deg", 0.05);
  const auto at = at_one_instant(limb, {}, {80.0, 30.0, 0.2, 0.9, 0.4, 1.5});
  CHECK(at.reading[angle] == by_hand(0.45));
  CHECK(at.rates == at_one_instant(default_plant(), {}, {80.0, 30.0, 0.2, 0.9, 0.4, 1.5}).rates);
}

}  // namespace plant_limb_beam_test
