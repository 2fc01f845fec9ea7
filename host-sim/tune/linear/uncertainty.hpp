#pragma once
// The wires that a wire file may represent.

#include <cstdint>
#include <vector>

#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

/// Greatest convection that a tuned loop has to tolerate, relative to still air.
inline constexpr double max_draught = 1.5;

/// Wires that differ in what identification leaves open, and in their surroundings. With e =
/// accuracy.strain and the stroke s, the branches are known as follows: their width and strain to
/// e/s, their position to e/s of their width (twice that, cut at 2.5 deviations); latent heats to 6
/// %, the specific heat to 4 %, the stress slopes to 2 %, moduli to 5 %, curvatures to 10 %,
/// resistivities to 0.3 %. Convection varies by a factor from 0.8 to 1.5 (a draught), the air by 3
/// K. The first is the wire itself; the next two have the least and the greatest convection and
/// otherwise the file's numbers. The same seed gives the same members. All factors apply in
/// addition to plant.draught.
std::vector<TunedPlant> uncertain_plants(const TunedPlant& plant, int count, std::uint64_t seed);

}  // namespace smaservo::tune
