// The plant against an independent reference: every file beside this one is a run of reference.py (scipy, written from
// the equations alone) that the C++ plant must follow. See README.md for the cases, the tolerances and their reasons.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "plant/integrator.h"
#include "sim/plant_file.h"
#include "sim/recording.h"
#include "sim/simulation.h"
#include "sim/yaml.h"

#ifndef SINEW_SOURCE_DIR
#define SINEW_SOURCE_DIR "."
#endif

namespace fs = std::filesystem;
using namespace sinew;

namespace {

const fs::path folder = fs::path(SINEW_SOURCE_DIR) / "tests" / "golden";

struct Tolerance {
  double temperature_K = 2e-5;
  double angle_deg = 2e-4;
};

// The plant fades minor_loops in over the outermost thousandth of the loop (Smoothing::loop_edge_fraction), which the
// equations do not: that much of a fraction is some hundredths of a degree, and of a kelvin where latent heat is on too.
Tolerance tolerance_of(const plant::Limb<double>& limb) {
  if (limb.on[plant::effect_index("minor_loops")]) return {2e-3, 0.04};
  return {};
}

plant::Limb<double> limb_of(const sim::Recording& golden) {
  for (const std::string& comment : golden.comments)
    if (comment.starts_with("plant:")) {
      const sim::YamlValue yaml = sim::parse_yaml(comment, golden.name);
      sim::YamlMap map(yaml);
      return sim::read_plant(map.require("plant", "a golden run"), folder);
    }
  FAIL("no line '# plant: ...' in " << golden.name);
  return {};
}

struct Difference {
  double temperature_K = 0.0;
  double angle_deg = 0.0;
  std::size_t rows = 0;
};

Difference largest_difference(const sim::Recording& golden, const sim::Recording& duty, plant::Method method) {
  plant::Integrator limb(limb_of(golden), plant::Start{}, {.method = method, .relative_tolerance = 1e-9});
  Difference largest;
  std::size_t row = 0;
  const auto failure = sim::replay(limb, duty.samples, [&](std::size_t k) {
    if (row == golden.samples.size() || duty.samples[k].time_s != golden.samples[row].time_s) return;
    const sim::Sample& expected = golden.samples[row++];
    CHECK(duty.samples[k].duty_fraction == expected.duty_fraction);
    const plant::Reading<double> shown = limb.reading();
    for (const auto j : {plant::A, plant::B})
      largest.temperature_K =
          std::max(largest.temperature_K, std::abs(shown.temperature_degC[j] - expected.temperature_degC[j]));
    largest.angle_deg =
        std::max(largest.angle_deg, std::abs(shown.angle_rad * 180.0 / std::numbers::pi - expected.angle_deg));
  });
  CHECK_FALSE(failure.has_value());
  largest.rows = row;
  return largest;
}

}  // namespace

TEST_CASE("the plant follows the independent reference in the core, in every effect, and in combinations") {
  const sim::Recording duty = sim::read_recording(folder / "duty.csv");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".csv" && entry.path().filename() != "duty.csv") files.push_back(entry.path());
  std::ranges::sort(files);
  CHECK(files.size() == plant::effect_count + 5);  // the core twice, three combinations

  for (const fs::path& file : files) {
    const sim::Recording golden = sim::read_recording(file);
    const std::string name = file.stem().string();
    for (const auto method : {plant::Method::cvode, plant::Method::arkode}) {
      CAPTURE(name);
      CAPTURE(method == plant::Method::cvode);
      const Difference largest = largest_difference(golden, duty, method);
      MESSAGE(name, " ", std::string(method == plant::Method::cvode ? "cvode" : "arkode"), " ", largest.temperature_K, " K ", largest.angle_deg, " deg");
      CHECK(largest.rows == golden.samples.size());
      CHECK(largest.temperature_K < tolerance_of(limb_of(golden)).temperature_K);
      CHECK(largest.angle_deg < tolerance_of(limb_of(golden)).angle_deg);
    }
  }
}
