// SPDX-License-Identifier: Apache-2.0
// The shared object of an FMU: FMI 2.0's functions for co-simulation around plant::Integrator. Whatever goes wrong is told to the importing
// program's logger, and the call returns fmi2Error; no exception leaves this file. There are no globals: instances know nothing of each
// other.
//
// Inputs are held over a communication step. An instance makes the calls that a simulation of Sinew makes (hold, advance_to, readings), so
// that at the same times it has the same values, bit for bit.
#include "fmu/fmi2.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmu/description.h"
#include "fmu/variables.h"
#include "plant/contains.h"
#include "plant/integrator.h"
#include "sim/plant_file.h"
#include "sim/text.h"

// Debian compiles libyaml-cpp.a for programs, in whose code glibc's variable of this name can be reached directly; within a shared object
// only one of its own can. 0: other threads may be there, so that pointers are counted by atomic operations.
extern "C" {
__attribute__((visibility("hidden"))) extern char __libc_single_threaded;
char __libc_single_threaded = 0;
}

#define EXPORTED extern "C" __attribute__((visibility("default")))

namespace sinew::fmu {
namespace {

constexpr double tightest_tolerance = 1e-12, coarsest_tolerance = 1e-2;
constexpr double same_time_s = 1e-9;  // an importing program may add up its steps

enum class Phase { instantiated, initializing, stepping, terminated, failed };

const char* words_of(Phase phase) {
  switch (phase) {
    case Phase::instantiated:
      return "before fmi2EnterInitializationMode";
    case Phase::initializing:
      return "in initialization mode";
    case Phase::stepping:
      return "between communication steps";
    case Phase::terminated:
      return "after fmi2Terminate";
    case Phase::failed:
      break;
  }
  return "after a failed integration; fmi2Reset or fmi2FreeInstance may follow";
}

struct Instance {
  std::string name;
  fmi2CallbackFunctions callbacks;
  plant::Plant from_file, plant;
  std::vector<Variable> variables;
  std::vector<double> values;  // of each variable, in its unit; those of outputs and states from `settle` on
  Phase phase = Phase::instantiated;
  plant::NumericalSettings numerics;
  double start_time_s = 0.0;
  std::optional<double> stop_time_s;
  std::optional<plant::Integrator> integrator;

  void reset() {
    plant = from_file;
    values.clear();
    for (const Variable& variable : variables) values.push_back(variable.start);
    phase = Phase::instantiated;
    numerics = {};
    start_time_s = 0.0;
    stop_time_s.reset();
    integrator.reset();
  }

  // The plant at rest, with the parameters that it has now.
  void settle() {
    if (integrator) return;
    integrator.emplace(plant, plant::Start{}, numerics);
    read();
  }

  void read() {
    const std::vector<double> readings = integrator->readings();
    const std::vector<double>& state = integrator->state();
    for (std::size_t v = 0; v < variables.size(); ++v) {
      const Variable& variable = variables[v];
      if (variable.causality == Causality::output) values[v] = readings[variable.index] / variable.unit.internal_per_unit;
      if (variable.causality == Causality::local) values[v] = state[variable.index] / variable.unit.internal_per_unit;
    }
  }
};

// A whole sentence, as not every importing program fills in what stands behind a format. In a message `%` begins a format, and `#` the name
// of a variable.
void tell(const fmi2CallbackFunctions& callbacks, const char* instance, const char* call, const char* words) noexcept try {
  if (!callbacks.logger) return;
  std::string message;
  for (const char c : std::string(call) + ": " + words) message.append(c == '%' || c == '#' ? 2 : 1, c);
  callbacks.logger(callbacks.componentEnvironment, instance, fmi2Error, "logStatusError", message.c_str());
} catch (...) {  // no memory left for it
}

template <class Work>
fmi2Status run(fmi2Component component, const char* call, std::initializer_list<Phase> allowed, Work&& work) noexcept {
  auto* const instance = static_cast<Instance*>(component);
  if (!instance) return fmi2Error;
  try {
    if (!contains(allowed, instance->phase)) throw std::runtime_error(std::string("cannot be called ") + words_of(instance->phase));
    work(*instance);
    return fmi2OK;
  } catch (const std::exception& error) {
    tell(instance->callbacks, instance->name.c_str(), call, error.what());
  } catch (...) {
    tell(instance->callbacks, instance->name.c_str(), call, "failed");
  }
  return fmi2Error;
}

fmi2Status refuse(fmi2Component component, const char* call, const char* words) noexcept {
  return run(component, call, {Phase::instantiated, Phase::initializing, Phase::stepping, Phase::terminated, Phase::failed},
             [&](const Instance&) { throw std::runtime_error(words); });
}

fmi2Status none_of_this_type(fmi2Component component, const char* call, std::size_t count) noexcept {
  return count == 0 && component ? fmi2OK : refuse(component, call, "every variable is a Real");
}

const Variable& variable_at(const Instance& instance, fmi2ValueReference reference) {
  if (reference >= instance.variables.size()) throw std::runtime_error("no variable has the value reference " + std::to_string(reference));
  return instance.variables[reference];
}

// The path of "file:///tmp/an%20fmu/resources".
std::string path_of(std::string_view location) {
  for (const std::string_view scheme : {"file://localhost/", "file:///", "file:/"})
    if (location.starts_with(scheme)) {
      location.remove_prefix(scheme.size() - 1);
      std::string path;
      for (std::size_t i = 0; i < location.size(); ++i) {
        const auto digit = [&](std::size_t at) {
          return at < location.size() ? std::string_view("0123456789abcdef").find(static_cast<char>(location[at] | 0x20))
                                      : std::string_view::npos;
        };
        const std::size_t high = digit(i + 1), low = digit(i + 2);
        const bool escaped = location[i] == '%' && high != std::string_view::npos && low != std::string_view::npos;
        path += escaped ? static_cast<char>(high << 4 | low) : location[i];
        if (escaped) i += 2;
      }
      return path;
    }
  throw std::runtime_error("fmuResourceLocation = " + std::string(location) + " is no file:/// URI");
}

std::unique_ptr<Instance> instantiated(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                                       const fmi2CallbackFunctions& callbacks) {
  if (!name || !*name) throw std::runtime_error("instanceName is empty");
  if (type != fmi2CoSimulation) throw std::runtime_error("this FMU is for co-simulation alone");
  if (!guid || !*guid) throw std::runtime_error("fmuGUID is empty");
  if (!location) throw std::runtime_error("fmuResourceLocation is needed");
  auto instance = std::make_unique<Instance>();
  instance->name = name;
  instance->callbacks = callbacks;
  const std::string file = path_of(location) + "/" + std::string(plant_path).substr(std::string_view("resources/").size());
  if (sim::read_file(file).find(guid_line + std::string(guid) + "\n") == std::string::npos)
    throw std::runtime_error("fmuGUID = " + std::string(guid) + " is not that of " + file);
  instance->from_file = sim::read_plant_file(file);
  instance->variables = variables_of(instance->from_file);
  instance->reset();
  return instance;
}

void set_reals(Instance& instance, const fmi2ValueReference* references, std::size_t count, const fmi2Real* values) {
  if (count > 0 && (!references || !values)) throw std::runtime_error("a list is missing");
  // All of them or none.
  for (std::size_t k = 0; k < count; ++k) {
    const Variable& variable = variable_at(instance, references[k]);
    if (!variable.range) throw std::runtime_error(variable.name + " is calculated and cannot be set");
    if (variable.causality == Causality::parameter && instance.phase == Phase::stepping)
      throw std::runtime_error(variable.name + " is a parameter, and fixed once initialization has ended");
    if (const std::string fault = variable.fault(values[k]); !fault.empty())
      throw std::runtime_error(variable.name + " = " + sim::shortest(values[k]) + " " + fault);
  }
  for (std::size_t k = 0; k < count; ++k) {
    const Variable& variable = instance.variables[references[k]];
    instance.values[references[k]] = values[k];
    if (variable.causality != Causality::parameter) continue;
    instance.plant.set_in_file_units(plant::ParameterId{variable.index}, values[k]);
    instance.integrator.reset();
  }
}

void get_reals(Instance& instance, const fmi2ValueReference* references, std::size_t count, fmi2Real* values) {
  if (count > 0 && (!references || !values)) throw std::runtime_error("a list is missing");
  instance.settle();
  for (std::size_t k = 0; k < count; ++k) {
    variable_at(instance, references[k]);
    values[k] = instance.values[references[k]];
  }
}

void setup(Instance& instance, bool tolerance_defined, double tolerance, double start_time_s, bool stop_defined, double stop_time_s) {
  if (tolerance_defined && !(tolerance >= tightest_tolerance && tolerance <= coarsest_tolerance))
    throw std::runtime_error("tolerance = " + sim::shortest(tolerance) + " must lie in [1e-12, 0.01]");
  if (!std::isfinite(start_time_s)) throw std::runtime_error("startTime must be finite");
  if (stop_defined && !(stop_time_s >= start_time_s)) throw std::runtime_error("stopTime must not lie before startTime");
  instance.numerics = {};
  if (tolerance_defined) instance.numerics.relative_tolerance = tolerance;
  instance.start_time_s = start_time_s;
  instance.stop_time_s = stop_defined ? std::optional(stop_time_s) : std::nullopt;
}

void step(Instance& instance, double point_s, double size_s) {
  if (!std::isfinite(point_s)) throw std::runtime_error("currentCommunicationPoint must be finite");
  if (!(std::isfinite(size_s) && size_s > 0.0))
    throw std::runtime_error("communicationStepSize = " + sim::shortest(size_s) + " must be above 0 and finite");
  plant::Integrator& integrator = *instance.integrator;
  const double slack_s = same_time_s * std::max(1.0, std::abs(point_s));
  if (const double reached_s = instance.start_time_s + integrator.time_s(); std::abs(point_s - reached_s) > slack_s)
    throw std::runtime_error("currentCommunicationPoint = " + sim::shortest(point_s) + " is not where the step before it ended, " +
                             sim::shortest(reached_s));
  const double end_s = point_s + size_s;
  if (instance.stop_time_s && end_s > *instance.stop_time_s + slack_s)
    throw std::runtime_error("the step ends after stopTime = " + sim::shortest(*instance.stop_time_s));
  if (!(end_s - instance.start_time_s > integrator.time_s()))
    throw std::runtime_error("communicationStepSize = " + sim::shortest(size_s) + " is lost in rounding");
  std::vector<double> inputs;
  for (std::size_t v = 0; v < instance.variables.size(); ++v)
    if (instance.variables[v].causality == Causality::input) inputs.push_back(instance.values[v]);
  integrator.hold(inputs);
  if (const auto failure = integrator.advance_to(end_s - instance.start_time_s)) {
    instance.phase = Phase::failed;
    throw std::runtime_error("the integration failed at " + sim::shortest(instance.start_time_s + failure->time_s) +
                             " s: " + failure->reason);
  }
  instance.read();
}

}  // namespace
}  // namespace sinew::fmu

using namespace sinew::fmu;  // the functions below are the standard's, and stand outside of every namespace

EXPORTED const char* fmi2GetTypesPlatform() { return "default"; }
EXPORTED const char* fmi2GetVersion() { return "2.0"; }

// Errors alone are told, and always.
EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean, std::size_t, const fmi2String*) { return c ? fmi2OK : fmi2Error; }

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                                       const fmi2CallbackFunctions* callbacks, fmi2Boolean, fmi2Boolean) {
  if (!callbacks) return nullptr;
  try {
    return instantiated(name, type, guid, location, *callbacks).release();
  } catch (const std::exception& error) {
    tell(*callbacks, name ? name : "", "fmi2Instantiate", error.what());
  } catch (...) {
    tell(*callbacks, name ? name : "", "fmi2Instantiate", "failed");
  }
  return nullptr;
}

EXPORTED void fmi2FreeInstance(fmi2Component c) { delete static_cast<Instance*>(c); }

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start_time_s,
                                        fmi2Boolean stop_defined, fmi2Real stop_time_s) {
  return run(c, "fmi2SetupExperiment", {Phase::instantiated},
             [&](Instance& instance) { setup(instance, tolerance_defined != 0, tolerance, start_time_s, stop_defined != 0, stop_time_s); });
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return run(c, "fmi2EnterInitializationMode", {Phase::instantiated}, [](Instance& instance) { instance.phase = Phase::initializing; });
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return run(c, "fmi2ExitInitializationMode", {Phase::initializing}, [](Instance& instance) {
    instance.settle();
    instance.phase = Phase::stepping;
  });
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component c) {
  return run(c, "fmi2Terminate", {Phase::stepping}, [](Instance& instance) { instance.phase = Phase::terminated; });
}

EXPORTED fmi2Status fmi2Reset(fmi2Component c) {
  return run(c, "fmi2Reset", {Phase::instantiated, Phase::initializing, Phase::stepping, Phase::terminated, Phase::failed},
             [](Instance& instance) { instance.reset(); });
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference* references, std::size_t count, fmi2Real* values) {
  return run(c, "fmi2GetReal", {Phase::initializing, Phase::stepping, Phase::terminated},
             [&](Instance& instance) { get_reals(instance, references, count, values); });
}
EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference* references, std::size_t count, const fmi2Real* values) {
  return run(c, "fmi2SetReal", {Phase::instantiated, Phase::initializing, Phase::stepping},
             [&](Instance& instance) { set_reals(instance, references, count, values); });
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real point_s, fmi2Real size_s, fmi2Boolean) {
  return run(c, "fmi2DoStep", {Phase::stepping}, [&](Instance& instance) { step(instance, point_s, size_s); });
}

EXPORTED fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* value) {
  return run(c, "fmi2GetRealStatus", {Phase::stepping, Phase::terminated, Phase::failed}, [&](Instance& instance) {
    if (kind != fmi2LastSuccessfulTime || !value) throw std::runtime_error("tells the last successful time alone");
    *value = instance.start_time_s + instance.integrator->time_s();
  });
}

EXPORTED fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* value) {
  return run(c, "fmi2GetBooleanStatus", {Phase::stepping, Phase::terminated, Phase::failed}, [&](const Instance&) {
    if (kind != fmi2Terminated || !value) throw std::runtime_error("tells whether the FMU ended the simulation alone");
    *value = 0;
  });
}

// What this FMU has not, by modelDescription.xml.
namespace {
constexpr const char *steps_end_at_once = "a step ends before fmi2DoStep returns", *no_state = "canGetAndSetFMUstate is false",
                     *no_derivative = "providesDirectionalDerivative is false";
}

EXPORTED fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference*, std::size_t count, fmi2Integer*) {
  return none_of_this_type(c, "fmi2GetInteger", count);
}
EXPORTED fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference*, std::size_t count, fmi2Boolean*) {
  return none_of_this_type(c, "fmi2GetBoolean", count);
}
EXPORTED fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference*, std::size_t count, fmi2String*) {
  return none_of_this_type(c, "fmi2GetString", count);
}
EXPORTED fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference*, std::size_t count, const fmi2Integer*) {
  return none_of_this_type(c, "fmi2SetInteger", count);
}
EXPORTED fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference*, std::size_t count, const fmi2Boolean*) {
  return none_of_this_type(c, "fmi2SetBoolean", count);
}
EXPORTED fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference*, std::size_t count, const fmi2String*) {
  return none_of_this_type(c, "fmi2SetString", count);
}
EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate*) { return refuse(c, "fmi2GetFMUstate", no_state); }
EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate) { return refuse(c, "fmi2SetFMUstate", no_state); }
EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate*) { return refuse(c, "fmi2FreeFMUstate", no_state); }
EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate, std::size_t*) {
  return refuse(c, "fmi2SerializedFMUstateSize", no_state);
}
EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate, fmi2Byte*, std::size_t) {
  return refuse(c, "fmi2SerializeFMUstate", no_state);
}
EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte*, std::size_t, fmi2FMUstate*) {
  return refuse(c, "fmi2DeSerializeFMUstate", no_state);
}
EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2ValueReference*,
                                                 std::size_t, const fmi2Real*, fmi2Real*) {
  return refuse(c, "fmi2GetDirectionalDerivative", no_derivative);
}
EXPORTED fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2Integer*,
                                                const fmi2Real*) {
  return refuse(c, "fmi2SetRealInputDerivatives", "canInterpolateInputs is false");
}
EXPORTED fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2Integer*, fmi2Real*) {
  return refuse(c, "fmi2GetRealOutputDerivatives", "maxOutputDerivativeOrder is 0");
}
EXPORTED fmi2Status fmi2CancelStep(fmi2Component c) { return refuse(c, "fmi2CancelStep", steps_end_at_once); }
EXPORTED fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind, fmi2Status*) { return refuse(c, "fmi2GetStatus", steps_end_at_once); }
EXPORTED fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) {
  return refuse(c, "fmi2GetIntegerStatus", steps_end_at_once);
}
EXPORTED fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) {
  return refuse(c, "fmi2GetStringStatus", steps_end_at_once);
}
