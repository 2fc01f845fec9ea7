#pragma once
// How hot a wire gets at most in random scenarios, and what the device says of it.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host-sim/evaluate/closed_loop/random_scenario.hpp"

namespace smaservo::evaluate {

/// What the true hottest point may be above limits.temperature_K.
inline constexpr double hottest_allowed_K = 3;
/// What it should never be.
inline constexpr double hottest_far_K = 15;
/// Time within which a device has to end in a fault where it is hotter.
inline constexpr double hottest_answered_s = 5;

/// One scenario's outcome, with what classes it.
struct HottestRun {
  std::uint64_t seed;
  Mode mode;
  RandomAir air;
  RandomTrouble trouble;
  bool beyond;
  double duration_s;
  double above_limit_K;  ///< true hottest point less limits.temperature_K, the highest
  double at_s;           ///< when
  Fault first_cause;     ///< of the first trip; Fault::none
  double tripped_s;      ///< when; infinite: never
  double over_s;         ///< for so long above what is allowed, all such times together
  bool unanswered;       ///< not in a fault hottest_answered_s after it was above

  bool violates() const { return above_limit_K > hottest_allowed_K; }
  /// Nothing happened to the wire and nothing was asked beyond its limits.
  bool harmless() const {
    return !beyond && trouble == RandomTrouble::none &&
           (air == RandomAir::still || air == RandomAir::draught);
  }
  /// What the current limit or a draught leaves out of reach ends with a following error.
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

/// Tables of Markdown: all of them, classes of them, those that violate, and what tripped.
std::string hottest_markdown(const std::vector<HottestRun>& runs);

}  // namespace smaservo::evaluate
