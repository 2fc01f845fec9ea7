#include "hal/linux/can/can_datagram.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>

namespace smaservo::can_datagram_test {
namespace {

using nlohmann::json;

std::vector<std::uint8_t> bytes(std::string_view hex) {
  std::vector<std::uint8_t> result;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    result.push_back(
        static_cast<std::uint8_t>(std::stoul(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return result;
}

// What python-can 4.1 sends for frames of several kinds.
constexpr const char* request =
    "8ba974696d657374616d70cb3ff8000000000000ae6172626974726174696f6e5f6964cd0601ae69735f657874656e"
    "6465645f6964c2af69735f72656d6f74655f6672616d65c2ae69735f6572726f725f6672616d65c2a76368616e6e65"
    "6cc0a3646c6308a464617461c4084000100000000000a569735f6664c2ae626974726174655f737769746368c2b565"
    "72726f725f73746174655f696e64696361746f72c2";
constexpr const char* remote =
    "8ba974696d657374616d70cb3ff8000000000000ae6172626974726174696f6e5f6964cd0701ae69735f657874656e"
    "6465645f6964c2af69735f72656d6f74655f6672616d65c3ae69735f6572726f725f6672616d65c2a76368616e6e65"
    "6cc0a3646c6301a464617461c400a569735f6664c2ae626974726174655f737769746368c2b56572726f725f737461"
    "74655f696e64696361746f72c2";
constexpr const char* extended =
    "8ba974696d657374616d70cb3ff8000000000000ae6172626974726174696f6e5f6964ce1abcdef0ae69735f657874"
    "656e6465645f6964c3af69735f72656d6f74655f6672616d65c2ae69735f6572726f725f6672616d65c2a76368616e"
    "6e656ca178a3646c6301a464617461c40101a569735f6664c2ae626974726174655f737769746368c2b56572726f72"
    "5f73746174655f696e64696361746f72c2";

TEST(CanDatagram, ReadsWhatPythonCanSends) {
  EXPECT_EQ(hal::from_datagram(bytes(request)),
            (hal::CanFrame{.id = 0x601, .length = 8, .data = {0x40, 0x00, 0x10}}));
  EXPECT_EQ(hal::from_datagram(bytes(remote)),
            (hal::CanFrame{.id = 0x701, .remote = true, .length = 1}));
  EXPECT_EQ(hal::from_datagram(bytes(extended)),
            (hal::CanFrame{.id = 0x1ABCDEF0, .extended = true, .length = 1, .data = {1}}));
}

hal::CanFrame random_frame(std::mt19937& random) {
  hal::CanFrame frame;
  frame.extended = random() % 2 == 0;
  frame.remote = random() % 4 == 0;
  frame.id = static_cast<std::uint32_t>(random() & (frame.extended ? 0x1FFFFFFF : 0x7FF));
  frame.length = static_cast<std::uint8_t>(random() % 9);
  for (std::size_t i = 0; !frame.remote && i < frame.length; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(random());
  }
  return frame;
}

TEST(CanDatagram, GivesBackWhatItWrites) {
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    const hal::CanFrame frame = random_frame(random);
    EXPECT_EQ(hal::from_datagram(hal::to_datagram(frame, 1.5)), frame);
  }
}

// The attributes of python-can's Message, of the types that its constructor takes.
TEST(CanDatagram, HasTheKeysOfPythonCan) {
  const auto ours = json::from_msgpack(hal::to_datagram({.id = 0x601, .length = 8}, 2.25));
  const auto theirs = json::from_msgpack(bytes(request));
  ASSERT_EQ(ours.size(), theirs.size());
  for (const auto& [key, value] : theirs.items()) {
    ASSERT_TRUE(ours.contains(key)) << key;
    EXPECT_EQ(ours[key].type(), value.type()) << key;
  }
  EXPECT_EQ(ours["timestamp"], 2.25);
}

struct Change {
  const char* key;
  json value;
};

TEST(CanDatagram, RefusesWhatIsNoFrameOfClassicCan) {
  const Change changes[] = {
      {"arbitration_id", 0x800},
      {"arbitration_id", -1},
      {"arbitration_id", "601"},
      {"arbitration_id", 1.0},
      {"dlc", 9},
      {"dlc", 7},
      {"dlc", nullptr},
      {"data", "12345678"},
      {"data", json::binary({1, 2, 3})},
      {"data", nullptr},
      {"is_error_frame", true},
      {"is_fd", true},
      {"is_extended_id", 1},
      {"is_remote_frame", nullptr},
  };
  for (const Change& change : changes) {
    auto map = json::from_msgpack(bytes(request));
    map[change.key] = change.value;
    EXPECT_FALSE(hal::from_datagram(json::to_msgpack(map))) << change.key << ' ' << change.value;
  }
  for (const char* key : {"arbitration_id", "dlc", "data"}) {
    auto map = json::from_msgpack(bytes(request));
    map.erase(key);
    EXPECT_FALSE(hal::from_datagram(json::to_msgpack(map))) << key;
  }
}

// Whatever it is, what comes out is a frame within CAN's limits.
TEST(CanDatagram, SurvivesBrokenDatagrams) {
  std::mt19937 random(11);
  const auto whole = bytes(request);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(hal::from_datagram(std::span(whole).first(size))) << size;
  }
  auto longer = whole;
  longer.push_back(0);
  EXPECT_FALSE(hal::from_datagram(longer));
  EXPECT_FALSE(hal::from_datagram(std::vector<std::uint8_t>(4096, 0x91)));
  for (int i = 0; i < 50000; ++i) {
    auto broken = whole;
    for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
      broken[random() % broken.size()] = static_cast<std::uint8_t>(random());
    }
    if (const auto frame = hal::from_datagram(broken)) {
      EXPECT_LE(frame->length, 8);
      EXPECT_LE(frame->id, frame->extended ? 0x1FFFFFFFU : 0x7FFU);
    }
  }
}

}  // namespace
}  // namespace smaservo::can_datagram_test
