// Runs from a servo, in virtual time.

#include "host-sim/record/bus_run.hpp"

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <gmock/gmock.h>

#include "firmware/signals.hpp"
#include "hal/replay/trace.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/record/card/wire_of_card.hpp"
#include "host-sim/record/check.hpp"
#include "host-sim/record/record.hpp"
#include "tests/host-sim/can/can_client.hpp"
#include "tests/host-sim/record/data_set.hpp"

namespace smaservo::record {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::file_text;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Another client asks the node in the middle of each of the first transfers of blocks.
class DisturbedBus final : public can::Bus {
 public:
  DisturbedBus(can::Bus& bus, int times) : bus_(bus), left_(times) {}

  void send(const hal::CanFrame& frame) override {
    constexpr std::uint8_t starts_blocks = 0xA3;
    bus_.send(frame);
    if (frame.data[0] == starts_blocks && left_ > 0) {
      --left_;
      hal::CanFrame other = frame;
      other.data = {0x40, 0x41, 0x60, 0};  // reads the statusword
      bus_.send(other);
    }
  }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    return bus_.receive(frame, until_us);
  }
  std::int64_t now_us() const override { return bus_.now_us(); }
  std::string name() const override { return bus_.name(); }
  int left() const { return left_; }

 private:
  can::Bus& bus_;
  int left_;
};

struct RecordFromBus : can::CanClient {
  BusTask task(const std::string& name = "") const {
    folder.write("card.toml", test::filled_card({{"length_mm", "length_mm = 100"}}));
    return {folder / "card.toml", folder / "set", name, {}, "node 5 on sim"};
  }
  /// A second of a servo that is heated.
  Recorded heated(double seconds = 1) {
    const can::RecordingPlan plan{signals_with({"strain"}), seconds, 0, ""};
    const BusRun run = record_from_bus(remote, plan, 5);
    rows = run.recording.rows.size();
    return {run.csv, run.left_out};
  }

  test::TemporaryFolder folder;
  std::size_t rows = 0;
};

TEST(BusRun, HasWhatAReplayNeedsOnce) {
  EXPECT_THAT(signals_with({"strain", "live.current_A", "stress_Pa", "live.strain"}),
              ElementsAre("current_A", "voltage_V", "stress_Pa", "strain"));
}

// No estimate of the servo is taken for a measurement, whichever signals are recorded.
TEST_F(RecordFromBus, EstimatesAreNoMeasurements) {
  for (std::size_t i = 0; i < signal_count; ++i) {
    const can::RecordingPlan plan{signals_with({std::string(signal_rows<float>.at(i).name)}), 0.01,
                                  0, ""};
    const BusRun run = record_from_bus(remote, plan, 5);
    const hal::TraceReader trace(folder.write("x.csv", run.csv), {});
    for (std::size_t k = 0; k < hal::column_count; ++k) {
      using enum hal::Column;
      const auto column = static_cast<hal::Column>(k);
      EXPECT_EQ(trace.has(column),
                column == time || column == current || column == voltage || column == stress)
          << run.csv.substr(0, 100) << k;
    }
    EXPECT_EQ(trace.read_as(), "");
  }
}

TEST_F(RecordFromBus, MakesTheSameKindOfFolder) {
  run(0.2);
  remote.enable();
  record_bus(task(), [&] { return heated(); });
  const std::string csv = file_text(folder / "set/runs/run-001.csv");
  EXPECT_TRUE(csv.starts_with("time_s,current_A,voltage_V,stress_Pa,servo_strain\n"))
      << csv.substr(0, 80);
  EXPECT_THAT(check_folder(folder / "set", {}).faults, IsEmpty());
  EXPECT_EQ(check_folder(folder / "set", {}).rows, rows);
  record_bus(task(), [&] { return heated(0.5); });
  record_bus(task("steps"), [&] { return heated(0.5); });
  EXPECT_THAT(check_folder(folder / "set", {}).faults, IsEmpty());
  EXPECT_TRUE(fs::exists(folder / "set/runs/run-002.csv"));
  EXPECT_TRUE(fs::exists(folder / "set/runs/steps.csv"));
  EXPECT_THAT(refusal([&] {
                record_bus(task("steps"), [&]() -> Recorded {
                  ADD_FAILURE() << "it is judged before the recording";
                  return {};
                });
              }),
              HasSubstr("is there already"));
}

TEST_F(RecordFromBus, IsReadAgainWhereAnotherClientEndsTheTransfer) {
  const can::RecordingPlan plan{signals_with({}), 0.5, 0, ""};
  for (const int times : {1, 3, 100}) {
    DisturbedBus disturbed(bus, times);
    can::Remote through({disturbed, test::SimulatedBus::node});
    if (times < 5) {
      EXPECT_NEAR(static_cast<double>(record_from_bus(through, plan, 5).recording.rows.size()), 500,
                  1);
      EXPECT_EQ(disturbed.left(), 0);
    } else {
      EXPECT_THROW(record_from_bus(through, plan, 5), can::SdoError);
      EXPECT_EQ(disturbed.left(), times - 5);
    }
  }
}

// Ctrl-C while a run is copied: the copy ends, and its owner can clean up.
TEST_F(RecordFromBus, ASignalEndsTheCopy) {
  task();
  const auto before = std::signal(SIGINT, [](int) {});
  {
    const EndBySignal guard;
    raise(SIGINT);
    const Card card = load_card(folder / "card.toml");
    const RunSource source{folder.write("a.csv", test::joule_file()), "a.csv", {}, 0, {}, {}, {}};
    EXPECT_THAT(refusal([&] { take_run(source, card, wire_of(card), folder / "copy.csv"); }),
                HasSubstr("a.csv: ended by a signal; nothing is added"));
    EXPECT_FALSE(fs::exists(folder / "copy.csv"));
  }
  std::signal(SIGINT, before);
}

TEST_F(RecordFromBus, ABusThatIsLostLeavesNothing) {
  const BusTask wanted = task();
  const auto before = content_of(folder.path());
  EXPECT_THROW(record_bus(wanted, []() -> Recorded { throw files::UserError("bus lost"); }),
               files::UserError);
  EXPECT_EQ(content_of(folder.path()), before);
}

TEST_F(RecordFromBus, ARecordingThatIsRefusedIsNotLost) {
  const std::string csv =
      "time_s,current_A,voltage_V,stress_Pa\n0,0.1,2.2,1e8\n0.1,0.1,2.2,1e8\n0.2,100,2.2,1e8\n";
  const auto again = [&] {
    return refusal([&] { record_bus(task("x"), [&] { return Recorded{csv, 0}; }); });
  };
  EXPECT_THAT(again(), HasSubstr("node 5 on sim: "));
  EXPECT_THAT(again(), HasSubstr("set-x-2.csv"));
  EXPECT_EQ(file_text(folder / "set-x.csv"), csv);
  EXPECT_EQ(file_text(folder / "set-x-2.csv"), csv);
  setenv("TMPDIR", (folder / "none").c_str(), 1);
  EXPECT_THAT(again(), HasSubstr("let TMPDIR name one that exists; the recording is kept as"));
  unsetenv("TMPDIR");
  EXPECT_EQ(file_text(folder / "set-x-3.csv"), csv);
  EXPECT_FALSE(fs::exists(folder / "set"));
}

}  // namespace
}  // namespace smaservo::record
