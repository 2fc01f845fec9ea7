#pragma once
// What a row of the parameter table says, and how one is made. parameters.hpp has the rows.

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
#include "model/units.hpp"

namespace smaservo {

/// The numbers are those of the stored image: never change one.
enum class ValueType : std::uint8_t {
  real = 0,     ///< REAL32
  number = 1,   ///< UNSIGNED32
  choice = 2,   ///< UNSIGNED8, one of some names
  boolean = 3,  ///< BOOLEAN
};

/// When a change takes effect.
enum class Change : std::uint8_t {
  live,             ///< in the next step
  without_current,  ///< likewise, but refused while the device is enabled
  after_reset,      ///< stored, and in force after the next start
};

/// 32 bits as they are stored and sent: a float, or an unsigned number.
struct Value {
  std::uint32_t bits;

  static constexpr Value real(float value) { return {std::bit_cast<std::uint32_t>(value)}; }
  static constexpr Value number(std::uint32_t value) { return {value}; }
  constexpr float real() const { return std::bit_cast<float>(bits); }
  constexpr std::uint32_t number() const { return bits; }

  friend constexpr bool operator==(const Value&, const Value&) = default;
};

/// As std::isfinite, which no constant may call yet.
constexpr bool is_finite(float x) {
  constexpr float most = std::numeric_limits<float>::max();
  return -most <= x && x <= most;
}

/// A path made of up to three parts, such as "strain" + ".proportional_" + "W".
class Path {
 public:
  constexpr Path() = default;
  // NOLINTNEXTLINE(google-explicit-constructor)
  constexpr Path(const char* a, const char* b = "", const char* c = "") {
    for (const std::string_view part : {a, b, c}) {
      for (const char letter : part) {
        text_[size_++] = letter;  // Too long a path does not compile.
      }
    }
  }
  constexpr std::string_view text() const { return {text_.data(), size_}; }

 private:
  std::array<char, 48> text_{};
  std::size_t size_ = 0;
};

/// Without which a parameter has no meaning.
enum class Needs : std::uint8_t { nothing, own_r2a, own_r2m };

/// Where a real is part of a Pair.
enum class Lane : std::uint8_t { none, first, second };

/// What a device needs of a row. Ranges are inclusive and, as the default, values of `type`. A real
/// whose default is NaN has none: the device is not configured before it is set.
template <class S>
struct ParameterRow {
  Key key;
  ValueType type;
  Change change;
  Needs needs;
  Lane lane;
  Value least, standard, greatest;
  /// An S or a Pair<S>, an unsigned number of 32 bits, an enumerator of 8, a bool.
  const void* (*at)(const Settings<S>&);

  Value get(const Settings<S>& settings) const {
    const void* from = at(settings);
    switch (type) {
      case ValueType::real:
        return Value::real(static_cast<float>(load<S>(from)));
      case ValueType::number:
        return Value::number(*static_cast<const std::uint32_t*>(from));
      case ValueType::choice:
        return Value::number(*static_cast<const std::uint8_t*>(from));
      case ValueType::boolean:
        break;
    }
    return Value::number(*static_cast<const bool*>(from) ? 1 : 0);
  }
  /// A real may be anything; a choice must be one.
  void set(Settings<S>& settings, Value value) const {
    void* to = const_cast<void*>(at(settings));  // NOLINT(*-const-cast)
    switch (type) {
      case ValueType::real:
        keep(to, S(value.real()));
        break;
      case ValueType::number:
        *static_cast<std::uint32_t*>(to) = value.number();
        break;
      case ValueType::choice:
        *static_cast<std::uint8_t*>(to) = static_cast<std::uint8_t>(value.number());
        break;
      case ValueType::boolean:
        *static_cast<bool*>(to) = value.number() != 0;
        break;
    }
  }
  constexpr bool is_used(const Settings<S>& settings) const {
    const ThreePhaseParams<S>& p = settings.wire.kinetics;
    return needs == Needs::nothing || (needs == Needs::own_r2a ? p.separate_r2a : p.separate_r2m);
  }
  constexpr bool has_default() const {
    return type != ValueType::real || standard.real() == standard.real();
  }

 private:
  template <class T>
  T load(const void* from) const {
    if (lane == Lane::none) {
      return *static_cast<const T*>(from);
    }
    const Pair<T>& both = *static_cast<const Pair<T>*>(from);
    return lane == Lane::first ? both.first() : both.second();
  }
  template <class T>
  void keep(void* to, const T& value) const {
    if (lane == Lane::none) {
      *static_cast<T*>(to) = value;
      return;
    }
    Pair<T>& both = *static_cast<Pair<T>*>(to);
    both = lane == Lane::first ? Pair<T>(value, both.second()) : Pair<T>(both.first(), value);
  }
};

/// A row with its words.
template <class S>
struct Parameter : ParameterRow<S> {
  Path path;                                  ///< table and name, with the SI unit as suffix
  Kind kind;                                  ///< of a real: its units
  std::span<const std::string_view> choices;  ///< of a choice: names by value
  std::string_view meaning;
};

// How a row reaches its member: through pointers to members, from Settings<S> down.

template <class S, auto... members>
struct Member {
  using Scalar = S;
  using Type = std::remove_cvref_t<decltype((std::declval<Settings<S>&>().*....*members))>;
  static constexpr Lane lane = Lane::none;
  static const void* at(const Settings<S>& s) { return &(s.*....*members); }
};

/// The i-th coefficient of a surface's polynomial.
template <class S, auto surface, auto polynomial, std::size_t i>
struct Coefficient {
  using Scalar = S;
  using Type = S;
  static constexpr Lane lane = Lane::none;
  static const void* at(const Settings<S>& s) { return &(s.wire.kinetics.*surface.*polynomial)[i]; }
};

/// The same of one of the two surfaces that stand side by side.
template <class S, Lane which, auto polynomial, std::size_t i>
struct LaneCoefficient {
  using Scalar = S;
  using Type = S;
  static constexpr Lane lane = which;
  static const void* at(const Settings<S>& s) { return &(s.wire.kinetics.a2m_a2r.*polynomial)[i]; }
};

inline constexpr float no_default = std::numeric_limits<float>::quiet_NaN();

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> real(Key key, Path path, Kind kind, Change change, float least,
                            float standard, float greatest, std::string_view meaning,
                            Needs needs = Needs::nothing) {
  static_assert(std::is_same_v<typename Access::Type, S>);
  return {{key, ValueType::real, change, needs, Access::lane, Value::real(least),
           Value::real(standard), Value::real(greatest), Access::at},
          path,
          kind,
          {},
          meaning};
}

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> number(Key key, Path path, Change change, std::uint32_t least,
                              std::uint32_t standard, std::uint32_t greatest,
                              std::string_view meaning) {
  static_assert(std::is_same_v<typename Access::Type, std::uint32_t>);
  return {{key, ValueType::number, change, Needs::nothing, Access::lane, Value::number(least),
           Value::number(standard), Value::number(greatest), Access::at},
          path,
          kind::number,
          {},
          meaning};
}

/// `choices` names the enumerators, from 0 on.
template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> choice(Key key, Path path, std::span<const std::string_view> choices,
                              Change change, typename Access::Type standard,
                              std::string_view meaning) {
  static_assert(std::is_enum_v<typename Access::Type> && sizeof(typename Access::Type) == 1);
  return {{key, ValueType::choice, change, Needs::nothing, Access::lane, Value::number(0),
           Value::number(static_cast<std::uint32_t>(standard)),
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
  return {{key, ValueType::boolean, change, Needs::nothing, Access::lane, Value::number(0),
           Value::number(standard ? 1 : 0), Value::number(1), Access::at},
          path,
          kind::number,
          {},
          meaning};
}

}  // namespace smaservo
