// SPDX-License-Identifier: Apache-2.0
// What a predictor is to the rest of the program: it begins after what was measured, steps, and is kept in a file.
//
// Each kind is one file in model/predictors/, which trains, saves and loads it; the list of kinds is made at build time
// (CMakeLists.txt), so that another kind touches no other file.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/hdf5_file.h"
#include "model/interval.h"
#include "model/train.h"
#include "model/trained_region.h"
#include "model/weights_file.h"
#include "plant/system.h"

namespace sinew::model {

// What is known of any predictor.
struct AboutPredictor {
  Task task;
  std::string kind;                               // name of its PredictorKind
  std::string trained_on;                         // in words, for people
  std::optional<LinearModel> arx = std::nullopt;  // fitted to the same data: what it must beat
  // How far to trust it. No kind need know of them: bytes_of keeps them, and read_predictor finds them. None: an older file.
  std::optional<Intervals> intervals = std::nullopt;
  std::optional<TrainedRegion> region = std::nullopt;
};

class Predictor {
 public:
  virtual ~Predictor() = default;
  const AboutPredictor& about() const { return about_; }
  AboutPredictor& about() { return about_; }

  // Begins anew at the last sample of `history`, which has at least that one. What lies before is for those that can use it: a
  // state that one sample does not show. In the units of a recording.
  virtual void begin(const Series& history) = 0;
  // y one period later, where the inputs are `v` [features]. `y_before`: y measured at the sample before; without it the
  // prediction of that sample takes its place.
  virtual double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before = std::nullopt) = 0;
  // As a file; HDF5, whose root has at least an attribute `sinew` that says the kind.
  virtual Hdf5File save(Layout layout = Layout::keras2) const = 0;
  // Another of the same, to run beside this one.
  virtual std::unique_ptr<Predictor> copy() const = 0;

 protected:
  explicit Predictor(AboutPredictor about) : about_(std::move(about)) {}
  AboutPredictor about_;
};

// y of a series as predicted [samples], from its first sample on, after `history` (which ends with the series' first sample;
// without it, with that sample alone). The first entry is the measured one.
Vector<double> rollout(Predictor& predictor, const Series& series, const Series* history = nullptr);
// The same with each y measured one sample later.
Vector<double> one_step_ahead(Predictor& predictor, const Series& series, const Series* history = nullptr);

struct TrainingInput {
  const std::vector<Series>& data;
  const TrainingFile& settings;
  const TrainingRun& run;
  const Predictor* from = nullptr;      // goes on from it
  const plant::Plant* plant = nullptr;  // for those that hold one
};
struct TrainedPredictor {
  std::unique_ptr<Predictor> predictor;
  std::vector<CurvePoint> curve = {};  // empty where it is not trained step by step
  Index best_update = 0;
  double training_fraction = 1.0;  // of each recording, from its beginning
  std::string validated_by = "";   // what the curve's validation error is, in words
};

struct PredictorKind {
  std::string_view name;
  std::string_view words;
  TrainedPredictor (*train)(const TrainingInput& input);
  std::unique_ptr<Predictor> (*load)(const Hdf5File& file, const std::string& name, const Unsaid& unsaid);
  // All settings as YAML, those of the file or the defaults. Throws InputError where the file's are wrong.
  std::string (*settings_text)(const TrainingFile& file);
  bool counts_updates = false;  // whether TrainingRun::updates is for it
  bool goes_on = false;         // whether TrainingInput::from is for it
  bool holds_another = false;   // a predictor inside, which is trained by its own settings
};

// In the order of their names.
const std::vector<PredictorKind>& predictor_kinds();
std::vector<std::string> predictor_names();
// Throws std::invalid_argument where there is none.
const PredictorKind& predictor_kind(std::string_view name);
// Throws InputError where a number of updates is given to a kind that counts none.
void check_updates(const PredictorKind& kind, std::optional<Index> updates);

// Reads a file of settings; each kind's stand under its name. Throws InputError for a name that is no kind's, and what the kind
// says is wrong.
TrainingFile read_training(const std::filesystem::path& file);

// The file of any kind, with its intervals and the region it was trained on in an attribute `sinew_trust` and an array beside it, under a
// checksum over that and over what the root says. Throws InputError.
std::unique_ptr<Predictor> read_predictor(const std::filesystem::path& path, const Unsaid& unsaid = {});
std::string bytes_of(const Predictor& predictor, Layout layout = Layout::keras2);

// For the kinds. The kind that a file names: in an attribute of its own where another predictor is inside, else in its description.
std::string kind_named_in(const Hdf5File& file, const std::string& name, const Unsaid& unsaid);
// Their description in the attribute `sinew`: task, kind, what it was trained on, ARX, and what the kind itself has to say, `own_json`,
// with a checksum over all that; and back again.
Hdf5File described_file(const AboutPredictor& about, const std::string& own_json);
AboutPredictor read_description(const Hdf5File& file, const std::string& name, const Unsaid& unsaid, std::string& own_json);

}  // namespace sinew::model
