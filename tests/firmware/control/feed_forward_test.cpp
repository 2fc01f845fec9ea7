#include "firmware/control/feed_forward.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/firmware/device/test_device.hpp"

namespace smaservo::feed_forward_test {
namespace {

using Filter = KalmanObserver<double>;
using Model = Plant<ThreePhase<double>>;
constexpr double ambient_K = room_K;

Prepared<double> prepared() {
  Settings<double> settings = test_settings();
  settings.wire.kinetics.smallest_reversal_K = 0;
  return prepare(settings);
}

/// An observer that knows the wire exactly.
Filter::State knowing(const Prepared<double>& p, const Model::State& wire) {
  const Drive<double> u = ThreePhase<double>::drive(wire.kinetics);
  Measurement<double> m{};
  m.stress_Pa = u.stress_Pa;
  Filter::State f = Filter::start(p.observer, m, ambient_K);
  f.kinetics = wire.kinetics;
  return f;
}

/// The wire after a walk through its hysteresis.
Model::State somewhere(const Prepared<double>& p, double stress_Pa, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Model::State s = Model::rest(p.observer.model, {ambient_K, stress_Pa});
  double T = 360;
  for (int i = 0; i < 8; ++i) {
    T = std::clamp(T + 15 * normal(random), 310.0, 410.0);
    ThreePhase<double>::advance(p.observer.model.kinetics, s.kinetics, {T, stress_Pa});
  }
  return s;
}

TEST(FeedForward, TheHeatBringsAnInsulatedWireToTheStrain) {
  const Prepared<double> p = prepared();
  Model::Params insulated = p.observer.model;
  insulated.body.loss_W_K = insulated.body.loss_W_K2 = 0;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  for (const double stress_Pa : {100e6, 150e6, 300e6}) {
    double worst = 0;
    int moved = 0;
    for (int i = 0; i < 200; ++i) {
      Model::State wire = somewhere(p, stress_Pa, random);
      const double now = Model::strain(insulated, wire);
      const double goal = share(random) * 0.03 + 0.008;
      const double heat_J = FeedForward<double>::heat_J(p, knowing(p, wire), goal - now);
      // The plant is the oracle: the same energy in many small parts.
      constexpr int parts = 4000;
      for (int k = 0; k < parts; ++k) {
        Model::advance(insulated, wire, {heat_J / (parts * 1e-4), stress_Pa, ambient_K}, 1e-4);
      }
      moved += std::abs(heat_J) > 0 ? 1 : 0;
      worst = std::max(worst, std::abs(Model::strain(insulated, wire) - goal));
    }
    EXPECT_GT(moved, 190);
    EXPECT_LT(worst, 4e-5) << stress_Pa;  // 0.1 % of the stroke
  }
}

TEST(FeedForward, TheLossHoldsTheTemperature) {
  const Prepared<double> p = prepared();
  std::mt19937_64 random(2);
  for (int i = 0; i < 20; ++i) {
    Model::State wire = somewhere(p, 150e6, random);
    const double before_K = Model::temperature_K(wire);
    for (int k = 0; k < 1000; ++k) {
      const double power_W = FeedForward<double>::loss_W(p, knowing(p, wire));
      Model::advance(p.observer.model, wire, {power_W, 150e6, ambient_K}, 1e-3);
    }
    EXPECT_NEAR(Model::temperature_K(wire), before_K, 1e-6);
  }
}

TEST(FeedForward, ADraughtyWireLosesMore) {
  const Prepared<double> p = prepared();
  std::mt19937_64 random(3);
  Filter::State f = knowing(p, somewhere(p, 150e6, random));
  const double still_W = FeedForward<double>::loss_W(p, f);
  f.loss = 1.3;
  EXPECT_DOUBLE_EQ(FeedForward<double>::loss_W(p, f), 1.3 * still_W);
}

TEST(FeedForward, NeverHeatsAWireThatIsToBecomeLonger) {
  const Prepared<double> p = prepared();
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> any(-0.06, 0.06);
  for (int i = 0; i < 2000; ++i) {
    const Filter::State f = knowing(p, somewhere(p, 50e6, random));
    const double longer = any(random);
    const double heat_J = FeedForward<double>::heat_J(p, f, longer);
    ASSERT_TRUE(std::isfinite(heat_J));
    ASSERT_LE(heat_J * longer, 0);
  }
}

TEST(FeedForward, ASlowLoopTakesItsTime) {
  EXPECT_DOUBLE_EQ(FeedForward<double>::power_W(1e-3, 0.01, 1e-3), 0.1);
  EXPECT_DOUBLE_EQ(FeedForward<double>::power_W(1e-3, 0.01, 0.02), 1e-3 / 0.06);
}

}  // namespace
}  // namespace smaservo::feed_forward_test
