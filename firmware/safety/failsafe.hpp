#pragma once
// The consequences of faults: two pure functions of a few flags, small enough to be tested over
// every combination (tests/firmware/safety/failsafe_test.cpp).

#include "firmware/command.hpp"
#include "firmware/safety/faults/table.hpp"
#include "firmware/settings.hpp"

namespace smaservo {

/// The kind of current that the device gives.
enum class Heat : std::uint8_t {
  none,     ///< exactly zero
  sense,    ///< the minimum current, to measure the resistance
  run,      ///< current as commanded
  hold,     ///< safe state: holds the strain that the wire had at the fault
  release,  ///< safe state: cools at a set rate
};

struct FailsafeInput {
  DeviceState state;
  FaultSet active, latched;  ///< sets after latch()
  // The command.
  bool arm;
  bool arm_edge;  ///< arm has risen and this edge has not been used yet
  // Conditions of the present state.
  bool started;  ///< the offsets are known and the observer runs: starting may end
  bool blocked;  ///< an active condition blocks arming
  bool checked;  ///< the checks of arming are complete
  bool passed;   ///< the checks of arming have passed
  // Conditions of the safe state.
  SafeState safe;
  bool may_hold;   ///< the estimate is good enough to hold or release the wire
  bool safe_over;  ///< the time of the safe state is over, or the wire is cold
};

struct FailsafeOutput {
  DeviceState state;
  Heat heat;
  friend constexpr bool operator==(const FailsafeOutput&, const FailsafeOutput&) = default;
};

inline constexpr FaultSet heat_off_faults = faults_of(FaultClass::F0) | faults_of(FaultClass::F1);
inline constexpr FaultSet tripping_faults = heat_off_faults | faults_of(FaultClass::F2);
inline constexpr FaultSet blocking_faults = tripping_faults | faults_of(FaultClass::B);
inline constexpr FaultSet limiting_faults = faults_of(FaultClass::L);
inline constexpr FaultSet acknowledged_faults =
    faults_where([](const FaultRow& row) { return row.clears == Clears::acknowledge; });
inline constexpr FaultSet lasting_faults =
    faults_where([](const FaultRow& row) { return row.clears == Clears::reset; });

/// The latched faults after this step. While the wire is heated, all faults of the classes F0, F1
/// and F2 are latched; otherwise only F0, so that a supply that is not yet switched on needs no
/// clearing. `clear` removes faults that are no longer active, and works only in a state without
/// heat.
constexpr FaultSet latch(FaultSet latched, FaultSet active, DeviceState state, bool clear) {
  const FaultSet kept = clear && !is_heated(state) ? latched & active : latched;
  return kept | (active & (is_heated(state) ? tripping_faults : faults_of(FaultClass::F0)));
}

/// The output for a fault of the classes F0 to F2 in running or stopping.
constexpr FailsafeOutput safe_state(const FailsafeInput& in) {
  const bool must_be_off = !((in.active | in.latched) & heat_off_faults).empty();
  const bool possible = in.arm && in.may_hold && !in.safe_over && in.safe != SafeState::off;
  if (must_be_off || !possible) {
    return {DeviceState::fault, Heat::none};
  }
  return {DeviceState::stopping, in.safe == SafeState::hold ? Heat::hold : Heat::release};
}

/// The output in arming without a fault of the classes F0 to F2.
constexpr FailsafeOutput look_at_wire(const FailsafeInput& in) {
  if (!in.arm || in.blocked || (in.checked && !in.passed)) {
    return {DeviceState::ready, Heat::none};
  }
  return in.checked ? FailsafeOutput{DeviceState::running, Heat::run}
                    : FailsafeOutput{DeviceState::arming, Heat::sense};
}

/// The next state of the device and its kind of current from this step on. There is no heat with a
/// fault of class F0 or F1. After a fault the wire is heated again only from ready, with nothing
/// latched, and after a new rising edge of `arm`.
constexpr FailsafeOutput failsafe(const FailsafeInput& in) {
  using enum DeviceState;
  const bool tripped = !((in.active | in.latched) & tripping_faults).empty();
  if (!is_heated(in.state) && !in.latched.empty()) {
    return {fault, Heat::none};
  }
  switch (in.state) {
    case starting:
    case fault:
      return {in.started ? ready : starting, Heat::none};
    case ready: {
      const bool may = in.arm && in.arm_edge && !in.blocked && !tripped;
      return may ? FailsafeOutput{arming, Heat::sense} : FailsafeOutput{ready, Heat::none};
    }
    case arming:
      return tripped ? FailsafeOutput{fault, Heat::none} : look_at_wire(in);
    case running:
      if (tripped) {
        return safe_state(in);
      }
      return in.arm ? FailsafeOutput{running, Heat::run} : FailsafeOutput{ready, Heat::none};
    case stopping:
      return safe_state(in);
  }
  return {fault, Heat::none};
}

}  // namespace smaservo
