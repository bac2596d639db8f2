// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulator/board.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

extern "C" {
#include <avr_adc.h>
#include <avr_eeprom.h>
#include <avr_ioport.h>
#include <avr_spi.h>
#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_elf.h>
}

namespace sinew::emulator {
namespace {

constexpr std::int64_t cycles_per_byte = 320;                        // ten bits at 500000 Bd
constexpr std::int64_t charge_pump_cycles = 20'000 * cycles_per_us;  // that its capacitor holds the relay
constexpr std::int64_t cycles_per_cell = 3400 * cycles_per_us;
constexpr int ram_begin = 0x100, ram_end = 0x900;  // data sheet, figure 8-2
// What the stack has not reached shows this: power-on leaves chance in RAM, and this is as good as any.
constexpr std::uint8_t untouched = 0xc5;
constexpr std::int64_t cycles_of_entry = 4;  // of an interrupt: the program counter is pushed, which simavr does not count
constexpr std::uint32_t frequency_Hz = 16'000'000;
// Addresses in data space, ATmega328P data sheet, section 35.
constexpr int spmcsr = 0x57, ddrb = 0x24, portb = 0x25, mcusr = 0x54, tccr1a = 0x80, tccr1b = 0x81, icr1 = 0x86, eecr = 0x3f, eearl = 0x41,
              ocr1a = 0x88, ocr1b = 0x8a, admux = 0x7c;

// Of each coil: its bit in port B, its compare mode's in TCCR1A, its compare register.
struct GatePin {
  int pin, mode_bit, compare;
};
constexpr PerCoil<GatePin> gate_pins{{{1, 6, ocr1a}, {2, 4, ocr1b}}};

void log_errors(avr_t*, const int level, const char* format, va_list arguments) {
  if (level <= LOG_ERROR) std::vfprintf(stderr, format, arguments);
}

void do_not_sleep(avr_t*, avr_cycle_count_t) {}
avr_cycle_count_t wake(avr_t*, avr_cycle_count_t, void*) { return 0; }

}  // namespace

Board::Board(const std::string& elf, Surroundings& surroundings, bool is_new, bool dividers)
    : surroundings_(surroundings), dividers_(dividers) {
  avr_global_logger_set(log_errors);
  elf_firmware_t firmware{};
  if (std::FILE* file = std::fopen(elf.c_str(), "rb"))
    std::fclose(file);
  else
    throw std::runtime_error(elf + ": cannot read");
  if (elf_read_firmware(elf.c_str(), &firmware) != 0 || firmware.flashsize == 0) throw std::runtime_error(elf + ": is no AVR program");
  avr_ = avr_make_mcu_by_name("atmega328p");
  if (!avr_) throw std::runtime_error("simavr knows no atmega328p");
  avr_init(avr_);
  std::strcpy(firmware.mmcu, "atmega328p");
  if (is_new) firmware.eesize = 0;
  for (std::size_t k = 0; k < fuses_.size() && k < firmware.fusesize; ++k) fuses_[k] = firmware.fuse[k];
  firmware.frequency = frequency_Hz;
  avr_load_firmware(avr_, &firmware);
  for (std::uint32_t i = 0; i < firmware.symbolcount; ++i) {
    const std::string name = firmware.symbol[i]->symbol;
    const std::uint32_t address = firmware.symbol[i]->addr & 0xffff;
    // Link-time optimisation may add a suffix.
    if (name == "time_ms" || name.starts_with("time_ms.")) time_ms_address_ = address;
    if (name == "ms_since_round" || name.starts_with("ms_since_round.")) ms_since_round_address_ = address;
    if (name == "_end") static_end_ = static_cast<int>(address);
  }
  watched_ = {{this, "millisecond", 14},
              {this, "byte received", 18},
              {this, "byte sent", 19},
              {this, "conversion done", 21}};  // data sheet, table 12-6
  if (static_end_ > ram_begin) std::memset(avr_->data + static_end_, untouched, static_cast<std::size_t>(ram_end - static_end_));
  avr_->frequency = frequency_Hz;
  avr_->vcc = avr_->avcc = avr_->aref = 5000;
  avr_->sleep = do_not_sleep;
  avr_->log = LOG_ERROR;
  connect();
  reset(Reset::power_on);
}

Board::~Board() {
  if (avr_) avr_terminate(avr_);
}

void Board::connect() {
  std::uint32_t flags = 0;
  avr_ioctl(avr_, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_uart, this);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_OUTPUT), on_spi, this);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER), on_adc, this);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('D'), 7), on_relay_pin, this);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('D'), 5), on_select<0>, this);
  avr_irq_register_notify(avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ('D'), 6), on_select<1>, this);
  avr_irq_register_notify(avr_iomem_getirq(avr_, eecr, nullptr, AVR_IOMEM_IRQ_ALL), on_eeprom_control, this);
  avr_irq_register_notify(avr_iomem_getirq(avr_, spmcsr, nullptr, AVR_IOMEM_IRQ_ALL), on_self_programming, this);
  for (Watched& one : watched_) {
    avr_irq_t* const irq = avr_get_interrupt_irq(avr_, one.vector);
    avr_irq_register_notify(irq + AVR_INT_IRQ_PENDING, on_interrupt_asked, &one);
    avr_irq_register_notify(irq + AVR_INT_IRQ_RUNNING, on_interrupt_running, &one);
  }
  for (const int address : {ddrb, portb, tccr1a, tccr1b, ocr1a, ocr1a + 1, ocr1b, ocr1b + 1})
    avr_irq_register_notify(avr_iomem_getirq(avr_, static_cast<avr_io_addr_t>(address), nullptr, AVR_IOMEM_IRQ_ALL), on_gate_register,
                            this);
}

std::int64_t Board::now_us() const { return static_cast<std::int64_t>(avr_->cycle) / cycles_per_us; }
bool Board::relay() const { return swung_cycle_ >= 0 && static_cast<std::int64_t>(avr_->cycle) < swung_cycle_ + charge_pump_cycles; }
void Board::on_relay_pin(avr_irq_t*, std::uint32_t, void* self) {
  Board& board = *static_cast<Board*>(self);
  board.swung_cycle_ = static_cast<std::int64_t>(board.avr_->cycle);
}

void Board::on_interrupt_asked(avr_irq_t*, std::uint32_t value, void* self) {
  Watched& one = *static_cast<Watched*>(self);
  // That the port can take a byte is asked for all the time, and served when there is one to send: no wait.
  constexpr std::uint8_t data_register_empty = 19;
  if (value != 0 && one.asked_cycle < 0 && one.vector != data_register_empty)
    one.asked_cycle = static_cast<std::int64_t>(one.board->avr_->cycle);
}
void Board::on_interrupt_running(avr_irq_t*, std::uint32_t value, void* self) {
  Watched& one = *static_cast<Watched*>(self);
  const auto now = static_cast<std::int64_t>(one.board->avr_->cycle);
  if (value != 0) {
    if (one.asked_cycle >= 0) one.longest_wait = std::max(one.longest_wait, now - one.asked_cycle);
    one.asked_cycle = -1;
    one.entered_cycle = now;
  } else if (one.entered_cycle >= 0) {
    one.longest = std::max(one.longest, now - one.entered_cycle + cycles_of_entry);
    one.entered_cycle = -1;
    ++one.count;
  }
}

Usage Board::usage() const {
  Usage usage{static_end_ - ram_begin, 0, ram_end - ram_begin, {}, 0};
  int deepest = static_end_;
  while (deepest < ram_end && avr_->data[deepest] == untouched) ++deepest;
  usage.stack_most_bytes = ram_end - deepest;
  constexpr auto per_us = static_cast<double>(cycles_per_us);
  for (const Watched& one : watched_)
    usage.interrupts.push_back(
        {one.name, static_cast<double>(one.longest) / per_us, static_cast<double>(one.longest_wait) / per_us, one.count});
  usage.most_ms_since_round = most_ms_since_round_;
  return usage;
}

void Board::send(const std::vector<std::uint8_t>& bytes) {
  const auto now = static_cast<std::int64_t>(avr_->cycle);
  if (arriving_.empty() && next_arrival_cycle_ < now) next_arrival_cycle_ = now;
  arriving_.insert(arriving_.end(), bytes.begin(), bytes.end());
}

void Board::run(std::int64_t until_us, bool stop_at_frame_end) {
  const std::int64_t until = until_us * cycles_per_us;
  for (;;) {
    const auto now = static_cast<std::int64_t>(avr_->cycle);
    bool frame_ended = false;
    while (!sending_.empty() && sending_.front().done_cycle <= now) {
      sent_.push_back(sending_.front().byte);
      frame_ended = frame_ended || sending_.front().byte == 0;
      sending_.pop_front();
    }
    if (now >= until || (frame_ended && stop_at_frame_end)) return;
    if (!arriving_.empty()) {
      if (next_arrival_cycle_ <= now) {
        avr_raise_irq(avr_io_getirq(avr_, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT), arriving_.front());
        arriving_.pop_front();
        next_arrival_cycle_ = std::max(next_arrival_cycle_, now - cycles_per_byte) + cycles_per_byte;
      } else {
        avr_cycle_timer_register(avr_, static_cast<avr_cycle_count_t>(next_arrival_cycle_ - now), wake, this);
      }
    }
    if (!sending_.empty() && sending_.front().done_cycle > now)
      avr_cycle_timer_register(avr_, static_cast<avr_cycle_count_t>(sending_.front().done_cycle - now), wake, &sending_);
    const int state = avr_run(avr_);
    if (state == cpu_Done || state == cpu_Crashed) throw std::runtime_error("the emulated processor stopped");
    most_ms_since_round_ = std::max(most_ms_since_round_, avr_->data[ms_since_round_address_]);
    if (gates_written_) look_at_gates();
    if (fuses_shown_cycle_ >= 0) hide_fuses();
    if (writing_ && static_cast<std::int64_t>(avr_->cycle) >= write_begun_cycle_ + cycles_per_cell) {
      writing_ = false;
      avr_->data[eecr] = static_cast<std::uint8_t>(avr_->data[eecr] & ~2);
    }
  }
}

std::vector<std::uint8_t> Board::take_sent() {
  std::vector<std::uint8_t> bytes;
  bytes.swap(sent_);
  return bytes;
}

// Averaged over the PWM's period, from the registers: a pin that the timer drives has the compare value's share, one that
// it does not drive its port bit, and one that is no output is pulled to ground.
void Board::look_at_gates() {
  gates_written_ = false;
  const std::uint8_t* const r = avr_->data;
  std::uint32_t compare;
  std::memcpy(&compare, r + ocr1a, 4);
  const std::uint64_t registers = compare | (std::uint64_t{r[tccr1a]} << 32) | (std::uint64_t{r[ddrb]} << 40) |
                                  (std::uint64_t{r[portb]} << 48) | (std::uint64_t{r[tccr1b]} << 56);
  if (registers == gate_registers_) return;
  gate_registers_ = registers;
  PerCoil<double> duty{};
  const double top = r[icr1] + 256.0 * r[icr1 + 1];
  for (std::size_t j = 0; j < board_coils; ++j) {
    const auto& [pin, mode_bit, at] = gate_pins[j];
    const int mode = (r[tccr1a] >> mode_bit) & 3;
    if (!((r[ddrb] >> pin) & 1)) continue;
    if (mode == 0)
      duty[j] = (r[portb] >> pin) & 1;
    else
      duty[j] = (r[tccr1b] & 7) == 0 ? 1.0 : std::min(1.0, (r[at] + 256.0 * r[at + 1] + 1.0) / (top + 1.0));
  }
  if (duty == gates_) return;
  gates_ = duty;
  surroundings_.gates(now_us(), duty);
}

// At this moment: the period begins with the gate on. Its phase is that of the clock, for the program never asks for it.
bool Board::pin_on(std::size_t coil) const {
  const std::uint8_t* const r = avr_->data;
  const auto& [pin, mode_bit, at] = gate_pins[coil];
  if (!((r[ddrb] >> pin) & 1)) return false;
  if (((r[tccr1a] >> mode_bit) & 3) == 0) return (r[portb] >> pin) & 1;
  constexpr std::int64_t prescaler = 8;
  const std::int64_t top = r[icr1] + 256 * r[icr1 + 1];
  return static_cast<std::int64_t>(avr_->cycle) / prescaler % (top + 1) <= r[at] + 256 * r[at + 1];
}

void Board::reset(Reset cause) {
  if (writing_ && cause != Reset::external) *cell(written_cell_) = 0xff;
  writing_ = false;
  avr_reset(avr_);
  avr_->data[mcusr] = cause == Reset::power_on ? 1 : cause == Reset::external ? 2 : 4;
  arriving_.clear();
  selected_ = 2;
  // PC3 has a pull-up, and is on ground where the dividers are fitted.
  avr_ioport_external_t strap{.name = 'C', .mask = 1 << 3, .value = dividers_ ? 0ul : 1ul << 3};
  avr_ioctl(avr_, AVR_IOCTL_IOPORT_SET_EXTERNAL('C'), &strap);
  look_at_gates();
}

// An LPM within three cycles of BLBSET and SPMEN reads fuses and not flash (data sheet, section 27.8.9). simavr does not know that: so
// they stand in flash for that long, in the order in which Z asks for them: low, lock bits, extended, high.
void Board::on_self_programming(avr_irq_t*, std::uint32_t value, void* self) {
  constexpr std::uint32_t read_fuses = 0x09;
  Board& board = *static_cast<Board*>(self);
  if ((value & 0x3f) != read_fuses) return;
  if (board.fuses_shown_cycle_ < 0) std::copy_n(board.avr_->flash, board.flash_begin_.size(), board.flash_begin_.begin());
  board.fuses_shown_cycle_ = static_cast<std::int64_t>(board.avr_->cycle);
  const std::array<std::uint8_t, 4> shown{board.fuses_[0], 0xff, board.fuses_[2], board.fuses_[1]};
  std::copy(shown.begin(), shown.end(), board.avr_->flash);
  board.avr_->run_cycle_count = 1;  // one instruction at a time from here on
}

void Board::hide_fuses() {
  if (static_cast<std::int64_t>(avr_->cycle) < fuses_shown_cycle_ + 3) return;
  std::copy(flash_begin_.begin(), flash_begin_.end(), avr_->flash);
  fuses_shown_cycle_ = -1;
}

std::uint8_t* Board::cell(int address) {
  avr_eeprom_desc_t one{.ee = nullptr, .offset = static_cast<std::uint16_t>(address), .size = 1};
  avr_ioctl(avr_, AVR_IOCTL_EEPROM_GET, &one);
  return one.ee;
}

// simavr writes a cell at once, and says so; the chip takes 3.4 ms (data sheet, table 8-2), and shows it in EEPE.
void Board::on_eeprom_control(avr_irq_t*, std::uint32_t value, void* self) {
  Board& board = *static_cast<Board*>(self);
  if ((value & 6) != 6) return;  // EEMPE, then EEPE
  board.write_begun_cycle_ = static_cast<std::int64_t>(board.avr_->cycle);
  board.written_cell_ = board.avr_->data[eearl] + 256 * (board.avr_->data[eearl + 1] & 3);
  board.writing_ = true;
  board.avr_->data[eecr] = static_cast<std::uint8_t>(board.avr_->data[eecr] | 2);
}

void Board::hang(bool interrupts_served) {
  constexpr std::uint32_t place = 0x7f00;  // of flash, which the program does not fill
  avr_->flash[place] = 0xff;               // rjmp .-2
  avr_->flash[place + 1] = 0xcf;
  avr_->pc = place;
  avr_->sreg[S_I] = interrupts_served;
  if (avr_->state == cpu_Sleeping) avr_->state = cpu_Running;
}

void Board::set_time_ms(std::uint32_t time_ms) {
  if (time_ms_address_ == 0) throw std::runtime_error("the firmware has no symbol time_ms");
  std::memcpy(avr_->data + time_ms_address_, &time_ms, 4);
}

void Board::on_gate_register(avr_irq_t*, std::uint32_t, void* self) { static_cast<Board*>(self)->gates_written_ = true; }

void Board::on_uart(avr_irq_t*, std::uint32_t value, void* self) {
  Board& board = *static_cast<Board*>(self);
  const auto now = static_cast<std::int64_t>(board.avr_->cycle);
  const std::int64_t free = board.sending_.empty() ? now : std::max(now, board.sending_.back().done_cycle);
  board.sending_.push_back({static_cast<std::uint8_t>(value), free + cycles_per_byte});
}

void Board::on_spi(avr_irq_t*, std::uint32_t, void* self) {
  Board& board = *static_cast<Board*>(self);
  const std::uint8_t byte = board.selected_ ? board.surroundings_.clock_out(*board.selected_) : 0xff;
  avr_raise_irq(avr_io_getirq(board.avr_, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_INPUT), byte);
}

// Channel 0 is the bend sensor, those above it the drains, through dividers of 22 k and 10 k.
void Board::on_adc(avr_irq_t*, std::uint32_t, void* self) {
  Board& board = *static_cast<Board*>(self);
  const std::size_t channel = board.avr_->data[admux] & 15u;
  if (channel > board_coils) return;
  const int shown_mV = channel == 0
                           ? board.surroundings_.bend_sensor_mV(board.now_us())
                           : board.surroundings_.drain_mV(board.now_us(), channel - 1, {board.pin_on(0), board.pin_on(1)}) * 10 / 32;
  avr_raise_irq(avr_io_getirq(board.avr_, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + static_cast<int>(channel)),
                static_cast<std::uint32_t>(std::min(shown_mV, 5000)));
}

// Chip selects are active low.
template <std::size_t coil>
void Board::on_select(avr_irq_t*, std::uint32_t value, void* self) {
  Board& board = *static_cast<Board*>(self);
  const bool selected = (value & 1) == 0;
  if (selected) board.selected_ = coil;
  if (!selected && board.selected_ == coil) board.selected_.reset();
  board.surroundings_.select(board.now_us(), coil, selected);
}

}  // namespace sinew::emulator
