#pragma once
// Randomly drawn closed loops: the demands of users on a device, and disturbances meanwhile.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/bench/scenario/units.hpp"

namespace smaservo::evaluate {

/// A piece of wire, and the wire file that `identify` has made for it.
struct CalibratedUnit {
  bench::WireUnit unit;
  Wire<double> wire;
};

/// `of_each` units of each family with seeds from `seed` on. Wires that are not in the folder are
/// calibrated.
std::vector<CalibratedUnit> calibrated_units(int of_each, std::uint64_t seed,
                                             const std::string& folder);

/// The air around the wire.
enum class RandomAir : unsigned char {
  still,
  draught,
  gusts,
  shielded,  ///< a little less cooling for a time
  ambient_step,
  weak,     ///< slightly less cooling for a time
  lost,     ///< cooling falls suddenly
  fading,   ///< cooling falls over some seconds
  fan,      ///< the file was fitted in a fan's draught, and the fan fails
  touched,  ///< much more cooling for a short time
  wall,     ///< less cooling, in air that the wire warms
};
inline constexpr std::size_t random_air_count = 11;
std::string_view random_air_name(RandomAir air);

/// Disturbances of wire, load, sensors, converter and device.
enum class RandomTrouble : unsigned char {
  none,
  load_change,
  load_lost,
  stuck,
  offset,
  noise,
  gain,
  missing,
  lost_frames,
  weak_supply,
  weak_converter,
  broken,
  shorted,
  slip,
  reboot,
};
inline constexpr std::size_t random_trouble_count = 15;
std::string_view random_trouble_name(RandomTrouble trouble);

struct RandomScenario {
  bench::ClosedLoopScenario loop;  ///< its note describes what was drawn
  Mode mode;                       ///< mode of most of its commands
  RandomAir air;
  RandomTrouble trouble;
  RandomTrouble second;  ///< a trouble at the same time as the first one
  bool beyond;           ///< there are set-points beyond the limits or what the load allows
  /// First time at which the draught is a half or less of what it was at most a second before, as
  /// where a fan fails, or a touch ends; infinite: at none.
  double halved_s;
};

/// Draws a scenario of 20, 60 or 600 s from this seed. host-sim/evaluate/README.md lists the ranges
/// of all random values.
RandomScenario random_scenario(const std::vector<CalibratedUnit>& units, std::uint64_t seed);

}  // namespace smaservo::evaluate
