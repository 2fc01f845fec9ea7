#pragma once
// Turns intermittent conditions into faults: each has to last for its deglitch time.

#include <array>

#include "firmware/safety/faults/table.hpp"
#include "firmware/settings.hpp"

namespace smaservo {

inline constexpr auto fault_deglitch_s = [] {
  std::array<float, fault_count> times{};
  for (const FaultRow& row : fault_rows) {
    times[static_cast<std::size_t>(row.fault)] = static_cast<float>(row.deglitch_s);
  }
  return times;
}();

/// The time that a condition has to last to be a fault, with these settings.
template <class S>
constexpr S deglitch_s(Fault fault, const Settings<S>& settings) {
  switch (fault) {
    case Fault::following_error:
      return settings.trips.following_s;
    case Fault::sample_stale:
      return settings.timing.sample_timeout_s;
    case Fault::command_timeout:
      return settings.timing.command_timeout_s;
    default:
      return S(fault_deglitch_s[static_cast<std::size_t>(fault)]);
  }
}

/// A timer for each condition. It counts up while the condition is present and down while it is
/// not: so a loose contact that is open most of the time trips as well. All zero: no condition has
/// been seen.
template <class S>
struct Deglitch {
  std::array<S, fault_count> held_s;  ///< timers of pending conditions
  FaultSet pending;  ///< conditions that were seen and whose timers have not run down
  FaultSet active;

  /// Cost: some operations for each condition that is present or pending; otherwise next to
  /// nothing.
  FaultSet step(FaultSet now, const S& dt_s) {
    for_each_fault(now | pending, [&](Fault fault) {
      const auto i = static_cast<std::size_t>(fault);
      const S limit_s = S(fault_deglitch_s[i]);
      S& held = held_s[i];
      if (!now.has(fault)) {
        held -= dt_s;
        if (!(S(0) < held)) {
          pending.set(fault, false);
          active.set(fault, false);
        }
        return;
      }
      held = pending.has(fault) ? held + dt_s : S(0);
      held = held < limit_s ? held : limit_s;
      pending.set(fault);
      // The rounding of a sum of many steps may keep it just below the limit.
      if (limit_s <= held + S(0.25) * dt_s) {
        active.set(fault);
      }
    });
    return active;
  }
};

}  // namespace smaservo
