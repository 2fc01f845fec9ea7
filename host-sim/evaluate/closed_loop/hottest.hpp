#pragma once
// The hottest point of the wire in random scenarios, and the faults that the device finds in them.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host-sim/evaluate/closed_loop/random_scenario.hpp"

namespace smaservo::evaluate {

/// The true hottest point may exceed limits.temperature_K by this much.
inline constexpr double hottest_allowed_K = 3;
/// What it should never be.
inline constexpr double hottest_far_K = 15;
/// Time within which a device has to end in a fault where it is hotter.
inline constexpr double hottest_answered_s = 5;

/// The outcome of one scenario, and the properties by which scenarios are classed.
struct HottestRun {
  std::uint64_t seed;
  Mode mode;
  RandomAir air;
  RandomTrouble trouble;
  bool beyond;
  double duration_s;
  double above_limit_K;  ///< maximum of the true hottest point less limits.temperature_K
  double at_s;           ///< when
  Fault first_cause;     ///< of the first trip; Fault::none: never
  double tripped_s;      ///< when; infinite: never
  double over_s;         ///< for so long above what is allowed, all such times together
  bool unanswered;       ///< not in a fault hottest_answered_s after it was above

  bool violates() const { return above_limit_K > hottest_allowed_K; }
  /// Nothing happened to the wire and nothing was asked beyond its limits.
  bool harmless() const {
    return !beyond && trouble == RandomTrouble::none &&
           (air == RandomAir::still || air == RandomAir::draught);
  }
  /// A harmless scenario has tripped. A following error is no false alarm: the current limit or a
  /// draught may put a set-point out of reach.
  bool false_alarm() const {
    return harmless() && first_cause != Fault::none && first_cause != Fault::following_error;
  }
};

/// Cost: 20 to 600 s of a closed loop, 0.03 to 0.1 s for each 20 s.
HottestRun run_hottest(const RandomScenario& scenario);

/// `count` scenarios with seeds from `seed` on, by several threads; the result does not depend on
/// them.
std::vector<HottestRun> run_hottest(const std::vector<CalibratedUnit>& units, std::uint64_t seed,
                                    int count, int threads,
                                    const std::function<void(std::size_t)>& done);

/// Tables in Markdown: all scenarios and their classes, the first trips, the violations.
std::string hottest_markdown(const std::vector<HottestRun>& runs);

}  // namespace smaservo::evaluate
