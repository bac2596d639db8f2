// SPDX-License-Identifier: Apache-2.0
// What a limb is composed of: segments that bend, coils that bend them, sensors. Which part acts on which, worked out once.
//
//   segments   silicone beams of constant curvature, in series; each bends about one axis or two. The angle of a segment is
//              relative to the one before.
//   coils      wire and spring, each along one segment, at a direction around it
//   sensors    a thermocouple on a coil; a bend sensor, or a camera, on an axis of a segment
//
// A bend is one axis of one segment: the coordinate that the equations have.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "plant/description.h"

namespace sinew::plant {

enum class Sensing { thermocouple, bend, camera };

struct Shape {
  struct Segment {
    std::string name;
    int axes = 1;
  };
  struct Coil {
    std::string name;
    std::size_t segment = 0;
    double direction_deg = 0.0;
  };
  struct Sensor {
    std::string column;
    Sensing kind;
    std::size_t part;  // a coil, or a bend
  };
  struct Bend {
    std::size_t segment;
    int axis;          // 0: towards 0 degrees, 1: towards 90 degrees
    std::string name;  // "" where there is only one
  };
  // A coil's share in a bend: the cosine of the angle between its direction and the axis, exact at right angles, never 0.
  struct Coupling {
    std::size_t coil, bend;
    double cosine;
  };
  struct Pair {
    std::size_t first, second;
  };

  std::vector<Segment> segments;
  std::vector<Coil> coils;
  std::vector<Sensor> sensors;
  // Of what coils share (core.h), what a coil has of its own: "heating_midpoint", index of the coil.
  std::vector<std::pair<std::string, std::size_t>> own;
  bool is_own(std::string_view quantity, std::size_t coil) const;

  // Worked out from these by `complete`.
  std::vector<Bend> bends;
  std::vector<std::string> segment_names;              // as they stand in names: "" where there is only one segment
  std::vector<Coupling> couplings;                     // by bend, then coil
  std::vector<Pair> pairs;                             // of coils on one segment
  std::vector<std::vector<std::size_t>> coils_of;      // of each segment
  std::vector<std::vector<std::size_t>> bends_before;  // of each bend: those of the same axis, from the base to itself
  std::vector<std::size_t> thermocouple_coils;         // coils with a thermocouple, each once
  std::vector<std::size_t> sensor_bends;               // bends with a bend sensor, each once
  bool is_two_coil_limb = false;                       // the limb of format 1

  void complete();
};

// The limb of plant files of format 1: one segment, coils A and B on opposite sides, a thermocouple on each, a bend sensor.
Shape two_coil_shape();

// Throws DescriptionError. What may stand there: docs/adding_a_limb.md.
Shape shape_of(const Description& limb);

// The same as it stands in a plant file.
std::string yaml_of(const Shape& shape);

}  // namespace sinew::plant
