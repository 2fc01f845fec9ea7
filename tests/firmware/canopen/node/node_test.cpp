#include "firmware/canopen/node/node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <utility>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::node_test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr std::uint32_t heartbeat = 0x701, emergency = 0x81;

TEST(Nmt, BootsUpOnceWithEveryReset) {
  ServoRig rig;
  rig.run(10);
  const auto boot = rig.take(heartbeat);
  ASSERT_THAT(boot, SizeIs(1));
  EXPECT_EQ(boot[0], frame(heartbeat, {0}));
  for (const std::uint8_t reset : Bytes{129, 130}) {
    rig.nmt(reset);
    rig.run(10);
    EXPECT_THAT(rig.take(heartbeat), SizeIs(1));
    EXPECT_EQ(rig.servo.node().state(), Nmt::pre_operational);
  }
  EXPECT_THAT(rig.requests, ElementsAre(Request::reset_node, Request::reset_communication));
}

TEST(Nmt, ObeysItsOwnAndEverybodysCommands) {
  ServoRig rig;
  const auto state = [&] { return rig.servo.node().state(); };
  rig.nmt(1);
  EXPECT_EQ(state(), Nmt::operational);
  rig.nmt(2, 0);
  EXPECT_EQ(state(), Nmt::stopped);
  rig.nmt(128);
  EXPECT_EQ(state(), Nmt::pre_operational);
  rig.nmt(1, 2);
  EXPECT_EQ(state(), Nmt::pre_operational) << "for another node";
  rig.send(0, {1});
  rig.send(0, {1, 1, 0});
  EXPECT_EQ(state(), Nmt::pre_operational) << "wrong length";
  rig.nmt(77);
  EXPECT_EQ(state(), Nmt::pre_operational) << "no such command";
}

TEST(Nmt, StoppedKnowsHeartbeatAndNmtOnly) {
  ServoRig rig;
  rig.set({0x1017, 0}, 10, 2);
  rig.nmt(1);
  rig.run(5);
  rig.nmt(2);
  rig.sent.clear();
  rig.sync();
  rig.send(0x601, {0x40, 0, 0x10, 0, 0, 0, 0, 0});
  rig.send(0x201, {6, 0, 1});
  rig.run(100);
  EXPECT_THAT(rig.take(heartbeat), SizeIs(testing::Ge(9U)));
  EXPECT_TRUE(rig.sent.empty());
}

TEST(Nmt, ExtendedFramesAreNobodys) {
  ServoRig rig;
  hal::CanFrame f = frame(0, {1, 1});
  f.extended = true;
  rig.servo.receive(f, rig.now_us);
  EXPECT_EQ(rig.servo.node().state(), Nmt::pre_operational);
}

// Heartbeats.

TEST(Heartbeat, KeepsItsPeriodAndTellsTheState) {
  ServoRig rig;
  rig.run(5);
  rig.sent.clear();
  rig.set({0x1017, 0}, 20, 2);
  rig.run(1000);
  const auto beats = rig.take(heartbeat);
  EXPECT_THAT(beats, SizeIs(50));
  EXPECT_EQ(beats[0].data[0], 127);
  rig.nmt(1);
  rig.run(20);
  EXPECT_EQ(rig.take(heartbeat).at(0).data[0], 5);
}

TEST(Heartbeat, ALostCommandSourceIsAnEmergencyAndEndsTheHeat) {
  ServoRig rig;
  EXPECT_EQ(rig.set({0x1016, 1}, 0x0010'0064, 4), Abort::none);
  rig.run(500);
  EXPECT_TRUE(rig.take(emergency).empty()) << "the monitor starts with the first heartbeat";
  EXPECT_FALSE(rig.command.fresh);
  rig.nmt(1);
  rig.send(0x710, {5});
  rig.step();
  EXPECT_TRUE(rig.command.fresh);
  for (int i = 0; i < 10; ++i) {
    rig.send(0x710, {5});
    rig.run(20);
  }
  rig.set({0x6060, 0}, 1, 1);
  for (const std::uint16_t word : std::array<std::uint16_t, 3>{6, 7, 15}) {
    rig.control(word);
    rig.run(5);
    rig.send(0x710, {5});
  }
  rig.run(60);
  ASSERT_EQ(rig.output.state, DeviceState::running);
  rig.sent.clear();
  rig.run(110);
  const auto frames = rig.take(emergency);
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(emergency_code(frames[0]), 0x8130);
  EXPECT_EQ(frames[0].data[2] & 0x11U, 0x11U);
  EXPECT_EQ(frames[0].data[3], 0x10);
  EXPECT_FALSE(rig.command.arm);
  EXPECT_EQ(rig.output.current_A, 0);
  EXPECT_EQ(rig.state(), DriveState::fault);
  EXPECT_EQ(rig.servo.node().state(), Nmt::pre_operational) << "1029h";
}

TEST(Heartbeat, TheStateAfterALossIsThatOf1029h) {
  constexpr auto table = std::to_array<std::pair<std::uint8_t, Nmt>>(
      {{0, Nmt::pre_operational}, {1, Nmt::operational}, {2, Nmt::stopped}});
  for (const auto& [behaviour, state] : table) {
    ServoRig rig;
    rig.set({0x1029, 1}, behaviour, 1);
    rig.set({0x1016, 1}, 0x0010'0064, 4);
    rig.nmt(1);
    rig.send(0x710, {5});
    rig.run(99);
    EXPECT_EQ(rig.servo.node().state(), Nmt::operational);
    rig.run(2);
    EXPECT_EQ(rig.servo.node().state(), state) << int{behaviour};
    // Its return changes nothing but the error register.
    rig.send(0x710, {5});
    rig.run(2);
    EXPECT_EQ(rig.servo.node().state(), state) << int{behaviour};
    EXPECT_EQ(rig.servo.node().objects().error_register, 0) << int{behaviour};
  }
}

TEST(Heartbeat, TwoTimesForOneNodeContradictEachOther) {
  ServoRig rig;
  EXPECT_EQ(rig.set({0x1016, 1}, 0x0010'0064, 4), Abort::none);
  EXPECT_EQ(rig.set({0x1016, 2}, 0x0010'0065, 4), Abort::incompatible);
  EXPECT_EQ(rig.set({0x1016, 2}, 0x0011'0065, 4), Abort::none);
  EXPECT_EQ(rig.set({0x1016, 3}, 0x0080'0065, 4), Abort::value);
}

TEST(Heartbeat, ASecondNodeOfTheSameIdIsSeen) {
  ServoRig rig;
  EXPECT_TRUE(rig.servo.external().empty());
  rig.send(heartbeat, {5});
  EXPECT_TRUE(rig.servo.external().has(Fault::duplicate_node));
}

// Emergencies.

TEST(Emergency, AFaultIsToldAndKeptUntilItIsCleared) {
  ServoRig rig;
  rig.enable();
  rig.sent.clear();
  rig.device.faults = Fault::over_temperature;
  rig.run(3);
  const auto frames = rig.take(emergency);
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_EQ(emergency_code(frames[0]), 0x4310);
  EXPECT_EQ(frames[0].data[2], 0x09) << "generic and temperature";
  EXPECT_EQ(rig.get({0x1001, 0}), 0x09U);
  EXPECT_EQ(rig.get({0x1003, 0}), 1U);
  EXPECT_EQ(rig.get({0x1003, 1}) & 0xFFFFU, 0x4310U);
  rig.device.faults = {};
  rig.run(3);
  rig.control(0x80);
  rig.run(10);
  const auto cleared = rig.take(emergency);
  ASSERT_THAT(cleared, SizeIs(1));
  EXPECT_EQ(emergency_code(cleared[0]), 0);
  EXPECT_EQ(rig.get({0x1001, 0}), 0U);
  EXPECT_EQ(rig.set({0x1003, 0}, 0, 1), Abort::none);
  EXPECT_EQ(rig.upload({0x1003, 1}).abort, Abort::no_data);
}

TEST(Emergency, TheListHoldsEightAndTheInhibitTimeIsKept) {
  ServoRig rig;
  rig.set({0x1015, 0}, 100, 2);
  rig.nmt(1);
  rig.run(3);
  rig.sent.clear();
  for (int i = 0; i < 20; ++i) {
    rig.send(0x201, {6});
  }
  rig.run(35);
  EXPECT_THAT(rig.take(emergency), SizeIs(4)) << "one each 10 ms";
  EXPECT_EQ(rig.get({0x1003, 0}), 8U);
}

TEST(Emergency, ItsIdentifierObeysTheRules) {
  ServoRig rig;
  EXPECT_EQ(rig.get({0x1014, 0}), 0x81U);
  EXPECT_EQ(rig.set({0x1014, 0}, 0x82, 4), Abort::state);
  EXPECT_EQ(rig.set({0x1014, 0}, 0x8000'0081, 4), Abort::none);
  rig.nmt(1);
  rig.send(0x201, {6});
  rig.run(5);
  EXPECT_TRUE(rig.take(emergency).empty()) << "not valid";
  EXPECT_EQ(rig.set({0x1014, 0}, 0x601, 4), Abort::value);
  EXPECT_EQ(rig.set({0x1014, 0}, 0x2000'0091, 4), Abort::value) << "29 bits";
  EXPECT_EQ(rig.set({0x1014, 0}, 0x4000'0091, 4), Abort::value) << "a reserved bit";
  EXPECT_EQ(rig.set({0x1014, 0}, 0x1091, 4), Abort::value) << "more than 11 bits";
  EXPECT_EQ(rig.set({0x1014, 0}, 0x91, 4), Abort::none);
}

}  // namespace
}  // namespace smaservo::canopen::node_test
