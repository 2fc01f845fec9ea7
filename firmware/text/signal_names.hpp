#pragma once
// The device's signals by their names.

#include <cstddef>
#include <string>
#include <string_view>

#include "model/units.hpp"

namespace smaservo::text {

/// What the names of the live values begin with on the bus.
inline constexpr std::string_view live_prefix = "live.";

/// The row in signal_rows, by its name with or without "live.". Throws UserError, which has the
/// names that there are, or the new one where a signal was called like this before.
std::size_t signal_row(const std::string& name);

/// The units of a signal, SI's own first. Those of set-point and reference depend on the mode: here
/// they have none.
Kind signal_kind(std::size_t row);

/// What a signal is called now that was called `former` on the bus; empty where none was. current_A
/// and voltage_V are not among them: they are other signals today.
std::string_view renamed_signal(std::string_view former);

/// What the column of an output was called in older logs; empty where it had this name.
std::string_view former_column(std::string_view now);

}  // namespace smaservo::text
