#include "observer/measurement.hpp"

#include <array>
#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <random>

namespace smaservo::measurement_test {
namespace {

template <class S>
constexpr MeasurementParams<S> bench() {
  return {.area_m2 = S(4.5e-9),
          .current_offset_A = S(0),
          .voltage_offset_V = S(0),
          .current_noise_A = S(10e-6),
          .voltage_noise_V = S(0.5e-3),
          .lead_resistance_ohm = S(0),
          .min_current_A = S(0.01),
          .min_resistance_ohm = S(1),
          .max_resistance_ohm = S(1000)};
}

template <class S>
class Measure : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Measure, Scalars);

template <class S>
void expect_near(S value, S expected, S relative) {
  EXPECT_LE(std::abs(value - expected), relative * std::abs(expected))
      << value << " instead of " << expected;
}

TYPED_TEST(Measure, OhmsLawWithOffsets) {
  using S = TypeParam;
  MeasurementParams<S> p = bench<S>();
  p.current_offset_A = S(0.002);
  p.voltage_offset_V = S(-0.05);
  std::mt19937 random(1);
  std::uniform_real_distribution<S> ohm(S(1.1), S(900));
  std::uniform_real_distribution<S> ampere(S(0.011), S(2));
  const S eps = std::numeric_limits<S>::epsilon();
  for (int i = 0; i < 1000; ++i) {
    const S R = ohm(random);
    const S I = ampere(random);
    const Measurement<S> m = measure<S>(p, {I + S(0.002), R * I - S(0.05), S(0.9)});
    ASSERT_TRUE(m.resistance_valid && m.power_valid && m.stress_valid);
    // Subtracting the offset from a small current loses digits.
    expect_near(m.resistance_ohm, R, 20 * eps + eps / I + eps / (R * I));
    expect_near(m.power_W, R * I * I, 20 * eps + eps / I + eps / (R * I));
    expect_near(m.stress_Pa, S(0.2e9), 4 * eps);
  }
}

TYPED_TEST(Measure, TwoWiresLeaveTheLeadsOut) {
  using S = TypeParam;
  MeasurementParams<S> p = bench<S>();
  p.lead_resistance_ohm = S(0.75);
  const S I = S(0.25);
  const S R = S(22);
  const Measurement<S> m = measure<S>(p, {I, (R + S(0.75)) * I, S(0)});
  EXPECT_TRUE(m.resistance_valid);
  expect_near(m.resistance_ohm, R, S(1e-6));
  expect_near(m.power_W, R * I * I, S(1e-6));  // what the leads heat is not the wire's
}

// A supply, a reference resistor, leads and the wire in one loop.
TYPED_TEST(Measure, TwoWireFormulaOfPaper002) {
  using S = TypeParam;
  for (const S I : {S(-0.3), S(0.02), S(0.4)}) {
    for (const S R : {S(2), S(22), S(150)}) {
      const S reference_ohm = S(4.7);
      const S lead_ohm = S(0.6);
      const S net_V = I * (reference_ohm + lead_ohm + R);
      expect_near(two_wire_resistance_ohm(reference_ohm, net_V, I * reference_ohm, lead_ohm), R,
                  100 * std::numeric_limits<S>::epsilon());
    }
  }
}

TYPED_TEST(Measure, NeedsTheLeastCurrentInEitherDirection) {
  using S = TypeParam;
  MeasurementParams<S> p = bench<S>();
  p.current_offset_A = S(0.5);
  for (const S sign : {S(1), S(-1)}) {
    const auto at = [&](S I) { return measure<S>(p, {sign * I + S(0.5), sign * I * S(22), S(1)}); };
    EXPECT_TRUE(at(S(0.0101)).resistance_valid);
    EXPECT_FALSE(at(S(0.0099)).resistance_valid);
    EXPECT_TRUE(at(S(0.0099)).power_valid);  // a small current heats little, and that is known
    expect_near(at(S(0.0099)).power_W, S(22 * 0.0099 * 0.0099), S(1e-4));
  }
}

TYPED_TEST(Measure, NegativeCurrentIsTheSameWire) {
  using S = TypeParam;
  const Measurement<S> there = measure<S>(bench<S>(), {S(0.2), S(4.4), S(1)});
  const Measurement<S> back = measure<S>(bench<S>(), {S(-0.2), S(-4.4), S(1)});
  EXPECT_TRUE(back.resistance_valid);
  EXPECT_EQ(there.resistance_ohm, back.resistance_ohm);
  EXPECT_EQ(there.resistance_sd_ohm, back.resistance_sd_ohm);
  EXPECT_EQ(there.power_W, back.power_W);
  EXPECT_GT(back.power_W, 0);
  // A voltage against the current is a wiring fault.
  EXPECT_FALSE(measure<S>(bench<S>(), {S(0.2), S(-4.4), S(1)}).resistance_valid);
}

TYPED_TEST(Measure, OutsideTheWiresRangeItIsBrokenOrShort) {
  using S = TypeParam;
  const auto valid = [](S ohm) {
    const Measurement<S> m = measure<S>(bench<S>(), {S(0.125), ohm * S(0.125), S(1)});
    EXPECT_TRUE(m.power_valid);
    return m.resistance_valid;
  };
  EXPECT_FALSE(valid(S(0)));
  EXPECT_FALSE(valid(S(0.999)));
  EXPECT_TRUE(valid(S(1)));
  EXPECT_TRUE(valid(S(1000)));
  EXPECT_FALSE(valid(S(1001)));
  EXPECT_FALSE(valid(S(1e8)));
}

// A bad reading invalidates the results that need it, and no others.
TYPED_TEST(Measure, ABadReadingInvalidatesWhatNeedsIt) {
  using S = TypeParam;
  const S inf = std::numeric_limits<S>::infinity();
  const Measurement<S> good = measure<S>(bench<S>(), {S(0.2), S(4.4), S(0.9)});
  ASSERT_TRUE(good.resistance_valid && good.power_valid && good.stress_valid);
  for (const S bad : {std::numeric_limits<S>::quiet_NaN(), inf, -inf}) {
    for (const auto& sample : {Sample<S>{bad, S(4.4), S(0.9)}, Sample<S>{S(0.2), bad, S(0.9)},
                               Sample<S>{bad, bad, S(0.9)}}) {
      const Measurement<S> m = measure<S>(bench<S>(), sample);
      EXPECT_FALSE(m.resistance_valid);
      EXPECT_FALSE(m.power_valid);
      EXPECT_EQ(m.power_W, 0);
      EXPECT_TRUE(m.stress_valid);
      EXPECT_EQ(m.stress_Pa, good.stress_Pa);
    }
    const Measurement<S> m = measure<S>(bench<S>(), {S(0.2), S(4.4), bad});
    EXPECT_FALSE(m.stress_valid);
    EXPECT_TRUE(m.resistance_valid && m.power_valid);
    EXPECT_EQ(m.resistance_ohm, good.resistance_ohm);
    EXPECT_EQ(m.power_W, good.power_W);
  }
}

TYPED_TEST(Measure, ValidMeansFinite) {
  using S = TypeParam;
  const S huge = std::numeric_limits<S>::max();
  const S values[] = {S(0), S(1e-30), S(0.2), S(-0.2), S(4.4), S(1e30), huge, -huge};
  MeasurementParams<S> p = bench<S>();
  for (const S min_A : {S(0), S(0.01)}) {
    p.min_current_A = min_A;
    for (const S I : values) {
      for (const S V : values) {
        const Measurement<S> m = measure<S>(p, {I, V, I});
        EXPECT_TRUE(std::isfinite(m.power_W)) << I << " A, " << V << " V";
        EXPECT_TRUE(!m.resistance_valid || std::isfinite(m.resistance_ohm + m.resistance_sd_ohm))
            << I << " A, " << V << " V";
        EXPECT_TRUE(!m.stress_valid || std::isfinite(m.stress_Pa)) << I << " N";
      }
    }
  }
}

TEST(MeasureNoise, DeviationIsThatOfManySamples) {
  struct Case {
    double current_A, current_noise_A, voltage_noise_V, lead_ohm;
  };
  const std::array<Case, 4> cases{{{0.2, 10e-6, 0.5e-3, 0},     // voltage noise counts
                                   {0.02, 200e-6, 0.1e-3, 0},   // current noise counts
                                   {-0.1, 100e-6, 2e-3, 0},     // both
                                   {0.1, 400e-6, 0.2e-3, 5}}};  // through the leads as well
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const Case& c : cases) {
    MeasurementParams<double> p = bench<double>();
    p.current_noise_A = c.current_noise_A;
    p.voltage_noise_V = c.voltage_noise_V;
    p.lead_resistance_ohm = c.lead_ohm;
    const double R = 22;
    const int count = 20000;
    double sum = 0;
    double square = 0;
    double stated = 0;
    for (int i = 0; i < count; ++i) {
      const Measurement<double> m = measure<double>(
          p, {c.current_A + c.current_noise_A * normal(random),
              c.current_A * (R + c.lead_ohm) + c.voltage_noise_V * normal(random), 0.9});
      sum += m.resistance_ohm - R;
      square += (m.resistance_ohm - R) * (m.resistance_ohm - R);
      stated += m.resistance_sd_ohm / count;
    }
    const double mean = sum / count;
    const double sd = std::sqrt(square / count - mean * mean);
    // The deviation of 20000 samples is itself known to 0.5 %.
    EXPECT_NEAR(stated / sd, 1, 0.02) << "at " << c.current_A << " A";
    EXPECT_NEAR(mean / sd, 0, 0.05) << "at " << c.current_A << " A";
  }
}

}  // namespace
}  // namespace smaservo::measurement_test
