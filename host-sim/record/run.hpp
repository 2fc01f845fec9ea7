#pragma once
// One run of a folder: a recording of any bench as a table in this project's columns.

#include <optional>
#include <string>
#include <vector>

#include "hal/replay/trace.hpp"
#include "host-sim/inspect/inspect.hpp"
#include "host-sim/record/card/card.hpp"

namespace smaservo::record {

/// Where a run comes from, and what its file does not say.
struct RunSource {
  std::string path;
  std::string shown;  ///< its name in messages
  std::vector<std::string> renames;
  double period_s = 0;  ///< above 0: time between rows of a table without time
  /// For tables that have neither load nor stress; at most one of the two.
  std::optional<double> load_N, stress_MPa;
  std::vector<std::string> allowed;  ///< checks that may fail
};

/// After a signal (EndBySignal): says that nothing is added, and throws UserError.
void refuse_after_signal(const std::string& shown);

/// Refuses names in `allowed` that are no checks.
void check_allowed(const std::vector<std::string>& allowed);

/// What a run lacks for a replay: "a current; a load: ...". Empty: nothing.
std::string lacks(const hal::TraceReader& trace, bool has_constant_load);

/// Writes a run as CSV to `to`: the source's columns under this project's names, each number with
/// its digits; a constant load and a period become columns. Then it reads both files again, and
/// each number must be the same in both. Prints how a table was read and what the checks find.
/// Throws UserError or TraceError, which name file, line, column and value; then the file at `to`
/// may be there, in part. Ends with UserError soon after a signal (EndBySignal).
inspect::Facts take_run(const RunSource& source, const Card& card,
                        const files::WireDescription& wire, const std::string& to);

/// A run that is in a folder: what it holds and what the checks find. Throws TraceError.
inspect::Facts facts_of(const std::string& path, const files::WireDescription& wire);

/// "" or that a run has more rows a second than the card says that were converted.
std::string rate_note(const inspect::Facts& facts, const Card& card);

/// "" or that a run was heated under another load than the card's weight.
std::string load_fault(const inspect::Facts& facts, const Card& card,
                       const files::WireDescription& wire);

/// Reads a whole run strictly; "" or what is wrong.
std::string fault_of(const std::string& path, const Card& card);

/// The options of the reader for runs: strict, with resistance.
hal::TraceOptions run_options();

}  // namespace smaservo::record
