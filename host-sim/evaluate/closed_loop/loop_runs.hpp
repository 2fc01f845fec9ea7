#pragma once
// Closed-loop runs and what they say: steps between random strains, and sines.

#include <cstdint>
#include <vector>

#include "host-sim/evaluate/closed_loop/loop_controllers.hpp"

namespace smaservo::evaluate {

inline constexpr double loop_hold_s = 2.5;           ///< of each strain
inline constexpr double loop_band_percent = 2;       ///< settled
inline constexpr double loop_steady_over_s = 0.5;    ///< at the end of each
inline constexpr double loop_ripple_percent = 0.25;  ///< what counts as going to and fro

/// One step of the set-point. In per cent of the nominal stroke.
struct LoopStep {
  bool heats;
  double settled_s;      ///< until within 2 % to the end of the hold; infinite: never
  double error_percent;  ///< mean size over the last half second
  int reversals;         ///< of the motion over it, by more than loop_ripple_percent
};

struct LoopRun {
  std::vector<LoopStep> steps;
  double above_limit_K;  ///< the hottest that the wire was anywhere, beyond the temperature limit
  Fault tripped;         ///< what the controller had switched off for at the end
};

/// After one full stroke: so many random strains between a tenth and nine tenths of what the wire
/// can do under this load. All controllers get the same strains.
LoopRun run_steps(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                  int steps, std::uint64_t seed);

/// Amplitude of the strain, in dB of the one asked for: 10 % of the nominal stroke about the
/// middle.
double sine_gain_dB(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                    double frequency_Hz, std::uint64_t seed);

/// The frequency of -3 dB, between 0.25 and 8 Hz, within 5 %.
double bandwidth_Hz(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                    std::uint64_t seed);

}  // namespace smaservo::evaluate
