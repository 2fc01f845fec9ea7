#include "model/scalar/pair.hpp"

#include <algorithm>
#include <array>
#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <random>

#include "model/wire/three_phase/ihyp.hpp"

namespace smaservo::pair_test {
namespace {

template <class S>
class PairTest : public ::testing::Test {};
using Scalars = ::testing::Types<double, float>;
TYPED_TEST_SUITE(PairTest, Scalars);

TYPED_TEST(PairTest, EachLaneComputesWhatTheScalarDoesToTheBit) {
  using S = TypeParam;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<S> uniform(S(0.01), S(10));
  for (int i = 0; i < 10000; ++i) {
    const S a = uniform(random), b = uniform(random), c = uniform(random), d = uniform(random);
    const Pair<S> x(a, b), y(c, d);
    const auto expect = [](const Pair<S>& pair, S first, S second) {
      EXPECT_EQ(pair.first(), first);
      EXPECT_EQ(pair.second(), second);
    };
    expect(x + y, a + c, b + d);
    expect(x - y, a - c, b - d);
    expect(-x, -a, -b);
    Pair<S> z = x;
    expect(z += y, a + c, b + d);
    expect(z -= x, a + c - a, b + d - b);
    expect(x * y, a * c, b * d);
    expect(x / y, a / c, b / d);
    expect(sqrt(x), std::sqrt(a), std::sqrt(b));
    expect(select(x < y, x, y), a < c ? a : c, b < d ? b : d);
    EXPECT_EQ(any(x < y), a < c || b < d);
    expect(Pair<S>(a), a, a);
  }
}

TYPED_TEST(PairTest, TwoCurvesAtOnceAreTheTwoCurves) {
  using S = TypeParam;
  std::mt19937_64 random(4);
  std::uniform_real_distribution<S> uniform(S(0), S(1));
  const auto curvature = [&] { return S(0.5) + S(5) * uniform(random); };
  const auto turning = [&] { return S(0.1) + S(0.8) * uniform(random); };
  for (int i = 0; i < 10000; ++i) {
    const IhypShape<S> one{curvature(), turning()}, two{curvature(), turning()};
    const S t1 = S(20) * uniform(random) - S(10), t2 = S(20) * uniform(random) - S(10);
    const IhypShape<Pair<S>> both{{one.curvature, two.curvature}, {one.turning, two.turning}};
    const Split<Pair<S>> x = ihyp_fraction(both, Pair<S>(t1, t2));
    EXPECT_EQ(x.converted.first(), ihyp_fraction(one, t1).converted);
    EXPECT_EQ(x.converted.second(), ihyp_fraction(two, t2).converted);
    EXPECT_EQ(x.remaining.first(), ihyp_fraction(one, t1).remaining);
    EXPECT_EQ(x.remaining.second(), ihyp_fraction(two, t2).remaining);
  }
}

TEST(PairOfAnyScalar, DerivativesStayInTheirLane) {
  using J = ceres::Jet<double, 2>;
  const Pair<J> x(J(2.0, 0), J(3.0, 1));
  const Pair<J> y = x * x / (x + Pair<J>(J(1.0)));
  EXPECT_DOUBLE_EQ(y.first().a, 4.0 / 3);
  EXPECT_DOUBLE_EQ(y.first().v[0], 8.0 / 9);  // (x² + 2x)/(x + 1)²
  EXPECT_EQ(y.first().v[1], 0);
  EXPECT_DOUBLE_EQ(y.second().v[1], 15.0 / 16);
  EXPECT_EQ(y.second().v[0], 0);
  EXPECT_TRUE(any(x < Pair<J>(J(2.5))));
  EXPECT_FALSE(any(x < Pair<J>(J(1.5))));
}

TEST(PairOfPairs, FourCurvesAtOnceAreTheFourCurves) {
  using S = double;
  using Four = Pair<Pair<S>>;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<S> uniform(S(0.1), S(0.9));
  for (int i = 0; i < 10000; ++i) {
    std::array<IhypShape<S>, 4> shape;
    std::array<S, 4> tau;
    for (std::size_t k = 0; k < 4; ++k) {
      shape[k] = {S(6) * uniform(random), uniform(random)};
      tau[k] = S(4) * uniform(random) - S(1.5);
    }
    const auto four = [](S a, S b, S c, S d) { return Four(Pair<S>(a, b), Pair<S>(c, d)); };
    const IhypShape<Four> all{
        four(shape[0].curvature, shape[1].curvature, shape[2].curvature, shape[3].curvature),
        four(shape[0].turning, shape[1].turning, shape[2].turning, shape[3].turning)};
    const Four at = four(tau[0], tau[1], tau[2], tau[3]);
    const Four x = ihyp_fraction(all, at).converted;
    EXPECT_EQ(x.first().first(), ihyp_fraction(shape[0], tau[0]).converted);
    EXPECT_EQ(x.first().second(), ihyp_fraction(shape[1], tau[1]).converted);
    EXPECT_EQ(x.second().first(), ihyp_fraction(shape[2], tau[2]).converted);
    EXPECT_EQ(x.second().second(), ihyp_fraction(shape[3], tau[3]).converted);
    EXPECT_EQ(any(at < Four(S(0))), std::ranges::any_of(tau, [](S t) { return t < S(0); }));
  }
}

}  // namespace
}  // namespace smaservo::pair_test
