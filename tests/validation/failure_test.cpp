// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "plant/integrator.h"
#include "tests/plant/limb/one_instant.h"
#include "tests/validation/drive.h"

namespace validation_failure_test {

using namespace sinew::plant;
using namespace sinew::test;

namespace {

bool names_a_state(const Integrator& run, const std::string& text) {
  for (const StateInfo& state : run.states())
    if (text.find(state.key) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("an integration that would take too many steps fails, says so, and names the states it could not follow") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(default_plant(), Start{}, {.method = method, .most_steps = 1});
    run.hold({0.6, 0.0});
    const auto failure = run.advance_to(10.0);
    REQUIRE(failure);
    CHECK(failure->time_s >= 0.0);
    CHECK(failure->time_s < 10.0);
    CHECK(failure->reason.find("mxstep steps taken") != std::string::npos);
    CHECK(failure->reason.find("largest errors: ") != std::string::npos);
    CHECK(names_a_state(run, failure->reason));
    CHECK(run.time_s() < 10.0);
  }
}

TEST_CASE("a failure later on leaves time and state where they were last good") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(default_plant(), Start{}, {.method = method, .most_steps = 60});
    run.hold({0.6, 0.0});
    double last_good_s = 0.0;
    std::vector<double> last_good = run.state();
    std::optional<IntegrationFailure> failure;
    for (const double time_s : {0.1, 0.2, 30.0}) {
      failure = run.advance_to(time_s);
      if (failure) break;
      last_good_s = time_s;
      last_good = run.state();
    }
    REQUIRE(failure);
    CHECK(last_good_s == 0.2);
    CHECK(failure->time_s >= last_good_s);
    CHECK(run.time_s() == last_good_s);
    CHECK(run.state() == last_good);
  }
}

TEST_CASE("a rate that is not a number is a failure and no state") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(default_plant(), Start{}, {.method = method});
    run.hold({std::numeric_limits<double>::quiet_NaN(), 0.0});
    const auto failure = run.advance_to(1.0);
    REQUIRE(failure);
    CHECK(failure->reason.find("right-hand side") != std::string::npos);
    for (const double value : run.state()) CHECK(std::isfinite(value));
  }
}

TEST_CASE("with sensitivities, too, a failure is a value") {
  for (const Method method : {Method::cvode, Method::arkode}) {
    Integrator run(default_plant(), Start{}, {.method = method, .most_steps = 1}, {{ParameterId{0}, ParameterId{1}}, {}});
    run.hold({0.6, 0.0});
    const auto failure = run.advance_to(10.0);
    REQUIRE(failure);
    CHECK(names_a_state(run, failure->reason));
  }
}

}  // namespace validation_failure_test
