// SPDX-License-Identifier: Apache-2.0
#include "model/series.h"

#include <doctest/doctest.h>

#include <cmath>

#include "model/errors.h"
#include "plant/systems.h"
#include "sim/input_error.h"
#include "sim/plant_file.h"

namespace model_series_test {

using namespace sinew;
using namespace sinew::model;

namespace {

const std::string header = "time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n";

const plant::Plant usual = plant::default_plant();
const plant::System& limb = usual.system();

sim::Recording recording(const std::string& rows) { return sim::parse_recording(header + rows, "a.csv", sim::columns_of(limb)); }
Series series_of_case(const sim::Recording& from, int paper_case, Missing missing = Missing::refused) {
  return series_of(from, task_of(limb, paper_case), missing);
}

std::string message(const sim::Recording& from, int paper_case, Missing missing = Missing::refused) {
  try {
    series_of_case(from, paper_case, missing);
  } catch (const sim::InputError& e) {
    return e.what();
  }
  return "nothing thrown";
}

}  // namespace

TEST_CASE("series: the four cases see what the paper gives them, in its order") {
  const auto from = recording("0,0.1,0.2,30,40,5\n0.1,0.3,0.4,31,41,6\n0.2,0.5,0.6,32,42,7\n");
  CHECK(series_of_case(from, 1).v.col(1) == Vector<double>::Constant(1, 0.3));
  CHECK(series_of_case(from, 2).v.col(1) == Eigen::Vector2d(0.3, 31));
  CHECK(series_of_case(from, 3).v.col(1) == Eigen::Vector2d(0.3, 0.4));
  CHECK(series_of_case(from, 4).v.col(1) == Eigen::Vector4d(0.3, 31, 0.4, 41));
  CHECK(series_of_case(from, 4).y == Eigen::Vector3d(5, 6, 7));
  CHECK_THROWS_WITH(task_of(limb, 5), "the paper's cases are 1 to 4, not 5");
}
TEST_CASE("series: of any plant, the tasks are made from its lists") {
  const auto plant_of = [](const std::string& channels) {
    return sim::read_plant(
        sim::parse_yaml(
            "format: 2\nlimb:\n  segments: [{ name: lower, axes: 1 }, { name: upper, axes: 1 }]\n"
            "  coils:\n    - { name: A, segment: lower, direction_deg: 0 }\n    - { name: B, segment: lower, direction_deg: 180 }\n"
            "    - { name: C, segment: upper, direction_deg: 0 }\n    - { name: D, segment: upper, direction_deg: 180 }\n"
            "  channels:\n" +
                channels,
            "p.yaml"),
        ".");
  };
  const auto names = [](const Task& task) {
    std::string text;
    for (const Feature& feature : task.features) text += feature.column.name + " ";
    return text + "-> " + task.predicted.name;
  };
  const std::string bends = "    - { column: angle_lower_deg, bend: lower }\n    - { column: angle_upper_deg, bend: upper }\n";
  const plant::Plant two_segments = plant_of(bends + "    - { column: temperature_C_degC, thermocouple: C }\n");
  const plant::System& system = two_segments.system();
  CHECK(names(task_of(system, 1)) == "duty_A -> angle_lower_deg");
  CHECK(names(task_of(system, 2)) == "duty_A -> angle_lower_deg");
  CHECK(names(task_of(system, 3)) == "duty_A duty_B duty_C duty_D -> angle_lower_deg");
  CHECK(names(task_of(system, 4)) == "duty_A duty_B duty_C temperature_C_degC duty_D -> angle_lower_deg");
  CHECK(names(task_of(system, 2, system.channel("angle_upper_deg"))) == "duty_C temperature_C_degC -> angle_upper_deg");
  // Where no channel that an input moves is measured, the only channel is predicted; of several, one must be named.
  CHECK(names(task_of(plant_of("    - { column: temperature_B_degC, thermocouple: B }\n").system(), 4)) ==
        "duty_A duty_B duty_C duty_D -> temperature_B_degC");
  const plant::Plant hot =
      plant_of("    - { column: temperature_A_degC, thermocouple: A }\n    - { column: temperature_B_degC, thermocouple: B }\n");
  CHECK_THROWS_WITH(task_of(hot.system(), 4), "nothing says which channel of this plant is to be predicted");

  const sim::Recording from = sim::parse_recording(
      "time_s,duty_A,duty_B,duty_C,duty_D,angle_lower_deg,angle_upper_deg,temperature_C_degC\n"
      "0,0.1,0.2,0.3,0.4,5,6,30\n0.1,0.5,0.6,0.7,0.8,7,8,31\n",
      "r.csv", sim::columns_of(system));
  const Series series = series_of(from, task_of(system, 4));
  CHECK(series.v.col(1) == Vector<double>{{0.5, 0.6, 0.7, 31.0, 0.8}});
  CHECK(series.y == Eigen::Vector2d(5, 7));
  CHECK(message(from, 4) ==
        "r.csv: temperature_A_degC = nothing\n  the predictor needs it; what is there: duty_A, duty_B, duty_C, duty_D, angle_lower_deg, "
        "angle_upper_deg, temperature_C_degC");
}
TEST_CASE("series: X(t) is [v(t), v(t-1), y(t-1)], each scaled over the training data") {
  const auto from = recording("0,0.1,0,30,0,5\n0.1,0.3,0,31,0,6\n0.2,0.5,0,34,0,7\n");
  const Series series = series_of_case(from, 2);
  const Scaling scaling = scaling_of({series}, task_of(limb, 2));
  const ScaledSeries x = scaled(series, scaling);
  // By hand: temperatures 30 ... 34 and angles 5 ... 7 go to 0 ... 1, duty stays.
  CHECK(x.exogenous.col(1).isApprox(Eigen::Vector4f(0.5F, 1.0F, 0.3F, 0.25F)));
  CHECK(x.y.isApprox(Eigen::Vector3f(0.0F, 0.5F, 1.0F)));
  CHECK(scaling.y(0.5) == 6.0);
}
TEST_CASE("series: of uneven period and with a pause, on the grid of 10 Hz") {
  // By hand: at 0.1 s the angle lies 3/8 of the way from 5 (at 0.07 s) to 9 (0.15 s); the duty there is that of 0.07 s. Between 0.2
  // and 2.3 s nothing was measured: what stands there lies on a line, and is not counted.
  const auto from = recording(
      "0,0.1,0,30,40,1\n0.07,0.2,0,30,40,5\n0.15,0.3,0,30,40,9\n0.2,0.4,0,30,40,10\n1,0,0,,,\n2.3,0,0,30,40,31\n2.4,0,0,30,40,32\n");
  const Series series = series_of_case(from, 3, Missing::resampled);
  REQUIRE(series.samples() == 25);
  CHECK(series.y(1) == doctest::Approx(6.5).epsilon(1e-12));
  CHECK(series.v(0, 1) == 0.2);
  CHECK(series.v(0, 2) == 0.4);
  CHECK(series.v(0, 9) == 0.4);
  CHECK(series.v(0, 10) == 0.0);
  CHECK(series.y(2) == 10.0);
  CHECK(series.y(12) == doctest::Approx(20.0));  // 10 of 21 steps from 10 to 31
  CHECK(series.counted.sum() == 5.0);
  CHECK(series.is_measured(2));
  CHECK_FALSE(series.is_measured(3));
  CHECK_FALSE(series.is_measured(22));
  CHECK(series.is_measured(23));
  // An error there weighs nothing.
  Vector<double> predicted = series.y;
  predicted(12) += 100.0;
  CHECK(errors_of(predicted, series).rmse == 0.0);
  predicted(24) += 2.0;
  CHECK(errors_of(predicted, series).rmse == doctest::Approx(1.0));  // of samples 1, 2, 23, 24, that one is 2 off
  CHECK(part_of(series, 20, 5).counted.sum() == 2.0);
}
TEST_CASE("series: what a case needs and a recording lacks is an error that names it") {
  const auto no_temperature = recording("0,0.1,0,,,5\n0.1,0.3,0,,,6\n");
  CHECK(message(no_temperature, 3) == "nothing thrown");
  CHECK(message(no_temperature, 4) == "a.csv: temperature_A_degC = nothing\n  case 4 needs it, and the recording has none");
  const auto hole = recording("0,0.1,0,30,30,5\n0.1,0.3,0,nan,30,6\n0.2,0.3,0,32,30,6\n");
  CHECK(message(hole, 4) ==
        "a.csv: temperature_A_degC = not a number at 0.1 s\n  1 samples are missing; with --hold-missing the value before each is taken");
  CHECK(series_of_case(hole, 4, Missing::held).v(1, 1) == 30.0);
  // Rows that are missing are held, and every later sample keeps its time.
  const auto gap = recording("0,0.1,0,30,30,5\n0.1,0.3,0,31,30,6\n0.5,0.4,0,32,30,7\n0.6,0.4,0,32,30,7\n");
  CHECK(message(gap, 3).find("comes 0.4 s after") != std::string::npos);
  const Series held = series_of_case(gap, 3, Missing::held);
  REQUIRE(held.samples() == 7);
  CHECK(held.v(0, 4) == 0.3);
  CHECK(held.y(4) == 6.0);
  CHECK(held.y(5) == 7.0);
  CHECK(message(recording("0,0,0,1,1,1\n0.1,0,0,1,1,1\n0.2,0,0,1,1,1\n50,0,0,1,1,1\n"), 3, Missing::held).find("comes 49.8 s after") !=
        std::string::npos);
  CHECK(message(recording("0,0,0,1,1,1\n0.01,0,0,1,1,1\n0.02,0,0,1,1,1\n"), 3) ==
        "a.csv: time_s = a sample every 0.01 s\n  the predictor works at 10 Hz, a sample every 0.1 s");
  CHECK(message(recording("0,0,0,1,1,1\n0.1,0,0,1,1,1\n0.2,0,0,1,1,1\n0.9,0,0,1,1,1\n"), 3).find("comes 0.7 s after") != std::string::npos);
}

}  // namespace model_series_test
