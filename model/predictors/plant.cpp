// SPDX-License-Identifier: Apache-2.0
// A plant as a predictor: its equations, driven by the inputs alone. Nothing is trained here; `sinew calibrate` fits one.
//
// It begins at rest at the first sample of the history, whatever was measured, and follows the inputs from there: where it is to be
// warm, the history has to reach back. What follows the training part of each recording judges it: where the plant was fitted to that too,
// its errors and its intervals come out too small.
#include "model/plant_path.h"
#include "model/predictor.h"
#include "model/task_json.h"
#include "sim/plant_file.h"

namespace sinew::model {
namespace {

struct PlantSettings {
  static constexpr std::string_view name = "plant";
  double relative_tolerance = 1e-5, training_fraction = 0.67;
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.relative_tolerance, sim::Key{"relative_tolerance", {1e-12, 1e-2}, "of the integrator"});
    visit(self.training_fraction,
          sim::Key{"training_fraction", {0.05, 1.0}, "of each recording, from its beginning: the plant may have been fitted to that"});
  }
};

class PlantPredictor : public Predictor {
 public:
  PlantPredictor(AboutPredictor about, const plant::Plant& plant, double relative_tolerance, const std::string& file)
      : Predictor(std::move(about)), path_(plant, about_.task, relative_tolerance, file) {}

  void begin(const Series& history) override {
    path_.begin(history.v.col(0));
    for (Index k = 1; k < history.samples(); ++k) path_.step(history.v.col(k));
  }

  double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double>) override {
    path_.step(v);
    return path_.y();
  }

  Hdf5File save(Layout) const override {
    const nlohmann::ordered_json own{{"plant_file", sim::plant_file_text(path_.plant())},
                                     {"relative_tolerance", path_.relative_tolerance()}};
    return described_file(about_, own.dump());
  }

  std::unique_ptr<Predictor> copy() const override {
    return std::make_unique<PlantPredictor>(about_, path_.plant(), path_.relative_tolerance(), "");
  }

 private:
  PlantPath path_;
};

TrainedPredictor train_plant(const TrainingInput& input) {
  const auto settings = input.settings.settings<PlantSettings>();
  if (!input.plant) complain("", "--plant", "", "is needed: the file of the plant that is to predict, as `sinew calibrate` writes it");
  AboutPredictor about{.task = input.run.task, .kind = std::string(PlantSettings::name), .trained_on = {}};
  return {.predictor = std::make_unique<PlantPredictor>(std::move(about), *input.plant, settings.relative_tolerance, "--plant"),
          .training_fraction = settings.training_fraction};
}

std::unique_ptr<Predictor> load_plant(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  std::string own;
  AboutPredictor about = read_description(file, name, unsaid, own);
  const auto json = nlohmann::ordered_json::parse(own);
  try {
    const sim::YamlValue root = sim::parse_yaml(json.at("plant_file").get<std::string>(), name);
    return std::make_unique<PlantPredictor>(std::move(about), sim::read_plant(root, std::filesystem::path(name).parent_path()),
                                            json.at("relative_tolerance").get<double>(), name);
  } catch (const nlohmann::json::exception& e) {
    complain(name, "plant", "", std::string("is no plant: ") + e.what());
  }
}

}  // namespace

PredictorKind make_plant() {
  return {.name = PlantSettings::name,
          .words = "a plant's own equations (--plant)",
          .train = train_plant,
          .load = load_plant,
          .settings_text = settings_text_of<PlantSettings>};
}

}  // namespace sinew::model
