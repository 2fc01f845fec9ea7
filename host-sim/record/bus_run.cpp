#include "host-sim/record/bus_run.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "model/files/error.hpp"

namespace smaservo::record {
namespace {

std::string header_of(const std::vector<std::string>& signals) {
  std::string header = "time_s";
  for (const std::string& name : signals) {
    const bool is_reading = std::ranges::find(needed_signals, name) != std::end(needed_signals);
    header += (is_reading ? "," : "," + std::string(servo_prefix)) + name;
  }
  return header + '\n';
}

/// CSV whose times are those of the recorder: rows that are left out leave a gap.
void write_rows(const can::Recording& whole, BusRun& run) {
  const std::string all = can::to_csv(whole);
  std::size_t at = all.find('\n') + 1;
  std::size_t in_a_row = 0;
  run.csv = header_of(whole.signals);
  for (const std::vector<double>& row : whole.rows) {
    const std::size_t end = all.find('\n', at) + 1;
    const auto needed = static_cast<std::ptrdiff_t>(std::size(needed_signals));
    // The needed signals are the first ones.
    if (std::all_of(row.begin(), row.begin() + needed, [](double x) { return std::isfinite(x); })) {
      run.csv.append(all, at, end - at);
      run.recording.rows.push_back(row);
      in_a_row = 0;
    } else {
      ++run.left_out;
      ++in_a_row;
    }
    run.longest_gap_s = std::max(run.longest_gap_s, static_cast<double>(in_a_row) * whole.period_s);
    at = end;
  }
}

/// Another client that talks to the node ends the transfer of a recording. The device keeps the
/// recording, so it is read again after a pause.
can::Recording read_undisturbed(can::Remote& remote, const can::RecordingPlan& plan) {
  constexpr int most = 5;
  constexpr std::int64_t pause_us = 300'000;
  for (int tries = 1;; ++tries) {
    try {
      return can::read_recording(remote, plan);
    } catch (const can::SdoError&) {
      if (tries == most) {
        throw;
      }
    }
    const std::int64_t until_us = remote.bus().now_us() + pause_us;
    hal::CanFrame passing;
    while (remote.bus().receive(passing, until_us)) {
    }
  }
}

}  // namespace

std::vector<std::string> signals_with(const std::vector<std::string>& others) {
  std::vector<std::string> all(std::begin(needed_signals), std::end(needed_signals));
  for (const std::string& name : others) {
    const std::string plain = name.starts_with("live.") ? name.substr(5) : name;
    if (std::ranges::find(all, plain) == all.end()) {
      all.push_back(plain);
    }
  }
  return all;
}

BusRun record_from_bus(can::Remote& remote, const can::RecordingPlan& plan, double patience_s,
                       const std::function<void()>& waits) {
  can::arm_recorder(remote, plan);
  can::wait_for_recorder(remote, plan, patience_s, waits);
  return read_run(remote, plan);
}

BusRun read_run(can::Remote& remote, const can::RecordingPlan& plan) {
  const can::Recording whole = read_undisturbed(remote, plan);
  BusRun run{{whole.signals, whole.period_s, {}, {}}, "", 0, 0};
  write_rows(whole, run);
  if (run.recording.rows.empty()) {
    throw files::UserError(fmt::format(
        "node {}: none of {} rows has current, voltage and stress; is the servo measuring? "
        "`host-sim can --node {} faults` says what blocks it",
        remote.node(), whole.rows.size(), remote.node()));
  }
  return run;
}

}  // namespace smaservo::record
