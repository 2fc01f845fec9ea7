// The device's states, as its user meets them.

#include "firmware/safety/supervisor.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/safety/provokers.hpp"

namespace smaservo::supervisor_test {
namespace {

Rig running_rig(const Settings<double>& settings = test_settings()) {
  Rig rig = plain_rig(settings);
  rig.run(0.1);
  rig.arm(Mode::strain, rig.wire->strain() - 0.015);
  rig.run(0.3);
  return rig;
}

void clear(Rig& rig) {
  rig.command.clear_faults = true;
  rig.step();
  rig.command.clear_faults = false;
  rig.step();
}

TEST(Supervisor, GivesNoCurrentUntilItIsArmed) {
  Rig rig = plain_rig();
  rig.command.mode = Mode::strain;
  rig.command.setpoint = 0.02;
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(rig.step().drive_current_A, 0);
  }
  EXPECT_EQ(rig.out.state, DeviceState::ready);
  EXPECT_TRUE(rig.out.blocks.empty());
}

TEST(Supervisor, ArmsWithASenseCurrentFirst) {
  Rig rig = plain_rig();
  rig.run(0.2);
  rig.command.arm = true;
  rig.command.mode = Mode::strain;
  rig.command.setpoint = 0.02;
  int sensing = 0;
  while (rig.step().state == DeviceState::arming) {
    EXPECT_EQ(rig.out.drive_current_A, rig.settings.limits.min_current_A);
    ++sensing;
  }
  EXPECT_EQ(rig.out.state, DeviceState::running);
  EXPECT_GE(sensing, 50);
  EXPECT_LE(sensing, 100);
  rig.run(3 * rig.settings.transfer_s);
  EXPECT_GT(rig.out.drive_current_A, 0.1);
}

TEST(Supervisor, TakesAwayTheSensorsOffsets) {
  Settings<double> settings = test_settings();
  settings.trips.following_error = 1;
  Rig rig = plain_rig(settings);
  rig.tamper_inputs = [](Readings& in) {
    in.sample.current_A += 0.0015;
    in.sample.voltage_V += 0.01;
  };
  rig.run(0.1);
  rig.arm(Mode::strain, 0.03);
  rig.command.setpoint = 0.06;  // only the least current, where offsets hurt most
  rig.run(3);
  ASSERT_EQ(rig.out.state, DeviceState::running);
  EXPECT_NEAR(rig.out.measurement.resistance_ohm, rig.wire->resistance_ohm(),
              0.01 * rig.wire->resistance_ohm());
}

TEST(Supervisor, DisarmingEndsTheCurrentAtOnce) {
  Rig rig = running_rig();
  rig.command.arm = false;
  EXPECT_EQ(rig.step().drive_current_A, 0);
  EXPECT_EQ(rig.out.state, DeviceState::ready);
  EXPECT_TRUE(rig.out.latched.empty());
}

TEST(Supervisor, AllReasonsThatBlockAreShownAtOnce) {
  Rig rig = plain_rig();
  rig.supply_V = 3;
  rig.tamper_inputs = [](Readings& in) {
    in.external = Fault::store_corrupt;
    in.ambient_K = 350;
    in.driver_K = 370;
  };
  rig.run(1.5);
  for (const Fault fault :
       {Fault::supply_low, Fault::store_corrupt, Fault::ambient_range, Fault::driver_hot}) {
    EXPECT_TRUE(rig.out.blocks.has(fault)) << fault_name(fault);
  }
  // A supply that is off while the wire is not heated latches no fault, so nothing has to be
  // cleared.
  EXPECT_TRUE(rig.out.latched.empty());
}

TEST(Supervisor, ARefusedAttemptNeedsANewEdge) {
  Rig rig = plain_rig();
  rig.supply_V = 3;
  rig.run(0.2);
  rig.arm(Mode::strain, 0.02);
  rig.supply_V = 24;
  rig.run(0.5);
  EXPECT_EQ(rig.out.state, DeviceState::ready);
  rig.command.arm = false;
  rig.step();
  rig.arm(Mode::strain, 0.02);
  EXPECT_EQ(rig.out.state, DeviceState::running);
}

TEST(Supervisor, LatchesUntilClearedAndGone) {
  Rig rig = running_rig();
  const double fault_at_s = 1e-6 * static_cast<double>(rig.out.time_us);
  rig.supply_V = 3;
  rig.run(0.05);
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  EXPECT_EQ(rig.out.first_cause, Fault::supply_low);
  EXPECT_NEAR(1e-6 * static_cast<double>(rig.out.first_cause_us), fault_at_s + 0.006, 0.0011);
  clear(rig);  // the cause is still present
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  rig.supply_V = 24;
  rig.run(0.1);  // the cause has gone, but the fault is not cleared
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  EXPECT_TRUE(rig.out.active.empty());
  clear(rig);  // cleared at last; the command to arm has no new edge
  EXPECT_EQ(rig.out.state, DeviceState::ready);
  EXPECT_EQ(rig.out.first_cause, Fault::none);
  rig.run(0.3);
  EXPECT_EQ(rig.out.drive_current_A, 0);
  rig.command.arm = false;
  rig.step();
  rig.arm(Mode::strain, 0.025);
  EXPECT_EQ(rig.out.state, DeviceState::running);
}

TEST(Supervisor, AClearThatIsHeldClearsNothingThatComesLater) {
  Rig rig = running_rig();
  rig.command.clear_faults = true;
  rig.run(0.1);
  rig.tamper_inputs = [](Readings& in) { in.emergency_stop = true; };
  rig.step();
  rig.tamper_inputs = nullptr;
  rig.run(0.5);
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  EXPECT_TRUE(rig.out.latched.has(Fault::emergency_stop));
}

TEST(Supervisor, KeepsTheFirstCauseWhenOthersFollow) {
  Rig rig = running_rig();
  rig.command.fresh = false;
  rig.run(0.2);
  EXPECT_EQ(rig.out.first_cause, Fault::command_timeout);
  const std::uint64_t when = rig.out.first_cause_us;
  rig.tamper_inputs = [](Readings& in) { in.emergency_stop = true; };
  rig.run(0.1);
  EXPECT_EQ(rig.out.first_cause, Fault::command_timeout);
  EXPECT_EQ(rig.out.first_cause_us, when);
  EXPECT_TRUE(rig.out.latched.has(Fault::emergency_stop));
}

TEST(Supervisor, AnUncleanBootIsAcknowledgedThoughItStays) {
  Rig rig = plain_rig();
  reported(Fault::unclean_boot)(rig);
  rig.run(0.2);
  EXPECT_TRUE(rig.out.blocks.has(Fault::unclean_boot));
  clear(rig);
  EXPECT_TRUE(rig.out.blocks.empty());
  rig.arm(Mode::strain, 0.03);
  EXPECT_EQ(rig.out.state, DeviceState::running);
}

TEST(Supervisor, ACorruptStoreLastsUntilTheRestart) {
  Rig rig = plain_rig();
  reported(Fault::store_corrupt)(rig);
  rig.run(0.2);
  rig.tamper_inputs = nullptr;
  rig.run(0.2);
  clear(rig);
  EXPECT_TRUE(rig.out.blocks.has(Fault::store_corrupt));
}

Settings<double> safe_settings(SafeState state) {
  Settings<double> s = test_settings();
  s.safe = {state, 0.5, 0.02};
  return s;
}

TEST(SafeState, HoldsTheStrainForItsTimeOnly) {
  Rig rig = running_rig(safe_settings(SafeState::hold));
  rig.command.setpoint -= 0.003;
  rig.run(0.3);
  rig.command.fresh = false;
  while (rig.step().state == DeviceState::running) {
  }
  ASSERT_EQ(rig.out.state, DeviceState::stopping);
  const double held = rig.wire->strain();
  rig.command.setpoint = 0.035;  // a set-point that does not count any more
  for (int i = 0; i < 480; ++i) {
    EXPECT_GT(rig.step().drive_current_A, 0);
    EXPECT_NEAR(rig.wire->strain(), held, 0.001);
  }
  rig.run(0.03);
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  EXPECT_EQ(rig.out.drive_current_A, 0);
}

TEST(SafeState, ReleasesNoFasterThanSet) {
  Rig rig = running_rig(safe_settings(SafeState::release));
  rig.command.fresh = false;
  while (rig.step().state == DeviceState::running) {
  }
  const double from = rig.wire->strain();
  for (int i = 1; i <= 300; ++i) {
    ASSERT_EQ(rig.step().state, DeviceState::stopping);
    EXPECT_LE(rig.wire->strain() - from, 0.02 * i * Rig::dt_s + 0.001);
  }
  EXPECT_GT(rig.wire->strain() - from, 0.004);
  rig.run(10);
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  EXPECT_EQ(rig.out.drive_current_A, 0);
}

TEST(SafeState, AFaultOfTheHeatEndsIt) {
  for (const SafeState state : {SafeState::hold, SafeState::release}) {
    Rig rig = running_rig(safe_settings(state));
    rig.command.fresh = false;
    rig.run(0.15);
    ASSERT_EQ(rig.out.state, DeviceState::stopping);
    rig.tamper_inputs = [](Readings& in) { in.emergency_stop = true; };
    EXPECT_EQ(rig.step().drive_current_A, 0);
    EXPECT_EQ(rig.out.state, DeviceState::fault);
  }
}

TEST(SafeState, NothingIsHeldByAnEstimateThatIsNone) {
  Rig rig = running_rig(safe_settings(SafeState::hold));
  rig.tamper_estimate = [](Estimate<double>& e) { e.strain = not_a_number; };
  EXPECT_EQ(rig.step().drive_current_A, 0);
  EXPECT_EQ(rig.out.state, DeviceState::fault);
  rig.tamper_estimate = nullptr;
  rig.run(0.1);
  clear(rig);
  rig.command.arm = false;
  rig.run(0.2);
  EXPECT_EQ(rig.out.state, DeviceState::ready);
  EXPECT_TRUE(std::isfinite(rig.out.estimate.strain));
}

/// The same readings come again and again, though with new sequence numbers.
TEST(Supervisor, FindsReadingsThatDoNotFollowTheCurrent) {
  Rig rig = running_rig();
  const Readings old = rig.inputs;
  rig.tamper_inputs = [&](Readings& in) { in.sample = old.sample; };
  rig.command.setpoint -= 0.01;
  rig.run(0.05);
  EXPECT_EQ(rig.out.drive_current_A, 0);
  EXPECT_TRUE(rig.out.latched.has(Fault::sample_frozen) ||
              rig.out.latched.has(Fault::current_control));
}

/// The same log gives the same outputs, after whatever other devices have done.
TEST(Supervisor, DependsOnItsInputsOnly) {
  const auto outputs = [] {
    std::vector<double> all;
    Rig rig = running_rig();
    rig.supply_V = 3;
    rig.run(0.1);
    rig.supply_V = 24;
    clear(rig);
    all.push_back(rig.out.estimate.strain);
    all.push_back(rig.out.measurement.resistance_ohm);
    all.push_back(static_cast<double>(rig.out.latched.bits()));
    all.push_back(rig.hottest_K);
    return all;
  };
  const auto first = outputs();
  Rig other = running_rig();
  other.tamper_inputs = [](Readings& in) { in.emergency_stop = true; };
  other.run(0.2);
  EXPECT_EQ(outputs(), first);
}

}  // namespace
}  // namespace smaservo::supervisor_test
