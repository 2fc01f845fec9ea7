#include "host-sim/can/shown.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/signals.hpp"
#include "firmware/text/settings_text.hpp"
#include "firmware/text/signal_names.hpp"
#include "model/files/error.hpp"
#include "model/files/toml/fields.hpp"

namespace smaservo::can {
namespace {

bool is_set_point(const text::KnownObject& object) {
  return object.key == Key{live_values, sub_of(signal_index("setpoint"))} ||
         object.key == Key{live_values, sub_of(signal_index("reference"))};
}

/// "live.setpoint" and "um" of "setpoint_um" or "live.setpoint_um", where a mode has this unit;
/// empty for any other name.
std::pair<std::string, std::string> set_point_with_unit(const std::string& name) {
  const std::array<Kind, 5> of_modes{kind::length, kind::force, kind::current, kind::power,
                                     kind::temperature};
  for (const char* const base : {"live.setpoint", "live.reference"}) {
    for (const Kind kind : of_modes) {
      for (const Unit& unit : kind) {
        const std::string full = files::key_with(base, unit.suffix);
        if (name == full || std::string(text::live_prefix) + name == full) {
          return {base, std::string(unit.suffix)};
        }
      }
    }
  }
  return {};
}

}  // namespace

Shown shown_object(const std::string& name, Units units) {
  if (const auto [base, unit] = set_point_with_unit(name); !base.empty()) {
    return {text::find_object(base), true, true, unit};
  }
  bool unitless = false;
  text::KnownObject object = text::find_quantity(name, unitless);
  if (object.name.empty()) {
    object.name = name;
  }
  if (is_set_point(object)) {
    return {object, false, true};
  }
  const bool live_share = object.key.index == live_values && !object.kind.empty() &&
                          object.kind.front().suffix.empty() && object.unit.suffix.empty();
  if (!unitless && !live_share) {
    return {object};
  }
  const Unit chosen = unit_in(object.kind, units);
  return {text::in_unit(object, chosen), chosen.suffix.empty()};
}

text::KnownObject in_force(const Shown& shown, const std::optional<Kind>& mode, Units units) {
  if (!shown.by_mode || !mode) {
    return shown.object;
  }
  const auto typed = std::ranges::find(*mode, shown.typed_unit, &Unit::suffix);
  return text::in_unit(shown.object, typed == mode->end() ? unit_in(*mode, units) : *typed);
}

void require_in_force(const Shown& shown, const std::optional<Kind>& mode) {
  if (shown.typed_unit.empty() ||
      (mode && std::ranges::find(*mode, shown.typed_unit, &Unit::suffix) != mode->end())) {
    return;
  }
  throw files::UserError(fmt::format(
      "{}_{}: {}", shown.object.name, shown.typed_unit,
      mode ? fmt::format("the mode in force has another unit: {}", text::suffixes_text(*mode))
           : unknown_mode));
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

std::optional<Kind> kind_in_force(Remote& remote) {
  try {
    const double mode = remote.number("6061");
    return std::isnan(mode) ? std::nullopt : kind_of_mode(static_cast<int>(mode));
  } catch (const SdoError& error) {
    if (error.code() == 0) {
      throw;
    }
    return std::nullopt;  // a node of another make
  }
}

text::KnownObject parameter_in(const std::string& path, Units units) {
  const text::KnownObject object = text::find_object(path);
  return object.unit.suffix.empty() || object.kind.empty()
             ? object
             : text::in_unit(object, unit_in(object.kind, units));
}

std::string quantity_text(double si, Kind kind, Units units, int digits) {
  const Unit unit = unit_in(kind, units);
  return fmt::format("{:.{}g} {}", unit.from_si(si), digits, unit.suffix);
}

}  // namespace smaservo::can
