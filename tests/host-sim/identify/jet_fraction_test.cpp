#include "host-sim/identify/fit/jet_fraction.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::identify {
namespace jet_fraction_test {
namespace {

struct Place {
  IhypShape<Jet> shape;
  Jet tau;
};

/// A place on a curve, each of whose four numbers is a parameter. Every other curve is paper 000's.
Place random_place(std::mt19937& random, int first_parameter) {
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double taper = random() % 2 == 0 ? 0 : within(0.01, 2);
  const double reach = random() % 2 == 0 ? 2 : 300;
  return {{Jet(within(0.3, 9), first_parameter), Jet(within(0.1, 0.9), first_parameter + 1),
           Jet(taper, first_parameter + 2)},
          Jet(within(-reach, reach), first_parameter + 3)};
}

/// Derivatives may differ by rounding, or far out on a tapered curve by the error of its formula
/// for the end, as parts of the greatest one: two of them vanish at the turning point.
void expect_same(const Split<Jet>& got, const Split<Jet>& expected, const Jet& tau, bool tapered) {
  EXPECT_EQ(got.converted.a, expected.converted.a);
  EXPECT_EQ(got.remaining.a, expected.remaining.a);
  // The smaller of the two fractions has derivatives with few rounding errors.
  const double tolerance = tapered && std::abs(tau.a) > 3 ? 1e-6 : 1e-11;
  const bool from_below = expected.converted.a < expected.remaining.a;
  double greatest = 0;
  for (int i = 0; i < Jet::size; ++i) {
    greatest = std::max(greatest, std::abs(expected.converted.v[i]));
  }
  for (int i = 0; i < Jet::size; ++i) {
    const double exact = from_below ? expected.converted.v[i] : -expected.remaining.v[i];
    EXPECT_EQ(got.remaining.v[i], -got.converted.v[i]);
    EXPECT_NEAR(got.converted.v[i], exact, tolerance * greatest) << i;
  }
}

// The model's own function, differentiated step by step, is the oracle.
TEST(JetFraction, IsTheModelsWithTheSameDerivatives) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 5000; ++trial) {
    const auto [shape, tau] = random_place(random, 0);
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", tau " << tau.a);
    expect_same(ihyp_fraction(shape, tau), smaservo::ihyp_fraction<Jet>(shape, tau), tau,
                shape.taper.a > 0);

    const auto [other, other_tau] = random_place(random, 4);
    const IhypShape<Pair<Jet>> both{{shape.curvature, other.curvature},
                                    {shape.turning, other.turning},
                                    {shape.taper, other.taper}};
    const Split<Pair<Jet>> x = ihyp_fraction(both, Pair<Jet>(tau, other_tau));
    const Split<Pair<Jet>> exact =
        smaservo::ihyp_fraction<Pair<Jet>>(both, Pair<Jet>(tau, other_tau));
    expect_same({x.converted.first(), x.remaining.first()},
                {exact.converted.first(), exact.remaining.first()}, tau, shape.taper.a > 0);
    expect_same({x.converted.second(), x.remaining.second()},
                {exact.converted.second(), exact.remaining.second()}, other_tau, other.taper.a > 0);
  }
}

}  // namespace
}  // namespace jet_fraction_test
}  // namespace smaservo::identify
