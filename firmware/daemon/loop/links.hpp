#pragma once
// Data shared by the loop and the other threads. No side ever waits for the other one.

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/cycle.hpp"
#include "firmware/daemon/loop/histogram.hpp"
#include "firmware/daemon/loop/prepared_device.hpp"
#include "firmware/daemon/loop/ring.hpp"

namespace smaservo::daemon {

/// The record of one cycle, for the recorder.
struct CycleRecord {
  Cycle cycle;
  std::uint64_t number;  ///< counts cycles; a gap: the ring was full
  /// Number of the parameters that came into force with this cycle; 0: none did.
  std::uint32_t set;
};

struct LoopLinks {
  Ring<ParameterSet*> new_sets{16};      ///< parameters for the loop
  Ring<ParameterSet*> old_sets{32};      ///< replaced or refused parameters, which the desk deletes
  std::atomic<std::uint64_t> faults{0};  ///< faults of other threads, as FaultSet::bits()
  std::atomic<bool> stop{false};
  std::atomic<bool> restart{false};  ///< set with `stop`: start anew, as after switching on
  Latest<Output<double>> output;
  Ring<CycleRecord>* record = nullptr;       ///< null: nothing is recorded
  std::atomic<std::uint64_t> unrecorded{0};  ///< cycles for which the ring had no room
  /// Heat ends at this instant of CLOCK_MONOTONIC unless the loop renews it; 0: no heat.
  std::atomic<std::int64_t> lease_ends_ns{0};
  std::atomic<bool> heated{false};
};

/// Written by the loop and its guard, read by any thread.
struct LoopFigures {
  struct Stop {
    std::atomic<std::uint32_t> count{0};
    std::atomic<std::int64_t> longest_ns{0};  ///< from the fault's sample to the drive off
  };

  std::atomic<std::uint64_t> cycles{0};
  std::atomic<std::uint64_t> missed{0};       ///< cycles left out because their time had passed
  std::atomic<std::uint64_t> no_frame{0};     ///< cycles without a frame
  std::atomic<std::uint64_t> lost_frames{0};  ///< counted by gaps in the sequence number
  std::atomic<std::uint64_t> setpoints{0};    ///< set-points from a master, in cyclic modes
  /// Set-points that a newer one replaced before a cycle took them.
  std::atomic<std::uint64_t> superseded{0};
  Histogram wake;             ///< delay of a cycle's wake-up
  Histogram execution;        ///< from waking up to the end of the cycle
  Histogram sample_to_drive;  ///< from the instant of the sample to the command of the drive
  std::array<Stop, fault_count> stops{};  ///< by the fault that ended a current
  /// As WarningCounts.
  std::array<std::atomic<std::uint32_t>, warning_count> warning_causes{};
  std::atomic<std::uint64_t> guard_stops{0};  ///< times that the guard had to switch off
};

}  // namespace smaservo::daemon
