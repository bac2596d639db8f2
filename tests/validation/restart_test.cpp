// SPDX-License-Identifier: Apache-2.0
#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"

namespace validation_restart_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

constexpr double middle_s = 4.8;  // the profile jumps here

struct End {
  std::vector<double> state;
  SolverCounters counters;
  friend bool operator==(const End&, const End&) = default;
};

End finish(Integrator& run) {
  // The jump at the middle has been commanded already, and commanding it again is no jump.
  drive(run, babbling_profile(), 20.0);
  return {run.state(), run.counters()};
}

Integrator in_the_middle(const Plant& limb, Method method) {
  Integrator run(limb, Start{}, {.method = method});
  drive(run, babbling_profile(), middle_s);
  return run;
}

Plant limb_with_everything_but_delay() {
  Plant limb = default_plant();
  for (const EffectId e : effects().ids()) turn_on_typical(limb, e);
  set_in_file_units(limb, "airflow_change.onset_s", 12.34);
  limb.turn(effect_id("input_delay"), false);
  return limb;
}

Plant limb_with_delay() {
  Plant limb = limb_with_everything_but_delay();
  turn_on(limb, "input_delay", {{"delay_s", 0.7}});  // longer than from jump to jump: several commands are under way
  return limb;
}

}  // namespace

TEST_CASE("a run that goes on from a checkpoint at a jump ends as the run without one, to the last bit") {
  for (const Plant& limb : {default_plant(), limb_with_everything_but_delay()})
    for (const Method method : {Method::cvode, Method::arkode}) {
      Integrator uninterrupted = in_the_middle(limb, method);
      Integrator watched = in_the_middle(limb, method);
      const Checkpoint checkpoint = watched.checkpoint();
      CHECK(checkpoint.time_s == middle_s);
      Integrator resumed(limb, checkpoint, {.method = method});
      CHECK(resumed.time_s() == middle_s);
      CHECK(resumed.state() == watched.state());
      CHECK(resumed.counters() == watched.counters());
      const End expected = finish(uninterrupted);
      CHECK(finish(watched) == expected);
      CHECK(finish(resumed) == expected);
    }
}

TEST_CASE("a run that goes on from a checkpoint where it was restarted ends as the run that was restarted there") {
  for (const Plant& limb : {default_plant(), limb_with_delay()})
    for (const Method method : {Method::cvode, Method::arkode}) {
      const auto restarted = [&] {
        Integrator run = in_the_middle(limb, method);
        advance(run, middle_s + 0.15);
        run.restart();
        return run;
      };
      Integrator uninterrupted = restarted();
      Integrator watched = restarted();
      const Checkpoint checkpoint = watched.checkpoint();
      CHECK(checkpoint.commands_under_way.size() == (limb.is_on(effect_id("input_delay")) ? 2 : 0));
      Integrator resumed(limb, checkpoint, {.method = method});
      const End expected = finish(uninterrupted);
      CHECK(finish(resumed) == expected);
      CHECK(finish(watched) == expected);
    }
}

TEST_CASE("the method that was chosen at the start stays chosen when a run goes on from a checkpoint") {
  // Dry friction is stiff at rest and not in motion; a stop is stiff only in contact.
  for (const Plant& limb :
       {limb_with("dry_friction", {{"moment_Nm", 0.003}}), limb_with("hard_stop", {{"stiffness_Nm_rad", 50.0}}), default_plant()}) {
    Integrator watched = in_the_middle(limb, Method::automatic);
    Integrator resumed(limb, watched.checkpoint(), {.method = Method::automatic});
    CHECK(finish(resumed).state == finish(watched).state);
  }
}

TEST_CASE("two runs of one limb are the same to the last bit, and a moved run is the run") {
  const Plant limb = limb_with_delay();
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator one = in_the_middle(limb, method), other = in_the_middle(limb, method);
    Integrator moved = std::move(other);
    CHECK(finish(moved) == finish(one));
  }
}

TEST_CASE("a checkpoint of another limb is refused") {
  Integrator run = in_the_middle(default_plant(), Method::cvode);
  CHECK_THROWS_WITH_AS(Integrator(limb_with("thermocouple_lag"), run.checkpoint(), {}), "checkpoint is of another plant",
                       std::invalid_argument);
}

}  // namespace validation_restart_test
