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

// A reset comes while something is being stored. Its result belongs to the request of before.
TEST(Store, AResultAnswersItsOwnRequestOnly) {
  ServoRig rig;
  rig.answers = false;
  Bytes save = ServoRig::named(0x23, {0x1010, 1});
  const Bytes signature = little(store_signature, 4);
  save.insert(save.end(), signature.begin(), signature.end());
  rig.send(0x601, save);
  ASSERT_EQ(rig.servo.request(), Request::store_all);
  const std::uint32_t first = rig.servo.request_number();
  rig.nmt(130);
  ASSERT_EQ(rig.servo.request(), Request::reset_communication);
  rig.servo.finish(first, true);
  ASSERT_EQ(rig.servo.request(), Request::reset_communication) << "it waits for start()";
  rig.restart();
  rig.run(2);
  rig.send(0x601, save);
  ASSERT_EQ(rig.servo.request(), Request::store_all);
  const std::uint32_t second = rig.servo.request_number();
  ASSERT_NE(second, first);
  rig.servo.finish(first, true);
  rig.run(2);
  EXPECT_TRUE(rig.take(0x581).empty()) << "nothing is stored yet";
  ASSERT_EQ(rig.servo.request(), Request::store_all);
  rig.servo.finish(second, true);
  rig.run(2);
  EXPECT_EQ(rig.take(0x581).size(), 1U);
}

// What others give is logged like a write, and takes back nothing that waits for the next start.
TEST(Store, SettingsOfOthersAreLogged) {
  ServoRig rig;
  ASSERT_EQ(rig.set({0x2000, 2}, 17, 4), Abort::none) << "node-id, after a reset";
  Settings<double> given = rig.staging.active();
  given.limits.current_A *= 0.5;
  given = stored_settings<double>(given);
  const std::uint32_t changes = rig.servo.objects().changes;
  rig.servo.replace_settings(given, Source::file);
  EXPECT_EQ(rig.servo.objects().changes, changes + 1);
  LoggedChange last{};
  while (rig.servo.take_change(last)) {
  }
  EXPECT_EQ(last.key, (Key{0x2020, 2}));
  EXPECT_EQ(last.source, Source::file);
  EXPECT_EQ(2 * as_real(last.value), as_real(last.before));
  EXPECT_EQ(rig.get({0x2000, 2}), 17U);
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
