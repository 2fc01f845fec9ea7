// Garbage of every kind: the wire is never heated without Operation enabled, and a reset of the
// node brings it back.

#include <gtest/gtest.h>
#include <set>

#include "tests/firmware/canopen/servo/frame_feeder.hpp"

namespace smaservo::canopen::random_frames_test {
namespace {

#ifdef SMASERVO_SANITIZED
constexpr int runs = 30;
#else
constexpr int runs = 200;
#endif

Bytes random_bytes(std::mt19937& random, std::size_t size) {
  Bytes bytes(size);
  std::ranges::generate(bytes, [&] { return static_cast<std::uint8_t>(random()); });
  return bytes;
}

ServoConfig with_ceilings(const Settings<double>& settings) {
  ServoConfig config;
  config.ceilings = ceilings_at(settings);
  return config;
}

TEST(RandomFrames, OfEachService) {
  std::mt19937 random(20);
  const Settings<double> settings = reference_settings();
  for (const Service service :
       {Service::sdo, Service::pdo, Service::lss, Service::nmt, Service::all}) {
    for (int i = 0; i < runs; ++i) {
      ServoRig rig(with_ceilings(settings), settings);
      FrameFeeder feeder(rig, service);
      ASSERT_TRUE(feeder.feed(random_bytes(random, 2000))) << i;
      ASSERT_TRUE(feeder.comes_back()) << static_cast<int>(service) << ' ' << i;
    }
  }
}

/// What a master really says, as service, identifier and data; garbage rarely gets so far.
struct Said {
  std::uint32_t id;
  Bytes data;
};

std::vector<Said> conversation() {
  std::vector<Said> said{{0, {1, 1}}};
  const auto sdo = [&](Bytes request) {
    request.resize(8);
    said.push_back({0x601, request});
  };
  sdo({0x2F, 0x60, 0x60, 0, 1});
  for (const std::uint8_t word : Bytes{6, 7, 15, 31, 15, 2, 0x80, 6, 7, 15}) {
    sdo({0x2B, 0x40, 0x60, 0, word});
    said.push_back({0x201, {word, 0, 1}});
    said.push_back({0x301, {100, 0, 0, 0, 0, 0, 0, 0}});
    said.push_back({0x80, {}});
  }
  sdo({0x2B, 0x5A, 0x60, 0, 6});
  sdo({0x2B, 0x5E, 0x60, 0, 2});
  sdo({0x2F, 0x02, 0x21, 1, 1});
  sdo({0x23, 0x00, 0x21, 1, 0, 0, 0x80, 0x3F});
  sdo({0x2F, 0x02, 0x21, 1, 2});
  sdo({0x2F, 0x00, 0x23, 1, 1});
  // Limits and trips upwards: 0.5 A, 4 W, 450 K, 400 MPa, and what was stored or given comes back.
  sdo({0x23, 0x20, 0x20, 2, 0, 0, 0, 0x3F});
  sdo({0x23, 0x20, 0x20, 3, 0, 0, 0x80, 0x40});
  sdo({0x23, 0x20, 0x20, 4, 0, 0, 0xE1, 0x43});
  sdo({0x23, 0x20, 0x20, 8, 0x20, 0xBC, 0xBE, 0x4D});
  sdo({0x23, 0x21, 0x20, 1, 0, 0, 0, 0x3F});
  sdo({0x23, 0x21, 0x20, 2, 0, 0, 0xE1, 0x43});
  sdo({0x2F, 0x02, 0x21, 1, 3});
  sdo({0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
  sdo({0x23, 0x11, 0x10, 1, 'l', 'o', 'a', 'd'});
  sdo({0xA4, 0x08, 0x10, 0, 127, 0});
  sdo({0xA3});
  sdo({0xA2, 2, 127});
  sdo({0xA1});
  sdo({0x40, 0x08, 0x10, 0});
  sdo({0x60});
  sdo({0x70});
  said.push_back({0x710, {5}});
  said.push_back({0x7E5, {4, 1, 0, 0, 0, 0, 0, 0}});
  said.push_back({0x7E5, {4, 0, 0, 0, 0, 0, 0, 0}});
  said.push_back({0, {0x81, 1}});
  return said;
}

TEST(RandomFrames, AConversationWithFlippedBitsLossAndRepetition) {
  std::mt19937 random(21);
  const Settings<double> settings = reference_settings();
  const std::vector<Said> said = conversation();
  int heated = 0;
  std::set<DriveState> seen;
  for (int i = 0; i < runs; ++i) {
    ServoRig rig(with_ceilings(settings), settings);
    FrameFeeder feeder(rig, Service::all);
    rig.run(120);
    std::size_t at = 0;
    for (int k = 0; k < 300; ++k) {
      at = random() % 10 == 0 ? random() % said.size() : (at + 1) % said.size();
      hal::CanFrame f = frame(said[at].id, said[at].data);
      if (random() % 4 == 0) {
        f.data[random() % 8] ^= static_cast<std::uint8_t>(1U << random() % 8);
      }
      if (random() % 20 == 0) {
        f.length = static_cast<std::uint8_t>(random() % 9);
      }
      if (random() % 50 == 0) {
        rig.device.faults = FaultSet::from_bits(1ULL << (1 + random() % (fault_count - 1)));
      } else if (random() % 10 == 0) {
        rig.device.faults = {};
      }
      rig.servo.receive(f, rig.now_us);
      ASSERT_TRUE(feeder.feed(Bytes{static_cast<std::uint8_t>(random() % 32)})) << i << ' ' << k;
      heated += rig.output.drive_current_A != 0 ? 1 : 0;
      seen.insert(rig.state());
    }
    rig.device.faults = {};
    ASSERT_TRUE(feeder.comes_back()) << i;
  }
  EXPECT_LT(runs, heated) << "or nothing was tried";
  EXPECT_EQ(seen.size(), 8U) << "each state has been met";
}

}  // namespace
}  // namespace smaservo::canopen::random_frames_test
