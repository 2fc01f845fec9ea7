#pragma once
// The parameters of observer/papers/strain_resistance.hpp from measured runs, in the order of paper
// 002 section 4: lines at every load, polynomials over the loads, then the transitions.

#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "observer/papers/strain_resistance.hpp"

namespace smaservo::fits {

/// The lines at one load.
struct LoadLevel {
  double stress_Pa;
  papers::ResistanceLine<double> heating, cooling;
};

struct StrainResistanceFit {
  papers::StrainResistance<double>::Params params;
  std::vector<LoadLevel> levels;  ///< sorted by stress
  /// Order of the polynomials, up to 4; 0 if there is one level: they are then valid only at its
  /// stress.
  int order;
};

/// Uses joule and bath runs with strain and resistance; the rows of a bath run are settled states.
/// Lines come from the full heatings and coolings of runs at constant stress: from 90 % of the
/// run's stroke to 10 % of it without reversal, by Theil and Sen's median of slopes; a run whose
/// stroke is below 1 %, or half of another run's, has none. Loads within 5 % (and 2 MPa) are one
/// level. The transition constants and the standard deviation come from all runs, so these should
/// have minor loops. Throws UserError if no run has a full heating or a full cooling, and if the
/// strain does not rise with the resistance, as at light loads with much R-phase on cooling. Takes
/// about a second for ten minutes at 1 kHz.
StrainResistanceFit identify_strain_resistance(const std::vector<identify::Run>& runs);

/// The observer's strain in every row of a run.
std::vector<double> estimate_strain(const papers::StrainResistance<double>::Params& params,
                                    const identify::Run& run);

}  // namespace smaservo::fits
