#include "firmware/canopen/node/pdo.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::pdo_test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr std::uint32_t emergency = 0x81, tpdo1 = 0x181, tpdo2 = 0x281;

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
  EXPECT_EQ(emergency_code(frames[0]), 0x8240) << "a SYNC without its counter";
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
    // The SYNC and the second RPDO have both come before the node's answer can leave.
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
  rig.set({0x1015, 0}, 0, 2);
  rig.nmt(1);
  rig.run(100);
  rig.sent.clear();
  rig.send(0x201, {6, 0});
  rig.step();
  EXPECT_EQ(emergency_code(rig.take(emergency).at(0)), 0x8210);
  EXPECT_EQ(rig.get({0x6060, 0}), 0U) << "not processed";
  rig.send(0x201, {6, 0, 1, 0});
  rig.step();
  EXPECT_EQ(emergency_code(rig.take(emergency).at(0)), 0x8220);
  EXPECT_EQ(rig.get({0x6060, 0}), 1U) << "the rest is ignored";
  rig.run(30);
  const auto late = rig.take(emergency);
  ASSERT_THAT(late, SizeIs(2));
  EXPECT_EQ(emergency_code(late[0]), 0x8250);
  EXPECT_EQ(emergency_code(late[1]), 0)
      << "the node leaves OPERATIONAL, and so the wrong length ends";
  EXPECT_EQ(late[1].data[2], 0x11) << "the source is still lost";
}

// Without heartbeats, the partner's RPDO alone ends the error.
TEST(Pdo, APartnerThatSpeaksAgainEndsTheError) {
  ServoRig rig;
  rig.set({0x1400, 5}, 20, 2);
  rig.set({0x1029, 1}, 1, 1);
  rig.nmt(1);
  rig.send(0x201, {6, 0, 1});
  rig.run(30);
  ASSERT_EQ(emergency_code(rig.take(emergency).at(0)), 0x8250);
  EXPECT_EQ(rig.get({0x1001, 0}) & 0x10U, 0x10U);
  EXPECT_FALSE(rig.command.fresh);
  rig.send(0x201, {6, 0, 1});
  rig.run(15);
  EXPECT_TRUE(rig.command.fresh);
  EXPECT_EQ(rig.get({0x1001, 0}), 0U);
  const auto ended = rig.take(emergency);
  ASSERT_THAT(ended, SizeIs(1));
  EXPECT_EQ(emergency_code(ended[0]), 0);
}

TEST(Pdo, WithoutObjectsItIsNeitherSentNorTaken) {
  ServoRig rig;
  for (const std::uint8_t type : Bytes{1, 255}) {
    rig.set({0x1802, 2}, type, 1);
    rig.set({0x1A02, 0}, 0, 1);
    ASSERT_EQ(rig.set({0x1802, 1}, 0x381, 4), Abort::none);
    ASSERT_EQ(rig.set({0x1402, 1}, 0x401, 4), Abort::none);
    rig.nmt(1);
    rig.run(10);
    rig.sent.clear();
    rig.sync();
    hal::CanFrame request = frame(0x381, {});
    request.remote = true;
    rig.servo.receive(request, rig.now_us);
    rig.send(0x401, {1, 2, 3, 4});
    rig.run(250);
    EXPECT_TRUE(rig.take(0x381).empty());
    EXPECT_TRUE(rig.take(emergency).empty()) << "no length to be wrong";
    rig.nmt(128);
    rig.set({0x1802, 1}, cob_invalid | 0x381, 4);
  }
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

/// CiA 301 has the dummies for RPDOs: what a TPDO sends must be something.
TEST(Pdo, DummiesAreForReceiving) {
  ServoRig rig;
  rig.set({0x1A02, 0}, 0, 1);
  const std::array<unsigned, 8> bits{0, 8, 8, 16, 32, 8, 16, 32};
  for (std::uint16_t type = 2; type <= 7; ++type) {
    const std::uint32_t dummy = mapped(type, 0, bits.at(type));
    EXPECT_EQ(rig.set({0x1A02, 1}, dummy, 4), Abort::not_mappable) << type;
    EXPECT_EQ(rig.set({0x1602, 1}, dummy, 4), Abort::none) << type;
  }
}

/// Live values in REAL32 change in each step, so only the inhibit time limits their rate.
TEST(Pdo, LiveValuesComeEvery20MillisecondsByDefault) {
  ServoRig rig;
  rig.set({0x1802, 1}, 0x4000'0381, 4);
  rig.set({0x1803, 1}, 0x4000'0481, 4);
  rig.enable();
  rig.nmt(1);
  rig.run(100);
  rig.sent.clear();
  for (int i = 0; i < 1000; ++i) {
    rig.step();
    Output<double> out = rig.output;
    out.measurement.resistance_ohm = 10 + 0.01 * i;
    out.estimate.temperature_K = 300 + 0.01 * i;
    rig.servo.publish(out, Inputs<double>{}, 1e-3);
  }
  for (const std::uint32_t id : {0x381U, 0x481U}) {
    const std::size_t count = rig.take(id).size();
    EXPECT_LE(count, 51U) << id;
    EXPECT_GE(count, 10U) << id;
  }
}

/// The load that 2211h gives is never less than that of the frames sent, and equal to it for a PDO
/// whose values always change.
TEST(Pdo, TheLoadOfTheMappingIsTold) {
  ServoRig rig;
  rig.step();
  EXPECT_NEAR(rig.get_real({0x2211, 4}), 1000, 1) << "TPDO1 has no inhibit time";
  for (const unsigned inhibit_100us : {30U, 100U, 1000U}) {
    rig.nmt(128);
    for (const std::uint16_t index : std::array<std::uint16_t, 2>{0x1800, 0x1802}) {
      const std::uint32_t cob = index == 0x1800 ? 0x181 : 0x381;
      rig.set({index, 1}, cob_invalid | cob_no_remote | cob, 4);
      ASSERT_EQ(rig.set({index, 3}, inhibit_100us, 2), Abort::none);
    }
    rig.set({0x1802, 1}, cob_no_remote | 0x381, 4);
    rig.step();
    const float frames = rig.get_real({0x2211, 4});
    EXPECT_NEAR(frames, 1e4 / inhibit_100us, 0.1);
    // 8 bytes: 111 bits and at most 24 stuff bits, at 1 Mbit/s.
    EXPECT_NEAR(rig.get_real({0x2211, 5}), 100.F * frames * 135 / 1e6F, 0.01F);
    rig.nmt(1);
    rig.sent.clear();
    for (int i = 0; i < 1000; ++i) {
      rig.step();
      Output<double> out = rig.output;
      out.estimate.temperature_K = 300 + 0.01 * i;
      rig.servo.publish(out, Inputs<double>{}, 1e-3);
    }
    EXPECT_NEAR(static_cast<double>(rig.take(0x381).size()), frames, 2);
  }
  rig.nmt(128);
  rig.set({0x1802, 1}, cob_invalid | 0x381, 4);
  rig.set({0x1006, 0}, 10'000, 4);
  rig.step();
  EXPECT_NEAR(rig.get_real({0x2211, 4}), 100, 0.1) << "TPDO2 with each SYNC";
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
  hal::CanFrame request = frame(tpdo2, {});
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

}  // namespace
}  // namespace smaservo::canopen::pdo_test
