#pragma once
// What follows from faults: two pure functions of a few flags, small enough to be tested over every
// combination (tests/firmware/failsafe_test.cpp).

#include "firmware/command.hpp"
#include "firmware/faults/table.hpp"
#include "firmware/settings.hpp"

namespace smaservo {

/// What the device does with its current.
enum class Heat : std::uint8_t {
  none,     ///< exactly zero
  sense,    ///< the least current: the resistance is looked at
  run,      ///< as commanded
  hold,     ///< safe state: the strain at the fault
  release,  ///< safe state: cools at a known rate
};

struct FailsafeInput {
  DeviceState state;
  FaultSet active, latched;  ///< after latch()
  // The command.
  bool arm;
  bool arm_edge;  ///< arm has come since it was last used or away
  // Of the state.
  bool started;  ///< starting has found out what it must
  bool blocked;  ///< something active blocks arming
  bool checked;  ///< the checks of arming are done
  bool passed;   ///< with success
  // Of the safe state.
  SafeState safe;
  bool may_hold;   ///< there is an estimate to hold or to release by
  bool safe_over;  ///< its time is over, or the wire is cold
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

/// The latched faults after this step. While the wire is heated everything that trips is latched;
/// otherwise only F0: a supply that is not yet switched on needs no clearing. `clear` forgets what
/// is not active any more, and only in a state without heat.
constexpr FaultSet latch(FaultSet latched, FaultSet active, DeviceState state, bool clear) {
  const FaultSet kept = clear && !is_heated(state) ? latched & active : latched;
  return kept | (active & (is_heated(state) ? tripping_faults : faults_of(FaultClass::F0)));
}

/// Where the device goes and what it may do there, from this step on. There is no heat with an F0
/// or F1; from a fault the way leads through ready, without anything latched, and a new edge of
/// `arm`.
constexpr FailsafeOutput failsafe(const FailsafeInput& in) {
  using enum DeviceState;
  const FailsafeOutput off{fault, Heat::none};
  const FaultSet all = in.active | in.latched;
  const bool must_be_off = !(all & heat_off_faults).empty();
  const bool tripped = !(all & tripping_faults).empty();
  const auto safe_state = [&]() -> FailsafeOutput {
    const bool possible = in.arm && in.may_hold && in.safe != SafeState::off && !in.safe_over;
    return possible && !must_be_off
               ? FailsafeOutput{stopping, in.safe == SafeState::hold ? Heat::hold : Heat::release}
               : off;
  };
  if (!is_heated(in.state) && !in.latched.empty()) {
    return off;
  }
  switch (in.state) {
    case starting:
      return {in.started ? ready : starting, Heat::none};
    case ready:
      return in.arm && in.arm_edge && !in.blocked && !tripped ? FailsafeOutput{arming, Heat::sense}
                                                              : FailsafeOutput{ready, Heat::none};
    case arming:
      if (tripped) {
        return off;
      }
      if (!in.arm || in.blocked || (in.checked && !in.passed)) {
        return {ready, Heat::none};
      }
      return in.checked ? FailsafeOutput{running, Heat::run} : FailsafeOutput{arming, Heat::sense};
    case running:
      if (tripped) {
        return safe_state();
      }
      return in.arm ? FailsafeOutput{running, Heat::run} : FailsafeOutput{ready, Heat::none};
    case stopping:
      return safe_state();
    case fault:
      return {in.started ? ready : starting, Heat::none};
  }
  return off;
}

}  // namespace smaservo
