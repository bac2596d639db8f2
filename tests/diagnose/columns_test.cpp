// SPDX-License-Identifier: Apache-2.0
#include "diagnose/columns.h"

#include <doctest/doctest.h>

#include "tests/diagnose/one_limb.h"

namespace diagnose_columns_test {

using namespace sinew;

TEST_CASE("columns: kelvin, radians and exchanged names are found, right columns are not") {
  const auto found_in = [](const sim::Recording& recording) {
    const auto mistaken = diagnose::mistaken_column(plant::default_plant(), recording);
    return mistaken ? mistaken->column + " " + mistaken->why : "";
  };
  const sim::Recording right = testing::recorded(testing::babbling(120.0));
  CHECK(found_in(right) == "");

  sim::Recording duties = right, temperatures = right, kelvin = right, radians = right, offset = right, alike = right;
  for (std::size_t k = 0; k < right.samples.size(); ++k) {
    std::swap(duties.samples[k].inputs[0], duties.samples[k].inputs[1]);
    std::swap(temperatures.samples[k].channels[0], temperatures.samples[k].channels[1]);
    kelvin.samples[k].channels[1] += 273.15;
    radians.samples[k].channels[2] *= plant::radians_per_degree;
    offset.samples[k].channels[0] += 30.0;
    alike.samples[k].inputs[1] = alike.samples[k].inputs[0];
  }
  CHECK(found_in(duties).find("seem to be exchanged") != std::string::npos);
  CHECK(found_in(temperatures).find("seem to be exchanged") != std::string::npos);
  CHECK(found_in(kelvin).starts_with("temperature_B_degC never falls below 200 degC"));
  CHECK(found_in(radians).starts_with("angle_deg"));
  CHECK(found_in(radians).find("radians") != std::string::npos);
  CHECK(found_in(offset) == "");
  CHECK(found_in(alike) == "");
}

TEST_CASE("columns: a column that was never measured is not mistaken") {
  sim::Recording recording = testing::recorded(testing::babbling(60.0));
  for (sim::Sample& sample : recording.samples) sample.channels[0] = sample.channels[2] = std::nan("");
  CHECK(!diagnose::mistaken_column(plant::default_plant(), recording));
}

}  // namespace diagnose_columns_test
