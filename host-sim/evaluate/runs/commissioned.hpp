#pragma once
// The wire of a unit as `host-sim commission` would find it.

#include "firmware/bench/scenario/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::evaluate {

/// What was read in a commissioning run, cold and hot (commissioning_readings_s), each time with an
/// error of 0.02 mm.
enum class Read {
  nothing,
  stroke,   ///< a caliper from anywhere: how far the wire has moved
  lengths,  ///< of the wire, whose own length is known with the same error
};

/// From the unit's commissioning_run(), without its strain, and from what was read in it. Takes one
/// to two seconds.
Wire<double> commissioned_wire(const bench::WireUnit& unit, Read read);

}  // namespace smaservo::evaluate
