#include "model/scalar/fixed.hpp"

#include <cmath>
#include <cstdint>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <type_traits>

namespace smaservo::fixed_test {
namespace {

constexpr int repeats = 200'000;

// A literal that does not fit does not compile.
template <int fraction, double x>
concept Fits = requires { typename std::bool_constant<(Fixed<fraction>(x), true)>; };
static_assert(Fits<30, 1.9> && !Fits<30, 2.0> && Fits<30, -2.0> && !Fits<30, -2.1>);
static_assert(Fits<0, 2147483647.0> && !Fits<0, 2147483648.0>);
static_assert(!Fits<24, std::numeric_limits<double>::quiet_NaN()>);
static_assert(Fixed<16>(0.5).raw() == 1 << 15 && Fixed<16>(-0.5).raw() == -(1 << 15));
static_assert(std::is_trivially_copyable_v<Fixed<16>>);

/// Any bits, and every magnitude as often as the others.
template <int fraction>
Fixed<fraction> any(std::mt19937_64& random) {
  const auto bits = static_cast<std::int32_t>(random());
  return Fixed<fraction>::of_raw(bits >> (random() % 31));
}

template <class Format>
class FixedTest : public testing::Test {
 protected:
  using X = Format;
  static constexpr int fraction = Format::fraction;
  static long double step() { return std::ldexp(1.0L, -fraction); }
  static long double value(const X& x) { return x.raw() * step(); }
  static long double max() { return 2147483647 * step(); }
  static long double min() { return -2147483648.0L * step(); }

  /// What an operation has to give whose exact result this is.
  static X nearest(long double exact) {
    const long double raw = std::floor(exact / step() + 0.5L);
    if (raw > 2147483647) {
      return X::of_raw(std::numeric_limits<std::int32_t>::max());
    }
    return raw < -2147483648.0L ? X::of_raw(std::numeric_limits<std::int32_t>::min())
                                : X::of_raw(static_cast<std::int32_t>(raw));
  }
  static bool fits(long double exact) {
    const long double raw = std::floor(exact / step() + 0.5L);
    return raw <= 2147483647 && raw >= -2147483648.0L;
  }
  static void expect_result(const X& x, long double exact) {
    ASSERT_EQ(x.raw(), nearest(exact).raw()) << static_cast<double>(exact);
    ASSERT_EQ(x.overflowed(), !fits(exact)) << static_cast<double>(exact);
  }
};

using Formats = testing::Types<Fixed<0>, Fixed<8>, Fixed<16>, Fixed<24>, Fixed<30>>;
TYPED_TEST_SUITE(FixedTest, Formats);

// A long double holds every exact result: 64 bits.
TYPED_TEST(FixedTest, ArithmeticIsTheNearestOrSaturatesAndSaysSo) {
  std::mt19937_64 random(1);
  for (int i = 0; i < repeats; ++i) {
    const TypeParam a = any<TypeParam::fraction>(random);
    const TypeParam b = any<TypeParam::fraction>(random);
    const long double x = this->value(a);
    const long double y = this->value(b);
    this->expect_result(a + b, x + y);
    this->expect_result(a - b, x - y);
    this->expect_result(a * b, x * y);
    this->expect_result(-a, -x);
    ASSERT_EQ(a < b, x < y);
    ASSERT_EQ(a == b, a.raw() == b.raw());
    if (b.raw() != 0) {
      const TypeParam quotient = a / b;
      // x/y itself is rounded in a long double: a neighbour's tie is no error.
      const long double error = this->value(quotient) - x / y;
      ASSERT_TRUE(quotient.overflowed() || std::abs(error) <= this->step() * (0.5L + 1e-9L));
      if (!this->fits(x / y)) {
        this->expect_result(quotient, x / y);
      }
    }
  }
}

TYPED_TEST(FixedTest, Algebra) {
  std::mt19937_64 random(2);
  const TypeParam zero(0);
  const TypeParam one(1);
  for (int i = 0; i < repeats; ++i) {
    const TypeParam a = any<TypeParam::fraction>(random);
    const TypeParam b = any<TypeParam::fraction>(random);
    ASSERT_EQ(a + b, b + a);
    ASSERT_EQ(a * b, b * a);
    ASSERT_EQ(a - a, zero);
    ASSERT_EQ(a + zero, a);
    ASSERT_EQ(a * one, a);
    ASSERT_EQ(a / one, a);
    if (a.raw() != 0) {
      ASSERT_EQ(a / a, one);
    }
    const TypeParam sum = a + b;
    if (!sum.overflowed()) {
      ASSERT_EQ(sum - b, a);
    }
  }
}

TYPED_TEST(FixedTest, MinusAndAssignmentsAreShortForTheLongForms) {
  std::mt19937_64 random(6);
  const auto same = [](const TypeParam& x, const TypeParam& y) {
    ASSERT_EQ(x.raw(), y.raw());
    ASSERT_EQ(x.overflowed(), y.overflowed());
  };
  const TypeParam min = TypeParam::of_raw(std::numeric_limits<std::int32_t>::min());
  const TypeParam max = TypeParam::of_raw(std::numeric_limits<std::int32_t>::max());
  const TypeParam extremes[] = {min,
                                max,
                                max + max,
                                TypeParam(0),
                                min + min,
                                -max,
                                TypeParam::of_raw(1),
                                TypeParam::of_raw(-1)};
  EXPECT_TRUE((-min).overflowed());
  EXPECT_EQ(-min, max);
  for (int i = 0; i < repeats; ++i) {
    const auto number = [&] {
      return random() % 4 == 0 ? extremes[random() % 8] : any<TypeParam::fraction>(random);
    };
    const TypeParam a = number();
    const TypeParam b = number();
    same(-a, TypeParam(0) - a);
    TypeParam x = a;
    same(x += b, a + b);
    same(x = a, a);
    same(x -= b, a - b);
    same(x = a, a);
    same(x *= b, a * b);
    same(x = a, a);
    same(x /= b, a / b);
    same(x = b, b);
    same(x += x, b + b);
  }
}

TYPED_TEST(FixedTest, WhatHasOverflowedStaysSo) {
  const TypeParam max = TypeParam::of_raw(std::numeric_limits<std::int32_t>::max());
  const TypeParam over = max + max;
  ASSERT_TRUE(over.overflowed());
  EXPECT_EQ(over, max);
  EXPECT_FALSE(isfinite(over));
  const TypeParam none(0);
  for (const TypeParam& result :
       {over + none, none - over, over * none, none / over, -over, abs(over), sqrt(over),
        exp(none * over), pow(max, over), ceil(over), log(over)}) {
    EXPECT_TRUE(result.overflowed());
  }
  EXPECT_TRUE(Fixed<12>(over).overflowed());
  EXPECT_TRUE(Fixed<20>(over).overflowed());
  // and nothing else: the next computation is a new one.
  EXPECT_FALSE((max - max).overflowed());
  EXPECT_TRUE((max / none).overflowed());
  EXPECT_TRUE((none / none).overflowed());
  EXPECT_TRUE(sqrt(TypeParam::of_raw(-1)).overflowed());
  EXPECT_TRUE(log(none).overflowed());
}

TYPED_TEST(FixedTest, NumbersOfTheRunRoundAndSaturate) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-40, 40);
  for (int i = 0; i < repeats; ++i) {
    const double x = (random() % 2 == 0 ? 1 : -1) * std::exp2(exponent(random));
    this->expect_result(TypeParam::of(x), static_cast<long double>(x));
    const TypeParam a = any<TypeParam::fraction>(random);
    ASSERT_EQ(TypeParam::of(static_cast<double>(a)), a);
    ASSERT_EQ(static_cast<int>(a), static_cast<int>(static_cast<double>(a)));
    const double up = std::ceil(static_cast<double>(a));
    if (this->fits(static_cast<long double>(up))) {
      ASSERT_EQ(static_cast<double>(ceil(a)), up);
    }
  }
  EXPECT_TRUE(TypeParam::of(std::numeric_limits<double>::quiet_NaN()).overflowed());
  EXPECT_TRUE(TypeParam::of(std::numeric_limits<double>::infinity()).overflowed());
  EXPECT_TRUE(TypeParam(std::numeric_limits<int>::max()).overflowed() == (TypeParam::fraction > 0));
}

TYPED_TEST(FixedTest, FunctionsAreThoseOfADouble) {
  std::mt19937_64 random(4);
  const double step = std::ldexp(1.0, -TypeParam::fraction);
  const auto expect = [&](const TypeParam& result, double exact, double error) {
    if (!result.overflowed()) {
      ASSERT_NEAR(static_cast<double>(result), exact, 0.5001 * step + error);
    } else {
      ASSERT_GE(std::abs(exact), 0.9999 * static_cast<double>(this->max()));
    }
  };
  for (int i = 0; i < repeats; ++i) {
    const TypeParam a = any<TypeParam::fraction>(random);
    const auto x = static_cast<double>(a);
    expect(exp(a), std::exp(x), std::exp(x) * (2e-9 + 4e-10 * std::abs(x)));
    if (a.raw() < 0) {
      continue;
    }
    // The nearest root: exact to the last bit.
    ASSERT_EQ(sqrt(a).raw(),
              static_cast<std::int32_t>(std::round(std::sqrt(
                  static_cast<long double>(a.raw()) * std::ldexp(1.0L, TypeParam::fraction)))));
    if (a.raw() == 0) {
      continue;
    }
    expect(log(a), std::log(x), 2e-9);
    const TypeParam b = any<TypeParam::fraction>(random);
    const auto y = static_cast<double>(b);
    expect(pow(a, b), std::pow(x, y), std::pow(x, y) * 2e-8 * (1 + std::abs(y)));
  }
}

TEST(Fixed, FormatsMeetWithoutAStepInBetween) {
  std::mt19937_64 random(5);
  for (int i = 0; i < repeats; ++i) {
    const Fixed<28> a = any<28>(random);
    const Fixed<20> b = any<20>(random);
    const double x = static_cast<double>(a);
    const double y = static_cast<double>(b);
    const auto expect = [&](const auto& result, double exact) {
      using R = std::remove_cvref_t<decltype(result)>;
      const double step = std::ldexp(1.0, -R::fraction);
      const bool fits = std::abs(exact) < std::ldexp(1.0, 31 - R::fraction) - step;
      if (fits) {
        ASSERT_FALSE(result.overflowed()) << x << " " << y;
        ASSERT_NEAR(static_cast<double>(result), exact, 0.5 * step * (1 + 1e-9));
      }
    };
    expect(Fixed<24>::product(a, b), x * y);
    expect(Fixed<10>::product(a, b), x * y);
    expect(Fixed<24>(a), x);
    expect(Fixed<30>(b), y);
    if (b.raw() != 0) {
      expect(Fixed<24>::quotient(a, b), x / y);
    }
  }
  EXPECT_TRUE(Fixed<30>(Fixed<20>(3.0)).overflowed());
  EXPECT_FALSE(Fixed<29>(Fixed<20>(3.0)).overflowed());
}

}  // namespace
}  // namespace smaservo::fixed_test
