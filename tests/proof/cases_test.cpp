// SPDX-License-Identifier: Apache-2.0
// Which concealed cases there are: further ones come at the end, and leave those before as they were.
#include "proof/cases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "prove/series_limb.h"

namespace proof_cases_test {

using namespace sinew;
using proof::ProofCase;

namespace {

std::vector<ProofCase> cases_of(int seeds) { return proof::proof_cases(proof::reported_seeds, seeds, 8 * seeds, 300.0, 150.0); }

bool is_further(const ProofCase& one) {
  const auto further = prove::further_kinds();
  return one.elsewhere || std::ranges::find(further, one.kind.name, &prove::Kind::name) != further.end();
}

}  // namespace

TEST_CASE("cases: every case has an id of its own, fit for a file name") {
  std::set<std::string> ids;
  for (const ProofCase& one : cases_of(5)) {
    CAPTURE(one.id());
    CHECK(ids.insert(one.id()).second);
    CHECK(std::ranges::all_of(one.id(), [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || std::string("._-+").find(c) != std::string::npos;
    }));
  }
}

TEST_CASE("cases: further kinds and recordings elsewhere come after all that there were before") {
  const auto cases = cases_of(5);
  const auto first = std::ranges::find_if(cases, is_further);
  REQUIRE(first != cases.end());
  // Those before, counted by hand for each seed: 8 clean, 26 of the catalogue twice and a form in its midst, 15 more forms, 12 pairs, and
  // 12 outside, one of which is a form of a name by now; with a junction a named one three times, and four in pairs.
  CHECK(first - cases.begin() == 5 * (8 + 25 * 2 + 2 + 16 + 12 + 12 + 3 + 4 * 2));
  CHECK(std::all_of(first, cases.end(), is_further));
  CHECK(cases.front().id() == "clean-core-plain-1-15001");
  CHECK((first - 1)->id() == "other_form-junction_layer.diffusive-mid_motion-1-13005");
}

TEST_CASE("cases: each further kind has one case for each seed, and each sort of recording elsewhere one in which nothing is missing") {
  const prove::Settings usual{300.0, 150.0, 1.0, {}};
  std::map<std::string, int> of_kind, of_sort;
  std::map<std::string, prove::Settings> settings;
  std::set<std::uint64_t> seeds;
  for (const ProofCase& one : cases_of(2)) {
    if (!one.elsewhere) {
      if (is_further(one)) ++of_kind[one.kind.name];
      continue;
    }
    CHECK(one.family() == "elsewhere");
    CHECK(one.kind.effects.empty());
    CHECK_FALSE(one.with_baselines);
    CHECK(seeds.insert(one.seed).second);
    CHECK(one.seed >= proof::reported_seeds.clean + 500);
    ++of_sort[one.variant];
    settings[one.variant] = one.settings;
    const auto answer = proof::answer_of(one, {});
    CHECK(answer["family"] == "clean");
    CHECK(answer["variant"] == one.variant);
  }
  CHECK(of_kind.size() == prove::further_kinds().size());
  for (const auto& [kind, count] : of_kind) CHECK(count == 2);
  CHECK(of_sort.size() == 16);
  for (const auto& [sort, count] : of_sort) CHECK(count == 2);

  CHECK(settings["2Hz"].sample_rate_Hz == 2.0);
  CHECK(settings["50Hz"].sample_rate_Hz == 50.0);
  CHECK(settings["core_15"].core_spread == 0.15);
  CHECK(settings["20min"].training_s == 1200.0);
  CHECK(settings["2min"].training_s == 120.0);
  CHECK_FALSE(settings["still_air"].disturbances.moving_air);
  CHECK(settings["slow_air"].air == prove::AirMotion::slow);
  CHECK(settings["random_binary"].protocol == prove::Protocol::random_binary);
  // All else is as usual.
  CHECK(settings["slow_air"].training_s == usual.training_s);
  CHECK(settings["20min"].sample_rate_Hz == usual.sample_rate_Hz);
  CHECK(settings["random_binary"].air == usual.air);
}

TEST_CASE("cases: a case of three effects is of the family of triples") {
  const auto cases = cases_of(1);
  CHECK(std::ranges::count(cases, "triple", &ProofCase::family) == 8);
  CHECK(std::ranges::count_if(cases, [](const ProofCase& one) { return one.kind.effects.size() == 3; }) == 8);
}

TEST_CASE("cases: the limb of two segments in series has a family of its own, scored by what is concealed in it") {
  const auto cases = proof::series_proof_cases(proof::reported_seeds, 3, 300.0, 150.0);
  CHECK(cases.size() == 3 * prove::series_kinds().size());
  std::set<std::string> ids;
  for (const ProofCase& one : cases) {
    CAPTURE(one.id());
    CHECK(one.family() == "series_limb");
    CHECK(ids.insert(one.id()).second);
    const bool clean = one.kind.effects.empty();
    CHECK(proof::answer_of(one, {})["family"] == (clean ? "clean" : "catalogue"));
    CHECK(one.seed >= (clean ? proof::reported_seeds.clean : proof::reported_seeds.concealed));
    CHECK((one.settings.strength == 1.0 || !clean));
  }
  CHECK(std::ranges::count_if(cases, [](const ProofCase& one) { return one.settings.strength == 0.25; }) == 5);
}

TEST_CASE("cases: coils that are not alike have a family of their own, sealed by the quantity in which they differ") {
  const auto cases = proof::unlike_proof_cases(proof::reported_seeds, 2, 300.0, 150.0);
  CHECK(cases.size() == 2 * prove::unlike_kinds().size());
  CHECK(cases.front().id() == "unlike-unlike.heating_midpoint_degC-plain-1-13001");
  CHECK(cases.back().settings.strength == 0.5);
  const auto answer = proof::answer_of(cases.front(), prove::make(cases.front().kind, 13001, prove::Settings{1.0, 1.0, 1.0, {}}));
  CHECK(answer["family"] == "unlike");
  CHECK(answer["effects"][0]["form"] == "heating_midpoint_degC");
}

}  // namespace proof_cases_test
