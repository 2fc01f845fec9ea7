#pragma once
// A run that a servo records itself and gives over the bus.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/can/bus/recorder.hpp"

namespace smaservo::record {

/// What a replay needs; a run has them in any case. No servo has a sensor of the strain.
inline constexpr const char* needed_signals[] = {"current_A", "voltage_V", "stress_Pa"};

/// Begins the columns of all other signals: what a servo estimates or wants must not be taken for
/// a measurement, as `wire_temperature_K` would be.
inline constexpr std::string_view servo_prefix = "servo_";

/// The needed signals, then the others.
std::vector<std::string> signals_with(const std::vector<std::string>& others);

struct BusRun {
  can::Recording recording;  ///< rows without a needed reading are left out
  std::string csv;
  std::size_t left_out = 0;
  double longest_gap_s = 0;  ///< longest time without a row
};

/// Records by the device's recorder, as `can record` does. Throws UserError where the node does not
/// answer, the trigger does not come, or no row has current, voltage and stress.
BusRun record_from_bus(
    can::Remote& remote, const can::RecordingPlan& plan, double patience_s,
    const std::function<void()>& waits = [] {});

/// Stops a recorder that was armed with this plan, and reads its run; the plan's time may have been
/// shortened meanwhile. Throws UserError as record_from_bus().
BusRun read_run(can::Remote& remote, const can::RecordingPlan& plan);

}  // namespace smaservo::record
