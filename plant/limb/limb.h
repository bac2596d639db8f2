// SPDX-License-Identifier: Apache-2.0
// The System of soft limbs that are bent by SMA coils, for any number of segments and coils.
#pragma once

#include "plant/limb/equations.h"

namespace sinew::plant {

// Compiled once, in limb.cpp.
extern template class LimbEquations<double>;
extern template class LimbEquations<Jet>;

class LimbSystem final : public System {
 public:
  LimbSystem(Shape shape, const std::vector<OwnValues>& own);

  States states(const EffectsOn& on) const override;
  std::unique_ptr<Equations<double>> equations(const std::vector<double>& values, const EffectsOn& on) const override;
  std::unique_ptr<Equations<Jet>> equations(const std::vector<Jet>& values, const EffectsOn& on) const override;
  std::vector<StartBelief> start_beliefs(const Plant& plant, std::span<const double> first_measured) const override;
  std::vector<std::vector<std::pair<StateId, double>>> other_starts(const Plant& plant,
                                                                    const std::vector<std::optional<double>>& start) const override;
  std::string structure_yaml() const override;
  std::shared_ptr<const System> with_own(const std::vector<std::size_t>& sharings) const override;

  const Shape& shape() const { return shape_; }
  // The concrete equations, for tests that look inside.
  std::unique_ptr<LimbEquations<double>> limb_equations(const Plant& plant) const;

 private:
  Envelopes<double> loop_at(const Plant& plant, std::size_t coil, double temperature_degC) const;
  void list_sharings();
  void list_channels();
  void list_entries();
  void list_drives();
  void list_loggers();

  Shape shape_;
  std::vector<OwnValues> own_values_;
  OwnParts own_;  // of effects; the core's are the shape's
};

// The limb of plant files of format 1, shared.
const std::shared_ptr<const LimbSystem>& two_coil_limb();

}  // namespace sinew::plant
