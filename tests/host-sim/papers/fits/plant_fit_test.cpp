// Wires that are the fitted model themselves: their strain must be found again.

#include "host-sim/papers/fits/plant_fit.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numeric>

#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/papers/duhem.hpp"
#include "model/papers/liang_rogers.hpp"

namespace smaservo::test {
namespace {

template <class K>
using Adjustables = std::vector<fits::Adjustable<fits::PlantModel<K>>>;

fits::PlantModel<papers::Duhem<double>> duhem_model() {
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  return {{{344, 3, 0.13e-6}, {314, 3, 0.14e-6}}, wire.material, wire.heat, wire.geometry};
}

fits::PlantModel<papers::LiangRogers<double>> liang_rogers_model() {
  const Wire<double> wire = files::load_wire("smartflex-76um").wire;
  return {{{338, 352, 7.5e6}, {322, 306, 7e6}, {335, 325, 14e6}},
          wire.material,
          wire.heat,
          wire.geometry};
}

/// What both have.
template <class K>
void add_common(Adjustables<K>& all) {
  using Model = fits::PlantModel<K>;
  all.push_back(
      {"martensite strain", [](Model& m, double u) { m.material.martensite.strain += 0.004 * u; }});
  all.push_back(
      {"convection", [](Model& m, double u) { m.heat.convection_W_m2K *= std::exp(0.2 * u); }});
}

Adjustables<papers::Duhem<double>> duhem_adjustables() {
  using Model = fits::PlantModel<papers::Duhem<double>>;
  Adjustables<papers::Duhem<double>> all{
      {"heating", [](Model& m, double u) { m.kinetics.m2a.centre_K += 8 * u; }},
      {"cooling", [](Model& m, double u) { m.kinetics.a2m.centre_K += 8 * u; }},
      {"width", [](Model& m, double u) { m.kinetics.m2a.deviation_K *= std::exp(0.5 * u); }},
      {"slope", [](Model& m, double u) { m.kinetics.a2m.stress_K_Pa += 0.03e-6 * u; }}};
  add_common<papers::Duhem<double>>(all);
  return all;
}

Adjustables<papers::LiangRogers<double>> liang_rogers_adjustables() {
  using Model = fits::PlantModel<papers::LiangRogers<double>>;
  const auto move = [](papers::CosineProcess<double>& process, double by_K) {
    process.start_K += by_K;
    process.finish_K += by_K;
  };
  Adjustables<papers::LiangRogers<double>> all{
      {"heating", [move](Model& m, double u) { move(m.kinetics.m2a, 8 * u); }},
      {"cooling", [move](Model& m, double u) { move(m.kinetics.a2m, 8 * u); }},
      {"R-phase", [move](Model& m, double u) { move(m.kinetics.a2r, 6 * u); }},
      {"C_M", [](Model& m, double u) { m.kinetics.a2m.stress_Pa_K *= std::exp(0.3 * u); }}};
  add_common<papers::LiangRogers<double>>(all);
  return all;
}

template <class K>
fits::PlantModel<K> moved(fits::PlantModel<K> model, const Adjustables<K>& adjustables,
                          const std::vector<double>& u) {
  for (std::size_t i = 0; i < u.size(); ++i) {
    adjustables[i].apply(model, u[i]);
  }
  return model;
}

/// The power goes up and down between peaks of such watts, each way within 2 s, 100 rows/s.
smaservo::identify::Run drive(const std::vector<double>& peaks_W, double stress_Pa) {
  smaservo::identify::Run run{};
  run.name = "run.csv";
  run.kind = identify::RunKind::joule;
  constexpr int rows = 200;
  for (const double peak_W : peaks_W) {
    for (int i = 0; i < 2 * rows; ++i) {
      const double share = static_cast<double>(i < rows ? i : 2 * rows - i) / rows;
      run.time_s.push_back(0.01 * static_cast<double>(run.time_s.size()));
      run.voltage_V.push_back(2);
      run.current_A.push_back((0.01 + (peak_W - 0.01) * share) / 2);
      run.stress_Pa.push_back(stress_Pa);
    }
  }
  return run;
}

template <class K>
smaservo::identify::Run measured(smaservo::identify::Run run, const fits::PlantModel<K>& truth) {
  run.strain = fits::driven_strain(truth, fits::every_row(run));
  return run;
}

template <class K>
std::vector<smaservo::identify::Run> training(const fits::PlantModel<K>& truth) {
  return {measured(drive({0.5, 0.3, 0.5, 0.36}, 80e6), truth),
          measured(drive({0.6, 0.4}, 220e6), truth)};
}

/// Greatest error in a run under another load, that the fit has not seen.
template <class K>
double worst_error(const fits::PlantModel<K>& fitted, const fits::PlantModel<K>& truth) {
  const smaservo::identify::Run fresh = measured(drive({0.55, 0.32, 0.4}, 150e6), truth);
  const auto [low, high] = std::ranges::minmax(fresh.strain);
  EXPECT_GT(high - low, 0.03) << "the run must move the wire";
  const std::vector<double> strain = fits::driven_strain(fitted, fits::every_row(fresh));
  double worst = 0;
  for (std::size_t i = 0; i < strain.size(); ++i) {
    worst = std::max(worst, std::abs(strain[i] - fresh.strain[i]));
  }
  return worst;
}

std::vector<std::vector<double>> at_prior() {
  return {std::vector<double>(6, 0.0)};
}

TEST(PlantFit, FindsADuhemWireAgain) {
  const auto prior = duhem_model();
  const auto adjustables = duhem_adjustables();
  const auto truth = moved(prior, adjustables, {0.7, -0.6, 0.5, 0.6, -0.8, 0.7});
  EXPECT_GT(worst_error(prior, truth), 0.01);
  EXPECT_LT(worst_error(fits::fit_plant(prior, adjustables, training(truth), at_prior(), 2), truth),
            2e-4);
}

TEST(PlantFit, FindsALiangRogersWireAgain) {
  const auto prior = liang_rogers_model();
  const auto adjustables = liang_rogers_adjustables();
  const auto truth = moved(prior, adjustables, {-0.6, 0.7, 0.4, -0.5, 0.6, -0.6});
  EXPECT_GT(worst_error(prior, truth), 0.01);
  EXPECT_LT(worst_error(fits::fit_plant(prior, adjustables, training(truth), at_prior(), 2), truth),
            2e-4);
}

TEST(PlantFit, FindsItFromTheWorstStart) {
  const auto prior = duhem_model();
  const auto adjustables = duhem_adjustables();
  const auto truth = moved(prior, adjustables, {0.7, -0.6, 0.5, 0.6, -0.8, 0.7});
  const std::vector<double> worst{-2.5, 2.5, -2, -2, 2, -2};
  EXPECT_GT(worst_error(moved(prior, adjustables, worst), truth), 0.03);
  EXPECT_LT(worst_error(fits::fit_plant(prior, adjustables, training(truth), {worst}, 1), truth),
            2e-4);
}

TEST(PlantFit, GoesOnFromTheBestStart) {
  const auto prior = duhem_model();
  const auto adjustables = duhem_adjustables();
  const auto truth = moved(prior, adjustables, {0.7, -0.6, 0.5, 0.6, -0.8, 0.7});
  const auto runs = training(truth);
  const std::vector<double> good{0.5, -0.5, 0, 0, 0, 0};
  const std::vector<double> bad{-2.5, 2.5, -2, -2, 2, -2};
  const auto alone = fits::fit_plant(prior, adjustables, runs, {good}, 1);
  const auto chosen = fits::fit_plant(prior, adjustables, runs, {bad, good, bad}, 1);
  EXPECT_EQ(chosen.kinetics.m2a.centre_K, alone.kinetics.m2a.centre_K);
  EXPECT_EQ(chosen.heat.convection_W_m2K, alone.heat.convection_W_m2K);
}

TEST(PlantFit, IsTheSameForAnyNumberOfThreads) {
  const auto prior = duhem_model();
  const auto adjustables = duhem_adjustables();
  auto runs = training(moved(prior, adjustables, {0.7, -0.6, 0.5, 0.6, -0.8, 0.7}));
  runs.push_back(runs.front());
  const auto strain = [&](int threads) {
    return fits::driven_strain(fits::fit_plant(prior, adjustables, runs, at_prior(), threads),
                               fits::every_row(runs.front()));
  };
  const auto alone = strain(1);
  EXPECT_EQ(strain(2), alone);
  EXPECT_EQ(strain(7), alone);
}

/// In a bath nothing but the kinetics and the strains is left to find.
TEST(PlantFit, FindsTheTemperaturesFromABath) {
  const auto prior = duhem_model();
  const auto adjustables = duhem_adjustables();
  const auto truth = moved(prior, adjustables, {0.8, -0.9, 0.4, 0.5, 0.7, 0});
  std::vector<smaservo::identify::Run> runs;
  for (const double stress_Pa : {60e6, 240e6}) {
    smaservo::identify::Run run{};
    run.kind = identify::RunKind::bath;
    for (int i = 0; i <= 1200; ++i) {
      run.temperature_K.push_back(295 + 0.2 * (i < 600 ? i : 1200 - i));
      run.stress_Pa.push_back(stress_Pa);
    }
    runs.push_back(measured(run, truth));
  }
  const auto fitted = fits::fit_plant(prior, adjustables, runs, at_prior(), 2);
  EXPECT_NEAR(fitted.kinetics.m2a.centre_K, truth.kinetics.m2a.centre_K, 0.1);
  EXPECT_NEAR(fitted.kinetics.a2m.centre_K, truth.kinetics.a2m.centre_K, 0.2);
  EXPECT_NEAR(fitted.kinetics.a2m.stress_K_Pa, truth.kinetics.a2m.stress_K_Pa, 1e-9);
  EXPECT_NEAR(fitted.kinetics.m2a.deviation_K, truth.kinetics.m2a.deviation_K, 0.1);
  EXPECT_NEAR(fitted.material.martensite.strain, truth.material.martensite.strain, 1e-4);
}

TEST(PlantFit, RowsThatDoNotCountChangeNothing) {
  const auto prior = duhem_model();
  const std::vector<fits::DrivenSteps> clean{fits::thinned(training(prior).front())};
  std::vector<fits::DrivenSteps> gaps = clean;
  ASSERT_TRUE(std::isfinite(gaps[0].strain.back()));
  gaps[0].strain.back() = std::nan("");
  const fits::StrainOf constant = [](const std::vector<double>& u, const fits::DrivenSteps& run) {
    std::vector<double> strain(run.stress_Pa.size(), 0.02 + 0.01 * u[0]);
    strain.back() += u[1];
    return strain;
  };
  EXPECT_NE(fits::fit_deviations(2, clean, constant, {{0, 0}}, 1)[1], 0);
  EXPECT_EQ(fits::fit_deviations(2, gaps, constant, {{0, 0}}, 1)[1], 0) << "nothing but its prior";
}

TEST(DrivenSteps, ThinningKeepsEnergyAndTime) {
  const smaservo::identify::Run run = measured(drive({0.5, 0.3}, 80e6), duhem_model());
  const fits::DrivenSteps thin = fits::thinned(run);
  const fits::DrivenSteps full = fits::every_row(run);
  EXPECT_LT(2 * thin.dt_s.size(), full.dt_s.size());
  EXPECT_EQ(full.strain, run.strain);
  const auto sum = [](const fits::DrivenSteps& steps, std::size_t from, auto of) {
    double all = 0;
    for (std::size_t i = from; i < steps.dt_s.size(); ++i) {
      all += of(i);
    }
    return all;
  };
  const auto energy_J = [&](const fits::DrivenSteps& steps, std::size_t from) {
    return sum(steps, from, [&](std::size_t i) { return steps.power_W[i] * steps.dt_s[i]; });
  };
  // The first of all rows has a step before it, which a thinned run has not.
  EXPECT_NEAR(energy_J(thin, 0), energy_J(full, 1), 1e-12);
  EXPECT_NEAR(sum(thin, 0, [&](std::size_t i) { return thin.dt_s[i]; }),
              run.time_s.back() - run.time_s.front(), 1e-12);
}

TEST(DrivenSteps, LongStepsAreMadeOfSubsteps) {
  const auto model = duhem_model();
  fits::DrivenSteps slow{false, room_K, {}, {}, {}, {}, {}};
  fits::DrivenSteps fine = slow;
  constexpr double slow_s = 0.5;
  constexpr int parts = 17;
  for (int i = 0; i < 60; ++i) {
    const double power_W = i % 20 < 10 ? 0.4 : 0.02;
    slow.dt_s.push_back(slow_s);
    slow.power_W.push_back(power_W);
    slow.stress_Pa.push_back(100e6);
    for (int part = 0; part < parts; ++part) {
      fine.dt_s.push_back(slow_s / parts);
      fine.power_W.push_back(power_W);
      fine.stress_Pa.push_back(100e6);
    }
  }
  const std::vector<double> strain = fits::driven_strain(model, slow);
  const std::vector<double> truth = fits::driven_strain(model, fine);
  const auto [low, high] = std::ranges::minmax(truth);
  ASSERT_GT(high - low, 0.03);
  for (std::size_t i = 0; i < strain.size(); ++i) {
    EXPECT_EQ(strain[i], truth[parts * (i + 1) - 1]) << i;
  }
}

TEST(DrivenSteps, OtherKindsOfRunsAreRefused) {
  smaservo::identify::Run run = drive({0.3}, 80e6);
  for (const identify::RunKind kind :
       {identify::RunKind::settled, identify::RunKind::calorimetry}) {
    run.kind = kind;
    EXPECT_THROW(fits::every_row(run), files::UserError);
    EXPECT_THROW(fits::thinned(run), files::UserError);
  }
}

}  // namespace
}  // namespace smaservo::test
