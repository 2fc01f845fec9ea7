#pragma once
// The device's states: the latched faults, the conditions that block, and the end of each state. It
// prepares the inputs of failsafe(), which makes the decisions.
//
//   starting -> ready -> arming -> running -> stopping -> fault -> ready
//
// starting, at least 0.1 s without current: reads the sensors' offsets, starts the observer.
// arming, 0.05 to 0.1 s: checks the wire (arming.hpp). stopping: the safe state (SafeSettings).
// In any state a falling edge of arm ends the current.

#include "firmware/safety/arming.hpp"
#include "firmware/safety/failsafe.hpp"
#include "firmware/safety/monitor.hpp"
#include "firmware/safety/standing.hpp"

namespace smaservo {

template <class S>
struct Supervisor {
  /// All zero: the device has just been switched on.
  struct State {
    DeviceState state;
    S in_state_s;
    bool armed, cleared;  ///< the flags of the last command
    bool arm_edge;        ///< arm has risen and this edge has not been used yet
    FaultSet latched;
    FaultSet acknowledged;
    FaultSet lasting;   ///< faults that stay active until a restart
    FaultSet findings;  ///< faults found by the check of the last arming
    StandingWarnings<S> warnings;
    Fault first_cause;
    std::uint64_t first_cause_us;
    ArmingCheck<S> check;
    S safe_strain;  ///< strain set-point of the safe state
  };

  struct Verdict {
    DeviceState state;
    Heat heat;
    bool limited;  ///< a fault of class L limits the current
    S strain;      ///< strain to hold, or the release's set-point
    FaultSet active, latched, warnings, blocks;
  };

  /// `active` comes from Monitor; `time_us` is the time of this step.
  static Verdict step(const MonitorInputs<S>& seen, State& s, FaultSet active,
                      std::uint64_t time_us);

 private:
  static constexpr S starting_s = S(0.1);
  static constexpr S longest_release_s = S(60);

  static FaultSet remember(State& s, FaultSet active, bool clear);
  static void latch_faults(State& s, FaultSet active, bool clear, std::uint64_t time_us);
  static bool safe_over(const MonitorInputs<S>& seen, const State& s);
  static bool trusted(const MonitorInputs<S>& seen, FaultSet faults);
  static void enter(const MonitorInputs<S>& seen, State& s, DeviceState next);
};

template <class S>
auto Supervisor<S>::step(const MonitorInputs<S>& seen, State& s, FaultSet active_now,
                         std::uint64_t time_us) -> Verdict {
  const Command<S>& c = seen.command;
  const Settings<S>& q = seen.prepared.settings;
  const bool clear = c.clear_faults && !s.cleared;
  s.arm_edge = c.arm && (s.arm_edge || !s.armed);
  s.armed = c.arm;
  s.cleared = c.clear_faults;
  const FaultSet active = remember(s, active_now, clear);
  latch_faults(s, active, clear, time_us);

  FailsafeInput in{};
  in.state = s.state;
  in.active = active;
  in.latched = s.latched;
  in.arm = c.arm;
  in.arm_edge = s.arm_edge;
  in.started = seen.zeroed && seen.observing &&
               (s.state != DeviceState::starting || !(s.in_state_s < starting_s));
  in.blocked = !(active & blocking_faults).empty();
  in.safe = q.safe.state;
  if (s.state == DeviceState::arming) {
    s.check.take(seen, s.in_state_s);
    if (!(s.in_state_s < ArmingCheck<S>::min_s)) {
      const FaultSet found = s.check.findings(seen);
      in.passed = found.empty();
      in.checked = in.passed || !(s.in_state_s < ArmingCheck<S>::max_s);
      s.findings = in.checked ? found : s.findings;
    }
  }
  if (s.state == DeviceState::running) {
    s.safe_strain = seen.estimate.strain;
  }
  const FaultSet all = active | s.latched;
  if (is_heated(s.state) && !(all & tripping_faults).empty()) {
    in.may_hold = trusted(seen, all);
    in.safe_over = safe_over(seen, s);
  }
  const FailsafeOutput next = failsafe(in);
  // An edge of arm is used up by one attempt, even a refused one; only in the state starting it is
  // kept.
  s.arm_edge = s.arm_edge && s.state == DeviceState::starting;
  s.in_state_s += seen.dt_s;
  if (next.state != s.state) {
    enter(seen, s, next.state);
  }
  if (next.heat == Heat::release) {
    s.safe_strain += q.safe.release_1_s * seen.dt_s;
  }

  const bool heated = is_heated(s.state);
  const FaultSet harmless = faults_of(FaultClass::W) | limiting_faults;
  const FaultSet warned = active & (heated ? warning_faults : harmless);
  return {s.state,
          next.heat,
          !(active & limiting_faults).empty(),
          s.safe_strain,
          active,
          s.latched,
          s.warnings.step(warned, clear, seen.dt_s),
          heated ? FaultSet{} : (active & blocking_faults) | s.latched | s.findings};
}

/// The active faults without acknowledged ones that are still present, and with those that only a
/// restart clears.
template <class S>
FaultSet Supervisor<S>::remember(State& s, FaultSet active, bool clear) {
  s.acknowledged = s.acknowledged & active;
  if (clear) {
    s.acknowledged = s.acknowledged | (active & acknowledged_faults);
  }
  s.lasting = s.lasting | (active & lasting_faults);
  return (active - s.acknowledged) | s.lasting;
}

template <class S>
void Supervisor<S>::latch_faults(State& s, FaultSet active, bool clear, std::uint64_t time_us) {
  const FaultSet before = s.latched;
  s.latched = latch(before, active, s.state, clear);
  if (s.latched.empty()) {
    s.first_cause = Fault::none;
    s.first_cause_us = 0;
  } else if (before.empty()) {
    // If several faults were latched at once, the first cause is the gravest.
    const FaultSet at_once = s.latched & faults_of(FaultClass::F0);
    const FaultSet off = s.latched & heat_off_faults;
    s.first_cause = (!at_once.empty() ? at_once : !off.empty() ? off : s.latched).first();
    s.first_cause_us = time_us;
  }
}

template <class S>
bool Supervisor<S>::trusted(const MonitorInputs<S>& seen, FaultSet faults) {
  return seen.sure() && !faults.has(Fault::estimate_invalid) &&
         !faults.has(Fault::estimate_unsure) && !faults.has(Fault::model_divergence);
}

template <class S>
bool Supervisor<S>::safe_over(const MonitorInputs<S>& seen, const State& s) {
  const SafeSettings<S>& q = seen.prepared.settings.safe;
  const S since_s = s.state == DeviceState::stopping ? s.in_state_s + seen.dt_s : S(0);
  if (q.state == SafeState::hold) {
    return !(since_s < q.hold_s);
  }
  const bool cold = seen.estimate.temperature_K < seen.filter.ambient_K + S(5);
  const bool longest = !(s.safe_strain < seen.prepared.settings.limits.max_strain);
  return cold || longest || !(S(0) < q.release_1_s) || !(since_s < longest_release_s);
}

template <class S>
void Supervisor<S>::enter(const MonitorInputs<S>& seen, State& s, DeviceState next) {
  s.state = next;
  s.in_state_s = S(0);
  if (next == DeviceState::arming) {
    s.check = ArmingCheck<S>::begin(seen);
    s.findings = {};
  }
}

}  // namespace smaservo
