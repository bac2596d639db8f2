// SPDX-License-Identifier: Apache-2.0
#include "sim/manifest.h"

#include <doctest/doctest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace sim_manifest_test {

using namespace sinew::sim;

TEST_CASE("manifest: hashes are those of FIPS 180-4") {
  // The examples of the standard.
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  // A byte of zero counts: by Python's hashlib.
  CHECK(sha256(std::string(1, '\0')) == "6e340b9cffb37a989ca544e6bb780a2c78901d3fb33738768511a30617afa01d");
}

TEST_CASE("manifest: run.json says what made the result") {
  Scenario scenario;
  scenario.seed = 4711;
  RunResult result;
  result.counters = {11, 22, 33, 44, 55};
  const auto json = nlohmann::json::parse(run_json(scenario, result, {{"recording.csv", "abc"}, {"truth.csv", ""}}));
  CHECK(json.at("program") == "sinew " + this_build().version);
  CHECK(json.at("commit") == this_build().commit);
  CHECK(json.at("compiler").get<std::string>().starts_with("g++ "));
  CHECK(json.at("libraries").get<std::string>().find("SUNDIALS 6.") != std::string::npos);
  CHECK(json.at("seed") == 4711);
  CHECK(json.at("status") == "finished");
  CHECK(json.at("solver").at("steps") == 11);
  CHECK(json.at("solver").at("rhs_evaluations") == 22);
  CHECK(json.at("solver").at("jacobian_evaluations") == 33);
  CHECK(json.at("solver").at("error_test_failures") == 44);
  CHECK(json.at("solver").at("restarts") == 55);
  CHECK(json.at("sha256").size() == 2);
  CHECK(json.at("sha256").at("recording.csv") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(json.at("sha256").at("truth.csv") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST_CASE("manifest: run.json has no date, no host and no duration, and is the same each time") {
  const std::string text = run_json({}, {}, {{"recording.csv", "abc"}});
  CHECK(text == run_json({}, {}, {{"recording.csv", "abc"}}));
  CHECK(text.back() == '\n');
  std::set<std::string> keys;
  const auto json = nlohmann::json::parse(text);
  for (const auto& [key, value] : json.items()) keys.insert(key);
  CHECK(keys == std::set<std::string>{"program", "commit", "compiler", "libraries", "seed", "status", "solver", "sha256"});
}

TEST_CASE("manifest: a failed run says so, with the time and the reason; a stopped one too") {
  RunResult result;
  result.status = RunStatus::failed;
  result.failure = sinew::plant::IntegrationFailure{12.5, "the words of the solver"};
  const auto failed = nlohmann::json::parse(run_json({}, result, {}));
  CHECK(failed.at("status") == "failed");
  CHECK(failed.at("failure").at("time_s") == 12.5);
  CHECK(failed.at("failure").at("reason") == "the words of the solver");
  CHECK_FALSE(failed.contains("sha256"));
  result = {};
  result.status = RunStatus::stopped;
  CHECK(nlohmann::json::parse(run_json({}, result, {})).at("status") == "stopped");
}

}  // namespace sim_manifest_test
