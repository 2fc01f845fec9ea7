#include "model/scalar/scaled.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <type_traits>

#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::scaled_test {
namespace {

constexpr int repeats = 300'000;
constexpr double unit = 0x1p-29;  ///< relative step at the least mantissa

template <double x>
concept Fits = requires { typename std::bool_constant<(Scaled(x), true)>; };
static_assert(Fits<1e9> && Fits<-1e-9> && Fits<0x1p199> && !Fits<0x1p210>);
static_assert(!Fits<std::numeric_limits<double>::infinity()>);
static_assert(Scaled(0.0) == Scaled{} && Scaled(3.0) == Scaled(3) && Scaled(3.0F) == Scaled(3));
static_assert(std::is_trivially_copyable_v<Scaled> && sizeof(Scaled) == 8);

/// Of every magnitude, or as great as the one before: sums that cancel.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  Scaled next() {
    const double mantissa = std::uniform_real_distribution<double>(-1, 1)(random_);
    if (random_() % 3 != 0) {
      exponent_ = static_cast<int>(random_() % 80) - 40;
    }
    return random_() % 50 == 0 ? Scaled(0) : Scaled::of(std::ldexp(mantissa, exponent_));
  }

 private:
  std::mt19937_64 random_;
  int exponent_ = 0;
};

void expect_near(const Scaled& x, double exact, double tolerance) {
  ASSERT_TRUE(isfinite(x));
  ASSERT_NEAR(static_cast<double>(x), exact, tolerance) << exact;
}

TEST(Scaled, ArithmeticIsThatOfADouble) {
  Numbers numbers(1);
  for (int i = 0; i < repeats; ++i) {
    const Scaled a = numbers.next();
    const Scaled b = numbers.next();
    const auto x = static_cast<double>(a);
    const auto y = static_cast<double>(b);
    const auto max = [&](double sum) {
      return std::max({std::abs(x), std::abs(y), std::abs(sum)});
    };
    expect_near(a + b, x + y, 0.76 * unit * max(x + y));
    expect_near(a - b, x - y, 0.76 * unit * max(x - y));
    expect_near(a * b, x * y, 0.76 * unit * std::abs(x * y));
    if (y != 0) {
      expect_near(a / b, x / y, 0.501 * unit * std::abs(x / y));
    }
    expect_near(sqrt(abs(a)), std::sqrt(std::abs(x)), 0.76 * unit * std::sqrt(std::abs(x)));
    ASSERT_EQ(a < b, x < y);
    ASSERT_EQ(a <= b, x <= y);
    ASSERT_EQ(a > b, x > y);
    ASSERT_EQ(a == b, x == y);
  }
}

TEST(Scaled, SumsOfProductsAreThoseOfADouble) {
  Numbers numbers(7);
  using Term = Product<Scaled>;
  const auto exact = [](const Term& t) {
    return static_cast<double>(t.a) * static_cast<double>(t.b);
  };
  for (int i = 0; i < repeats; ++i) {
    const Scaled start = numbers.next();
    const Term t[] = {{numbers.next(), numbers.next()},
                      {numbers.next(), numbers.next()},
                      {numbers.next(), numbers.next()},
                      {numbers.next(), numbers.next()},
                      {numbers.next(), numbers.next()}};
    auto sum = static_cast<double>(start);
    double max = std::abs(sum);
    const auto add = [&](const Term& term) {
      sum += exact(term);
      max = std::max(max, std::abs(exact(term)));
    };
    add(t[0]);
    expect_near(sum_of_products(start, t[0]), sum, 2 * 2 * unit * max);
    add(t[1]);
    add(t[2]);
    expect_near(sum_of_products(start, t[0], t[1], t[2]), sum, 4 * 4 * unit * max);
    add(t[3]);
    add(t[4]);
    const double products = sum - static_cast<double>(start);
    expect_near(sum_of_products(start, t[0], t[1], t[2], t[3], t[4]), sum, 6 * 8 * unit * max);
    expect_near(sum_of_products(t[0], t[1], t[2], t[3], t[4]), products, 6 * 8 * unit * max);
  }
}

TEST(Scaled, WhatASumOfProductsCanNotHoldIsNotFinite) {
  using Term = Product<Scaled>;
  const Scaled one(1);
  const Scaled great = Scaled::of(0x1p150);
  const Scaled small = Scaled::of(0x1p-150);
  const Scaled invalid = one / Scaled(0);
  const Term unity{one, one};
  EXPECT_FALSE(isfinite(sum_of_products(one, Term{great, great})));
  EXPECT_FALSE(isfinite(sum_of_products(invalid, unity)));
  EXPECT_FALSE(isfinite(sum_of_products(unity, Term{invalid, Scaled(0)})));
  EXPECT_FALSE(isfinite(sum_of_products(Term{invalid, invalid}, unity, unity)));
  EXPECT_EQ(sum_of_products(Term{small, small}, Term{small, small}), Scaled(0));
  EXPECT_EQ(sum_of_products(Term{small, small}, unity), one);
  EXPECT_EQ(sum_of_products(Scaled(0), Term{Scaled(0), great}), Scaled(0));
  EXPECT_EQ(sum_of_products(unity, Term{one, -one}), Scaled(0));
}

TEST(Scaled, Algebra) {
  Numbers numbers(2);
  for (int i = 0; i < repeats; ++i) {
    const Scaled a = numbers.next();
    const Scaled b = numbers.next();
    ASSERT_EQ(a + b, b + a);
    ASSERT_EQ(a * b, b * a);
    ASSERT_EQ(a - a, Scaled(0));
    ASSERT_EQ(a + Scaled(0), a);
    ASSERT_EQ(a * Scaled(1), a);
    ASSERT_EQ(a / Scaled(1), a);
    ASSERT_EQ(a + a, a * Scaled(2));
    ASSERT_EQ(Scaled(0) - a, -a);
    if (!(a == Scaled(0))) {
      ASSERT_EQ(a / a, Scaled(1));
    }
  }
}

TEST(Scaled, MinusAndAssignmentsAreShortForTheLongForms) {
  Numbers numbers(12);
  std::mt19937_64 random(13);
  const auto same = [](const Scaled& x, const Scaled& y) {
    using Bits = std::array<std::uint32_t, 2>;
    ASSERT_EQ(std::bit_cast<Bits>(x), std::bit_cast<Bits>(y));
  };
  const Scaled great = Scaled::of(0x1.fffffp199);
  const Scaled extremes[] = {Scaled(0),
                             Scaled::of(0x1p-200),
                             great,
                             -great,
                             great + great,
                             great * great,
                             Scaled(1) / Scaled(0),
                             -Scaled::of(0x1p-200)};
  for (int i = 0; i < repeats; ++i) {
    const auto number = [&] { return random() % 4 == 0 ? extremes[random() % 8] : numbers.next(); };
    const Scaled a = number();
    const Scaled b = number();
    same(-a, Scaled(0) - a);
    Scaled x = a;
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

TEST(Scaled, WhatHasNoValueStaysWithout) {
  const Scaled one(1);
  const Scaled none(0);
  const Scaled nan = one / none;
  const Scaled another_nan = -one / none;
  const Scaled nothing(0);
  for (const Scaled& x :
       {nan, none / nothing, nan + one, one - nan, nan * none, none / nan, one / nan, sqrt(nan),
        -nan, abs(nan), sqrt(-one), log(none), log(-one), exp(Scaled(1000)), nan - another_nan,
        std::numeric_limits<Scaled>::quiet_NaN(), Scaled(1e50) * Scaled(1e50)}) {
    EXPECT_FALSE(isfinite(x));
    EXPECT_TRUE(std::isnan(static_cast<double>(x)));
    EXPECT_TRUE(std::isnan(static_cast<float>(x)));
    for (const Scaled& y : {one, none, -one, nan}) {
      EXPECT_FALSE(x < y || y < x || x <= y || y <= x || x > y || x >= y || x == y);
    }
  }
  EXPECT_EQ(Scaled(1e-50) * Scaled(1e-50), none);
  EXPECT_EQ(exp(Scaled(-1000)), none);
}

TEST(Scaled, NumbersOfTheRun) {
  std::mt19937_64 random(3);
  for (int i = 0; i < repeats; ++i) {
    const double x = std::ldexp(std::uniform_real_distribution<double>(-1, 1)(random),
                                static_cast<int>(random() % 60) - 25);
    const Scaled a = Scaled::of(x);
    expect_near(a, x, 0.501 * unit * std::abs(x));
    const auto f = static_cast<float>(x);
    ASSERT_EQ(static_cast<float>(Scaled(f)), f);
    ASSERT_EQ(static_cast<double>(Scaled(f)), static_cast<double>(f));
    ASSERT_NEAR(static_cast<float>(a), f, 1.3e-7F * std::abs(f));
    const auto exact = static_cast<double>(a);
    if (std::abs(exact) < 2e9) {
      ASSERT_EQ(static_cast<int>(a), static_cast<int>(exact));
    }
    if (std::abs(exact) < 0x1p30) {
      ASSERT_EQ(static_cast<double>(Scaled(static_cast<int>(a))), std::trunc(exact));
    }
    ASSERT_EQ(static_cast<double>(ceil(a)), std::ceil(exact));
  }
  EXPECT_FALSE(isfinite(Scaled::of(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_FALSE(isfinite(Scaled(-std::numeric_limits<float>::infinity())));
  EXPECT_EQ(static_cast<double>(Scaled(std::numeric_limits<int>::max())), 0x1p31);
}

TEST(Scaled, FunctionsAreThoseOfADouble) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> exponents(-80, 80);
  for (int i = 0; i < repeats; ++i) {
    const Scaled a = Scaled::of(exponents(random));
    const auto x = static_cast<double>(a);
    expect_near(exp(a), std::exp(x), std::exp(x) * 3e-9 * (1 + std::abs(x)));
    const Scaled b = Scaled::of(std::exp(0.5 * exponents(random)));
    const auto y = static_cast<double>(b);
    expect_near(log(b), std::log(y), 2e-9 * (1 + std::abs(std::log(y))));
    const Scaled c = Scaled::of(0.02 * exponents(random));
    const double power = std::pow(y, static_cast<double>(c));
    expect_near(pow(b, c), power, power * 1e-7 * (1 + std::abs(std::log(power))));
    const Scaled d = Scaled::of(0.2 * exponents(random));
    const double hyperbolic = std::cosh(static_cast<double>(d));
    expect_near(cosh(d), hyperbolic, hyperbolic * 1e-7);
  }
}

// The curve over all shapes and temperatures that float is measured with, fifty times as close.
TEST(Scaled, TheTransformationCurve) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> curvature(-3, 1.477);
  std::uniform_real_distribution<double> turning(0.05, 0.95);
  std::uniform_real_distribution<double> size(-3, 2);
  double worst = 0;
  for (int i = 0; i < repeats; ++i) {
    const IhypShape<Scaled> shape{Scaled::of(std::pow(10, curvature(random))),
                                  Scaled::of(turning(random))};
    const Scaled tau = Scaled::of((i % 2 == 0 ? 1 : -1) * std::pow(10, size(random)));
    const IhypShape<double> exact_shape{static_cast<double>(shape.curvature),
                                        static_cast<double>(shape.turning)};
    const Split<Scaled> split = ihyp_fraction(shape, tau);
    const Split<double> exact = ihyp_fraction(exact_shape, static_cast<double>(tau));
    worst = std::max({worst, std::abs(static_cast<double>(split.converted) - exact.converted),
                      std::abs(static_cast<double>(split.remaining) - exact.remaining)});
  }
  EXPECT_LT(worst, 4e-9);
  EXPECT_GT(worst, 4e-10);
}

}  // namespace
}  // namespace smaservo::scaled_test
