// SPDX-License-Identifier: Apache-2.0
// A plant as a predictor: its equations, driven by the inputs alone. Nothing is trained here; `sinew calibrate` fits one.
//
// It begins at rest at the first sample of the history, whatever was measured, and follows the inputs from there: where it is to be
// warm, the history has to reach back. What follows the training part of each recording judges it: where the plant was fitted to that too,
// its errors and its intervals come out too small.
#include <cmath>

#include "model/predictor.h"
#include "model/task_json.h"
#include "plant/integrator.h"
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
  PlantPredictor(AboutPredictor about, plant::Plant plant, double relative_tolerance, const std::string& file)
      : Predictor(std::move(about)),
        plant_(std::move(plant)),
        numerics_{plant::Method::automatic, relative_tolerance},
        places_(places_in(sim::columns_of(plant_.system()), about_.task, file)),
        inputs_(plant_.system().inputs().size(), 0.0) {}

  void begin(const Series& history) override {
    integrator_.emplace(plant_, plant::Start{}, numerics_);
    failed_ = false;
    steps_ = 0;
    hold(history.v.col(0));
    for (Index k = 1; k < history.samples(); ++k) step(history.v.col(k), std::nullopt);
  }

  double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double>) override {
    ++steps_;
    if (failed_ || integrator_->advance_to(static_cast<double>(steps_) * period_s)) {
      failed_ = true;
      return std::nan("");
    }
    const plant::ChannelInfo& channel = plant_.system().channels()[plant::ChannelId{places_.predicted}];
    const double y = integrator_->readings()[places_.predicted] / channel.unit.internal_per_unit;
    hold(v);
    return y;
  }

  Hdf5File save(Layout) const override {
    const nlohmann::ordered_json own{{"plant_file", sim::plant_file_text(plant_)}, {"relative_tolerance", numerics_.relative_tolerance}};
    return described_file(about_, own.dump());
  }

  std::unique_ptr<Predictor> copy() const override {
    return std::make_unique<PlantPredictor>(about_, plant_, numerics_.relative_tolerance, "");
  }

 private:
  void hold(const Eigen::Ref<const Vector<double>>& v) {
    for (std::size_t f = 0; f < places_.features.size(); ++f)
      if (!places_.features[f].measured) inputs_[places_.features[f].index] = v(static_cast<Index>(f));
    integrator_->hold(inputs_);
  }

  plant::Plant plant_;
  plant::NumericalSettings numerics_;
  Places places_;
  std::vector<double> inputs_;
  std::optional<plant::Integrator> integrator_;
  std::int64_t steps_ = 0;
  bool failed_ = false;
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
  return {PlantSettings::name, "a plant's own equations (--plant)", train_plant, load_plant, settings_text_of<PlantSettings>};
}

}  // namespace sinew::model
