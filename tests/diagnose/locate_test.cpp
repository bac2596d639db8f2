// SPDX-License-Identifier: Apache-2.0
#include "diagnose/locate.h"

#include <doctest/doctest.h>
#include <algorithm>

#include "plant/systems.h"

namespace locate_test {
namespace {

using sinew::diagnose::PlaceEvidence;
using Places = std::vector<std::string>;

Places said(const PlaceEvidence& evidence) { return sinew::diagnose::places_said(sinew::plant::default_plant().system(), evidence); }
Places sorted(Places places) {
  std::sort(places.begin(), places.end());
  return places;
}

const Places of_the_angle{"mechanics", "sensor.angle", "transformation"};

}  // namespace

TEST_CASE("where it enters: the place of a name that is sure stands alone, whatever else speaks") {
  CHECK(said({.name = "mechanics",
              .name_probability = 0.9,
              .laws = {"thermal"},
              .forcing = "sensor.temperature",
              .forcing_speaks = true,
              .varying = {"actuation"}}) == Places{"mechanics"});
}

TEST_CASE("where it enters: alike are the places that move the same channels") {
  const auto alike = [](std::string_view place) {
    const auto places = sinew::diagnose::places_alike(sinew::plant::default_plant().system(), place);
    return sorted(Places(places.begin(), places.end()));
  };
  for (const std::string& place : of_the_angle) CHECK(alike(place) == of_the_angle);
  CHECK(alike("thermal") == Places{"actuation", "thermal"});
  CHECK(alike("sensor.temperature") == Places{"sensor.temperature"});
}

TEST_CASE("where it enters: a name that is likely comes first, and beside it what moves the same channels") {
  const Places places = said({.name = "mechanics", .name_probability = 0.89, .forcing = "thermal"});
  CHECK(places.front() == "mechanics");
  CHECK(sorted(places) == of_the_angle);
}

TEST_CASE("where it enters: a reading is said after what moves its channel, unless a name is likely that says it") {
  CHECK(said({.laws = {"sensor.angle"}, .forcing = "thermal"}).back() == "sensor.angle");
  CHECK(said({.laws = {"sensor.angle", "transformation"}, .forcing = "thermal"}) == Places{"transformation", "mechanics", "sensor.angle"});
  const Places varies = said({.forcing = "sensor.angle", .varying = {"sensor.angle", "thermal"}});
  CHECK(sorted({varies[0], varies[1], varies[2]}) == of_the_angle);
  CHECK(varies[2] == "sensor.angle");
  CHECK(varies[3] == "thermal");
  CHECK(said({.name = "sensor.angle", .name_probability = 0.5, .forcing = "mechanics"}).front() == "sensor.angle");
  // That of a thermocouple is alone.
  CHECK(said({.laws = {"sensor.temperature"}, .forcing = "thermal"}) == Places{"sensor.temperature"});
}

TEST_CASE("where it enters: a law without a name does not tell the bend sensor from the beam, nor the current's heat from the air's") {
  CHECK(sorted(said({.laws = {"sensor.angle"}, .forcing = "thermal"})) == of_the_angle);
  CHECK(said({.laws = {"thermal"}, .forcing = "sensor.angle"}) == Places{"thermal", "actuation"});
  CHECK(said({.laws = {"actuation"}, .forcing = "sensor.angle"}) == Places{"actuation", "thermal"});
  CHECK(said({.forcing = "sensor.temperature"}) == Places{"sensor.temperature"});
  CHECK(said({.forcing = "thermal", .varying = {"sensor.temperature"}}) == Places{"sensor.temperature"});
}

TEST_CASE(
    "where it enters: what forcings say comes before a name that is less likely than not, and is not forgotten where they were not asked") {
  const Places places = said({.name = "thermal", .name_probability = 0.3, .forcing = "sensor.angle"});
  CHECK(sorted({places[0], places[1], places[2]}) == of_the_angle);
  CHECK(places[2] == "sensor.angle");
  CHECK(std::count(places.begin(), places.end(), "thermal") == 1);
  const Places by_paths = said({.name = "thermal", .name_probability = 0.7, .forcing = "sensor.angle", .forcing_speaks = true});
  CHECK(by_paths.front() == "thermal");
  CHECK(std::count(by_paths.begin(), by_paths.end(), "mechanics") == 1);
  const Places varies = said({.name = "thermal", .name_probability = 0.7, .forcing = "sensor.angle", .varying = {"sensor.temperature"}});
  CHECK(varies == Places{"thermal", "sensor.temperature", "actuation"});
}

}  // namespace locate_test
