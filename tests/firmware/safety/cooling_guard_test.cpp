#include "firmware/safety/cooling/cooling_guard.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <utility>

#include "tests/firmware/device/rig.hpp"

namespace smaservo {
namespace {

/// A wire that is pressed against its temperature limit, by a strain that is out of reach.
Settings<double> pressed_settings() {
  Settings<double> s = test_settings();
  s.limits.temperature_K = 393.15;
  s.limits.hot_spot_K = 18;
  s.limits.loss_margin = 1;
  s.limits.min_strain = -0.05;
  s.trips.temperature_K = 403.15;
  s.trips.following_error = 1;
  return s;
}
Rig pressed_rig(double draught) {
  Rig rig = plain_rig(pressed_settings());
  rig.run(0.2);
  rig.draught = draught;
  rig.arm(Mode::power, 10);
  return rig;
}
const CoolingGuard<double>& guard(const Rig& rig) {
  return rig.state.monitor.wire.cooling;
}
bool confirmed(const Rig& rig) {
  return guard(rig).told.verdict == CoolingGuard<double>::Verdict::confirmed;
}

TEST(CoolingGuard, LeavesAWireAloneThatIsCooledAsItsFileSays) {
  Rig rig = pressed_rig(1);
  int cut = 0;
  for (int i = 0; i < 30000; ++i) {
    rig.step();
    cut += guard(rig).probing() ? 1 : 0;
    ASSERT_FALSE(guard(rig).weak()) << "at step " << i;
  }
  EXPECT_TRUE(confirmed(rig));
  EXPECT_EQ(rig.out.cooling, 1);
  EXPECT_LT(cut, 1500) << "of the time, less than 5 % is given for tests";
  EXPECT_GT(cut, 50) << "without a test nothing is confirmed";
}

TEST(CoolingGuard, NeverCutsTheHeatBelowWhereItCouldBeTooHot) {
  Rig rig = plain_rig(pressed_settings());
  rig.run(0.2);
  rig.arm(Mode::temperature, 345);
  for (int i = 0; i < 5000; ++i) {
    rig.step();
    ASSERT_FALSE(guard(rig).probing());
  }
}

/// A strain that can be reached, so that the temperature limit does not act.
Rig holding_rig(double share_of_stroke, double load_Pa) {
  Rig rig = plain_rig(pressed_settings(), load_Pa);
  rig.run(0.2);
  rig.arm(Mode::strain, rig.wire->strain() - share_of_stroke * 0.04);
  return rig;
}

/// While a strain is held, the guard makes one test at the beginning and none later, even less than
/// 12 K below the limit.
TEST(CoolingGuard, CostsNoRippleWhereTheSetPointIsReached) {
  for (const double load_Pa : {100e6, 150e6}) {
    Rig rig = holding_rig(0.75, load_Pa);
    double low = 1, high = -1;
    int tests = 0;
    for (int i = 0; i < 60'000; ++i) {
      const bool before = guard(rig).probing();
      rig.step();
      tests += guard(rig).probing() && !before ? 1 : 0;
      if (i > 10'000) {
        low = std::min(low, rig.wire->strain());
        high = std::max(high, rig.wire->strain());
      }
    }
    EXPECT_EQ(rig.out.state, DeviceState::running);
    EXPECT_EQ(tests, 1);
    EXPECT_LT(high - low, 1e-3 * 0.04) << load_Pa;
  }
}

/// When cooling is lost, the loop gives less power. By the file's cooling the wire would then be
/// colder and far below its limit, where there are no regular tests.
TEST(CoolingGuard, FindsCoolingThatIsLostWhileAStrainIsHeld) {
  Settings<double> settings = pressed_settings();
  settings.limits.temperature_K = 413.15;
  settings.trips.temperature_K = 423.15;
  for (const double load_Pa : {50e6, 100e6, 150e6}) {
    Rig rig = plain_rig(settings, load_Pa);
    rig.run(0.2);
    rig.arm(Mode::strain, rig.wire->strain() - 0.88 * 0.04);
    rig.run(12);
    ASSERT_EQ(rig.out.state, DeviceState::running);
    rig.draught = 0.3;
    int too_hot = 0;
    for (int i = 0; i < 20'000; ++i) {
      rig.step();
      too_hot += rig.wire->hottest_K() > settings.limits.temperature_K + 3 ? 1 : 0;
    }
    EXPECT_LT(too_hot * Rig::dt_s, 3) << load_Pa;
    EXPECT_TRUE(rig.out.latched.has(Fault::cooling_lost) ||
                rig.out.warnings.has(Fault::cooling_weak))
        << load_Pa;
  }
}

class LessCooling : public ::testing::TestWithParam<double> {};

TEST_P(LessCooling, FromTheStartIsFoundBeforeTheWireIsTooHot) {
  Rig rig = pressed_rig(GetParam());
  rig.run(4);
  EXPECT_LT(rig.hottest_K, rig.settings.limits.temperature_K + 3);
  EXPECT_TRUE(rig.out.warnings.has(Fault::cooling_weak));
  EXPECT_NEAR(rig.out.cooling, GetParam(), 0.2);
  EXPECT_GT(std::abs(rig.out.cooling - 1), 0.2);
  rig.run(20);
  EXPECT_LT(rig.hottest_K, rig.settings.limits.temperature_K + 3);
}

TEST_P(LessCooling, IsFoundWhereTheResistanceMovesByItself) {
  Rig rig = pressed_rig(1);
  rig.run(20);
  ASSERT_TRUE(confirmed(rig));
  rig.draught = GetParam();
  rig.run(20);
  EXPECT_LT(rig.hottest_K, rig.settings.limits.temperature_K + 15);
  EXPECT_TRUE(rig.out.warnings.has(Fault::cooling_weak) ||
              rig.out.latched.has(Fault::cooling_lost));
}

/// Time above the limit by more than 3 K, in `for_s` from now on.
double too_hot_s(Rig& rig, double for_s) {
  double time_s = 0;
  while (for_s > 0) {
    rig.step();
    time_s += rig.wire->hottest_K() > rig.settings.limits.temperature_K + 3 ? Rig::dt_s : 0;
    for_s -= Rig::dt_s;
  }
  return time_s;
}

/// Tests of the cooling are made at times of their own; none of the times between them may be bad.
TEST_P(LessCooling, IsFoundAtWhateverMomentItIsLost) {
  for (int i = 0; i < 10; ++i) {
    Rig rig = pressed_rig(1);
    rig.run(20 + 0.1 * i);
    ASSERT_TRUE(confirmed(rig)) << i;
    rig.draught = GetParam();
    rig.run(20);
    EXPECT_LT(rig.hottest_K, rig.settings.limits.temperature_K + 15) << i;
  }
}

/// A wire drawn at random that heats against its limit, under 70 to 200 MPa, in air that is
/// measured.
std::unique_ptr<Rig> random_pressed_rig(std::mt19937_64& random, bool distributed) {
  const Settings<double> settings = pressed_settings();
  const Unlike unlike = random_unlike(random);
  const double load_Pa = std::uniform_real_distribution<double>(70e6, 200e6)(random);
  std::unique_ptr<RigWire> wire;
  if (distributed) {
    wire = std::make_unique<DistributedRigWire>(settings.wire, unlike, load_Pa, random);
  } else {
    wire = std::make_unique<LumpedRigWire>(settings.wire, unlike, load_Pa);
  }
  auto rig = std::make_unique<Rig>(settings, std::move(wire), load_Pa, random());
  rig->tamper_inputs = [air_K = unlike.ambient_K](Inputs<double>& in) { in.ambient_K = air_K; };
  rig->run(0.2);
  rig->arm(Mode::power, 10);
  return rig;
}

/// Cooling that falls to a half within 20 s, as where a fan runs down or a box is closed: each test
/// finds a little less than the one before. What becomes too hot is told.
TEST(CoolingGuard, FollowsCoolingThatFadesAway) {
  constexpr int wires = 8;
  for (const bool distributed : {false, true}) {
    std::mt19937_64 random(400);
    double hot_s = 0;
    int above_15_K = 0;
    for (int wire = 0; wire < wires; ++wire) {
      const auto rig = random_pressed_rig(random, distributed);
      rig->run(std::uniform_real_distribution<double>(10, 15)(random));
      ASSERT_EQ(rig->out.state, DeviceState::running) << wire;
      ASSERT_FALSE(guard(*rig).weak()) << wire;
      bool told = false;
      for (int i = 0; i < 250; ++i) {
        rig->draught = std::max(0.5, 1 - i / 400.0);
        hot_s += too_hot_s(*rig, 0.1);
        told = told || rig->out.warnings.has(Fault::cooling_weak) ||
               rig->out.latched.has(Fault::cooling_lost);
      }
      const double above_K = rig->hottest_K - rig->settings.limits.temperature_K;
      EXPECT_TRUE(told || above_K < 0) << wire;
      above_15_K += above_K > 15 ? 1 : 0;
    }
    EXPECT_EQ(above_15_K, 0);
    EXPECT_LT(hot_s, 0.5 * wires);
  }
}

/// A wire that is held at its limit stays there, but for the probes. It must not be taken for a
/// hotter one when it cools a little and begins to transform: it would swing through its hysteresis
/// once a second, and each swing would be a test without a probe.
TEST(CoolingGuard, LetsAPressedWireRest) {
  for (const bool distributed : {false, true}) {
    std::mt19937_64 random(500);
    int tested = 0;
    for (int wire = 0; wire < 8; ++wire) {
      const auto rig = random_pressed_rig(random, distributed);
      int swings = 0;
      for (int i = 0; i < 60'000; ++i) {
        const bool probing = guard(*rig).probing();
        const double since_s = guard(*rig).told.since_s;
        rig->step();
        swings += !probing && guard(*rig).told.since_s < since_s ? 1 : 0;
      }
      EXPECT_EQ(rig->out.state, DeviceState::running) << wire;
      tested += guard(*rig).told.lease_s >= 4 ? 1 : 0;
      const double limit_K = rig->settings.limits.temperature_K - rig->settings.limits.hot_spot_K;
      EXPECT_GT(rig->hottest_K, limit_K - 10) << wire;
      EXPECT_LE(swings, 2) << wire << (distributed ? " distributed" : "");
    }
    EXPECT_GE(tested, 6) << "the guard has confirmed their cooling several times";
  }
}

/// A resistance that is 1 to 2 % too high looks like R-phase, which would be cold at this power.
TEST_P(LessCooling, IsFoundWhereTheObserverTakesTheHotWireForRPhase) {
  for (const double load_Pa : {50e6, 150e6}) {
    Rig rig = plain_rig(pressed_settings(), load_Pa);
    rig.run(0.2);
    rig.draught = GetParam();
    rig.tamper_estimate = [](Estimate<double>& e) {
      if (e.martensite + e.r_phase < 0.5) {
        e.martensite = 0.07;
        e.r_phase = 0.43;
        e.temperature_K = 346;
      }
    };
    rig.arm(Mode::power, 10);
    EXPECT_LT(too_hot_s(rig, 20), 3.5) << load_Pa;
    EXPECT_LT(rig.hottest_K, rig.settings.limits.temperature_K + 25) << load_Pa;
    EXPECT_TRUE(rig.out.warnings.has(Fault::cooling_weak)) << load_Pa;
  }
}

INSTANTIATE_TEST_SUITE_P(Shares, LessCooling, ::testing::Values(0.3, 0.4, 0.5));

TEST(CoolingGuard, LeavesALittleLessCoolingToTheMarginOfTheHotSpot) {
  Rig rig = pressed_rig(0.8);
  rig.run(20);
  EXPECT_LT(rig.hottest_K, rig.settings.limits.temperature_K + 3);
}

TEST(CoolingGuard, FindsThatAFanRunsAgain) {
  Rig rig = pressed_rig(0.4);
  rig.run(3);
  ASSERT_TRUE(rig.out.warnings.has(Fault::cooling_weak));
  rig.draught = 1;
  rig.run(15);
  EXPECT_FALSE(rig.out.warnings.has(Fault::cooling_weak));
  EXPECT_EQ(rig.out.cooling, 1);
}

/// A wire that is probed as soon as it is hot has been hot for too short a time for a result, most
/// of all under a light load in warm air. The next probe must wait, also after a gust.
TEST(CoolingGuard, ProbesAWeakWireOnlyAfterItHasBeenHot) {
  Unlike unlike;
  unlike.ambient_K = 311.15;
  const Settings<double> settings = pressed_settings();
  Rig rig(settings, std::make_unique<LumpedRigWire>(settings.wire, unlike, 40e6), 40e6);
  rig.tamper_inputs = [](Inputs<double>& in) { in.ambient_K = 311.15; };
  rig.run(0.2);
  rig.draught = 0.6;
  rig.arm(Mode::power, 10);
  rig.run(26);
  ASSERT_TRUE(guard(rig).weak());
  int probes = 0;
  for (int i = 0; i < 40'000; ++i) {
    if (i < 20'000) {
      rig.draught = i / 2000 % 2 == 0 ? 0.55 : 0.65;
    } else {
      rig.command.setpoint = i / 1000 % 8 < 7 ? 0.05 : 10;
    }
    const bool before = guard(rig).probing();
    rig.step();
    probes += guard(rig).probing() && !before ? 1 : 0;
  }
  EXPECT_EQ(rig.out.state, DeviceState::running);
  EXPECT_LE(probes, 20);
}

/// R-phase is doubted only where no test has just shown it: held there, the wire is left alone.
TEST(CoolingGuard, LeavesAWireAloneThatIsRPhase) {
  for (const double draught : {1.0, 2.0}) {
    Rig rig = plain_rig(pressed_settings(), 50e6);
    rig.run(0.2);
    rig.draught = draught;
    rig.arm(Mode::temperature, 370);
    rig.run(2);
    rig.command.setpoint = 330;
    rig.run(1);
    int cut = 0;
    for (int i = 0; i < 30'000; ++i) {
      rig.step();
      cut += guard(rig).probing() ? 1 : 0;
    }
    EXPECT_EQ(rig.out.state, DeviceState::running);
    EXPECT_GT(MultipleModelFilter<double>::likeliest(rig.state.observer.observer).kinetics.r_phase,
              0.25);
    EXPECT_LT(cut, 300) << draught;
  }
}

TEST(CoolingGuard, ForgetsWhatItKnewOfAWireThatHasRested) {
  Rig rig = pressed_rig(1);
  rig.run(3);
  ASSERT_TRUE(confirmed(rig));
  rig.command.arm = false;
  rig.run(15);
  EXPECT_FALSE(confirmed(rig));
}

}  // namespace
}  // namespace smaservo
