// SPDX-License-Identifier: Apache-2.0
// Any predictor in open loop, and what its last errors say of the next one.
//
//   y(t) = r(t) + e(t),   r: the rollout of the predictor inside, which no measurement touches
//   e(t) = sum_i a_i e(t-i) + sum_j q_j v(t-j) + sum_j s_j r(t-j) + b,  i = 1 ... n, j = 0 ... n
//                                              while the last n of y were measured: an ARX with the rollout as an input
//   e(t) = c_1 e(t-1) + c_2 e(t-2)             while not all of them were: e of a sample that was not measured is the one predicted
//   e(t) = 0                                   while nothing was measured since it began: the rollout alone
//
// A rollout takes its first sample as it was measured, and says where it is itself only at the second: in mid-motion that may be far off,
// since one value does not show a state. So e of the first sample is taken from there, y(0) - r(1).
//
// The second is fitted by the equations of Yule and Walker, with which e decays (Box, Jenkins, Reinsel, 4th ed., 3.2). n is the one
// of 1, 2, 4, 8, 16 that is best one step ahead on the last 15 % of what is fitted to. Innovation form: Ljung, 2nd ed., 4.3.
#include <Eigen/Cholesky>
#include <cmath>

#include "model/linear_predictor.h"
#include "model/task_json.h"
#include "sim/manifest.h"

namespace sinew::model {
namespace {

struct CorrectedSettings {
  static constexpr std::string_view name = "corrected";
  std::string base = "stateful";
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& visit) {
    visit(self.base, sim::Key{"base", {}, "the predictor inside, trained by its own settings; with --from, the one given"});
  }
  void check(const sim::YamlValue& given) const {
    if (base == name) given.complain("base must be another predictor");
    for (const PredictorKind& kind : predictor_kinds())
      if (kind.name == base) return;
    given.complain("base = " + base + " is no predictor");
  }
};

struct Correction {
  LinearModel arx;                                 // inputs: v and r, y: e
  Vector<double> decay = Vector<double>::Zero(2);  // c_1, c_2
};

// e as the series to be predicted, v and r as its inputs.
Series errors_as_series(const Series& series, const Vector<double>& rolled) {
  Series errors{series.name, series.first_s, Matrix<double>(series.v.rows() + 1, series.samples()), series.y - rolled, series.counted};
  errors.v << series.v, rolled.transpose();
  return errors;
}

Correction fit_correction(const std::vector<Series>& errors) {
  Correction correction{.arx = finite(fit_arx_one_step(errors), errors)};
  double r[3] = {0.0, 0.0, 0.0};
  for (const Series& one : errors)
    for (Index lag = 0; lag < 3; ++lag) r[lag] += one.y.tail(one.samples() - lag).dot(one.y.head(one.samples() - lag));
  const double determinant = r[0] * r[0] - r[1] * r[1];
  if (determinant > 1e-12 * r[0] * r[0]) {
    correction.decay(0) = r[1] * (r[0] - r[2]) / determinant;
    correction.decay(1) = (r[0] * r[2] - r[1] * r[1]) / determinant;
  }
  return correction;
}

class CorrectedPredictor : public Predictor {
 public:
  CorrectedPredictor(std::unique_ptr<Predictor> base, Correction correction)
      : Predictor(base->about()),
        base_(std::move(base)),
        correction_(std::move(correction)),
        linear_({}, correction_.arx),
        inputs_(static_cast<Index>(about_.task.features.size()) + 1) {
    about_.kind = CorrectedSettings::name;
  }

  void begin(const Series& history) override {
    base_->begin(history);
    const Index last = history.samples() - 1;
    inputs_ << history.v.col(last), 0.0;  // r: as soon as it is known
    measured_in_turn_ = 0;
    any_ = begun_ = false;
    last_two_[0] = last_two_[1] = 0.0;
  }

  double step(const Eigen::Ref<const Vector<double>>& v, std::optional<double> y_before) override {
    const double rolled = base_->step(v);
    const bool first = !begun_;
    if (first) before_ = inputs_(v.size()) = rolled;
    if (y_before) {
      last_two_[0] = *y_before - before_;
      any_ = true;
    }
    if (first) {  // what came before is as at the first sample
      begun_ = true;
      last_two_[1] = last_two_[0];
      linear_.begin({"", 0.0, inputs_, Vector<double>::Constant(1, last_two_[0])});
    }
    measured_in_turn_ = y_before ? measured_in_turn_ + 1 : 0;
    before_ = rolled;
    inputs_.head(v.size()) = v;
    inputs_(v.size()) = before_;
    const double by_inputs = linear_.step(inputs_, last_two_[0]);
    double error = 0.0;
    if (any_)
      error = measured_in_turn_ >= correction_.arx.order ? by_inputs
                                                         : correction_.decay(0) * last_two_[0] + correction_.decay(1) * last_two_[1];
    last_two_[1] = last_two_[0];
    last_two_[0] = error;
    return before_ + error;
  }

  Hdf5File save(Layout layout) const override {
    base_->about().trained_on = about_.trained_on;
    base_->about().arx = about_.arx;
    Hdf5File file = base_->save(layout);
    nlohmann::ordered_json json = json_of(correction_.arx);
    json["decay"] = {correction_.decay(0), correction_.decay(1)};
    auto& root = file.text_attributes["/"];
    if (const auto inside = root.find("sinew_kind"); inside != root.end()) root["sinew_kind_inside"] = inside->second;
    root["sinew_kind"] = CorrectedSettings::name;
    json["sha256"] = sim::sha256(root["sinew"] + json.dump());
    root["sinew_correction"] = json.dump();
    return file;
  }

  std::unique_ptr<Predictor> copy() const override {
    auto other = std::make_unique<CorrectedPredictor>(base_->copy(), correction_);
    other->about_ = about_;
    return other;
  }

 private:
  std::unique_ptr<Predictor> base_;
  Correction correction_;
  LinearPredictor linear_;
  Vector<double> inputs_;  // v, r
  double before_ = 0.0;    // r of the sample before
  double last_two_[2] = {0.0, 0.0};
  Index measured_in_turn_ = 0;
  bool any_ = false, begun_ = false;
};

TrainedPredictor train_corrected(const TrainingInput& input) {
  const auto settings = input.settings.settings<CorrectedSettings>();
  TrainedPredictor trained;
  if (input.from) {
    if (input.from->about().kind == CorrectedSettings::name)
      complain("", "--from", input.from->about().kind, "is corrected already; name the predictor that is inside it");
    trained.predictor = input.from->copy();
    trained.training_fraction = LinearSettings{}.training_fraction;
  } else {
    check_updates(predictor_kind(settings.base), input.run.updates);
    trained = predictor_kind(settings.base).train(input);
  }
  std::vector<Series> errors;
  for (const Series& one : parts_to_fit(input.data, trained.training_fraction)) {
    if (input.run.should_stop && input.run.should_stop()) throw Stopped{};
    const Vector<double> rolled = rollout(*trained.predictor, one);
    if (!rolled.allFinite()) throw std::runtime_error(one.name + ": the predictor inside goes beyond all bounds in open loop");
    errors.push_back(errors_as_series(one, rolled));
  }
  trained.predictor = std::make_unique<CorrectedPredictor>(std::move(trained.predictor), fit_correction(errors));
  return trained;
}

std::unique_ptr<Predictor> load_corrected(const Hdf5File& file, const std::string& name, const Unsaid& unsaid) {
  Hdf5File inside = file;
  auto& root = inside.text_attributes["/"];
  root.erase("sinew_kind");
  if (const auto kind = root.find("sinew_kind_inside"); kind != root.end()) root["sinew_kind"] = kind->second;
  try {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(root.at("sinew_correction"));
    const std::string sha = json.at("sha256");
    json.erase("sha256");
    if (sha != sim::sha256(root.at("sinew") + json.dump())) complain(name, "sinew_correction", sha, "is not that of what is in the file");
    std::unique_ptr<Predictor> base = predictor_kind(kind_named_in(inside, name, unsaid)).load(inside, name, unsaid);
    Task with_rollout = base->about().task;
    with_rollout.features.push_back({});
    Correction correction{.arx = linear_of_json(json, with_rollout, name)};
    correction.decay << json.at("decay").at(0).get<double>(), json.at("decay").at(1).get<double>();
    return std::make_unique<CorrectedPredictor>(std::move(base), std::move(correction));
  } catch (const nlohmann::json::exception& e) {
    complain(name, "sinew_correction", "", std::string("is no correction: ") + e.what());
  } catch (const std::out_of_range&) {
    complain(name, "sinew_correction", "", "is missing");
  }
}

}  // namespace

PredictorKind make_corrected() {
  return {.name = CorrectedSettings::name,
          .words = "another in open loop, and what its last errors say of the next (settings: base)",
          .train = train_corrected,
          .load = load_corrected,
          .settings_text = settings_text_of<CorrectedSettings>,
          .counts_updates = true,
          .goes_on = true,
          .holds_another = true};
}

}  // namespace sinew::model
