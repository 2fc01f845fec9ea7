#include <array>
#include <cmath>
#include <gmock/gmock.h>
#include <random>
#include <utility>

#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/status.hpp"
#include "host-sim/can/step_test.hpp"
#include "host-sim/can/watch.hpp"
#include "host-sim/report/text_plot.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/can/simulated_bus.hpp"

namespace smaservo::can {
namespace {

using test::SimulatedBus;
using testing::HasSubstr;

constexpr Key gain{0x2100, 1};

struct CanClient : testing::Test {
  SimulatedBus bus;
  SdoClient client{bus, SimulatedBus::node};
  Remote remote{client};

  void run(double seconds) {
    hal::CanFrame passing;
    const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(seconds * 1e6);
    while (bus.receive(passing, until_us)) {
    }
  }
  template <class F>
  static std::string refusal(F f) {
    try {
      f();
    } catch (const files::UserError& error) {
      return error.what();
    }
    return "";
  }
};

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

Bytes real_bytes(float value) {
  Bytes bytes(4);
  canopen::put_number(bytes, canopen::as_bits(value));
  return bytes;
}

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
  const auto change = [](const char* name, const char* value) {
    const text::KnownObject object = text::find_object(name);
    return Change(object, text::value_bytes(object, value));
  };
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
          info_text(other);
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

TEST_F(CanClient, JudgesAStep) {
  run(0.5);
  const StepRun step = run_step(remote, {.amplitude_um = 600, .seconds = 1});
  const std::vector<double> setpoints = step.recording.column("setpoint");
  EXPECT_NEAR(*std::ranges::max_element(setpoints) - setpoints.front(), 600e-6, 60e-6)
      << "of the way there, which begins after the recording";
  const StepResult result = judge(step);
  EXPECT_GT(result.figures.rise_s, 0.005);
  EXPECT_LT(result.figures.rise_s, 0.5);
  EXPECT_LT(result.figures.error_percent, 10);
  EXPECT_GT(result.peak_K, 320);
  // It was off before.
  EXPECT_EQ(static_cast<unsigned>(remote.number("6041")) & 0x4FU, 0x40U);
  // What a file keeps gives the same figures.
  const test::TemporaryFolder folder;
  const std::string file = folder.write("step.csv", to_csv(step.recording));
  const StepResult again = judge(load_step(file));
  EXPECT_NEAR(again.figures.rise_s, result.figures.rise_s, 1e-6);
  EXPECT_NEAR(again.figures.error_percent, result.figures.error_percent, 0.01);
  EXPECT_THAT(step_text({step}, {"now"}), HasSubstr("now"));
  // Runs lie over each other, whatever their lengths.
  StepRun shorter = step;
  shorter.recording.rows.resize(shorter.recording.rows.size() / 2);
  for (std::vector<double>& row : shorter.recording.rows) {
    row[1] += 100e-6;
  }
  shorter.recording.rows.front()[1] -= 50e-6;
  const std::string both = step_text({step, shorter}, {"now", "before"});
  EXPECT_THAT(both, HasSubstr("um: * now, . before\n"));
  EXPECT_THAT(both.substr(both.find("um: *")), HasSubstr(" |"));
  EXPECT_GT(std::ranges::count(both.substr(both.find('|')), '.'), 5);
}

TEST_F(CanClient, ARecordingThatSomebodyElseStopsIsNotWhole) {
  const RecordingPlan plan{{"strain"}, 1, 0, ""};
  arm_recorder(remote, plan);
  run(0.3);
  remote.set("recorder.command", "0");
  wait_for_recorder(remote, plan, 5);
  const Recording part = read_recording(remote, plan);
  EXPECT_THROW(require_complete(part, plan, "r.csv"), files::NoResult);
  arm_recorder(remote, plan);
  wait_for_recorder(remote, plan, 5);
  EXPECT_NO_THROW(require_complete(read_recording(remote, plan), plan, "r.csv"));
}

TEST_F(CanClient, RefusesWhatIsNoRecording) {
  const test::TemporaryFolder folder;
  const auto said = [&](const char* text) {
    const std::string file = folder.write("step.csv", text);
    return refusal([&] { load_step(file); });
  };
  EXPECT_THAT(said(""), HasSubstr("is not a recording"));
  EXPECT_THAT(said("time_s,setpoint\n"), HasSubstr("has no rows"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0.1\n"), HasSubstr(":3: must have 2 fields"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0.1,2x\n"), HasSubstr(":3: 2x: is not a number"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0,2\n"), HasSubstr(":3: time_s must increase"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n,2\n"), HasSubstr(":3: time_s must increase"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0.1,2\n0.3,2\n"),
              HasSubstr(":4: time_s is 0.2 s later than before, must be 0.1 s"));
  EXPECT_THAT(said("time_s,setpoint,\n0,1,2\n"), HasSubstr("needs the name of a signal"));
  EXPECT_THAT(said("time_s,setpoint\n0,1e39\n"), HasSubstr(":2: 1e39: is not a number"));
}

TEST_F(CanClient, RefusesARecordingThatBeginsBeforeItself) {
  EXPECT_THAT(refusal([&] { arm_recorder(remote, {{"strain"}, 1, 0.5, ""}); }),
              HasSubstr("--before 0.5 s: needs a --trigger"));
  EXPECT_THAT(refusal([&] { arm_recorder(remote, {{"strain"}, 1, 1, "strain>0"}); }),
              HasSubstr("--before 1 s: must be less than the 1 s"));
}

TEST_F(CanClient, FindsWhoIsThere) {
  const FoundNodes found = scan(bus, 200'000);
  ASSERT_EQ(found.nodes.size(), 1U);
  EXPECT_EQ(found.nodes[0].node, SimulatedBus::node);
  EXPECT_EQ(found.nodes[0].device_type & 0xFFFFU, 402U);
  EXPECT_FALSE(found.without_id);
  EXPECT_THAT(info_text(remote), HasSubstr("Switch on disabled"));
  EXPECT_THAT(faults_text(remote), HasSubstr("latched     none"));
}

TEST_F(CanClient, WatchShowsRows) {
  std::string text;
  watch(remote, {{"live.wire_temperature_K", "6041"}, 0.05, 3, "live.wire_temperature_K"}, false,
        [&](const std::string& part) { text += part; });
  EXPECT_TRUE(text.starts_with("time_s,live.wire_temperature_K,Statusword\n0.0"));
  EXPECT_THAT(text, HasSubstr("\n0.10"));
}

TEST(CanObjects, AreFoundByNameUnitAndKey) {
  EXPECT_EQ(text::find_object("strain.proportional_W").key, gain);
  EXPECT_EQ(text::find_object("2100:1").name, "strain.proportional_W");
  EXPECT_EQ(text::find_object("0x2100:1").key, gain);
  EXPECT_EQ(text::find_object("2100h:1").key, gain);
  EXPECT_EQ(text::value_bytes(text::find_object("limits.current_mA"), "250"), real_bytes(0.25F));
  EXPECT_EQ(text::value_text(text::find_object("limits.current_mA"), real_bytes(0.25F)), "250");
  EXPECT_EQ(text::find_object("5FFF:2").type, canopen::Type::octets);
  EXPECT_THROW(text::find_object("limits.currnt_A"), files::UserError);
  EXPECT_THAT([] { text::find_object("measuring.load_gain"); },
              testing::ThrowsMessage<files::UserError>(
                  "measuring.load_gain: is now called measurement.load_gain"));
  EXPECT_THROW(text::value_bytes(text::find_object("6040"), "65536"), files::UserError);
  EXPECT_THROW(text::value_bytes(text::find_object("6060"), "-129"), files::UserError);
  EXPECT_THROW(text::value_bytes(text::find_object("limits.current_A"), "0.1x"), files::UserError);
}

// Every object reads back what it writes as text.
TEST(CanObjects, TextsComeBack) {
  for (const text::KnownObject& object : text::known_objects()) {
    const std::size_t size = canopen::size_of(object.type);
    if (size == 0) {
      continue;
    }
    const Bytes one = object.type == canopen::Type::real ? real_bytes(1.5F) : Bytes(size, 0);
    const std::string text = text::value_text(object, one);
    EXPECT_EQ(text::value_bytes(object, text), one) << object.name << ' ' << text;
  }
}

TEST(CanTextPlot, DrawsARise) {
  const std::vector<double> values{0, 1, 2, std::nan("")};
  EXPECT_EQ(report::text_plot({values}, 10, 3), "         2 |  *\n           | *\n         0 |*\n");
  EXPECT_EQ(report::text_plot({values, {2, 2, 2, 0}}, 10, 3),
            "         2 |..*\n           | *\n         0 |*  .\n");
  EXPECT_EQ(report::text_plot({}, 10, 3), "");
}

TEST(CanFrames, AreSaidInWords) {
  EXPECT_EQ(frame_text({.id = 0, .length = 2, .data = {1, 5}}), "NMT: start, node 5");
  EXPECT_EQ(frame_text({.id = 0x705, .length = 1, .data = {0x7F}}),
            "heartbeat of 5: pre-operational");
  EXPECT_THAT(frame_text({.id = 0x85, .length = 8, .data = {0x30, 0x81, 0x11}}),
              HasSubstr("EMCY of 5: 8130h"));
  EXPECT_THAT(frame_text({.id = 0x585, .length = 8, .data = {0x80, 0, 0x10, 0, 0, 0, 2, 6}}),
              HasSubstr("06020000h no such object"));
}

}  // namespace
}  // namespace smaservo::can
