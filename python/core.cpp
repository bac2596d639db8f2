// SPDX-License-Identifier: Apache-2.0
// sinew._core: the rooms' own types in Python. Converts, and computes nothing; for people: docs/python.md, sinew/_core.pyi.
//
// What takes long runs without the lock of the interpreter. Ctrl-C ends it as it ends a command, and is a KeyboardInterrupt.
#include <glog/logging.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <signal.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/app.h"
#include "apps/calibrate.h"
#include "apps/comparison_page.h"
#include "apps/diagnose.h"
#include "apps/training.h"
#include "diagnose/calibrate.h"
#include "model/predictor.h"
#include "model/weights_file.h"
#include "plant/integrator.h"
#include "plant/laws.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/simulation.h"
#include "sim/text.h"

namespace py = pybind11;

namespace sinew::python {
namespace {

struct IntegrationFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

py::str text(std::string_view bytes) {
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "replace"));
}

// --- Ctrl-C ----------------------------------------------------------------------------------------------------------------------

volatile sig_atomic_t interrupts_seen = 0;

// While one of these lives in Python's main thread, Ctrl-C is noted here rather than there. In any other thread Python has the signal, and
// its main thread answers to it.
class Interrupts {
 public:
  Interrupts() {
    const py::module_ threading = py::module_::import("threading");
    watched_ = threading.attr("current_thread")().is(threading.attr("main_thread")());
    if (!watched_) return;
    interrupts_seen = 0;
    struct sigaction ours {};
    ours.sa_handler = [](int) { interrupts_seen = 1; };
    sigaction(SIGINT, &ours, &before_);
  }
  ~Interrupts() {
    if (watched_) sigaction(SIGINT, &before_, nullptr);
  }
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  bool came() const { return watched_ && interrupts_seen != 0; }

 private:
  bool watched_ = false;
  struct sigaction before_ {};
};

// work(should_stop), with the interpreter free to do something else. Throws diagnose::Stopped where Ctrl-C came, be it at the last moment.
template <class Work>
auto computed(Work&& work) {
  const Interrupts interrupts;
  const py::gil_scoped_release released;
  const std::function<bool()> should_stop = [&] { return interrupts.came(); };
  auto result = work(should_stop);
  if (interrupts.came()) throw diagnose::Stopped{};
  return result;
}

// --- Recordings ------------------------------------------------------------------------------------------------------------------

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

// [rows x width], which cannot be written to.
template <class Value>
py::array_t<double> table(std::size_t rows, std::size_t width, Value&& value) {
  py::array_t<double> result({rows, width});
  auto cells = result.mutable_unchecked<2>();
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t c = 0; c < width; ++c) cells(static_cast<py::ssize_t>(k), static_cast<py::ssize_t>(c)) = value(k, c);
  result.attr("flags").attr("writeable") = false;
  return result;
}

py::array_t<double> vector(std::size_t rows, auto&& value) {
  py::array_t<double> result(static_cast<py::ssize_t>(rows));
  for (std::size_t k = 0; k < rows; ++k) result.mutable_at(static_cast<py::ssize_t>(k)) = value(k);
  result.attr("flags").attr("writeable") = false;
  return result;
}

std::vector<std::string> names_of(const std::vector<sim::Column>& columns) {
  std::vector<std::string> names;
  for (const sim::Column& column : columns) names.push_back(column.name);
  return names;
}

struct Recording {
  sim::Recording data;
  std::string sha256;
  py::array_t<double> time_s, inputs, channels;

  Recording(sim::Recording recording, std::string hash) : data(std::move(recording)), sha256(std::move(hash)) {
    const auto& samples = data.samples;
    time_s = vector(samples.size(), [&](std::size_t k) { return samples[k].time_s; });
    inputs = table(samples.size(), data.columns.inputs.size(), [&](std::size_t k, std::size_t c) { return samples[k].inputs[c]; });
    channels = table(samples.size(), data.columns.channels.size(), [&](std::size_t k, std::size_t c) { return samples[k].channels[c]; });
  }

  py::object column(const std::string& name) const {
    const auto of = [&](const py::array_t<double>& array, const std::vector<sim::Column>& columns) -> py::object {
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (columns[c].name == name) return array[py::make_tuple(py::ellipsis(), c)];
      return py::none();
    };
    if (name == "time_s") return time_s;
    if (py::object found = of(inputs, data.columns.inputs); !found.is_none()) return found;
    if (py::object found = of(channels, data.columns.channels); !found.is_none()) return found;
    std::vector<std::string> all = names_of(data.columns.inputs);
    for (const sim::Column& channel : data.columns.channels) all.push_back(channel.name);
    throw py::key_error("no column " + sim::printable(name) + sim::did_you_mean(name, all));
  }
};

// Whatever is made of arrays goes through the reader of files, so that the same is refused in the same words.
sim::Recording recording_of(const std::vector<std::pair<std::string, Array>>& columns, const sim::Columns& known, const std::string& name) {
  std::string csv;
  std::size_t rows = 0;
  for (const auto& [column, values] : columns) {
    const auto count = static_cast<std::size_t>(values.size());
    if (values.ndim() != 1 || (!csv.empty() && count != rows))
      throw sim::InputError({.file = name, .key = column, .advice = "must be an array of one dimension, as long as the others"});
    rows = count;
    csv += (csv.empty() ? "" : ",") + column;
  }
  csv += '\n';
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = columns[c].second.at(static_cast<py::ssize_t>(k));
      if (!std::isnan(value)) sim::append_shortest(csv, value);
      csv += c + 1 < columns.size() ? ',' : '\n';
    }
  return sim::parse_recording(csv, name, known);
}

// --- Plants ----------------------------------------------------------------------------------------------------------------------

struct Plant {
  plant::Plant values;
  std::string name, sha256;  // of the file; of one that was changed, of what `save` would write
  const plant::System& system() const { return values.system(); }
};

Plant plant_of(plant::Plant values, std::string name) {
  const std::string yaml = sim::plant_file_text(values);
  return {std::move(values), std::move(name), sim::sha256(yaml)};
}

Plant read_plant(const std::filesystem::path& path) {
  return {sim::read_plant_file(path), path.string(), sim::sha256(sim::read_file(path))};
}

// The plant as its file would be with these keys of `parameters:` or `effects:` written anew; null: left out. Reader and words are those of
// files.
void change(Plant& plant, const std::string& section, const std::string& changes) {
  sim::YamlValue file = sim::parse_yaml(sim::plant_file_text(plant.values), plant.name);
  sim::YamlValue given = sim::parse_yaml("{\"" + section + "\": " + changes + "}", plant.name).map.front().value;
  auto& sections = file.map;
  auto there = std::find_if(sections.begin(), sections.end(), [&](const auto& entry) { return entry.key == section; });
  if (there == sections.end()) {
    sim::YamlValue none;
    none.kind = sim::YamlValue::Kind::map;
    none.file = plant.name;
    none.path = section;
    there = sections.insert(sections.end(), {section, 0, 0, none});
  }
  auto& entries = there->value.map;
  there->value.kind = sim::YamlValue::Kind::map;
  for (auto& entry : given.map) {
    std::erase_if(entries, [&](const auto& old) { return old.key == entry.key; });
    if (entry.value.kind != sim::YamlValue::Kind::empty) entries.push_back(entry);
  }
  plant = plant_of(sim::read_plant(file, std::filesystem::path(plant.name).parent_path()), plant.name);
}

struct Parameter {
  std::shared_ptr<const plant::System> system;
  plant::ParameterId id;
  double value;
  const plant::ParameterInfo& info() const { return system->parameters()[id]; }
};

Parameter parameter_of(const Plant& plant, plant::ParameterId id) {
  return {plant.values.shared_system(), id, plant.values.get_in_file_units(id)};
}

struct Effect {
  std::shared_ptr<const plant::System> system;
  plant::EffectId id;
  bool is_on;
  py::dict parameters;
  const plant::EffectInfo& info() const { return system->effects()[id]; }
};

struct Law {
  std::string name, words, entry, unit;
  std::vector<std::string> argument;
  std::vector<double> knots, values;
  bool is_on;
};

bool is_law_weight(const plant::System& system, plant::ParameterId p) {
  const auto& effect = system.parameters()[p].effect;
  return effect && system.effects()[*effect].law;
}

py::dict parameters_of(const Plant& plant) {
  py::dict result;
  for (const plant::ParameterId p : plant.system().parameters().ids()) {
    const auto& info = plant.system().parameters()[p];
    if (is_law_weight(plant.system(), p) || (info.effect && !plant.values.is_on(*info.effect))) continue;
    result[text(info.key())] = parameter_of(plant, p);
  }
  return result;
}

py::dict effects_of(const Plant& plant) {
  py::dict result;
  for (const plant::EffectId e : plant.system().effects().ids()) {
    const plant::EffectInfo& info = plant.system().effects()[e];
    if (info.law) continue;
    py::dict parameters;
    for (const plant::ParameterId p : info.parameters)
      parameters[text(plant.system().parameters()[p].declaration.name)] = parameter_of(plant, p);
    result[text(info.name)] = Effect{plant.values.shared_system(), e, plant.values.is_on(e), parameters};
  }
  return result;
}

std::vector<Law> laws_of(const Plant& plant) {
  std::vector<Law> result;
  const plant::System& system = plant.system();
  for (const plant::EffectId e : system.effects().ids()) {
    const plant::EffectInfo& info = system.effects()[e];
    if (!info.law) continue;
    const plant::Law& law = system.laws()[*info.law];
    const plant::EntryGroup& group = system.entry_groups()[law.entry];
    std::vector<std::string> argument;
    for (const plant::VariableId v : law.argument) argument.push_back(system.variables()[v].name);
    const Eigen::VectorXd values = plant::values_of(plant.values, e);
    result.push_back({std::string(info.name),
                      plant::law_words(system, law),
                      std::string(group.name),
                      law.factor.empty() ? std::string(group.unit) : "",
                      argument,
                      law.knots,
                      {values.begin(), values.end()},
                      plant.values.is_on(e)});
  }
  return result;
}

template <class List>
std::vector<std::string> columns_in(const List& list) {
  std::vector<std::string> names;
  for (const auto& one : list) names.push_back(one.column);
  return names;
}

std::vector<std::string> states_of(const Plant& plant) {
  std::vector<std::string> names;
  for (const auto& state : plant.values.states()) names.push_back(state.key);
  return names;
}

// --- Simulation ------------------------------------------------------------------------------------------------------------------

struct Simulation {
  std::vector<std::string> channel_names, state_names, parameter_names;
  py::array_t<double> time_s, channels, states;
  py::object jacobian;
};

plant::ParameterId parameter_named(const Plant& plant, const std::string& name) {
  if (const auto found = plant.system().find_parameter(name)) return *found;
  std::vector<std::string> all;
  for (const auto& info : plant.system().parameters()) all.push_back(info.key());
  throw sim::InputError({.file = plant.name, .key = name, .advice = "no such parameter" + sim::did_you_mean(name, all)});
}

std::vector<plant::ParameterId> sensitivities_asked(const Plant& plant, const py::object& asked) {
  if (py::isinstance<py::bool_>(asked))
    return asked.cast<bool>() ? diagnose::fittable_parameters(plant.values) : std::vector<plant::ParameterId>{};
  std::vector<plant::ParameterId> result;
  for (const std::string& name : asked.cast<std::vector<std::string>>()) result.push_back(parameter_named(plant, name));
  return result;
}

Simulation simulate(const Plant& plant, const Array& time_s, const py::object& inputs, const py::object& sensitivities, double tolerance) {
  if (!(tolerance >= 1e-12 && tolerance <= 1e-2))
    throw sim::InputError({.file = "", .key = "tolerance", .value = sim::shortest(tolerance), .advice = "must lie in [1e-12, 0.01]"});
  const plant::System& system = plant.system();
  // Columns by name, or one array with a column for each of the plant's inputs.
  std::vector<std::pair<std::string, Array>> columns{{"time_s", time_s}};
  if (py::isinstance<py::array>(inputs) || !py::hasattr(inputs, "keys")) {
    const Array all = inputs.cast<Array>();
    if (all.ndim() != 2 || static_cast<std::size_t>(all.shape(1)) != system.inputs().size())
      throw sim::InputError(
          {.file = "simulate",
           .key = "inputs",
           .advice = "must be [samples x " + std::to_string(system.inputs().size()) + "], or a map from the plant's inputs to arrays"});
    for (const plant::InputId i : system.inputs().ids())
      columns.emplace_back(system.inputs()[i].column, all[py::make_tuple(py::ellipsis(), i.index)].cast<Array>());
  } else {
    for (const py::handle key : inputs.attr("keys")()) columns.emplace_back(key.cast<std::string>(), inputs[key].cast<Array>());
  }
  sim::Columns inputs_alone = sim::columns_of(system);
  inputs_alone.channels.clear();
  const sim::Recording recording = recording_of(columns, inputs_alone, "simulate");
  const auto& samples = recording.samples;
  if (samples.size() != static_cast<std::size_t>(time_s.size()))
    throw sim::InputError({.file = "simulate", .key = "time_s", .advice = "must rise from sample to sample"});

  const plant::SensitivityRequest request{sensitivities_asked(plant, sensitivities), {}};
  const plant::States states = plant.values.states();
  std::vector<std::vector<double>> readings, reached;
  std::vector<Eigen::MatrixXd> derivatives;
  computed([&](const std::function<bool()>& should_stop) {
    plant::Integrator integrator(plant.values, {}, {plant::Method::cvode, tolerance}, request);
    const auto failure = sim::replay(integrator, system, samples, [&](std::size_t) {
      if (should_stop()) throw diagnose::Stopped{};
      reached.push_back(integrator.state());
      readings.push_back(integrator.readings());
      if (request.columns() > 0) integrator.readings_with_sensitivity(readings.back(), derivatives.emplace_back());
    });
    if (failure) throw IntegrationFailed("the integration failed at " + sim::shortest(failure->time_s) + " s: " + failure->reason);
    return true;
  });

  Simulation result{columns_in(system.channels()), states_of(plant), {}, {}, {}, {}, py::none()};
  result.time_s = vector(samples.size(), [&](std::size_t k) { return samples[k].time_s; });
  std::vector<double> channel_unit, state_unit, parameter_unit;
  for (const auto& channel : system.channels()) channel_unit.push_back(channel.unit.internal_per_unit);
  for (const auto& state : states) state_unit.push_back(state.unit.internal_per_unit);
  for (const plant::ParameterId p : request.parameters) {
    parameter_unit.push_back(system.parameters()[p].declaration.unit.internal_per_unit);
    result.parameter_names.push_back(system.parameters()[p].key());
  }
  result.channels =
      table(samples.size(), channel_unit.size(), [&](std::size_t k, std::size_t c) { return readings[k][c] / channel_unit[c]; });
  result.states = table(samples.size(), state_unit.size(), [&](std::size_t k, std::size_t s) { return reached[k][s] / state_unit[s]; });
  if (request.columns() == 0) return result;
  py::array_t<double> jacobian({samples.size(), channel_unit.size(), parameter_unit.size()});
  auto cells = jacobian.mutable_unchecked<3>();
  for (py::ssize_t k = 0; k < cells.shape(0); ++k)
    for (py::ssize_t c = 0; c < cells.shape(1); ++c)
      for (py::ssize_t p = 0; p < cells.shape(2); ++p)
        cells(k, c, p) = derivatives[static_cast<std::size_t>(k)](c, p) * parameter_unit[static_cast<std::size_t>(p)] /
                         channel_unit[static_cast<std::size_t>(c)];
  result.jacobian = jacobian;
  return result;
}

// --- calibrate and diagnose ------------------------------------------------------------------------------------------------------

std::vector<sim::Recording> data_of(const std::vector<const Recording*>& given, const Plant& plant, std::vector<std::string>& names) {
  std::vector<sim::Recording> result;
  for (const Recording* one : given) {
    if (!(one->data.columns == sim::columns_of(plant.system())))
      throw sim::InputError({.file = one->data.name,
                             .advice = "is of another kind of plant than " + plant.name + "; read it as sinew.Recording(path, plant)"});
    apps::check_recording(one->data, plant.values);
    names.push_back(one->data.name);
    result.push_back(one->data);
  }
  if (result.empty()) throw sim::InputError({.file = "", .key = "recordings", .advice = "at least one is needed"});
  return result;
}

std::int64_t whole_number(const py::dict& options, const char* name, std::int64_t lowest, std::int64_t highest) {
  const auto value = options[name].cast<std::int64_t>();
  if (value < lowest || value > highest)
    throw sim::InputError({.file = "",
                           .key = name,
                           .value = std::to_string(value),
                           .advice = "must lie in [" + std::to_string(lowest) + ", " + std::to_string(highest) + "]"});
  return value;
}

void read_options(const py::dict& options, auto& request) {
  request.noise = options["noise"].cast<std::vector<std::string>>();
  request.ignored = options["ignored"].cast<std::vector<std::string>>();
  request.fit_until_s = options["fit_until_s"].cast<double>();
  if (std::isnan(request.fit_until_s))
    throw sim::InputError({.file = "", .key = "fit_until_s", .value = "nan", .advice = "must be a time"});
  request.seed = whole_number(options, "seed", 0, std::numeric_limits<std::int64_t>::max());
  request.threads = static_cast<int>(whole_number(options, "threads", 1, 1024));
  request.at_rest = options["at_rest"].cast<bool>();
}

py::dict dictionary(const std::map<std::string, std::string>& files) {
  py::dict result;
  for (const auto& [name, content] : files) result[text(name)] = text(content);
  return result;
}

// `progress`: False, True (a line in the terminal), or a function.
class Watched {
 public:
  Watched(const py::object& progress, const char* what) {
    if (!py::isinstance<py::bool_>(progress))
      function_ = progress;
    else if (progress.cast<bool>())
      line_.emplace(what);
  }
  template <class... Words>
  void operator()(double share, const Words&... words) {
    if (line_) line_->show(share, words...);
    if (!function_) return;
    const py::gil_scoped_acquire acquired;
    function_(share, words...);
  }

 private:
  std::optional<apps::Progress> line_;
  py::object function_;
};

py::dict calibrate(const Plant& plant, const std::vector<const Recording*>& recordings, const py::dict& options,
                   const py::object& progress) {
  apps::CalibrateRequest request;
  read_options(options, request);
  request.plant = plant.name;
  request.fit = options["fit"].cast<std::vector<std::string>>();
  request.starts = static_cast<int>(whole_number(options, "starts", 1, 1000));
  std::vector<sim::Recording> data = data_of(recordings, plant, request.recordings);
  Watched watched(progress, "calibrate");
  request.progress = [&](double share) { watched(share); };
  const apps::Calibrated result = computed([&](const std::function<bool()>& should_stop) {
    request.should_stop = should_stop;
    return apps::calibrated(request, plant.values, std::move(data));
  });
  return dictionary(result.files);
}

py::tuple diagnose_recordings(const Plant& plant, const std::vector<const Recording*>& train, const std::vector<const Recording*>& heldout,
                              const py::dict& options, const py::object& progress) {
  apps::DiagnoseRequest request;
  read_options(options, request);
  request.plant = plant.name;
  request.without = options["without"].cast<std::vector<std::string>>();
  request.hashes[plant.name] = plant.sha256;
  std::vector<sim::Recording> training = data_of(train, plant, request.training), held_out;
  if (!heldout.empty()) held_out = data_of(heldout, plant, request.held_out);
  for (const auto* list : {&train, &heldout})
    for (const Recording* one : *list)
      if (!request.hashes.emplace(one->data.name, one->sha256).second)
        throw sim::InputError(
            {.file = one->data.name, .advice = "is given twice; each recording can be used once, and needs its own name"});
  Watched watched(progress, "diagnose");
  request.progress = [&](double share, const std::string& doing) { watched(share, doing); };
  const apps::Diagnosed result = computed([&](const std::function<bool()>& should_stop) {
    request.should_stop = should_stop;
    return apps::diagnosed(request, plant.values, std::move(training), std::move(held_out));
  });
  return py::make_tuple(dictionary(result.files), text(result.oddities + result.words));
}

// --- Predictors ------------------------------------------------------------------------------------------------------------------

struct Rollout {
  std::string column;
  py::array_t<double> time_s, measured, open_loop, one_step;
  double rmse;
};

Rollout rollout(model::Predictor& predictor, const Recording& recording, bool hold_missing) {
  const model::Task& task = predictor.about().task;
  const model::Series series = model::series_of(recording.data, task, hold_missing ? model::Missing::held : model::Missing::refused);
  model::Vector<double> open, step;
  computed([&](const std::function<bool()>&) {
    open = model::rollout(predictor, series);
    step = model::one_step_ahead(predictor, series);
    return true;
  });
  const auto count = static_cast<std::size_t>(series.samples());
  const auto of = [&](const auto& values) { return vector(count, [&](std::size_t k) { return values(static_cast<model::Index>(k)); }); };
  return {task.predicted.name,
          vector(count, [&](std::size_t k) { return series.first_s + static_cast<double>(k) * model::period_s; }),
          of(series.y),
          of(open),
          of(step),
          model::root_mean_square_error(open, series, 1, series.samples() - 1)};
}

void translate(std::exception_ptr thrown) {
  const auto raise = [](const char* type, const py::args& arguments) {
    const py::object class_ = py::module_::import("sinew.errors").attr(type);
    PyErr_SetObject(class_.ptr(), class_(*arguments).ptr());
  };
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const sim::InputError& e) {
    raise("InputError", py::make_tuple(text(e.what()), text(e.file), e.line, e.column, text(e.key), text(e.value), text(e.advice)));
  } catch (const IntegrationFailed& e) {
    raise("IntegrationError", py::make_tuple(text(e.what())));
  } catch (const diagnose::Stopped&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  }
}

}  // namespace
}  // namespace sinew::python

PYBIND11_MODULE(_core, module) {
  using namespace sinew;
  using namespace sinew::python;
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres says its failures in its summary
  py::register_exception_translator(translate);
  module.attr("__version__") = sim::this_build().version;
  module.attr("__commit__") = sim::this_build().commit;

  py::class_<python::Parameter>(module, "Parameter")
      .def_readonly("value", &python::Parameter::value)
      .def_property_readonly("name", [](const python::Parameter& p) { return p.info().key(); })
      .def_property_readonly("unit", [](const python::Parameter& p) { return p.info().declaration.unit.text; })
      .def_property_readonly("symbol", [](const python::Parameter& p) { return p.info().declaration.symbol; })
      .def_property_readonly("lowest", [](const python::Parameter& p) { return p.info().declaration.range.lowest; })
      .def_property_readonly("highest", [](const python::Parameter& p) { return p.info().declaration.range.highest; })
      .def_property_readonly("typical", [](const python::Parameter& p) { return p.info().declaration.typical; })
      .def_property_readonly("prior_deviation", [](const python::Parameter& p) { return p.info().declaration.prior_deviation; })
      .def_property_readonly("meaning", [](const python::Parameter& p) { return p.info().declaration.meaning; })
      .def("__float__", [](const python::Parameter& p) { return p.value; })
      .def("__repr__", [](const python::Parameter& p) {
        return "<" + p.info().key() + " = " + sim::shortest(p.value) + " " + std::string(p.info().declaration.unit.text) + ">";
      });
  py::class_<python::Effect>(module, "Effect")
      .def_readonly("is_on", &python::Effect::is_on)
      .def_readonly("parameters", &python::Effect::parameters)
      .def_property_readonly("name", [](const python::Effect& e) { return e.info().name; })
      .def_property_readonly("place", [](const python::Effect& e) { return e.info().place; })
      .def_property_readonly("equation", [](const python::Effect& e) { return e.info().equation; })
      .def_property_readonly("words", [](const python::Effect& e) { return e.info().words; })
      .def("__repr__", [](const python::Effect& e) { return "<" + std::string(e.info().name) + (e.is_on ? ", on>" : ", off>"); });
  py::class_<python::Law>(module, "Law")
      .def_readonly("name", &python::Law::name)
      .def_readonly("words", &python::Law::words)
      .def_readonly("entry", &python::Law::entry)
      .def_readonly("unit", &python::Law::unit)
      .def_readonly("argument", &python::Law::argument)
      .def_readonly("knots", &python::Law::knots)
      .def_readonly("values", &python::Law::values)
      .def_readonly("is_on", &python::Law::is_on);

  py::class_<python::Plant>(module, "Plant")
      .def(py::init([] { return plant_of(plant::default_plant(), "paper_limb"); }))
      .def(py::init(&read_plant), py::arg("path"))
      .def_static(
          "from_yaml",
          [](const std::string& yaml, const std::string& name) {
            plant::Plant values = sim::read_plant(sim::parse_yaml(yaml, name), std::filesystem::path(name).parent_path());
            return python::Plant{std::move(values), name, sim::sha256(yaml)};
          },
          py::arg("yaml"), py::arg("name") = "plant")
      .def_readonly("name", &python::Plant::name)
      .def_property_readonly("system", [](const python::Plant& p) { return p.system().name(); })
      .def_property_readonly("inputs", [](const python::Plant& p) { return columns_in(p.system().inputs()); })
      .def_property_readonly("channels", [](const python::Plant& p) { return columns_in(p.system().channels()); })
      .def_property_readonly("states", &states_of)
      .def_property_readonly("yaml", [](const python::Plant& p) { return text(sim::plant_file_text(p.values)); })
      .def_property_readonly("laws", &laws_of)
      .def("_parameters", &parameters_of)
      .def("_effects", &effects_of)
      .def("_change", &change)
      .def(
          "save",
          [](const python::Plant& p, const std::filesystem::path& path) { sim::write_file_whole(path, sim::plant_file_text(p.values)); },
          py::arg("path"))
      .def("simulate", &simulate, py::arg("time_s"), py::arg("inputs"), py::kw_only(), py::arg("sensitivities") = false,
           py::arg("tolerance") = 1e-8)
      .def("copy", [](const python::Plant& p) { return p; })
      .def("__copy__", [](const python::Plant& p) { return p; })
      .def("__deepcopy__", [](const python::Plant& p, const py::dict&) { return p; })
      .def("__eq__", [](const python::Plant& a, const python::Plant& b) { return a.values == b.values; })
      .def("__repr__", [](const python::Plant& p) { return "<sinew.Plant " + sim::printable(p.name, 200) + ">"; });

  py::class_<python::Recording>(module, "Recording")
      .def(py::init([](const std::filesystem::path& path, const python::Plant* plant) {
             const auto system = plant ? plant->values.shared_system() : plant::default_plant().shared_system();
             std::string bytes = sim::read_file(path);
             return python::Recording(sim::read_recording(path, *system), sim::sha256(bytes));
           }),
           py::arg("path"), py::arg("plant") = nullptr)
      .def_static(
          "from_columns",
          [](const py::object& columns, const python::Plant* plant, const std::string& name) {
            std::vector<std::pair<std::string, Array>> arrays;
            for (const py::handle key : columns.attr("keys")()) arrays.emplace_back(key.cast<std::string>(), columns[key].cast<Array>());
            const auto system = plant ? plant->values.shared_system() : plant::default_plant().shared_system();
            sim::Recording recording = recording_of(arrays, sim::columns_of(*system), name);
            std::string hash = sim::sha256(sim::to_csv(recording));
            return python::Recording(std::move(recording), std::move(hash));
          },
          py::arg("columns"), py::arg("plant") = nullptr, py::arg("name") = "arrays")
      .def_property_readonly("name", [](const python::Recording& r) { return text(r.data.name); })
      .def_readonly("time_s", &python::Recording::time_s)
      .def_readonly("inputs", &python::Recording::inputs)
      .def_readonly("channels", &python::Recording::channels)
      .def_property_readonly("input_names", [](const python::Recording& r) { return names_of(r.data.columns.inputs); })
      .def_property_readonly("channel_names", [](const python::Recording& r) { return names_of(r.data.columns.channels); })
      .def_property_readonly("notes", [](const python::Recording& r) { return text(r.data.notes.summary()); })
      .def_property_readonly("csv", [](const python::Recording& r) { return text(sim::to_csv(r.data)); })
      .def(
          "save", [](const python::Recording& r, const std::filesystem::path& path) { sim::write_recording(path, r.data); },
          py::arg("path"))
      .def("__len__", [](const python::Recording& r) { return r.data.samples.size(); })
      .def("__getitem__", &python::Recording::column, py::arg("column"))
      .def("__repr__", [](const python::Recording& r) {
        return "<sinew.Recording " + sim::printable(r.data.name, 200) + ", " + std::to_string(r.data.samples.size()) + " samples>";
      });

  py::class_<python::Simulation>(module, "Simulation")
      .def_readonly("time_s", &python::Simulation::time_s)
      .def_readonly("channels", &python::Simulation::channels)
      .def_readonly("states", &python::Simulation::states)
      .def_readonly("jacobian", &python::Simulation::jacobian)
      .def_readonly("channel_names", &python::Simulation::channel_names)
      .def_readonly("state_names", &python::Simulation::state_names)
      .def_readonly("parameter_names", &python::Simulation::parameter_names);

  py::class_<python::Rollout>(module, "Rollout")
      .def_readonly("column", &python::Rollout::column)
      .def_readonly("time_s", &python::Rollout::time_s)
      .def_readonly("measured", &python::Rollout::measured)
      .def_readonly("open_loop", &python::Rollout::open_loop)
      .def_readonly("one_step", &python::Rollout::one_step)
      .def_readonly("rmse", &python::Rollout::rmse);
  py::class_<model::Predictor>(module, "Predictor")
      .def(py::init([](const std::filesystem::path& path) { return apps::read_predictor_at(path.string()); }), py::arg("path"))
      .def_property_readonly("case", [](const model::Predictor& p) { return p.about().task.paper_case; })
      .def_property_readonly("predicted", [](const model::Predictor& p) { return p.about().task.predicted.name; })
      .def_property_readonly("trained_on", [](const model::Predictor& p) { return text(p.about().trained_on); })
      .def("rollout", &rollout, py::arg("recording"), py::kw_only(), py::arg("hold_missing") = false);

  module.def("_calibrate", &calibrate);
  module.def("_diagnose", &diagnose_recordings);
}
