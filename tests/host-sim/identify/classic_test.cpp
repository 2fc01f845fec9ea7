#include "host-sim/identify/classic.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "model/wire/three_phase/ihyp.hpp"
#include "tests/host-sim/replay/measured_data.hpp"

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

/// A bath run from 290 K to 420 K and back, with 600 rows.
identify::Run bath(const Truth& truth, const Fraction& fraction) {
  identify::Run run{};
  run.name = "bath";
  run.kind = identify::RunKind::bath;
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

void expect_recovered(const identify::ClassicFit& fit, const Truth& truth, double tolerance) {
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
      if (shape == 0) {  // the cosine's width extends from start to finish
        scaled.heating_width_K *= 4;
        scaled.cooling_width_K *= 4;
      }
      const auto fits = identify::fit_classics(bath(scaled, shapes[shape]));
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

/// The value of the curve, found by bisection on its parameter with de Casteljau's construction.
double bezier_by_bisection(const identify::BezierShape<double>& shape, double t) {
  const auto point = [](double s, double a, double b, double c, double d) {
    double p[] = {a, b, c, d};
    for (int left = 3; left > 0; --left) {
      for (int i = 0; i < left; ++i) {
        p[i] = (1 - s) * p[i] + s * p[i + 1];
      }
    }
    return p[0];
  };
  double low = 0;
  double high = 1;
  for (int i = 0; i < 60; ++i) {
    const double s = 0.5 * (low + high);
    (point(s, 0, shape.t_1, shape.t_2, 1) < t ? low : high) = s;
  }
  return point(low, 1, shape.z_1, shape.z_2, 0);
}

identify::BezierShape<double> random_bezier(std::mt19937_64& random) {
  identify::BezierShape<double> shape{};
  for (double* t : {&shape.t_1, &shape.t_2}) {
    *t = std::uniform_real_distribution<double>(0.02, 0.98)(random);
  }
  for (double* z : {&shape.z_1, &shape.z_2}) {
    *z = std::uniform_real_distribution<double>(0, 1)(random);
  }
  return shape;
}

TEST(Bezier, IsWhatBisectionFinds) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const identify::BezierShape<double> shape = random_bezier(random);
    const double t = std::uniform_real_distribution<double>(0, 1)(random);
    // Where the curve is steep, rounding makes its parameter uncertain by the square root of the
    // rounding error.
    EXPECT_NEAR(identify::bezier_fraction(shape, t), bezier_by_bisection(shape, t), 1e-9) << t;
  }
}

TEST(Bezier, SteepestAndStraightCurvesAndTheEnds) {
  const identify::BezierShape<double> shapes[] = {{1.0 / 3, 2.0 / 3, 2.0 / 3, 1.0 / 3},
                                                  {0.98, 0.02, 1, 0},
                                                  {0.02, 0.98, 0, 1},
                                                  {0.02, 0.02, 1, 1},
                                                  {0.98, 0.98, 0, 0}};
  for (const identify::BezierShape<double>& shape : shapes) {
    for (int i = 0; i <= 1000; ++i) {
      const double t = i / 1000.0;
      EXPECT_NEAR(identify::bezier_fraction(shape, t), bezier_by_bisection(shape, t), 1e-9) << t;
    }
    EXPECT_EQ(identify::bezier_fraction(shape, 0.0), 1);
    EXPECT_EQ(identify::bezier_fraction(shape, -3.0), 1);
    EXPECT_EQ(identify::bezier_fraction(shape, 1.0), 0);
    EXPECT_EQ(identify::bezier_fraction(shape, 3.0), 0);
  }
  EXPECT_NEAR(identify::bezier_fraction(shapes[0], 0.3), 0.7, 1e-15);  // a straight line
}

TEST(Adaptable, EachFindsItsOwnCurveAndFitsItBest) {
  std::mt19937_64 random(3);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int round = 0; round < 2; ++round) {
    SCOPED_TRACE(round);
    const double curvature = between(0.5, 4);
    const double turning = between(0.3, 0.7);
    const Fraction ihyp = [&](double u) {
      return ihyp_fraction(IhypShape<double>{curvature, turning}, u + 0.5).remaining;
    };
    const double heating_K = between(350, 365);
    const Truth narrow{0.04, 0.001, heating_K, between(5, 10), heating_K - 25, between(5, 10)};
    const auto of_ihyp = identify::fit_adaptable(bath(narrow, ihyp));
    ASSERT_EQ(of_ihyp.size(), 2U);
    EXPECT_EQ(of_ihyp[1].name, "ihyp");
    expect_recovered(of_ihyp[1], narrow, 1e-4);
    EXPECT_GT(of_ihyp[0].rms, 0.001);

    const identify::BezierShape<double> shape{between(0.3, 0.8), between(0.3, 0.8), between(0.6, 1),
                                              between(0, 0.4)};
    const Fraction bezier = [&](double u) { return identify::bezier_fraction(shape, u + 0.5); };
    Truth wide = narrow;
    wide.heating_width_K *= 5;
    wide.cooling_width_K *= 5;
    const auto of_bezier = identify::fit_adaptable(bath(wide, bezier));
    EXPECT_EQ(of_bezier[0].name, "Bezier");
    EXPECT_LT(of_bezier[0].rms, 5e-4);
    EXPECT_GT(of_bezier[1].rms, 2 * of_bezier[0].rms);
  }
}

TEST(Classics, SameRunSameBits) {
  const auto run = bath({0.04, 0, 360, 5, 335, 4}, arctan);
  const auto first = identify::fit_classics(run), second = identify::fit_classics(run);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(first[i].strain, second[i].strain);
  }
}

/// It does not matter where on its way around the loop a measurement begins.
TEST(Classics, ACycleMayBeginHot) {
  smaservo::identify::Run run = bath({0.04, 0, 360, 5, 335, 4}, arctan);
  const auto cold = identify::fit_classics(run);
  const auto hottest = std::ranges::max_element(run.temperature_K) - run.temperature_K.begin();
  for (auto* column : {&run.temperature_K, &run.strain, &run.stress_Pa}) {
    std::ranges::rotate(*column, column->begin() + hottest);
  }
  const auto hot = identify::fit_classics(run);
  ASSERT_EQ(hot.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(hot[i].rms, cold[i].rms, 1e-5);
    EXPECT_NEAR(hot[i].heating_K, cold[i].heating_K, 0.01);
    for (std::size_t row = 0; row < run.strain.size(); ++row) {
      const std::size_t there = (row + static_cast<std::size_t>(hottest)) % run.strain.size();
      EXPECT_NEAR(hot[i].strain[row], cold[i].strain[there], 1e-4);
    }
  }
}

TEST(Classics, OnlyOneFullCycleAtConstantStressCounts) {
  const auto good = bath({0.04, 0, 360, 5, 335, 4}, hyperbolic);
  ASSERT_FALSE(identify::fit_classics(good).empty());
  const auto without = [&](const std::function<void(smaservo::identify::Run&)>& spoil) {
    smaservo::identify::Run run = good;
    spoil(run);
    return identify::fit_classics(run).empty();
  };
  EXPECT_TRUE(without([](smaservo::identify::Run& run) { run.kind = identify::RunKind::settled; }));
  EXPECT_TRUE(without([](smaservo::identify::Run& run) { run.strain.clear(); }));
  EXPECT_TRUE(without([](smaservo::identify::Run& run) {
    for (std::size_t i = 0; i < 300; ++i) {
      run.stress_Pa[i] = 120e6;
    }
  })) << "another stress on heating";
  EXPECT_TRUE(without([](smaservo::identify::Run& run) {
    for (auto* column : {&run.temperature_K, &run.strain, &run.stress_Pa}) {
      column->resize(350);
    }
  })) << "does not cool down";
  EXPECT_TRUE(without([](smaservo::identify::Run& run) {
    for (auto* column : {&run.temperature_K, &run.strain, &run.stress_Pa}) {
      const std::vector<double> once = *column;
      column->insert(column->end(), once.begin(), once.end());
    }
  })) << "two cycles";
}

struct Measured {
  const char* file;
  double cosine, tanh, arctan;  ///< rms in per cent of the stroke
  double ihyp;
};

TEST_F(MeasuredData, ClassicsOfFlexinol) {
  constexpr Measured wires[] = {{"flexinol_50MPa.csv", 3.71, 2.99, 1.56, 0.75},
                                {"flexinol_100MPa.csv", 3.88, 3.11, 1.78, 0.72},
                                {"flexinol_200MPa.csv", 4.14, 3.39, 2.21, 0.58}};
  for (const Measured& wire : wires) {
    SCOPED_TRACE(wire.file);
    const smaservo::identify::Run run =
        identify::read_run(file(wire.file), {{0.1, 150e-6}, {}, {}, {}});
    const auto fits = identify::fit_classics(run);
    ASSERT_EQ(fits.size(), 3U);
    // A least-squares fit has a single solution. The tolerance of 1 % covers only the rounding of
    // the figures in `wires`.
    EXPECT_NEAR(100 * fits[0].rms, wire.cosine, 0.01 * wire.cosine);
    EXPECT_NEAR(100 * fits[1].rms, wire.tanh, 0.01 * wire.tanh);
    EXPECT_NEAR(100 * fits[2].rms, wire.arctan, 0.01 * wire.arctan);
    // 000, figure 5: Bezier is much better than the classics, and ihyp better with half of its
    // parameters.
    const auto adaptable = identify::fit_adaptable(run);
    ASSERT_EQ(adaptable.size(), 2U);
    EXPECT_LT(adaptable[0].rms, 0.75 * fits[2].rms);
    EXPECT_GT(adaptable[0].rms, adaptable[1].rms);
    EXPECT_NEAR(100 * adaptable[1].rms, wire.ihyp, 0.01 * wire.ihyp);
  }
}

}  // namespace
}  // namespace smaservo::test
