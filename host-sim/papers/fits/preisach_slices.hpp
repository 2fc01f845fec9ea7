#pragma once
// Bath runs for the identification of the Preisach model: checked, and sorted by stress.

#include <vector>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::fits {

/// Runs at one stress.
struct PreisachSlice {
  double stress_Pa;
  std::vector<const identify::Run*> runs;
  double shortest, longest;  ///< range of the strain
};

/// Sorts runs into at most `max` slices by rising stress, and checks that each has reversal curves.
/// Throws UserError as fit_preisach() does.
std::vector<PreisachSlice> preisach_slices(const std::vector<identify::Run>& runs, std::size_t max);

/// The temperature without the reversals below 0.5 K, which its noise causes.
std::vector<double> steady_K(const std::vector<double>& temperature_K);

}  // namespace smaservo::fits
