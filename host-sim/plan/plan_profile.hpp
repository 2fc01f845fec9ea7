#pragma once
// Current profiles for calibration runs, by a handful of numbers that a search can vary.

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace smaservo::plan {

/// The parts of a run, one after the other. Levels are proportional to the power, from 0 at the
/// least current to 1 at the greatest.
struct Recipe {
  std::array<double, 4> shares{1, 0, 0, 0};  ///< of the time: full cycles, stairs, loops, random
  int cycles = 1;
  double pace = 1;   ///< each cycle takes this share of the time of the one before
  double ramp = 1;   ///< share of a cycle's time in which the power changes; the rest holds
  double low = 0.3;  ///< lowest level of all but the cycles
  int stairs = 6;    ///< on the way up, and as many on the way down
  int loops = 6;     ///< around `center`, each a sixth smaller than the one before
  double center = 0.6;
  int holds = 20;  ///< number of holds at random levels
  std::uint64_t seed = 1;
};

Recipe random_recipe(std::mt19937_64& random);
/// The same with one or a few of its numbers changed.
Recipe varied(const Recipe& recipe, std::mt19937_64& random);

/// The level in each of `steps` steps. The first and the last fiftieth of the time are at level 0.
std::vector<double> levels(const Recipe& recipe, std::size_t steps);

}  // namespace smaservo::plan
