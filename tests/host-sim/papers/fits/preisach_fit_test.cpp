#include "host-sim/papers/fits/preisach_fit.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "host-sim/papers/figures/003/reversal_curves.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/model/papers/preisach_relays.hpp"

namespace smaservo::test {
namespace {

using K = papers::Preisach<double>;
using Runs = std::vector<identify::Run>;
constexpr double MPa = 1e6;
constexpr double stroke = 0.04;

/// Reversal curves of a wire that is a Preisach model, with noise on its strain.
identify::Run relay_run(double stress_MPa, double noise, int curves = 20) {
  const K::Params p = relays<double>(0.14);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  identify::Run run{};
  run.name = "relays";
  run.kind = identify::RunKind::bath;
  const double shift_K = 0.14 * stress_MPa;
  K::State s = K::rest(p, {386 + shift_K, stress_MPa * MPa});
  const auto go = [&](double to_K) {
    const double from_K = s.drive.temperature_K;
    for (int i = 1; i <= 150; ++i) {
      K::advance(p, s, {from_K + (to_K - from_K) * i / 150, stress_MPa * MPa});
      run.temperature_K.push_back(s.drive.temperature_K);
      run.stress_Pa.push_back(stress_MPa * MPa);
      run.strain.push_back(0.002 + stroke * s.martensite + noise * normal(random));
    }
  };
  go(290 + shift_K);
  for (int i = 0; i <= curves; ++i) {
    go(330 + 50.0 * i / curves + shift_K);
    go(290 + shift_K);
  }
  return run;
}

/// Root mean square of the strain's error over a random walk of the temperature, by stroke.
double walk_error(const fits::PreisachWire& wire, double stress_MPa) {
  const K::Params p = relays<double>(0.14);
  std::mt19937_64 random(6);
  const double shift_K = 0.14 * stress_MPa;
  K::State truth = K::rest(p, {290 + shift_K, stress_MPa * MPa});
  K::State model = K::rest(wire.kinetics, {290 + shift_K, stress_MPa * MPa});
  double squares = 0;
  for (int i = 0; i < 2000; ++i) {
    const double T = std::uniform_real_distribution<double>(300, 370)(random) + shift_K;
    K::advance(p, truth, {T, stress_MPa * MPa});
    K::advance(wire.kinetics, model, {T, stress_MPa * MPa});
    const double error =
        wire.strain(model.martensite, stress_MPa * MPa) - 0.002 - stroke * truth.martensite;
    squares += error * error / (stroke * stroke);
  }
  return std::sqrt(squares / 2000);
}

/// What a cell of the grid weighs.
double cell_weight(const K::Params& p, std::size_t stress, std::size_t hot, std::size_t cold) {
  const auto F = [&](std::size_t h, std::size_t c) {
    return h > c ? p.increments[stress][K::Params::index(h, c)] : 0.0;
  };
  return F(hot + 1, cold) - F(hot, cold) - F(hot + 1, cold + 1) + F(hot, cold + 1);
}

TEST(PreisachFits, FindAPreisachWireAndItsStressesInBetween) {
  Runs runs;
  for (const double stress_MPa : {100.0, 200.0, 300.0}) {
    runs.push_back(relay_run(stress_MPa, 0));
  }
  const fits::PreisachFit fit = fits::fit_preisach(runs, fits::StressShift::fitted);
  // The wire has a grid of its own.
  EXPECT_LT(fit.rms, 0.004);
  EXPECT_NEAR(fit.wire.kinetics.shift_K_Pa * MPa, 0.14, 0.002);
  EXPECT_NEAR(fit.wire.strain(0, 200 * MPa), 0.002, 0.01 * stroke);
  EXPECT_NEAR(fit.wire.strain(1, 200 * MPa), 0.002 + stroke, 0.01 * stroke);
  for (const double stress_MPa : {100.0, 150.0, 300.0}) {
    EXPECT_LT(walk_error(fit.wire, stress_MPa), 0.006) << stress_MPa;
  }
  EXPECT_TRUE(fit.remark.empty());
}

TEST(PreisachFits, StayMonotoneWhereNoiseIsNot) {
  // 2 % of stroke on each of 6000 rows
  const fits::PreisachFit fit =
      fits::fit_preisach({relay_run(150, 0.02 * stroke)}, fits::StressShift::none);
  const K::Params& p = fit.wire.kinetics;
  for (std::size_t hot = 0; hot < 23; ++hot) {
    for (std::size_t cold = 0; cold <= hot; ++cold) {
      ASSERT_GE(cell_weight(p, 0, hot, cold), -1e-12);
    }
  }
  EXPECT_NEAR(p.increments[0][K::Params::index(23, 0)], 1, 1e-12);
  EXPECT_NEAR(fit.rms, 0.02, 0.001);
  EXPECT_LT(walk_error(fit.wire, 150), 0.012);
  EXPECT_NE(fit.remark.find("150 MPa"), std::string::npos);
}

TEST(PreisachFits, IncrementIsTheStrainOfAReversalCurve) {
  const fits::PreisachFit fit =
      fits::fit_preisach({relay_run(100, 0), relay_run(200, 0)}, fits::StressShift::fitted);
  const double stress_Pa = 150 * MPa;
  for (const double hot_K : {360.0, 368.0, 375.0}) {
    for (const double cold_K : {330.0, 340.0}) {
      K::State s = K::rest(fit.wire.kinetics, {315, stress_Pa});
      K::advance(fit.wire.kinetics, s, {hot_K, stress_Pa});
      const double turned = fit.wire.strain(s.martensite, stress_Pa);
      K::advance(fit.wire.kinetics, s, {cold_K, stress_Pa});
      EXPECT_NEAR(fit.wire.strain(s.martensite, stress_Pa) - turned,
                  fit.wire.increment(hot_K, cold_K, stress_Pa), 1e-12);
    }
  }
}

/// A random walk of temperature and stress, with the temperature wrong by `off_K`, slowly.
identify::Run random_run(std::uint64_t seed, double off_K) {
  const K::Params p = relays<double>(0.14);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  identify::Run run{};
  run.name = "histories";
  K::State s = K::rest(p, {300, 150 * MPa});
  for (int goal = 0; goal < 60; ++goal) {
    const double to_MPa = uniform(100, 300);
    const double to_K = uniform(295, 380) + 0.14 * to_MPa;
    const Drive<double> from = s.drive;
    for (int i = 1; i <= 80; ++i) {
      const double share = i / 80.0;
      K::advance(p, s,
                 {std::lerp(from.temperature_K, to_K, share),
                  std::lerp(from.stress_Pa, to_MPa * MPa, share)});
      run.temperature_K.push_back(s.drive.temperature_K + off_K * std::sin(0.01 * goal * i));
      run.stress_Pa.push_back(s.drive.stress_Pa);
      run.strain.push_back(0.002 + stroke * s.martensite);
    }
  }
  return run;
}

TEST(PreisachFits, FindAPreisachWireInAnyHistories) {
  const std::vector<double> stresses_Pa{100 * MPa, 200 * MPa, 300 * MPa};
  const auto fitted = [&](double off_K) {
    return fits::fit_preisach_histories(
        {random_run(1, off_K), random_run(2, off_K), random_run(3, off_K)}, stresses_Pa,
        0.14 / MPa);
  };
  const fits::PreisachFit fit = fitted(0);
  EXPECT_LT(fit.rms, 0.005);
  for (const double stress_MPa : {120.0, 200.0, 260.0}) {
    EXPECT_LT(walk_error(fit.wire, stress_MPa), 0.012) << stress_MPa;
  }
  // A kelvin is worth 8 % of the stroke where the wire is steepest.
  const fits::PreisachFit off = fitted(1);
  EXPECT_TRUE(off.rms > 0.01 && off.rms < 0.05) << off.rms;
  EXPECT_LT(walk_error(off.wire, 200), 0.025);
}

TEST(PreisachFits, HistoriesSayWhatIsMissing) {
  const auto run = random_run(1, 0);
  auto without = run;
  without.strain.clear();
  EXPECT_THROW(fits::fit_preisach_histories({}, {1e8}, 0), files::UserError);
  EXPECT_THROW(fits::fit_preisach_histories({run, without}, {1e8}, 0), files::UserError);
  EXPECT_THROW(fits::fit_preisach_histories({run}, {}, 0), files::UserError);
  EXPECT_THROW(fits::fit_preisach_histories({run}, {2e8, 1e8}, 0), files::UserError);
  EXPECT_THROW(fits::fit_preisach_histories({run}, {1, 2, 3, 4, 5, 6, 7, 8, 9}, 0),
               files::UserError);
}

std::string refusal(const std::function<void(Runs&)>& spoil) {
  Runs runs{relay_run(100, 0), relay_run(200, 0)};
  spoil(runs);
  try {
    fits::fit_preisach(runs, fits::StressShift::fitted);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

TEST(PreisachFits, SayWhatIsMissing) {
  EXPECT_EQ(refusal([](auto&) {}), "");
  const auto expect = [](const char* part, const std::function<void(Runs&)>& spoil) {
    EXPECT_NE(refusal(spoil).find(part), std::string::npos) << refusal(spoil);
  };
  expect("no run", [](auto& runs) { runs.clear(); });
  expect("is a settled run", [](auto& runs) { runs[1].kind = identify::RunKind::settled; });
  expect("without strain", [](auto& runs) { runs[1].strain.clear(); });
  expect("need a constant one", [](auto& runs) {
    for (std::size_t i = 0; i < 1000; ++i) {
      runs[0].stress_Pa[i] = 120 * MPa;
    }
  });
  expect("begins at", [](auto& runs) {
    for (auto* column : {&runs[0].temperature_K, &runs[0].strain, &runs[0].stress_Pa}) {
      column->erase(column->begin(), column->begin() + 75);
    }
  });
  expect("2 reversal curves at 200 MPa", [](auto& runs) { runs[1] = relay_run(200, 0, 5); });
  expect("9 stresses", [](auto& runs) {
    runs.assign(9, runs[0]);
    for (std::size_t i = 0; i < 9; ++i) {
      for (double& stress_Pa : runs[i].stress_Pa) {
        stress_Pa += static_cast<double>(i) * 10 * MPa;
      }
    }
  });
}

class PreisachOfFamily : public ::testing::TestWithParam<hal::Family> {
 protected:
  struct Errors {
    double constant, varying;  ///< root mean square by stroke
  };

  static fits::PreisachFit identified(fits::StressShift shift) {
    Runs runs;
    for (double stress_MPa = 100; stress_MPa < 201; stress_MPa += 25) {
      runs.push_back(
          figures::bath_run({"run",
                             description(),
                             7,
                             0.5,
                             GetParam(),
                             {},
                             figures::reversal_curves(description().wire, stress_MPa * MPa, 20)}));
    }
    return fits::fit_preisach(runs, shift);
  }
  static const files::WireDescription& description() {
    static const files::WireDescription wire = files::load_wire("smartflex-76um");
    return wire;
  }

  /// Another history than that of the runs: swings of the temperature that die away.
  static double error(const fits::PreisachWire& model,
                      const std::function<double(double)>& stress_MPa) {
    std::mt19937_64 random(8);
    const auto wire = hal::make_simulated_wire(GetParam(), description().wire, {}, 0.5, random);
    const double hot_K = 371;
    wire->rest(hot_K, stress_MPa(0) * MPa);
    K::State s = K::rest(model.kinetics, {hot_K, stress_MPa(0) * MPa});
    double squares = 0;
    constexpr int steps = 8000;
    for (int i = 0; i < steps; ++i) {
      const double turns = 1e-3 * i;
      const double T = 344 + 27 * std::cos(2 * std::numbers::pi * turns) * (1 - turns / 10);
      const double stress_Pa = stress_MPa(turns) * MPa;
      wire->soak(T, stress_Pa);
      K::advance(model.kinetics, s, {T, stress_Pa});
      squares += std::pow((model.strain(s.martensite, stress_Pa) - wire->strain()) / stroke, 2);
    }
    return std::sqrt(squares / steps);
  }
  static Errors errors(const fits::PreisachWire& model) {
    return {error(model, [](double) { return 138.0; }), error(model, [](double turns) {
              return 150 + 50 * std::sin(2 * std::numbers::pi * turns / 1.3);
            })};
  }
};

INSTANTIATE_TEST_SUITE_P(Families, PreisachOfFamily, ::testing::ValuesIn(hal::tuning_families),
                         [](const auto& tested) {
                           return std::string(hal::family_name(tested.param));
                         });

TEST_P(PreisachOfFamily, FollowsTheWireOnOtherPathsAndBetweenTheStresses) {
  const fits::PreisachFit fit = identified(fits::StressShift::fitted);
  EXPECT_TRUE(fit.rms > 0.001 && fit.rms < 0.01) << fit.rms;
  EXPECT_TRUE(fit.wire.kinetics.shift_K_Pa * MPa > 0.12 &&
              fit.wire.kinetics.shift_K_Pa * MPa < 0.15);
  const Errors now = errors(fit.wire);
  EXPECT_TRUE(now.constant > 0.002 && now.constant < 0.02) << now.constant;
  EXPECT_TRUE(now.varying > 0.002 && now.varying < 0.02) << now.varying;
}

TEST_P(PreisachOfFamily, WithoutAShiftAVaryingStressLeadsItAstray) {
  // 003's form; where a turning point was made at another stress its staircase is the wrong one.
  const Errors now = errors(identified(fits::StressShift::none).wire);
  EXPECT_LT(now.constant, 0.03);
  EXPECT_GT(now.varying, 0.05);
}

}  // namespace
}  // namespace smaservo::test
