#pragma once
// Measured runs of a wire, to which its parameters are fitted. A run is a whole trace in SI,
// checked for errors that would make a fit wrong unnoticed.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/trace.hpp"
#include "host-sim/checks/record.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::identify {

using checks::name_of;
using checks::RunKind;
/// A run has a stress, and joule and settled runs a strain (joule: unless it is optional), bath a
/// strain or a resistance. Where
/// the file has neither stress nor load, it comes from the options; in calorimetry it is 0.
using Run = checks::Record;

struct RunOptions {
  Geometry<double> geometry;
  std::optional<double> stress_Pa;  ///< for files that have neither stress nor load
  std::optional<double> load_N;     ///< like stress_Pa; used if there is no stress_Pa
  hal::TraceOptions trace;
  /// Checks that may fail.
  std::vector<std::string> allowed = {};  // NOLINT(readability-redundant-member-init): for braces
  /// Whether a run that was heated by current may lack a strain.
  bool strain_optional = false;
  /// Whether the strain of runs that were heated by current was imposed.
  bool imposed_strain = false;
};

/// Makes a run of a record: finds its kind and its stress, and refuses what read_run() refuses,
/// except for mistakes that the checks would find. Throws UserError.
Run run_of(checks::Record record, const RunOptions& options);

/// Reads the whole file. Throws UserError, which says what to measure instead, for a file that
/// - is of no kind, has fewer than 20 rows, or nothing to fit to;
/// - shows no motion: strain within 0.3 % and resistance within 2 %, or in calorimetry temperature
///   within 10 K, each without the outermost hundredths;
/// - shows a mistake (host-sim/checks/findings.hpp), unless it is allowed. Warnings are printed.
/// Throws TraceError for errors that no trace may have.
Run read_run(const std::string& path, const RunOptions& options);

/// Whether a run's strains are absolute elongations. They are not if the smallest or greatest value
/// of the column is exactly 0, since such a column was zeroed there.
bool zero_known(const std::vector<double>& strain);

}  // namespace smaservo::identify
