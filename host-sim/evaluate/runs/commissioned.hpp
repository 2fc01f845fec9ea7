#pragma once
// The wire of a unit as `host-sim commission` would find it.

#include <cstddef>

#include "firmware/bench/scenario/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::evaluate {

/// From the unit's commissioning_run(), without its strain, and the first `readings` (0 to 2) of
/// the length at commissioning_readings_s, in error by 0.02 mm, as is the wire's own length. Takes
/// one to two seconds.
Wire<double> commissioned_wire(const bench::WireUnit& unit, std::size_t readings);

}  // namespace smaservo::evaluate
