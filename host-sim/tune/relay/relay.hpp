#pragma once
// A relay in place of the controller makes a loop oscillate; frequency and harmonics show the
// plant's response there, without any model of the plant. The set-point moves along, so that the
// wire always moves in one direction and its hysteresis does not reverse.
// Source: Astrom and Hagglund, 'Advanced PID Control', 2006, chapter 8.

#include <functional>
#include <vector>

#include "host-sim/tune/proposal.hpp"

namespace smaservo::tune {

/// The plant that a relay drives: `advance` holds a power for a period and returns the variable
/// after it.
struct RelayPlant {
  std::function<double(double power_W)> advance;
  double now;  ///< the variable before the first period
};

struct RelayTask {
  double period_s;
  int delay_ticks;
  double base_W;          ///< power is base +- amplitude
  double base_rises_W_s;  ///< rate of the base power, for the rising loss of a wire that becomes
                          ///< warmer
  double amplitude_W;
  double rises_1_s;   ///< rate of the variable at the base power, and of the set-point
  double direction;   ///< +1 if power raises the variable, -1 if it lowers it
  double hysteresis;  ///< hysteresis of the relay, in units of the variable
};

struct Oscillation {
  bool steady;  ///< the last two periods were alike
  double rad_s;
  double gain;  ///< ratio of the first harmonics, variable over power
};

Oscillation relay_test(const RelayTask& task, RelayPlant plant);

/// Frequency and gain that a linear loop would have in the same test, by its describing function.
Oscillation expected_oscillation(const LinearLoop& loop, const RelayTask& task);

/// The result of a test half way on a branch, and the result that the linearisation predicts.
struct RelayCheck {
  LoopName name;
  Motion motion;
  const char* plant;  ///< "one body", "24 segments"
  Oscillation tested, expected;
};

/// Tests all possible loops on both branches, with the file's wire as one body. The loop of the
/// strain is also tested on a wire of 24 segments, if the load is constant and the test takes less
/// time than the wire takes to stretch.
std::vector<RelayCheck> relay_checks(const TuneTask& task, const Proposal& p);

/// Test and prediction agree if frequency and gain are within this factor. They differ because a
/// relay switches on ticks, of which an oscillation has about twenty, and because the branch is not
/// straight.
inline constexpr double relay_factor = 1.3;
bool agrees(const RelayCheck& check);

}  // namespace smaservo::tune
