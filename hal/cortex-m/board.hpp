#pragma once
// A microcontroller's board in an emulator: SysTick gives the loop's period; pipes, opened by
// semihosting, replace converter, output stage and CAN controller. A real board has registers
// instead of the pipes; README.md says what to change.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "hal/board.hpp"
#include "hal/cortex-m/registers.hpp"
#include "hal/cortex-m/semihosting.hpp"
#include "hal/cortex-m/wire_link.hpp"

namespace smaservo::cortex_m {

/// Number of the timer's interrupts since its start.
inline volatile std::uint32_t ticks = 0;

class PipeBoard {
 public:
  /// `period_us` is the loop's period, at most 16.7 million clocks.
  explicit PipeBoard(std::uint32_t period_us)
      : period_us_(period_us), clocks_(period_us * 1000 / clock_ns) {}

  bool is_open() const { return to_.is_open() && from_.is_open(); }

  /// Begins the first period.
  void start() const {
    sys_tick().reload = clocks_ - 1;
    sys_tick().value = 0;
    sys_tick().control = SysTick::enable | SysTick::interrupt | SysTick::processor_clock;
  }

  /// Sleeps until the timer's next tick, then reads from the pipe without waiting. On a real board
  /// the tick would start the converter, and the converter's interrupt would end the sleep.
  hal::ReadStatus read(hal::FrameOf<float>& frame) {
    while (ticks == served_) {
      wait_for_interrupt();
    }
    missed_ = ticks - served_ - 1;
    served_ = ticks;
    send();
    link::Readings now{};
    if (from_.read(std::as_writable_bytes(std::span(&now, 1))) != sizeof now) {
      return hal::ReadStatus::end;
    }
    frame = {.time_ns = std::int64_t{served_} * period_us_ * 1000,
             .sequence = now.sequence,
             .current_A = now.current_A,
             .voltage_V = now.voltage_V,
             .load_N = now.load_N,
             .supply_V = now.supply_V,
             .ambient_K = now.ambient_K,
             .driver_K = now.driver_K,
             .emergency_stop = (now.flags & link::emergency_stop) != 0,
             .driver_fault = (now.flags & link::driver_fault) != 0};
    return (now.flags & link::fresh) != 0 ? hal::ReadStatus::frame : hal::ReadStatus::nothing;
  }
  /// Number of periods that were missed before the last frame.
  std::uint32_t missed() const { return missed_; }

  /// The command's lease must not exceed one second.
  void drive(const hal::DriveCommandOf<float>& command) {
    next_.current_A = command.current_A;
    next_.voltage_V = command.voltage_V;
    next_.lease_us = static_cast<std::int32_t>(command.valid_until_ns - now_ns()) / 1000;
  }
  void kick() { next_.kicked = 1; }
  void safe_off() {
    next_ = {};
    send();
  }
  std::int64_t now_ns() const { return std::int64_t{ticks} * period_us_ * 1000 + gone_ns(); }
  std::uint64_t now_us() const { return std::uint64_t{ticks} * period_us_ + gone_ns() / 1000; }

 private:
  void send() {
    to_.write(std::as_bytes(std::span(&next_, 1)));
    next_ = {};
  }

  /// Time since the last tick.
  std::uint32_t gone_ns() const { return (clocks_ - 1 - sys_tick().value) * clock_ns; }

  std::uint32_t period_us_, clocks_;
  std::uint32_t served_ = 0, missed_ = 0;
  link::Drive next_{};
  semihosting::File to_{"drive", semihosting::Open::write};
  semihosting::File from_{"readings", semihosting::Open::read};
};
static_assert(hal::Board<PipeBoard, float>);

/// A CanPort made of two pipes; receive() asks the other end for a frame.
class PipeCan {
 public:
  bool is_open() const { return to_.is_open() && from_.is_open(); }

  bool receive(hal::CanFrame& in) {
    link::Can ask{};
    to_.write(std::as_bytes(std::span(&ask, 1)));
    link::Can answer{};
    if (from_.read(std::as_writable_bytes(std::span(&answer, 1))) != sizeof answer ||
        answer.frames == 0) {
      return false;
    }
    in = {.id = answer.id, .length = answer.length, .data = answer.data};
    return true;
  }
  bool send(const hal::CanFrame& out) {
    const link::Can frame{1, out.id, out.length, {}, out.data};
    return to_.write(std::as_bytes(std::span(&frame, 1)));
  }

 private:
  semihosting::File to_{"can-out", semihosting::Open::write};
  semihosting::File from_{"can-in", semihosting::Open::read};
};
static_assert(hal::CanPort<PipeCan>);

/// The store's two slots as files.
class SlotFiles {
 public:
  bool read(unsigned slot, std::size_t offset, std::span<std::byte> to) {
    semihosting::File file(names.at(slot), semihosting::Open::read);
    if (!file.is_open()) {
      // A slot without a file counts as erased.
      std::ranges::fill(to, std::byte{0xFF});
      return true;
    }
    const bool all = file.seek(offset) && file.read(to) == to.size();
    file.close();
    return all;
  }
  bool erase(unsigned slot) {
    semihosting::File file(names.at(slot), semihosting::Open::write);
    file.close();
    at_ = 0;
    return true;
  }
  /// The pieces of a slot must be written in order, from its beginning.
  bool write(unsigned slot, std::size_t offset, std::span<const std::byte> from) {
    if (offset != at_) {
      return false;
    }
    semihosting::File file(names.at(slot), semihosting::Open::append);
    const bool all = file.is_open() && file.write(from);
    file.close();
    at_ += from.size();
    return all;
  }
  static bool sync() { return true; }

 private:
  static constexpr std::array<std::string_view, 2> names{"slot-0", "slot-1"};
  std::size_t at_ = 0;
};

}  // namespace smaservo::cortex_m
