#pragma once
// A fixed-point number whose point moves with it: a 30-bit mantissa and a power of two, both in
// integer registers. For processors that have no floating point, where the range is too wide for
// one Q format; FIXED.md lists these places. It has six more bits than a float, and on such
// processors it is cheaper: nothing is packed, and there are no denormal numbers.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "model/scalar/integer_math.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// Magnitudes 2^-200 to 2^200 with a relative error of 2^-30 in each operation (nearest, a tie
/// upwards); smaller magnitudes become zero. A result that is greater or undefined (x/0, the root
/// of a negative number) is not finite, and so is every result computed from it: the flag is part
/// of the value, nothing is shared between computations. As with NaN every comparison with it is
/// false. A literal that does not fit is a compile error.
class Scaled {
 public:
  Scaled() = default;
  explicit consteval Scaled(double literal) : Scaled(of(literal)) {
    if (!isfinite(*this)) {
      literal_does_not_fit();
    }
  }
  explicit constexpr Scaled(float x) : Scaled(of(x)) {}
  explicit constexpr Scaled(int whole)
      : Scaled(-2 * min_mantissa < whole && whole < 2 * min_mantissa
                   ? normal(whole, bias)
                   : normal((whole >> 2) + (whole >> 1 & 1), bias + 2)) {}

  /// Converts a number that is known only at run time. The conversion uses integer arithmetic only.
  static constexpr Scaled of(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto exponent = static_cast<int>(bits >> 52U & 0x7ffU);
    const auto mantissa = static_cast<std::int64_t>(bits & 0xf'ffff'ffff'ffffU) | 1LL << 52U;
    if (exponent == 0x7ff) {
      return invalid();
    }
    const auto rounded = static_cast<std::int32_t>(integer_math::rounded_shift(mantissa, 23));
    return exponent == 0
               ? zero()
               : carried(bits >> 63U != 0 ? -rounded : rounded, exponent - 1023 - 29 + bias);
  }
  static constexpr Scaled of(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const auto exponent = static_cast<int>(bits >> 23U & 0xffU);
    const auto mantissa = static_cast<std::int32_t>((bits & 0x7f'ffffU) | 1U << 23U) << 6;
    if (exponent == 0xff) {
      return invalid();
    }
    return exponent == 0
               ? zero()
               : carried(bits >> 31U != 0 ? -mantissa : mantissa, exponent - 127 - 29 + bias);
  }

  explicit constexpr operator double() const {
    if (!isfinite(*this)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const auto unit = static_cast<std::uint64_t>(power() + 1023) << 52U;
    return mantissa_ == 0 ? 0.0 : mantissa_ * std::bit_cast<double>(unit);
  }
  /// The value must be within the range of a float.
  explicit constexpr operator float() const {
    if (!isfinite(*this)) {
      return std::numeric_limits<float>::quiet_NaN();
    }
    const std::int32_t magnitude = mantissa_ < 0 ? -mantissa_ : mantissa_;
    const auto rounded = static_cast<std::uint32_t>(integer_math::rounded_shift(magnitude, 6));
    const int exponent = power() + 29 + 127;
    if (exponent < 1) {
      return 0.F;
    }
    // A mantissa that was rounded up to 2^24 carries into the exponent.
    const auto bits = (static_cast<std::uint32_t>(exponent - 1) << 23U) + rounded;
    return std::bit_cast<float>(mantissa_ < 0 ? bits | 1U << 31U : bits);
  }
  /// Rounds towards zero; |x| < 2^31.
  explicit constexpr operator int() const {
    const std::int32_t magnitude = mantissa_ < 0 ? -mantissa_ : mantissa_;
    const int whole = power() >= 0    ? magnitude << (power() & 1)
                      : power() < -30 ? 0
                                      : magnitude >> -power();
    return mantissa_ < 0 ? -whole : whole;
  }

  [[gnu::always_inline]] friend constexpr Scaled operator+(const Scaled& a, const Scaled& b) {
    return unpacked(sum(a.packed(), b.packed()));
  }
  [[gnu::always_inline]] friend constexpr Scaled operator-(const Scaled& a, const Scaled& b) {
    return a + -b;
  }
  [[gnu::always_inline]] friend constexpr Scaled operator-(const Scaled& a) {
    return {-a.mantissa_, a.exponent_};
  }
  [[gnu::always_inline]] friend constexpr Scaled operator*(const Scaled& a, const Scaled& b) {
    return unpacked(product(a.packed(), b.packed()));
  }
  [[gnu::always_inline]] friend constexpr Scaled operator/(const Scaled& a, const Scaled& b) {
    return unpacked(ratio(a.packed(), b.packed()));
  }

  // Up to eight terms are added at the exponent of the greatest one and normalised once. Error per
  // term, relative to the greatest term: 2^-27; half of that for up to four terms and a quarter for
  // two.
  template <class... More>
  [[gnu::always_inline]] static constexpr Scaled add_products(const Scaled& start,
                                                              const Product<Scaled>& first,
                                                              const More&... more) {
    static_assert(sizeof...(more) <= 6);
    constexpr int spare = spare_bits(sizeof...(more) + 2);
    Sum sum{start.mantissa_ >> spare, start.exponent_ + spare};
    sum.add<spare>(first);
    (sum.add<spare>(more), ...);
    return unpacked(rounded(Scaled(sum.mantissa, sum.exponent).packed()));
  }
  template <class... More>
  [[gnu::always_inline]] static constexpr Scaled add_products(const Product<Scaled>& first,
                                                              const Product<Scaled>& second,
                                                              const More&... more) {
    static_assert(sizeof...(more) <= 6);
    constexpr int spare = spare_bits(sizeof...(more) + 2);
    Sum sum{0, 0};
    sum.add<spare>(first);
    sum.add<spare>(second);
    (sum.add<spare>(more), ...);
    return unpacked(rounded(Scaled(sum.mantissa, sum.exponent).packed()));
  }

  constexpr Scaled& operator+=(const Scaled& b) { return *this = *this + b; }
  constexpr Scaled& operator-=(const Scaled& b) { return *this = *this - b; }
  constexpr Scaled& operator*=(const Scaled& b) { return *this = *this * b; }
  constexpr Scaled& operator/=(const Scaled& b) { return *this = *this / b; }

  friend constexpr bool operator==(const Scaled& a, const Scaled& b) {
    return a.mantissa_ == b.mantissa_ && a.exponent_ == b.exponent_ && isfinite(a);
  }
  friend constexpr bool operator<(const Scaled& a, const Scaled& b) {
    if ((a.mantissa_ ^ b.mantissa_) < 0) {
      return a.mantissa_ < 0 && isfinite(b);
    }
    if (a.exponent_ == b.exponent_) {
      return a.mantissa_ < b.mantissa_;
    }
    return a.mantissa_ < 0 ? b.exponent_ < a.exponent_ : a.exponent_ < b.exponent_ && isfinite(b);
  }
  friend constexpr bool operator>(const Scaled& a, const Scaled& b) { return b < a; }
  friend constexpr bool operator<=(const Scaled& a, const Scaled& b) { return a < b || a == b; }
  friend constexpr bool operator>=(const Scaled& a, const Scaled& b) { return b <= a; }

  friend constexpr bool isfinite(const Scaled& x) { return x.exponent_ <= max_exponent; }
  friend constexpr Scaled abs(const Scaled& x) { return x.mantissa_ < 0 ? -x : x; }
  friend constexpr Scaled ceil(const Scaled& x) {
    if (x.power() >= 0) {
      return x;
    }
    const int down = x.power() < -31 ? 31 : -x.power();
    const std::int64_t up = std::int64_t{x.mantissa_} + (std::int64_t{1} << down) - 1;
    return normal(static_cast<std::int32_t>(up >> down), bias);
  }
  friend constexpr Scaled sqrt(const Scaled& x) {
    if (x.mantissa_ < 0 || !isfinite(x)) {
      return invalid();
    }
    // An even power of two remains: 2^59 <= radicand < 2^61
    const auto mantissa = static_cast<std::uint64_t>(x.mantissa_);
    const int odd = x.power() & 1;
    const std::uint32_t root = integer_math::root(mantissa << (30 + odd));
    return x.mantissa_ == 0
               ? x
               : normal(static_cast<std::int32_t>(root), (x.power() - odd) / 2 - 15 + bias);
  }
  /// Relative error 2e-9 (1 + |x|).
  friend constexpr Scaled exp(const Scaled& x) {
    constexpr int max = 8 - 30;  // |x| < 2^8
    if (!isfinite(x) || (x.power() > max && x.mantissa_ > 0)) {
      return invalid();
    }
    if (x.power() > max) {
      return zero();
    }
    const std::int64_t octaves = std::int64_t{x.mantissa_} * integer_math::per_ln_2;
    const int down = -x.power() - 2;
    const auto power =
        integer_math::power_of_two(integer_math::rounded_shift(octaves, down < 62 ? down : 62));
    return carried(static_cast<std::int32_t>(power.mantissa), power.exponent + bias);
  }
  /// For x > 0. Absolute error 1e-9 (1 + |log x|).
  friend constexpr Scaled log(const Scaled& x) {
    if (x.mantissa_ <= 0 || !isfinite(x)) {
      return invalid();
    }
    const std::int64_t log_x =
        integer_math::logarithm({static_cast<std::uint32_t>(x.mantissa_), x.power()});
    const std::int64_t size = log_x < 0 ? -log_x : log_x;
    const int used = 64 - std::countl_zero(static_cast<std::uint64_t>(size));
    const int down = used > 30 ? used - 30 : 0;
    return normal(static_cast<std::int32_t>(integer_math::rounded_shift(log_x, down)),
                  down - 32 + bias);
  }
  /// For x > 0. Relative error 1e-7 (1 + |y log x|).
  friend constexpr Scaled pow(const Scaled& x, const Scaled& y) { return exp(y * log(x)); }
  friend constexpr Scaled cosh(const Scaled& x) { return (exp(x) + exp(-x)) / Scaled(2); }

 private:
  static void literal_does_not_fit();  // has no body, and is not constexpr

  // Zero is all bits zero, like a State{}. Zero and the value that is not finite have exponents so
  // far from those of every number that sum() returns the term with the greater one.
  static constexpr std::int32_t bias = 1 << 10;
  static constexpr std::int32_t invalid_exponent = 1 << 20;
  static constexpr std::int32_t max_exponent = bias + 200 - 30;
  static constexpr std::int32_t min_exponent = bias - 200 - 29;
  static constexpr std::int32_t min_mantissa = 1 << 29;

  constexpr Scaled(std::int32_t mantissa, std::int32_t exponent)
      : mantissa_(mantissa), exponent_(exponent) {}

  static constexpr Scaled zero() { return {0, 0}; }
  static constexpr Scaled invalid() { return {0, invalid_exponent}; }
  constexpr int power() const { return exponent_ - bias; }

  /// |mantissa| 2^29 to 2^31 - 3, exponent anything.
  static constexpr Scaled carried(std::int32_t mantissa, std::int32_t exponent) {
    constexpr std::uint32_t max = 2 * min_mantissa - 1;
    const bool carry = static_cast<std::uint32_t>(mantissa) + max > 2 * max;
    if (carry) {
      mantissa = (mantissa + 1) >> 1;
      ++exponent;
    }
    constexpr auto range = static_cast<std::uint32_t>(max_exponent - min_exponent);
    if (static_cast<std::uint32_t>(exponent - min_exponent) <= range) {
      return {mantissa, exponent};
    }
    return exponent < min_exponent ? zero() : invalid();
  }
  /// |mantissa| <= 2^31 - 2, exponent no more than 30 beyond the range, or invalid.
  static constexpr Scaled normal(std::int32_t mantissa, std::int32_t exponent) {
    if (mantissa == 0) {
      return exponent <= max_exponent ? zero() : invalid();
    }
    const auto magnitude = static_cast<std::uint32_t>(mantissa < 0 ? -mantissa : mantissa);
    const int up = std::countl_zero(magnitude) - 2;
    return up < 0 ? Scaled((mantissa + 1) >> 1, exponent + 1)
                  : Scaled(mantissa * (1 << up), exponent - up);
  }

  /// The number of low bits to drop so that a sum of this many terms stays below 2^31.
  static constexpr int spare_bits(std::size_t terms) { return terms <= 2 ? 0 : terms <= 4 ? 1 : 2; }
  struct Sum {
    std::int32_t mantissa, exponent;

    template <int spare>
    [[gnu::always_inline]] constexpr void add(const Product<Scaled>& term) {
      constexpr std::int64_t half = std::int64_t{1} << (29 + spare);
      const auto m = static_cast<std::int32_t>(
          (std::int64_t{term.a.mantissa_} * term.b.mantissa_ + half) >> (30 + spare));
      const std::int32_t e = term.a.exponent_ + term.b.exponent_ + 30 + spare - bias;
      const std::int32_t down = exponent - e;
      if (0 <= down) {
        mantissa += down > 30 ? 0 : ((m * 2 >> down) + 1) >> 1;
      } else {
        mantissa = (down < -31 ? 0 : ((mantissa >> (-down - 1)) + 1) >> 1) + m;
        exponent = e;
      }
    }
  };

  /// Packed into a pair of registers: a class of this size would be passed in memory.
  using Packed = std::uint64_t;
  constexpr Packed packed() const {
    return static_cast<std::uint32_t>(mantissa_) |
           static_cast<Packed>(static_cast<std::uint32_t>(exponent_)) << 32U;
  }
  static constexpr Scaled unpacked(Packed x) {
    return {static_cast<std::int32_t>(static_cast<std::uint32_t>(x)),
            static_cast<std::int32_t>(static_cast<std::uint32_t>(x >> 32U))};
  }

  // Not inlined, because a filter has a thousand sums.
  [[gnu::noinline]] static constexpr Packed sum(Packed x, Packed y) {
    const Scaled a = unpacked(x);
    const Scaled b = unpacked(y);
    std::int32_t great = a.mantissa_;
    std::int32_t small = b.mantissa_;
    std::int32_t exponent = a.exponent_;
    std::int32_t down = a.exponent_ - b.exponent_;
    if (down < 0) {
      great = b.mantissa_;
      small = a.mantissa_;
      exponent = b.exponent_;
      down = -down;
    }
    if (down > 30) {
      return Scaled(great, exponent).packed();
    }
    return normal(great + (((small * 2 >> down) + 1) >> 1), exponent).packed();
  }
  [[gnu::noinline]] static constexpr Packed rounded(Packed x) {
    const Scaled sum = unpacked(x);
    const Scaled r = normal(sum.mantissa_, sum.exponent_);
    return carried(r.mantissa_, r.exponent_).packed();
  }
  [[gnu::noinline]] static constexpr Packed product(Packed x, Packed y) {
    const Scaled a = unpacked(x);
    const Scaled b = unpacked(y);
    const std::int64_t wide = std::int64_t{a.mantissa_} * b.mantissa_;
    return carried(static_cast<std::int32_t>((wide + (1 << 28)) >> 29),
                   a.exponent_ + b.exponent_ + 29 - bias)
        .packed();
  }
  [[gnu::noinline]] static constexpr Packed ratio(Packed x, Packed y) {
    const Scaled a = unpacked(x);
    const Scaled b = unpacked(y);
    if (!isfinite(a) || b.mantissa_ == 0) {
      return invalid().packed();
    }
    if (a.mantissa_ == 0) {
      return x;
    }
    const auto magnitude = [](std::int32_t m) {
      return static_cast<std::uint32_t>(m < 0 ? -m : m);
    };
    const integer_math::Quotient q =
        integer_math::quotient(magnitude(a.mantissa_), magnitude(b.mantissa_));
    const auto mantissa = static_cast<std::int32_t>(q.mantissa);
    return carried((a.mantissa_ ^ b.mantissa_) < 0 ? -mantissa : mantissa,
                   a.exponent_ - b.exponent_ - (q.halved ? 29 : 30) + bias)
        .packed();
  }

  std::int32_t mantissa_;  ///< 0 or of a magnitude of 2^29 to 2^30 - 1
  std::int32_t exponent_;  ///< exponent of two, plus bias
};

}  // namespace smaservo

template <>
struct std::numeric_limits<smaservo::Scaled> {
  static constexpr bool is_specialized = true;
  static constexpr bool is_signed = true;
  static constexpr bool is_integer = false;
  static constexpr bool is_exact = false;
  static constexpr int radix = 2;
  static constexpr int digits = 30;
  static constexpr bool has_quiet_NaN = true;
  static constexpr smaservo::Scaled quiet_NaN() noexcept {
    return smaservo::Scaled::of(std::numeric_limits<float>::quiet_NaN());
  }
};
