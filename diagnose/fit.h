// SPDX-License-Identifier: Apache-2.0
// A plant against recordings, as a least-squares problem: unknowns, residuals and their exact derivatives.
//
// Unknowns are parameters of the plant, shared by all recordings, and for each recording the first values of those states
// that a recording may begin with in mid-motion, or that have grown since the first one began (plant::AtStart); the others are at rest
// with them (System::start_beliefs). Each unknown has a weak prior and bounds from its declaration, and a coordinate z in which the prior
// is N(0, 1): value = centre + z deviation. The prior of a quantity that cannot but be positive is log-normal, value =
// centre exp(z log_deviation): twice as much is believed as easily as half.
//
// Rows: (model - measured) / deviation for every sample that is there, recording by recording, time by time, channel by channel;
// then one row z for each unknown; then one for each pair of unknowns that physics orders (Declaration::less_than): by how many
// hundredths of the prior's deviation, where it is so, the lower one lies above the higher.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnose/channels.h"
#include "plant/integrator.h"
#include "sim/recording.h"

namespace sinew::diagnose {

struct Unknown {
  std::string name;                             // of a parameter; "start.<state>"; of several recordings "start[1].<state>"
  std::optional<plant::ParameterId> parameter;  // none: a first value
  double centre, deviation, lowest, highest;    // internal units
  double internal_per_unit;
  std::string_view unit;
  double log_deviation = 0.0;  // of a log-normal prior, whose median is `centre`; 0: the prior is normal
  double value_at(double z) const { return log_deviation > 0.0 ? centre * std::exp(z * log_deviation) : centre + z * deviation; }
  double coordinate_of(double value) const {
    return log_deviation > 0.0 ? std::log(value / centre) / log_deviation : (value - centre) / deviation;
  }
  double slope_at(double z) const { return log_deviation > 0.0 ? value_at(z) * log_deviation : deviation; }  // dvalue/dz
};

struct FitData {
  const sim::Recording* recording;
  std::size_t sample_count;  // the first so many samples are fitted
  PerChannel deviation;      // what a residual of each channel is divided by; at least the sensor's noise
};

enum class StartPolicy {
  estimated,  // recordings may begin in mid-motion
  at_rest,    // all begin cold and at rest; unknown is at most what has grown since the first recording
};
struct Beginnings {
  StartPolicy policy;
  // When what is counted from the first recording on was nothing, on the clock of recordings that say when they were made
  // (sim::Recording::time_zero_s). None: where the first of those that are fitted begins.
  std::optional<double> counted_from_s;
  bool later = false;  // the first of these is not the limb's first recording: what has grown since then is open in it, too
  // NOLINTNEXTLINE(google-explicit-constructor): where no clock matters, a policy is all there is to say
  Beginnings(StartPolicy how = StartPolicy::estimated, std::optional<double> from_s = std::nullopt, bool others_before = false)
      : policy(how), counted_from_s(from_s), later(others_before) {}
  friend bool operator==(const Beginnings& one, StartPolicy policy) { return one.policy == policy; }
};

// By state: the time since `from_s` where it begins, of states that are that time, where the recording says when it was made and
// that is near enough; else none.
std::vector<std::optional<double>> elapsed_where_it_begins(const plant::States& states, const sim::Recording& recording,
                                                           std::optional<double> from_s);

struct Row {
  std::size_t recording, sample;
  plant::ChannelId channel;
};

// A course that the forcings (state_noise.h) may have taken. Paths follow it instead of none, and what it does to the residuals to first
// order is taken off again: they are what they were, but for what is not linear.
struct Course {
  std::vector<std::string> states;      // keys of those that it pushes
  std::vector<Eigen::MatrixXd> pushes;  // of each recording: [states x samples less one], from a sample to the next; internal units
  std::vector<double> response;         // [rows of the problem], in standard deviations of the sensors
};

class FitProblem {
 public:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // `centres`: what is on, what is not fitted, and the centres of the priors. Recordings must outlive this.
  FitProblem(const plant::Plant& centres, const std::vector<plant::ParameterId>& parameters, std::vector<FitData> data,
             const Beginnings& start, const plant::NumericalSettings& numerics);

  const std::vector<Unknown>& unknowns() const { return unknowns_; }
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<FitData>& data() const { return data_; }
  const plant::NumericalSettings& numerics() const { return numerics_; }
  const std::vector<plant::ParameterId>& parameters() const { return parameters_; }
  const plant::System& system() const { return centres_.system(); }
  const Beginnings& beginnings() const { return start_; }
  bool at_rest() const { return start_ == StartPolicy::at_rest; }
  // States whose first value is unknown where this recording begins, and the first of their unknowns, which stand in this order.
  const std::vector<plant::StateId>& free_states(std::size_t recording) const { return free_states_[recording]; }
  std::size_t first_start(std::size_t recording) const { return first_start_[recording]; }
  // Where inputs act late, what was commanded before a recording acts in it: its first command, or nothing.
  void set_idle_before(std::vector<bool> idle) { idle_before_ = std::move(idle); }
  const std::vector<bool>& idle_before() const { return idle_before_; }  // empty: none
  // None where it is of other states or samples.
  void set_course(const std::shared_ptr<const Course>& course);
  const std::shared_ptr<const Course>& course() const { return course_; }  // null: none
  // Moves an integrator that has come to this sample by what the course, if there is one, brings since the one before.
  void follow_course(plant::Integrator& integrator, std::size_t recording, std::size_t sample) const {
    if (course_ && sample > 0) integrator.move(course_->pushes[recording].col(static_cast<Eigen::Index>(sample) - 1));
  }
  void set_deviation(std::size_t recording, plant::ChannelId channel, double deviation) { data_[recording].deviation[channel] = deviation; }
  std::size_t residual_count() const { return rows_.size() + unknowns_.size() + orders_.size(); }
  // Rows of the pairs that physics orders, and their derivatives [orders x unknowns]; 0 where the order is kept.
  std::size_t order_count() const { return orders_.size(); }
  Eigen::VectorXd order_residuals(const double* z, FitProblem::RowMajor* jacobian) const;

  double value(std::size_t unknown, double z) const { return unknowns_[unknown].value_at(z); }
  const plant::Plant& centres() const { return centres_; }  // what is on, and the centres of the priors
  plant::Plant plant_at(const double* z) const;
  plant::Start start_at(const double* z, std::size_t recording) const;

  // False where the integration fails. `jacobian`: [residual_count x unknowns], row-major, or null.
  bool evaluate(const double* z, double* residuals, double* jacobian) const;

 private:
  std::vector<std::vector<double>> grown_by_then() const;
  void add_start_unknowns(std::size_t recording, const std::vector<double>& grown);

  plant::Plant centres_;
  plant::States states_;
  std::vector<plant::ParameterId> parameters_;
  std::vector<FitData> data_;
  Beginnings start_;
  std::vector<bool> idle_before_;
  std::shared_ptr<const Course> course_;
  plant::NumericalSettings numerics_;
  std::vector<Unknown> unknowns_;
  struct Order {
    std::size_t low, high;  // unknowns
    double scale;
  };
  std::vector<Order> orders_;
  std::vector<std::vector<std::optional<double>>> elapsed_;  // of each recording, as all below
  std::vector<std::vector<plant::StateId>> free_states_;
  std::vector<std::size_t> first_start_, first_row_;
  std::vector<Row> rows_;
};

}  // namespace sinew::diagnose
