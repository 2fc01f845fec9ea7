#pragma once
// Bath runs as the Preisach model is identified from them: checked, and sorted by stress.

#include <vector>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::fits {

/// Runs at one stress.
struct PreisachSlice {
  double stress_Pa;
  std::vector<const identify::Run*> runs;
  double shortest, longest;  ///< strain
};

/// Sorts runs into slices by rising stress, at most `max`, and checks that each has reversal
/// curves. Throws UserError as fit_preisach() says.
std::vector<PreisachSlice> preisach_slices(const std::vector<identify::Run>& runs, std::size_t max);

/// The temperature without the reversals that its noise makes: those below 0.5 K.
std::vector<double> steady_K(const std::vector<double>& temperature_K);

}  // namespace smaservo::fits
