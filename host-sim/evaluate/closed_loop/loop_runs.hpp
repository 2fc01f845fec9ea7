#pragma once
// Closed-loop runs by which a controller is judged: steps between random strains, and sines.

#include <cstdint>
#include <vector>

#include "host-sim/evaluate/closed_loop/loop_controllers.hpp"

namespace smaservo::evaluate {

inline constexpr double loop_hold_s = 2.5;      ///< time for which each strain is held
inline constexpr double loop_band_percent = 2;  ///< error within which a step has settled
/// Last part of a hold, over which the mean is the steady error.
inline constexpr double loop_steady_over_s = 0.5;
inline constexpr double loop_ripple_percent = 0.25;  ///< motion that counts as a reversal

/// One step of the set-point, in per cent of the nominal stroke.
struct LoopStep {
  bool heats;
  /// Time until the error stays within 2 % to the end of the hold; infinite: never.
  double settled_s;
  double error_percent;  ///< mean magnitude over the last half second
  int reversals;         ///< reversals by more than loop_ripple_percent over the last half second
};

struct LoopRun {
  std::vector<LoopStep> steps;
  double above_limit_K;  ///< hottest point of the wire in the run less the temperature limit
  Fault tripped;         ///< fault for which the controller had switched off at the end
};

/// Makes one full stroke, then holds `steps` random strains between 10 and 90 % of the wire's range
/// under this load. All controllers get the same strains.
LoopRun run_steps(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                  int steps, std::uint64_t seed);

/// The amplitude of the strain relative to that of the set-point, which is 10 % of the nominal
/// stroke around the middle.
double sine_gain_dB(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                    double frequency_Hz, std::uint64_t seed);

/// The frequency at which the gain is -3 dB, between 0.25 and 8 Hz, within 5 %.
double bandwidth_Hz(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                    std::uint64_t seed);

}  // namespace smaservo::evaluate
