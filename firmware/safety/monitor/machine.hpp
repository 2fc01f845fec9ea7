#pragma once
// Detects faults of the machine: readings, timing, commands, and what the caller reports.

#include "firmware/safety/monitor/inputs.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

template <class S>
struct MachineMonitor {
  /// All zero: nothing has been seen.
  struct State {
    S misses;  ///< number of missed deadlines; decays within a second
    bool sampled;
    std::uint32_t sequence;  ///< sequence number of the last fresh sample
    Sample<S> sample;
    S frozen_at_A;         ///< current that was given when the readings last changed
    bool control_invalid;  ///< the controller gave no usable current in the last step
  };

  /// Cost: about 40 operations, no division.
  static FaultSet detect(const MonitorInputs<S>& seen, State& s);

 private:
  static constexpr S max_misses = S(10);

  static bool frozen(const MonitorInputs<S>& seen, State& s);
};

template <class S>
FaultSet MachineMonitor<S>::detect(const MonitorInputs<S>& seen, State& s) {
  const Settings<S>& q = seen.prepared.settings;
  const Inputs<S>& in = seen.in;
  FaultSet now = in.external;
  const bool load = !q.measurement.has_load_cell || isfinite(in.sample.load_N);
  now.add(Fault::sensor_invalid,
          in.fresh && !(isfinite(in.sample.current_A + in.sample.voltage_V) && load));
  now.add(Fault::sample_stale, q.timing.sample_timeout_s <= seen.since_sample_s);
  now.add(Fault::sample_frozen, in.fresh && frozen(seen, s));
  now.add(Fault::control_invalid, s.control_invalid);
  s.control_invalid = false;
  if (in.deadline_missed || S(0) < s.misses) {
    s.misses = s.misses - s.misses * seen.dt_s + (in.deadline_missed ? S(1) : S(0));
    // The margin of 0.5 covers the decay of misses that follow each other closely.
    now.add(Fault::deadline_missed, max_misses - S(0.5) < s.misses);
  }
  now.add(Fault::command_timeout,
          seen.command.arm && q.timing.command_timeout_s <= seen.since_command_s);
  now.add(Fault::emergency_stop, in.emergency_stop);
  if (seen.observing && seen.off()) {
    const bool warm = seen.filter.ambient_K + S(15) < seen.estimate.temperature_K;
    now.add(Fault::cooling_timeout, warm && seen.cold());
  }
  return now;
}

/// Whether the readings are frozen. Equal readings alone are no fault, because a quiet front end
/// repeats them. They must change when the current does.
template <class S>
bool MachineMonitor<S>::frozen(const MonitorInputs<S>& seen, State& s) {
  const Inputs<S>& in = seen.in;
  const bool same_sequence = s.sampled && in.sequence == s.sequence;
  const bool same_readings = s.sampled && in.sample.current_A == s.sample.current_A &&
                             in.sample.voltage_V == s.sample.voltage_V &&
                             in.sample.load_N == s.sample.load_N;
  s.sampled = true;
  s.sequence = in.sequence;
  if (!same_readings) {
    s.sample = in.sample;
    s.frozen_at_A = seen.last.drive_current_A;
    return same_sequence;
  }
  const S changed_A = magnitude(seen.last.drive_current_A - s.frozen_at_A);
  const Settings<S>& q = seen.prepared.settings;
  const bool ignored = S(0.05) * seen.last.drive_current_A + S(10) * q.measurement.current_noise_A +
                           q.trips.current_offset_A <
                       changed_A;
  return same_sequence || ignored;
}

}  // namespace smaservo
