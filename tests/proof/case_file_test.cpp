// SPDX-License-Identifier: Apache-2.0
#include "proof/case_file.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "proof/score_files.h"

namespace case_file_test {

using namespace sinew::proof;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

Json a_result() {
  return Json::parse(R"({"verdict": "named_in_part",
    "effects": [{"name": "lag", "confidence": 0.7, "strength": "time_s", "null": 0.0,
                 "parameters": {"time_s": {"value": 1.5, "ci95": [1.0, 2.0], "known": false}}}],
    "ambiguous_with": ["creep"], "cannot_be_seen": ["slack"], "located": {"place": "thermal", "or": ["mechanics"]},
    "laws": [{"place": "mechanics", "law": {"entry": "moment"}}],
    "visibility": 12.5, "unrest": [3.0, 1.0], "rounds": [{"gain": 9.0, "candidates": [["lag", -1.0, 4.0, 0.0]]}, {"gain": 11.0}],
    "explanations": [{"misfit": 8.0}], "normalised_before": null, "normalised_after": 2.0, "normalised_oracle": 1.5,
    "oracle": {"normalised": 1.25}, "probability_of_nothing": 0.01,
    "baselines": {"bic": {"effects": ["creep"], "weights": {"creep": 0.75}}, "sindy": {"terms": {"a": 2, "b": 3}, "normalised_after": 4.0},
                  "gaussian_process": {"normalised_after": 5.0}}})");
}

}  // namespace

TEST_CASE("case file: everything that a case holds is read") {
  const Reported reported = read_reported(a_result());
  CHECK(reported.verdict == Verdict::named_in_part);
  REQUIRE(reported.effects.size() == 1);
  CHECK(reported.effects[0].probability == 0.7);
  CHECK(reported.effects[0].parameters.at("time_s").highest == 2.0);
  CHECK(reported.ambiguous_with == std::vector<std::string>{"creep"});
  CHECK(reported.cannot_be_seen == std::vector<std::string>{"slack"});
  CHECK(reported.place == "thermal");
  CHECK(reported.places_alike == std::vector<std::string>{"mechanics"});
  REQUIRE(reported.laws.size() == 1);
  CHECK(reported.laws[0].entry == "moment");
  CHECK(reported.largest_gain == 11.0);
  CHECK(reported.core_misfit == 8.0);
  CHECK(reported.first_candidates.at(0).misfit == 4.0);
  CHECK(std::isnan(reported.held_out.before));
  CHECK(reported.held_out.refit == 1.5);
  CHECK(reported.held_out.oracle == 1.25);
  CHECK(reported.probability_of_nothing == 0.01);
  CHECK(reported.baselines->bic_weights.at("creep") == 0.75);
  CHECK_FALSE(reported.baselines->bic_after.has_value());
  CHECK(reported.baselines->sindy_terms == 5);
}

TEST_CASE("case file: what an older or a failed case lacks is not there") {
  Json result = a_result();
  for (const char* key : {"laws", "unrest", "rounds", "explanations", "normalised_oracle", "oracle", "probability_of_nothing", "baselines"})
    result.erase(key);
  const Reported reported = read_reported(result);
  CHECK(reported.laws.empty());
  CHECK_FALSE(reported.held_out.refit.has_value());
  CHECK_FALSE(reported.held_out.oracle.has_value());
  CHECK_FALSE(reported.probability_of_nothing.has_value());
  CHECK_FALSE(reported.baselines.has_value());
  CHECK(reported.first_candidates.empty());
  // An oracle that could not be had says why, and is none.
  result["oracle"] = {{"why_not", "the recording begins in mid-motion"}};
  CHECK_FALSE(read_reported(result).held_out.oracle.has_value());
}

TEST_CASE("case file: a verdict or a family that there is not is an error that names it") {
  Json result = a_result();
  result["verdict"] = "perhaps";
  CHECK_THROWS_WITH(read_reported(result), "no such verdict: perhaps");
  const Json answer{{"family", "quartet"}, {"variant", "plain"}, {"seed", 1}, {"effects", Json::array()}};
  CHECK_THROWS_WITH(read_truth(answer), "no such family: quartet");
}

TEST_CASE("case file: the stored proof is read, and gives the figures of the stored score") {
  const fs::path proof = fs::path(SINEW_SOURCE_DIR) / "results" / "proof";
  const auto json_of = [](const fs::path& file) {
    std::ifstream in(file);
    return Json::parse(in);
  };
  const Json answers = json_of(proof / "answers.json"), stored = json_of(proof / "score.json");
  Json results;
  for (const auto& [id, answer] : answers.items()) results[id] = json_of(proof / "cases" / (id + ".json"));
  const Json score = score_json(score_of(read_cases(answers, results)));
  CHECK(score["cases"] == stored["cases"]);
  CHECK(score["confusion"] == stored["confusion"]);
  CHECK(score["strata"] == stored["strata"]);
  for (const Json& figure : stored["figures"]) {
    INFO(figure.dump());
    bool is_there = false;
    for (const Json& one : score["figures"]) is_there = is_there || one == figure;
    CHECK(is_there);
  }
}

}  // namespace case_file_test
