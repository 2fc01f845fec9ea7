#pragma once
// The result of a fit as text, JSON and HTML.

#include <optional>
#include <string>
#include <vector>

#include "host-sim/identify/classic.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::identify {

/// A fit and what it was made from.
struct Identification {
  std::string from;  ///< name of the wire that it started from
  std::string out;   ///< file of the wire
  std::vector<Run> runs;
  FitResult fit;
  files::WireDescription wire;
  std::vector<std::vector<ClassicFit>> classics;  ///< of each run, see fit_classics()
  double elapsed_s = 0;
};

/// Over all compared rows of all runs, in shares of the nominal stroke; none without strain.
std::optional<double> joint_strain_rms(const FitResult& fit);

/// RMS of a classic function in shares of the nominal stroke, as the fit's own.
double classic_rms(const ClassicFit& classic, const Run& run, double nominal_stroke);

/// For a terminal.
std::string fit_summary(const Identification& all);

/// All numbers as one JSON object: runs, parameters with prior and deviation, correlations.
std::string fit_json(const Identification& all);

/// Writes one HTML file that opens without a network. Throws UserError.
void write_fit_report(const std::string& path, const Identification& all);

}  // namespace smaservo::identify
