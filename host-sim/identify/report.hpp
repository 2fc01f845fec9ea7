#pragma once
// The result of a fit as text, JSON and HTML.

#include <optional>
#include <string>
#include <vector>

#include "host-sim/identify/classic.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/units.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::identify {

/// A fit and its inputs.
struct Identification {
  std::string from;  ///< name of the wire that the fit started from
  std::string out;   ///< file for the fitted wire
  std::vector<Run> runs;
  std::vector<Run> held_out_runs;
  FitResult fit;
  std::vector<FittedRun> held_out;
  files::WireDescription wire;
  std::vector<std::vector<ClassicFit>> classics;  ///< fits of each run, see fit_classics()
  double elapsed_s = 0;
};

/// RMS over all compared rows of all runs; none where no run has errors of this kind.
std::optional<double> joint_rms(const std::vector<FittedRun>& runs,
                                FitQuality FittedRun::* quality);
/// That of the strain, as a share of the nominal stroke.
inline std::optional<double> joint_strain_rms(const FitResult& fit) {
  return joint_rms(fit.runs, &FittedRun::strain);
}

/// RMS of a classic function as a share of the nominal stroke, like that of the fit.
double classic_rms(const ClassicFit& classic, const Run& run, double nominal_stroke);

/// The result as text for a terminal.
std::string fit_summary(const Identification& all);

/// All numbers as one JSON object: runs, parameters with prior and standard deviation,
/// correlations.
std::string fit_json(const Identification& all);

/// Writes one HTML file that can be opened without a network. Throws UserError.
void write_fit_report(const std::string& path, const Identification& all, Units units);

}  // namespace smaservo::identify
