// SPDX-License-Identifier: Apache-2.0
#include "diagnose/columns.h"

#include <algorithm>
#include <cmath>

#include "diagnose/open_loop.h"
#include "sim/text.h"

namespace sinew::diagnose {
namespace {

constexpr double hottest_room_degC = 200.0;  // what never falls below it is no temperature in a room
constexpr double most_bend_rad = 1.6;        // a plant that is bent by more than 90 degrees is not meant
constexpr double least_ratio = 20.0;         // between degrees and radians there are 57
constexpr std::size_t least_samples = 20;

struct Range {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  double width() const { return highest - lowest; }
  bool none() const { return !(width() >= 0.0); }
  std::string words() const { return sim::shortest(lowest) + " to " + sim::shortest(highest); }
};

Range range_of(const std::vector<double>& values) {
  Range range;
  for (const double value : values)
    if (std::isfinite(value)) {
      range.lowest = std::min(range.lowest, value);
      range.highest = std::max(range.highest, value);
    }
  return range;
}

// Of model and measurement, each about its own mean, where both are there; NaN where that is hardly ever.
double squared_distance(const std::vector<double>& model, const std::vector<double>& target) {
  double n = 0.0, mean = 0.0, square = 0.0;
  for (std::size_t k = 0; k < model.size(); ++k)
    if (const double off = target[k] - model[k]; std::isfinite(off)) {
      ++n;
      const double step = off - mean;
      mean += step / n;
      square += step * (off - mean);
    }
  return n < least_samples ? std::nan("") : square / n;
}

}  // namespace

std::optional<MistakenColumn> mistaken_column(const plant::Plant& nominal, const sim::Recording& recording) {
  const auto& channels = nominal.system().channels();
  Series target(channels.size(), {});
  for (const sim::Sample& sample : recording.samples)
    for (const plant::ChannelId c : channels.ids()) target[c].push_back(measured(sample, c));
  const auto mistaken = [&](plant::ChannelId c, const std::string& why) {
    return MistakenColumn{channels[c].column, range_of(target[c]).words(), why};
  };
  for (const plant::ChannelId c : channels.ids())
    if (const Range range = range_of(target[c]);
        channels[c].unit.text == plant::units::degC.text && !range.none() && range.lowest > hottest_room_degC)
      return mistaken(c, "never falls below 200 degC: it seems to be in kelvin; subtract 273.15");

  const Series model = predict(nominal, {}, recording, {plant::Method::rosenbrock, 1e-5});
  for (const plant::ChannelId c : channels.ids()) {
    if (channels[c].unit.text != plant::units::deg.text) continue;
    const Range range = range_of(target[c]);
    if (!range.none() && range.width() > 0.0 && std::max(-range.lowest, range.highest) < most_bend_rad &&
        range_of(model[c]).width() > least_ratio * range.width())
      return mistaken(c, "the plant bends " + sim::shortest(std::round(range_of(model[c]).width() / range.width())) +
                             " times as far: it seems to be in radians; multiply by 57.29578");
  }
  for (const plant::ChannelId c : channels.ids())
    for (const plant::ChannelId other : channels.ids()) {
      if (!(c < other) || channels[c].kind != channels[other].kind || !channels[c].driven_by) continue;
      const double as_named = squared_distance(model[c], target[c]) + squared_distance(model[other], target[other]);
      const double exchanged = squared_distance(model[c], target[other]) + squared_distance(model[other], target[c]);
      if (4.0 * exchanged < as_named)
        return mistaken(c, "the plant is " + sim::shortest(std::round(std::sqrt(as_named / exchanged))) + " times nearer to " +
                               channels[other].column + ", and the other way round: the two, or " +
                               nominal.system().inputs()[*channels[c].driven_by].column + " and " +
                               nominal.system().inputs()[*channels[other].driven_by].column + ", seem to be exchanged");
    }
  return std::nullopt;
}

}  // namespace sinew::diagnose
