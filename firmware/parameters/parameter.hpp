#pragma once
// The type of a row of the parameter table, and functions that make rows. parameters.hpp has the
// rows.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "firmware/parameters/key.hpp"
#include "firmware/settings.hpp"
#include "model/wire/wire_parameters.hpp"

namespace smaservo {

/// When a change takes effect.
enum class Change : std::uint8_t {
  live,             ///< takes effect in the next step
  without_current,  ///< takes effect in the next step, but is refused while the device is enabled
  after_reset,      ///< stored, and takes effect after the next start
};

/// 32 bits as stored and sent: a float, or an unsigned number.
struct Value {
  std::uint32_t bits;

  static constexpr Value real(float value) { return {std::bit_cast<std::uint32_t>(value)}; }
  static constexpr Value number(std::uint32_t value) { return {value}; }
  constexpr float real() const { return std::bit_cast<float>(bits); }
  constexpr std::uint32_t number() const { return bits; }

  friend constexpr bool operator==(const Value&, const Value&) = default;
};

/// Like std::isfinite, which is not constexpr before C++23.
constexpr bool is_finite(float x) {
  constexpr float max = std::numeric_limits<float>::max();
  return -max <= x && x <= max;
}

/// The part of a row that a device needs. `min`, `standard` (the default) and `max` are values of
/// `type`; the range is inclusive. A real whose `standard` is NaN has no default: the device is not
/// configured before it is set.
template <class S>
struct ParameterRow {
  Key key;
  ValueType type;
  Change change;
  Level level;
  Needs needs;
  Lane lane;
  Value min, standard, max;
  /// Address of the member, for load_real() and load_whole().
  const void* (*at)(const Settings<S>&);

  Value get(const Settings<S>& settings) const {
    const void* from = at(settings);
    return type == ValueType::real ? Value::real(static_cast<float>(load_real<S>(from, lane)))
                                   : Value::number(load_whole(from, type));
  }
  /// Sets the value without a check: a real may be any value, but a choice must be one of its
  /// values.
  void set(Settings<S>& settings, Value value) const {
    void* to = const_cast<void*>(at(settings));  // NOLINT(*-const-cast)
    if (type == ValueType::real) {
      keep_real(to, lane, S(value.real()));
    } else {
      keep_whole(to, type, value.number());
    }
  }
  constexpr bool is_used(const Settings<S>& settings) const {
    return smaservo::is_used(needs, settings.wire);
  }
  constexpr bool has_default() const {
    return type != ValueType::real || standard.real() == standard.real();
  }
};

/// A row with its texts.
template <class S>
struct Parameter : ParameterRow<S> {
  Path path;                                  ///< table and name, with the SI unit as suffix
  Kind kind;                                  ///< unit kind of a real
  std::span<const std::string_view> choices;  ///< names of a choice, by value
  std::string_view meaning;
};

/// A row's access to its member: through pointers to members, from Settings<S> down.
template <class S, auto... members>
struct Member {
  using Scalar = S;
  using Type = std::remove_cvref_t<decltype((std::declval<Settings<S>&>().*....*members))>;
  static const void* at(const Settings<S>& s) { return &(s.*....*members); }
};

/// A parameter that may change while the device is enabled is for tuning, unless set_up() sets
/// another level for its group.
constexpr Level level_of(Change change) {
  return change == Change::live ? Level::tune : Level::set_up;
}

/// The same rows with Level::set_up, because they bound heat or motion.
template <class S, std::size_t n>
constexpr std::array<Parameter<S>, n> set_up(std::array<Parameter<S>, n> rows) {
  for (Parameter<S>& row : rows) {
    row.level = Level::set_up;
  }
  return rows;
}

inline constexpr float no_default = std::numeric_limits<float>::quiet_NaN();

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> real(Key key, Path path, Kind kind, Change change, float min, float standard,
                            float max, std::string_view meaning) {
  static_assert(std::is_same_v<typename Access::Type, S>);
  return {{key, ValueType::real, change, level_of(change), Needs::nothing, Lane::none,
           Value::real(min), Value::real(standard), Value::real(max), Access::at},
          path,
          kind,
          {},
          meaning};
}

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> number(Key key, Path path, Change change, std::uint32_t min,
                              std::uint32_t standard, std::uint32_t max, std::string_view meaning) {
  static_assert(std::is_same_v<typename Access::Type, std::uint32_t>);
  return {{key, ValueType::number, change, level_of(change), Needs::nothing, Lane::none,
           Value::number(min), Value::number(standard), Value::number(max), Access::at},
          path,
          kind::number,
          {},
          meaning};
}

/// `choices` names the enumerators, beginning with 0.
template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> choice(Key key, Path path, std::span<const std::string_view> choices,
                              Change change, typename Access::Type standard,
                              std::string_view meaning) {
  static_assert(std::is_enum_v<typename Access::Type> && sizeof(typename Access::Type) == 1);
  return {{key, ValueType::choice, change, level_of(change), Needs::nothing, Lane::none,
           Value::number(0), Value::number(static_cast<std::uint32_t>(standard)),
           Value::number(static_cast<std::uint32_t>(choices.size() - 1)), Access::at},
          path,
          kind::number,
          choices,
          meaning};
}

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> boolean(Key key, Path path, Change change, bool standard,
                               std::string_view meaning) {
  static_assert(std::is_same_v<typename Access::Type, bool>);
  return {{key, ValueType::boolean, change, level_of(change), Needs::nothing, Lane::none,
           Value::number(0), Value::number(standard ? 1 : 0), Value::number(1), Access::at},
          path,
          kind::number,
          {},
          meaning};
}

}  // namespace smaservo
