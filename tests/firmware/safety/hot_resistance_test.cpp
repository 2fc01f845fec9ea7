// A wire that is cooled less than the observer believes: only its resistance tells.

#include "firmware/safety/monitor/hot_resistance.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/device/rig.hpp"

namespace smaservo::hot_resistance_test {
namespace {

Settings<double> hot_settings() {
  Settings<double> settings = test_settings();
  settings.limits.temperature_K = 413.15;
  settings.trips.temperature_K = 423.15;
  settings.limits.min_strain = -0.05;
  return settings;
}

/// Gives the wire all the power that the limits allow, so that it is at its temperature limit, 40 K
/// beyond the end of the transformation. Tests of the cooling are prevented, because each of them
/// starts HotResistance anew.
void hold_at_limit(Rig& rig) {
  rig.tamper_command = [&rig](Command<double>&) { rig.state.monitor.wire.cooling.confirm(); };
  rig.run(0.1);
  rig.arm(Mode::power, 10);
  rig.run(3);
}

/// The last martensite that disappears takes away a part of what the heat adds to the resistance,
/// so the temperature that it tells is a lower bound.
TEST(HotResistance, KeepsAWireThatIsCooledLessBelowItsLimit) {
  for (const double draught : {0.9, 0.8, 0.7}) {
    Rig rig = plain_rig(hot_settings(), 50e6);
    hold_at_limit(rig);
    ASSERT_EQ(rig.out.state, DeviceState::running);
    rig.draught = draught;
    rig.run(3);
    EXPECT_LE(rig.hottest_K, rig.settings.limits.temperature_K + 3) << draught;
    const double told_K = rig.state.monitor.wire.hot.temperature_K;
    EXPECT_LE(told_K, rig.wire->hottest_K()) << draught;
    EXPECT_GT(told_K, rig.wire->hottest_K() - 7) << draught;
    EXPECT_FALSE(rig.out.latched.has(Fault::overheat_signature)) << draught;
  }
}

TEST(HotResistance, NeedsAustenite) {
  Rig rig = plain_rig();
  rig.run(0.1);
  rig.arm(Mode::strain, rig.wire->strain() - 0.01);
  rig.run(1);
  EXPECT_EQ(rig.state.monitor.wire.hot.temperature_K, 0);
}

TEST(HotResistance, DoesNotTakeMartensiteForHeat) {
  Rig rig = plain_rig(hot_settings(), 50e6);
  hold_at_limit(rig);
  rig.command.setpoint = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.step();
    EXPECT_LT(rig.state.monitor.wire.hot.temperature_K, rig.settings.limits.temperature_K);
  }
  EXPECT_TRUE(rig.out.latched.empty());
}

}  // namespace
}  // namespace smaservo::hot_resistance_test
