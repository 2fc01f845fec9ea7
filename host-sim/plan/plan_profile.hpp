#pragma once
// Current profiles for calibration runs, described by a few numbers that a search can vary.

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace smaservo::plan {

/// The parts of a run, one after the other. Levels are proportional to the power, from 0 at the
/// least current to 1 at the greatest.
struct Recipe {
  /// Shares of the time for full cycles, stairs, loops and random holds.
  std::array<double, 4> shares{1, 0, 0, 0};
  int cycles = 1;
  double pace = 1;   ///< duration of each cycle relative to the one before
  double ramp = 1;   ///< share of a cycle's time in which the power changes; it is held in the rest
  double low = 0.3;  ///< lowest level of all parts except the cycles
  int stairs = 6;    ///< number of stairs on the way up, and on the way down
  int loops = 6;     ///< number of loops around `center`, each a sixth smaller than the one before
  double center = 0.6;
  int holds = 20;  ///< number of holds at random levels
  std::uint64_t seed = 1;
};

Recipe random_recipe(std::mt19937_64& random);
/// The same recipe with one or a few of its numbers changed.
Recipe varied(const Recipe& recipe, std::mt19937_64& random);

/// The level in each of `steps` steps. The first and the last fiftieth of the time are at level 0.
std::vector<double> levels(const Recipe& recipe, std::size_t steps);

}  // namespace smaservo::plan
