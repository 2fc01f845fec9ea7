#include "firmware/canopen/node/node.hpp"

#include <algorithm>
#include <array>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
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
  EXPECT_EQ(rig.output.drive_current_A, 0);
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
    // When the watched node returns, only the error register changes, not the state.
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

/// A frame whose length may be wrong, and the code that tells it.
struct Lengths {
  std::uint32_t id;
  std::size_t right, wrong;
  std::uint16_t code;
};

/// Conditions of the bus that begin and end at random, seen by somebody who only listens.
void begin_and_end(unsigned seed) {
  constexpr std::array<Lengths, 3> frames{
      {{0x201, 3, 2, 0x8210}, {0x301, 8, 7, 0x8210}, {0x80, 0, 1, 0x8240}}};
  std::mt19937 random(seed);
  ServoRig rig;
  ASSERT_EQ(rig.get({0x1015, 0}), 100U) << "10 ms";
  rig.set({0x1029, 1}, 1, 1);
  rig.nmt(1);
  rig.run(20);
  rig.sent.clear();
  std::array<bool, frames.size()> wrong{};
  for (int i = 0; i < 300; ++i) {
    const std::size_t which = random() % frames.size();
    const Lengths& sent = frames[which];
    const bool is_wrong = random() % 2 == 0;
    rig.send(sent.id, Bytes(is_wrong ? sent.wrong : sent.right));
    rig.run(25);
    const auto told = rig.take(emergency);
    const bool has_changed = std::exchange(wrong[which], is_wrong) != is_wrong;
    ASSERT_EQ(told.size(), has_changed ? 1U : 0U) << i;
    const unsigned errors = rig.servo.node().objects().error_register;
    ASSERT_EQ(errors, std::ranges::count(wrong, true) > 0 ? 0x11U : 0U);
    if (has_changed) {
      ASSERT_EQ(told[0].data[2], errors);
      ASSERT_EQ(emergency_code(told[0]), is_wrong ? sent.code : 0);
    }
  }
}

TEST(Emergency, BeginsOnceEndsOnceAndTellsTheRegister) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    begin_and_end(seed);
  }
}

TEST(Emergency, ThatOfAFloodIsSentOnce) {
  ServoRig rig;
  rig.nmt(1);
  rig.run(20);
  rig.sent.clear();
  for (int i = 0; i < 1000; ++i) {
    rig.send(0x201, Bytes(i % 2 == 0 ? 1 : 2));
    rig.send(0x80, {1});
    rig.step();
  }
  rig.run(20);
  EXPECT_THAT(rig.take(emergency), SizeIs(2));
  EXPECT_EQ(rig.get({0x1003, 0}), 2U);
  rig.nmt(128);
  rig.run(20);
  const auto ended = rig.take(emergency);
  ASSERT_THAT(ended, SizeIs(1)) << "in PRE-OPERATIONAL no length is wrong";
  EXPECT_EQ(ended[0], frame(emergency, Bytes(8)));
}

TEST(Emergency, TheListHoldsEightAndTheInhibitTimeIsKept) {
  ServoRig rig;
  rig.nmt(1);
  rig.run(3);
  rig.sent.clear();
  for (int i = 0; i < 20; ++i) {
    rig.send(0x201, {6});
    rig.send(0x201, {6, 0, 1});
  }
  rig.run(35);
  EXPECT_THAT(rig.take(emergency), SizeIs(4)) << "one each 10 ms";
  EXPECT_EQ(rig.get({0x1003, 0}), 8U);
  rig.run(100);
  const auto rest = rig.take(emergency);
  ASSERT_FALSE(rest.empty());
  EXPECT_EQ(rest.back(), frame(emergency, Bytes(8))) << "the end is told, whatever is left out";
}

/// The list of errors is full of mild and severe ones: the severe ones stay in their order, as far
/// as there is room.
TEST(Emergency, WhatIsMildPushesNothingSevereOut) {
  std::mt19937 random(7);
  ServoRig rig;
  rig.set({0x1016, 1}, 0x0010'0064, 4);
  rig.set({0x1029, 1}, 1, 1);
  rig.nmt(1);
  std::deque<unsigned> severe;
  for (int i = 0; i < 200; ++i) {
    if (random() % 8 == 0) {
      rig.send(0x710, {5});
      rig.run(101);
      severe.push_front(0x8130);
    } else {
      rig.send(0x201, Bytes(2));
      rig.send(0x201, Bytes(3));
      rig.run(1);
    }
    severe.resize(std::min<std::size_t>(severe.size(), 8));
    const auto& objects = rig.servo.node().objects();
    std::deque<unsigned> kept;
    for (std::size_t k = 0; k < objects.error_count; ++k) {
      if ((objects.errors[k] & 0xFFFFU) == 0x8130) {
        kept.push_back(0x8130);
      }
    }
    ASSERT_EQ(kept, severe) << i;
  }
  EXPECT_EQ(severe.size(), 8U);
}

/// If nobody commands and 6007h is 2, the axis goes to Switch on disabled, which is no fault.
TEST(Emergency, ThatOfASilentSourceEndsWhenItCommandsAgain) {
  ServoRig rig;
  rig.set({0x6007, 0}, 2, 2);
  rig.enable();
  rig.sent.clear();
  rig.run(5100);
  const auto gone = rig.take(emergency);
  ASSERT_THAT(gone, SizeIs(1));
  EXPECT_EQ(emergency_code(gone[0]), heartbeat_lost);
  EXPECT_EQ(gone[0].data[2], 0x11);
  EXPECT_EQ(rig.get({0x1001, 0}), 0x11U);
  rig.control(0);
  rig.run(20);
  const auto back = rig.take(emergency);
  ASSERT_THAT(back, SizeIs(1));
  EXPECT_EQ(back[0], frame(emergency, Bytes(8)));
  EXPECT_EQ(rig.get({0x1001, 0}), 0U);
}

/// A node that is no longer watched is no longer reported as lost.
TEST(Emergency, EndsWithTheWatch) {
  ServoRig rig;
  rig.set({0x1029, 1}, 1, 1);
  rig.set({0x1016, 1}, 0x0010'0064, 4);
  rig.set({0x1400, 5}, 0, 2);
  rig.nmt(1);
  rig.send(0x710, {5});
  rig.run(150);
  EXPECT_EQ(rig.get({0x1001, 0}), 0x11U);
  rig.set({0x1016, 1}, 0, 4);
  EXPECT_EQ(rig.get({0x1001, 0}), 0U);
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
