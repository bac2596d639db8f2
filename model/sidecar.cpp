// SPDX-License-Identifier: Apache-2.0
#include "model/sidecar.h"

#include <algorithm>

#include "sim/text.h"

namespace sinew::model {
namespace {

constexpr plant::Range any_value{-1e9, 1e9};

Sidecar::Entry read_entry(const sim::YamlValue& value, bool has_time) {
  sim::YamlMap map(value);
  Sidecar::Entry entry{.column = map.require("column", "a column of the recording").text(), .at_file = value};
  if (has_time) {
    const sim::YamlValue& at = map.require("at", "t or t-1");
    if (at.text() != "t" && at.text() != "t-1") at.complain("must be t or t-1");
    entry.before = at.text() == "t-1";
  }
  entry.lowest = map.require("lowest", "the value that is 0 in the network").number_in(any_value);
  entry.highest = map.require("highest", "the value that is 1 in the network").number_in(any_value);
  map.finish();
  if (!(entry.lowest < entry.highest)) value.complain("lowest must lie below highest");
  return entry;
}

std::string name_of(const std::string& column, bool before) { return column + " at " + (before ? "t-1" : "t"); }

}  // namespace

std::filesystem::path sidecar_of(const std::filesystem::path& weights) { return weights.string() + ".yaml"; }

Sidecar read_sidecar(const std::filesystem::path& file) {
  const sim::YamlValue root = sim::read_yaml(file);
  sim::YamlMap map(root);
  Sidecar sidecar;
  if (const sim::YamlValue& format = map.require("format", "1"); format.whole_number() != 1)
    format.complain("must be 1, the format that this version reads");
  const sim::YamlValue& paper_case = map.require("case", "1 to 4");
  if (paper_case.whole_number() < 1 || paper_case.whole_number() > 4) paper_case.complain("must lie in [1, 4]");
  sidecar.paper_case = static_cast<int>(paper_case.whole_number());
  const sim::YamlValue& method = map.require("method", "published or stateful");
  if (method.text() != "published" && method.text() != "stateful") method.complain("must be published or stateful");
  sidecar.method = method.text();
  const sim::YamlValue& inputs = map.require("inputs", "a list, in the order of the kernel's columns");
  if (inputs.kind != sim::YamlValue::Kind::list) inputs.complain("must be a list, one input an entry");
  for (const sim::YamlValue& input : inputs.list) sidecar.inputs.push_back(read_entry(input, true));
  sidecar.output = read_entry(map.require("output", "the column that is predicted, with lowest and highest"), false);
  map.finish();
  return sidecar;
}

Arrangement arrangement_of(const Sidecar& sidecar, const Task& task) {
  const auto K = static_cast<Index>(task.features.size());
  Arrangement arrangement{std::vector<Index>(static_cast<std::size_t>(2 * K + 1), -1),
                          {Vector<double>::Zero(K), Vector<double>::Ones(K), sidecar.output.lowest,
                           sidecar.output.highest - sidecar.output.lowest}};
  Scaling& scaling = arrangement.scaling;
  if (sidecar.output.column != task.predicted.name)
    sidecar.output.at_file.complain("column must be " + task.predicted.name + ", which is predicted");
  std::vector<bool> scaled(static_cast<std::size_t>(K), false);
  for (std::size_t i = 0; i < sidecar.inputs.size(); ++i) {
    const Sidecar::Entry& entry = sidecar.inputs[i];
    const double span = entry.highest - entry.lowest;
    Index place = -1;
    if (entry.column == task.predicted.name && entry.before) {
      place = 2 * K;
      if (entry.lowest != scaling.y_offset || span != scaling.y_span)
        entry.at_file.complain("lowest and highest must be those of output: what is predicted is fed back");
    }
    for (Index f = 0; f < K; ++f) {
      if (task.features[static_cast<std::size_t>(f)].column.name != entry.column) continue;
      place = entry.before ? K + f : f;
      if (scaled[static_cast<std::size_t>(f)] && (scaling.v_offset(f) != entry.lowest || scaling.v_span(f) != span))
        entry.at_file.complain(entry.column + " has another lowest and highest above; a column has one scaling");
      scaling.v_offset(f) = entry.lowest;
      scaling.v_span(f) = span;
      scaled[static_cast<std::size_t>(f)] = true;
    }
    if (place < 0) entry.at_file.complain(name_of(entry.column, entry.before) + " is no input of case " + std::to_string(task.paper_case));
    if (arrangement.from[static_cast<std::size_t>(place)] >= 0)
      entry.at_file.complain(name_of(entry.column, entry.before) + " stands twice");
    arrangement.from[static_cast<std::size_t>(place)] = static_cast<Index>(i);
  }
  for (Index place = 0; place < 2 * K + 1; ++place)
    if (arrangement.from[static_cast<std::size_t>(place)] < 0)
      sidecar.output.at_file.complain("the list of inputs lacks " +
                                      (place == 2 * K
                                           ? name_of(task.predicted.name, true)
                                           : name_of(task.features[static_cast<std::size_t>(place % K)].column.name, place >= K)));
  return arrangement;
}

}  // namespace sinew::model
