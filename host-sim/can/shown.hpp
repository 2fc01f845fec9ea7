#pragma once
// Objects in the units in which a person wants to see them.

#include <optional>
#include <string>

#include "firmware/text/canopen/objects.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

/// An object as it is shown.
struct Shown {
  text::KnownObject object;
  /// Whether the name that was asked for says the unit that the object is shown in.
  bool names_unit = true;
  /// Whether it is live.setpoint or live.reference, whose unit is that of the mode.
  bool by_mode = false;
  std::string typed_unit = {};  // NOLINT(readability-redundant-member-init): of these two, or ""
};

/// The object that a name denotes, with its texts in the unit that the name has, or else in that of
/// `units`: "position" is live.position_um on the bench, and "strain", a live share,
/// live.strain_percent. A parameter that is known as it stands and has no unit stays so.
/// live.setpoint and live.reference are also found with a unit of some mode: "setpoint_um". Throws
/// UserError.
Shown shown_object(const std::string& name, Units units);

/// The object in the unit of the mode, where it has that of the mode and the mode is known: in the
/// unit that was asked for if the mode has it.
text::KnownObject in_force(const Shown& shown, const std::optional<Kind>& mode, Units units);

/// Throws UserError if a unit was asked for that the mode does not have.
void require_in_force(const Shown& shown, const std::optional<Kind>& mode);

/// The kind of a mode's set-point (6061h); nullopt where the mode has none.
std::optional<Kind> kind_of_mode(int mode);

/// The kind of the set-points of the mode that is in force, if it is known.
std::optional<Kind> kind_in_force(Remote& remote);

inline constexpr const char* unknown_mode = "no mode is set (6060h), so its unit is not known";

/// A parameter in the unit of `units`; one without dimension stays as it is.
text::KnownObject parameter_in(const std::string& path, Units units);

/// An SI value with its unit, such as "23.4 degC", with this many significant digits.
std::string quantity_text(double si, Kind kind, Units units, int digits = 5);

}  // namespace smaservo::can
