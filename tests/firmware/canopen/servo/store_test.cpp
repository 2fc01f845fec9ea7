// What 1010h keeps and 1011h forgets.

#include <gtest/gtest.h>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::store_test {
namespace {

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

}  // namespace
}  // namespace smaservo::canopen::store_test
