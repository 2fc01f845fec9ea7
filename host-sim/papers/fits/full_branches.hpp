#pragma once
// Full heatings and coolings in a measured run.

#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/papers/resistance_lines.hpp"

namespace smaservo::fits {

/// Strain and resistance (in units of `ohm`) on all full branches of a run: those that go from 90 %
/// of the run's stroke to 10 % or back and never turn by more than 5 %. Every 2 % of the stroke
/// gives one point per branch, the mean of its rows, so that every bit of strain counts alike.
struct FullBranches {
  std::vector<papers::ResistancePoint<double>> heating, cooling;
};
FullBranches full_branches(const identify::Run& run, double ohm);

/// A joule run with the means of its rows over at least so many seconds; others as they are.
identify::Run averaged(const identify::Run& run, double seconds);

}  // namespace smaservo::fits
