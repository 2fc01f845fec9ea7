#include "firmware/control/control.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/firmware/device/closed_loop.hpp"

namespace smaservo::control_test {
namespace {

constexpr double stroke = 0.04;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t bit(LimitReason why) {
  return 1U << static_cast<unsigned>(why);
}

constexpr Mode closed_modes[] = {Mode::current, Mode::power,    Mode::resistance, Mode::temperature,
                                 Mode::strain,  Mode::position, Mode::force};

double area_m2() {
  return test_settings().wire.geometry.area_m2();
}

/// The present value of the variable that a mode controls; as a set-point it changes nothing.
double present(const ClosedLoop<>& loop, Mode mode) {
  const auto& p = loop.prepared();
  const double strain = loop.estimate().strain;
  const double power_W = loop.control.power_W;
  switch (mode) {
    case Mode::current:
      return std::sqrt(power_W / loop.wire.resistance_ohm());
    case Mode::power:
      return power_W;
    case Mode::resistance:
      return loop.wire.resistance_ohm();
    case Mode::temperature:
      return loop.estimate().temperature_K;
    case Mode::position:
      return (p.settings.axis.zero_strain - strain) * p.settings.wire.geometry.length_m;
    case Mode::force:
      return loop.wire.stress_Pa() * area_m2();
    default:
      return strain;
  }
}

/// Brings the wire to a random state of its hysteresis, in motion or at rest, under this mode.
void bring_about(ClosedLoop<>& loop, Mode mode, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const double longest = loop.wire.strain();
  loop.run(0.5, Mode::strain, longest - 0.03 * share(random) - 0.003);
  loop.run(0.05 + 0.5 * share(random), Mode::strain, longest - 0.03 * share(random) - 0.003);
  if (mode != Mode::strain) {
    loop.run(0.01 + 0.2 * share(random), mode, present(loop, mode));
  }
}

TEST(Controller, ChangesItsModeWithoutAJump) {
  std::mt19937_64 random(1);
  for (const Mode from : closed_modes) {
    for (const Mode to : closed_modes) {
      for (int i = 0; i < (from == to ? 0 : 4); ++i) {
        ClosedLoop<> loop(settings_with_pid());
        loop.against_spring(2e9);
        bring_about(loop, from, random);
        const double before_W = loop.control.power_W;
        const double max_W = 0.4 * 0.4 * loop.wire.resistance_ohm();
        const double setpoint = present(loop, to);
        const double after_W = loop.step(to, setpoint).wanted_power_W;
        // The tolerance is 2 % of the range.
        ASSERT_NEAR(after_W, before_W, 0.02 * max_W)
            << "from mode " << static_cast<int>(from) << " to " << static_cast<int>(to);
        loop.run(0.15, to, setpoint);
        ASSERT_NEAR(loop.control.transfer_W, 0, 1e-5);
      }
    }
  }
}

TEST(Controller, BeginsFromNothing) {
  for (const Mode mode : closed_modes) {
    ClosedLoop<> loop(test_settings());
    const double setpoint = mode == Mode::power     ? 1.0
                            : mode == Mode::current ? 0.2
                                                    : present(loop, mode);
    // The power rises from zero to that of the new mode within transfer_s.
    EXPECT_LT(loop.step(mode, setpoint).wanted_power_W, 0.02);
    loop.run(0.05, mode, setpoint);
    EXPECT_NEAR(loop.control.transfer_W, 0, 0.02);
  }
}

TEST(Controller, NewGainsMakeNoStep) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> factor(0.2, 4);
  for (const Mode mode : {Mode::strain, Mode::temperature, Mode::resistance, Mode::force}) {
    for (int i = 0; i < 10; ++i) {
      ClosedLoop<> loop(settings_with_pid());
      loop.against_spring(2e9);
      bring_about(loop, mode, random);
      const double setpoint = present(loop, mode);
      loop.run(1, mode, setpoint);
      Settings<double> other = settings_with_pid();
      for (LoopGains<double>* gains :
           {&other.strain, &other.temperature, &other.resistance, &other.force}) {
        gains->proportional *= factor(random);
        gains->integral_1_s *= i % 3 == 0 ? 0 : factor(random);
        gains->derivative_s *= factor(random);
        gains->derivative_weight = i % 2;
        gains->setpoint_weight = 0.5;
      }
      other.feed_forward_s *= factor(random);
      double last_W = loop.control.power_W;
      loop.adopt(other);
      for (int k = 0; k < 5; ++k) {
        const double now_W = loop.step(mode, setpoint).wanted_power_W;
        // In a millisecond the power may change by 0.2 % of the range, and by the part of the
        // difference that fades meanwhile.
        const double fades_W = 0.12 * std::abs(loop.control.transfer_W);
        ASSERT_NEAR(now_W, last_W, 0.01 + fades_W)
            << static_cast<int>(mode) << " after " << k << " ms";
        last_W = now_W;
      }
    }
  }
}

TEST(Controller, NewGainsKeepWhatTheIntegralHasLearned) {
  // The room is 15 K colder than the model assumes.
  Settings<double> settings = test_settings();
  settings.temperature.integral_1_s = 5;
  ClosedLoop<> loop(settings);
  loop.ideal_sensor = true;
  loop.wire.ambient(283.15);
  loop.run(4, Mode::temperature, 340);
  ASSERT_NEAR(loop.wire.temperature_K(), 340, 0.02);
  ASSERT_GT(loop.control.pid.integral_W, 0.03);
  settings.temperature.proportional *= 1.5;
  loop.adopt(settings);
  loop.run(0.5, Mode::temperature, 340,
           [&](const auto&) { ASSERT_NEAR(loop.wire.temperature_K(), 340, 0.02); });
}

// Every mode holds its set-point.

TEST(Controller, HoldsACurrentAndAPower) {
  ClosedLoop<> loop(test_settings());
  loop.run(0.3, Mode::current, 0.1);
  EXPECT_NEAR(loop.step(Mode::current, 0.1).drive_current_A, 0.1, 1e-12);
  loop.run(0.3, Mode::power, 0.25);
  const auto result = loop.step(Mode::power, 0.25);
  EXPECT_NEAR(result.wanted_power_W, 0.25, 1e-12);
  EXPECT_NEAR(result.drive_current_A * result.drive_current_A * loop.wire.resistance_ohm(), 0.25,
              1e-4);
}

TEST(Controller, HoldsATemperature) {
  ClosedLoop<> loop(test_settings());
  for (const double setpoint_K : {360.0, 330.0, 375.0}) {
    loop.run(3, Mode::temperature, setpoint_K);
    EXPECT_NEAR(loop.estimate().temperature_K, setpoint_K, 0.2);
    EXPECT_NEAR(loop.wire.temperature_K(), setpoint_K, 1.5);
  }
}

TEST(Controller, HoldsAResistance) {
  ClosedLoop<> loop(test_settings());
  loop.run(1, Mode::strain, loop.wire.strain() - 0.02);
  const double ohm = loop.wire.resistance_ohm();
  for (const double setpoint_ohm : {ohm - 0.5, ohm + 0.5, ohm}) {
    loop.run(3, Mode::resistance, setpoint_ohm);
    EXPECT_NEAR(loop.wire.resistance_ohm(), setpoint_ohm, 0.05);
  }
}

TEST(Controller, HoldsAForceAgainstASpring) {
  ClosedLoop<> loop(test_settings(), 100e6);
  loop.against_spring(2e9);
  for (const double stress_Pa : {120e6, 150e6, 110e6}) {
    loop.run(3, Mode::force, stress_Pa * area_m2());
    EXPECT_NEAR(loop.wire.stress_Pa(), stress_Pa, 1e6);
  }
}

TEST(Controller, APositionIsAStrainSeenFromTheAxis) {
  ClosedLoop<> strain(test_settings()), position(test_settings());
  const double length_m = test_settings().wire.geometry.length_m;
  const double zero = test_settings().axis.zero_strain;
  for (const double goal : {0.03, 0.015, 0.025}) {
    for (int i = 0; i < 600; ++i) {
      const auto a = strain.step(Mode::strain, goal);
      const auto b = position.step(Mode::position, (zero - goal) * length_m);
      ASSERT_NEAR(a.drive_current_A, b.drive_current_A, 1e-9);
      ASSERT_NEAR(b.reference, (zero - a.reference) * length_m, 1e-12);
    }
  }
}

TEST(Controller, ASetpointBeyondItsLimitIsSaid) {
  ClosedLoop<> loop(test_settings());
  loop.run(0.1, Mode::strain, loop.wire.strain() - 0.01);
  const SoftLimits<double>& q = loop.prepared().settings.limits;
  const auto strain = loop.step(Mode::strain, q.max_strain + 0.01);
  EXPECT_EQ(strain.setpoint, q.max_strain);
  EXPECT_TRUE(strain.limit_reasons & bit(LimitReason::strain));
  const auto temperature = loop.step(Mode::temperature, q.temperature_K);
  EXPECT_EQ(temperature.setpoint, q.temperature_K - q.hot_spot_K);
  EXPECT_TRUE(temperature.limit_reasons & bit(LimitReason::temperature));
  const auto force = loop.step(Mode::force, 2 * q.stress_Pa * area_m2());
  EXPECT_NEAR(force.setpoint, q.stress_Pa * area_m2(), 1e-12);
  EXPECT_TRUE(force.limit_reasons & bit(LimitReason::stress));
}

TEST(Controller, WaitsForAWireThatCools) {
  ClosedLoop<> loop(test_settings(), 300e6);
  const double longest = loop.wire.strain();
  loop.run(1, Mode::strain, longest - 0.03);
  double max_ahead = 0;
  double heat_W = 0;
  loop.run(0.2, Mode::strain, longest - 0.005, [&](const auto& result) {
    max_ahead = std::max(max_ahead, result.reference - loop.estimate().strain);
    heat_W = std::max(
        heat_W, result.limit_reasons & bit(LimitReason::trajectory) ? result.wanted_power_W : 0);
  });
  EXPECT_NEAR(max_ahead, Trajectory<double>::lead, 1e-4);
  EXPECT_LT(heat_W, 0.006);  // the least current
}

TEST(Controller, NoNumberIsKept) {
  for (const Mode mode : closed_modes) {
    ClosedLoop<> loop(settings_with_pid());
    loop.run(0.5, Mode::strain, loop.wire.strain() - 0.02);
    const double setpoint = present(loop, mode);
    loop.run(0.1, mode, setpoint);
    const double before_W = loop.control.power_W;
    for (int i = 0; i < 10; ++i) {
      const auto lost = loop.step(mode, nan);
      EXPECT_TRUE(std::isfinite(lost.drive_current_A));
      EXPECT_LT(lost.wanted_power_W, 0.006);
    }
    loop.run(0.3, mode, setpoint);
    EXPECT_NEAR(loop.control.power_W, before_W, 0.1) << static_cast<int>(mode);
  }
}

TEST(Controller, AnUnknownWireGetsNoCurrent) {
  ClosedLoop<> loop(test_settings());
  loop.run(0.2, Mode::power, 0.3);
  const auto p = loop.prepared();
  const Measurement<double> m{};
  const auto filter = KalmanObserver<double>::start(p.observer, m, room_K);
  Estimate<double> e = loop.estimate();
  for (double* lost : {&e.strain, &e.temperature_K, &e.resistance_model_ohm}) {
    const double was = *lost;
    *lost = nan;
    const ControlInputs<double> known{m, e, filter, 0, 24};
    const auto none =
        Controller<double>::step(p, loop.control, {Mode::power, 0.3, {}}, known, 1e-3);
    EXPECT_EQ(none.drive_current_A, 0);
    EXPECT_EQ(none.drive_voltage_V, 0);
    *lost = was;
    EXPECT_TRUE(std::isfinite(loop.step(Mode::power, 0.3).drive_current_A));
  }
}

TEST(Controller, OffIsNoCurrent) {
  ClosedLoop<> loop(test_settings());
  loop.run(0.2, Mode::power, 0.3);
  EXPECT_EQ(loop.step(Mode::off, 0.3).drive_current_A, 0);
}

TEST(Controller, ACurrentHasNoSign) {
  ClosedLoop<> loop(test_settings());
  loop.run(0.1, Mode::current, -0.3);
  EXPECT_NEAR(loop.step(Mode::current, -0.3).drive_current_A, 0.012, 1e-9);
}

TEST(Controller, RestKeepsTheDuty) {
  ClosedLoop<> loop(test_settings());
  loop.run(1, Mode::current, 0.1);
  const double before = loop.control.duty;
  ASSERT_GT(before, 0);
  for (int i = 0; i < 10000; ++i) {
    Controller<double>::rest(loop.prepared(), loop.control, 1e-3);
  }
  EXPECT_NEAR(loop.control.duty, before * std::exp(-1), 1e-3 * before);
  EXPECT_EQ(loop.control.power_W, 0);
}

TEST(Controller, TheIdentificationProfileGoesThroughTheTransformation) {
  Settings<double> settings = test_settings();
  settings.profile = {12, 5, 0.5};
  ClosedLoop<> loop(settings);
  double shortest = 1, hottest_K = 0;
  const double longest = loop.wire.strain();
  loop.run(10, Mode::identification, 0, [&](const auto&) {
    shortest = std::min(shortest, loop.wire.strain());
    hottest_K = std::max(hottest_K, loop.wire.temperature_K());
  });
  EXPECT_GT(longest - shortest, 0.8 * stroke);
  const Isobar<double> m2a = isobar(settings.wire.kinetics.m2a, 150e6);
  EXPECT_NEAR(hottest_K, m2a.start_K + 1 / m2a.per_K + 12, 4);
}

TEST(Controller, FloatFollowsDouble) {
  ClosedLoop<double> exact(test_settings());
  ClosedLoop<float> quick(test_settings<float>());
  const double longest = exact.wire.strain();
  double worst = 0;
  for (const double contraction : {0.01, 0.03, 0.02, 0.005}) {
    for (int i = 0; i < 800; ++i) {
      exact.step(Mode::strain, longest - contraction);
      quick.step(Mode::strain, longest - contraction);
      worst = std::max(worst, std::abs(exact.wire.strain() - quick.wire.strain()));
    }
  }
  std::printf("float against double: %.2g of the stroke\n", worst / stroke);
  EXPECT_LT(worst / stroke, 1e-4);
}

}  // namespace
}  // namespace smaservo::control_test
