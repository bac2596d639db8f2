// SPDX-License-Identifier: Apache-2.0
#include "model/plant_path.h"

#include <cmath>

#include "sim/signals.h"

namespace sinew::model {

PlantPath::PlantPath(const plant::Plant& plant, const Task& task, double relative_tolerance, const std::string& file)
    : plant_(plant),
      numerics_{plant::Method::automatic, relative_tolerance},
      places_(places_in(sim::columns_of(plant_.system()), task, file)),
      inputs_(plant_.system().inputs().size(), 0.0),
      states_(Vector<double>::Zero(static_cast<Index>(plant_.states().size()))) {}

void PlantPath::begin(const Eigen::Ref<const Vector<double>>& v) {
  integrator_.emplace(plant_, plant::Start{}, numerics_);
  steps_ = 0;
  see();
  hold(v);
}

void PlantPath::step(const Eigen::Ref<const Vector<double>>& v) {
  ++steps_;
  if (std::isnan(y_) || integrator_->advance_to(static_cast<double>(steps_) * period_s)) {
    y_ = std::nan("");
    states_.setConstant(y_);
    return;
  }
  see();
  hold(v);
}

void PlantPath::see() {
  const plant::ChannelInfo& channel = plant_.system().channels()[plant::ChannelId{places_.predicted}];
  y_ = integrator_->readings()[places_.predicted] / channel.unit.internal_per_unit;
  states_ = Eigen::Map<const Vector<double>>(integrator_->state().data(), states_.size());
}

void PlantPath::hold(const Eigen::Ref<const Vector<double>>& v) {
  for (std::size_t f = 0; f < places_.features.size(); ++f)
    if (!places_.features[f].measured) inputs_[places_.features[f].index] = v(static_cast<Index>(f));
  integrator_->hold(inputs_);
}

}  // namespace sinew::model
