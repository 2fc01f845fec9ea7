#pragma once
// How far the transitions that runs show lie from those of a wire, for alloys that no preset is
// near to.

#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::identify {

/// A fit reaches transitions so far from those that it starts with: three of the standard
/// deviations that are usual between wires.
inline constexpr double within_reach_K = 24;

/// By how much the transitions of these runs lie above the wire's, in K: the median over the runs
/// in a bath or a calorimeter that show heating and cooling. 0 where that is within_reach_K, or
/// where no run tells. A run that turns within the transformation misleads, so that a fit has to
/// try both.
double transitions_offset_K(const Wire<double>& wire, const std::vector<Run>& runs);

/// The wire with all its transitions moved to higher temperatures.
Wire<double> moved(Wire<double> wire, double by_K);

}  // namespace smaservo::identify
