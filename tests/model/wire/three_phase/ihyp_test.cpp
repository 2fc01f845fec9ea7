#include "model/wire/three_phase/ihyp.hpp"

#include <algorithm>
#include <ceres/jet.h>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

namespace smaservo::ihyp_test {
namespace {

/// tau(x) as science.md section 1 has it, before it was simplified.
long double original_tau(long double G, long double zT, long double x, long double y) {
  const long double b = 1 - zT;
  return x + G * (b * b * b / y - b * b - zT * zT * zT / x + zT * zT - (x - zT));
}

/// The root of original_tau(x) = tau by Newton's steps on logit(x), kept inside a bracket: both x
/// and 1 - x keep their relative accuracy.
template <class S>
Split<long double> oracle(const IhypShape<S>& shape, S at_tau) {
  const auto G = static_cast<long double>(shape.curvature);
  const auto zT = static_cast<long double>(shape.turning);
  const auto tau = static_cast<long double>(at_tau);
  long double low = -60;
  long double high = 60;
  long double w = std::log(zT / (1 - zT));
  for (int i = 0; i < 200; ++i) {
    const long double x = 1 / (1 + std::exp(-w));
    const long double y = 1 / (1 + std::exp(w));
    const long double f = original_tau(G, zT, x, y) - tau;
    (f > 0 ? high : low) = w;
    const long double b = 1 - zT;
    const long double slope = 1 + G * (b * b * b / (y * y) + zT * zT * zT / (x * x) - 1);
    long double next = w - f / (slope * x * y);
    if (!(next > low && next < high)) {
      next = 0.5L * (low + high);
    }
    if (std::abs(next - w) <= 1e-18L * (1 + std::abs(w))) {
      break;
    }
    w = next;
  }
  return {1 / (1 + std::exp(-w)), 1 / (1 + std::exp(w))};
}

struct Case {
  double curvature, turning, tau;
};

/// The whole range of the header's promise: logarithmic and linear grids, corners, random cases.
const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<double> taus{0, 1e-300, -1e-300, 1, 0.5};
    for (int i = 0; i <= 60; ++i) {
      const double t = std::pow(10.0, -6 + i / 6.0);
      taus.insert(taus.end(), {t, -t, 1 + t, 1 - t});
    }
    for (int i = 0; i <= 100; ++i) {
      taus.push_back(-0.5 + i * 0.02);
    }
    std::erase_if(taus, [](double t) { return std::abs(t) > 1e4; });
    std::vector<Case> list;
    for (int g = 0; g <= 18; ++g) {
      const double curvature = 1e-3 * std::pow(3e4, g / 18.0);
      for (int z = 0; z <= 18; ++z) {
        for (const double tau : taus) {
          list.push_back({curvature, 0.05 + z * 0.05, tau});
        }
      }
    }
    std::mt19937_64 random(20260101);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 60000; ++i) {
      const double curvature = 1e-3 * std::pow(3e4, unit(random));
      const double turning = 0.05 + 0.9 * unit(random);
      const double sign = unit(random) < 0.5 ? -1 : 1;
      const double tau = i % 2 == 0 ? -1 + 3 * unit(random)
                                    : turning + sign * std::pow(10.0, -8 + 11.99 * unit(random));
      list.push_back({curvature, turning, tau});
    }
    return list;
  }();
  return all;
}

template <class S>
class Ihyp : public ::testing::Test {};
using Scalars = ::testing::Types<double, float>;
TYPED_TEST_SUITE(Ihyp, Scalars);

template <class S>
constexpr bool is_float = std::numeric_limits<S>::digits <= 24;

TYPED_TEST(Ihyp, InverseKeepsBothFractionsToTheirOwnAccuracy) {
  using S = TypeParam;
  double worst_relative = 0;
  double worst_absolute = 0;
  Case at{};
  for (const Case& c : cases()) {
    const IhypShape<S> shape{static_cast<S>(c.curvature), static_cast<S>(c.turning)};
    const S tau = static_cast<S>(c.tau);
    const Split<S> got = ihyp_fraction(shape, tau);
    const Split<long double> want = oracle(shape, tau);
    const auto error_x =
        static_cast<double>(std::abs(static_cast<long double>(got.converted) - want.converted));
    const auto error_y =
        static_cast<double>(std::abs(static_cast<long double>(got.remaining) - want.remaining));
    const double relative = want.converted < want.remaining
                                ? error_x / static_cast<double>(want.converted)
                                : error_y / static_cast<double>(want.remaining);
    if (!(relative <= worst_relative)) {
      worst_relative = relative;
      at = c;
    }
    worst_absolute = std::max({worst_absolute, error_x, error_y});
  }
  std::printf(
      "%zu cases: worst relative error %.2g (curvature %.4g, turning %.4g, tau %.6g), "
      "worst absolute error %.2g\n",
      cases().size(), worst_relative, at.curvature, at.turning, at.tau, worst_absolute);
  this->RecordProperty("worst_relative_error", std::to_string(worst_relative * 1e15) + "e-15");
  this->RecordProperty("worst_absolute_error", std::to_string(worst_absolute * 1e15) + "e-15");
  // The header's figures. One that is much too good is out of date as well.
  EXPECT_LT(worst_relative, is_float<S> ? 1.2e-6 : 6e-14);
  EXPECT_GT(worst_relative, is_float<S> ? 0.5e-6 : 2e-14);
  EXPECT_LT(worst_absolute, is_float<S> ? 1.8e-7 : 1e-14);
  EXPECT_GT(worst_absolute, is_float<S> ? 0.8e-7 : 3e-15);
}

TYPED_TEST(Ihyp, TemperatureOfFractionOfTemperatureIsTheSame) {
  using S = TypeParam;
  double worst = 0;
  for (const Case& c : cases()) {
    const IhypShape<S> shape{static_cast<S>(c.curvature), static_cast<S>(c.turning)};
    const S tau = static_cast<S>(c.tau);
    const Split<S> x = ihyp_fraction(shape, tau);
    // A rounding error of the smaller fraction shifts tau by the slope there times that error.
    const S smaller = std::min(x.converted, x.remaining);
    const S scale = S(1) + ihyp_slope(shape, x) * smaller;
    worst =
        std::max(worst, static_cast<double>(std::abs(ihyp_temperature(shape, x) - tau) / scale));
  }
  EXPECT_LT(worst, is_float<S> ? 2e-6 : 1e-13);
}

TYPED_TEST(Ihyp, FractionRisesWithTemperature) {
  using S = TypeParam;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int curve = 0; curve < 300; ++curve) {
    const IhypShape<S> shape{static_cast<S>(1e-3 * std::pow(3e4, unit(random))),
                             static_cast<S>(0.05 + 0.9 * unit(random))};
    Split<S> before = ihyp_fraction(shape, S(-1e4));
    for (int i = -400; i <= 400; ++i) {
      // sinh: fine around the bend, coarse in the tails
      const S tau = static_cast<S>(0.01 * std::sinh(i * 14.5 / 400));
      const Split<S> now = ihyp_fraction(shape, tau);
      // Neighbours differ by more than the inverse's error: strict, in the more accurate fraction.
      if (now.converted < now.remaining) {
        ASSERT_LT(before.converted, now.converted);
      } else {
        ASSERT_GT(before.remaining, now.remaining);
      }
      before = now;
    }
  }
}

TEST(IhypFormula, IsTheOneOfThePaper) {
  for (const Case& c : cases()) {
    const IhypShape<double> shape{c.curvature, c.turning};
    const Split<long double> x = oracle(shape, c.tau);
    const Split<double> rounded{static_cast<double>(x.converted), static_cast<double>(x.remaining)};
    const double slope = ihyp_slope(shape, rounded);
    const double smaller = std::min(rounded.converted, rounded.remaining);
    EXPECT_NEAR(ihyp_temperature(shape, rounded), c.tau, 4e-15 * (1 + slope * smaller));
  }
}

TEST(IhypFormula, StartsAndFinishesWhereTheTangentAtTheTurningPointDoes) {
  for (const Case& c : cases()) {
    const IhypShape<double> shape{c.curvature, c.turning};
    const Split<double> at{c.turning, 1 - c.turning};
    EXPECT_DOUBLE_EQ(ihyp_temperature(shape, at), c.turning);
    EXPECT_NEAR(ihyp_slope(shape, at), 1, 4e-16 * (1 + c.curvature));
    EXPECT_DOUBLE_EQ(ihyp_fraction(shape, c.turning).converted, c.turning);
  }
}

TEST(IhypFormula, SlopeIsTheDerivative) {
  using J = ceres::Jet<double, 1>;
  for (const Case& c : cases()) {
    const IhypShape<double> shape{c.curvature, c.turning};
    const Split<long double> x = oracle(shape, c.tau);
    const auto converted = static_cast<double>(x.converted);
    const auto remaining = static_cast<double>(x.remaining);
    const double slope = ihyp_slope(shape, {converted, remaining});
    EXPECT_GE(slope, 1 - 1e-14);

    const long double h = 1e-6L * std::min(x.converted, x.remaining);
    const auto tau_at = [&](long double shift) {
      return original_tau(static_cast<long double>(c.curvature),
                          static_cast<long double>(c.turning), x.converted + shift,
                          x.remaining - shift);
    };
    const long double difference = (tau_at(h) - tau_at(-h)) / (2 * h);
    EXPECT_NEAR(slope, static_cast<double>(difference), 1e-10 * slope);

    const J fraction(converted, 0);
    const J rest(remaining, Eigen::Matrix<double, 1, 1>(-1));
    const J tau = ihyp_temperature<J>({J(c.curvature), J(c.turning)}, {fraction, rest});
    EXPECT_NEAR(slope, tau.v[0], 1e-12 * slope);
  }
}

TEST(IhypFormula, AutomaticDerivativeOfTheInverseObeysTheImplicitFunctionTheorem) {
  using J = ceres::Jet<double, 3>;
  for (const Case& c : cases()) {
    const IhypShape<J> shape{J(c.curvature, 0), J(c.turning, 1)};
    const Split<J> x = ihyp_fraction(shape, J(c.tau, 2));
    const Split<double> value{x.converted.a, x.remaining.a};
    const IhypShape<double> plain{c.curvature, c.turning};
    const double slope = ihyp_slope(plain, value);
    const double smaller = std::min(value.converted, value.remaining);
    // dx/dtau = 1/tau'(x); of the smaller fraction, since that is the accurate one
    const J& accurate = value.converted < value.remaining ? x.converted : x.remaining;
    const double sign = value.converted < value.remaining ? 1 : -1;
    EXPECT_NEAR(sign * accurate.v[2] * slope, 1, 1e-11);
    // dx/dΓ = -(dtau/dΓ)/tau' = -(tau - x)/(Γ tau'), where tau is not too close to x
    const double by_curvature = -(c.tau - value.converted) / (c.curvature * slope);
    EXPECT_NEAR(sign * accurate.v[0], by_curvature,
                1e-11 * (std::abs(by_curvature) + smaller / c.curvature));
    // dx/dz_T = 3 Γ (x - z_T)²/(x (1 - x))/tau'
    const double u = value.converted - c.turning;
    const double by_turning = 3 * c.curvature * u * u / (value.converted * value.remaining) / slope;
    EXPECT_NEAR(sign * accurate.v[1], by_turning, 1e-11 * (by_turning + smaller));
  }
}

/// A shape with this taper, and a place on its curve.
struct Tapered {
  IhypShape<double> shape;
  double tau;
};

/// Up to 200 widths from the turning point.
std::vector<Tapered> tapered_cases() {
  std::vector<Tapered> all;
  std::mt19937_64 random(44);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const double turning = 0.05 + 0.9 * unit(random);
    const double sign = unit(random) < 0.5 ? -1 : 1;
    all.push_back(
        {{1e-3 * std::pow(3e4, unit(random)), turning, std::pow(10, -3 + 4 * unit(random))},
         turning + sign * std::pow(10, -6 + 8.3 * unit(random))});
  }
  return all;
}

TYPED_TEST(Ihyp, TaperedTemperatureOfFractionOfTemperatureIsTheSame) {
  using S = TypeParam;
  double worst = 0;
  for (const Tapered& c : tapered_cases()) {
    const IhypShape<S> shape{static_cast<S>(c.shape.curvature), static_cast<S>(c.shape.turning),
                             static_cast<S>(c.shape.taper)};
    const S tau = static_cast<S>(c.tau);
    const Split<S> x = ihyp_fraction(shape, tau);
    const S smaller = std::min(x.converted, x.remaining);
    const S scale = S(1) + ihyp_slope(shape, x) * smaller + std::abs(tau);
    worst =
        std::max(worst, static_cast<double>(std::abs(ihyp_temperature(shape, x) - tau) / scale));
  }
  EXPECT_LT(worst, is_float<S> ? 2e-6 : 1e-13);
}

TEST(IhypTaper, MovesEveryPlaceOfThePapersCurveTowardsTheTurningPoint) {
  for (const Tapered& c : tapered_cases()) {
    const IhypShape<double> paper{c.shape.curvature, c.shape.turning};
    const Split<double> x = ihyp_fraction(c.shape, c.tau);
    // e = d sqrt(1 + κ d²), t = e sqrt(1 + κ e²)
    const auto half = [&](double d) {
      return std::copysign(std::hypot(d, std::sqrt(c.shape.taper) * d * d), d);
    };
    const double t = c.shape.turning + half(half(c.tau - c.shape.turning));
    const Split<long double> same = oracle(paper, t);
    const long double smaller = std::min(same.converted, same.remaining);
    const double got = std::min(x.converted, x.remaining);
    ASSERT_NEAR(got / static_cast<double>(smaller), 1, std::abs(t) < 1e4 ? 1e-12 : 1e-8) << t;
  }
}

TEST(IhypTaper, SlopeIsTheDerivativeOfTheTemperature) {
  using J = ceres::Jet<double, 1>;
  for (const Tapered& c : tapered_cases()) {
    const Split<double> x = ihyp_fraction(c.shape, c.tau);
    const J fraction(x.converted, 0);
    const J rest(x.remaining, Eigen::Matrix<double, 1, 1>(-1));
    const IhypShape<J> shape{J(c.shape.curvature), J(c.shape.turning), J(c.shape.taper)};
    const double slope = ihyp_slope(c.shape, x);
    ASSERT_NEAR(ihyp_temperature(shape, Split<J>{fraction, rest}).v[0], slope, 1e-9 * slope);
  }
}

TEST(IhypTaper, EndsFallLikeTheFourthPower) {
  const IhypShape<double> shape{2, 0.4, 1};
  const auto left = [&](double tau) { return ihyp_fraction(shape, tau).remaining; };
  EXPECT_NEAR(left(8) / left(4), std::pow(0.5, 4), 0.015);
  EXPECT_NEAR(ihyp_fraction(IhypShape<double>{2, 0.4}, 8.0).remaining /
                  ihyp_fraction(IhypShape<double>{2, 0.4}, 4.0).remaining,
              0.5, 0.1);
}

TEST(IhypTaper, FractionsStayWithinTheirBoundsHoweverFar) {
  for (const float tau : {-1e4F, -300.0F, 300.0F, 1e4F}) {
    const Split<float> x = ihyp_fraction(IhypShape<float>{30, 0.05F, 20}, tau);
    EXPECT_TRUE(x.converted > 0 && x.converted <= 1 && x.remaining > 0 && x.remaining <= 1) << tau;
  }
}

TYPED_TEST(Ihyp, StaysBetweenNoneAndAllFarOutsideItsRange) {
  using S = TypeParam;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 200000; ++i) {
    const IhypShape<S> shape{static_cast<S>(std::pow(10.0, -3 + 7 * unit(random))),
                             static_cast<S>(0.05 + 0.9 * unit(random))};
    const double sign = unit(random) < 0.5 ? -1 : 1;
    const double tau = sign * std::pow(10.0, -6 + 10 * unit(random));
    const Split<S> x = ihyp_fraction(shape, static_cast<S>(tau));
    // The larger fraction may round to 1, the smaller one never to 0.
    ASSERT_TRUE(x.converted > S(0) && x.converted <= S(1) && x.remaining > S(0) &&
                x.remaining <= S(1) && std::abs(x.converted + x.remaining - S(1)) < S(1e-5))
        << "curvature " << shape.curvature << ", turning " << shape.turning << ", tau " << tau
        << ": " << x.converted << ", " << x.remaining;
  }
}

}  // namespace
}  // namespace smaservo::ihyp_test
