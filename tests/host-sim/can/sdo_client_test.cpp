// What a node may do to a client that reads and writes its objects: it may break off, be slow, say
// nonsense. It never keeps the client for ever, and never fills its memory.

#include "host-sim/can/sdo_client.hpp"

#include <deque>
#include <functional>
#include <gmock/gmock.h>
#include <random>

#include "firmware/canopen/node/object.hpp"

namespace smaservo::can {
namespace {

using testing::HasSubstr;
using Data = std::array<std::uint8_t, 8>;

constexpr unsigned node = 9;
constexpr Key key{0x2300, 11};

/// A node in virtual time, which answers a request by what `answers` says, each a millisecond later
/// than the one before or `delay_us` later.
class OddNode final : public Bus {
 public:
  std::function<std::vector<Data>(const Data& request)> answers;
  std::int64_t delay_us = 1000;
  std::size_t requests = 0;
  std::uint32_t abort_code = 0;  ///< what the client has broken off with

  void send(const hal::CanFrame& frame) override {
    ++requests;
    if (frame.data[0] == 0x80) {
      abort_code =
          static_cast<std::uint32_t>(canopen::take_number(std::span(frame.data).subspan(4)));
      return;
    }
    for (const Data& data : answers(frame.data)) {
      waiting_.push_back(data);
    }
  }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    if (waiting_.empty() || now_us_ + delay_us > until_us) {
      now_us_ = std::max(now_us_, until_us);
      return false;
    }
    now_us_ += delay_us;
    frame = {.id = 0x580 + node, .length = 8, .data = waiting_.front()};
    waiting_.pop_front();
    return true;
  }
  std::int64_t now_us() const override { return now_us_; }
  std::string name() const override { return "odd"; }

 private:
  std::int64_t now_us_ = 1;
  std::deque<Data> waiting_;
};

/// The first byte of an answer that has the object's key, and a number.
Data keyed(unsigned first, std::uint32_t number = 0) {
  Data data{static_cast<std::uint8_t>(first)};
  canopen::put_number(std::span(data).subspan(1, 2), key.index);
  data[3] = key.sub;
  canopen::put_number(std::span(data).subspan(4), number);
  return data;
}

struct CanSdoClient : testing::Test {
  OddNode bus;
  SdoClient client{bus, node};

  template <class F>
  std::string failure(F f) {
    try {
      f();
    } catch (const SdoError& error) {
      return error.what();
    }
    return "";
  }
  std::string upload() {
    return failure([&] { client.upload(key); });
  }
  std::string upload_block() {
    return failure([&] { client.upload_block(key); });
  }
  std::string download_block() {
    return failure([&] { client.download_block(key, Bytes(100, 7)); });
  }
  /// Segments of an upload, each of so many bytes, without end.
  void sends_without_end(std::uint8_t first, std::uint32_t announced, unsigned bytes) {
    bus.answers = [=](const Data& request) -> std::vector<Data> {
      if (request[0] == 0x40) {
        return {keyed(first, announced)};
      }
      return {Data{static_cast<std::uint8_t>((request[0] & 0x10U) | (7 - bytes) << 1U)}};
    };
  }
};

TEST_F(CanSdoClient, EndsAnUploadWithoutEnd) {
  sends_without_end(0x40, 0, 7);
  EXPECT_THAT(upload(), HasSubstr("too long"));
  EXPECT_EQ(bus.abort_code, 0x06070012U);
  EXPECT_LT(bus.requests, (std::size_t{1} << 20U) / 7 + 10);
}

TEST_F(CanSdoClient, EndsAnUploadThatIsLongerThanItSays) {
  sends_without_end(0x41, 20, 7);
  EXPECT_THAT(upload(), HasSubstr("too long"));
  EXPECT_LE(bus.requests, 5U);
}

/// Each request is answered twice, so that the second segment comes when the first is expected.
TEST_F(CanSdoClient, SaysThatTwoDevicesAnswer) {
  bool two = true;
  bus.answers = [&](const Data& request) -> std::vector<Data> {
    Data answer = keyed(0x43, 7);
    if (request[0] == 0x40 && request[2] != 0x10) {
      answer = keyed(0x41, 20);
    } else if (request[0] == 0x40) {
      std::ranges::copy(std::span(request).subspan(1, 3), answer.begin() + 1);
    } else {
      answer = keyed(0x80, 0x05040001);
    }
    return two ? std::vector<Data>{answer, answer} : std::vector<Data>{answer};
  };
  EXPECT_THAT(upload(), HasSubstr("two devices answer as node 9"));
  two = false;
  EXPECT_THAT(upload(), HasSubstr("unknown SDO command"));
}

TEST_F(CanSdoClient, EndsAnUploadOfEmptySegments) {
  sends_without_end(0x40, 0, 0);
  EXPECT_THAT(upload(), HasSubstr("waited too long"));
  EXPECT_LE(bus.requests, 4U);
}

TEST_F(CanSdoClient, EndsAnUploadByteByByte) {
  sends_without_end(0x40, 0, 1);
  bus.delay_us = 499'000;
  EXPECT_THAT(upload(), HasSubstr("waited too long"));
  EXPECT_LT(bus.now_us(), 20'000'000);
}

TEST_F(CanSdoClient, TakesNoValueOfGigabytes) {
  sends_without_end(0x41, 0xFFFFFFFF, 7);
  EXPECT_THAT(upload(), HasSubstr("out of memory"));
  EXPECT_LE(bus.requests, 2U);
  bus.answers = [](const Data&) -> std::vector<Data> { return {keyed(0xC2, 0xFFFFFFFF)}; };
  EXPECT_THAT(upload_block(), HasSubstr("out of memory"));
}

// A node that takes nearly all of its time for each full segment is slow, not wrong.
TEST_F(CanSdoClient, WaitsForANodeThatIsSlow) {
  constexpr std::uint32_t size = 700;
  bus.delay_us = 490'000;
  unsigned sent = 0;
  bus.answers = [&](const Data& request) -> std::vector<Data> {
    if (request[0] == 0x40) {
      return {keyed(0x41, size)};
    }
    sent += 7;
    return {Data{static_cast<std::uint8_t>((request[0] & 0x10U) | (sent == size ? 1U : 0U)), 1, 2,
                 3, 4, 5, 6, 7}};
  };
  EXPECT_EQ(client.upload(key).size(), size);
}

// Another client writes, or reads in blocks, the object that this one reads, and the other way
// round.
TEST_F(CanSdoClient, TakesNoAnswerToARequestOfAnotherKind) {
  bus.answers = [](const Data& request) -> std::vector<Data> {
    const std::vector<Data> all{keyed(0x43, 7), keyed(0x60), keyed(0xC2, 4), keyed(0xA4)};
    const std::size_t own = request[0] == 0x40 ? 0 : 1;
    std::vector<Data> answers;
    std::ranges::copy_if(all, std::back_inserter(answers),
                         [&](const Data& data) { return data != all[own]; });
    answers.push_back(all[own]);
    return answers;
  };
  EXPECT_EQ(client.upload(key), (Bytes{7, 0, 0, 0}));
  EXPECT_NO_THROW(client.download(key, Bytes{1, 0, 0, 0}));
  EXPECT_EQ(bus.abort_code, 0U) << "which would end the other client's transfer";
}

// A node answers the later of two requests that meet: the other client's, at first.
TEST_F(CanSdoClient, AsksAgainWhereAnotherClientWasAnswered) {
  unsigned others = 1;
  bus.answers = [&](const Data& request) -> std::vector<Data> {
    if (others > 0) {
      --others;
      Data other = keyed(0x43, 5);
      other[3] = key.sub + 1;
      return {other};
    }
    return {request[0] == 0x40 ? keyed(0x43, 7) : keyed(0x60)};
  };
  EXPECT_EQ(client.upload(key), (Bytes{7, 0, 0, 0}));
  EXPECT_EQ(bus.requests, 2U);
  others = 2;
  EXPECT_THAT(upload(), HasSubstr("no answer within 0.5 s, asked twice"));
  EXPECT_EQ(bus.requests, 4U);
  // What is written may have been done, with its answer lost.
  others = 1;
  EXPECT_THAT(failure([&] { client.download(key, Bytes{1}); }),
              HasSubstr("no answer within 0.5 s"));
  EXPECT_EQ(bus.requests, 5U);
}

/// The segments of a block whose numbers begin at `first` and do not rise.
std::vector<Data> same_segments(std::uint8_t number, int count) {
  return std::vector<Data>(static_cast<std::size_t>(count), Data{number, 1, 2, 3, 4, 5, 6, 7});
}

TEST_F(CanSdoClient, EndsABlockUploadWithoutNews) {
  for (const int number : {5, 0, 0x80 | 5}) {
    bus.answers = [=](const Data& request) -> std::vector<Data> {
      if ((request[0] & 0xE3U) == 0xA0) {
        return {keyed(0xC0)};
      }
      return same_segments(static_cast<std::uint8_t>(number), 1000);
    };
    EXPECT_THAT(upload_block(), HasSubstr("invalid sequence number")) << number;
    EXPECT_EQ(bus.abort_code, 0x05040003U);
    EXPECT_LE(bus.requests, 6U);
    bus = {};
  }
}

TEST_F(CanSdoClient, EndsABlockUploadWithoutEnd) {
  bus.answers = [](const Data& request) -> std::vector<Data> {
    if ((request[0] & 0xE3U) == 0xA0) {
      return {keyed(0xC0)};
    }
    std::vector<Data> block;
    for (std::uint8_t i = 1; i <= 127; ++i) {
      block.push_back(same_segments(i, 1).front());
    }
    return block;
  };
  EXPECT_THAT(upload_block(), HasSubstr("too long"));
  EXPECT_LT(bus.requests, (std::size_t{1} << 20U) / (std::size_t{127} * 7) + 10);
}

TEST_F(CanSdoClient, EndsABlockUploadOfANodeThatIsGone) {
  bus.answers = [](const Data& request) -> std::vector<Data> {
    if ((request[0] & 0xE3U) == 0xA0) {
      return {keyed(0xC2, 5000)};
    }
    if (request[0] == 0xA3) {
      return same_segments(1, 1);
    }
    return {};
  };
  EXPECT_THAT(upload_block(), HasSubstr("no answer within 0.5 s"));
  EXPECT_LT(bus.now_us(), 5'000'000);
}

TEST_F(CanSdoClient, EndsABlockDownloadThatIsNeverTaken) {
  bus.answers = [](const Data& request) -> std::vector<Data> {
    if ((request[0] & 0xE1U) == 0xC0 && request[1] == (key.index & 0xFFU)) {
      return {keyed(0xA4, 10)};
    }
    // The tenth segment ends a block: none of it is acknowledged.
    return request[0] == 10 ? std::vector<Data>{Data{0xA2, 0, 10}} : std::vector<Data>{};
  };
  EXPECT_THAT(download_block(), HasSubstr("invalid sequence number"));
  EXPECT_LE(bus.requests, 40U);
}

// Answers at random: whatever a node says, each call ends, in bounded time.
TEST_F(CanSdoClient, EndsWhateverANodeSays) {
  std::mt19937 random(20);
  const auto byte = [&] { return static_cast<std::uint8_t>(random()); };
  for (int i = 0; i < 2000; ++i) {
    const std::uint8_t command = byte();
    bus.answers = [&](const Data& request) {
      std::vector<Data> all(random() % 4);
      for (Data& data : all) {
        const bool fits = random() % 4 != 0;
        data = fits ? keyed(request[0] == 0x40 ? 0x40U : command, byte()) : Data{byte(), byte()};
      }
      return all;
    };
    const std::int64_t start_us = bus.now_us();
    upload();
    upload_block();
    download_block();
    failure([&] { client.download_segmented(key, Bytes(20, 1)); });
    ASSERT_LT(bus.now_us() - start_us, 60'000'000) << i;
  }
}

}  // namespace
}  // namespace smaservo::can
