#include "model/papers/resistance_lines.hpp"

#include <gtest/gtest.h>

#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::resistance_lines_test {
namespace {

using K = papers::LiangRogers<double>;
using Lines = papers::ResistanceLines<double>;

Material<double> material() {
  Material<double> m = paper_wire().material;
  m.mixture = Mixture::series;
  return m;
}

/// The state's own point.
papers::ResistancePoint<double> point(const K::State& s) {
  const Material<double> m = material();
  const Drive<double> u = K::drive(s);
  const double strain = papers::mixed_modulus_strain(m, K::phases(s), u.stress_Pa);
  const double rho = resistivity(m, K::phases(s), u).value;
  return {strain, resistance_ohm(rho, 1.0, strain) / m.martensite.resistivity_ohm_m};
}

/// Strain by the line that two points make.
void expect_through(const papers::ResistanceBranch<double>& branch,
                    const papers::ResistancePoint<double>& start,
                    const papers::ResistancePoint<double>& finish) {
  EXPECT_NEAR(branch.start.strain, start.strain, 1e-12);
  EXPECT_NEAR(branch.start.resistance, start.resistance, 1e-12);
  EXPECT_NEAR(branch.finish.strain, finish.strain, 1e-12);
  EXPECT_NEAR(branch.finish.resistance, finish.resistance, 1e-12);
  ASSERT_TRUE(branch.valid);
  EXPECT_NEAR(branch.line.strain(start.resistance), start.strain, 1e-10);
  EXPECT_NEAR(branch.line.strain(finish.resistance), finish.strain, 1e-10);
}

TEST(ResistanceLines, PassThroughTheSimulatedLoopsOwnPoints) {
  const K::Params p = flexinol_liang_rogers<double>();
  for (double stress_Pa = 15e6; stress_Pa < 400e6; stress_Pa += 20e6) {
    SCOPED_TRACE(stress_Pa);
    K::State s = K::rest(p, {290, stress_Pa});
    const auto at = [&](const papers::CosineProcess<double>& process, double zero_stress_K) {
      const double goal_K = zero_stress_K + stress_Pa / process.stress_Pa_K;
      const double from_K = K::drive(s).temperature_K;
      for (int i = 1; i <= 200; ++i) {
        K::advance(p, s, {from_K + (goal_K - from_K) * i / 200, stress_Pa});
      }
      return point(s);
    };
    const auto heating_start = at(p.m2a, p.m2a.start_K);
    const auto heating_finish = at(p.m2a, p.m2a.finish_K);
    const auto cooling_start = at(p.a2m, p.a2m.start_K);
    const auto cooling_finish = at(p.a2m, p.a2m.finish_K);
    const Lines lines = Lines::at(p, material(), stress_Pa);
    expect_through(lines.heating, heating_start, heating_finish);
    expect_through(lines.cooling, cooling_start, cooling_finish);
  }
}

// 002 section 3.2 and figure 8: stress changes the cooling line far more than the heating line.
TEST(ResistanceLines, StressChangesCoolingMoreThanHeating) {
  const K::Params p = flexinol_liang_rogers<double>();
  const auto slopes = [&](double stress_Pa) { return Lines::at(p, material(), stress_Pa); };
  const auto low = slopes(15e6);
  const auto high = slopes(175e6);
  const double heating = high.heating.line.slope / low.heating.line.slope;
  const double cooling = high.cooling.line.slope / low.cooling.line.slope;
  EXPECT_TRUE(heating > 0.8 && heating < 1.25) << heating;
  EXPECT_TRUE(cooling < 0.6) << cooling;
}

TEST(ResistanceLines, SayWhereTheLineIsUpright) {
  Material<double> m = material();
  const K::Params p = flexinol_liang_rogers<double>();
  // The resistivity of R-phase that makes M_s as resistive as M_f, found by bisection.
  double low = 0.9 * m.martensite.resistivity_ohm_m;
  double high = 1.3 * m.martensite.resistivity_ohm_m;
  for (int i = 0; i < 60; ++i) {
    m.r_phase.resistivity_ohm_m = 0.5 * (low + high);
    const auto cooling = Lines::at(p, m, 15e6).cooling;
    (cooling.start.resistance < cooling.finish.resistance ? low : high) =
        m.r_phase.resistivity_ohm_m;
  }
  EXPECT_FALSE(Lines::at(p, m, 15e6).cooling.valid);
  EXPECT_TRUE(Lines::at(p, m, 15e6).heating.valid);
}

}  // namespace
}  // namespace smaservo::test::resistance_lines_test
