#include "firmware/canopen/node/lss.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::lss_test {
namespace {

using testing::SizeIs;

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

TEST(Lss, AnImageWithANodeIdThatThereIsNotIsDamaged) {
  LssRig rig(127);
  EXPECT_EQ(rig.node_id(), 127);
  for (const std::uint8_t id : std::array<std::uint8_t, 3>{128, 200, 254}) {
    rig.image[3] = id;
    put_number(std::span(rig.image).last(2),
               crc16(std::span(rig.image).first(rig.image.size() - 2)));
    EXPECT_FALSE(rig.servo.start(rig.image, rig.now_us)) << int{id};
    EXPECT_EQ(rig.node_id(), ServoRig::id);
  }
}

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

// A node-id for which LSS has answered "not stored" is not stored with the next save either.
TEST(Lss, WhatCouldNotBeStoredIsNotStoredLater) {
  ServoRig rig;
  rig.storage_works = false;
  rig.send(0x7E5, {4, 1, 0, 0, 0, 0, 0, 0});
  rig.send(0x7E5, {0x11, 9, 0, 0, 0, 0, 0, 0});
  rig.take(0x7E4);
  rig.send(0x7E5, {0x17, 0, 0, 0, 0, 0, 0, 0});
  rig.run(2);
  EXPECT_EQ(rig.take(0x7E4).at(0).data[1], 2) << "media error";
  rig.storage_works = true;
  ASSERT_EQ(rig.set({0x1010, 2}, store_signature, 4), Abort::none);
  rig.nmt(129);
  rig.run(5);
  EXPECT_EQ(rig.node_id(), 1);
}

// There must be no second answer: the master would take it for the answer to its next request.
TEST(Lss, TwoStoresAreAnsweredOnce) {
  ServoRig rig;
  rig.answers = false;
  rig.send(0x7E5, {4, 1, 0, 0, 0, 0, 0, 0});
  rig.send(0x7E5, {0x17, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_TRUE(rig.take(0x7E4).empty());
  rig.send(0x7E5, {0x17, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(rig.take(0x7E4).at(0).data[1], 2);
  rig.answers = true;
  rig.run(2);
  EXPECT_TRUE(rig.take(0x7E4).empty());
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
}  // namespace smaservo::canopen::lss_test
