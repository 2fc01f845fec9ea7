#pragma once
// The wires that a wire file may stand for.

#include <cstdint>
#include <vector>

#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

/// Most convection that a tuned loop has to bear, by still air.
inline constexpr double max_draught = 1.5;

/// Wires that differ by what identification leaves open and by their surroundings. accuracy.strain
/// e relative to the stroke s says how well the branches are known: their width and strain by e/s,
/// their place by e/s of their width (twice that, cut at 2.5 deviations); latent heats by 6 %, the
/// specific heat by 4 %, the stress slopes by 2 %, moduli by 5 %, curvatures by 10 %, resistivities
/// by 0.3 %; convection by a factor from 0.8 to 1.5 (a draught), air by 3 K. The first is the wire
/// itself, the next two have the least and the greatest convection and else the file's numbers. The
/// same seed gives the same members; plant.draught of the file counts.
std::vector<TunedPlant> uncertain_plants(const TunedPlant& plant, int count, std::uint64_t seed);

}  // namespace smaservo::tune
