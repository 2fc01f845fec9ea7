#pragma once
// The transformation functions that most models use, as a yardstick: what a fit of the wire's own
// model has to beat.

#include <string_view>
#include <vector>

#include "host-sim/identify/run.hpp"

namespace smaservo {

/// A run's strain by eps_A + (eps_M - eps_A) xi(T), with the martensite fraction xi on heating and
/// on cooling, each of its own centre and width, and plateau strains that both share:
/// cosine (Liang and Rogers 1990), tanh and arctan. No unloading, no minor loops, no R-phase.
struct ClassicFit {
  std::string_view name;       ///< "cosine", "tanh" or "arctan"
  double rms, p95, max;        ///< of the error, as a share of the stroke: the span of the strain
  std::vector<double> strain;  ///< what it makes of each row
  double martensite_strain, austenite_strain;
  double heating_K, heating_width_K;  ///< centre and width, see fraction() in classic.cpp
  double cooling_K, cooling_width_K;
};

/// Least squares over all rows, which count alike; of more than 2000 rows every n-th. Takes some
/// 20 ms for 500 rows.
/// Empty where the fits mean nothing: for runs that are not in a bath, have no strain, whose stress
/// leaves its median by more than an eighth (and 5 MPa) in more than a twentieth of the rows to
/// either side, or that are not one heating and one cooling through the whole transformation.
std::vector<ClassicFit> fit_classics(const Run& run);

}  // namespace smaservo
