#include "host-sim/papers/figures/003/temperature_loop.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

#include "host-sim/papers/figures/003/paper_003.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::test {
namespace {

figures::LoopSetup setup(std::uint64_t seed = 1) {
  figures::LoopSetup s = figures::loop_003();
  s.seed = seed;
  return s;
}

TEST(TemperatureLoop, AdaptiveTracksBetterThanAnyFixedGain) {
  for (const bool dynamic : {false, true}) {
    const auto references = figures::references_003(dynamic);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      figures::AdaptiveController adaptive = figures::adaptive_003(setup());
      const double adaptive_K =
          figures::tracking_error_K(figures::run_loop(setup(seed), adaptive, references), 2);
      EXPECT_TRUE(adaptive_K > 0.05 && adaptive_K < 0.15) << adaptive_K;
      double best_K = std::numeric_limits<double>::infinity();
      for (const double response_s : {0.02, 0.025, 0.03, 0.035, 0.04, 0.05, 0.1, 0.2}) {
        figures::FixedController fixed(figures::loop_design(setup()), response_s);
        best_K = std::min(best_K, figures::tracking_error_K(
                                      figures::run_loop(setup(seed), fixed, references), 2));
      }
      figures::FixedController fixed = figures::fixed_003(setup());
      const double fixed_K =
          figures::tracking_error_K(figures::run_loop(setup(seed), fixed, references), 2);
      EXPECT_LT(adaptive_K, 0.95 * best_K);
      EXPECT_LT(adaptive_K, 0.5 * fixed_K);
    }
  }
}

/// Steps that the wire cannot follow either way, then a level that it can.
std::vector<figures::LoopReference> impossible() {
  std::vector<figures::LoopReference> all;
  for (int i = 0; i < 1500; ++i) {
    const double T = i < 600 ? (i / 50 % 2 == 0 ? 390 : 250) : 340;
    all.push_back({T, 150e6});
  }
  return all;
}

TEST(TemperatureLoop, CurrentStaysBetweenNoneAndTheLimitAndTheLoopRecovers) {
  figures::LoopSetup weak = setup();
  weak.limit_A = 0.15;
  figures::FixedController fixed = figures::fixed_003(weak);
  figures::AdaptiveController adaptive = figures::adaptive_003(weak);
  for (figures::TemperatureController* controller :
       {static_cast<figures::TemperatureController*>(&fixed),
        static_cast<figures::TemperatureController*>(&adaptive)}) {
    const auto rows = figures::run_loop(weak, *controller, impossible());
    bool none = false;
    bool full = false;
    for (const auto& row : rows) {
      ASSERT_GE(row.current_A, 0);
      ASSERT_LE(row.current_A, weak.limit_A);
      none = none || row.current_A == 0;
      full = full || row.current_A > 0.99 * weak.limit_A;
    }
    EXPECT_TRUE(none && full);
    EXPECT_LT(figures::tracking_error_K(rows, 22), 0.3);
  }
}

TEST(TemperatureLoop, SameSeedSameRun) {
  const auto run = [](std::uint64_t seed) {
    figures::AdaptiveController controller = figures::adaptive_003(setup());
    return figures::tracking_error_K(
        figures::run_loop(setup(seed), controller, figures::references_003(true)), 2);
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_NE(run(3), run(4));
}

TEST(RecursiveLeastSquares, IsTheWeightedSolutionOfAllRowsAtOnce) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const Eigen::Vector4d start(0.5, 0, 1, 0);
  const double forgetting = 0.97;
  const double variance = 10;
  figures::RecursiveLeastSquares recursive(start, variance, forgetting, 1e9);
  // The start counts like one more row for each parameter, and fades like all others.
  Eigen::Matrix4d left = Eigen::Matrix4d::Identity() / variance;
  Eigen::Vector4d right = start / variance;
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector4d regressors;
    for (double& regressor : regressors) {
      regressor = normal(random);
    }
    const double y = normal(random);
    recursive.update(regressors, y);
    left = forgetting * left + regressors * regressors.transpose();
    right = forgetting * right + regressors * y;
    const Eigen::Vector4d once = left.ldlt().solve(right);
    ASSERT_LT((recursive.parameters() - once).norm(), 1e-9 * (1 + once.norm()));
  }
}

TEST(AdaptiveController, PutsALinearWireOnItsReferenceInOneSample) {
  // Without noise and weight, once the parameters are found. A wire twice as heavy as designed.
  const figures::LoopDesign design{0.02, 2, 1e-3, 4e-3, 300};
  figures::AdaptiveController controller(design, {{}, 0.98, 0});
  double T = 300;
  double worst_K = 0;
  for (int i = 0; i < 4000; ++i) {
    const double next_K = 350 + 10 * std::sin(0.05 * i) + 3 * std::sin(0.3 * i);
    const double power_W = controller.power_W(T, next_K);
    T += 0.02 * (power_W - 4e-3 * (T - 300)) / 2e-3;
    worst_K = i > 3000 ? std::max(worst_K, std::abs(T - next_K)) : worst_K;
  }
  EXPECT_LT(worst_K, 0.02);
}

}  // namespace
}  // namespace smaservo::test
