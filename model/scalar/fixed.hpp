#pragma once
// A fixed-point number: a 32-bit integer that counts steps of 2^-fraction_bits. The format is in
// the type. For processors that have no floating point; FIXED.md says where it is used.

#include <bit>
#include <compare>
#include <cstdint>
#include <limits>

#include "model/scalar/integer_math.hpp"

namespace smaservo {

/// Range: -2^(31 - fraction_bits) up to one step below 2^(31 - fraction_bits). Every operation
/// rounds to the nearest step (a tie upwards) and saturates. A flag in the value records an
/// overflow and passes to every result computed from it; nothing is shared between computations. A
/// literal that does not fit is a compile error.
template <int fraction_bits>
class Fixed {
  static_assert(fraction_bits >= 0 && fraction_bits <= 30);

 public:
  static constexpr int fraction = fraction_bits;

  Fixed() = default;
  explicit consteval Fixed(double literal) : Fixed(of(literal)) {
    if (overflowed_) {
      literal_does_not_fit();
    }
  }
  explicit constexpr Fixed(int whole)
      : Fixed(within(static_cast<std::int64_t>(whole) * one, false)) {}
  /// Converts from another format.
  template <int from>
    requires(from != fraction_bits)
  explicit constexpr Fixed(const Fixed<from>& x)
      : Fixed(within(moved(x.raw(), from), x.overflowed())) {}

  /// Converts a number that is known only at run time; for edges, not for loops.
  static constexpr Fixed of(double x) {
    const double steps = x * static_cast<double>(one) + 0.5;
    if (!(steps < static_cast<double>(max) + 1 && static_cast<double>(min) <= steps)) {
      return Fixed(steps > 0 ? max : min, true);
    }
    const auto cut = static_cast<std::int32_t>(steps);
    return Fixed(static_cast<double>(cut) > steps ? cut - 1 : cut, false);
  }
  static constexpr Fixed of_raw(std::int32_t raw) { return Fixed(raw, false); }

  constexpr std::int32_t raw() const { return raw_; }
  constexpr bool overflowed() const { return overflowed_; }
  explicit constexpr operator double() const {
    return static_cast<double>(raw_) / static_cast<double>(one);
  }
  /// Rounds towards zero.
  explicit constexpr operator int() const { return static_cast<int>(raw_ / one); }

  friend constexpr Fixed operator+(const Fixed& a, const Fixed& b) {
    return within(std::int64_t{a.raw_} + b.raw_, either(a, b));
  }
  friend constexpr Fixed operator-(const Fixed& a, const Fixed& b) {
    return within(std::int64_t{a.raw_} - b.raw_, either(a, b));
  }
  friend constexpr Fixed operator-(const Fixed& a) { return Fixed(0) - a; }
  friend constexpr Fixed operator*(const Fixed& a, const Fixed& b) { return product(a, b); }
  friend constexpr Fixed operator/(const Fixed& a, const Fixed& b) { return quotient(a, b); }

  constexpr Fixed& operator+=(const Fixed& b) { return *this = *this + b; }
  constexpr Fixed& operator-=(const Fixed& b) { return *this = *this - b; }
  constexpr Fixed& operator*=(const Fixed& b) { return *this = *this * b; }
  constexpr Fixed& operator/=(const Fixed& b) { return *this = *this / b; }

  /// The product of two numbers of other formats, rounded once.
  template <int of_a, int of_b>
  static constexpr Fixed product(const Fixed<of_a>& a, const Fixed<of_b>& b) {
    return within(moved(std::int64_t{a.raw()} * b.raw(), of_a + of_b),
                  a.overflowed() || b.overflowed());
  }
  /// The quotient of two numbers of other formats. Division by zero saturates, also 0/0.
  template <int of_a, int of_b>
  static constexpr Fixed quotient(const Fixed<of_a>& a, const Fixed<of_b>& b) {
    constexpr int up = fraction_bits + of_b - of_a;
    static_assert(up >= 0 && up <= 32, "move the dividend first");
    if (b.raw() == 0) {
      return Fixed(a.raw() < 0 ? min : max, true);
    }
    const std::int64_t divisor = b.raw() < 0 ? -std::int64_t{b.raw()} : std::int64_t{b.raw()};
    const std::int64_t dividend =
        (b.raw() < 0 ? -std::int64_t{a.raw()} : std::int64_t{a.raw()}) * (std::int64_t{1} << up);
    // Rounded to the nearest, a tie upwards
    const std::int64_t twice = 2 * (dividend % divisor);
    const std::int64_t towards_zero = dividend / divisor;
    const std::int64_t nearest = twice >= divisor   ? towards_zero + 1
                                 : twice < -divisor ? towards_zero - 1
                                                    : towards_zero;
    return within(nearest, a.overflowed() || b.overflowed());
  }

  friend constexpr bool operator==(const Fixed& a, const Fixed& b) { return a.raw_ == b.raw_; }
  friend constexpr auto operator<=>(const Fixed& a, const Fixed& b) { return a.raw_ <=> b.raw_; }

  friend constexpr bool isfinite(const Fixed& x) { return !x.overflowed_; }
  friend constexpr Fixed abs(const Fixed& x) { return x.raw_ < 0 ? -x : x; }
  friend constexpr Fixed ceil(const Fixed& x) {
    const std::int64_t up = std::int64_t{x.raw_} + one - 1;
    return within(up - (up & (one - 1)), x.overflowed_);
  }
  /// The root of a negative number is 0 with the overflow flag. Exact to the last bit.
  friend constexpr Fixed sqrt(const Fixed& x) {
    if (x.raw_ < 0) {
      return Fixed(0, true);
    }
    const std::uint32_t root =
        integer_math::root(static_cast<std::uint64_t>(x.raw_) << fraction_bits);
    return within(root, x.overflowed_);
  }
  /// Relative error 2e-9 + 4e-10 |x|, and half a step.
  friend constexpr Fixed exp(const Fixed& x) {
    constexpr std::int64_t bound = 64 * one;
    const std::int64_t raw = x.raw_ < -bound ? -bound : bound < x.raw_ ? bound : x.raw_;
    return powered(moved(raw * integer_math::per_ln_2, fraction_bits + 30, 32), x.overflowed_);
  }
  /// Error 1e-9 plus half a step. For x <= 0 the result is the least number with the overflow flag.
  friend constexpr Fixed log(const Fixed& x) {
    if (x.raw_ <= 0) {
      return Fixed(min, true);
    }
    return within(moved(logarithm(x), 32), x.overflowed_);
  }
  /// For x > 0. Relative error 2e-8 (1 + |y|), and half a step.
  friend constexpr Fixed pow(const Fixed& x, const Fixed& y) {
    if (x.raw_ <= 0) {
      return Fixed(0, true);
    }
    // With 26 bits behind the point the products have 63 bits.
    const std::int64_t log_x = integer_math::rounded_shift(logarithm(x), 6);
    const std::int64_t log_power = moved(log_x * y.raw_, fraction_bits + 26, 26);
    constexpr std::int64_t bound = std::int64_t{64} << 26;
    const std::int64_t bounded = log_power < -bound  ? -bound
                                 : bound < log_power ? bound
                                                     : log_power;
    return powered(moved(bounded * integer_math::per_ln_2, 56, 32), either(x, y));
  }

 private:
  static void literal_does_not_fit();  // has no body, and is not constexpr

  static constexpr std::int64_t one = std::int64_t{1} << fraction_bits;
  static constexpr std::int32_t max = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int32_t min = std::numeric_limits<std::int32_t>::min();

  constexpr Fixed(std::int32_t raw, bool overflowed) : raw_(raw), overflowed_(overflowed) {}

  static constexpr bool either(const Fixed& a, const Fixed& b) {
    return a.overflowed_ || b.overflowed_;
  }
  static constexpr Fixed within(std::int64_t raw, bool overflowed) {
    if (raw > max) {
      return Fixed(max, true);
    }
    return raw < min ? Fixed(min, true) : Fixed(static_cast<std::int32_t>(raw), overflowed);
  }
  /// Converts from `from` fraction bits to `to`, by default those of this format.
  static constexpr std::int64_t moved(std::int64_t value, int from, int to = fraction_bits) {
    return to < from ? integer_math::rounded_shift(value, from - to)
                     : value * (std::int64_t{1} << (to - from));
  }
  /// 2^x, x with 32 bits behind the point
  static constexpr Fixed powered(std::int64_t x, bool overflowed) {
    const integer_math::Power power = integer_math::power_of_two(x);
    const int up = power.exponent + fraction_bits;
    if (up > 1) {
      return Fixed(max, true);
    }
    return within(moved(power.mantissa,
                        up < -40 ? 40
                        : up < 0 ? -up
                                 : 0,
                        up < 0 ? 0 : up),
                  overflowed);
  }
  static constexpr std::int64_t logarithm(const Fixed& x) {
    const int shift = std::countl_zero(static_cast<std::uint32_t>(x.raw_)) - 2;
    const auto raw = static_cast<std::uint32_t>(x.raw_);
    const std::uint32_t mantissa = shift < 0 ? raw >> 1U : raw << shift;
    return integer_math::logarithm({mantissa, -shift - fraction_bits});
  }

  std::int32_t raw_;
  bool overflowed_;
};

}  // namespace smaservo

template <int fraction_bits>
struct std::numeric_limits<smaservo::Fixed<fraction_bits>> {
  static constexpr bool is_specialized = true;
  static constexpr bool is_signed = true;
  static constexpr bool is_integer = false;
  static constexpr bool is_exact = false;
  static constexpr int radix = 2;
  static constexpr int digits = 31;
};
