// SPDX-License-Identifier: GPL-3.0-or-later
// The limb behind the pins: the plant, two MAX31855 on SPI and a bend sensor on the ADC, with the scenario's noise.
//
// An amplifier converts within 100 ms, beginning when its chip select is let go; a select before that stops it and the old
// value stays (MAX31855 data sheet). Its steps are those of the chip: 0.25 K, and 1/16 K for the cold junction.
#pragma once

#include <string>

#include "emulator/board.h"
#include "emulator/body.h"
#include "emulator/fault.h"
#include "sim/random.h"
#include "sim/scenario.h"

namespace sinew::emulator {

class Limb : public Surroundings {
 public:
  // `trace`: keep a row every 10 ms and whenever the gates change. Throws sim::InputError where the scenario's plant has other coils
  // and sensors than the board.
  Limb(const sim::Scenario& scenario, std::vector<Fault> faults, bool trace, std::unique_ptr<Body> body);

  void gates(std::int64_t now_us, const PerCoil<double>& duty_fraction) override;
  void select(std::int64_t now_us, std::size_t coil, bool selected) override;
  std::uint8_t clock_out(std::size_t coil) override;
  int bend_sensor_mV(std::int64_t now_us) override;
  int drain_mV(std::int64_t now_us, std::size_t coil, const PerCoil<bool>& pins_on) override;

  // The next moment at which something here changes by itself.
  std::int64_t next_us() const;
  void advance(std::int64_t now_us);
  const std::string& trace_csv() const { return trace_csv_; }
  // `pause_s` after now, without duty and without faults.
  Left left_after(std::int64_t now_us, double pause_s);
  // A relay that follows PD7 sits in the coils' supply.
  void relay(std::int64_t now_us, bool closed);

 private:
  struct Amplifier {
    std::int64_t begun_us = 0;  // of the conversion; -1: selected, or done
    std::uint32_t shown = 0, shifting = 0;
    std::uint64_t conversions = 0;
  };
  const Fault* active(FaultKind kind, std::size_t coil, std::int64_t now_us) const;
  void move_plant(std::int64_t now_us);
  void hold(std::int64_t now_us);
  double supply_V(std::int64_t now_us) const;
  std::uint32_t convert(std::size_t coil, std::int64_t now_us);
  void row(std::int64_t now_us);
  const sim::Scenario& scenario_;
  std::vector<Fault> faults_;
  bool trace_;
  std::unique_ptr<Body> body_;
  PerCoil<plant::ChannelId> thermocouples_;
  plant::ChannelId angle_;
  plant::ParameterId supply_, ambient_;
  PerCoil<double> gates_{};
  bool relay_closed_ = true;
  PerCoil<Amplifier> amplifiers_;
  std::vector<sim::RandomStream> noise_;  // one a channel
  std::uint64_t angle_conversions_ = 0;
  int bend_mV_ = 2500;  // shown last
  std::int64_t moved_us_ = 0;
  std::string trace_csv_;
};

}  // namespace sinew::emulator
