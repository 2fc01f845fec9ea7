#pragma once
// Every condition that a device detects, with its class. fault_rows describes each once; the
// reference page and `host-sim explain` are made from it.

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
  driver_hot,
  // the wire
  wire_open,
  wire_short,
  sense_lead_open,
  no_response,
  over_temperature,
  overheat_signature,
  heating_rate,
  load_lost,
  over_stress,
  over_strain,
  clamp_slip,
  drift,
  cycles,
  cold_resistance,
  duty,
  // the estimate
  model_divergence,
  estimate_invalid,
  following_error,
  power_balance,
  ambient_range,
  started_outside,
  // the machine
  sample_stale,
  sample_frozen,
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
  count
};
static_assert(static_cast<unsigned>(Fault::count) <= 64);

/// A set of them. An empty one is all zero.
class FaultSet {
 public:
  constexpr FaultSet() = default;
  constexpr FaultSet(Fault fault) : bits_(bit(fault)) {}  // NOLINT(google-explicit-constructor)
  static constexpr FaultSet from_bits(std::uint64_t bits) {
    FaultSet set;
    set.bits_ = bits;
    return set;
  }

  constexpr std::uint64_t bits() const { return bits_; }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr bool has(Fault fault) const { return (bits_ & bit(fault)) != 0; }
  constexpr void set(Fault fault, bool on = true) {
    bits_ = on ? bits_ | bit(fault) : bits_ & ~bit(fault);
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

}  // namespace smaservo
