// SPDX-License-Identifier: Apache-2.0
#include "model/interval.h"

#include <doctest/doctest.h>

#include <cmath>

#include "model/predictor.h"
#include "sim/random.h"

namespace model_interval_test {

using namespace sinew;
using namespace sinew::model;

namespace {

Task one_input() {
  return {.paper_case = 3,
          .features = {{{.name = "duty_A", .words = "duty A", .unit = ""}, false}},
          .predicted = {.name = "angle_deg", .words = "angle", .unit = "deg"}};
}

// Says zero, whatever it is given: what is measured is its error. Counts what it was given to begin with.
class Zero : public Predictor {
 public:
  explicit Zero(double says = 0.0) : Predictor({.task = one_input(), .kind = "zero", .trained_on = {}}), says_(says) {}
  void begin(const Series&) override {}
  double step(const Eigen::Ref<const Vector<double>>&, std::optional<double>) override { return says_; }
  Hdf5File save(Layout) const override { return described_file(about_, "{}"); }
  std::unique_ptr<Predictor> copy() const override { return std::make_unique<Zero>(*this); }

 private:
  double says_;
};

Series off_by(double error, Index samples = 1200) {
  return {"off", 0.0, Matrix<double>::Zero(1, samples), Vector<double>::Constant(samples, error)};
}

std::vector<SetAside> off_by_one_to(Index count) {
  std::vector<SetAside> data;
  for (Index i = count; i > 0; --i) data.push_back({off_by(static_cast<double>(i)), 0});
  return data;
}

// A recording whose errors are its own: an offset, and what wanders slowly round it.
Series wandering(std::uint64_t seed) {
  const sim::RandomStream chance(seed, "wandering");
  Series series = off_by(0.0, 3000);
  double slow = 0.0;
  for (Index k = 0; k < series.samples(); ++k) {
    slow += 0.01 * (0.0 - slow) + 0.1 * chance.normal(static_cast<std::uint64_t>(k));
    series.y(k) = 0.5 * chance.normal(1000000) + slow;
  }
  return series;
}

}  // namespace

TEST_CASE("intervals: of 39 recordings the width is the 38th error, of 20 the 19th, of 19 the largest; fewer promise less") {
  // By hand: left out, the nth of 39 has n - 1 of 38 below it. 38 of 39 must be held for 0.95, 37 are less. So 19 of 20 must, and
  // of 19 all; but no width from the other 18 holds the largest. Of 5 neither, and 5/6 is promised.
  const Intervals of_39 = intervals_from(Zero(), off_by_one_to(39), 2);
  for (const Beginning beginning : {Beginning::at_first, Beginning::in_motion}) {
    const IntervalSteps* steps = of_39.steps_for(beginning);
    REQUIRE(steps);
    for (const double width : steps->open_loop) CHECK(width == 38.0);
    for (const double width : steps->one_step) CHECK(width == 38.0);
    CHECK(promised_share(*steps) == 0.95);
  }
  CHECK(intervals_from(Zero(), off_by_one_to(20), 1).steps_for(Beginning::at_first)->open_loop.front() == 19.0);
  CHECK(intervals_from(Zero(), off_by_one_to(19), 1).steps_for(Beginning::at_first)->open_loop.front() == 19.0);
  const Intervals of_5 = intervals_from(Zero(), off_by_one_to(5), 1);
  CHECK(of_5.steps_for(Beginning::at_first)->open_loop.back() == 5.0);
  CHECK(promised_share(*of_5.steps_for(Beginning::at_first)) == doctest::Approx(5.0 / 6.0));
}
TEST_CASE("intervals: a recording counts once, however many samples it has") {
  // 38 short ones that are 1 off, one four times as long that is 100 off: samples alone would give it a tenth.
  std::vector<SetAside> data(38, {off_by(1.0), 0});
  data.push_back({off_by(100.0, 4800), 0});
  CHECK(intervals_from(Zero(), data, 1).steps_for(Beginning::at_first)->open_loop.front() == 1.0);
}
TEST_CASE("intervals: of fewer than five recordings, minutes of them are the units, and what was trained on is not judged") {
  Series long_one = off_by(7.0, 3000);
  long_one.y.tail(1800).setConstant(2.0);
  const Intervals intervals = intervals_from(Zero(), {{long_one, 1200}}, 1);
  CHECK_FALSE(intervals.unit_is_recording);
  CHECK_FALSE(intervals.by_beginning[0].has_value());
  const IntervalSteps* steps = intervals.steps_for(Beginning::after_history);
  REQUIRE(steps);
  CHECK(steps->units.front() == 3);  // 1800 samples are three minutes
  for (const double width : steps->open_loop) CHECK(width == 2.0);
  CHECK_FALSE(intervals_from(Zero(), {}, 1).steps_for(Beginning::in_motion));
  CHECK_FALSE(intervals_from(Zero(std::nan("")), off_by_one_to(39), 1).steps_for(Beginning::at_first));
}
TEST_CASE("intervals: they widen with the time since a rollout began as errors do") {
  std::vector<SetAside> data;
  for (int i = 0; i < 30; ++i) {
    Series growing = off_by(0.0, 700);
    for (Index k = 0; k < 700; ++k) growing.y(k) = 0.1 * static_cast<double>(k);  // 1 a second
    data.push_back({growing, 0});
  }
  const Intervals intervals = intervals_from(Zero(), data, 2);
  const IntervalSteps* steps = intervals.steps_for(Beginning::at_first);
  const Vector<double> widths = half_widths(*steps, false, 700);
  CHECK(widths(0) == 0.0);
  CHECK(widths(5) == doctest::Approx(0.5));  // the first step ends at 0.5 s, where all are 0.5 off at most
  CHECK(widths(6) == doctest::Approx(1.0));
  CHECK(widths(600) == doctest::Approx(59.0).epsilon(0.02));  // 96.8 % of 30 to 60 s
  CHECK(widths(699) > widths(600));
}
TEST_CASE("intervals: of fresh recordings 95 % of samples lie inside, though errors of one go together") {
  constexpr int fresh = 60;
  const auto share_inside_fresh = [](std::uint64_t sets, std::uint64_t set_aside) {
    double inside = 0.0;
    for (std::uint64_t set = 0; set < sets; ++set) {
      std::vector<SetAside> data;
      for (std::uint64_t r = 0; r < set_aside; ++r) data.push_back({wandering(1000 * set + r), 0});
      const Intervals intervals = intervals_from(Zero(), data, 2);
      const Vector<double> widths = half_widths(*intervals.steps_for(Beginning::at_first), false, 3000);
      for (std::uint64_t r = 0; r < fresh; ++r) inside += share_inside(Vector<double>::Zero(3000), widths, wandering(1000 * set + 500 + r));
    }
    return inside / static_cast<double>(sets * fresh);
  };
  // Over 8 sets of 60 the mean is known to 0.006, over 16 of 24 to 0.007.
  CHECK(share_inside_fresh(8, 60) == doctest::Approx(0.95).epsilon(0.015));
  CHECK(share_inside_fresh(16, 24) == doctest::Approx(0.95).epsilon(0.02));
}
}  // namespace model_interval_test
