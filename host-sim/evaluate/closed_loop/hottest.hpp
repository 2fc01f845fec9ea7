#pragma once
// The hottest point of the wire in random scenarios, and the faults that the device detects in
// them.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host-sim/evaluate/closed_loop/random_scenario.hpp"

namespace smaservo::evaluate {

/// Allowed excess of the true hottest point over limits.temperature_K.
inline constexpr double hottest_allowed_K = 3;
/// An excess that should never occur.
inline constexpr double hottest_far_K = 15;
/// Time within which a device has to be in a fault after a greater excess than allowed.
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
  double at_s;           ///< time of above_limit_K
  Fault first_cause;     ///< cause of the first trip; Fault::none: there was none
  double tripped_s;      ///< time of the first trip; infinite: there was none
  double over_s;         ///< total time above the allowed excess
  bool unanswered;       ///< no fault within hottest_answered_s after an excess
  bool halved;           ///< at some time before at_s the draught had halved within a second

  bool violates() const { return above_limit_K > hottest_allowed_K; }
  /// Whether nothing happened to the wire and nothing was demanded beyond its limits.
  bool harmless() const {
    return !beyond && trouble == RandomTrouble::none &&
           (air == RandomAir::still || air == RandomAir::draught);
  }
  /// Whether a harmless scenario has tripped. A following error is no false alarm: the current
  /// limit or a draught may make a set-point unreachable.
  bool false_alarm() const {
    return harmless() && first_cause != Fault::none && first_cause != Fault::following_error;
  }
};

/// Cost: each 20 s of the 20 to 600 s of a closed loop take 0.03 to 0.1 s.
HottestRun run_hottest(const RandomScenario& scenario);

/// Runs `count` scenarios with seeds from `seed` on, in several threads, whose number does not
/// affect the result.
std::vector<HottestRun> run_hottest(const std::vector<CalibratedUnit>& units, std::uint64_t seed,
                                    int count, int threads,
                                    const std::function<void(std::size_t)>& done);

/// Tables in Markdown: all scenarios and their classes, the first trips, the violations.
std::string hottest_markdown(const std::vector<HottestRun>& runs);

}  // namespace smaservo::evaluate
