// SPDX-License-Identifier: Apache-2.0
#include "sim/table.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace sim_table_test {

using namespace sinew::sim;

TEST_CASE("table: as CSV, a missing value is an empty field and numbers read back the same") {
  const double missing = std::numeric_limits<double>::quiet_NaN();
  const Table table{{"from the bench", "", "two\nlines"}, {{"time_s", {0.0, 0.1, 1e-9}}, {"level_V", {5.205, missing, 0.1 + 0.2}}}};
  CHECK(to_csv(table) == "# from the bench\n#\n# two\n# lines\ntime_s,level_V\n0,5.205\n0.1,\n1e-09,0.30000000000000004\n");
  CHECK(table.rows() == 3);
  REQUIRE(table.find("level_V") != nullptr);
  CHECK(table.find("level_V")->values[0] == 5.205);
  CHECK(table.find("level") == nullptr);
}

TEST_CASE("table: the lower median") {
  CHECK(lower_median({3.0, 1.0, 2.0}) == 2.0);
  CHECK(lower_median({4.0, 1.0, 2.0, 3.0}) == 2.0);
  CHECK(std::isnan(lower_median({})));
}

}  // namespace sim_table_test
