// SPDX-License-Identifier: Apache-2.0
#include "sim/manifest.h"

#include <openssl/evp.h>
#include <sundials/sundials_config.h>

#include <Eigen/Core>
#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "version.h"

namespace sinew::sim {

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned length = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 failed");
  std::string text;
  for (unsigned i = 0; i < length; ++i) {
    constexpr std::string_view digits = "0123456789abcdef";
    text += digits[digest[i] >> 4];
    text += digits[digest[i] & 15];
  }
  return text;
}

Build this_build() {
  return {SINEW_VERSION, SINEW_COMMIT, std::string("g++ ") + __VERSION__,
          "SUNDIALS " SUNDIALS_VERSION ", Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
              std::to_string(EIGEN_MINOR_VERSION)};
}

std::string run_json(const Scenario& scenario, const RunResult& result, const std::map<std::string, std::string>& files) {
  const Build build = this_build();
  nlohmann::ordered_json json;
  json["program"] = "sinew " + build.version;
  json["commit"] = build.commit;
  json["compiler"] = build.compiler;
  json["libraries"] = build.libraries;
  json["seed"] = scenario.seed;
  json["status"] = result.status == RunStatus::finished ? "finished" : result.status == RunStatus::failed ? "failed" : "stopped";
  if (result.failure) json["failure"] = {{"time_s", result.failure->time_s}, {"reason", result.failure->reason}};
  json["solver"] = {{"steps", result.counters.steps},
                    {"rhs_evaluations", result.counters.rhs_evaluations},
                    {"jacobian_evaluations", result.counters.jacobian_evaluations},
                    {"error_test_failures", result.counters.error_test_failures},
                    {"restarts", result.counters.restarts}};
  for (const auto& [name, content] : files) json["sha256"][name] = sha256(content);
  return json.dump(2) + "\n";
}

}  // namespace sinew::sim
