#include "host-sim/identify/classic.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "host-sim/measured_data.hpp"

namespace smaservo::test {
namespace {

constexpr double pi = std::numbers::pi;

struct Truth {
  double martensite_strain, austenite_strain;
  double heating_K, heating_width_K, cooling_K, cooling_width_K;
};

using Fraction = std::function<double(double)>;

double cosine(double u) {
  return u <= -0.5 ? 1 : u >= 0.5 ? 0 : std::pow(std::cos(0.5 * pi * (u + 0.5)), 2);
}
double hyperbolic(double u) {
  return 1 / (1 + std::exp(2 * u));
}
double arctan(double u) {
  return std::atan2(1, u) / pi;
}

/// From 290 K to 420 K and back, 600 rows.
Run bath(const Truth& truth, const Fraction& fraction) {
  Run run{"bath", RunKind::bath, {}, {}, {}, {}, {}, {}, {}, {}, {}};
  for (int i = 0; i < 600; ++i) {
    const bool cools = i > 300;
    const double T = cools ? 420 - 130.0 / 299 * (i - 300) : 290 + 130.0 / 300 * i;
    const double u = cools ? (T - truth.cooling_K) / truth.cooling_width_K
                           : (T - truth.heating_K) / truth.heating_width_K;
    run.temperature_K.push_back(T);
    run.stress_Pa.push_back(100e6);
    run.strain.push_back(truth.austenite_strain +
                         (truth.martensite_strain - truth.austenite_strain) * fraction(u));
  }
  return run;
}

void expect_recovered(const ClassicFit& fit, const Truth& truth, double tolerance) {
  EXPECT_LT(fit.max, tolerance);
  EXPECT_NEAR(fit.martensite_strain, truth.martensite_strain, 0.05 * tolerance);
  EXPECT_NEAR(fit.austenite_strain, truth.austenite_strain, 0.05 * tolerance);
  EXPECT_NEAR(fit.heating_K, truth.heating_K, 20 * tolerance);
  EXPECT_NEAR(fit.cooling_K, truth.cooling_K, 20 * tolerance);
  EXPECT_NEAR(fit.heating_width_K, truth.heating_width_K, 50 * tolerance);
  EXPECT_NEAR(fit.cooling_width_K, truth.cooling_width_K, 50 * tolerance);
}

TEST(Classics, EachFindsItsOwnCurveAndFitsItBest) {
  std::mt19937_64 random(1);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Fraction shapes[] = {cosine, hyperbolic, arctan};
  const char* const names[] = {"cosine", "tanh", "arctan"};
  for (int round = 0; round < 8; ++round) {
    const Truth truth{between(0.03, 0.05), between(-0.003, 0.003), between(355, 370),
                      between(2.5, 7),     between(325, 345),      between(2.5, 7)};
    for (std::size_t shape = 0; shape < 3; ++shape) {
      SCOPED_TRACE(testing::Message() << "round " << round << ", " << names[shape]);
      Truth scaled = truth;
      if (shape == 0) {  // from start to finish
        scaled.heating_width_K *= 4;
        scaled.cooling_width_K *= 4;
      }
      const auto fits = fit_classics(bath(scaled, shapes[shape]));
      ASSERT_EQ(fits.size(), 3U);
      expect_recovered(fits[shape], scaled, 1e-4);
      for (std::size_t other = 0; other < 3; ++other) {
        EXPECT_EQ(fits[other].name, names[other]);
        EXPECT_LE(fits[other].rms, fits[other].max);
        EXPECT_LE(fits[other].p95, fits[other].max);
        if (other != shape) {
          EXPECT_GT(fits[other].rms, 0.003);
        }
      }
    }
  }
}

TEST(Classics, SameRunSameBits) {
  const auto run = bath({0.04, 0, 360, 5, 335, 4}, arctan);
  const auto first = fit_classics(run), second = fit_classics(run);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(first[i].strain, second[i].strain);
  }
}

TEST(Classics, OnlyOneFullCycleAtConstantStressCounts) {
  const auto good = bath({0.04, 0, 360, 5, 335, 4}, hyperbolic);
  ASSERT_FALSE(fit_classics(good).empty());
  const auto without = [&](const std::function<void(smaservo::Run&)>& spoil) {
    smaservo::Run run = good;
    spoil(run);
    return fit_classics(run).empty();
  };
  EXPECT_TRUE(without([](smaservo::Run& run) { run.kind = RunKind::settled; }));
  EXPECT_TRUE(without([](smaservo::Run& run) { run.strain.clear(); }));
  EXPECT_TRUE(without([](smaservo::Run& run) {
    for (std::size_t i = 0; i < 300; ++i) run.stress_Pa[i] = 120e6;
  })) << "another stress on heating";
  EXPECT_TRUE(without([](smaservo::Run& run) {
    for (auto* column : {&run.temperature_K, &run.strain, &run.stress_Pa}) column->resize(350);
  })) << "does not cool down";
  EXPECT_TRUE(without([](smaservo::Run& run) {
    for (auto* column : {&run.temperature_K, &run.strain, &run.stress_Pa}) {
      const std::vector<double> once = *column;
      column->insert(column->end(), once.begin(), once.end());
    }
  })) << "two cycles";
}

struct Measured {
  const char* file;
  double cosine, tanh, arctan;  ///< rms in per cent of the stroke
};

TEST_F(MeasuredData, ClassicsOfFlexinol) {
  constexpr Measured wires[] = {{"flexinol_50MPa.csv", 3.71, 2.99, 1.56},
                                {"flexinol_100MPa.csv", 3.88, 3.11, 1.78},
                                {"flexinol_200MPa.csv", 4.14, 3.39, 2.21}};
  for (const Measured& wire : wires) {
    SCOPED_TRACE(wire.file);
    const auto fits = fit_classics(read_run(file(wire.file), {{0.1, 150e-6}, {}, {}, {}}));
    ASSERT_EQ(fits.size(), 3U);
    // A least-squares fit has one answer: 1 % is the rounding of these figures.
    EXPECT_NEAR(100 * fits[0].rms, wire.cosine, 0.01 * wire.cosine);
    EXPECT_NEAR(100 * fits[1].rms, wire.tanh, 0.01 * wire.tanh);
    EXPECT_NEAR(100 * fits[2].rms, wire.arctan, 0.01 * wire.arctan);
  }
}

}  // namespace
}  // namespace smaservo::test
