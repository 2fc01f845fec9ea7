#pragma once
// Puts new settings in force between two steps.

#include <algorithm>

#include "firmware/device/device.hpp"
#include "firmware/parameters/parameters.hpp"

namespace smaservo {

namespace detail {

/// Whether the parameter is one of measurement.* or wire.*
constexpr bool is_observed(Key key) {
  return key.index == 0x2010 || (0x2110 <= key.index && key.index <= 0x211C);
}
static_assert(std::ranges::all_of(parameters<float>, [](const Parameter<float>& row) {
  const std::string_view path = row.path.text();
  return is_observed(row.key) == (path.starts_with("wire.") || path.starts_with("measurement."));
}));

/// Whether the observer may go on with its state: it sees the same wire through the same sensors.
template <class S>
bool same_plant(const Settings<S>& a, const Settings<S>& b) {
  return std::ranges::all_of(parameter_rows<S>, [&](const ParameterRow<S>& row) {
    return !is_observed(row.key) || row.get(a) == row.get(b);
  });
}

}  // namespace detail

/// Readies the state for a next step with `to` instead of `from`; both are prepared beforehand.
/// Gains, limits and trajectory settings change without a jump of the output: the controller goes
/// on from the power that it gave last. With another wire or other sensors, which may change
/// without current only, the observer starts afresh. Cost: some microseconds, once for each change.
template <class S>
void adopt(const Prepared<S>& from, const Prepared<S>& to, typename Device<S>::State& s) {
  s.observing = s.observing && detail::same_plant(from.settings, to.settings);
  Controller<S>::adopt(s.controller);
}

/// The same, where the loop itself has the time to prepare the settings.
template <class S>
void adopt(Prepared<S>& prepared, const Settings<S>& settings, typename Device<S>::State& s) {
  const Prepared<S> next = prepare(settings);
  adopt(prepared, next, s);
  prepared = next;
}

}  // namespace smaservo
