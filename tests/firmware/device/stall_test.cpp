// A loop that stands still: the fault loop_stalled, and what the device assumes of the wire
// afterwards.

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/firmware/device/rig.hpp"

namespace smaservo::stall_test {
namespace {

/// Heated for a while, so that the estimate is good.
Rig running(Mode mode, double setpoint) {
  Settings<double> settings = test_settings();
  settings.limits.min_strain = -0.05;
  settings.limits.loss_margin = 20;
  Rig rig = plain_rig(settings);
  rig.arm(mode, setpoint);
  rig.run(1);
  EXPECT_EQ(rig.out.state, DeviceState::running);
  EXPECT_EQ(rig.out.estimate.health, Health::good);
  return rig;
}

// Only loop_stalled is reported, whatever the output did meanwhile: if the one-shot has cut the
// current, this is not taken for an open wire.
TEST(Stall, LongerThanTheLeaseIsAFaultThatSaysSo) {
  for (const double time_s : {0.003, 0.009, 0.02, 0.3, 8.0}) {
    for (const bool cut : {false, true}) {
      Rig rig = running(Mode::strain, 0.02);
      rig.stall(time_s, cut);
      rig.step();
      EXPECT_EQ(rig.out.first_cause, Fault::loop_stalled) << time_s;
      EXPECT_EQ(rig.out.drive_current_A, 0);
      for (int i = 0; i < 500; ++i) {
        rig.step();
        ASSERT_EQ(rig.out.latched, FaultSet(Fault::loop_stalled)) << time_s << ", step " << i;
        ASSERT_EQ(rig.out.state, DeviceState::fault);
        ASSERT_EQ(rig.out.drive_current_A, 0);
      }
    }
  }
}

TEST(Stall, WithinTheLeaseIsNone) {
  Rig rig = running(Mode::strain, 0.02);
  for (int i = 0; i < 50; ++i) {
    rig.stall(0.002);
    rig.run(0.02);
  }
  EXPECT_TRUE(rig.out.latched.empty()) << fault_name(rig.out.first_cause);
  EXPECT_EQ(rig.out.state, DeviceState::running);
}

// The device assumes the worst, that the last command persisted. So the wire is never hotter than
// the device believes when the fault is cleared.
TEST(Stall, TheWireIsAsHotAsThePersistingPowerMakesIt) {
  for (const double power_W : {0.05, 0.15, 0.3, 0.6}) {
    for (const double time_s : {0.004, 0.02, 0.1, 0.5, 2.0, 8.0, 60.0}) {
      Rig rig = running(Mode::strain, 0.03);
      rig.command.mode = Mode::power;
      rig.command.setpoint = power_W;
      rig.run(0.02);
      ASSERT_EQ(rig.out.state, DeviceState::running);
      const double before_K = rig.wire->hottest_K();
      rig.stall(time_s);
      rig.step();
      const double heat_K = rig.state.monitor.wire.heat.temperature_K;
      // The temperature by heat has a wider tolerance, as it uses only the heating branch.
      EXPECT_GE(rig.out.estimate.temperature_K, rig.wire->hottest_K() - 1)
          << power_W << " W, " << time_s << " s, from " << before_K << " K";
      EXPECT_GE(heat_K, rig.wire->hottest_K() - 3)
          << power_W << " W, " << time_s << " s, from " << before_K << " K";
      EXPECT_TRUE(std::isfinite(rig.out.estimate.strain));
    }
  }
}

// A power that would melt the wire, in stalls of up to 30 years.
TEST(Stall, NothingIsLostInTheLongestOne) {
  for (const double time_s : {1.0, 1000.0, 1e9}) {
    Rig rig = running(Mode::strain, 0.03);
    rig.command.mode = Mode::current;
    rig.command.setpoint = 0.4;
    rig.run(0.03);
    ASSERT_GT(rig.out.drive_current_A, 0.2);
    const std::uint64_t before_us = rig.out.time_us;
    const Measurement<double> m =
        Device<double>::observe(rig.prepared, rig.state, rig.inputs, time_s);
    const Estimate<double> e = Device<double>::estimate(rig.prepared, rig.state);
    rig.out =
        Device<double>::decide(rig.prepared, rig.state, rig.inputs, m, e, rig.command, time_s);
    EXPECT_EQ(rig.out.time_us - before_us, static_cast<std::uint64_t>(std::min(time_s, 1e3) * 1e6));
    EXPECT_TRUE(std::isfinite(rig.out.estimate.temperature_K));
    EXPECT_GT(rig.out.estimate.temperature_K, rig.settings.trips.temperature_K);
    EXPECT_GT(rig.state.monitor.wire.heat.temperature_K, rig.settings.trips.temperature_K);
    EXPECT_EQ(rig.out.first_cause, Fault::loop_stalled);
    EXPECT_EQ(rig.out.latched, FaultSet(Fault::loop_stalled));
  }
}

TEST(Stall, ThePersistingCurrentCountsAsDuty) {
  Rig rig = running(Mode::strain, 0.03);
  rig.command.mode = Mode::current;
  rig.command.setpoint = 0.4;
  rig.run(0.03);
  const double before = rig.state.controller.duty;
  rig.stall(10);
  rig.step();
  EXPECT_GT(rig.state.controller.duty, before + 0.1);
}

// A stall without current only blocks arming for a while; then the device can be armed again.
TEST(Stall, WithoutHeatItIsForgotten) {
  Rig rig = plain_rig();
  rig.run(0.3);
  ASSERT_EQ(rig.out.state, DeviceState::ready);
  rig.stall(30);
  rig.step();
  EXPECT_TRUE(rig.out.blocks.has(Fault::loop_stalled));
  EXPECT_TRUE(rig.out.latched.empty());
  rig.run(0.5);
  EXPECT_TRUE(rig.out.blocks.empty());
  rig.arm(Mode::strain, 0.02);
  EXPECT_EQ(rig.out.state, DeviceState::running);
}

// After the fault has been cleared, a command to arm that has stood all the time does not heat; a
// new one does, and the estimate becomes good again.
TEST(Stall, IsClearedLikeAnyFault) {
  for (const bool cut : {false, true}) {
    Rig rig = running(Mode::strain, 0.02);
    rig.stall(8, cut);
    rig.run(20);
    EXPECT_EQ(rig.out.state, DeviceState::fault);
    EXPECT_EQ(rig.out.latched, FaultSet(Fault::loop_stalled));
    rig.command.clear_faults = true;
    rig.run(0.1);
    EXPECT_EQ(rig.out.state, DeviceState::ready);
    rig.command.clear_faults = rig.command.arm = false;
    rig.run(0.1);
    rig.arm(Mode::strain, 0.02);
    rig.run(3);
    EXPECT_EQ(rig.out.state, DeviceState::running) << fault_name(rig.out.first_cause);
    EXPECT_NEAR(rig.wire->strain(), 0.02, 1e-3);
  }
}

}  // namespace
}  // namespace smaservo::stall_test
