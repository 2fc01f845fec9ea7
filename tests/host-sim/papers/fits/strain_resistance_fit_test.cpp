#include "host-sim/papers/fits/strain_resistance_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "model/files/error.hpp"

namespace smaservo::test {
namespace {

using Observer = papers::StrainResistance<double>;

/// The wire of these tests is the estimator's own model. Its transitions take a quarter of the way.
Observer::Params wire() {
  return {10,
          20e6,
          180e6,
          {{{0.25, 0.03}}, {{-0.22, -0.02}}},
          {{{0.27, 0.02}}, {{-0.245, -0.015}}},
          0.05,
          200,
          1e-9,
          0};
}

constexpr int leg_rows = 400;

identify::Run run_along(const std::vector<double>& turns, double stress_Pa,
                        identify::RunKind kind = identify::RunKind::joule) {
  smaservo::identify::Run run{};
  run.name = fmt::format("{:.0f} MPa", stress_Pa / 1e6);
  run.kind = kind;
  // Long enough for the low-pass to settle in each row
  constexpr double row_s = 1;
  for (std::size_t k = 1; k < turns.size(); ++k) {
    for (int i = 0; i < leg_rows; ++i) {
      const double lambda = turns[k - 1] + (turns[k] - turns[k - 1]) * i / leg_rows;
      run.resistance_ohm.push_back(wire().martensite_ohm * lambda);
      run.stress_Pa.push_back(stress_Pa);
      run.temperature_K.push_back(300);
      if (kind == identify::RunKind::joule) {
        run.time_s.push_back(row_s * static_cast<double>(run.time_s.size()));
      }
    }
  }
  run.strain.resize(run.resistance_ohm.size());
  run.strain = fits::estimate_strain(wire(), run);
  return run;
}

/// A full loop that finds the lines and is not recorded, another one and two minor ones.
identify::Run loops(double stress_Pa, identify::RunKind kind = identify::RunKind::joule) {
  identify::Run run = run_along({1.04, 0.85, 1.04, 0.85, 1.04, 0.85, 0.95, 0.88, 1.04, 0.94, 1.04},
                                stress_Pa, kind);
  for (auto* column :
       {&run.time_s, &run.stress_Pa, &run.strain, &run.resistance_ohm, &run.temperature_K}) {
    if (!column->empty()) {
      column->erase(column->begin(), column->begin() + std::ptrdiff_t{2} * leg_rows);
    }
  }
  return run;
}

std::vector<smaservo::identify::Run> runs(const std::vector<double>& stresses_MPa,
                                          identify::RunKind kind = identify::RunKind::joule) {
  std::vector<smaservo::identify::Run> all;
  all.reserve(stresses_MPa.size());
  for (const double stress_MPa : stresses_MPa) {
    all.push_back(loops(1e6 * stress_MPa, kind));
  }
  return all;
}

/// Greatest error of the fit on a run that it has not seen, in % of a stroke of 4 %.
double worst_percent(const fits::StrainResistanceFit& fit, double stress_Pa) {
  const smaservo::identify::Run fresh =
      run_along({1.04, 0.85, 0.99, 0.90, 1.02, 0.93, 1.04}, stress_Pa);
  const std::vector<double> strain = fits::estimate_strain(fit.params, fresh);
  double worst = 0;
  for (std::size_t i = 0; i < strain.size(); ++i) {
    worst = std::max(worst, std::abs(strain[i] - fresh.strain[i]) / 0.04);
  }
  return 100 * worst;
}

TEST(StrainResistanceFit, FindsTheEstimatorsOwnParameters) {
  const fits::StrainResistanceFit fit =
      fits::identify_strain_resistance(runs({20, 60, 100, 140, 180}));
  EXPECT_EQ(fit.order, 4);
  ASSERT_EQ(fit.levels.size(), 5U);
  const double scale = fit.params.martensite_ohm / wire().martensite_ohm;
  for (const fits::LoadLevel& level : fit.levels) {
    const auto heating = Observer::line(wire().heating, wire(), level.stress_Pa);
    const auto cooling = Observer::line(wire().cooling, wire(), level.stress_Pa);
    EXPECT_NEAR(level.heating.slope, scale * heating.slope, 0.01);
    EXPECT_NEAR(level.cooling.slope, scale * cooling.slope, 0.01);
  }
  EXPECT_NEAR(fit.params.initial_slope, scale * wire().initial_slope, 0.02);
  EXPECT_NEAR(std::log(fit.params.decay / (scale * wire().decay)), 0, 0.3);
  EXPECT_LT(fit.params.strain_sd, 0.03 * 0.04);
  for (const double stress_Pa : {20e6, 75e6, 130e6, 180e6}) {
    EXPECT_LT(worst_percent(fit, stress_Pa), 3) << stress_Pa;
  }
}

TEST(StrainResistanceFit, TakesBathRunsToo) {
  const fits::StrainResistanceFit fit =
      fits::identify_strain_resistance(runs({20, 100, 180}, identify::RunKind::bath));
  EXPECT_EQ(fit.order, 2);
  EXPECT_LT(worst_percent(fit, 60e6), 3);
}

TEST(StrainResistanceFit, OneLevelHoldsAtItsStressAlone) {
  const fits::StrainResistanceFit fit = fits::identify_strain_resistance(runs({98, 100, 102}));
  EXPECT_EQ(fit.order, 0);
  ASSERT_EQ(fit.levels.size(), 1U);
  EXPECT_EQ(fit.params.min_stress_Pa, fit.params.max_stress_Pa);
  EXPECT_LT(worst_percent(fit, 100e6), 3);
  const Measurement<double> other{10, 0, 0, 150e6, true, true, true};
  const auto s = Observer::start(fit.params, other, 298);
  EXPECT_EQ(Observer::estimate(fit.params, s).health, Health::doubtful);
}

TEST(StrainResistanceFit, LinesDoNotFollowOutliers) {
  std::vector<smaservo::identify::Run> disturbed = runs({100});
  std::mt19937_64 random(4);
  for (double& ohm : disturbed[0].resistance_ohm) {
    // Bursts that last for some rows: means of bins go wrong, too.
    if (std::uniform_real_distribution<double>(0, 1)(random) < 0.003) {
      ohm *= 1.2;
    }
  }
  const fits::LoadLevel clean = fits::identify_strain_resistance(runs({100})).levels[0];
  const fits::LoadLevel level = fits::identify_strain_resistance(disturbed).levels[0];
  for (const double lambda : {0.88, 0.95, 1.0}) {
    EXPECT_NEAR(level.heating.strain(lambda), clean.heating.strain(lambda), 0.02 * 0.04);
    EXPECT_NEAR(level.cooling.strain(lambda), clean.cooling.strain(lambda), 0.02 * 0.04);
  }
}

TEST(StrainResistanceFit, RowsWithoutResistanceAreSkipped) {
  std::vector<smaservo::identify::Run> gaps = runs({20, 100, 180});
  for (smaservo::identify::Run& run : gaps) {
    for (std::size_t i = 100; i < run.resistance_ohm.size(); i += 7) {
      run.resistance_ohm[i] = std::nan("");
    }
  }
  EXPECT_LT(worst_percent(fits::identify_strain_resistance(gaps), 60e6), 3);
}

void expect_refused(const std::vector<smaservo::identify::Run>& runs, const std::string& because) {
  try {
    fits::identify_strain_resistance(runs);
    ADD_FAILURE() << "not refused: " << because;
  } catch (const files::UserError& error) {
    EXPECT_NE(std::string(error.what()).find(because), std::string::npos) << error.what();
  }
}

TEST(StrainResistanceFit, RefusesWhatDeterminesNothing) {
  expect_refused({}, "0 runs");
  expect_refused({run_along({1.04, 0.85}, 100e6)}, "full cooling");
  expect_refused({run_along({0.99, 0.97, 0.99, 0.97, 0.99}, 100e6)}, "stroke");
  smaservo::identify::Run varying = loops(100e6);
  for (std::size_t i = 0; i < varying.stress_Pa.size(); ++i) {
    varying.stress_Pa[i] = 100e6 + 50e6 * std::sin(0.01 * static_cast<double>(i));
  }
  expect_refused({varying}, "constant load");
  smaservo::identify::Run blind = loops(100e6);
  blind.resistance_ohm.clear();
  expect_refused({blind}, "0 resistances");
  // No current while it is cold, so none of the rows that R_0 comes from has a resistance.
  smaservo::identify::Run dark = loops(100e6);
  const double longest = *std::ranges::max_element(dark.strain);
  for (std::size_t i = 0; i < dark.strain.size(); ++i) {
    if (dark.strain[i] > 0.8 * longest) {
      dark.resistance_ohm[i] = std::nan("");
    }
  }
  expect_refused({dark}, "no run has a resistance where the wire is long");
}

// Much R-phase makes the resistance fall while the wire gets longer.
TEST(StrainResistanceFit, RefusesALoadWhereResistanceFallsOnCooling) {
  smaservo::identify::Run run = loops(20e6);
  const double longest = *std::ranges::max_element(run.strain);
  bool heats = true;
  for (std::size_t i = 1; i < run.strain.size(); ++i) {
    heats = run.strain[i] == run.strain[i - 1] ? heats : run.strain[i] < run.strain[i - 1];
    if (!heats) {
      run.resistance_ohm[i] = 10 * (1.05 + longest - run.strain[i]);
    }
  }
  expect_refused({run}, "on cooling");
}

}  // namespace
}  // namespace smaservo::test
