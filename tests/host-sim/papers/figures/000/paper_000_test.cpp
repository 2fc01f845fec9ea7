// What the text of paper 000 says of its figures, held against the numbers that are drawn here.

#include "host-sim/papers/figures/000/paper_000.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "model/units.hpp"
#include "model/wire/three_phase/ihyp.hpp"
#include "tests/host-sim/replay/measured_data.hpp"

namespace smaservo::figures::paper_000 {
namespace {

void expect_between(double value, double low, double high) {
  EXPECT_GE(value, low);
  EXPECT_LE(value, high);
}

double peak_r_phase(const BathRun& run) {
  double peak = 0;
  for (const Phases<double>& z : run.phases) {
    peak = std::max(peak, z.r_phase);
  }
  return peak;
}

/// Root mean square of a - b.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    squares += (a[i] - b[i]) * (a[i] - b[i]);
  }
  return std::sqrt(squares / static_cast<double>(a.size()));
}

/// Change of a column on heating or cooling from one temperature to another, as a share of its
/// whole change there.
double share(const CalorimetryRun& run, const std::vector<double>& column, bool cools,
             double from_degC, double to_degC) {
  const auto at = [&](double degC) {
    std::size_t nearest = cools ? run.hottest() : 0;
    for (std::size_t i = nearest; i < (cools ? column.size() : run.hottest() + 1); ++i) {
      if (std::abs(run.temperature_K[i] - degC - zero_degC_K) <
          std::abs(run.temperature_K[nearest] - degC - zero_degC_K)) {
        nearest = i;
      }
    }
    return column[nearest];
  };
  return (at(to_degC) - at(from_degC)) / (at(cools ? 20 : 100) - at(cools ? 100 : 20));
}

// 'Analysis of phase transformations', figure 1
TEST(Paper000, TransformsAt75And60And40DegreesWithoutStress) {
  const Peaks simulated = peaks(simulated_calorimetry());
  EXPECT_NEAR(simulated.m2a_K - zero_degC_K, 75, 2.1);
  EXPECT_NEAR(simulated.a2r_K - zero_degC_K, 60, 2.1);
  EXPECT_NEAR(simulated.r2m_K - zero_degC_K, 40, 2.1);
  const auto middle_degC = [](const Surface<double>& surface) {
    const Isobar<double> at = isobar(surface, 0.0);
    return at.start_K + 0.5 / at.per_K - zero_degC_K;
  };
  const ThreePhaseParams<double>& k = paper_wire().kinetics;
  EXPECT_NEAR(middle_degC(k.m2a), 75, 1);
  EXPECT_NEAR(middle_degC(second_surface(k.a2m_a2r)), 60, 1);
  EXPECT_NEAR(middle_degC(first_surface(k.a2m_a2r)), 40, 1);
}

TEST(Paper000, HeatingIsOneTransformationAndCoolingTwo) {
  const CalorimetryRun run = simulated_calorimetry();
  // Strain and resistance drop together.
  expect_between(share(run, run.strain, false, 60, 85), 0.85, 1);
  expect_between(share(run, run.resistivity_ohm_m, false, 60, 85), 0.85, 1.1);
  // A2R: a rise of the resistance without much impact on the strain.
  expect_between(share(run, run.resistivity_ohm_m, true, 66, 54), 0.4, 0.7);
  expect_between(share(run, run.strain, true, 66, 54), 0.01, 0.1);
  // R2M: an elongation, while the resistance changes only gradually.
  expect_between(share(run, run.strain, true, 46, 34), 0.5, 0.8);
  expect_between(share(run, run.resistivity_ohm_m, true, 46, 34), 0.05, 0.25);
}

TEST(Paper000, CalorimetryTakesInWhatItGivesBack) {
  const CalorimetryRun run = simulated_calorimetry();
  const HeatParams<double>& heat = paper_wire().heat;
  double in_J_kg = 0;
  for (std::size_t i = 1; i <= run.hottest(); ++i) {
    const double step_K = run.temperature_K[i] - run.temperature_K[i - 1];
    in_J_kg += run.transforming_W_kg[i] * step_K * 6;  // 6 s for a kelvin
  }
  EXPECT_NEAR(in_J_kg, heat.latent_m2a_J_kg, 0.01 * heat.latent_m2a_J_kg);
}

// 'Impact of R-phase on strain-resistance relationship' and 'Summary and outlook'
TEST(Paper000, RPhaseIs70PercentAt10MPaAndFeltUpToAlmost250) {
  const BathRun runs[] = {simulated_bath_run(10), model_bath_run(paper_wire(), 10)};
  for (const BathRun& run : runs) {
    expect_between(peak_r_phase(run), 0.65, 0.78);
  }
  // The identified model has less of an R-phase that resists more: resistance tells the product.
  expect_between(peak_r_phase(model_bath_run(fitted_model(), 10)), 0.55, 0.75);
  for (const double stress_MPa : {100.0, 250.0, 400.0}) {
    const double low = stress_MPa == 100 ? 0.3 : stress_MPa == 250 ? 0.08 : 0.01;
    const double high = stress_MPa == 100 ? 0.56 : stress_MPa == 250 ? 0.13 : 0.08;
    expect_between(peak_r_phase(simulated_bath_run(stress_MPa)), low, high);
    expect_between(peak_r_phase(model_bath_run(fitted_model(), stress_MPa)), low, high);
    expect_between(peak_r_phase(model_bath_run(paper_wire(), stress_MPa)), low, high);
  }
}

TEST(Paper000, StrainOverResistanceIsStraightBetween150And250MPa) {
  for (const bool simulated : {true, false}) {
    SCOPED_TRACE(simulated ? "simulated wire" : "model");
    const auto at = [&](double stress_MPa) {
      return self_sensing(simulated ? simulated_bath_run(stress_MPa)
                                    : model_bath_run(fitted_model(), stress_MPa));
    };
    // 'below 150 MPa ... a wide gap'
    expect_between(at(10).gap, 0.28, 0.40);
    expect_between(at(50).gap, 0.22, 0.32);
    expect_between(at(100).gap, 0.14, 0.22);
    expect_between(at(10).deviation, 0.06, 0.09);
    // 'relatively linear and hysteresis-free'
    expect_between(at(150).gap, 0.04, 0.11);
    expect_between(at(200).gap, -0.06, 0.06);
    expect_between(at(250).gap, -0.06, -0.02);
    for (const double stress_MPa : {150.0, 200.0, 250.0}) {
      expect_between(at(stress_MPa).deviation, 0.02, 0.035);
    }
    // Beyond, without R-phase, the hotter heating has the higher resistance.
    expect_between(at(400).gap, -0.10, -0.055);
    EXPECT_GT(at(400).deviation, at(250).deviation);
  }
}

// 'Transformation function', figure 5
TEST(Paper000, AdaptableFunctionsFitTwiceAsWellAsTheClassics) {
  for (const double stress_MPa : {10.0, 100.0, function_stress_MPa, 400.0}) {
    const std::vector<identify::ClassicFit> fits =
        transformation_functions(simulated_bath_run(stress_MPa));
    ASSERT_EQ(fits.size(), 5U);
    double best_classic = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
      expect_between(fits[i].rms, 0.019, 0.033);
      best_classic = std::min(best_classic, fits[i].rms);
    }
    EXPECT_EQ(fits[3].name, "Bezier");
    expect_between(fits[3].rms, 0.003, 0.3 * best_classic);
    EXPECT_EQ(fits[4].name, "ihyp");
    expect_between(fits[4].rms, 0.007, 0.55 * best_classic);
  }
}

// Figure 6: 'the sum of two hyperbolic functions and a linear function'
TEST(Paper000, IhypIsTwoHyperbolasAndALine) {
  std::mt19937_64 random(6);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 1000; ++i) {
    const double curvature = between(0.01, 10);
    const double turning = between(0.1, 0.9);
    const IhypShape<double> shape{curvature, turning};
    const double x = between(0.01, 0.98);
    const double further = x + 0.01;
    const IhypParts a = ihyp_parts(shape, x);
    const IhypParts b = ihyp_parts(shape, further);
    const double sum = ihyp_temperature(shape, Split<double>{x, 1 - x});
    EXPECT_NEAR(a.initial + a.target + a.line, sum, 1e-12 * (1 + std::abs(sum) + curvature / x));
    EXPECT_NEAR(a.initial * x, b.initial * further, 1e-13 * curvature);
    EXPECT_NEAR(a.target * (1 - x), b.target * (1 - further), 1e-13 * curvature);
    EXPECT_NEAR((b.line - a.line) / 0.01, 1 - curvature, 1e-11 * (1 + curvature));
  }
}

// 'Switching the transformation direction', figure 8
TEST(Paper000, InnerLoopConvertsTheSameShareAsTheOuterCurve) {
  const InnerLoop loop = inner_loop();
  const double reversal = loop.back.front();
  const auto outer = [&](double T) {
    const auto row = static_cast<std::size_t>(std::lround(
        (T - loop.temperature_K.front()) / (loop.temperature_K[1] - loop.temperature_K[0])));
    return loop.cooling[row];
  };
  const double left = 1 - outer(loop.back_K.front());
  expect_between(reversal, 0.35, 0.5);
  for (std::size_t i = 0; i < loop.back.size(); ++i) {
    const double expected = 1 - (1 - reversal) * (1 - outer(loop.back_K[i])) / left;
    // A2R has not gone completely: 0.4 % of austenite become R-phase, far below its temperature.
    EXPECT_NEAR(loop.back[i], expected, 1e-3);
    EXPECT_GE(loop.back[i], outer(loop.back_K[i]));
  }
}

// 'Heating process' and 'Cooling process for three phase fractions', figures 9 and 10
TEST(Paper000, BarsOfHeatingFollowOneAnother) {
  const std::vector<HeatingBar> bars = heating_bars();
  ASSERT_GE(bars.size(), 10U);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const HeatingBar& b = bars[i];
    EXPECT_NEAR(b.martensite + b.m2a + b.austenite + b.r2a + b.r_phase, 1, 1e-14);
    for (const double part : {b.martensite, b.m2a, b.austenite, b.r2a, b.r_phase}) {
      EXPECT_GT(part, 0);
    }
    // M2A and R2A do not influence each other and have the same surface, so martensite and R-phase
    // lose the same share.
    EXPECT_NEAR(b.m2a / (b.m2a + b.martensite), b.r2a / (b.r2a + b.r_phase), 1e-13);
    if (i > 0) {
      EXPECT_NEAR(b.austenite, bars[i - 1].austenite + bars[i - 1].m2a + bars[i - 1].r2a, 1e-14);
    }
  }
}

TEST(Paper000, BarsOfCoolingFollowOneAnother) {
  const std::vector<CoolingBar> bars = cooling_bars();
  ASSERT_GE(bars.size(), 10U);
  double contested = 0;
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const CoolingBar& b = bars[i];
    EXPECT_NEAR(b.martensite + b.a2m + b.either + b.austenite + b.a2r + b.r_phase + b.r2m, 1,
                1e-14);
    for (const double part :
         {b.martensite, b.a2m, b.either, b.austenite, b.a2r, b.r_phase, b.r2m}) {
      EXPECT_GE(part, 0);
    }
    contested = std::max(contested, b.either);
    if (i > 0) {
      // What the model's own step has made of the bar before; what is contested ends as
      // martensite, by way of R-phase.
      const CoolingBar& before = bars[i - 1];
      EXPECT_NEAR(b.martensite, before.martensite + before.a2m + before.either + before.r2m, 1e-12);
      EXPECT_NEAR(b.r_phase + b.r2m, before.r_phase + before.a2r, 1e-12);
      EXPECT_NEAR(b.austenite + b.a2m + b.either + b.a2r, before.austenite, 1e-12);
    }
  }
  expect_between(contested, 0.02, 0.3);
}

// 'Experimental results'
TEST(Paper000, FifteenRunsFrom20To150Degrees) {
  EXPECT_EQ(stresses_MPa.size(), 15U);
  EXPECT_EQ(stresses_MPa.front(), 10);
  EXPECT_EQ(stresses_MPa.back(), 400);
  const BathRun run = simulated_bath_run(stresses_MPa.back());
  EXPECT_DOUBLE_EQ(run.temperature_K.front(), 20 + zero_degC_K);
  EXPECT_DOUBLE_EQ(run.temperature_K[run.hottest()], 150 + zero_degC_K);
  EXPECT_DOUBLE_EQ(run.temperature_K.back(), 20 + zero_degC_K);
  // From full martensite, and at this stress back to it.
  EXPECT_GT(run.phases.front().martensite, 0.999);
  EXPECT_LT(run.phases[run.hottest()].martensite, 0.001);
}

// 'Stress-free phase transformation', figure 14
TEST(Paper000, CalorimetryFindsTheTransitions) {
  const identify::FitResult& fit = fitted_without_stress();
  expect_between(fit.runs.front().power.rms, 0.01, 0.045);
  const ThreePhaseParams<double>& k = fit.wire.kinetics;
  const auto turning_degC = [](const Surface<double>& surface) {
    const Isobar<double> at = isobar(surface, 0.0);
    return at.start_K + at.shape.turning / at.per_K - zero_degC_K;
  };
  EXPECT_NEAR(turning_degC(k.m2a), 75, 2);
  EXPECT_NEAR(turning_degC(second_surface(k.a2m_a2r)), 60, 2);
  EXPECT_NEAR(turning_degC(first_surface(k.a2m_a2r)), 40, 3);
}

// 'Model parameters for different stress levels', figure 15
TEST(Paper000, EachLevelIsFittedWell) {
  const std::vector<Level>& levels = fitted_levels();
  ASSERT_EQ(levels.size(), 1 + stresses_MPa.size());
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const double stress_MPa = levels[i].stress_MPa;
    SCOPED_TRACE(stress_MPa);
    const BathRun wire = simulated_bath_run(stress_MPa);
    const BathRun model = model_bath_run(levels[i].wire, stress_MPa);
    expect_between(difference(wire.strain, model.strain), 0.005 * 0.04, 0.015 * 0.04);
    expect_between(difference(wire.resistivity_ohm_m, model.resistivity_ohm_m), 0.2e-9, 4e-9);
  }
}

// 'Stress dependence of the transformation parameters', figure 16
TEST(Paper000, TransitionTemperaturesOverStress) {
  const auto turning_K = [](const Surface<double>& surface, double stress_Pa) {
    const Isobar<double> at = isobar(surface, stress_Pa);
    return at.start_K + at.shape.turning / at.per_K;
  };
  const ThreePhaseParams<double>& all = fitted_model().kinetics;
  const double step_Pa = 400e6;
  for (const Surface<double>& surface : {all.m2a, first_surface(all.a2m_a2r)}) {
    const double K_MPa = (turning_K(surface, step_Pa) - turning_K(surface, 0)) / 400;
    expect_between(K_MPa, 0.12, 0.15);
  }
  // A2R: stress-independent in the paper; the simulated wire has 0.01 K/MPa
  const Surface<double> a2r = second_surface(all.a2m_a2r);
  expect_between((turning_K(a2r, step_Pa) - turning_K(a2r, 0)) / 400, 0, 0.03);
  // The levels by themselves lie on M2A's straight line.
  for (const Level& level : fitted_levels()) {
    const double stress_Pa = 1e6 * level.stress_MPa;
    EXPECT_NEAR(turning_K(level.wire.kinetics.m2a, stress_Pa), turning_K(all.m2a, stress_Pa), 1.5)
        << level.stress_MPa;
  }
}

// 'Stress dependence of the material parameters', figure 18
TEST(Paper000, PurePhasesOverStress) {
  for (const Material<double>& m : {paper_wire().material, fitted_model().material}) {
    // The specific resistance of austenite rises with stress, that of martensite does not.
    EXPECT_EQ(m.martensite.resistivity_ohm_m_Pa, 0);
    expect_between(m.austenite.resistivity_ohm_m_Pa * 400e6, 0.02e-6, 0.06e-6);
    EXPECT_GT(m.r_phase.resistivity_ohm_m_Pa, 0);
    // Martensite is softer and longer than austenite; R-phase hardly longer.
    expect_between(m.martensite.modulus_Pa, 25e9, 40e9);
    expect_between(m.austenite.modulus_Pa, 60e9, 90e9);
    expect_between(m.martensite.strain, 0.04, 0.045);
    expect_between(m.r_phase.strain, 0.002, 0.006);
  }
}

// 'Measured and modeled strain and resistance surfaces', figure 19
TEST(Paper000, ModelAgreesWhereItWasNotFitted) {
  for (const double stress_MPa : {25.0, 150.0, 250.0, 350.0}) {
    const BathRun wire = simulated_bath_run(stress_MPa);
    const BathRun model = model_bath_run(fitted_model(), stress_MPa);
    expect_between(difference(wire.strain, model.strain), 0.005 * 0.04, 0.016 * 0.04);
    expect_between(difference(wire.resistivity_ohm_m, model.resistivity_ohm_m), 0.5e-9, 3e-9);
  }
}

}  // namespace
}  // namespace smaservo::figures::paper_000
