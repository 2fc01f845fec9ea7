#include "firmware/control/soft_limits.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/firmware/device/closed_loop.hpp"

namespace smaservo::soft_limits_test {
namespace {

constexpr double dt_s = 1e-3;
constexpr std::uint32_t bit(LimitReason why) {
  return 1U << static_cast<unsigned>(why);
}

/// A warm wire in the middle of its ranges, far from every limit except that of the current.
struct Situation {
  Situation() { settings.limits.min_strain = -1; }

  Settings<double> settings = test_settings();
  double temperature_K = 350, strain = 0.03, stress_Pa = 150e6, supply_V = 100;
  double duty = 0, sustained_W = 0, ohm = 30, loss_W = 0.2;

  struct Given {
    double power_W;
    std::uint32_t reasons;
  };
  Given give(double wanted_W) const {
    const Prepared<double> p = prepare(settings);
    Measurement<double> m{};
    m.stress_Pa = stress_Pa;
    m.stress_valid = true;
    const auto filter = KalmanObserver<double>::start(p.observer, m, room_K);
    Estimate<double> e{};
    e.temperature_K = temperature_K;
    e.strain = strain;
    const ControlInputs<double> known{m, e, filter, 0, supply_V};
    LimitReasons reasons;
    const double power_W =
        PowerRange<double>(p, known, ohm, loss_W, duty, sustained_W, dt_s).apply(wanted_W, reasons);
    return {power_W, reasons.bits()};
  }
};

double current_W(const Situation& s) {
  return s.settings.limits.current_A * s.settings.limits.current_A * s.ohm;
}
double min_W(const Situation& s) {
  return s.settings.limits.min_current_A * s.settings.limits.min_current_A * s.ohm;
}

TEST(SoftLimits, NoneOfThemTouchesAModestPower) {
  const Situation::Given given = Situation{}.give(0.3);
  EXPECT_EQ(given.power_W, 0.3);
  EXPECT_EQ(given.reasons, 0U);
}

TEST(SoftLimits, EachHasItsOwnReason) {
  Situation s;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::current));
  EXPECT_DOUBLE_EQ(s.give(20).power_W, current_W(s));

  s = {};
  s.settings.limits.power_W = 1;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::power));
  EXPECT_EQ(s.give(20).power_W, 1);

  s = {};
  s.temperature_K = s.settings.limits.temperature_K - s.settings.limits.hot_spot_K;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::temperature));
  EXPECT_DOUBLE_EQ(s.give(20).power_W, s.loss_W);

  s = {};
  s.strain = s.settings.limits.min_strain = 0.01;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::strain));
  EXPECT_DOUBLE_EQ(s.give(20).power_W, s.loss_W);

  s = {};
  s.stress_Pa = s.settings.limits.stress_Pa;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::stress));
  EXPECT_DOUBLE_EQ(s.give(20).power_W, s.loss_W);

  s = {};
  s.settings.limits.duty = s.duty = 0.3;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::duty));
  EXPECT_EQ(s.give(20).power_W, min_W(s));

  s = {};
  s.supply_V = 5;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::supply));
  EXPECT_DOUBLE_EQ(s.give(20).power_W, 25 / s.ohm);

  s = {};
  EXPECT_EQ(s.give(0).reasons, bit(LimitReason::min_current));
  EXPECT_EQ(s.give(0).power_W, min_W(s));
}

TEST(SoftLimits, NoPowerIsEverAboveAnyOfThem) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 1000; ++i) {
    Situation s;
    SoftLimits<double>& q = s.settings.limits;
    q.power_W = 5 * share(random);
    q.duty = share(random);
    q.min_strain = 0;
    s.temperature_K = 300 + 150 * share(random);
    s.strain = -0.005 + 0.05 * share(random);
    s.stress_Pa = 550e6 * share(random);
    s.supply_V = 15 * share(random);
    s.duty = share(random);
    s.ohm = 20 + 20 * share(random);
    s.loss_W = 0.4 * share(random);
    const Situation::Given given = s.give(10 * share(random) - 2);
    ASSERT_LE(given.power_W, q.power_W);
    ASSERT_LE(given.power_W, current_W(s));
    ASSERT_GE(given.power_W, std::min({min_W(s), q.power_W, current_W(s)}));
    // Where one of the other limits acts, the least current still flows.
    const double above_W = given.power_W - min_W(s);
    if (above_W > 0) {
      ASSERT_LE(given.power_W, s.supply_V * s.supply_V / s.ohm);
      ASSERT_LT(s.duty, q.duty);
      ASSERT_LT(s.temperature_K, q.temperature_K - q.hot_spot_K + 10);
      ASSERT_LT(s.strain < q.min_strain ? above_W : 0, s.loss_W);
      ASSERT_LT(s.stress_Pa > q.stress_Pa ? above_W : 0, s.loss_W);
    }
  }
}

TEST(SoftLimits, WhatIsNotANumberGivesTheLeastPower) {
  const Situation s;
  const Situation::Given given = s.give(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(given.power_W, min_W(s));
  EXPECT_EQ(given.reasons, bit(LimitReason::min_current));
}

TEST(SoftLimits, WhatAWireCanTakeForLongEndsThePowerOfAHotEstimateToo) {
  // By the estimate the wire is 10 K below the limit, but for long it has got more power than its
  // file allows.
  Situation s;
  s.temperature_K = 400;
  s.sustained_W = 1;
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::temperature));
  EXPECT_EQ(s.give(20).power_W, min_W(s));
}

TEST(SoftLimits, AnUnknownSupplyIsNoLimit) {
  Situation s;
  s.supply_V = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(s.give(20).reasons, bit(LimitReason::current));
}

TEST(SoftLimits, TheLeastCurrentHeatsByLessThanAKelvin) {
  const Settings<double> settings = test_settings();
  const Prepared<double> p = prepare(settings);
  const double min_A = settings.limits.min_current_A;
  EXPECT_LT(min_A * min_A * 1.1 * p.cold_ohm / p.observer.model.body.loss_W_K, 1);
}

// The following tests give a wire all power until a limit holds it.

TEST(SoftLimits, TheTemperatureComesToItsLimitWithoutOvershoot) {
  for (const double step_s : {1e-3, 5e-3}) {
    Settings<double> settings = test_settings();
    settings.limits.temperature_K = 395;
    ClosedLoop<> loop(settings);
    const double limit_K = 395 - settings.limits.hot_spot_K;
    double hottest_K = 0;
    std::uint32_t reasons = 0;
    loop.run(
        3, Mode::power, 10,
        [&](const auto& result) {
          hottest_K = std::max(hottest_K, loop.wire.temperature_K());
          reasons = result.limit_reasons;
        },
        step_s);
    EXPECT_LT(hottest_K, limit_K + 0.5) << step_s;
    EXPECT_NEAR(loop.wire.temperature_K(), limit_K, 0.5) << step_s;
    EXPECT_EQ(reasons, bit(LimitReason::temperature));
  }
}

/// Extremes of a wire in its last second.
struct Held {
  double shortest = 1, longest = 0, hottest_K = 0, coldest_K = 1000, max_Pa = 0;
  std::uint32_t reasons = 0;
};
Held hold(ClosedLoop<>& loop) {
  Held held;
  loop.run(4, Mode::power, 10, [&](const auto& result) {
    held.shortest = std::min(held.shortest, loop.wire.strain());
    held.max_Pa = std::max(held.max_Pa, loop.wire.stress_Pa());
    if (loop.time_s > 3) {
      held.longest = std::max(held.longest, loop.wire.strain());
      held.hottest_K = std::max(held.hottest_K, loop.wire.temperature_K());
      held.coldest_K = std::min(held.coldest_K, loop.wire.temperature_K());
      held.reasons |= result.limit_reasons;
    }
  });
  return held;
}

TEST(SoftLimits, AContractingWireStopsAtItsStrain) {
  Settings<double> settings = test_settings();
  settings.limits.min_strain = 0.02;
  ClosedLoop<> loop(settings);
  const Held held = hold(loop);
  EXPECT_GT(held.shortest, 0.02 - 4e-4);
  EXPECT_NEAR(held.longest, 0.02, 4e-4);
  EXPECT_LT(held.hottest_K - held.coldest_K, 0.3);
  EXPECT_EQ(held.reasons, bit(LimitReason::strain));
}

TEST(SoftLimits, AContractingWireStopsAtItsStress) {
  Settings<double> settings = test_settings();
  settings.limits.stress_Pa = 200e6;
  ClosedLoop<> loop(settings, 100e6);
  loop.against_spring(5e9);
  const Held held = hold(loop);
  EXPECT_LT(held.max_Pa, 210e6);  // it came with 18 MPa in a step
  EXPECT_GT(held.max_Pa, 190e6);
  EXPECT_LT(held.hottest_K - held.coldest_K, 0.5);
  EXPECT_EQ(held.reasons, bit(LimitReason::stress));
}

TEST(SoftLimits, TheDutyIsNeverExceeded) {
  Settings<double> settings = test_settings();
  settings.limits.duty = 0.04;
  settings.limits.duty_window_s = 0.5;
  settings.limits.temperature_K = 600;
  ClosedLoop<> loop(settings);
  double max = 0;
  std::uint32_t reasons = 0;
  loop.run(3, Mode::power, 10, [&](const auto& result) {
    max = std::max(max, loop.control.duty);
    reasons |= loop.time_s > 2 ? result.limit_reasons : 0;
  });
  EXPECT_LT(max, 0.04);
  EXPECT_GT(max, 0.037);
  EXPECT_EQ(reasons, bit(LimitReason::duty));
}

TEST(SoftLimits, TheWholeCurrentAllTheTimeIsADutyOfOne) {
  ClosedLoop<> loop(test_settings());
  loop.control.duty = 1;
  const auto result = loop.step(Mode::current, 0.4);
  EXPECT_EQ(result.limit_reasons & bit(LimitReason::duty), 0U);
}

}  // namespace
}  // namespace smaservo::soft_limits_test
