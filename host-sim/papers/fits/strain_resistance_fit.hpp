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
  std::vector<LoadLevel> levels;  ///< by stress
  int order;  ///< of the polynomials, up to 4; 0 for one level: then they hold at its stress alone
};

/// Joule and bath runs with strain and resistance; a bath run's rows are settled states. Lines come
/// from runs of constant stress, from their full heatings and coolings: from 90 % of the run's
/// stroke to 10 % of it without turning, by Theil and Sen's median of slopes; a run whose stroke is
/// below 1 %, or half of another run's, has none. Loads within 5 % (and 2 MPa) are one level. The
/// transition constants and the standard deviation come from all runs, so they should have minor
/// loops. Throws UserError where no run has a full heating or a full cooling, and where the strain
/// does not rise with the resistance, as light loads with much R-phase have it on cooling. Takes
/// about a second for ten minutes at 1 kHz.
StrainResistanceFit identify_strain_resistance(const std::vector<identify::Run>& runs);

/// The observer's strain in every row of a run.
std::vector<double> estimate_strain(const papers::StrainResistance<double>::Params& params,
                                    const identify::Run& run);

}  // namespace smaservo::fits
