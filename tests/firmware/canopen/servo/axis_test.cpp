#include "firmware/canopen/servo/axis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::axis_test {
namespace {

using enum DriveState;

constexpr std::uint16_t shutdown = 0x06, switch_on = 0x07, operate = 0x0F, disable_voltage = 0,
                        quick = 0x02, fault_reset = 0x80, new_setpoint = 0x10, at_once = 0x20,
                        relative = 0x40, halt = 0x100;

/// The statusword's bits that tell the state, by CiA 402's table.
bool shows(std::uint16_t word, DriveState state) {
  switch (state) {
    case not_ready:
      return (word & 0x4F) == 0x00;
    case disabled:
      return (word & 0x4F) == 0x40;
    case ready:
      return (word & 0x6F) == 0x21;
    case on:
      return (word & 0x6F) == 0x23;
    case enabled:
      return (word & 0x6F) == 0x27;
    case quick_stop:
      return (word & 0x6F) == 0x07;
    case reacting:
      return (word & 0x4F) == 0x0F;
    case fault:
      return (word & 0x4F) == 0x08;
  }
  return false;
}

class Drive : public ServoRig {
 public:
  using ServoRig::ServoRig;
  void word(std::uint16_t value, int ms = 5) {
    ASSERT_EQ(control(value), Abort::none);
    run(ms);
    EXPECT_TRUE(shows(status(), state())) << std::hex << status();
  }
  void go_to(DriveState wanted) {
    run(150);
    set({0x6060, 0}, 1, 1);
    if (wanted != disabled) {
      word(shutdown);
    }
    if (wanted == on || wanted == enabled || wanted == quick_stop) {
      word(switch_on);
    }
    if (wanted == enabled || wanted == quick_stop) {
      word(operate, 100);
    }
    if (wanted == quick_stop) {
      word(quick);
    }
    ASSERT_EQ(state(), wanted);
  }
  bool heated() const { return output.drive_current_A != 0; }
};

struct Transition {
  DriveState from;
  std::uint16_t word;
  DriveState to;
};

/// Each of CiA 402's commands in each state that it can be given in; what is no transition changes
/// nothing.
TEST(Axis, EveryTransitionAndNoOther) {
  const auto table = std::to_array<Transition>({
      {disabled, shutdown, ready},
      {disabled, switch_on, disabled},
      {disabled, operate, disabled},
      {disabled, disable_voltage, disabled},
      {disabled, quick, disabled},
      {disabled, fault_reset, disabled},
      {disabled, shutdown | fault_reset, disabled},
      {ready, switch_on, on},
      {ready, disable_voltage, disabled},
      {ready, quick, disabled},
      {ready, shutdown, ready},
      {ready, operate, enabled},
      {on, operate, enabled},
      {on, shutdown, ready},
      {on, disable_voltage, disabled},
      {on, quick, disabled},
      {on, switch_on, on},
      {enabled, switch_on, on},
      {enabled, shutdown, ready},
      {enabled, disable_voltage, disabled},
      {enabled, quick, quick_stop},
      {enabled, operate, enabled},
      {quick_stop, operate, enabled},
      {quick_stop, disable_voltage, disabled},
      {quick_stop, shutdown, quick_stop},
      {quick_stop, switch_on, quick_stop},
      {quick_stop, quick, quick_stop},
  });
  for (const Transition& t : table) {
    Drive drive;
    drive.set({0x605A, 0}, 6, 2);
    drive.go_to(t.from);
    drive.word(t.word, 100);
    EXPECT_EQ(drive.state(), t.to) << static_cast<int>(t.from) << " by " << std::hex << t.word;
    EXPECT_EQ(drive.heated(), t.to == enabled || t.to == quick_stop);
  }
}

TEST(Axis, NoStateIsJumpedOver) {
  Drive drive;
  drive.go_to(ready);
  drive.control(operate);
  drive.sent.clear();
  std::vector<DriveState> seen;
  for (int i = 0; i < 5; ++i) {
    drive.step();
    if (seen.empty() || seen.back() != drive.state()) {
      seen.push_back(drive.state());
    }
  }
  EXPECT_THAT(seen, testing::ElementsAre(on, enabled));
}

TEST(Axis, QuickStopTurnsTheHeatOffByDefault) {
  Drive drive;
  drive.go_to(enabled);
  drive.word(quick);
  EXPECT_EQ(drive.state(), disabled);
  EXPECT_FALSE(drive.heated());
}

TEST(Axis, OptionCodesAreWhatIsSupported) {
  Drive drive;
  EXPECT_EQ(drive.set({0x605A, 0}, 2, 2), Abort::value);
  EXPECT_EQ(drive.set({0x605A, 0}, 7, 2), Abort::too_high);
  EXPECT_EQ(drive.set({0x605B, 0}, 1, 2), Abort::too_high);
  EXPECT_EQ(drive.set({0x605C, 0}, 1, 2), Abort::too_high);
  EXPECT_EQ(drive.set({0x605D, 0}, 2, 2), Abort::too_high);
  EXPECT_EQ(drive.set({0x605E, 0}, 1, 2), Abort::value);
  EXPECT_EQ(drive.set({0x605E, 0}, 0xFFFF, 2), Abort::too_low);
  EXPECT_EQ(drive.set({0x6007, 0}, 4, 2), Abort::too_high);
  EXPECT_EQ(drive.set({0x6098, 0}, 36, 1), Abort::value);
}

TEST(Axis, AFaultIsResetByARisingEdgeOnly) {
  Drive drive;
  drive.go_to(enabled);
  drive.device.faults = Fault::wire_short;
  drive.run(3);
  EXPECT_EQ(drive.state(), fault);
  EXPECT_FALSE(drive.heated());
  EXPECT_EQ(drive.get({0x603F, 0}),
            fault_rows[static_cast<std::size_t>(Fault::wire_short) - 1].code);
  drive.word(operate, 20);
  EXPECT_EQ(drive.state(), fault);
  drive.word(fault_reset, 20);
  EXPECT_EQ(drive.state(), fault) << "its cause is there";
  drive.device.faults = {};
  drive.run(50);
  drive.word(fault_reset, 50);
  EXPECT_EQ(drive.state(), fault) << "no edge";
  drive.word(operate);
  drive.word(fault_reset | operate, 20);
  EXPECT_EQ(drive.state(), disabled);
  drive.word(operate, 100);
  EXPECT_EQ(drive.state(), disabled) << "and not enabled by what was left over";
  EXPECT_FALSE(drive.heated());
  EXPECT_EQ(drive.get({0x603F, 0}), 0U);
}

/// 605Eh = 2: the device's safe state holds, but not after a fault of the heat.
TEST(Axis, TheSafeStateIsForFaultsThatLeaveTheChoice) {
  for (const bool leaves : {true, false}) {
    for (const std::int16_t option : {option_off, option_safe_state}) {
      Drive drive;
      drive.set({0x605E, 0}, static_cast<std::uint16_t>(option), 2);
      drive.device.safe = SafeState::hold;
      drive.go_to(enabled);
      drive.device.faults = leaves ? Fault::over_stress : Fault::over_temperature;
      drive.run(20);
      const bool holds = leaves && option == option_safe_state;
      EXPECT_EQ(drive.heated(), holds);
      EXPECT_EQ(drive.state(), holds ? reacting : fault);
      drive.run(200);
      EXPECT_FALSE(drive.heated());
      EXPECT_EQ(drive.state(), fault);
    }
  }
}

TEST(Axis, ADeviceThatDoesNotArmIsAFault) {
  Drive drive;
  drive.device.arms = false;
  drive.run(150);
  drive.word(shutdown);
  drive.word(switch_on);
  drive.control(operate);
  drive.run(150);
  EXPECT_EQ(drive.state(), fault);
  EXPECT_EQ(drive.get({0x603F, 0}), 0xFF50U);
  drive.device.arms = true;
  drive.word(0);
  drive.word(fault_reset);
  EXPECT_EQ(drive.state(), disabled);
}

TEST(Axis, WhatBlocksArmingKeepsItSwitchedOn) {
  Drive drive;
  drive.go_to(on);
  drive.device.faults = Fault::unclean_boot;
  drive.run(5);
  drive.word(operate, 50);
  EXPECT_EQ(drive.state(), on);
  drive.device.faults = {};
  drive.run(50);
  EXPECT_EQ(drive.state(), enabled);
}

TEST(Axis, WhatBlocksArmingIsAcknowledgedByAFaultReset) {
  Drive drive;
  drive.go_to(disabled);
  const auto clears = [&](std::uint16_t word) {
    EXPECT_EQ(drive.control(word), Abort::none);
    bool any = false;
    for (int i = 0; i < 10; ++i) {
      drive.step();
      any = any || drive.command.clear_faults;
    }
    EXPECT_FALSE(drive.command.clear_faults) << "not for ever";
    return any;
  };
  EXPECT_FALSE(clears(fault_reset)) << "nothing to acknowledge";
  drive.device.faults = Fault::unclean_boot;
  drive.run(5);
  EXPECT_FALSE(clears(fault_reset)) << "no edge";
  EXPECT_FALSE(clears(0));
  EXPECT_TRUE(clears(fault_reset));
  EXPECT_EQ(drive.state(), disabled);
}

// Profile position.

constexpr unsigned acknowledged = 0x1000, reached = 0x400;

TEST(ProfilePosition, ASetPointIsTakenAcknowledgedAndReached) {
  Drive drive;
  drive.go_to(enabled);
  drive.set({0x607A, 0}, 500, 4);
  drive.run(100);
  EXPECT_EQ(drive.get({0x6064, 0}), 0U) << "not before the edge";
  drive.word(operate | new_setpoint, 3);
  EXPECT_EQ(drive.status() & acknowledged, acknowledged);
  drive.run(100);
  EXPECT_EQ(drive.get({0x6064, 0}), 500U);
  EXPECT_EQ(drive.status() & reached, reached);
  drive.word(operate, 3);
  EXPECT_EQ(drive.status() & acknowledged, 0U);
  drive.word(operate | new_setpoint | relative, 100);
  EXPECT_EQ(drive.get({0x6064, 0}), 1000U);
  EXPECT_NEAR(drive.command.setpoint, 1e-3, 1e-9);
  EXPECT_EQ(drive.command.mode, Mode::position);
}

TEST(ProfilePosition, OneSetPointWaitsAndAThirdIsRefused) {
  Drive drive;
  drive.set({0x6081, 0}, 10'000, 4);
  drive.go_to(enabled);
  const auto send = [&](std::uint32_t target, unsigned bits = 0) {
    drive.set({0x607A, 0}, target, 4);
    drive.word(static_cast<std::uint16_t>(operate | new_setpoint | bits), 3);
    const bool taken = (drive.status() & acknowledged) != 0;
    drive.word(operate, 3);
    return taken;
  };
  EXPECT_TRUE(send(2000));
  EXPECT_TRUE(send(500));
  EXPECT_EQ(drive.status() & acknowledged, acknowledged) << "no room";
  send(1);
  drive.run(230);
  EXPECT_NEAR(static_cast<double>(drive.get({0x6064, 0})), 2000, 100);
  drive.run(400);
  EXPECT_EQ(drive.get({0x6064, 0}), 500U) << "the one that waited, not the refused one";
  EXPECT_TRUE(send(3000));
  EXPECT_TRUE(send(100, at_once));
  drive.run(400);
  EXPECT_EQ(drive.get({0x6064, 0}), 100U);
}

/// Set-points that wait begin when the demand has gone all the way of the one before, whatever the
/// windows and velocities are.
TEST(ProfilePosition, NoSetPointIsCutShort) {
  std::mt19937 random(3);
  for (int i = 0; i < 10; ++i) {
    Drive drive;
    drive.set({0x6081, 0}, 200 + random() % 5000, 4);
    drive.set({0x6067, 0}, random() % 300, 4);
    drive.set({0x6068, 0}, random() % 60, 2);
    drive.go_to(enabled);
    const auto far = static_cast<std::uint32_t>(400 + random() % 1000);
    const auto near = static_cast<std::uint32_t>(random() % 100);
    for (const std::uint32_t target : {far, near}) {
      drive.set({0x607A, 0}, target, 4);
      drive.word(operate | new_setpoint, 3);
      drive.word(operate, 3);
    }
    std::int32_t furthest = 0;
    const auto is_done = [&] {
      return drive.servo.axis().moves_to() == static_cast<std::int32_t>(near) &&
             (drive.status() & reached) != 0;
    };
    for (int ms = 0; ms < 20'000 && !is_done(); ++ms) {
      if (ms % 1000 == 0) {
        drive.control(operate);
      }
      drive.step();
      const DriveObjects& shown = drive.servo.objects();
      furthest = std::max(furthest, shown.demand);
      EXPECT_TRUE((shown.statusword & reached) == 0 ||
                  shown.demand == static_cast<std::int32_t>(shown.demand >= 400 ? far : near));
    }
    EXPECT_TRUE(is_done());
    EXPECT_EQ(furthest, static_cast<std::int32_t>(far));
    EXPECT_EQ(drive.get({0x6064, 0}), near);
  }
}

TEST(ProfilePosition, KeepsItsVelocity) {
  Drive drive;
  drive.set({0x6081, 0}, 5000, 4);
  drive.go_to(enabled);
  drive.set({0x607A, 0}, 2000, 4);
  drive.word(operate | new_setpoint, 1);
  drive.run(200);
  EXPECT_NEAR(static_cast<double>(drive.get({0x6064, 0})), 1000, 60);
  EXPECT_NEAR(static_cast<double>(drive.get({0x606C, 0})), 5000, 200);
}

TEST(ProfilePosition, HaltHoldsAndGoesOn) {
  Drive drive;
  drive.set({0x6081, 0}, 5000, 4);
  drive.go_to(enabled);
  drive.set({0x607A, 0}, 2000, 4);
  drive.word(operate | new_setpoint, 100);
  drive.word(operate | halt, 10);
  const auto held = drive.get({0x6064, 0});
  drive.run(100);
  EXPECT_EQ(drive.get({0x6064, 0}), held);
  EXPECT_TRUE(drive.heated());
  drive.word(operate, 500);
  EXPECT_EQ(drive.get({0x6064, 0}), 2000U);
  drive.set({0x605D, 0}, 0, 2);
  drive.word(operate | halt, 10);
  EXPECT_EQ(drive.output.mode, Mode::off) << "heating off";
}

TEST(ProfilePosition, LimitsHoldAndAFollowingErrorIsAFault) {
  Drive drive;
  drive.set({0x607D, 2}, 800, 4);
  drive.set({0x6066, 0}, 50, 2);
  drive.go_to(enabled);
  drive.set({0x607A, 0}, 2000, 4);
  drive.word(operate | new_setpoint, 100);
  EXPECT_EQ(drive.get({0x6064, 0}), 800U);
  drive.word(operate);
  drive.device.moves = false;
  drive.set({0x6065, 0}, 300, 4);
  drive.set({0x607A, 0}, 0, 4);
  drive.word(operate | new_setpoint, 20);
  EXPECT_EQ(drive.state(), enabled);
  drive.run(60);
  EXPECT_EQ(drive.state(), fault);
  EXPECT_EQ(drive.get({0x603F, 0}), 0x8611U);
  EXPECT_FALSE(drive.heated());
}

/// Whatever 607Dh says and whatever is asked for: the demand stays within 607Dh and the wire's
/// reach, and bit 11 says when it is not what was asked for.
TEST(ProfilePosition, TargetsBeyondLimitsOrReachAreLimitedVisibly) {
  constexpr unsigned limited = 0x800;
  std::mt19937 random(5);
  const Settings<double> settings = reference_settings();
  const double length_um = 1e6 * settings.wire.geometry.length_m;
  const auto strain = settings.axis.zero_strain;
  const auto reach_low =
      static_cast<std::int32_t>(std::lround((strain - settings.limits.max_strain) * length_um));
  const auto reach_high =
      static_cast<std::int32_t>(std::lround((strain - settings.limits.min_strain) * length_um));
  ASSERT_LT(reach_low, reach_high);
  for (const std::int8_t mode : {std::int8_t{1}, std::int8_t{8}}) {
    Drive drive;
    drive.enable(mode);
    std::array<std::int32_t, 2> limit{INT32_MIN, INT32_MAX};
    for (int i = 0; i < 200; ++i) {
      const std::size_t which = random() % 2;
      const auto bound = static_cast<std::int32_t>(random() % 6000) - 1000;
      if (i > 20) {
        const std::array<std::int32_t, 2> before = limit;
        limit[which] = bound;
        const bool is_good = limit[0] <= limit[1];
        ASSERT_EQ(drive.set({0x607D, static_cast<std::uint8_t>(which + 1)}, as_bits(bound), 4),
                  is_good ? Abort::none : Abort::max_below_min);
        limit = is_good ? limit : before;
      }
      const std::int32_t target =
          i % 10 == 0 ? 100'000 : static_cast<std::int32_t>(random() % 8000) - 2000;
      drive.set({0x607A, 0}, as_bits(target), 4);
      drive.control(operate);
      drive.control(operate | new_setpoint | at_once);
      drive.run(3);
      const std::int32_t allowed = std::min(std::max(target, limit[0]), limit[1]);
      const std::int32_t expected = std::min(std::max(allowed, reach_low), reach_high);
      ASSERT_EQ(drive.servo.axis().moves_to(), expected) << target;
      ASSERT_EQ(drive.status() & limited, expected != target ? limited : 0U) << target;
    }
    EXPECT_EQ(drive.state(), enabled);
  }
}

TEST(CyclicPosition, FollowsWhatIsSent) {
  Drive drive;
  drive.nmt(1);
  drive.run(150);
  drive.set({0x6060, 0}, 8, 1);
  for (const std::uint8_t word : Bytes{6, 7, 15}) {
    drive.send(0x201, {word, 0, 8});
    drive.run(50);
  }
  for (std::int32_t target = 0; target < 1000; target += 10) {
    Bytes data = little(static_cast<std::uint32_t>(target), 4);
    data.resize(8);
    drive.send(0x301, data);
    drive.run(2);
    EXPECT_NEAR(static_cast<double>(drive.get({0x6064, 0})), target, 1);
  }
  EXPECT_EQ(drive.status() & 0x1000U, 0x1000U);
}

/// Straight lines between the set-points, whatever their period; with 1 ms each is followed at
/// once.
TEST(CyclicPosition, IsInterpolatedOver60C2h) {
  std::mt19937 random(11);
  for (const unsigned period_ms : {1U, 2U, 20U, 100U}) {
    Drive drive;
    ASSERT_EQ(drive.set({0x60C2, 1}, period_ms, 1), Abort::none);
    drive.nmt(1);
    drive.enable(8);
    double before_um = 0;
    for (int i = 0; i < 50; ++i) {
      const auto target = static_cast<std::uint32_t>(random() % 3000);
      Bytes data = little(target, 4);
      data.resize(8);
      drive.send(0x301, data);
      for (unsigned ms = 1; ms <= period_ms; ++ms) {
        drive.step();
        const double expected = before_um + (target - before_um) * ms / period_ms;
        ASSERT_NEAR(drive.servo.objects().demand, expected, 1.5) << period_ms << ' ' << ms;
      }
      before_um = target;
    }
  }
}

// Each one that the axis follows at once, also one that is as the one before.
TEST(CyclicPosition, ItsSetpointsAreCounted) {
  Drive drive;
  drive.enable(8);
  drive.nmt(1);
  const std::uint32_t before = drive.servo.setpoints();
  for (int i = 0; i < 3; ++i) {
    drive.send(0x301, {1, 0, 0, 0, 0, 0, 0, 0});
  }
  EXPECT_EQ(drive.servo.setpoints() - before, 3U);
  drive.set_real({0x2201, 1}, 0.1F);
  EXPECT_EQ(drive.servo.setpoints() - before, 3U) << "of another mode";
  drive.set({0x6060, 0}, 0xFF, 1);
  drive.step();
  drive.set_real({0x2201, 1}, 0.1F);
  drive.set({0x607A, 0}, 5, 4);
  EXPECT_EQ(drive.servo.setpoints() - before, 4U);
  drive.set({0x6060, 0}, 1, 1);
  drive.step();
  drive.set({0x607A, 0}, 6, 4);
  EXPECT_EQ(drive.servo.setpoints() - before, 4U) << "a profile has its own";
}

TEST(Homing, ThePresentPositionBecomesTheHome) {
  Drive drive;
  drive.go_to(enabled);
  drive.set({0x607A, 0}, 500, 4);
  drive.word(operate | new_setpoint, 100);
  drive.set({0x607C, 0}, 50, 4);
  drive.word(operate);
  drive.set({0x6060, 0}, 6, 1);
  drive.run(5);
  EXPECT_EQ(drive.status() & 0x1000U, 0U);
  drive.word(operate | new_setpoint, 5);
  EXPECT_EQ(drive.status() & 0x3400U, 0x1400U) << "attained, reached, no error";
  EXPECT_EQ(drive.get({0x6064, 0}), 50U);
  EXPECT_NEAR(drive.command.setpoint, 500e-6, 1e-9) << "the wire does not move";
}

TEST(Modes, ThoseOfForceNeedTheSensor) {
  Settings<double> settings = reference_settings();
  for (const bool has : {true, false}) {
    settings.measurement.has_load_cell = has;
    Drive drive({}, settings);
    EXPECT_EQ(drive.set({0x6060, 0}, 4, 1), has ? Abort::none : Abort::value);
    EXPECT_EQ(drive.set({0x6060, 0}, 10, 1), has ? Abort::none : Abort::value);
    EXPECT_EQ(drive.get({0x6502, 0}) & 0x3FFU, has ? 0x2A9U : 0x0A1U);
  }
}

TEST(Modes, TheManufacturersSetHeatDirectly) {
  const auto table = std::to_array<std::pair<std::int8_t, Mode>>({{-1, Mode::current},
                                                                  {-2, Mode::power},
                                                                  {-3, Mode::temperature},
                                                                  {-4, Mode::identification}});
  for (const auto& [number, mode] : table) {
    Drive drive;
    drive.enable(number);
    EXPECT_EQ(drive.command.mode, mode);
    if (mode != Mode::identification) {
      drive.set_real({0x2201, static_cast<std::uint8_t>(-number)}, 0.25F);
      drive.run(2);
      EXPECT_EQ(drive.command.setpoint, 0.25);
    }
  }
  Drive drive;
  drive.enable(10);
  drive.set({0x6076, 0}, 2000, 4);
  drive.set({0x6071, 0}, 500, 2);
  drive.run(2);
  EXPECT_EQ(drive.command.mode, Mode::force);
  EXPECT_NEAR(drive.command.setpoint, 1.0, 1e-6);
}

// The command source.

TEST(CommandSource, WhoCommandsNothingForFiveSecondsHasGone) {
  Drive drive;
  drive.go_to(enabled);
  drive.run(4850);
  EXPECT_TRUE(drive.command.fresh);
  drive.run(200);
  EXPECT_FALSE(drive.command.fresh);
  EXPECT_EQ(drive.state(), fault);
  EXPECT_FALSE(drive.heated());
  const auto told = drive.take(0x81);
  EXPECT_EQ(std::ranges::count(told, heartbeat_lost, emergency_code), 1);
}

/// A bystander that reads, tunes, starts the node, sends SYNC and other nodes' heartbeats does not
/// keep the heat on; whoever writes what commands does, even if the value stays.
TEST(CommandSource, IsWhoCommandsNotWhoTalks) {
  const auto held = [](const auto& talk) {
    Drive drive;
    drive.nmt(1);
    drive.go_to(enabled);
    for (int ms = 0; ms < 20'000 && drive.command.fresh; ms += 500) {
      talk(drive);
      drive.run(500);
    }
    return drive.command.fresh && drive.heated();
  };
  EXPECT_FALSE(held([](Drive& d) { d.upload({0x1000, 0}); }));
  EXPECT_FALSE(held([](Drive& d) { d.set_real({0x2100, 1}, 1); }));
  EXPECT_FALSE(held([](Drive& d) { d.nmt(1); }));
  EXPECT_FALSE(held([](Drive& d) { d.sync(); }));
  EXPECT_FALSE(held([](Drive& d) { d.send(0x742, {5}); }));
  EXPECT_TRUE(held([](Drive& d) { d.control(operate); }));
  EXPECT_TRUE(held([](Drive& d) { d.set({0x607A, 0}, 0, 4); }));
  EXPECT_TRUE(held([](Drive& d) { d.send(0x301, Bytes(8)); }));
}

TEST(CommandSource, ThatSendsCyclicallyHasOneSecond) {
  Drive drive;
  drive.nmt(1);
  drive.go_to(enabled);
  for (int i = 0; i < 50; ++i) {
    drive.send(0x301, Bytes(8));
    drive.run(20);
  }
  EXPECT_TRUE(drive.command.fresh);
  drive.run(950);
  EXPECT_TRUE(drive.command.fresh);
  drive.run(60);
  EXPECT_FALSE(drive.command.fresh);
}

/// As a PLC does that sends on events: the frames that enable the axis and give a target.
TEST(CommandSource, ThatSendsAFewFramesAtOnceIsNotCyclic) {
  Drive drive;
  drive.nmt(1);
  drive.run(150);
  for (const std::uint8_t word : Bytes{shutdown, switch_on, operate, operate}) {
    drive.send(0x201, {word, 0, 1});
    drive.run(10);
  }
  drive.run(4800);
  EXPECT_TRUE(drive.command.fresh);
}

TEST(CommandSource, NeedNotBeThereWhereTheBoardSaysSo) {
  ServoConfig config;
  config.unattended = true;
  Drive drive(config);
  drive.go_to(enabled);
  drive.run(60'000);
  EXPECT_TRUE(drive.command.fresh);
  EXPECT_TRUE(drive.heated());
}

TEST(CommandSource, HasGoneWithTheSyncThatIsWatched) {
  Drive drive;
  ASSERT_EQ(drive.set({0x1006, 0}, 10'000, 4), Abort::none);
  drive.nmt(1);
  drive.control(disable_voltage);
  drive.step();
  EXPECT_FALSE(drive.command.fresh) << "it has not come yet";
  for (int i = 0; i < 10; ++i) {
    drive.sync();
    drive.run(19);
    EXPECT_TRUE(drive.command.fresh);
  }
  drive.run(2);
  EXPECT_FALSE(drive.command.fresh);
  drive.sync();
  drive.step();
  EXPECT_TRUE(drive.command.fresh);
  drive.set({0x1006, 0}, 0, 4);
  drive.run(100);
  EXPECT_TRUE(drive.command.fresh) << "no longer watched, and it has commanded a moment ago";
}

/// What is watched, but has never come: the axis is enabled by SDO all the same, and loses its heat
/// with the code of what is missing before the device itself notices.
TEST(CommandSource, ThatNeverCameIsToldByItsCode) {
  struct Case {
    Key key;
    std::uint32_t value;
    std::uint8_t size;
    std::uint16_t code;
  };
  for (const Case& c :
       {Case{{0x1016, 1}, 0x0010'0064, 4, heartbeat_lost}, Case{{0x1400, 5}, 50, 2, 0x8250},
        Case{{0x1006, 0}, 10'000, 4, sync_lost}}) {
    Drive drive;
    drive.set({0x1400, 1}, cob_invalid | 0x201, 4);
    ASSERT_EQ(drive.set(c.key, c.value, c.size), Abort::none);
    drive.set({0x1400, 1}, 0x201, 4);
    drive.nmt(1);
    drive.enable();
    EXPECT_EQ(drive.state(), fault);
    EXPECT_EQ(drive.get({0x603F, 0}), c.code);
    EXPECT_EQ(drive.get({0x1001, 0}), 0x11U);
    const auto told = drive.take(0x81);
    EXPECT_EQ(std::ranges::count(told, c.code, emergency_code), 1);
    EXPECT_FALSE(drive.heated());
  }
}

/// A SYNC that is watched and stops is a lost command source, as a heartbeat is.
TEST(CommandSource, ThatStopsItsSyncIsToldByItsCode) {
  Drive drive;
  drive.set({0x1006, 0}, 10'000, 4);
  drive.nmt(1);
  drive.run(150);
  drive.set({0x6060, 0}, 1, 1);
  for (const std::uint16_t word : std::array<std::uint16_t, 3>{shutdown, switch_on, operate}) {
    drive.control(word);
    for (int i = 0; i < 8; ++i) {
      drive.sync();
      drive.run(10);
    }
  }
  ASSERT_TRUE(drive.heated());
  drive.take(0x81);
  drive.run(25);
  EXPECT_EQ(drive.state(), fault);
  EXPECT_EQ(drive.get({0x603F, 0}), sync_lost);
  const auto told = drive.take(0x81);
  EXPECT_EQ(std::ranges::count(told, sync_lost, emergency_code), 1);
}

/// Bit 9 is set exactly where controlwords are carried out.
TEST(Axis, RemoteIsWhereControlwordsAreCarriedOut) {
  constexpr unsigned remote = 0x200;
  for (const bool by_pdo : {false, true}) {
    for (const std::uint8_t nmt : Bytes{128, 1, 2}) {
      Drive drive;
      drive.run(150);
      drive.nmt(nmt);
      drive.run(5);
      if (by_pdo) {
        drive.send(0x201, {shutdown, 0, 1});
      } else {
        drive.send(0x601, {0x2B, 0x40, 0x60, 0, shutdown, 0, 0, 0});
      }
      drive.run(5);
      const bool carried_out = drive.state() == ready;
      const bool served = nmt == 1 || (nmt == 128 && !by_pdo);
      EXPECT_EQ(carried_out, served) << int{nmt} << by_pdo;
      EXPECT_EQ(drive.status() & remote, nmt == 2 ? 0U : remote) << int{nmt};
    }
  }
}

TEST(CommandSource, TheReactionIsThatOf6007h) {
  struct Case {
    std::uint16_t option;
    DriveState state;
    bool fresh;
  };
  for (const Case& c : {Case{0, enabled, false}, Case{1, fault, false}, Case{2, disabled, false},
                        Case{3, disabled, false}}) {
    Drive drive;
    drive.set({0x1029, 1}, 1, 1);
    drive.set({0x6007, 0}, c.option, 2);
    drive.set({0x1016, 1}, 0x0010'0190, 4);
    drive.send(0x710, {5});
    drive.nmt(1);
    drive.go_to(enabled);
    drive.run(500);
    EXPECT_EQ(drive.state(), c.state) << c.option;
    EXPECT_EQ(drive.command.fresh, c.fresh) << c.option;
    // Of its own the device goes on for timing.command_timeout_s, which the rig's does not know.
    EXPECT_EQ(drive.heated(), c.option == 0);
  }
}

TEST(CommandSource, StoppingTheNodeOrResettingItEndsTheHeat) {
  for (const std::uint8_t what : Bytes{2, 129, 130}) {
    Drive drive;
    drive.nmt(1);
    drive.go_to(enabled);
    ASSERT_TRUE(drive.heated());
    drive.answers = false;
    drive.nmt(what);
    drive.run(3);
    EXPECT_FALSE(drive.heated()) << int{what};
  }
}

}  // namespace
}  // namespace smaservo::canopen::axis_test
