// SPDX-License-Identifier: Apache-2.0
// Time against the length of a recording, and against the number of columns of the sensitivities: both should be linear.
#include "bench/babbling.h"

using namespace sinew;

namespace {

// Slope of the least-squares line through (log x, log y).
double exponent(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0.0, mean_y = 0.0, above = 0.0, below = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += std::log(x[i]) / static_cast<double>(x.size());
    mean_y += std::log(y[i]) / static_cast<double>(x.size());
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    above += (std::log(x[i]) - mean_x) * (std::log(y[i]) - mean_y);
    below += (std::log(x[i]) - mean_x) * (std::log(x[i]) - mean_x);
  }
  return above / below;
}

}  // namespace

int main() {
  const sim::Recording longest = bench::babbling(36000.0);

  std::printf("Core plant, babbling, relative tolerance 1e-6, replay without sensitivities.\n\n");
  std::printf(
      "| length [s] | CVODE [s] | ARKODE [s] | CVODE [us a simulated second] | ARKODE [us a simulated second] |\n"
      "|---|---|---|---|---|\n");
  const std::vector<double> durations_s{600.0, 1800.0, 3600.0, 10800.0, 36000.0};
  std::vector<double> cvode_s, arkode_s;
  for (const double duration_s : durations_s) {
    const sim::Recording part = bench::first_part(longest, duration_s);
    const std::vector<double> least_s =
        bench::fastest_in_turn_s(duration_s > 10000.0 ? 2 : 5, {[&] {
                                                                  bench::replay(part, {plant::Method::cvode, 1e-6});
                                                                },
                                                                [&] {
                                                                  bench::replay(part, {plant::Method::arkode, 1e-6});
                                                                }});
    cvode_s.push_back(least_s[0]);
    arkode_s.push_back(least_s[1]);
    std::printf("| %.0f | %.3f | %.3f | %.1f | %.1f |\n", duration_s, least_s[0], least_s[1], 1e6 * least_s[0] / duration_s,
                1e6 * least_s[1] / duration_s);
  }
  const double cvode_exponent = exponent(durations_s, cvode_s), arkode_exponent = exponent(durations_s, arkode_s);
  const auto linear = [](double e) { return bench::verdict(std::abs(e - 1.0) < 0.1); };
  std::printf("\nExponent of time in length (log-log fit; goal: 1 within 0.1): CVODE %.2f (%s), ARKODE %.2f (%s).\n\n", cvode_exponent,
              linear(cvode_exponent), arkode_exponent, linear(arkode_exponent));

  const sim::Recording ten_minutes = bench::first_part(longest, 600.0);
  std::printf("Ten minutes with sensitivities; columns are computed 16 at a time by ARKODE, one by one by CVODES.\n\n");
  std::printf("| columns | CVODE [ms] | ARKODE [ms] | CVODE [ms a column more] | ARKODE [ms a column more] |\n|---|---|---|---|---|\n");
  const auto time_with = [&](std::size_t count) {
    const plant::SensitivityRequest request = bench::columns(count);
    return bench::fastest_in_turn_s(
        3, {[&] {
              bench::replay(ten_minutes, {plant::Method::cvode, 1e-6}, request, plant::default_plant(), bench::given_start());
            },
            [&] {
              bench::replay(ten_minutes, {plant::Method::arkode, 1e-6}, request, plant::default_plant(), bench::given_start());
            }});
  };
  const std::vector<double> without_s = time_with(0);
  std::vector<double> counts, cvode_more_s, arkode_more_s;
  for (const std::size_t count : {1, 2, 4, 8, 16, 32}) {
    const std::vector<double> least_s = time_with(count);
    counts.push_back(static_cast<double>(count));
    cvode_more_s.push_back(least_s[0] - without_s[0]);
    arkode_more_s.push_back(least_s[1] - without_s[1]);
    std::printf("| %zu | %.1f | %.1f | %.2f | %.2f |\n", count, 1e3 * least_s[0], 1e3 * least_s[1],
                1e3 * cvode_more_s.back() / counts.back(), 1e3 * arkode_more_s.back() / counts.back());
  }
  const double cvode_columns = exponent(counts, cvode_more_s), arkode_columns = exponent(counts, arkode_more_s);
  const auto at_most_linear = [](double e) { return bench::verdict(e < 1.1); };
  std::printf(
      "\nExponent of the time above the run without (%.1f, %.1f ms) in columns (goal: at most 1.1): CVODE %.2f (%s), "
      "ARKODE %.2f (%s). Columns 31 and 32 repeat the first two.\n",
      1e3 * without_s[0], 1e3 * without_s[1], cvode_columns, at_most_linear(cvode_columns), arkode_columns, at_most_linear(arkode_columns));
  std::printf("\nLeast of 2 to 5 repeats in turn; %s.\n", bench::conditions().c_str());
}
