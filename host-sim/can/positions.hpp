#pragma once
// Positions of the axis as a person gives and reads them.

#include <cstdint>
#include <string>

#include "host-sim/can/remote.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

/// A position that the bus has in um: "1003 um" on the bench, "0.001003 m" in SI.
std::string position_text(double um, Units units);

/// The um of a position such as "1000", "0.8mm" or "0.001 m". A plain number is in um on the bench;
/// with SI it is refused, since 1000 would be a kilometre. Throws UserError unless it is a whole
/// number of um within 32 bits.
std::int32_t position_um(const std::string& text, Units units);

/// What a target may be without being limited by the node.
struct PositionRange {
  std::int64_t low_um, high_um;
};
/// The range of 607Dh and of the wire's strain limits; the wire's has priority, as in the node. A
/// node without one of them does not limit by it.
PositionRange allowed_positions(Remote& remote);

/// Throws UserError, which has the range, unless the node can go there. `text` is what was asked
/// for.
void require_allowed(Remote& remote, std::int32_t target_um, const std::string& text, Units units);

}  // namespace smaservo::can
