#pragma once
// The parameters of the wire: the rows of model/wire/wire_parameters.hpp with their keys. Reals
// have a default only where it means the model of paper 000: a device whose wire is not set is not
// configured.

#include "firmware/parameters/parameter.hpp"

namespace smaservo {

/// An object with the sub-indices 1 to `count`.
struct WireObject {
  std::uint16_t index;
  std::uint8_t count;
};
/// The objects in the order of the rows. The maker's limits are at 211Ch, the device's own limits
/// at 2020h.
inline constexpr auto wire_objects = std::to_array<WireObject>({{0x2110, 8},
                                                                {0x2111, 11},
                                                                {0x2112, 11},
                                                                {0x2113, 11},
                                                                {0x2114, 11},
                                                                {0x2115, 11},
                                                                {0x2116, 5},
                                                                {0x2117, 5},
                                                                {0x2118, 5},
                                                                {0x2119, 2},
                                                                {0x211A, 7},
                                                                {0x211B, 2},
                                                                {0x211C, 3}});

constexpr Key wire_key(std::size_t row) {
  std::size_t object = 0;
  while (row >= wire_objects[object].count) {
    row -= wire_objects[object++].count;
  }
  return {wire_objects[object].index, static_cast<std::uint8_t>(row + 1)};
}

namespace detail {

template <class S, std::size_t i>
const void* wire_member_at(const Settings<S>& settings) {
  constexpr auto at = wire_parameters<S>[i].at;
  return at(settings.wire);
}

template <class S, std::size_t i>
constexpr Parameter<S> wire_row() {
  constexpr const WireParameter<S>& w = wire_parameters<S>[i];
  const bool real = w.type == ValueType::real;
  const auto number = [](double x) { return Value::number(static_cast<std::uint32_t>(x)); };
  const std::size_t max = w.type == ValueType::choice ? w.choices.size() - 1 : 1;
  return {{wire_key(i), w.type, Change::without_current, Level::set_up, w.needs, w.lane,
           real ? Value::real(static_cast<float>(w.min)) : number(0),
           real ? Value::real(w.default_in_devices ? static_cast<float>(w.standard) : no_default)
           : w.type == ValueType::choice ? number(w.standard)
                                         : number(0),
           real ? Value::real(static_cast<float>(w.max)) : number(static_cast<double>(max)),
           wire_member_at<S, i>},
          w.path,
          real ? w.kind : kind::number,
          w.choices,
          w.meaning};
}

}  // namespace detail

template <class S>
constexpr auto wire_rows() {
  return []<std::size_t... i>(std::index_sequence<i...>) {
    return std::array<Parameter<S>, sizeof...(i)>{detail::wire_row<S, i>()...};
  }(std::make_index_sequence<wire_parameter_count>{});
}

}  // namespace smaservo
