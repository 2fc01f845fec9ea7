#pragma once
// Full heatings and coolings in a measured run.

#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/papers/resistance_lines.hpp"

namespace smaservo::fits {

/// Strain and resistance (in units of `ohm`) on all full branches of a run: those that go from 90 %
/// of the run's stroke to 10 % or back and never reverse by more than 5 %. Every 2 % of the stroke
/// gives one point per branch, the mean of its rows, so that all parts of the stroke have the same
/// weight.
struct FullBranches {
  std::vector<papers::ResistancePoint<double>> heating, cooling;
};
FullBranches full_branches(const identify::Run& run, double ohm);

/// A joule run with the means of its rows over at least this time; other runs unchanged.
identify::Run averaged(const identify::Run& run, double seconds);

}  // namespace smaservo::fits
