#include <array>
#include <gmock/gmock.h>
#include <random>
#include <utility>

#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/outcome.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/status.hpp"
#include "tests/host-sim/can/can_client.hpp"

namespace smaservo::can {
namespace {

using test::SimulatedBus;
using testing::HasSubstr;

/// A node that has every object, with random values of random lengths.
class AnyNode final : public Bus {
 public:
  explicit AnyNode(unsigned seed) : random_(seed) {}
  void send(const hal::CanFrame& frame) override {
    if (frame.id != 0x601 || frame.data[0] != 0x40) {
      return;
    }
    const auto length = static_cast<unsigned>(random_() % 4 + 1);
    answer_ = {.id = 0x581, .length = 8, .data = frame.data};
    answer_.data[0] = static_cast<std::uint8_t>(0x43U | (4 - length) << 2U);
    constexpr std::array<std::uint64_t, 6> values{0, 3, 0xFF, 0x7FC00000, 0xFF800000, 0x71000000};
    const std::uint64_t value = random_() % 2 == 0 ? values.at(random_() % 6) : random_();
    canopen::put_number(std::span(answer_.data).subspan(4, length), value);
    waits_ = true;
  }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    frame = answer_;
    now_us_ = waits_ ? now_us_ : std::max(now_us_, until_us);
    return std::exchange(waits_, false);
  }
  std::int64_t now_us() const override { return now_us_; }
  std::string name() const override { return "any"; }

 private:
  std::mt19937 random_;
  hal::CanFrame answer_;
  bool waits_ = false;
  std::int64_t now_us_ = 0;
};

TEST_F(CanClient, AllKindsOfTransfersGiveTheSame) {
  const Bytes name = client.upload({0x1008, 0});
  EXPECT_EQ(std::string(name.begin(), name.end()), "smaservo");
  EXPECT_EQ(client.upload_block({0x1008, 0}), name);
  client.download(gain, real_bytes(3));
  EXPECT_EQ(client.upload(gain), real_bytes(3));
  client.download_segmented(gain, real_bytes(4));
  EXPECT_EQ(client.upload(gain), real_bytes(4));
  client.download_block(gain, real_bytes(5));
  EXPECT_EQ(client.upload_block(gain), real_bytes(5));
}

TEST_F(CanClient, SaysWhatTheNodeRefuses) {
  EXPECT_THAT(refusal([&] { client.upload({0x1FFF, 0}); }),
              HasSubstr("1FFFh:0: refused: no such object (abort 06020000h)"));
  EXPECT_THAT(refusal([&] { remote.set("limits.current_mA", "99000"); }),
              HasSubstr("value too high (abort 06090031h); must be 1 to 20000 mA"));
  EXPECT_EQ(remote.number("limits.current_A"), static_cast<double>(0.4F));
  SdoClient nobody(bus, 9);
  EXPECT_THAT(refusal([&] { nobody.upload({0x1000, 0}); }),
              HasSubstr("node 9 on sim: 1000h:0: no answer within 0.5 s"));
}

// The first answer of a read may be lost; a write is not done twice.
TEST_F(CanClient, AsksForAReadAgain) {
  bus.lose_answer(1);
  EXPECT_EQ(client.upload({0x1008, 0}).size(), 8U);
  bus.lose_answer(1);
  EXPECT_EQ(client.upload_block({0x1008, 0}).size(), 8U);
  const std::uint32_t changes = remote.whole("2220:1");
  bus.lose_answer(1);
  EXPECT_THAT(refusal([&] { client.download(gain, real_bytes(6)); }), HasSubstr("no answer"));
  EXPECT_EQ(remote.whole("2220:1"), changes + 1);
}

// An answer that is lost costs this transfer, not the next one.
TEST_F(CanClient, GoesOnAfterALostAnswer) {
  for (int lost = 2; lost <= 3; ++lost) {
    bus.lose_answer(lost);
    EXPECT_THROW(client.upload({0x1008, 0}), SdoError) << lost;
    bus.lose_answer(0);
    EXPECT_EQ(client.upload({0x1008, 0}).size(), 8U);
  }
}

// A segment of a block that is lost is asked for again.
TEST_F(CanClient, BlocksRepeatWhatWasLost) {
  const RecordingPlan plan{{"wire_temperature_K", "position_m"}, 0.5, 0, ""};
  arm_recorder(remote, plan);
  run(0.6);
  remote.set("recorder.command", "0");
  const Bytes whole = client.upload_block({0x2300, 11});
  ASSERT_GT(whole.size(), 4000U);
  for (const int lost : {2, 60, 128, 129, 300}) {
    bus.lose_answer(lost);
    EXPECT_EQ(client.upload_block({0x2300, 11}), whole) << lost;
  }
}

TEST_F(CanClient, SetsAreInForceTogetherOrNotAtAll) {
  remote.change({change("limits.current_mA", "300"), change("strain.proportional_W", "6")});
  EXPECT_EQ(remote.text("limits.current_mA"), "300");
  EXPECT_EQ(remote.number("strain.proportional_W"), 6);
  const std::string why = refusal([&] {
    remote.change({change("limits.current_A", "0.55"), change("trips.current_A", "0.3")});
  });
  EXPECT_THAT(why, HasSubstr("nothing has changed: limits.current_A (2020h:2) = 0.55"));
  EXPECT_EQ(remote.text("limits.current_mA"), "300");
  EXPECT_EQ(remote.text("tuning.state"), "0");
}

TEST_F(CanClient, SettingsComeBackFromAFile) {
  const Settings<double> before = read_settings(remote);
  EXPECT_TRUE(same_settings(before, stored_settings<double>(bus.servo().servo().settings())));
  remote.set("limits.power_W", "1.25");
  const auto all = differences(before, read_settings(remote));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].row->path.text(), "limits.power_W");
  restore(remote, all);
  EXPECT_TRUE(differences(before, read_settings(remote)).empty());
}

// What is a state, a count or bits is one in the answer, or the answer is refused in words. The
// undefined-behaviour sanitizer sees a conversion of what is none.
TEST_F(CanClient, ANodeMayAnswerAnything) {
  int told = 0;
  int not_whole = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    AnyNode any(seed);
    Remote other(SdoClient(any, 1));
    const std::string refused = refusal([&] {
      switch (seed % 6) {
        case 0:
          info_text(other, Units::bench);
          break;
        case 1:
          faults_text(other);
          break;
        case 2:
          other.enable();
          break;
        case 3:
          other.hold(0.1);
          break;
        case 4:
          read_recording(other, {{"strain"}, 1, 0, ""});
          break;
        default:
          first_cause(other);
          break;
      }
    });
    told += refused.empty() ? 1 : 0;
    not_whole += refused.find("must be a whole number") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(told, 20);
  EXPECT_GT(not_whole, 500);
}

TEST_F(CanClient, TellsWhatWasWrittenAndRefused) {
  EXPECT_EQ(changes_text(remote), "none\n");
  remote.set("strain.proportional_W", "3");
  EXPECT_THROW(remote.set("6060", "9"), SdoError);
  const std::string text = changes_text(remote);
  const std::size_t gain_at = text.find("strain.proportional_W (2100h:1): 0 -> 3, by SDO\n");
  const std::size_t mode_at =
      text.find("Modes of operation (6060h:0): stays 0; 9 by SDO is refused");
  EXPECT_LT(gain_at, mode_at) << text;
  EXPECT_NE(mode_at, std::string::npos) << text;
}

TEST_F(CanClient, MovesAndStops) {
  run(0.5);
  EXPECT_THAT(refusal([&] { remote.move(800, 5); }), HasSubstr("is not enabled"));
  remote.enable();
  remote.move(800, 5);
  EXPECT_NEAR(remote.number("6064"), 800, 120);
  EXPECT_GT(bus.servo().rig().flowing_A, 0);
  remote.disable();
  run(0.01);
  EXPECT_EQ(bus.servo().rig().flowing_A, 0);
}

TEST_F(CanClient, FindsWhoIsThere) {
  const FoundNodes found = scan(bus, 200'000);
  ASSERT_EQ(found.nodes.size(), 1U);
  EXPECT_EQ(found.nodes[0].node, SimulatedBus::node);
  EXPECT_EQ(found.nodes[0].device_type & 0xFFFFU, 402U);
  EXPECT_FALSE(found.without_id);
  EXPECT_THAT(info_text(remote, Units::bench), HasSubstr("Switch on disabled"));
  EXPECT_THAT(faults_text(remote), testing::ContainsRegex("\nlatched  *none\n"));
}

}  // namespace
}  // namespace smaservo::can
