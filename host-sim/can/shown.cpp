#include "host-sim/can/shown.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/signals.hpp"
#include "firmware/text/settings_text.hpp"
#include "model/files/error.hpp"

namespace smaservo::can {
namespace {

constexpr double um_m = 1e-6;

}  // namespace

text::KnownObject asked_object(const std::string& name, Units units) {
  bool unitless = false;
  const text::KnownObject object = text::find_quantity(name, unitless);
  return unitless ? text::in_unit(object, unit_in(object.kind, units)) : object;
}

text::KnownObject shown_object(const std::string& name, Units units) {
  const text::KnownObject object = asked_object(name, units);
  const bool live_share = object.key.index == live_values && !object.kind.empty() &&
                          object.kind.front().suffix.empty() && object.unit.suffix.empty();
  return live_share ? text::in_unit(object, unit_in(object.kind, units)) : object;
}

bool is_in_unit_of_mode(const text::KnownObject& object) {
  return object.key == Key{live_values, sub_of(signal_index("setpoint"))} ||
         object.key == Key{live_values, sub_of(signal_index("reference"))};
}

std::optional<Kind> kind_of_mode(int mode) {
  switch (static_cast<canopen::DriveMode>(mode)) {
    case canopen::DriveMode::profile_position:
    case canopen::DriveMode::homing:
    case canopen::DriveMode::cyclic_position:
      return kind::length;
    case canopen::DriveMode::profile_force:
    case canopen::DriveMode::cyclic_force:
      return kind::force;
    case canopen::DriveMode::current:
      return kind::current;
    case canopen::DriveMode::power:
      return kind::power;
    case canopen::DriveMode::temperature:
      return kind::temperature;
    default:
      return std::nullopt;
  }
}

std::string quantity_text(double si, Kind kind, Units units, int digits) {
  const Unit unit = unit_in(kind, units);
  return fmt::format("{:.{}g} {}", unit.from_si(si), digits, unit.suffix);
}

std::string position_text(double um, Units units) {
  return units == Units::bench ? fmt::format("{} um", um) : fmt::format("{} m", um / 1e6);
}

std::int32_t position_um(const std::string& text, Units units) {
  const Kind length = kind::length;
  const std::optional<text::Quantity> quantity = text::quantity_of(text);
  const std::optional<Unit> unit =
      quantity ? quantity->unit_in(length, unit_in(length, units)) : std::nullopt;
  if (!unit) {
    throw files::UserError(
        fmt::format("position {}: must be a number, alone ({}) or with a unit behind it: {}", text,
                    unit_in(length, units).suffix, text::suffixes_text(length)));
  }
  constexpr double rounding_um = 1e-6;
  const double um = unit->to_si(quantity->number) / um_m;
  const double whole_um = std::round(um);
  constexpr std::int32_t low = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t high = std::numeric_limits<std::int32_t>::max();
  if (!(low <= whole_um && whole_um <= high)) {
    throw files::UserError(
        fmt::format("position {}: is {:.6g} um, must be {} to {} um", text, um, low, high));
  }
  if (std::abs(um - whole_um) > rounding_um) {
    throw files::UserError(
        fmt::format("position {}: is {:.6g} um, must be a whole number of um", text, um));
  }
  return static_cast<std::int32_t>(whole_um);
}

}  // namespace smaservo::can
