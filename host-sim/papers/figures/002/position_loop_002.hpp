#pragma once
// The position loop of paper 002 section 5 (figures 20 and 21): PID on the estimated strain.

#include <cstdint>
#include <vector>

#include "host-sim/papers/figures/002/bench_002.hpp"
#include "observer/papers/position_pid.hpp"

namespace smaservo::figures::bench_002 {

using papers::PidController;
using papers::PidGains;

/// The gains were found by trial, like the paper's.
PidGains gains();

struct LoopRow {
  double time_s, goal, strain, estimate, current_A, stress_Pa;
};

/// Under the spring: random goals between 1.2 and 3.2 %, each for 22 s, of which 2 s are for the
/// motion and 20 s for holding, after one full cycle from which the estimate finds its position.
/// Rows at 50 Hz, from the first goal on; steps at 1 kHz.
std::vector<LoopRow> position_loop(hal::Family family,
                                   const papers::StrainResistance<double>::Params& estimator,
                                   int goals, std::uint64_t seed);

}  // namespace smaservo::figures::bench_002
