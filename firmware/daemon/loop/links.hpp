#pragma once
// What the loop and the other threads share. Nothing of it waits for the other side.

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/daemon/loop/histogram.hpp"
#include "firmware/daemon/loop/prepared_device.hpp"
#include "firmware/daemon/loop/ring.hpp"
#include "firmware/text/cycle.hpp"

namespace smaservo::daemon {

/// What one cycle leaves to the recorder.
struct CycleRecord {
  text::Cycle cycle;
  std::uint64_t number;  ///< of the cycle; a jump: the ring was full
  std::uint32_t set;     ///< number of the parameters that came into force with it; 0: as before
};

struct LoopLinks {
  Ring<ParameterSet*> new_sets{16};      ///< to the loop
  Ring<ParameterSet*> old_sets{32};      ///< from it, to be deleted
  std::atomic<std::uint64_t> faults{0};  ///< FaultSet::bits() of what other threads have found
  std::atomic<bool> stop{false};
  std::atomic<bool> restart{false};  ///< with stop: everything anew, as after switching on
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
    std::atomic<std::int64_t> longest_ns{0};  ///< from the sample that showed it to the drive off
  };

  std::atomic<std::uint64_t> cycles{0};
  std::atomic<std::uint64_t> missed{0};       ///< cycles whose time passed, not caught up
  std::atomic<std::uint64_t> no_frame{0};     ///< cycles in which none came
  std::atomic<std::uint64_t> lost_frames{0};  ///< jumps of the sequence number
  std::atomic<std::uint64_t> setpoints{0};    ///< that a master has sent in a cyclic mode
  std::atomic<std::uint64_t> superseded{
      0};                     ///< of them, those that a newer one came before their cycle
  Histogram wake;             ///< after the cycle's time
  Histogram execution;        ///< from waking up to the end of the cycle
  Histogram sample_to_drive;  ///< from the instant of the sample to the drive being told
  std::array<Stop, fault_count> stops{};      ///< by the faults that ended a current
  std::atomic<std::uint64_t> guard_stops{0};  ///< times that the guard had to switch off
};

}  // namespace smaservo::daemon
