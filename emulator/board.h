// SPDX-License-Identifier: GPL-3.0-or-later
// The board in simavr: the firmware's .elf on an ATmega328P, with what is soldered to it.
//
// Plant, sensors and serial bytes are driven from the loop in run(), not from simavr's cycle timers: a watchdog reset drops
// those. Time is the processor's count of cycles and never goes back.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

struct avr_t;
struct avr_irq_t;

namespace sinew::emulator {

inline constexpr std::int64_t cycles_per_us = 16;

// The board's coils: a gate, an amplifier and a chip select each. BOARD_COILS of its firmware.
inline constexpr std::size_t board_coils = 2;
template <class Value>
using PerCoil = std::array<Value, board_coils>;

// What is soldered to the pins.
class Surroundings {
 public:
  virtual ~Surroundings() = default;
  // Duty that reaches the gates: from now on.
  virtual void gates(std::int64_t now_us, const PerCoil<double>& duty_fraction) = 0;
  virtual void select(std::int64_t now_us, std::size_t coil, bool selected) = 0;
  virtual std::uint8_t clock_out(std::size_t coil) = 0;  // the amplifier's next byte
  virtual int bend_sensor_mV(std::int64_t now_us) = 0;
  // At the drain of a coil's switch; `pins_on`: what drives the gates at this moment.
  virtual int drain_mV(std::int64_t now_us, std::size_t coil, const PerCoil<bool>& pins_on) = 0;
};

// What the program used of the chip, since power-on.
struct Usage {
  int static_bytes, stack_most_bytes, ram_bytes;  // the stack grows down towards what is static
  struct Interrupt {
    const char* name;
    double longest_us, longest_wait_us;  // to run, its entry and return included; from its request until it is entered
    std::int64_t count;
  };
  std::vector<Interrupt> interrupts;
  int most_ms_since_round;  // that the millisecond interrupt has seen the main loop stay away
};

enum class Fuse { low, high, extended };
enum class Reset { power_on, external, brown_out };

class Board {
 public:
  // Throws std::runtime_error where the file is no firmware for an ATmega328P.
  // `is_new`: its EEPROM is erased; otherwise it holds what the file has for it. `dividers`: those at the drains are fitted.
  Board(const std::string& elf, Surroundings& surroundings, bool is_new, bool dividers);
  ~Board();
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  std::int64_t now_us() const;
  // Bytes on their way to the receiver; they arrive one after the other at the baud rate.
  void send(const std::vector<std::uint8_t>& bytes);
  // Runs until then. Stops early once a byte 0x00 has been sent whole, if asked to.
  void run(std::int64_t until_us, bool stop_at_frame_end);
  std::vector<std::uint8_t> take_sent();
  bool something_sent() const { return !sent_.empty(); }

  // A cell of the EEPROM takes 3.4 ms to write. Where power goes or sags meanwhile, it is erased and not programmed.
  void reset(Reset cause);
  // When the EEPROM began to write a cell last; -1: never.
  std::int64_t writing_since_us() const { return write_begun_cycle_ < 0 ? -1 : write_begun_cycle_ / cycles_per_us; }
  // The program counter on an instruction that jumps to itself: with interrupts served or not.
  void hang(bool interrupts_served);
  // Sets the firmware's millisecond count, so that a wrap need not be waited for.
  void set_time_ms(std::uint32_t time_ms);
  // Low, high and extended. The .elf says what they should be, and so they are until this is called.
  void set_fuse(Fuse which, std::uint8_t value) { fuses_[static_cast<std::size_t>(which)] = value; }
  const PerCoil<double>& gates() const { return gates_; }
  bool relay() const;  // behind a charge pump that PD7 must keep swinging
  Usage usage() const;

 private:
  struct SentByte {
    std::uint8_t byte;
    std::int64_t done_cycle;
  };
  void connect();
  void look_at_gates();
  bool pin_on(std::size_t coil) const;
  std::uint8_t* cell(int address);
  avr_t* avr_ = nullptr;
  Surroundings& surroundings_;
  bool dividers_;
  std::deque<std::uint8_t> arriving_;
  std::int64_t next_arrival_cycle_ = 0;
  std::deque<SentByte> sending_;
  std::vector<std::uint8_t> sent_;
  std::uint64_t gate_registers_ = 0;
  bool gates_written_ = true;
  PerCoil<double> gates_{};
  std::optional<std::size_t> selected_;  // coil whose amplifier hears the clock
  std::uint32_t time_ms_address_ = 0;
  std::int64_t write_begun_cycle_ = -1;  // of the EEPROM
  int written_cell_ = 0;
  bool writing_ = false;
  std::int64_t swung_cycle_ = -1;                        // PD7
  std::array<std::uint8_t, 3> fuses_{0x62, 0xd9, 0xff};  // of a new chip
  std::array<std::uint8_t, 4> flash_begin_{};            // its first bytes, while a reading of the fuses stands in for them
  std::int64_t fuses_shown_cycle_ = -1;
  // The interrupts that the program uses, by their vector's number.
  struct Watched {
    Board* board;
    const char* name;
    std::uint8_t vector;
    std::int64_t asked_cycle = -1, entered_cycle = -1, longest = 0, longest_wait = 0, count = 0;
  };
  std::vector<Watched> watched_;
  std::uint32_t ms_since_round_address_ = 0;
  std::uint8_t most_ms_since_round_ = 0;
  int static_end_ = 0;  // address behind what is static, in the chip's data space
  static void on_interrupt_asked(::avr_irq_t*, std::uint32_t, void*);
  static void on_interrupt_running(::avr_irq_t*, std::uint32_t, void*);
  static void on_relay_pin(::avr_irq_t*, std::uint32_t, void*);
  static void on_eeprom_control(::avr_irq_t*, std::uint32_t, void*);
  void hide_fuses();
  static void on_self_programming(::avr_irq_t*, std::uint32_t, void*);
  static void on_gate_register(::avr_irq_t*, std::uint32_t, void*);
  static void on_uart(::avr_irq_t*, std::uint32_t, void*);
  static void on_spi(::avr_irq_t*, std::uint32_t, void*);
  static void on_adc(::avr_irq_t*, std::uint32_t, void*);
  template <std::size_t coil>
  static void on_select(::avr_irq_t*, std::uint32_t, void*);
};

}  // namespace sinew::emulator
