// SPDX-License-Identifier: Apache-2.0
#include "apps/ignore.h"

#include <algorithm>
#include <cmath>
#include <regex>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

[[noreturn]] void refuse(const std::string& value, const std::string& advice) {
  throw sim::InputError({.file = "", .key = "--ignore", .value = value, .advice = advice});
}

struct Ignored {
  std::vector<plant::ChannelId> channels;
  double from_s, to_s;
};

Ignored parsed(const std::string& text, const plant::System& system) {
  static const std::regex form(R"(([A-Za-z0-9_*]+):(-?[0-9.]+(?:e-?[0-9]+)?)-([0-9.]+(?:e-?[0-9]+)?))");
  std::smatch parts;
  const std::string example =
      "CHANNEL:FROM-TO in seconds is meant, such as " + system.channels()[plant::ChannelId{0}].column + ":10.3-11.5";
  if (!std::regex_match(text, parts, form)) refuse(text, example);
  Ignored result{{}, 0.0, 0.0};
  try {
    result.from_s = std::stod(parts[2]);
    result.to_s = std::stod(parts[3]);
  } catch (const std::exception&) {
    refuse(text, example);
  }
  if (!(result.from_s < result.to_s)) refuse(text, "ends before it begins; " + example);
  std::string pattern;
  for (const char c : parts[1].str()) pattern += c == '*' ? std::string(".*") : std::string(1, c);
  std::vector<std::string> all;
  for (const plant::ChannelId c : system.channels().ids()) {
    all.push_back(system.channels()[c].column);
    if (std::regex_match(all.back(), std::regex(pattern)) || std::regex_match(system.channels()[c].short_name, std::regex(pattern)))
      result.channels.push_back(c);
  }
  if (result.channels.empty()) {
    std::string names;
    for (const std::string& name : all) names += (names.empty() ? "" : ", ") + name;
    refuse(text, "no such channel" + sim::did_you_mean(parts[1].str(), all) + "; there are " + names);
  }
  return result;
}

constexpr std::ptrdiff_t least_samples = 20;  // of a channel that is not ignored altogether

std::ptrdiff_t count_measured(const sim::Recording& recording, plant::ChannelId channel) {
  return std::count_if(recording.samples.begin(), recording.samples.end(),
                       [&](const sim::Sample& sample) { return !std::isnan(sample.channels[channel.index]); });
}

}  // namespace

void add_ignore(CLI::App& command, std::vector<std::string>& ignored) {
  command
      .add_option("--ignore", ignored,
                  "CHANNEL:FROM-TO: seconds of a channel that are not to be trusted, separated by commas; a star in CHANNEL stands for any "
                  "letters")
      ->delimiter(',');
}

void ignore(const std::vector<std::string>& ignored, const plant::System& system, const std::vector<sim::Recording*>& recordings) {
  for (const std::string& text : ignored) {
    const Ignored one = parsed(text, system);
    bool inside = false;
    for (sim::Recording* recording : recordings) {
      std::vector<bool> was;
      for (const plant::ChannelId c : one.channels) was.push_back(count_measured(*recording, c) >= least_samples);
      for (sim::Sample& sample : recording->samples) {
        if (sample.time_s < one.from_s || sample.time_s > one.to_s) continue;
        inside = true;
        for (const plant::ChannelId c : one.channels) sample.channels[c.index] = sim::not_a_number;
      }
      for (std::size_t k = 0; k < one.channels.size(); ++k)
        if (was[k] && count_measured(*recording, one.channels[k]) < least_samples)
          refuse(text, "leaves fewer than 20 samples of " + system.channels()[one.channels[k]].column + " in " + recording->name);
    }
    if (!inside)
      refuse(text, "no sample lies there; " + recordings.front()->name + " goes from " +
                       sim::shortest(recordings.front()->samples.front().time_s) + " to " +
                       sim::shortest(recordings.front()->samples.back().time_s) + " s");
  }
}

}  // namespace sinew::apps
