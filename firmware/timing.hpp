#pragma once
// The time that a step of a device may take, and the time after which a loop counts as stalled.

#include <cstdint>

namespace smaservo {

/// Bounds of the time that one step covers while the loop runs.
inline constexpr std::int64_t shortest_step_ns = 100'000;
inline constexpr std::int64_t longest_step_ns = 20'000'000;

/// The longest time that a step after a stall covers. The rest of a longer stall is ignored,
/// because by then every timeout has passed and every wire has the steady temperature of its power.
inline constexpr int longest_stall_s = 1000;
inline constexpr std::int64_t longest_stall_ns = longest_stall_s * std::int64_t{1'000'000'000};

/// Heat is a lease of this many periods: it ends when the loop stops, but not when one cycle is
/// lost.
inline constexpr std::int64_t leased_periods = 3;

/// Whether the loop stood still for longer than the lease. `dt` is the time since the last step, in
/// the unit of the period. The margin of a thousandth allows for rounding of a dt that was computed
/// from steps.
template <class T>
constexpr bool is_stall(const T& dt, const T& period) {
  return T(static_cast<int>(leased_periods)) * period < dt - dt / T(1000);
}

}  // namespace smaservo
