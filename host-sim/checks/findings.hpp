#pragma once
// Mistakes that a recording shows before anything is computed from it: wrong units, swapped or
// clipped columns, a wire that is another one. One set of checks for all commands.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/checks/record.hpp"

namespace smaservo::checks {

/// Names of the checks, as --allow takes them.
inline constexpr std::string_view check_names[] = {"alloy",  "clipped",     "direction", "heat",
                                                   "load",   "resistivity", "sampling",  "strain",
                                                   "stress", "temperature", "time"};

struct Finding {
  std::string_view check;  ///< one of check_names
  /// Nothing that is computed from the record can be right; otherwise it may be.
  bool is_error;
  std::string text;  ///< what, where, which value, what is allowed, the likely cause, what to type
};

/// What is known of the wire that was recorded.
struct RecordedWire {
  Geometry<double> geometry;
  double lead_resistance_ohm = 0;  ///< between the points where the voltage was measured
};

/// All that the checks find, errors first. A record of fewer than 20 rows is judged by its units
/// and signs alone. Cost: a few sorts of each column.
std::vector<Finding> find_mistakes(const Record& record, const RecordedWire& wire);

/// What the findings are for somebody who has allowed some checks to fail; texts begin with the
/// record's name.
struct Judgement {
  std::string error;                  ///< the first error that is not allowed; empty: none
  std::vector<std::string> warnings;  ///< all else that was found
};
/// Throws UserError for a name in `allowed` that is no check.
Judgement judge_mistakes(const Record& record, const RecordedWire& wire,
                         const std::vector<std::string>& allowed);

/// Prints the warnings, and errors of the checks that are `allowed`, on the standard error output.
/// Throws UserError with the first error otherwise.
void refuse_mistakes(const Record& record, const RecordedWire& wire,
                     const std::vector<std::string>& allowed = {});

/// The parts of find_mistakes().
using Findings = std::vector<Finding>;
void check_units(const Record& record, const RecordedWire& wire, Findings& found);
void check_time(const Record& record, const RecordedWire& wire, Findings& found);
void check_signs(const Record& record, const RecordedWire& wire, Findings& found);
/// Clipped current or voltage, and then the other columns.
void check_converters(const Record& record, Findings& found);
void check_sensors(const Record& record, Findings& found);
void check_alloy(const Record& record, const RecordedWire& wire, Findings& found);

/// The power over the wire's surface, in kelvin above the air in still air, with the delay of the
/// wire's temperature (none where rows have no time): a measure of the heating.
std::vector<double> heating_K(const Record& record, const Geometry<double>& geometry);

/// The help of --allow.
inline constexpr const char* allow_help = "--allow resistivity: only print what this finds";

}  // namespace smaservo::checks
