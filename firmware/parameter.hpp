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

#include "firmware/key.hpp"
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

/// One row. Ranges are inclusive and, as the default, values of `type`. A real whose default is NaN
/// has none: the device is not configured before it is set.
template <class S>
struct Parameter {
  Key key;
  Path path;  ///< table and name, with the SI unit as suffix
  ValueType type;
  Kind kind;                                  ///< of a real: its units
  std::span<const std::string_view> choices;  ///< of a choice: names by value
  Change change;
  Value least, standard, greatest;
  std::string_view meaning;
  Value (*read)(const Settings<S>&);
  void (*assign)(Settings<S>&, Value);
  bool (*used)(const Settings<S>&);  ///< whether it has a meaning with the others; nullptr: always

  constexpr Value get(const Settings<S>& settings) const { return read(settings); }
  /// A real may be anything; a choice must be one.
  constexpr void set(Settings<S>& settings, Value value) const { assign(settings, value); }
  constexpr bool is_used(const Settings<S>& settings) const {
    return used == nullptr || used(settings);
  }
  constexpr bool has_default() const {
    return type != ValueType::real || standard.real() == standard.real();
  }
};

// How a row reaches its member: through pointers to members, from Settings<S> down.

template <class S, auto... members>
struct Member {
  using Scalar = S;
  using Type = std::remove_cvref_t<decltype((std::declval<Settings<S>&>().*....*members))>;
  static Type get(const Settings<S>& s) { return (s.*....*members); }
  static void set(Settings<S>& s, const Type& value) { (s.*....*members) = value; }
};

/// The i-th coefficient of a surface's polynomial.
template <class S, auto surface, auto polynomial, std::size_t i>
struct Coefficient {
  using Scalar = S;
  using Type = S;
  static S get(const Settings<S>& s) { return (s.wire.kinetics.*surface.*polynomial)[i]; }
  static void set(Settings<S>& s, const S& value) {
    (s.wire.kinetics.*surface.*polynomial)[i] = value;
  }
};

/// The same of one of the two surfaces that stand side by side.
template <class S, int lane, auto polynomial, std::size_t i>
struct LaneCoefficient {
  using Scalar = S;
  using Type = S;
  static S get(const Settings<S>& s) {
    const Pair<S>& both = (s.wire.kinetics.a2m_a2r.*polynomial)[i];
    return lane == 0 ? both.first() : both.second();
  }
  static void set(Settings<S>& s, const S& value) {
    Pair<S>& both = (s.wire.kinetics.a2m_a2r.*polynomial)[i];
    both = lane == 0 ? Pair<S>(value, both.second()) : Pair<S>(both.first(), value);
  }
};

inline constexpr float no_default = std::numeric_limits<float>::quiet_NaN();

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> real(Key key, Path path, Kind kind, Change change, float least,
                            float standard, float greatest, std::string_view meaning,
                            bool (*used)(const Settings<S>&) = nullptr) {
  return {key,
          path,
          ValueType::real,
          kind,
          {},
          change,
          Value::real(least),
          Value::real(standard),
          Value::real(greatest),
          meaning,
          [](const Settings<S>& s) { return Value::real(static_cast<float>(Access::get(s))); },
          [](Settings<S>& s, Value value) { Access::set(s, S(value.real())); },
          used};
}

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> number(Key key, Path path, Change change, std::uint32_t least,
                              std::uint32_t standard, std::uint32_t greatest,
                              std::string_view meaning) {
  return {key,
          path,
          ValueType::number,
          kind::number,
          {},
          change,
          Value::number(least),
          Value::number(standard),
          Value::number(greatest),
          meaning,
          [](const Settings<S>& s) { return Value::number(Access::get(s)); },
          [](Settings<S>& s, Value value) { Access::set(s, value.number()); },
          nullptr};
}

/// `choices` names the enumerators, from 0 on.
template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> choice(Key key, Path path, std::span<const std::string_view> choices,
                              Change change, typename Access::Type standard,
                              std::string_view meaning) {
  return {key,
          path,
          ValueType::choice,
          kind::number,
          choices,
          change,
          Value::number(0),
          Value::number(static_cast<std::uint32_t>(standard)),
          Value::number(static_cast<std::uint32_t>(choices.size() - 1)),
          meaning,
          [](const Settings<S>& s) {
            return Value::number(static_cast<std::uint32_t>(Access::get(s)));
          },
          [](Settings<S>& s, Value value) {
            Access::set(s, static_cast<typename Access::Type>(value.number()));
          },
          nullptr};
}

template <class Access, class S = typename Access::Scalar>
constexpr Parameter<S> boolean(Key key, Path path, Change change, bool standard,
                               std::string_view meaning) {
  return {key,
          path,
          ValueType::boolean,
          kind::number,
          {},
          change,
          Value::number(0),
          Value::number(standard ? 1 : 0),
          Value::number(1),
          meaning,
          [](const Settings<S>& s) { return Value::number(Access::get(s) ? 1 : 0); },
          [](Settings<S>& s, Value value) { Access::set(s, value.number() != 0); },
          nullptr};
}

}  // namespace smaservo
