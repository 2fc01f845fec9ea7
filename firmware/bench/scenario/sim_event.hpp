#pragma once
// What happens to a simulated wire and its board at a given time, as [[event]] tables say.

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "hal/sim/board.hpp"

namespace smaservo::files {
class TomlTable;
}  // namespace smaservo::files

namespace smaservo::bench {

/// An event lasts from at_s on for the time for_s and changes only what is set.
struct SimEvent {
  double at_s, for_s;
  std::optional<double> ambient_K, draught, supply_V, added_stress_Pa, slip, driver_above_K,
      stop_strain;
  std::optional<hal::Circuit> circuit;
  double bridged_share = 0;
  std::optional<std::pair<hal::Reading, hal::SpoiltSensor>> sensor;
  double lost_share = 0;
  bool emergency_stop = false;
  bool driver_fault = false;
  bool late = false;     ///< the loop misses its deadline
  bool reboots = false;  ///< the device has no power; it starts anew at the event's end

  /// Whether it lasts at this time; times within a nanosecond are the same.
  bool holds(double time_s) const;
};

/// Throws UserError.
std::vector<SimEvent> read_events(std::vector<files::TomlTable> tables);

/// Puts a board into the state that the events make of it. Events may overlap; where several set
/// the same value, the last one in the file counts. Stresses and slips add up.
class SimEvents {
 public:
  SimEvents(std::vector<SimEvent> events, const hal::SimSurroundings& without);

  /// `time_s` must not be before that of the last call. Costs little while nothing changes.
  void apply(double time_s, hal::SimBoard& board) {
    if (time_s >= next_s_) {
      change(time_s, board);
    }
  }
  bool late() const { return late_; }
  bool reboots() const { return reboots_; }

 private:
  void change(double time_s, hal::SimBoard& board);

  std::vector<SimEvent> events_;
  hal::SimSurroundings without_;
  double next_s_;
  bool late_ = false;
  bool reboots_ = false;
};

}  // namespace smaservo::bench
