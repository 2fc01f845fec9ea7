#pragma once
// Every parameter of a device, described once, without heap: key, path with its unit, range,
// default, when it may change, meaning. Defaults, checks, files, the store, CAN and PARAMETERS.md
// come from this table. Rows stand in the order of their keys; a new parameter is one more row.
//
// There is one table for float and one for double settings; all values can be represented as a
// float. A key never changes its meaning: if a parameter is removed or gets another unit, its key
// stays unused (schemas.hpp).

#include <algorithm>

#include "firmware/parameters/parameters_device.hpp"
#include "firmware/parameters/parameters_wire.hpp"

namespace smaservo {

template <class S>
inline constexpr auto parameters = joined(
    identity_rows<S>(), timing_rows<S>(), measuring_rows<S>(), observer_rows<S>(), limit_rows<S>(),
    trip_rows<S>(), safe_rows<S>(), axis_rows<S>(),
    loop_rows<S, &Settings<S>::strain>(0x2100, "strain", "W", kind::power, "", kind::number,
                                       {0, 0, 5e-5F}),
    drive_rows<S>(),
    loop_rows<S, &Settings<S>::temperature>(0x2103, "temperature", "W_K", kind::power_per_kelvin,
                                            "_K", kind::temperature_difference, {0.05F, 1, 0}),
    loop_rows<S, &Settings<S>::resistance>(0x2104, "resistance", "W_ohm", kind::power_per_ohm,
                                           "_ohm", kind::resistance, {1, 1, 0}),
    loop_rows<S, &Settings<S>::force>(0x2105, "force", "W_N", kind::power_per_force, "_N",
                                      kind::force, {20, 1, 0}),
    trajectory_rows<S>(), profile_rows<S>(), wire_rows<S>());

inline constexpr std::size_t parameter_count = parameters<float>.size();

/// The rows without their texts, for which a device has no memory.
template <class S>
inline constexpr auto parameter_rows = [] {
  std::array<ParameterRow<S>, parameter_count> rows{};
  std::ranges::copy(parameters<S>, rows.begin());
  return rows;
}();
inline constexpr std::size_t no_parameter = parameter_count;

/// The row of a key in rows that are sorted by their keys; nullptr if there is none.
template <class S>
constexpr const ParameterRow<S>* find_row(std::span<const ParameterRow<S>> rows, Key key) {
  while (!rows.empty()) {
    const std::size_t middle = rows.size() / 2;
    if (rows[middle].key == key) {
      return &rows[middle];
    }
    rows = rows[middle].key < key ? rows.subspan(middle + 1) : rows.first(middle);
  }
  return nullptr;
}

/// Row of a key or a path; no_parameter if there is none.
constexpr std::size_t find_parameter(Key key) {
  const ParameterRow<float>* row = find_row<float>(parameter_rows<float>, key);
  return row == nullptr ? no_parameter
                        : static_cast<std::size_t>(row - parameter_rows<float>.data());
}
constexpr std::size_t find_parameter(std::string_view path) {
  for (std::size_t i = 0; i < parameter_count; ++i) {
    if (parameters<float>[i].path.text() == path) {
      return i;
    }
  }
  return no_parameter;
}

/// Settings with every default; the numbers of the wire are NaN, which means not configured.
template <class S>
Settings<S> default_settings() {
  Settings<S> settings{};
  for (const ParameterRow<S>& row : parameter_rows<S>) {
    row.set(settings, row.standard);
  }
  return settings;
}

/// The same settings in another scalar, or rounded to float as the store and CAN have them. A
/// parameter that is not used with these settings gets its default.
template <class To, class From>
Settings<To> stored_settings(const Settings<From>& settings) {
  Settings<To> to{};
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const ParameterRow<From>& row = parameter_rows<From>[i];
    parameter_rows<To>[i].set(to, row.is_used(settings) ? row.get(settings) : row.standard);
  }
  return to;
}

/// Whether both use the same parameters, with the same bits.
template <class S>
bool same_settings(const Settings<S>& a, const Settings<S>& b) {
  return std::ranges::all_of(parameter_rows<S>, [&](const ParameterRow<S>& row) {
    return row.is_used(a) == row.is_used(b) && (!row.is_used(a) || row.get(a) == row.get(b));
  });
}

/// The position of a value relative to the range of its row.
enum class Fit : std::uint8_t { inside, not_finite, below, above };

template <class S>
constexpr Fit fit(const ParameterRow<S>& row, Value value) {
  if (row.type != ValueType::real) {
    return value.number() < row.min.number()   ? Fit::below
           : row.max.number() < value.number() ? Fit::above
                                               : Fit::inside;
  }
  const float x = value.real();
  if (!is_finite(x)) {
    return Fit::not_finite;
  }
  return x < row.min.real() ? Fit::below : row.max.real() < x ? Fit::above : Fit::inside;
}

namespace detail {

constexpr bool in_order_of_keys() {
  for (std::size_t i = 1; i < parameter_count; ++i) {
    if (!(parameters<float>[i - 1].key < parameters<float>[i].key)) {
      return false;
    }
  }
  return parameters<float>[0].key.index >= 0x2000 &&
         parameters<float>[parameter_count - 1].key.index <= 0x5FFF;
}

constexpr bool paths_are_unique() {
  for (std::size_t i = 0; i < parameter_count; ++i) {
    if (find_parameter(parameters<float>[i].path.text()) != i) {
      return false;
    }
  }
  return true;
}

constexpr bool defaults_are_in_range() {
  return std::ranges::all_of(parameters<float>, [](const Parameter<float>& row) {
    const bool ordered = row.type == ValueType::real ? row.min.real() < row.max.real()
                                                     : row.min.number() < row.max.number();
    return ordered && (!row.has_default() || fit(row, row.standard) == Fit::inside);
  });
}

constexpr bool ends_in_unit(std::string_view path, const Parameter<float>& row) {
  const std::string_view unit = row.kind.front().suffix;
  return path.ends_with(unit) && path[path.size() - unit.size() - 1] == '_';
}

/// A path ends in the unit of its kind; a path of a kind without unit ends in no unit at all.
constexpr bool units_stand_in_paths() {
  for (const Parameter<float>& row : parameters<float>) {
    const bool has_unit = !row.kind.front().suffix.empty();
    if (has_unit && !ends_in_unit(row.path.text(), row)) {
      return false;
    }
    for (const Parameter<float>& other : parameters<float>) {
      if (!has_unit && !other.kind.front().suffix.empty() && ends_in_unit(row.path.text(), other)) {
        return false;
      }
    }
  }
  return true;
}

static_assert(in_order_of_keys(), "keys rise from 2000h to 5FFFh, each stands once");
static_assert(paths_are_unique());
static_assert(defaults_are_in_range(), "min <= default <= max");
static_assert(units_stand_in_paths());

}  // namespace detail

}  // namespace smaservo
