#pragma once
// The position loop of paper 002 section 5 (figures 20 and 21): PID on the estimated strain.

#include <cstdint>
#include <vector>

#include "host-sim/papers/figures/002/bench_002.hpp"

namespace smaservo::figures::bench_002 {

/// Gains from strain to current, per unit of strain.
struct PidGains {
  double proportional_A;
  double integral_A_s;
  double derivative_As;
  double min_current_A;  ///< keeps the resistance measurable
  double max_current_A;  ///< greatest current that the wire bears
};

/// The gains were found by trial, like the paper's.
PidGains gains();

/// The controller acts on strain - goal, because more current makes the wire shorter. The integral
/// is frozen while the current is at a limit and the error would drive it beyond.
class PidController {
 public:
  explicit PidController(const PidGains& gains) : gains_(gains) {}
  double current_A(double goal, double strain, double dt_s);

 private:
  PidGains gains_;
  double integral_A_ = 0;
  double before_ = 0;  ///< smoothed strain of the last step
  bool first_ = true;
};

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
