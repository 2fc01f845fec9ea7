#pragma once
// What all commands of host-sim need where they read their options. Only options.cpp, *_command.*
// and commands/commands.cpp include it. They are compiled as one source, since CLI11 takes five
// seconds to compile.

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/units.hpp"

namespace smaservo {

/// The help of --column, where a trace is read.
inline constexpr const char* column_help =
    "QUANTITY=COLUMN:UNIT, as current=3:mA: this column by its name or number, in this unit; or "
    "NAME=COLUMN or NAME=COLUMN*FACTOR; repeatable";

/// Adds --units, the units of `what`. Its default is the value of `units`.
void add_units_option(CLI::App& command, Units& units, const std::string& what);
/// Adds --report FILE, and --units of its panels.
void add_report_options(CLI::App& command, std::string& report, Units& units,
                        const std::string& help = "report as one HTML file");

/// Checks that an option's value, if given, is in this range. Throws UserError.
void require(const char* option, const std::optional<double>& value, double low, double high);

/// Throws UserError if both names denote the same file. A device, "-" and an empty name are not
/// files.
void refuse_to_overwrite(const std::string& file, const std::string& output);

}  // namespace smaservo
