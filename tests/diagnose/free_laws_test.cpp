// SPDX-License-Identifier: Apache-2.0
#include "diagnose/free_laws.h"

#include <doctest/doctest.h>

#include <cmath>

#include "diagnose/proposals.h"
#include "tests/diagnose/one_limb.h"
#include "tests/long_when_sanitized.h"

namespace diagnose_free_laws_test {

using namespace sinew;

namespace {

using testing::group;
using testing::variable;

// The thermocouples read too much in the middle of their range: no effect of the catalogue.
plant::Law bow() {
  plant::Law law{.entry = group("temperature_reading"),
                 .argument = {variable("temperature A"), variable("temperature B")},
                 .factor = {},
                 .knots = {},
                 .curve = Eigen::VectorXd(17)};
  for (int k = 0; k < 17; ++k) {
    law.knots.push_back(20.0 + 5.0 * k);
    law.curve(k, 0) = 4.0 * std::sin(M_PI * (law.knots.back() - 20.0) / 80.0);
  }
  return law;
}
sim::Scenario bowed() {
  sim::Scenario scenario = testing::babbling(90.0);
  scenario.plant = plant::with_laws_on(plant::default_plant(), {bow()});
  return scenario;
}

}  // namespace

TEST_CASE("free laws: the screening puts the cell that is there first, and time is none") {
  const testing::FittedCore limb(bowed());
  diagnose::ExplanationSettings least_squares = limb.settings;
  least_squares.least_squares = true;
  least_squares.most_rounds = 1;
  auto data = limb.data;
  data[0].deviation = diagnose::PerChannel({1.0, 1.0, 0.5});
  const diagnose::Explanation core = diagnose::explain(plant::default_plant(), data, {}, least_squares);
  REQUIRE(core.usable);
  const auto cells = diagnose::screen_laws(core, 2);
  REQUIRE(cells.size() > 50);
  CHECK(cells.front().law.entry == group("temperature_reading"));
  CHECK(cells.front().law.argument == bow().argument);
  CHECK(cells.front().law.fading_memory_s == 0.0);
  CHECK(cells.front().gain > 10.0);
  for (std::size_t i = 1; i < cells.size(); ++i) CHECK(cells[i].gain <= cells[i - 1].gain);
  for (const auto& cell : cells) {
    CHECK(cell.law.argument.front() != variable("time"));
    CHECK(cell.law.knots.size() == 24);
    CHECK(cell.weights.size() == cell.law.curve.cols());
  }
  const auto alone = diagnose::screen_laws(core, 1);
  REQUIRE(alone.size() == cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) CHECK(alone[i].gain == cells[i].gain);
}

TEST_CASE("free laws: physics without a name is modelled, and its curve is the one that is there" * long_when_sanitized) {
  const testing::FittedCore limb(bowed());
  diagnose::ProposalSettings settings;
  settings.most_effects = 1;
  settings.starts = 1;
  settings.most_laws = 1;
  for (const plant::EffectId e : testing::limb_system().effects().ids())
    if (testing::limb_system().effects()[e].name != "thermocouple_lag") settings.without.push_back(e);
  const diagnose::Fitted core = diagnose::polished(limb.core, limb.data, limb.settings);
  const diagnose::Proposals found = diagnose::propose(core, limb.data, settings, limb.settings);
  const diagnose::Proposal& answer = found.all.at(found.answer);
  REQUIRE(answer.effects.size() == 1);
  const auto& effect = found.system->effects()[answer.effects[0]];
  REQUIRE(effect.law);
  const plant::Law& law = found.system->laws()[*effect.law];
  CHECK(law.entry == group("temperature_reading"));
  CHECK(law.argument == bow().argument);
  CHECK(found.cells > 50);
  // A straight part is what the heat capacities absorb; what is curved is not: against the chord, the bow.
  const Eigen::VectorXd values = plant::values_of(answer.fit.model(), answer.effects[0]);
  const auto at = [](const std::vector<double>& x, const Eigen::VectorXd& y, double where) {
    std::size_t k = 1;
    while (k + 1 < x.size() && x[k] < where) ++k;
    const double share = (where - x[k - 1]) / (x[k] - x[k - 1]);
    const auto i = static_cast<Eigen::Index>(k);
    return y(i - 1) + share * (y(i) - y(i - 1));
  };
  const auto curved = [&](const std::vector<double>& x, const Eigen::VectorXd& y) {
    return at(x, y, 55.0) - 0.5 * (at(x, y, 35.0) + at(x, y, 75.0));
  };
  const plant::Law truth = bow();
  CHECK(curved(law.knots, values) == doctest::Approx(curved(truth.knots, truth.curve)).epsilon(0.25));
  const auto left = diagnose::spread_of(diagnose::fitted(answer.fit), limb.data, limb.settings.numerics).rmse[0];
  CHECK(left[testing::temperature_A] < 0.5);  // 1.3 K without
}

TEST_CASE("free laws: closed forms that lie within a band, and none where none does") {
  const std::vector<double> x{-3, -2, -1, -0.2, 0.2, 1, 2, 3};
  const std::vector<double> narrow(8, 0.0);
  const auto words = [&](auto&& f, const std::vector<double>& band) {
    std::vector<double> y;
    for (const double at : x) y.push_back(f(at));
    std::vector<std::string> names;
    for (const auto& form : diagnose::forms_within(x, y, band)) names.push_back(form.words);
    return names;
  };
  CHECK(words([](double a) { return 2.0 - 3.0 * a; }, narrow).front() == "a line");
  CHECK(words([](double a) { return 1.0 + a * a; }, narrow) == std::vector<std::string>{"a parabola about zero"});
  CHECK(words([](double a) { return a * a * a; }, narrow).front() == "a cube");
  CHECK(words([](double a) { return a > 0.0 ? 1.0 : -1.0; }, narrow).front() == "a step");
  CHECK(words([](double a) { return std::sin(3.0 * a); }, narrow).empty());
  CHECK(words([](double a) { return std::sin(3.0 * a); }, std::vector<double>(8, 2.0)).size() == 8);
  CHECK(words([](double) { return 1.0; }, narrow).empty());  // no curve
}

}  // namespace diagnose_free_laws_test
