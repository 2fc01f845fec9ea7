#pragma once
// Functions on mantissas in integer arithmetic, for fixed.hpp and scaled.hpp.

#include <bit>
#include <cstdint>

namespace smaservo::integer_math {

/// value/2^bits, rounded to the nearest, a tie upwards. bits 0..62
constexpr std::int64_t rounded_shift(std::int64_t value, int bits) {
  return bits == 0 ? value : ((value >> (bits - 1)) + 1) >> 1;
}

/// The square root to the nearest, for x < 2^62. Cost: 9 products, no division, no loop.
constexpr std::uint32_t root(std::uint64_t x) {
  if (x == 0) {
    return 0;
  }
  // 2^60 <= normal < 2^62
  const int shift = (std::countl_zero(x) - 2) & ~1;
  const auto normal = static_cast<std::int64_t>(x << shift);
  const auto a = static_cast<std::uint64_t>(normal >> 30);
  // y ~ 1/sqrt(a/2^32) in 1..2, with 30 bits behind the point: a parabola good to 2.4 % and
  // Newton's y <- y (3 - a y²)/2 three times.
  const auto high = [](std::uint64_t p, std::uint64_t q) { return p * q >> 32U; };
  std::uint64_t y = 2'867'787'662U - high(3'527'624'778U - high(1'759'398'817U, a), a);
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t ayy = high(a, high(y, y));
    y = y * ((3ULL << 28U) - ayy) >> 29U;
  }
  auto r = static_cast<std::int64_t>(a * y >> 31U);
  r += (normal - r * r) * static_cast<std::int64_t>(y >> 8U) >> 54U;
  // The root is off by one at most.
  if (r * r > normal) {
    --r;
  } else if (normal - r * r > 2 * r) {
    ++r;
  }
  const int down = shift / 2;
  const auto whole = static_cast<std::uint64_t>(r) >> down;
  return static_cast<std::uint32_t>(x - whole * whole > whole ? whole + 1 : whole);
}

/// n 2^30/d, or half of it if that is not less than 2^30: rounded to the nearest, at least 2^29.
/// For n and d in 2^29..2^30 - 1. Cost: one division of 32 bits, 4 products.
struct Quotient {
  std::uint32_t mantissa;
  bool halved;
};
constexpr Quotient quotient(std::uint32_t n, std::uint32_t d) {
  // 2^60/d, good to 15 bits, and one Newton step, whose result is never too great.
  const std::uint32_t rough = (0xffff'ffffU / (d >> 14U)) << 14U;
  const auto missing =
      static_cast<std::int64_t>((std::uint64_t{1} << 60U) - static_cast<std::uint64_t>(rough) * d);
  const auto share = static_cast<std::int32_t>(missing >> 28);
  const auto more = static_cast<std::int32_t>(std::int64_t{share} * rough >> 32);
  const std::uint32_t reciprocal = rough + static_cast<std::uint32_t>(more);
  const bool halved = d <= n;
  const std::uint64_t wide = static_cast<std::uint64_t>(n) * reciprocal;
  auto q = static_cast<std::uint32_t>(halved ? wide >> 31U : wide >> 30U);
  // The remainder is less than 4 d.
  std::uint32_t rest = (halved ? n << 29U : n << 30U) - q * d;
  while (d <= rest) {
    rest -= d;
    ++q;
  }
  return {d <= rest + rest ? q + 1 : q, halved};
}

/// mantissa 2^exponent
struct Power {
  std::uint32_t mantissa;  ///< 2^29..2^30 - 1
  int exponent;
};

/// 2^x for x with 32 bits behind the point. Relative error: 2e-9.
constexpr Power power_of_two(std::int64_t x) {
  constexpr std::int64_t one = std::int64_t{1} << 32;
  const std::int64_t whole = x >> 32;
  const std::int64_t around = (x & (one - 1)) - one / 2;
  // Taylor around 1/2: sqrt(2) ln(2)^k/k!, with 30 bits behind the point
  constexpr std::int64_t terms[] = {1518500250, 1052544167, 364784011, 84283003, 14605131,
                                    2024701,    233903,     23161,     2007};
  std::int64_t sum = 0;
  for (int k = 8; k >= 0; --k) {
    sum = terms[k] + rounded_shift(sum * around, 32);
  }
  return {static_cast<std::uint32_t>(sum >> 1), static_cast<int>(whole) - 29};
}

/// Natural logarithm with 32 bits behind the point. Error: 1e-9.
constexpr std::int64_t logarithm(const Power& x) {
  constexpr std::int64_t ln_2 = 2977044472;
  constexpr std::int64_t root_2 = 759250125;  // sqrt(2) as a mantissa: times 2^29
  const bool upper = x.mantissa > root_2;
  const std::int64_t m = x.mantissa;
  const std::int64_t one = std::int64_t{1} << (upper ? 30 : 29);
  // ln m = 2 artanh((m - 1)/(m + 1)), of 1/sqrt(2)..sqrt(2)
  const std::int64_t s = ((m - one) << 32) / (m + one);
  const std::int64_t ss = s * s >> 32;
  std::int64_t sum = 0;
  for (int k = 11; k >= 1; k -= 2) {
    sum = (std::int64_t{1} << 32) / k + (sum * ss >> 32);
  }
  return (x.exponent + (upper ? 30 : 29)) * ln_2 + 2 * (sum * s >> 32);
}

/// 1/ln(2) with 30 bits behind the point
inline constexpr std::int64_t per_ln_2 = 1549082005;

}  // namespace smaservo::integer_math
