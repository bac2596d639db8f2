// SPDX-License-Identifier: Apache-2.0
#include "model/set.h"

#include <doctest/doctest.h>

#include <unistd.h>
#include <filesystem>
#include <set>

#include "sim/input_error.h"
#include "sim/text.h"

namespace model_set_test {

using namespace sinew;
using namespace sinew::model;

namespace {

SetPlan plan_of(const std::string& domain) {
  SetPlan plan;
  plan.scenario = sim::parse_scenario(
      "format: 1\nseed: 3\nduration_s: 5\nplant: { base: paper_limb }\ninput: { babble: { lowest_deg: -45, highest_deg: 45 } }\n",
      "s.yaml");
  plan.scenario_yaml = sim::to_yaml(plan.scenario);
  plan.domain = read_domain(sim::parse_yaml(domain, "domain.yaml"), plan.scenario.plant.system());
  plan.domain_text = domain;
  plan.runs = 3;
  return plan;
}
std::string message(const std::string& domain) {
  try {
    plan_of(domain);
  } catch (const sim::InputError& e) {
    return e.what();
  }
  return "nothing thrown";
}
struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("sinew_set_" + std::to_string(::getpid()));
  ~Folder() { std::filesystem::remove_all(path); }
};
std::vector<sim::Recording> recordings_of(const std::filesystem::path& set, std::int64_t most = 1000) {
  std::vector<sim::Recording> all;
  visit_set(set, {}, most, [&](sim::Recording one) { all.push_back(std::move(one)); });  // a set says its columns
  return all;
}
const std::string domain =
    "parameters: { heat_loss_A_W_K: { relative_deviation: 0.1 }, ambient_temperature_degC: { lowest: 20, highest: 30 } }\n"
    "effects: { thermocouple_lag: { probability: 0.5, time_constant_s: { lowest: 1, highest: 2 } } }\n"
    "sensors: { angle: { noise_deg: 0.2 } }\n";

}  // namespace

TEST_CASE("domain: draws lie where they were told, differ from run to run, and one more leaves the others as they were") {
  const SetPlan plan = plan_of(domain), more = plan_of(domain + "input: { longest_hold_s: { lowest: 10, highest: 20 } }\n");
  std::set<double> ambient;
  int lagging = 0;
  for (std::int64_t run = 0; run < 200; ++run) {
    const DrawnRun one = drawn_run(plan.scenario, plan.domain, run);
    const plant::System& system = one.scenario.plant.system();
    const double loss = one.scenario.plant.get(system.parameter("heat_loss_A_W_K")),
                 room = one.scenario.plant.get(system.parameter("ambient_temperature_degC"));
    CHECK(std::abs(loss / 0.040 - 1.0) <= 0.25);  // cut at 2.5 deviations
    CHECK((room >= 20.0 && room <= 30.0));
    CHECK(one.scenario.sensors[system.channel("angle_deg").index].noise == 0.2);
    ambient.insert(room);
    lagging += one.scenario.plant.is_on(system.effect("thermocouple_lag"));
    CHECK(drawn_run(more.scenario, more.domain, run).scenario.plant == one.scenario.plant);
  }
  CHECK(ambient.size() == 200);
  // 200 throws of a coin: between 70 and 130 but once in 20,000 times; the seed is fixed.
  CHECK((lagging > 70 && lagging < 130));
}
TEST_CASE("domain: what makes no scenario together is an error") {
  const SetPlan plan = plan_of("sensors: { angle: { stuck_from_s: 2 } }\n");
  CHECK_THROWS_AS(drawn_run(plan.scenario, plan.domain, 0), sim::InputError);
  const SetPlan other = plan_of("input: { lowest_deg: 10, highest_deg: -10 }\n");
  CHECK_THROWS_AS(drawn_run(other.scenario, other.domain, 0), sim::InputError);
}
TEST_CASE("domain: what is not there is an error with the place and what is near") {
  CHECK(message("parameters: { heat_los_A_W_K: 0.04 }") ==
        "domain.yaml:1:31: parameters.heat_los_A_W_K = 0.04\n  no such number to draw; did you mean heat_loss_A_W_K?");
  CHECK(
      message("parameters: { heat_loss_A_W_K: { lowest: 2 } }").find("must give relative_deviation, or deviation, or lowest and highest") !=
      std::string::npos);
  CHECK(message("sensors: { angle: { noise_degC: 1 } }").find("no such number of this sensor") != std::string::npos);
}
TEST_CASE("set: of a plant with other inputs and channels, it has its columns") {
  const Folder one;
  SetPlan plan;
  plan.scenario = sim::parse_scenario(
      "format: 1\nduration_s: 2\nplant:\n  format: 2\n  limb:\n    segments: [{ name: limb, axes: 1 }]\n"
      "    coils: [{ name: L, segment: limb, direction_deg: 0 }]\n    channels: [{ column: angle_deg, bend: limb }]\n"
      "input: { duty_L: { constant: { value_fraction: 0.3 } } }\n",
      "s.yaml");
  plan.scenario_yaml = sim::to_yaml(plan.scenario);
  plan.domain =
      read_domain(sim::parse_yaml("parameters: { heat_loss_L_W_K: { relative_deviation: 0.1 } }\nsensors: { angle: { bias_deg: 1 } }\n",
                                  "d.yaml"),
                  plan.scenario.plant.system());
  plan.runs = 1;
  CHECK_THROWS_WITH(read_domain(sim::parse_yaml("sensors: { temperature_A: { bias_degC: 1 } }\n", "d.yaml"), plan.scenario.plant.system()),
                    doctest::Contains("no such sensor; there are angle"));
  const std::string manifest = manifest_of(plan, {*make_part(plan, one.path, 0)});
  CHECK(set_in_hdf5(plan, one.path, manifest) == set_in_hdf5(plan, one.path, manifest));
  sim::write_file_whole(one.path / "manifest.json", manifest);
  CHECK(manifest.find("\"time_s, duty_L, angle_deg\"") != std::string::npos);
  CHECK(sim::columns_of(*system_of_set(one.path)) == sim::columns_of(plan.scenario.plant.system()));
  CHECK(system_of_set(one.path / "runs/0000.csv") == nullptr);
  const auto recordings = recordings_of(one.path);
  REQUIRE(recordings.size() == 1);
  CHECK(recordings[0].samples[1].inputs == std::vector<double>{0.3});
}
TEST_CASE("domain: those that are shipped are read, and draw from what is there") {
  const SetPlan plan = plan_of(domain);
  for (const std::string name : {"domain", "one_limb"}) {
    const Domain shipped =
        read_domain(std::filesystem::path(SINEW_SOURCE_DIR) / "scenarios" / (name + ".yaml"), plan.scenario.plant.system());
    CHECK(drawn_run(plan.scenario, shipped, 0).drawn.size() >= 9);
  }
}
TEST_CASE("set: made in any order and taken up again, it has the same bytes; a run that was changed is refused") {
  const Folder one, other;
  const SetPlan plan = plan_of(domain);
  const std::filesystem::path a = one.path / "a", b = one.path / "b";
  for (const std::int64_t part : {0, 1, 2}) make_part(plan, a, part);
  for (const std::int64_t part : {2, 0, 1}) make_part(plan, b, part);
  const auto manifest = [&](const std::filesystem::path& folder) {
    std::vector<SetPart> parts;
    for (const std::int64_t part : {0, 1, 2}) parts.push_back(part_in(plan, folder, part).value());
    return manifest_of(plan, parts);
  };
  CHECK(manifest(a) == manifest(b));
  CHECK(set_in_hdf5(plan, a, "") == set_in_hdf5(plan, b, ""));
  CHECK_FALSE(part_in(plan_of("parameters: {}"), a, 1));  // of another plan
  CHECK_THROWS_AS(recordings_of(a), sim::InputError);     // no manifest yet
  sim::write_file_whole(a / "manifest.json", manifest(a));
  CHECK(recordings_of(a).size() == 3);
  sim::write_file_whole(a / "runs/0001.csv", sim::read_file(a / "runs/0000.csv"));
  CHECK_FALSE(part_in(plan, a, 1));
  CHECK_THROWS_AS(recordings_of(a), sim::InputError);
}
TEST_CASE("set: with several runs a part, it has the recordings of one with one run a part, and a few of them lie evenly") {
  const Folder one;
  SetPlan single = plan_of(domain), several = plan_of(domain);
  single.runs = several.runs = 7;
  several.most_parts = 3;
  CHECK(several.runs_in_part() == 3);
  CHECK(several.parts() == 3);
  CHECK(several.runs_of(2).count == 1);
  const auto made = [&](const SetPlan& plan, const std::string& name) {
    std::vector<SetPart> parts;
    for (std::int64_t part = 0; part < plan.parts(); ++part) parts.push_back(*make_part(plan, one.path / name, part));
    sim::write_file_whole(one.path / name / "manifest.json", manifest_of(plan, parts));
    return recordings_of(one.path / name);
  };
  const auto alone = made(single, "single"), together = made(several, "several");
  REQUIRE(alone.size() == 7);
  REQUIRE(together.size() == 7);
  for (std::size_t run = 0; run < 7; ++run) CHECK(sim::to_csv(alone[run]) == sim::to_csv(together[run]));
  CHECK(std::distance(std::filesystem::directory_iterator(one.path / "several/runs"), {}) == 6);
  CHECK(part_in(several, one.path / "several", 2));
  CHECK_FALSE(part_in(single, one.path / "several", 0));
  std::string wrong = manifest_of(several, {});
  wrong.replace(wrong.find("\"runs_in_part\": 3"), 17, "\"runs_in_part\": 0");
  std::filesystem::create_directories(one.path / "wrong");
  sim::write_file_whole(one.path / "wrong/manifest.json", wrong);
  CHECK_THROWS_WITH(recordings_of(one.path / "wrong"), doctest::Contains("must be at least 1"));
  const auto some = recordings_of(one.path / "several", 3);  // runs 0, 2, 4
  REQUIRE(some.size() == 3);
  CHECK(sim::to_csv(some[1]) == sim::to_csv(alone[2]));
  CHECK(sim::to_csv(some[2]) == sim::to_csv(alone[4]));
}

}  // namespace model_set_test
