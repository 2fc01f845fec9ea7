#include "firmware/canopen/node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/canopen/servo_rig.hpp"

namespace smaservo::canopen::node_test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr std::uint32_t heartbeat = 0x701, emergency = 0x81, tpdo1 = 0x181, tpdo2 = 0x281;

std::uint16_t code_of(const CanFrame& f) {
  return static_cast<std::uint16_t>(take_number(f.payload().first(2)));
}

// NMT.

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
  CanFrame f = frame(0, {1, 1});
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

TEST(Heartbeat, ALostPartnerIsAnEmergencyAndEndsTheHeat) {
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
  EXPECT_EQ(code_of(frames[0]), 0x8130);
  EXPECT_EQ(frames[0].data[2] & 0x11U, 0x11U);
  EXPECT_EQ(frames[0].data[3], 0x10);
  EXPECT_FALSE(rig.command.arm);
  EXPECT_EQ(rig.output.current_A, 0);
  EXPECT_EQ(rig.state(), DriveState::fault);
  EXPECT_EQ(rig.servo.node().state(), Nmt::pre_operational) << "1029h";
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
  EXPECT_EQ(code_of(frames[0]), 0x4310);
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
  EXPECT_EQ(code_of(cleared[0]), 0);
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
  EXPECT_EQ(rig.set({0x1014, 0}, 0x91, 4), Abort::none);
}

// SYNC and PDO.

TEST(Pdo, TheDefaultsDriveTheAxis) {
  ServoRig rig;
  rig.run(150);
  rig.nmt(1);
  rig.send(0x201, {6, 0, 1});
  rig.run(2);
  EXPECT_EQ(rig.state(), DriveState::ready);
  EXPECT_EQ(rig.get({0x6061, 0}), 1U);
  rig.send(0x301, {0x10, 0x27, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(rig.get({0x607A, 0}), 10000U);
  const auto frames = rig.take(tpdo1);
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames.back().length, 5);
  EXPECT_EQ(take_number(frames.back().payload().first(2)), rig.status());
}

TEST(Pdo, NothingIsSentOrTakenBeforeOperational) {
  ServoRig rig;
  rig.run(150);
  rig.send(0x201, {6, 0, 1});
  rig.sync();
  rig.run(300);
  EXPECT_TRUE(rig.take(tpdo1).empty());
  EXPECT_TRUE(rig.take(tpdo2).empty());
  EXPECT_EQ(rig.state(), DriveState::disabled);
}

TEST(Pdo, EveryNthSyncAndEachChange) {
  ServoRig rig;
  for (const std::uint8_t type : Bytes{1, 2, 5, 240}) {
    ASSERT_EQ(rig.set({0x1801, 2}, type, 1), Abort::none);
    rig.nmt(1);
    rig.sent.clear();
    for (int i = 0; i < 480; ++i) {
      rig.sync();
    }
    EXPECT_THAT(rig.take(tpdo2), SizeIs(480U / type)) << int{type};
    rig.nmt(128);
  }
  ASSERT_EQ(rig.set({0x1801, 2}, 0, 1), Abort::none);
  rig.nmt(1);
  rig.sent.clear();
  for (int i = 0; i < 10; ++i) {
    rig.sync();
  }
  EXPECT_THAT(rig.take(tpdo2), SizeIs(1)) << "nothing has changed since the first";
  EXPECT_EQ(rig.set({0x1801, 2}, 241, 1), Abort::value);
  EXPECT_EQ(rig.set({0x1801, 2}, 252, 1), Abort::value);
  EXPECT_EQ(rig.set({0x1801, 2}, 253, 1), Abort::value);
  EXPECT_EQ(rig.set({0x1801, 2}, 254, 1), Abort::none);
}

TEST(Pdo, ASyncCounterStartsWhereItIsTold) {
  ServoRig rig;
  EXPECT_EQ(rig.set({0x1019, 0}, 1, 1), Abort::value);
  EXPECT_EQ(rig.set({0x1019, 0}, 241, 1), Abort::too_high);
  ASSERT_EQ(rig.set({0x1019, 0}, 10, 1), Abort::none);
  EXPECT_EQ(rig.set({0x1801, 6}, 3, 1), Abort::state) << "the PDO is valid";
  rig.set({0x1801, 1}, 0xC000'0281, 4);
  ASSERT_EQ(rig.set({0x1801, 6}, 3, 1), Abort::none);
  rig.set({0x1801, 2}, 2, 1);
  rig.set({0x1801, 1}, 0x4000'0281, 4);
  rig.nmt(1);
  std::vector<int> answered;
  for (std::uint8_t i = 1; i <= 10; ++i) {
    rig.sent.clear();
    rig.send(0x80, {i});
    if (!rig.take(tpdo2).empty()) {
      answered.push_back(i);
    }
  }
  EXPECT_THAT(answered, ElementsAre(3, 5, 7, 9));
  rig.sent.clear();
  rig.sync();
  rig.step();
  const auto frames = rig.take(emergency);
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_EQ(code_of(frames[0]), 0x8240) << "a SYNC without its counter";
  rig.set({0x1006, 0}, 1000, 4);
  EXPECT_EQ(rig.set({0x1019, 0}, 0, 1), Abort::state);
}

TEST(Pdo, ASynchronousSetPointWaitsForTheSync) {
  ServoRig rig;
  rig.set({0x1401, 2}, 1, 1);
  rig.nmt(1);
  rig.send(0x301, {7, 0, 0, 0, 0, 0, 0, 0});
  rig.run(3);
  EXPECT_EQ(rig.get({0x607A, 0}), 0U);
  rig.sync();
  EXPECT_EQ(rig.get({0x607A, 0}), 7U);
}

TEST(Pdo, WhatIsSentIsWhatTheSyncHasFound) {
  ServoRig rig;
  for (const std::uint8_t type : Bytes{0, 1}) {
    rig.set({0x1801, 1}, 0xC000'0281, 4);
    rig.set({0x1A01, 0}, 0, 1);
    rig.set({0x1A01, 1}, 0x607A'0020, 4);
    rig.set({0x1A01, 0}, 1, 1);
    rig.set({0x1801, 2}, type, 1);
    ASSERT_EQ(rig.set({0x1801, 1}, 0x4000'0281, 4), Abort::none);
    rig.nmt(1);
    rig.send(0x301, {static_cast<std::uint8_t>(type + 7), 0, 0, 0, 0, 0, 0, 0});
    rig.sent.clear();
    // All three have come before the node's answer can leave.
    rig.servo.receive(frame(0x80, {}), rig.now_us);
    rig.servo.receive(frame(0x301, {99, 0, 0, 0, 0, 0, 0, 0}), rig.now_us);
    rig.step();
    const auto frames = rig.take(tpdo2);
    ASSERT_THAT(frames, SizeIs(1));
    EXPECT_EQ(frames[0].data[0], type + 7);
    rig.nmt(128);
  }
}

TEST(Pdo, InhibitAndEventTimersHold) {
  ServoRig rig;
  rig.set({0x1800, 1}, 0xC000'0181, 4);
  rig.set({0x1800, 3}, 200, 2);
  rig.set({0x1800, 5}, 50, 2);
  rig.set({0x1800, 1}, 0x4000'0181, 4);
  EXPECT_EQ(rig.set({0x1800, 3}, 100, 2), Abort::state);
  rig.run(150);
  rig.nmt(1);
  rig.sent.clear();
  rig.run(500);
  EXPECT_THAT(rig.take(tpdo1), SizeIs(testing::AllOf(testing::Ge(9U), testing::Le(11U))));
  rig.run(60);
  rig.sent.clear();
  for (std::uint16_t i = 0; i < 100; ++i) {
    rig.send(0x201, {i % 2 == 0 ? std::uint8_t{6} : std::uint8_t{0}, 0, 1});
    rig.step();
  }
  EXPECT_THAT(rig.take(tpdo1), SizeIs(testing::Le(6U))) << "20 ms between two";
}

TEST(Pdo, LengthsAndDeadlinesAreEmergencies) {
  ServoRig rig;
  rig.set({0x1400, 5}, 20, 2);
  rig.nmt(1);
  rig.run(100);
  rig.sent.clear();
  rig.send(0x201, {6, 0});
  rig.step();
  EXPECT_EQ(code_of(rig.take(emergency).at(0)), 0x8210);
  EXPECT_EQ(rig.get({0x6060, 0}), 0U) << "not processed";
  rig.send(0x201, {6, 0, 1, 0});
  rig.step();
  EXPECT_EQ(code_of(rig.take(emergency).at(0)), 0x8220);
  EXPECT_EQ(rig.get({0x6060, 0}), 1U) << "the rest is ignored";
  rig.run(30);
  const auto late = rig.take(emergency);
  ASSERT_THAT(late, SizeIs(1));
  EXPECT_EQ(code_of(late[0]), 0x8250);
}

TEST(Pdo, MappingsChangeOnlyInTheRightOrder) {
  ServoRig rig;
  const Key count{0x1A02, 0}, first{0x1A02, 1}, cob{0x1802, 1};
  EXPECT_EQ(rig.set({0x1A00, 0}, 0, 1), Abort::state) << "valid";
  EXPECT_EQ(rig.set({0x1A00, 1}, mapped(0x6064, 0, 32), 4), Abort::state);
  EXPECT_EQ(rig.set(first, mapped(0x6064, 0, 32), 4), Abort::state) << "some are mapped";
  ASSERT_EQ(rig.set(count, 0, 1), Abort::none);
  EXPECT_EQ(rig.set(first, mapped(0x5FFF, 0, 32), 4), Abort::no_object);
  EXPECT_EQ(rig.set(first, mapped(0x2200, 99, 32), 4), Abort::no_sub);
  EXPECT_EQ(rig.set(first, mapped(0x1017, 0, 16), 4), Abort::not_mappable);
  EXPECT_EQ(rig.set(first, mapped(0x6064, 0, 16), 4), Abort::not_mappable) << "wrong length";
  EXPECT_EQ(rig.set(first, mapped(0x2201, 1, 32), 4), Abort::not_mappable) << "not to be sent";
  EXPECT_EQ(rig.set(first, mapped(0x6064, 0, 32), 4), Abort::none);
  EXPECT_EQ(rig.set({0x1A02, 2}, mapped(0x2200, 1, 32), 4), Abort::none);
  EXPECT_EQ(rig.set({0x1A02, 3}, mapped(0x6041, 0, 16), 4), Abort::none);
  EXPECT_EQ(rig.set(count, 3, 1), Abort::pdo_length) << "80 bits";
  EXPECT_EQ(rig.set(count, 9, 1), Abort::pdo_length);
  EXPECT_EQ(rig.set(count, 2, 1), Abort::none);
  EXPECT_EQ(rig.set(cob, 0x4000'0381, 4), Abort::none);
  rig.nmt(1);
  rig.run(150);
  EXPECT_EQ(rig.take(0x381).at(0).length, 8);
  EXPECT_EQ(rig.set({0x1602, 0}, 0, 1), Abort::none);
  EXPECT_EQ(rig.set({0x1602, 1}, mapped(5, 0, 8), 4), Abort::none) << "a dummy";
  EXPECT_EQ(rig.set({0x1602, 2}, mapped(0x2201, 1, 32), 4), Abort::none);
  EXPECT_EQ(rig.set({0x1602, 0}, 2, 1), Abort::none);
  EXPECT_EQ(rig.set({0x1402, 1}, 0x401, 4), Abort::none);
  rig.send(0x401, {9, 0, 0, 0x80, 0x3E});
  EXPECT_EQ(rig.get_real({0x2201, 1}), 0.25F);
}

TEST(Pdo, IdentifiersObeyTheRules) {
  ServoRig rig;
  for (const std::uint32_t id : {0x0U, 0x1U, 0x7FU, 0x101U, 0x180U, 0x581U, 0x5FFU, 0x601U, 0x67FU,
                                 0x6E0U, 0x6FFU, 0x701U, 0x77FU, 0x7FFU}) {
    EXPECT_EQ(rig.set({0x1402, 1}, cob_invalid | id, 4), Abort::value) << id;
  }
  for (const std::uint32_t id : {0x80U, 0x100U, 0x181U, 0x580U, 0x600U, 0x680U, 0x6DFU, 0x700U}) {
    EXPECT_EQ(rig.set({0x1402, 1}, cob_invalid | id, 4), Abort::none) << id;
  }
  EXPECT_EQ(rig.set({0x1402, 1}, 0x2000'0401, 4), Abort::value) << "29 bits";
  EXPECT_EQ(rig.set({0x1400, 1}, 0x202, 4), Abort::state) << "valid";
  EXPECT_EQ(rig.set({0x1400, 1}, cob_invalid | 0x202, 4), Abort::none);
  EXPECT_EQ(rig.set({0x1400, 1}, 0x202, 4), Abort::none);
}

TEST(Pdo, RemoteRequestsAreAnsweredWhereTheyAreAllowed) {
  ServoRig rig;
  rig.set({0x1801, 2}, 254, 1);
  rig.nmt(1);
  rig.run(20);
  CanFrame request = frame(tpdo2, {});
  request.remote = true;
  rig.sent.clear();
  rig.servo.receive(request, rig.now_us);
  rig.step();
  EXPECT_TRUE(rig.take(tpdo2).empty());
  rig.set({0x1801, 1}, 0x281, 4);
  rig.run(2);
  rig.sent.clear();
  rig.servo.receive(request, rig.now_us);
  rig.step();
  EXPECT_THAT(rig.take(tpdo2), SizeIs(1));
}

// What is kept.

TEST(Store, TheBusIsAsItWasAfterAReset) {
  ServoRig rig;
  rig.set({0x1017, 0}, 500, 2);
  rig.set({0x1802, 1}, 0x4000'0381, 4);
  rig.set({0x6067, 0}, 42, 4);
  EXPECT_EQ(rig.set({0x1020, 1}, 7, 4), Abort::none);
  ASSERT_EQ(rig.set({0x1010, 1}, store_signature, 4), Abort::none);
  rig.set({0x1017, 0}, 100, 2);
  EXPECT_EQ(rig.get({0x1020, 1}), 0U) << "1020h: something has changed since";
  rig.nmt(129);
  rig.run(5);
  EXPECT_EQ(rig.get({0x1017, 0}), 500U);
  EXPECT_EQ(rig.get({0x1802, 1}), 0x4000'0381U);
  EXPECT_EQ(rig.get({0x6067, 0}), 42U);
  EXPECT_EQ(rig.get({0x1020, 1}), 7U);
  ASSERT_EQ(rig.set({0x1011, 1}, restore_signature, 4), Abort::none);
  EXPECT_EQ(rig.get({0x1017, 0}), 500U) << "until the reset";
  rig.nmt(129);
  rig.run(5);
  EXPECT_EQ(rig.get({0x1017, 0}), 0U);
  EXPECT_EQ(rig.get({0x1802, 1}), 0xC000'0381U);
  EXPECT_EQ(rig.get({0x6067, 0}), 100U);
  EXPECT_EQ(rig.set({0x1011, 1}, store_signature, 4), Abort::transfer);
}

TEST(Store, IsRefusedWhileEnabled) {
  ServoRig rig;
  rig.enable();
  ASSERT_EQ(rig.output.state, DeviceState::running);
  EXPECT_EQ(rig.set({0x1010, 1}, store_signature, 4), Abort::state);
  EXPECT_EQ(rig.set({0x1011, 1}, restore_signature, 4), Abort::state);
}

/// Every object is as its description says: the EDS is made from the same one.
TEST(Store, DefaultsAreThoseOfTheTable) {
  ServoRig rig;
  for (const DescribedObject& row : communication_rows) {
    const Object& o = row.object;
    if ((o.access & stored) != 0) {
      EXPECT_EQ(rig.get(o.key), default_of(o, 1)) << row.name;
    }
  }
}

TEST(Store, ADamagedImageMeansDefaults) {
  ServoRig rig;
  rig.set({0x1017, 0}, 500, 2);
  rig.set({0x1010, 2}, store_signature, 4);
  std::mt19937 random(3);
  const Bytes good = rig.image;
  for (int i = 0; i < 2000; ++i) {
    Bytes bad = good;
    bad[random() % bad.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
    EXPECT_FALSE(rig.servo.start(bad, rig.now_us));
    EXPECT_EQ(rig.servo.node().objects().heartbeat_ms, 0);
    EXPECT_FALSE(
        rig.servo.start(std::span(good).first(random() % (good.size() - 1) + 1), rig.now_us));
  }
  EXPECT_TRUE(rig.servo.start(good, rig.now_us));
  EXPECT_EQ(rig.servo.node().objects().heartbeat_ms, 500);
}

// LSS.

Bytes lss(std::uint8_t command, std::uint32_t value = 0, std::uint8_t a = 0, std::uint8_t b = 0,
          std::uint8_t c = 0) {
  Bytes data{command};
  const Bytes number = little(value, 4);
  data.insert(data.end(), number.begin(), number.end());
  data.insert(data.end(), {a, b, c});
  return data;
}

class LssRig : public ServoRig {
 public:
  explicit LssRig(std::uint8_t stored_id = unconfigured) {
    // An image that LSS has stored.
    image.resize(Node::image_size);
    image.resize(servo.image(image));
    image[3] = stored_id;
    put_number(std::span(image).last(2), crc16(std::span(image).first(image.size() - 2)));
    restart();
    sent.clear();
  }
  std::optional<Bytes> tell(const Bytes& request) {
    take(0x7E4);
    send(0x7E5, request);
    const auto frames = take(0x7E4);
    return frames.empty() ? std::nullopt
                          : std::optional(Bytes(frames[0].data.begin(), frames[0].data.end()));
  }
  std::array<std::uint32_t, 4> identity() { return servo.node().objects().identity; }
};

TEST(Lss, ANodeWithoutIdIsFoundBitByBitAndNamed) {
  LssRig rig;
  rig.run(100);
  EXPECT_TRUE(rig.sent.empty()) << "it says nothing by itself";
  ASSERT_TRUE(rig.tell(lss(0x51, 0, 0x80)));
  std::array<std::uint32_t, 4> found{};
  for (std::uint8_t part = 0; part < 4; ++part) {
    for (int bit = 31; bit >= 0; --bit) {
      if (!rig.tell(lss(0x51, found[part], static_cast<std::uint8_t>(bit), part, part))) {
        found[part] |= 1U << static_cast<unsigned>(bit);
      }
    }
    const auto next = static_cast<std::uint8_t>((part + 1) % 4);
    ASSERT_TRUE(rig.tell(lss(0x51, found[part], 0, part, next))) << int{part};
  }
  EXPECT_EQ(found, rig.identity());
  EXPECT_EQ(rig.tell({0x5E, 0, 0, 0, 0, 0, 0, 0})->at(1), unconfigured);
  EXPECT_EQ(rig.tell({0x11, 128, 0, 0, 0, 0, 0, 0})->at(1), 1) << "out of range";
  EXPECT_EQ(rig.tell({0x11, 42, 0, 0, 0, 0, 0, 0})->at(1), 0);
  rig.send(0x7E5, {0x17, 0, 0, 0, 0, 0, 0, 0});
  rig.run(2);
  EXPECT_EQ(rig.take(0x7E4).at(0).data[1], 0) << "stored";
  rig.send(0x7E5, {4, 0, 0, 0, 0, 0, 0, 0});
  rig.run(5);
  EXPECT_THAT(rig.take(0x700 + 42), SizeIs(1)) << "boots up";
  rig.nmt(129, 42);
  rig.run(5);
  EXPECT_EQ(rig.node_id(), 42);
  EXPECT_EQ(rig.get({0x1200, 1}), 0x62AU);
}

TEST(Lss, AnIdCountsAfterAResetOfTheCommunication) {
  ServoRig rig;
  rig.send(0x7E5, {4, 1, 0, 0, 0, 0, 0, 0});
  rig.send(0x7E5, {0x11, 9, 0, 0, 0, 0, 0, 0});
  rig.send(0x7E5, {4, 0, 0, 0, 0, 0, 0, 0});
  rig.run(5);
  EXPECT_EQ(rig.node_id(), 1);
  rig.nmt(130);
  rig.run(5);
  EXPECT_EQ(rig.node_id(), 9);
  rig.nmt(129, 9);
  rig.run(5);
  EXPECT_EQ(rig.node_id(), 1) << "it was not stored";
}

TEST(Lss, OnlyTheOneThatIsMeantAnswers) {
  LssRig rig(5);
  const auto id = rig.identity();
  EXPECT_FALSE(rig.tell(lss(0x40, id[0])));
  EXPECT_FALSE(rig.tell(lss(0x41, id[1])));
  EXPECT_FALSE(rig.tell(lss(0x42, id[2])));
  EXPECT_FALSE(rig.tell(lss(0x43, id[3] + 1)));
  EXPECT_FALSE(rig.tell({0x5E, 0, 0, 0, 0, 0, 0, 0})) << "not selected";
  for (std::uint8_t i = 0; i < 3; ++i) {
    rig.tell(lss(static_cast<std::uint8_t>(0x40 + i), id[i]));
  }
  EXPECT_EQ(rig.tell(lss(0x43, id[3]))->at(0), 0x44);
  EXPECT_EQ(rig.tell({0x5E, 0, 0, 0, 0, 0, 0, 0})->at(1), 5);
  for (std::uint8_t i = 0; i < 4; ++i) {
    const auto answer = rig.tell({static_cast<std::uint8_t>(0x5A + i), 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(take_number(std::span(*answer).subspan(1, 4)), id[i]);
  }
  EXPECT_EQ(rig.tell({0x13, 0, 3, 0, 0, 0, 0, 0})->at(1), 0);
  EXPECT_EQ(rig.tell({0x13, 0, 5, 0, 0, 0, 0, 0})->at(1), 1) << "reserved";
  EXPECT_EQ(rig.tell({0x13, 1, 3, 0, 0, 0, 0, 0})->at(1), 1) << "no such table";
  rig.tell({0x15, 100, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(rig.servo.request(), Request::bit_rate);
  EXPECT_EQ(rig.servo.node().bit_rate(), 3);
  EXPECT_EQ(rig.servo.node().bit_rate_delay_ms(), 100);
}

TEST(Lss, IdentificationAsksForRanges) {
  LssRig rig(5);
  const auto id = rig.identity();
  const auto identify = [&](std::uint32_t low, std::uint32_t high) {
    rig.tell(lss(0x46, id[0]));
    rig.tell(lss(0x47, id[1]));
    rig.tell(lss(0x48, id[2]));
    rig.tell(lss(0x49, id[2]));
    rig.tell(lss(0x4A, low));
    return rig.tell(lss(0x4B, high)).has_value();
  };
  EXPECT_TRUE(identify(0, 0xFFFF'FFFF));
  EXPECT_TRUE(identify(id[3], id[3]));
  EXPECT_FALSE(identify(id[3] + 1, 0xFFFF'FFFF));
  EXPECT_FALSE(rig.tell(lss(0x4C))) << "it has a node-id";
  LssRig nameless;
  EXPECT_EQ(nameless.tell(lss(0x4C))->at(0), 0x50);
}

}  // namespace
}  // namespace smaservo::canopen::node_test
