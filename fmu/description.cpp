// SPDX-License-Identifier: Apache-2.0
#include "fmu/description.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "fmu/variables.h"
#include "plant/integrator.h"
#include "sim/text.h"

namespace sinew::fmu {
namespace {

std::string attribute(const char* name, std::string_view value) {
  std::string text = std::string(" ") + name + "=\"";
  for (const char c : value) text += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  return text + '"';
}

std::string attribute(const char* name, double value) { return std::isfinite(value) ? attribute(name, sim::shortest(value)) : ""; }

constexpr std::array base_units{"kg", "m", "s", "A", "K", "rad"};  // FMI's order; no plant has mol or cd
struct InBaseUnits {
  std::array<int, base_units.size()> exponents{};
  double factor = 1.0;
};
const std::map<std::string_view, InBaseUnits> known_units{
    {"1", {}},
    {"kg", {{1}}},
    {"m", {{0, 1}}},
    {"s", {{0, 0, 1}}},
    {"A", {{0, 0, 0, 1}}},
    {"K", {{0, 0, 0, 0, 1}}},
    {"rad", {{0, 0, 0, 0, 0, 1}}},
    {"deg", {{0, 0, 0, 0, 0, 1}, plant::radians_per_degree}},
    {"N", {{1, 1, -2}}},
    {"J", {{1, 2, -2}}},
    {"W", {{1, 2, -3}}},
    {"V", {{1, 2, -3, -1}}},
    {"Ohm", {{1, 2, -3, -2}}},
};

// Of "N*m*s/rad": factors, each with `*` or `/` before it and perhaps `^` and a digit behind. Nothing where a factor is not known.
std::optional<InBaseUnits> in_base_units(std::string_view text) {
  InBaseUnits result;
  for (int sign = 1; !text.empty();) {
    const std::size_t end = std::min(text.find_first_of("*/"), text.size());
    std::string_view symbol = text.substr(0, end);
    int power = sign;
    if (const std::size_t hat = symbol.find('^'); hat != std::string_view::npos && hat + 2 == symbol.size()) {
      power *= symbol.back() - '0';
      symbol = symbol.substr(0, hat);
    }
    const auto known = known_units.find(symbol);
    if (known == known_units.end()) return std::nullopt;
    for (std::size_t k = 0; k < base_units.size(); ++k) result.exponents[k] += power * known->second.exponents[k];
    result.factor *= std::pow(known->second.factor, power);
    sign = end < text.size() && text[end] == '/' ? -1 : 1;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return result;
}

std::string unit_definition(std::string_view unit) {
  const bool celsius = unit == "degC";
  const auto base = in_base_units(celsius ? "K" : unit);
  std::string text = "    <Unit" + attribute("name", unit);
  if (!base) return text + "/>\n";
  text += "><BaseUnit";
  for (std::size_t k = 0; k < base_units.size(); ++k)
    if (base->exponents[k] != 0) text += attribute(base_units[k], std::to_string(base->exponents[k]));
  if (base->factor != 1.0) text += attribute("factor", base->factor);
  if (celsius) text += attribute("offset", 273.15);
  return text + "/></Unit>\n";
}

std::string scalar_variable(const Variable& variable, std::size_t reference) {
  std::string text = "    <ScalarVariable" + attribute("name", variable.name) + attribute("valueReference", std::to_string(reference));
  if (!variable.words.empty()) text += attribute("description", variable.words);
  switch (variable.causality) {
    case Causality::input:
      text += attribute("causality", "input") + attribute("variability", "continuous");
      break;
    case Causality::output:
      text += attribute("causality", "output") + attribute("variability", "continuous") + attribute("initial", "calculated");
      break;
    case Causality::local:
      text += attribute("causality", "local") + attribute("variability", "continuous") + attribute("initial", "calculated");
      break;
    case Causality::parameter:
      text += attribute("causality", "parameter") + attribute("variability", "fixed") + attribute("initial", "exact");
      break;
  }
  text += "><Real";
  if (!variable.unit.text.empty()) text += attribute("unit", variable.unit.text);
  if (variable.range)
    text += attribute("min", variable.range->lowest) + attribute("max", variable.range->highest) + attribute("start", variable.start);
  return text + "/></ScalarVariable>\n";
}

}  // namespace

std::string binary_path(const std::string& name) { return "binaries/linux64/" + name + ".so"; }

std::string model_description(const plant::Plant& plant, const Identity& identity) {
  const std::vector<Variable> variables = variables_of(plant);
  std::string units, list, outputs, unknowns;
  std::map<std::string_view, bool> defined;
  for (std::size_t v = 0; v < variables.size(); ++v) {
    const std::string_view unit = variables[v].unit.text;
    if (!unit.empty() && !defined[unit]) units += unit_definition(unit), defined[unit] = true;
    list += scalar_variable(variables[v], v);
    if (variables[v].causality != Causality::output) continue;
    // An input acts from the step that follows: an output at a communication point depends on none of them.
    outputs += "      <Unknown" + attribute("index", std::to_string(v + 1)) + attribute("dependencies", "") + "/>\n";
    unknowns += "      <Unknown" + attribute("index", std::to_string(v + 1)) + "/>\n";
  }
  const std::string words(plant.system().words());
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription" + attribute("fmiVersion", "2.0") +
         attribute("modelName", identity.name) + attribute("guid", identity.guid) +
         attribute("description", words + ", with its sensors' noise left out; begins at rest") +
         attribute("generationTool", identity.tool) + attribute("variableNamingConvention", "structured") + ">\n  <CoSimulation" +
         attribute("modelIdentifier", identity.name) + attribute("canHandleVariableCommunicationStepSize", "true") +
         attribute("canNotUseMemoryManagementFunctions", "true") + "/>\n" +
         (units.empty() ? "" : "  <UnitDefinitions>\n" + units + "  </UnitDefinitions>\n") +
         "  <LogCategories>\n    <Category name=\"logStatusError\"/>\n  </LogCategories>\n  <DefaultExperiment" +
         attribute("startTime", 0.0) + attribute("stopTime", 60.0) + attribute("tolerance", plant::NumericalSettings{}.relative_tolerance) +
         attribute("stepSize", 0.1) + "/>\n  <ModelVariables>\n" + list + "  </ModelVariables>\n  <ModelStructure>\n    <Outputs>\n" +
         outputs + "    </Outputs>\n    <InitialUnknowns>\n" + unknowns +
         "    </InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n";
}

}  // namespace sinew::fmu
