#pragma once
// What a run without a strain, and a few readings of the displacement, tell of a wire: the
// parameters with which the observer itself, fed with the run, agrees best with the readings and
// with what is known of such wires beforehand. host-sim/commission/README.md has the method.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/commission/anchor.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/runs/run.hpp"

namespace smaservo::commission {

struct CommissionOptions {
  Zero zero = Zero::common;
  /// With Zero::length: standard deviation of the wire's own length.
  double length_sd_m = 0.1e-3;
  /// Of the air, where the run does not have it. None: 25 °C, within the 20 K that the observer
  /// allows for.
  std::optional<double> ambient_K;
  int threads = 1;
  /// Called with the share of the work that is done; returns whether to go on.
  std::function<bool(double share)> proceed = [](double /*share*/) { return true; };
};

/// The mean error that is to be expected of the observer's strain, as a share of the nominal
/// stroke.
struct ExpectedError {
  double strain;  ///< of the strain itself, that is, of the wire's length
  double stroke;  ///< of the strain since the beginning of the run
};

/// A reading, and where the observer was at that time; contractions from the same zero, in metres.
struct AnchorFit {
  Anchor anchor;
  double before_m, after_m;
};

/// The observer through the run, at some thousand instants at most.
struct Trace {
  std::vector<double> time_s, strain, strain_sd, resistance_ohm, resistance_model_ohm;
};

struct Commissioned {
  Wire<double> wire;
  bool broad;  ///< it began from broad_wire()
  /// Cost of the beginning that was not taken less that of the other, in natural logarithms; NaN
  /// if the readings do not span half of the stroke, so that the other was not tried.
  double ahead;
  /// How far readings and parameters together are from the type, in standard deviations: the root
  /// of the sum of their squares. Pieces of a type are at 0 to 2.4 with two readings.
  double distance;
  double cold_ohm;     ///< measured at the beginning
  double cold_factor;  ///< the same, divided by what the type would have there
  std::vector<identify::FittedParameter> parameters;
  ExpectedError before, after;
  std::vector<AnchorFit> anchors;
  double innovation_before, innovation_after;  ///< RMS of the resistance's, relative
  Trace trace_before, trace_after;
};

/// `run` is one of identify::read_run() with time, current and voltage. It begins with the cold
/// wire at rest and heats it through its transformation. Throws UserError if it does not, if the
/// wire is not of the type `from` (the message says in what it differs), and for readings that are
/// outside of the run, that no such wire can have, or that contradict each other or the resistance.
/// Takes about a second of a processor for each ten seconds of the run and reading or two. The
/// result does not depend on the number of threads.
Commissioned commission(const Wire<double>& from, const identify::Run& run,
                        std::vector<Anchor> anchors, const CommissionOptions& options);

}  // namespace smaservo::commission
