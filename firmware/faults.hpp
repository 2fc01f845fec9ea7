#pragma once
// Every condition that a device detects. safety/faults/table.hpp describes each once: class, times,
// texts; the reference page and `host-sim explain` are made from it. safety/monitor.hpp detects the
// conditions, safety/failsafe.hpp decides their consequences.
//
// An enumerator's value is its bit in object 2202h and is sent in its EMCY. New faults are
// therefore appended, whatever their group; none is ever inserted, moved or removed.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace smaservo {

enum class Fault : std::uint8_t {
  none,
  // the output stage
  supply_low,
  supply_high,
  over_current,
  current_saturated,
  voltage_saturated,
  current_offset,
  current_control,
  current_while_off,
  driver_fault,
  driver_warm,
  driver_hot,
  kelvin_mismatch,
  // the wire
  wire_open,
  wire_short,
  sense_lead_open,
  resistance_jump,
  no_response,
  over_temperature,
  heat_limit,
  overheat_onset,
  overheat_signature,
  heating_fast,
  heating_rate,
  load_lost,
  over_stress,
  over_strain,
  slip_seen,
  clamp_slip,
  drift,
  cycles,
  cold_resistance,
  duty,
  // the estimate
  model_divergence,
  estimate_invalid,
  estimate_unsure,
  following_error,
  power_balance,
  ambient_range,
  started_outside,
  // the machine
  sensor_invalid,
  sample_stale,
  sample_frozen,
  control_invalid,
  deadline_missed,
  command_timeout,
  emergency_stop,
  cooling_timeout,
  bus_lost,
  duplicate_node,
  unclean_boot,
  store_corrupt,
  bad_configuration,
  not_configured,
  store_outdated,
  cooling_weak,
  cooling_lost,
  loop_stalled,
  count
};
inline constexpr std::size_t fault_count = static_cast<std::size_t>(Fault::count);
static_assert(fault_count <= 64);

/// The consequence of a fault. In states without current, a present condition of any class except L
/// and W blocks arming; in these states only F0 is latched.
enum class FaultClass : std::uint8_t {
  F0,  ///< heat off at once, also by the hardware
  F1,  ///< heat off
  F2,  ///< the configured safe state: off, hold for a time, controlled release
  L,   ///< limiter: no more than limits.min_current_A while it is present
  B,   ///< blocks arming; a warning while running
  W,   ///< warning
};
inline constexpr std::size_t fault_class_count = 6;

/// A set of faults. The empty set is all zero.
class FaultSet {
 public:
  constexpr FaultSet() = default;
  /// The set of this fault alone.
  constexpr FaultSet(Fault fault) : bits_(bit(fault)) {}  // NOLINT(google-explicit-constructor)
  /// From the bits of bits().
  static constexpr FaultSet from_bits(std::uint64_t bits) {
    FaultSet set;
    set.bits_ = bits;
    return set;
  }

  /// Bit n is the fault of number n.
  constexpr std::uint64_t bits() const { return bits_; }
  /// Whether no fault is in it.
  constexpr bool empty() const { return bits_ == 0; }
  /// Whether this fault is in it.
  constexpr bool has(Fault fault) const { return (bits_ & bit(fault)) != 0; }
  /// Adds the fault, or takes it out.
  constexpr void set(Fault fault, bool on = true) {
    bits_ = on ? bits_ | bit(fault) : bits_ & ~bit(fault);
  }
  /// Adds the fault if `so`. Cost: one instruction in the usual case of false.
  constexpr void add(Fault fault, bool so) {
    if (so) [[unlikely]] {
      bits_ |= bit(fault);
    }
  }
  /// The first fault of the set in the order of Fault; Fault::none if it is empty.
  constexpr Fault first() const {
    return empty() ? Fault::none : static_cast<Fault>(std::countr_zero(bits_));
  }

  friend constexpr FaultSet operator|(FaultSet a, FaultSet b) {
    return from_bits(a.bits_ | b.bits_);
  }
  friend constexpr FaultSet operator&(FaultSet a, FaultSet b) {
    return from_bits(a.bits_ & b.bits_);
  }
  friend constexpr FaultSet operator-(FaultSet a, FaultSet b) {
    return from_bits(a.bits_ & ~b.bits_);
  }
  friend constexpr bool operator==(FaultSet, FaultSet) = default;

 private:
  static constexpr std::uint64_t bit(Fault fault) {
    return std::uint64_t{1} << static_cast<unsigned>(fault);
  }
  std::uint64_t bits_ = 0;
};

/// Calls f(Fault) for each fault of the set, in the order of Fault.
template <class F>
constexpr void for_each_fault(FaultSet set, F f) {
  for (std::uint64_t bits = set.bits(); bits != 0; bits &= bits - 1) {
    f(static_cast<Fault>(std::countr_zero(bits)));
  }
}

/// The number of faults that may be warnings; safety/standing.hpp checks it and says which.
inline constexpr std::size_t warning_count = 19;

/// How often the cause of each warning has come since the device was switched on; for the place of
/// a warning see safety/standing.hpp.
using WarningCounts = std::array<std::uint32_t, warning_count>;

/// One of them.
struct WarningCount {
  std::uint8_t place;
  std::uint32_t causes;
};

}  // namespace smaservo
