// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "diagnose/explanation.h"
#include "sim/random.h"
#include "tests/diagnose/one_limb.h"

namespace diagnose_course_test {

using namespace sinew;
using diagnose::Course;
using diagnose::FitProblem;
using diagnose::Path;
using diagnose::Want;

namespace {

// Coil B is held at a duty for 200 s, half-way through its transformation, in air that is cold at first and warm at last.
sim::Recording held_in_moving_air() {
  const plant::Plant limb = plant::default_plant();
  const plant::System& system = limb.system();
  const plant::ParameterId air = *system.surroundings();
  const sim::RandomStream chance(7, "course_test");
  std::uint64_t draw = 0;
  sim::Recording recording;
  recording.columns = sim::columns_of(system);
  plant::Plant now = limb;
  plant::Integrator integrator(now, plant::Start{}, {});
  for (int k = 0; k <= 1100; ++k) {
    const double time_s = 0.2 * k;
    REQUIRE_FALSE(integrator.advance_to(time_s));
    integrator.restart();
    now.set(air, limb.get(air) - std::cos(time_s / 40.0));
    integrator = plant::Integrator(now, integrator.checkpoint(), {});
    sim::Sample sample{.time_s = time_s, .inputs = {0.0, time_s < 200.0 ? 0.1 : 0.0}, .channels = {}};
    sample.channels = sim::in_file_units(system, integrator.readings());
    for (const plant::ChannelId c : system.channels().ids()) sample.channels[c.index] += testing::paper_noise[c] * chance.normal(draw++);
    recording.samples.push_back(std::move(sample));
    sim::command_sample(integrator, system, recording.samples, recording.samples.size() - 1);
  }
  return recording;
}

diagnose::ExplanationSettings only_how_it_begins() {
  diagnose::ExplanationSettings settings;
  settings.only_start = true;
  return settings;
}

// The likelihood of the same plant about a path without forcings, whatever sizes of these serve it best.
double about_no_forcing(const diagnose::Explanation& of) {
  const FitProblem problem(of.problem->centres(), of.problem->parameters(), of.problem->data(), of.problem->beginnings(),
                           of.problem->numerics());
  Path path;
  REQUIRE(follow(problem, of.z.data(), Want::points, path));
  diagnose::StateNoise noise(problem, *of.blocks, of.z.data(), path);
  const Eigen::VectorXd residual = of.blocks->means(path.residuals.data(), 1).col(0);
  noise.maximise(residual, diagnose::forcing_to_begin_with(problem.system()), diagnose::all_free(problem.system()), 1.3);
  return noise.log_likelihood(residual);
}

std::shared_ptr<const Course> warm_for_a_while(const FitProblem& problem, double by_K, Eigen::Index from, Eigen::Index to) {
  Course course;
  for (const plant::StateInfo& state : problem.centres().states()) course.states.push_back(state.key);
  const auto wire =
      static_cast<Eigen::Index>(std::find(course.states.begin(), course.states.end(), "temperature_A_degC") - course.states.begin());
  REQUIRE(wire < static_cast<Eigen::Index>(course.states.size()));
  const auto samples = static_cast<Eigen::Index>(problem.data()[0].sample_count);
  course.pushes.emplace_back(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(course.states.size()), samples - 1));
  course.pushes[0].row(wire).segment(from, to - from).setConstant(by_K);
  course.response.assign(problem.rows().size(), 0.0);
  return std::make_shared<const Course>(std::move(course));
}

}  // namespace

TEST_CASE("course: a held coil stands still on a corner of its hysteresis; that air has warmed it is seen along that course alone") {
  const sim::Recording recording = held_in_moving_air();
  const std::vector<diagnose::FitData> data = testing::data_of(recording);
  const diagnose::Explanation air = diagnose::explain(plant::default_plant(), data, {}, only_how_it_begins());
  REQUIRE(air.usable);
  REQUIRE(air.problem->course());
  CHECK(air.process_noise < 20.0);
  CHECK(about_no_forcing(air) < air.log_likelihood - 100.0);
  // What goes on from it goes on along it.
  const diagnose::Explanation again = diagnose::explain(plant::default_plant(), data, air.as_guess(), only_how_it_begins());
  CHECK(again.log_posterior > air.log_posterior - 1.0);
  // Alone the course is none of the plant's: it shows what the duty brings.
  CHECK(air.model().get(*air.system().surroundings()) == plant::default_plant().get(*air.system().surroundings()));
}

TEST_CASE("course: a recording that moving air explains without a corner has none") {
  sim::Scenario scenario = testing::babbling(60.0);
  scenario.sensors = sim::usual_sensors(scenario.plant.system());
  const testing::FittedCore limb(scenario);
  REQUIRE(limb.core.usable);
  CHECK_FALSE(limb.core.problem->course());
}

TEST_CASE("course: a fit that begins along the course of another explanation ends along its own") {
  const testing::FittedCore limb(testing::babbling(60.0));
  REQUIRE(limb.core.usable);
  diagnose::Guess guess = limb.core.as_guess();
  guess.course = warm_for_a_while(*limb.core.problem, 0.05, 50, 150);
  const diagnose::Explanation again = diagnose::explain(plant::default_plant(), limb.data, guess, only_how_it_begins());
  REQUIRE(again.usable);
  const diagnose::Explanation alone = diagnose::explain(plant::default_plant(), limb.data, {}, only_how_it_begins());
  CHECK(std::abs(again.log_posterior - alone.log_posterior) < 1.0);
  if (again.problem->course()) {
    const double begun = guess.course->pushes[0].norm(), ended = again.problem->course()->pushes[0].norm();
    CHECK(ended < 0.1 * begun);
  }
}

TEST_CASE("course: what it does to the residuals to first order is taken off again") {
  const testing::FittedCore limb(testing::babbling(40.0));
  const diagnose::Explanation& core = limb.core;
  REQUIRE(core.usable);
  FitProblem problem(core.problem->centres(), core.problem->parameters(), limb.data, core.problem->beginnings(), core.problem->numerics());
  Path before, pushed, taken_off;
  REQUIRE(follow(problem, core.z.data(), Want::points, before));
  auto course = warm_for_a_while(problem, 2e-3, 50, 150);
  problem.set_course(course);
  REQUIRE(follow(problem, core.z.data(), Want::points, pushed));
  auto whole = std::make_shared<Course>(*course);
  whole->response = response_to(problem, before, course->pushes);
  problem.set_course(whole);
  REQUIRE(follow(problem, core.z.data(), Want::residuals, taken_off));
  double moved = 0.0, left = 0.0;
  for (std::size_t i = 0; i < before.residuals.size(); ++i) {
    moved += std::pow(pushed.residuals[i] - before.residuals[i], 2);
    left += std::pow(taken_off.residuals[i] - before.residuals[i], 2);
  }
  CHECK(moved > 1.0);
  CHECK(left < 0.01 * moved);
}

TEST_CASE("course: on a plant with more states it pushes those of the same names; of other samples it is none") {
  const sim::Recording recording = testing::recorded(testing::babbling(20.0));
  const std::vector<diagnose::FitData> data = testing::data_of(recording);
  const diagnose::ExplanationSettings settings;
  FitProblem problem(plant::default_plant(), {}, data, settings.start, settings.numerics);
  const auto course = warm_for_a_while(problem, 0.5, 10, 20);
  problem.set_course(course);
  CHECK(problem.course() == course);
  FitProblem with_body(diagnose::with_effect(plant::default_plant(), testing::effect("body_heat_storage")), {}, data, settings.start,
                       settings.numerics);
  with_body.set_course(course);
  REQUIRE(with_body.course());
  REQUIRE(with_body.course()->states.size() > course->states.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < with_body.course()->states.size(); ++i) {
    const double push = with_body.course()->pushes[0](static_cast<Eigen::Index>(i), 15);
    CHECK(push == (with_body.course()->states[i] == "temperature_A_degC" ? 0.5 : 0.0));
    sum += push;
  }
  CHECK(sum == 0.5);
  std::vector<diagnose::FitData> fewer = data;
  fewer[0].sample_count -= 1;
  FitProblem shorter(plant::default_plant(), {}, fewer, settings.start, settings.numerics);
  shorter.set_course(course);
  CHECK_FALSE(shorter.course());
}

}  // namespace diagnose_course_test
