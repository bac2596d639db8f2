// SPDX-License-Identifier: Apache-2.0
// A plant in open loop, and a predictor of what it leaves: physics as far as it is known, and a network for the rest.
//
//   x(t), p(t): states and predicted channel of the plant's equations, driven by the inputs alone, at rest where the history begins
//   y(t) = p(t) + e(t),   e(t) by the predictor inside from [v(t), p(t), x(t)], the same at t-1, and e(t-1)
//
// The predictor inside sees how warm and how far transformed each coil is, which no measured value need show, and has to learn only what
// the plant has wrong. e(t-1) is what was measured less p(t-1), or what was predicted. Source: Forssell and Lindskog 1997 (IFAC SYSID),
// "Combining semi-physical and neural network modeling"; the residual form: Willard et al. 2022, arXiv:2003.04919, section 3.4.
#include <cmath>

#include "model/plant_path.h"
#include "model/predictor.h"
#include "model/task_json.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"

namespace sinew::model {
namespace {

struct HybridSettings {
  static constexpr std::string_view name = "hybrid";
  std::string base = "stateful";
  double relative_tolerance = 1e-5;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.base, sim::Key{"base", {}, "the predictor of what the plant leaves, trained by its own settings"});
    visit(self.relative_tolerance, sim::Key{"relative_tolerance", {1e-12, 1e-2}, "of the integrator"});
  }
  void check(const sim::YamlValue& given) const {
    if (base == name || base == "plant" || base == "corrected")
      given.complain("base must be a predictor without another one or a plant in it; `corrected` goes round a hybrid, by --from");
    for (const PredictorKind& kind : predictor_kinds())
      if (kind.name == base) return;
    given.complain("base = " + base + " is no predictor");
  }
};

// What the predictor inside is given and asked for.
Task task_inside(const Task& task, const plant::Plant& plant) {
  Task inside = task;
  const auto of_plant = [&](const std::string& name, const std::string& words, const std::string& unit) {
    inside.features.push_back({{.name = "plant_" + name, .words = words + " of the plant", .unit = unit}, true});
  };
  of_plant(task.predicted.name, task.predicted.words, task.predicted.unit);
  const plant::States states = plant.states();
  for (const plant::StateId i : states.ids()) of_plant(std::string(states[i].key), std::string(states[i].key), "");
  inside.predicted.name = "residual_" + task.predicted.name;
  inside.predicted.words = "residual of " + task.predicted.words;
  return inside;
}

// What the predictor inside is given of the plant: its channel, its states.
Vector<double> seen(const PlantPath& path) {
  Vector<double> all(1 + path.states().size());
  all << path.y(), path.states();
  return all;
}

// What the plant leaves of a series, with what the plant says among the inputs. Leaves the path at the last sample.
Series left_by(PlantPath& path, const Series& series) {
  const Index K = series.v.rows(), n = series.samples();
  const Index of_plant = 1 + path.states().size();
  Series left{series.name, series.first_s, Matrix<double>(K + of_plant, n), Vector<double>(n), series.counted};
  left.v.topRows(K) = series.v;
  for (Index k = 0; k < n; ++k) {
    k == 0 ? path.begin(series.v.col(0)) : path.step(series.v.col(k));
    left.v.col(k).tail(of_plant) = seen(path);
    left.y(k) = series.y(k) - path.y();
  }
  return left;
}

class HybridPredictor : public Predictor {
 public:
  HybridPredictor(AboutPredictor about, const plant::Plant& plant, double relative_tolerance, std::unique_ptr<Predictor> inside,
                  const std::string& file)
      : Predictor(std::move(about)),
        path_(plant, about_.task, relative_tolerance, file),
        inside_(std::move(inside)),
        inputs_(static_cast<Index>(about_.task.features.size()) + 1 + path_.states().size()) {}

  void begin(const Series& history) override {
    inside_->begin(left_by(path_, history));
    plant_before_ = path_.y();
  }

  double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before) override {
    path_.step(v);
    inputs_ << v, path_.y(), path_.states();
    const double error = y_before ? inside_->step(inputs_, *y_before - plant_before_) : inside_->step(inputs_);
    plant_before_ = path_.y();
    return plant_before_ + error;
  }

  Hdf5File save(Layout layout) const override {
    Hdf5File file = inside_->save(layout);
    auto& root = file.text_attributes["/"];
    const nlohmann::ordered_json own{{"plant_file", sim::plant_file_text(path_.plant())},
                                     {"relative_tolerance", path_.relative_tolerance()},
                                     {"inside_sha256", sim::sha256(root["sinew"])}};
    root["sinew_hybrid"] = described_file(about_, own.dump()).text_attributes.at("/").at("sinew");
    root["sinew_kind"] = HybridSettings::name;
    return file;
  }

  std::unique_ptr<Predictor> copy() const override {
    return std::make_unique<HybridPredictor>(about_, path_.plant(), path_.relative_tolerance(), inside_->copy(), "");
  }
  const Predictor& inside() const { return *inside_; }

 private:
  PlantPath path_;
  std::unique_ptr<Predictor> inside_;
  Vector<double> inputs_;
  double plant_before_ = 0.0;
};

TrainedPredictor train_hybrid(const TrainingInput& input) {
  const auto settings = input.settings.settings<HybridSettings>();
  const auto* from = dynamic_cast<const HybridPredictor*>(input.from);
  if (input.from && !from) complain("", "--from", input.from->about().kind, "cannot go on as hybrid");
  if (!input.plant) complain("", "--plant", "", "is needed: the file of the plant whose states are used, as `sinew calibrate` writes it");
  PlantPath path(*input.plant, input.run.task, settings.relative_tolerance, "--plant");
  std::vector<Series> left;
  for (const Series& one : input.data) {
    if (input.run.should_stop && input.run.should_stop()) throw Stopped{};
    left.push_back(left_by(path, one));
    if (!left.back().y.allFinite()) throw std::runtime_error(one.name + ": the plant cannot be integrated over this recording");
  }
  TrainingRun run = input.run;
  run.task = task_inside(input.run.task, *input.plant);
  check_updates(predictor_kind(settings.base), run.updates);
  TrainedPredictor trained = predictor_kind(settings.base).train({left, input.settings, run, from ? &from->inside() : nullptr});
  AboutPredictor about{.task = input.run.task, .kind = std::string(HybridSettings::name), .trained_on = {}};
  trained.predictor = std::make_unique<HybridPredictor>(std::move(about), *input.plant, settings.relative_tolerance,
                                                        std::move(trained.predictor), "--plant");
  return trained;
}

std::unique_ptr<Predictor> load_hybrid(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  Hdf5File inside = file, described;
  auto& root = inside.text_attributes["/"];
  root.erase("sinew_kind");
  if (!root.count("sinew_hybrid") || !root.count("sinew")) complain(name, "sinew_hybrid", "", "is missing");
  described.text_attributes["/"]["sinew"] = root.at("sinew_hybrid");
  std::string own;
  AboutPredictor about = read_description(described, name, unsaid, own);
  try {
    const auto json = nlohmann::ordered_json::parse(own);
    if (json.at("inside_sha256") != sim::sha256(root.at("sinew")))
      complain(name, "inside_sha256", json.at("inside_sha256"), "is not that of the predictor in the file");
    const sim::YamlValue yaml = sim::parse_yaml(json.at("plant_file").get<std::string>(), name);
    const plant::Plant plant = sim::read_plant(yaml, std::filesystem::path(name).parent_path());
    const Task task = task_inside(about.task, plant);
    return std::make_unique<HybridPredictor>(
        std::move(about), plant, json.at("relative_tolerance").get<double>(),
        predictor_kind(kind_named_in(inside, name, {})).load(inside, name, {.task = task, .method = {}, .lowest = {}, .highest = {}}),
        name);
  } catch (const nlohmann::json::exception& e) {
    complain(name, "sinew_hybrid", "", std::string("is no hybrid: ") + e.what());
  }
}

}  // namespace

PredictorKind make_hybrid() {
  return {.name = HybridSettings::name,
          .words = "a plant (--plant), and a network on what it leaves (settings: base)",
          .train = train_hybrid,
          .load = load_hybrid,
          .settings_text = settings_text_of<HybridSettings>,
          .counts_updates = true,
          .goes_on = true,
          .holds_another = true};
}

}  // namespace sinew::model
