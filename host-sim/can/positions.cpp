#include "host-sim/can/positions.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "firmware/text/settings_text.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::can {
namespace {

constexpr double um_m = 1e-6;
constexpr std::int32_t lowest_um = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t highest_um = std::numeric_limits<std::int32_t>::max();

/// The value of an object; nullopt where the node has none.
std::optional<double> number_if_there(Remote& remote, const char* name) {
  try {
    const double value = remote.number(name);
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  } catch (const SdoError& error) {
    if (error.code() == 0) {
      throw;
    }
    return std::nullopt;
  }
}

/// How far homing has moved the axis' zero from axis.zero_strain. The node shows both positions one
/// after the other, so a small difference is the wire's way between the two answers.
double shift_of_zero_um(Remote& remote) {
  constexpr double least_um = 20;
  const auto before = number_if_there(remote, "6064");
  const auto unshifted = number_if_there(remote, "live.position_m");
  const auto after = number_if_there(remote, "6064");
  if (!before || !unshifted || !after) {
    return 0;
  }
  const double shift_um = 0.5 * (*before + *after) - *unshifted / um_m;
  return std::abs(shift_um) < least_um + std::abs(*after - *before) ? 0 : shift_um;
}

}  // namespace

std::string position_text(double um, Units units) {
  return units == Units::bench ? fmt::format("{} um", um) : fmt::format("{} m", um / 1e6);
}

std::int32_t position_um(const std::string& text, Units units) {
  const Kind length = kind::length;
  const std::optional<text::Quantity> quantity = text::quantity_of(text);
  if (quantity && quantity->unit.empty() && units == Units::si) {
    throw files::UserError(
        fmt::format("position {}: needs a unit behind it: {}", text, text::suffixes_text(length)));
  }
  const std::optional<Unit> unit =
      quantity ? quantity->unit_in(length, unit_in(length, units)) : std::nullopt;
  if (!unit) {
    throw files::UserError(fmt::format("position {}: must be a number{} with a unit behind it: {}",
                                       text, units == Units::bench ? ", alone (um) or" : "",
                                       text::suffixes_text(length)));
  }
  constexpr double rounding_um = 1e-6;
  const double um = unit->to_si(quantity->number) / um_m;
  const double whole_um = std::round(um);
  if (!(lowest_um <= whole_um && whole_um <= highest_um)) {
    throw files::UserError(fmt::format("position {}: is {:.6g} um, must be {} to {} um", text, um,
                                       lowest_um, highest_um));
  }
  if (std::abs(um - whole_um) > rounding_um) {
    throw files::UserError(
        fmt::format("position {}: is {:.6g} um, must be a whole number of um", text, um));
  }
  return static_cast<std::int32_t>(whole_um);
}

PositionRange allowed_positions(Remote& remote) {
  const double low_um = number_if_there(remote, "607D:1").value_or(lowest_um);
  const double high_um = number_if_there(remote, "607D:2").value_or(highest_um);
  PositionRange range{std::llround(low_um), std::llround(high_um)};
  const auto zero = number_if_there(remote, "axis.zero_strain");
  const auto min = number_if_there(remote, "limits.min_strain");
  const auto max = number_if_there(remote, "limits.max_strain");
  const auto length_m = number_if_there(remote, "wire.length_m");
  if (zero && min && max && length_m) {
    const double shift_um = shift_of_zero_um(remote);
    const auto um_at = [&](double strain) {
      constexpr double most_um = 1e12;
      return std::llround(
          std::clamp((*zero - strain) * *length_m / um_m + shift_um, -most_um, most_um));
    };
    const PositionRange wire{um_at(*max), um_at(*min)};
    range.low_um = std::max(wire.low_um, std::min(range.low_um, wire.high_um));
    range.high_um = std::max(wire.low_um, std::min(range.high_um, wire.high_um));
  }
  return range;
}

void require_allowed(Remote& remote, std::int32_t target_um, const std::string& text, Units units) {
  const auto [low_um, high_um] = allowed_positions(remote);
  if (target_um < low_um || high_um < target_um) {
    throw files::UserError(fmt::format(
        "position {}: node {} allows {} to {}: 607Dh, limits.min_strain and limits.max_strain",
        text, remote.node(), position_text(static_cast<double>(low_um), units),
        position_text(static_cast<double>(high_um), units)));
  }
}

}  // namespace smaservo::can
