#pragma once
// Objects in the units in which a person wants to see them.

#include <optional>
#include <string>

#include "firmware/text/canopen/objects.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

/// The object that a name denotes, with its texts in the unit that the name has, or else in that of
/// `units`: "position" is live.position_um on the bench. A name that is known as it stands and has
/// no unit stays so. Throws UserError.
text::KnownObject asked_object(const std::string& name, Units units);

/// Like asked_object(), for a table whose head names the units: a live share, such as live.strain,
/// is in per cent on the bench.
text::KnownObject shown_object(const std::string& name, Units units);

/// Whether the object is live.setpoint or live.reference, whose unit is that of the mode.
bool is_in_unit_of_mode(const text::KnownObject& object);

/// The kind of a mode's set-point (6061h); nullopt where the mode has none.
std::optional<Kind> kind_of_mode(int mode);

/// An SI value with its unit, such as "23.4 degC", with this many significant digits.
std::string quantity_text(double si, Kind kind, Units units, int digits = 5);

/// A position that the bus has in um: "1003 um" on the bench, "0.001003 m" in SI.
std::string position_text(double um, Units units);

/// The um of a position such as "1000", "0.8mm" or "0.001 m"; a plain number is in the unit of
/// `units`. Throws UserError unless it is a whole number of um within 32 bits.
std::int32_t position_um(const std::string& text, Units units);

}  // namespace smaservo::can
