// SPDX-License-Identifier: Apache-2.0
// A diagnosis: where a plant and recordings differ, what physics was left out, how well the plant does once it is put in,
// and what to do next. Everything that the report, the terminal and diagnosis.json say stands in `Diagnosis`.
#pragma once

#include <optional>

#include "diagnose/chance.h"
#include "diagnose/decide.h"
#include "diagnose/gate.h"
#include "diagnose/held_out.h"
#include "diagnose/locate.h"
#include "diagnose/names.h"

namespace sinew::diagnose {

struct DiagnosisSettings {
  SearchSettings search;
  std::optional<PerChannel> noise;  // of each sensor, in the units of files; else estimated
  double fit_until_s = 1e300;       // of each training recording; what comes later is held out
  Beginnings start;
  Thresholds thresholds;
  WanderSettings wander;  // thresholds
};

// An effect of the catalogue that this recording could not have shown, or how small it would have been seen.
struct Visibility {
  plant::EffectId effect{};
  double visible_share;  // what calibration cannot absorb
  double smallest_seen;  // |strength - null| in the units of files
  double statistic;
  bool can_be_seen;  // a typical strength would be
};

struct Diagnosis {
  Answer answer;
  std::vector<GateNotes> gate;
  Search search;
  Located located;
  // Of the core's misfit, by what was found or by what stands in for it; of the errors of open-loop simulations, where `by_paths`. What
  // varies has a share of its own.
  double explained_share = 0.0;
  bool by_paths = false;  // what was found, was by open-loop simulation (proposals.h)
  Proposals proposals;    // that were compared then
  // Where there is process noise to be seen: what is beyond the ordinary.
  std::optional<double> process_noise_beyond_ordinary;
  // Where the verdict hangs on a process noise that is not large: what is left of it once the parameters are fitted again without the
  // forcings that carry it; and, unless that is nothing, how large it becomes where nothing is missing.
  std::optional<double> process_noise_after_refit;
  std::optional<ProcessNoiseByChance> by_chance;
  double visibility = 0.0;         // d': root of the core's misfit beyond noise and air
  std::vector<Visibility> others;  // effects that were not found
  LeftOver left_over;
  std::vector<plant::ParameterId> flipped_signs;
  Explanation chosen;  // the explanation that is the answer; its evidence, and what it leaves
  Explanation values;  // of `repaired`: every value and interval that is said is from here
  plant::Plant repaired;
  std::vector<plant::Start> starts;  // of the recordings, as `predictions` has them, repaired
  Agreement agreement_before, agreement_after;
  Objections objections;  // to the best names that were found by evidence
  HeldOutError held_out;
  // Of each recording that was held out, the inputs that it drives and training leaves alone: if any, its errors are said, but do not
  // object to what was found. Where none is left that could, two blocks of each training recording are not fitted, and do.
  std::vector<std::vector<plant::InputId>> driven_more;
  bool judged_on_blocks = false;
  std::vector<Prediction> predictions;  // training recordings, then held-out ones
  ResidualCorrelation correlation;
  std::shared_ptr<const void> kept_alive;  // the recordings as they were fitted, which explanations point into
};

// What the repaired plant predicts of a recording with one effect or law, fitted as it is, at a share of its strength, 0 to 1, and all else
// as fitted. Units of files; NaN where it cannot follow. Empty where there is no such share: something is there or not.
Series predicted_at_share(const Diagnosis& diagnosis, std::size_t prediction, plant::EffectId effect, double share);

// Training recordings must outlive the result, and so must the held-out ones. Throws Stopped, std::runtime_error.
Diagnosis diagnose(const plant::Plant& nominal, const std::vector<sim::Recording>& training, const std::vector<sim::Recording>& held_out,
                   const DiagnosisSettings& settings);

}  // namespace sinew::diagnose
