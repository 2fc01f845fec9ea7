#pragma once
// The device's signals by their names.

#include <cstddef>
#include <string>
#include <string_view>

namespace smaservo::text {

/// The row in signal_rows. Throws UserError, which has the names that there are, or the new one
/// where a signal was called like this before.
std::size_t signal_row(const std::string& name);

/// What a signal is called now that was called `former` on the bus; empty where none was. current_A
/// and voltage_V are not among them: they are other signals today.
std::string_view renamed_signal(std::string_view former);

/// What the column of an output was called in older logs; empty where it had this name.
std::string_view former_column(std::string_view now);

}  // namespace smaservo::text
