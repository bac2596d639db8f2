// SPDX-License-Identifier: Apache-2.0
// Ten minutes of babbling with forward sensitivities to 1, 5, 15 and 30 columns, as a multiple of the run without.
//
// Columns are the 24 parameters of the core, then the 6 first values of the states. What a fit would do otherwise is
// differences: one run more for each column.
#include "bench/babbling.h"

using namespace sinew;

int main() {
  const sim::Recording recording = bench::babbling(600.0);
  std::printf("Ten minutes of babbling, core plant, relative tolerance 1e-6. Differences would take 1 + columns runs.\n\n");
  std::printf("| method | columns | ms | times the run without | goal | | differences take longer by |\n|---|---|---|---|---|---|---|\n");
  const std::vector<std::size_t> columns{0, 1, 5, 15, 30};
  constexpr double most_times = 10.0;
  for (const plant::Method method : {plant::Method::cvode, plant::Method::arkode}) {
    std::vector<std::function<void()>> works;
    for (const std::size_t count : columns)
      works.push_back([&, count] {
        bench::replay(recording, {method, 1e-6}, bench::columns(count), plant::default_plant(), bench::given_start());
      });
    const std::vector<double> least_s = bench::fastest_in_turn_s(5, works);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double times = least_s[i] / least_s[0];
      std::printf("| %s | %zu | %.1f | %.1f | %s | %s | %.1f |\n", bench::name_of(method), columns[i], 1e3 * least_s[i], times,
                  columns[i] == 15 ? "at most 10" : "", columns[i] == 15 ? bench::verdict(times <= most_times) : "",
                  static_cast<double>(1 + columns[i]) / times);
    }
  }
  std::printf("\nLeast of 5 repeats in turn; %s.\n", bench::conditions().c_str());
}
