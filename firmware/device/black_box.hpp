#pragma once
// What a fault leaves behind: the whole cycle in which it was found, and the seconds before it.
// Kept beside the device's state, which stays small; whoever calls Device::step() calls record()
// after it. Trivially copyable, without pointers: a board may store its bytes.

#include <array>
#include <type_traits>

#include "firmware/command.hpp"

namespace smaservo {

/// Everything that went into and came out of the cycle of the first cause.
template <class S>
struct FreezeFrame {
  bool taken;
  Inputs<S> inputs;
  Command<S> command;
  Output<S> output;
};

/// One line of the ring, in single precision.
struct BlackBoxRecord {
  float strain, wire_temperature_K, resistance_ohm, stress_Pa;
  float setpoint, drive_current_A, current_A, voltage_V;
  std::uint32_t time_ms;  ///< of the loop; starts again after 49 days
  std::uint16_t limit_reasons;
  DeviceState state;
  Mode mode;
};
static_assert(sizeof(BlackBoxRecord) == 40);

/// The last `records` lines, spread over span_s: one every span_s/records, 10 ms by default, and
/// one of the fault itself. All zero: empty.
template <class S, std::size_t records = 500>
struct BlackBox {
  static constexpr S span_s = S(5);
  static constexpr S interval_s = span_s / S(records);

  FreezeFrame<S> frame;
  std::array<BlackBoxRecord, records> ring;
  std::size_t next;   ///< where the next line goes
  std::size_t count;  ///< lines that are filled
  S since_s;          ///< time since the last line

  /// Records a cycle. After the cycle of a first cause nothing is written until all faults are
  /// cleared.
  void record(const Inputs<S>& in, const Command<S>& command, const Output<S>& out, const S& dt_s) {
    const bool fault = out.first_cause != Fault::none;
    if (frame.taken && fault) {
      return;
    }
    since_s += dt_s;
    // Within half a step: a sum of steps does not meet the interval exactly.
    if (fault || count == 0 || interval_s <= since_s + S(0.5) * dt_s) {
      since_s = S(0);
      append(line(in, out));
    }
    if (fault) {
      frame = {true, in, command, out};
    } else {
      frame.taken = false;
    }
  }

  /// The i-th of `count` lines, the oldest first.
  const BlackBoxRecord& at(std::size_t i) const {
    return ring[(next + records - count + i) % records];
  }

 private:
  void append(const BlackBoxRecord& r) {
    ring[next] = r;
    next = next + 1 == records ? 0 : next + 1;
    count = count < records ? count + 1 : count;
  }
  static BlackBoxRecord line(const Inputs<S>& in, const Output<S>& out) {
    const auto f = [](const S& x) { return static_cast<float>(x); };
    return {f(out.estimate.strain),
            f(out.estimate.temperature_K),
            f(out.measurement.resistance_ohm),
            f(out.measurement.stress_Pa),
            f(out.setpoint),
            f(out.drive_current_A),
            f(in.sample.current_A),
            f(in.sample.voltage_V),
            static_cast<std::uint32_t>(out.time_us / 1000),
            static_cast<std::uint16_t>(out.limit_reasons),
            out.state,
            out.mode};
  }
};

static_assert(std::is_trivially_copyable_v<BlackBox<float>>);
static_assert(static_cast<unsigned>(LimitReason::count) <= 16);

}  // namespace smaservo
