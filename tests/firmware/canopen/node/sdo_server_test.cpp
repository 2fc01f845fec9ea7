#include "firmware/canopen/node/sdo_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::canopen::sdo_server_test {
namespace {

constexpr Key heartbeat{0x1017, 0}, name{0x1008, 0}, eds{0x1021, 0}, gain{0x2100, 1},
    status{0x6041, 0}, key{0x2003, 2};

Abort abort_in(const std::optional<Bytes>& answer) {
  return answer && answer->at(0) == 0x80
             ? static_cast<Abort>(take_number(std::span(*answer).subspan(4)))
             : Abort::none;
}

TEST(Sdo, ExpeditedValuesComeBack) {
  ServoRig rig;
  EXPECT_EQ(rig.set(heartbeat, 1234, 2), Abort::none);
  EXPECT_EQ(rig.upload(heartbeat).data, little(1234, 2));
  EXPECT_EQ(rig.ask(ServoRig::named(0x40, heartbeat)), (Bytes{0x4B, 0x17, 0x10, 0, 0xD2, 4, 0, 0}));
}

TEST(Sdo, TextsComeInSegments) {
  ServoRig rig;
  const Bytes data = rig.upload(name).data;
  EXPECT_EQ(std::string(data.begin(), data.end()), "smaservo");
  const Bytes file = rig.upload(eds).data;
  EXPECT_EQ(std::string(file.begin(), file.end()), ServoRig::eds);
}

TEST(Sdo, FourBytesMayComeInSegments) {
  ServoRig rig;
  EXPECT_EQ(abort_in(rig.ask({0x21, 0x00, 0x21, 1, 4})), Abort::none);
  const std::optional<Bytes> done = rig.ask({0x07, 0, 0, 0x80, 0x3F});
  EXPECT_EQ(done, (Bytes{0x20, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(rig.get_real(gain), 1.F);
}

TEST(Sdo, FourBytesMayComeAsABlock) {
  ServoRig rig;
  ASSERT_EQ(rig.ask({0xC6, 0x00, 0x21, 1, 4}), (Bytes{0xA4, 0x00, 0x21, 1, 127, 0, 0, 0}));
  ASSERT_EQ(rig.ask({0x81, 0, 0, 0x00, 0x40}), (Bytes{0xA2, 1, 127, 0, 0, 0, 0, 0}));
  const std::uint16_t crc = crc16(Bytes{0, 0, 0, 0x40});
  Bytes end{0xC1 | 3U << 2U};
  const Bytes sum = little(crc, 2);
  end.insert(end.end(), sum.begin(), sum.end());
  ASSERT_EQ(rig.ask(end), (Bytes{0xA1, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(rig.get_real(gain), 2.F);
}

TEST(Sdo, ABlockWithAWrongCrcChangesNothing) {
  ServoRig rig;
  rig.ask({0xC6, 0x00, 0x21, 1, 4});
  rig.ask({0x81, 0, 0, 0x00, 0x40});
  EXPECT_EQ(abort_in(rig.ask({0xC1 | 3U << 2U, 1, 2})), Abort::crc);
  EXPECT_EQ(rig.get_real(gain), 0.F);
}

/// CRC-16/XMODEM of "123456789" is 31C3h: CiA 301 and every catalogue of CRCs.
TEST(Sdo, TheCrcIsThatOfXmodem) {
  EXPECT_EQ(crc16(Bytes{'1', '2', '3', '4', '5', '6', '7', '8', '9'}), 0x31C3);
}

TEST(Sdo, EveryRefusalHasItsCode) {
  ServoRig rig;
  EXPECT_EQ(rig.upload({0x5FFF, 0}).abort, Abort::no_object);
  EXPECT_EQ(rig.upload({0x1002, 0}).abort, Abort::no_object);
  EXPECT_EQ(rig.upload({0x1018, 5}).abort, Abort::no_sub);
  EXPECT_EQ(rig.upload({0x2100, 10}).abort, Abort::no_sub);
  EXPECT_EQ(rig.upload({0x2200, 200}).abort, Abort::no_sub);
  EXPECT_EQ(rig.upload({0x6041, 1}).abort, Abort::no_sub);
  EXPECT_EQ(rig.set(status, 0, 2), Abort::read_only);
  EXPECT_EQ(rig.set({0x1018, 0}, 0, 1), Abort::read_only);
  EXPECT_EQ(rig.upload(key).abort, Abort::write_only);
  EXPECT_EQ(rig.set(heartbeat, 0, 4), Abort::too_long);
  EXPECT_EQ(rig.set(heartbeat, 0, 1), Abort::too_short);
  EXPECT_EQ(rig.set(gain, 0, 2), Abort::too_short);
  EXPECT_EQ(rig.download(gain, Bytes(8)), Abort::too_long);
  EXPECT_EQ(rig.set({0x1003, 0}, 1, 1), Abort::value);
  EXPECT_EQ(rig.upload({0x1003, 1}).abort, Abort::no_data);
  EXPECT_EQ(rig.set({0x6060, 0}, 9, 1), Abort::value);
  EXPECT_EQ(rig.set({0x1029, 1}, 3, 1), Abort::too_high);
  EXPECT_EQ(rig.set({0x1010, 1}, 1, 4), Abort::transfer);
  EXPECT_EQ(abort_in(rig.ask({0xE0})), Abort::command) << "no such command";
  EXPECT_EQ(abort_in(rig.ask({0x00})), Abort::command) << "a segment of nothing";
  EXPECT_EQ(abort_in(rig.ask({0x60})), Abort::command);
  EXPECT_EQ(abort_in(rig.ask({0xC1})), Abort::command);
  EXPECT_EQ(abort_in(rig.ask({0xA2, 1, 127})), Abort::command);
  EXPECT_EQ(abort_in(rig.ask({0xA3})), Abort::command);
}

TEST(Sdo, TheHighestSubIndexIsAnObject) {
  ServoRig rig;
  EXPECT_EQ(rig.upload({0x1018, 0}).data, Bytes{4});
  EXPECT_EQ(rig.upload({0x2100, 0}).data, Bytes{9});
  EXPECT_EQ(rig.upload({0x2200, 0}).data, Bytes{signal_count});
  EXPECT_EQ(rig.upload({0x1800, 0}).data, Bytes{6});
}

TEST(Sdo, AToggleBitThatStandsStillEndsTheTransfer) {
  ServoRig rig;
  rig.ask(ServoRig::named(0x40, name));
  rig.ask({0x60});
  EXPECT_EQ(abort_in(rig.ask({0x60})), Abort::toggle);
  EXPECT_EQ(abort_in(rig.ask({0x70})), Abort::command) << "the transfer is over";
  rig.ask({0x21, 0x00, 0x21, 1, 4});
  EXPECT_EQ(abort_in(rig.ask({0x17})), Abort::toggle);
}

TEST(Sdo, ADownloadThatEndsTooSoonChangesNothing) {
  ServoRig rig;
  rig.ask({0x21, 0x00, 0x21, 1, 4});
  EXPECT_EQ(abort_in(rig.ask({0x0B, 0, 0})), Abort::too_short);
  rig.ask({0x21, 0x00, 0x21, 1, 4});
  EXPECT_EQ(abort_in(rig.ask({0x05, 0, 0})), Abort::too_long);
  EXPECT_EQ(rig.get_real(gain), 0.F);
}

TEST(Sdo, BlockSizesOf0And128AreRefused) {
  ServoRig rig;
  EXPECT_EQ(abort_in(rig.ask({0xA4, 0x21, 0x10, 0, 0, 0})), Abort::block_size);
  EXPECT_EQ(abort_in(rig.ask({0xA4, 0x21, 0x10, 0, 128, 0})), Abort::block_size);
  rig.ask({0xA4, 0x21, 0x10, 0, 127, 0});
  rig.send(0x601, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(abort_in(rig.ask({0xA2, 1, 0})), Abort::block_size);
}

TEST(Sdo, ATransferTimesOutWhenItsClientIsSilent) {
  ServoRig rig;
  rig.ask(ServoRig::named(0x40, name));
  rig.run(4999);
  EXPECT_TRUE(rig.take(0x581).empty());
  rig.run(5);
  const auto answers = rig.take(0x581);
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(take_number(std::span(answers[0].data).subspan(4)), 0x05040000U);
  rig.run(6000);
  EXPECT_TRUE(rig.take(0x581).empty()) << "once";
}

TEST(Sdo, BlocksTimeOutInEachOfTheirStates) {
  const Bytes download{0xC6, 0x00, 0x21, 1, 4}, upload{0xA4, 0x21, 0x10, 0, 2, 0};
  const std::vector<std::vector<Bytes>> left_alone{
      {download},       {download, {0x81, 0, 0, 0x00, 0x40}}, {upload},
      {upload, {0xA3}}, {upload, {0xA3}, {0xA2, 2, 127}},
  };
  for (std::size_t i = 0; i < left_alone.size(); ++i) {
    ServoRig rig;
    for (const Bytes& request : left_alone[i]) {
      rig.ask(request);
    }
    rig.sent.clear();
    rig.run(i == 0 ? 1010 : 5010);
    const auto answers = rig.take(0x581);
    ASSERT_EQ(answers.size(), 1U) << i;
    EXPECT_EQ(static_cast<Abort>(take_number(std::span(answers[0].data).subspan(4))),
              Abort::timeout)
        << i;
    EXPECT_EQ(rig.get({0x1000, 0}), servo_device_type);
  }
}

TEST(Sdo, TimeoutsAreObjects) {
  ServoRig rig;
  const auto silent_ms = [&](const Bytes& request) {
    rig.ask(request);
    rig.sent.clear();
    int ms = 0;
    while (rig.take(0x581).empty() && ms < 5000) {
      rig.run(1);
      ++ms;
    }
    return ms;
  };
  ASSERT_EQ(rig.set_real({0x2004, 1}, 0.25F), Abort::none);
  ASSERT_EQ(rig.set_real({0x2004, 2}, 0.5F), Abort::none);
  EXPECT_NEAR(silent_ms({0xC6, 0x00, 0x21, 1, 4}), 250, 2);
  EXPECT_NEAR(silent_ms(ServoRig::named(0x40, name)), 500, 2);
  EXPECT_EQ(rig.set_real({0x2004, 1}, 0.F), Abort::too_low);
  EXPECT_EQ(rig.set_real({0x2004, 2}, 601.F), Abort::too_high);
}

/// Clients that poll while a block download is abandoned: with one kind of request, with several
/// in turn, with block transfers of their own. Each is answered within the time-out and a second.
TEST(Sdo, AnAbandonedBlockDownloadIsGivenUpUnderPolling) {
  const Bytes read = ServoRig::named(0x40, status), gain_block{0xC6, 0x00, 0x21, 1, 4};
  const std::vector<std::vector<Bytes>> polls{
      {read},
      {read, {0x2B, 0x17, 0x10, 0, 0, 0}, {0x60}, {0x70}},
      {gain_block},
      {{0xA4, 0x21, 0x10, 0, 2, 0}, read},
  };
  for (std::size_t i = 0; i < polls.size(); ++i) {
    ServoRig rig;
    rig.ask(gain_block);
    rig.ask({0x01, 1, 2, 3, 4, 5, 6, 7});
    rig.sent.clear();
    int ms = 0;
    bool given_up = false;
    for (std::size_t n = 0; !given_up && ms < 5000; ++n) {
      rig.send(0x601, polls[i][n % polls[i].size()]);
      rig.run(200);
      ms += 200;
      for (const auto& answer : rig.take(0x581)) {
        given_up |= abort_in(Bytes(answer.data.begin(), answer.data.end())) != Abort::none;
      }
    }
    EXPECT_LE(ms, 2000) << i;
    EXPECT_EQ(rig.upload({0x1000, 0}).abort, Abort::none) << i;
  }
}

/// The second request of another client ends the abandoned block, and is answered.
TEST(Sdo, AnAbandonedBlockDownloadEndsWithTheNextTransfer) {
  const Bytes read = ServoRig::named(0x40, {0x1000, 0});
  const Bytes write{0x2B, 0x17, 0x10, 0, 0x10, 0x27};
  for (const Bytes& request : {read, write}) {
    ServoRig rig;
    rig.ask({0xC6, 0x00, 0x21, 1, 4});
    rig.ask({0x01, 1, 2, 3, 4, 5, 6, 7});
    rig.sent.clear();
    std::size_t answers = 0;
    for (int i = 0; i < 2; ++i) {
      rig.run(100);
      Bytes padded = request;
      padded.resize(8);
      rig.send(0x601, padded);
      answers += rig.take(0x581).size();
    }
    EXPECT_EQ(answers, 1U);
    EXPECT_EQ(rig.get({0x1000, 0}), servo_device_type);
    EXPECT_EQ(rig.get({0x1017, 0}), request == write ? 10'000U : 0U);
    EXPECT_EQ(rig.get_real(gain), 0.F) << "nothing of the block is written";
  }
}

/// A client that sends its block to the end is not interrupted, even if the data look like
/// requests, and if segments are lost (also the first), come twice, or come slowly.
TEST(Sdo, ABlockOfRequestsIsABlock) {
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    ServoRig rig;
    rig.ask({0xC2, 0x00, 0x21, 1, 4});
    rig.sent.clear();
    for (unsigned number = 1; number <= 127; ++number) {
      const bool is_lost = number == 1 || random() % 4 == 0;  // the server takes 64 bytes
      for (unsigned k = random() % 8 == 0 ? 2 : 1; k > 0 && !is_lost; --k) {
        rig.send(0x601, {static_cast<std::uint8_t>(number), 0x00, 0x10, 0, 0, 0, 0, 0});
      }
      rig.run(random() % 16 == 0 ? 60 : 1);
      for (const hal::CanFrame& answer : rig.take(0x581)) {
        EXPECT_NE(answer.data[0], 0x43) << "an upload";
      }
    }
  }
}

/// A bus of 10 kbit/s loses the second segment of a block; those that follow take 1.6 s.
TEST(Sdo, ASlowBlockWithALostSegmentIsNotGivenUp) {
  ServoRig rig;
  rig.ask({0xC2, 0x00, 0x21, 1, 4});
  rig.sent.clear();
  for (unsigned number = 3; number <= 127; ++number) {
    rig.send(0x601, {static_cast<std::uint8_t>(number), 1, 2, 3, 4, 5, 6, 7});
    rig.run(13);
  }
  const auto answers = rig.take(0x581);
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].data[0], 0xA2);
  EXPECT_EQ(answers[0].data[1], 0) << "nothing was taken";
}

TEST(Sdo, SegmentsOutsideOfTheirBlockEndIt) {
  ServoRig rig;
  rig.ask({0xC6, 0x00, 0x21, 1, 4});
  EXPECT_EQ(abort_in(rig.ask({0x00, 1, 2, 3, 4})), Abort::sequence) << "they count from 1";
  rig.ask({0xA4, 0x21, 0x10, 0, 2, 0});
  rig.send(0x601, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(abort_in(rig.ask({0xA2, 3, 2})), Abort::sequence) << "two were sent";
  EXPECT_EQ(rig.get_real(gain), 0.F);
}

/// One object of any length, that a client may write.
class Notes final : public Dictionary {
 public:
  Bytes bytes;
  Abort find(Key /*key*/, Entry& entry) const override {
    entry = {{0x2000, 0},
             Type::domain,
             readable | writable,
             0,
             static_cast<std::uint32_t>(bytes.size())};
    return Abort::none;
  }
  Abort read(const Entry& /*entry*/, std::uint32_t /*offset*/,
             std::span<std::uint8_t> /*to*/) override {
    return Abort::no_data;
  }
  Abort write(const Entry& /*entry*/, std::span<const std::uint8_t> from,
              Source /*source*/) override {
    bytes.assign(from.begin(), from.end());
    return Abort::none;
  }
};

TEST(Sdo, WhatIsLongerThanTheBufferIsRefused) {
  using Request = std::array<std::uint8_t, 8>;
  Notes notes;
  std::array<std::uint8_t, 16> buffer{};
  SdoServer server(notes, buffer);
  const auto ask = [&](const Request& request) {
    Request answer{};
    server.receive(request, 0);
    server.take(answer);
    return abort_in(Bytes(answer.begin(), answer.end()));
  };
  EXPECT_EQ(ask({0x21, 0, 0x20, 0, 17}), Abort::memory) << "by segments, announced";
  EXPECT_EQ(ask({0xC2, 0, 0x20, 0, 17}), Abort::memory) << "as a block, announced";
  EXPECT_EQ(ask({0x20, 0, 0x20, 0}), Abort::none) << "without saying how long";
  EXPECT_EQ(ask({0x00}), Abort::none);
  EXPECT_EQ(ask({0x10}), Abort::none);
  EXPECT_EQ(ask({0x00}), Abort::memory) << "the 21st byte";
  EXPECT_TRUE(notes.bytes.empty());
  EXPECT_EQ(ask({0x21, 0, 0x20, 0, 7}), Abort::none);
  EXPECT_EQ(ask({0x01, 1, 2, 3, 4, 5, 6, 7}), Abort::none);
  EXPECT_EQ(notes.bytes, (Bytes{1, 2, 3, 4, 5, 6, 7}));
}

TEST(Sdo, AnAbortOfTheClientIsNotAnswered) {
  ServoRig rig;
  rig.ask(ServoRig::named(0x40, name));
  rig.send(0x601, Bytes(8, 0x80));
  rig.run(2000);
  EXPECT_TRUE(rig.take(0x581).empty());
}

TEST(Sdo, FramesOfAnotherLengthAreNone) {
  ServoRig rig;
  rig.send(0x601, {0x40, 0x17, 0x10, 0});
  rig.run(5);
  EXPECT_TRUE(rig.take(0x581).empty());
}

/// A block upload as a client runs it that loses segments at random.
Bytes block_upload(ServoRig& rig, Key object, std::uint8_t block, std::mt19937& random,
                   double loss) {
  Bytes request = ServoRig::named(0xA4, object);
  request.push_back(block);
  const std::optional<Bytes> first = rig.ask(request);
  if (!first || first->at(0) != 0xC6) {
    return {};
  }
  const auto size = take_number(std::span(*first).subspan(4));
  rig.send(0x601, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  Bytes data;
  std::bernoulli_distribution lost(loss);
  for (int round = 0; round < 10000; ++round) {
    std::uint8_t good = 0;
    for (const hal::CanFrame& f : rig.take(0x581)) {
      if ((f.data[0] & 0x7FU) == good + 1U && !lost(random)) {
        ++good;
        data.insert(data.end(), f.data.begin() + 1, f.data.end());
      }
    }
    const Bytes ack{0xA2, good, block, 0, 0, 0, 0, 0};
    rig.send(0x601, ack);
    const auto peek = rig.sent;
    if (!peek.empty() && (peek.front().data[0] & 0xE3U) == 0xC1 && size <= data.size()) {
      const hal::CanFrame end = rig.take(0x581).at(0);
      data.resize(size);
      EXPECT_EQ(take_number(std::span(end.data).subspan(1, 2)), crc16(data));
      EXPECT_EQ(end.data[0] >> 2U & 7U, (7 - size % 7) % 7);
      rig.send(0x601, {0xA1, 0, 0, 0, 0, 0, 0, 0});
      return data;
    }
  }
  return {};
}

/// What the recorder has taken, by blocks of any size over a bus that loses segments.
TEST(Sdo, BlockUploadsSurviveLostSegments) {
  ServoRig rig;
  std::mt19937 random(7);
  ASSERT_EQ(rig.set({0x2300, 1}, 1, 1), Abort::none);
  rig.run(1100);
  ASSERT_EQ(rig.get({0x2300, 2}), 3U);
  rig.sent.clear();
  const Bytes expected = rig.upload({0x2300, 11}).data;
  ASSERT_EQ(expected.size(), 4096U * 4U);
  for (const std::uint8_t block : Bytes{1, 2, 7, 64, 127}) {
    rig.sent.clear();
    EXPECT_EQ(block_upload(rig, {0x2300, 11}, block, random, 0), expected) << int{block};
    rig.sent.clear();
    EXPECT_EQ(block_upload(rig, {0x2300, 11}, block, random, 0.1), expected) << int{block};
  }
}

TEST(Sdo, WhatIsEmptyComesAsAnEmptyBlock) {
  ServoRig rig;
  ASSERT_EQ(rig.ask({0xA4, 0x20, 0x22, 2, 127, 0}), (Bytes{0xC6, 0x20, 0x22, 2, 0, 0, 0, 0}))
      << "without being asked it does not leave the protocol";
  rig.send(0x601, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  const auto segments = rig.take(0x581);
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_EQ(segments[0].data[0], 0x81);
  EXPECT_EQ(rig.ask({0xA2, 1, 127}), (Bytes{0xC1 | 7U << 2U, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Sdo, ASmallObjectMayLeaveTheBlockProtocol) {
  ServoRig rig;
  EXPECT_EQ(rig.ask({0xA4, 0x17, 0x10, 0, 20, 8}), (Bytes{0x4B, 0x17, 0x10, 0, 0, 0, 0, 0}));
}

TEST(Sdo, AStoreIsAnsweredWhenItIsDurable) {
  ServoRig rig;
  rig.answers = false;
  Bytes request = ServoRig::named(0x23, {0x1010, 1});
  const Bytes save = little(store_signature, 4);
  request.insert(request.end(), save.begin(), save.end());
  rig.send(0x601, request);
  rig.run(3000);
  EXPECT_TRUE(rig.take(0x581).empty()) << "no answer and no time-out before";
  rig.answers = true;
  rig.run(1);
  const auto answers = rig.take(0x581);
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].data[0], 0x60);
  rig.storage_works = false;
  EXPECT_EQ(rig.set({0x1010, 1}, store_signature, 4), Abort::hardware);
}

}  // namespace
}  // namespace smaservo::canopen::sdo_server_test
