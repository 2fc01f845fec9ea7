#pragma once
// The augmented Liang-Rogers model with the parameters of one of the project's wires.

#include <vector>

#include "model/papers/resistance_lines.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::figures::bench_002 {

/// A_s to R_f are the temperatures at zero stress at which the tangents of the wire's curves reach
/// their ends; the slopes of start and finish are averaged. A process that stress does not shift
/// has an infinite C.
papers::LiangRogers<double>::Params liang_rogers(const Wire<double>& wire);

/// Resistance (in ohm) and strain on one branch of the full loop between 10 and 150 °C.
std::vector<papers::ResistancePoint<double>> liang_rogers_loop(const Wire<double>& wire,
                                                               double stress_Pa, bool heats);

}  // namespace smaservo::figures::bench_002
