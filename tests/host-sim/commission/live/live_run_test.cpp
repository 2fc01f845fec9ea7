// Guided runs of a simulated servo, in virtual time.

#include <algorithm>
#include <csignal>
#include <deque>
#include <filesystem>
#include <gmock/gmock.h>

#include "hal/replay/trace.hpp"
#include "host-sim/commission/live/live.hpp"
#include "host-sim/end_by_signal.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/can/can_client.hpp"
#include "tests/host-sim/commission/live/scripted_person.hpp"

namespace smaservo::commission {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

/// Does something to a bus at a time; looks at each frame that is sent.
class WatchedBus final : public can::Bus {
 public:
  explicit WatchedBus(test::SimulatedBus& bus) : bus_(bus) {}

  void send(const hal::CanFrame& frame) override {
    if (on_send) {
      on_send(frame);
    }
    if (!is_lost) {
      bus_.send(frame);
    }
  }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    constexpr std::int64_t slice_us = 10'000;
    do {
      if (at_s > 0 && now_us() >= static_cast<std::int64_t>(at_s * 1e6)) {
        at_s = 0;
        then();
      }
      if (!others.empty()) {
        frame = others.front();
        others.pop_front();
        return true;
      }
      if (bus_.receive(frame, std::min(until_us, now_us() + slice_us)) && !is_lost) {
        return true;
      }
    } while (now_us() < until_us);
    return false;
  }
  std::int64_t now_us() const override { return bus_.now_us(); }
  std::string name() const override { return bus_.name(); }

  std::function<void(const hal::CanFrame&)> on_send;
  double at_s = 0;
  std::function<void()> then;
  bool is_lost = false;
  std::deque<hal::CanFrame> others;  ///< what others send: the simulated bus has no others

 private:
  test::SimulatedBus& bus_;
};

struct LiveCommission : can::CanClient {
  LiveCommission() {
    run(0.3);
    options.path = folder / "run.csv";
    options.times = LevelTimes{}.times(0.25);
    person.there = false;
  }

  LiveRun live() { return record_live(options, through, person); }
  std::string refused() {
    return refusal([&] { live(); });
  }
  double now_s() const { return 1e-6 * static_cast<double>(bus.now_us()); }
  /// Some time into the heating.
  void once_heated(const std::function<void()>& then) {
    watched.at_s = now_s() + 6;
    watched.then = then;
  }
  /// In the time in which the run listens whether anybody commands the servo: reading the settings
  /// passes no time in the simulation.
  void once_listening(const std::function<void()>& then) {
    watched.at_s = now_s() + 0.6;
    watched.then = then;
  }
  Rig& rig() { return bus.servo().rig(); }
  /// Heat is off, and nothing is there but what was there before.
  void expect_left_alone() {
    run(0.1);
    EXPECT_EQ(rig().flowing_A, 0);
    EXPECT_THAT(folder.names(), IsEmpty());
    EXPECT_EQ(remote.number("6060"), 0);
    EXPECT_EQ(remote.number("target.power_W"), 0);
    EXPECT_EQ(remote.whole("6041") & 0x6FU, 0x40U);
  }
  /// A wire whose resistance differs by this factor from that of the settings.
  void put_in(const Unlike& unlike) {
    rig().wire = std::make_unique<LumpedRigWire>(rig().settings.wire, unlike, 150e6);
  }

  test::TemporaryFolder folder;
  WatchedBus watched{bus};
  can::Remote through{{watched, test::SimulatedBus::node}};
  ScriptedPerson person;
  LiveOptions options;
};

TEST_F(LiveCommission, RecordsTheWholeSequence) {
  options.times = {};
  const LiveRun done = live();
  EXPECT_EQ(done.path, options.path);
  EXPECT_THAT(done.anchors, IsEmpty());
  EXPECT_EQ(done.left_out, 0);
  EXPECT_LE(done.period_s, 0.01 * (1 + 1e-6));
  // 84 s at 100 rows/s and more.
  EXPECT_GT(static_cast<double>(done.rows) * done.period_s, 83.5);
  EXPECT_LT(static_cast<double>(done.rows) * done.period_s, 87);
  EXPECT_LT(rig().hottest_K, rig().settings.limits.temperature_K);

  hal::TraceReader trace(options.path, {});
  using enum hal::Column;
  double before_s = -done.period_s;
  double coldest_ohm = 0;
  double least_ohm = 1e9;
  std::size_t rows = 0;
  for (hal::TraceRow row; trace.next(row); ++rows) {
    ASSERT_LT(row[time] - before_s, 0.1);
    before_s = row[time];
    ASSERT_GT(row[current], 0.009);
    const double ohm = row[voltage] / row[current];
    coldest_ohm = std::max(coldest_ohm, ohm);
    least_ohm = std::min(least_ohm, ohm);
  }
  EXPECT_EQ(rows, done.rows);
  EXPECT_LT(least_ohm, 0.9 * coldest_ohm);
  run(0.1);
  EXPECT_EQ(rig().flowing_A, 0);
  EXPECT_EQ(remote.number("6060"), 0);
  EXPECT_EQ(remote.whole("6041") & 0x6FU, 0x40U);
}

TEST_F(LiveCommission, AsksForReadings) {
  options.asks = 4;
  person.there = true;
  person.answers = {"0", "3,6", "x", "3.7 mm", ScriptedPerson::silence, ""};
  const LiveRun done = live();
  ASSERT_THAT(done.anchors, SizeIs(3));
  EXPECT_EQ(done.anchors[0].time_s, 0);
  EXPECT_NEAR(done.anchors[1].displacement_m, 3.6e-3, 1e-9);
  EXPECT_GT(done.anchors[1].time_s, 0.25 * (12 + 21) - 0.5);
  EXPECT_LT(done.anchors[2].time_s, static_cast<double>(done.rows) * done.period_s);
  EXPECT_THAT(person.asked, SizeIs(6));
  EXPECT_GT(person.shown, 20U);
  EXPECT_LE(person.longest_line, 79U);
  // A question holds the heat for 20 s at most.
  EXPECT_NEAR(static_cast<double>(done.rows) * done.period_s, 21 + 20, 3);
}

TEST_F(LiveCommission, WithoutAColdReadingNothingElseIsAsked) {
  options.asks = 4;
  options.cold_wait_s = 2;
  person.there = true;
  EXPECT_THAT(live().anchors, IsEmpty());
  EXPECT_THAT(person.asked, SizeIs(1));
}

/// One of several servos of a test.
class OtherServo final : public LiveCommission {
  void TestBody() override {}
};

// The device's own checks may end the heat first, and do not tell the length.
TEST_F(LiveCommission, AWireOfAnotherLengthIsNamed) {
  constexpr std::pair<double, const char*> wires[] = {{0.6, "wire.length of 60 to 61 mm"},
                                                      {0.85, "wire.length of 85 to 87 mm"},
                                                      {1.15, "wire.length of 115 to 117 mm"},
                                                      {1.4, "wire.length of 140 to 142 mm"}};
  for (const auto& [factor, named] : wires) {
    OtherServo other;
    other.put_in({.resistance = factor});
    EXPECT_THAT(other.refused(), AllOf(HasSubstr(named), HasSubstr("instead of 100 mm")));
    EXPECT_LT(other.rig().hottest_K, room_K + 5);
    EXPECT_EQ(other.rig().flowing_A, 0);
    EXPECT_THAT(other.folder.names(), IsEmpty());
    EXPECT_EQ(other.remote.number("6060"), 0);
  }
}

TEST_F(LiveCommission, AWireThatDoesNotTransformIsNamed) {
  put_in({.shift_K = 60});
  const double begun_s = now_s();
  EXPECT_THAT(refused(), AnyOf(HasSubstr("does not transform"), HasSubstr("no_response"),
                               HasSubstr("model_divergence")));
  EXPECT_LT(now_s() - begun_s, 8);
  EXPECT_EQ(rig().flowing_A, 0);
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST_F(LiveCommission, ALoadThatIsMissingIsNamed) {
  rig().stress_Pa = 0;
  run(0.2);
  EXPECT_THAT(refused(), HasSubstr("the load is missing"));
  EXPECT_LT(rig().hottest_K, room_K + 0.1);
  expect_left_alone();
}

TEST_F(LiveCommission, AFaultOfTheDeviceIsExplained) {
  once_heated([&] { rig().stress_Pa = 0; });
  EXPECT_THAT(refused(), HasSubstr("load_lost: "));
  EXPECT_EQ(rig().flowing_A, 0);
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST_F(LiveCommission, RefusesAServoThatIsEnabled) {
  remote.enable();
  EXPECT_THAT(refused(), HasSubstr("\"Operation enabled\" already"));
  EXPECT_EQ(remote.whole("6041") & 0x6FU, 0x27U) << "it is left as it was";
}

TEST_F(LiveCommission, RefusesAServoWithAFault) {
  remote.enable();
  run(6);  // nobody commands it
  EXPECT_THAT(refused(), HasSubstr("has a fault: bus_lost"));
}

TEST_F(LiveCommission, RefusesAServoThatSomebodyCommands) {
  const hal::CanFrame rpdo{.id = 0x205, .length = 3, .data = {6, 0, 0}};
  const hal::CanFrame write{.id = 0x605, .length = 8, .data = {0x2B, 0x40, 0x60, 0, 6, 0, 0, 0}};
  const hal::CanFrame read{.id = 0x605, .length = 8, .data = {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}};
  for (const hal::CanFrame& frame : {rpdo, write, read}) {
    once_listening([&] { watched.others.push_back(frame); });
    if (frame.data[0] == read.data[0]) {
      EXPECT_NO_THROW(live());
    } else {
      EXPECT_THAT(refused(), AllOf(HasSubstr("commanded by somebody else"),
                                   HasSubstr(frame.id == rpdo.id ? "RPDO" : "SDO")));
    }
  }
}

TEST_F(LiveCommission, RefusesAServoThatWatchesAnotherMaster) {
  remote.set("1016:1", std::to_string(7U << 16U | 500U));
  EXPECT_THAT(refused(), HasSubstr("obeys another master"));
}

TEST_F(LiveCommission, EndsWhereSomebodyElseUsesTheRecorder) {
  once_heated([&] { remote.set("recorder.command", "0"); });
  EXPECT_THAT(refused(), HasSubstr("its recorder has stopped"));
  expect_left_alone();
}

TEST_F(LiveCommission, EndsWhereSomebodyElseCommands) {
  once_heated([&] { remote.set("target.power_W", "0.05"); });
  EXPECT_THAT(refused(), HasSubstr("commanded by somebody else"));
  expect_left_alone();
}

TEST_F(LiveCommission, ALostBusIsSaid) {
  once_heated([&] { watched.is_lost = true; });
  EXPECT_THAT(refused(), HasSubstr("the servo ends it by itself 5 s after the last command"));
  run(5.5);
  EXPECT_EQ(rig().flowing_A, 0);
  EXPECT_THAT(folder.names(), IsEmpty());
}

// Whoever ends a run may interrupt the bus more than once.
TEST_F(LiveCommission, IsPutBackThoughThatIsInterrupted) {
  int interrupts = 0;
  once_heated([&] {
    watched.on_send = [&](const hal::CanFrame&) {
      if (interrupts++ == 0) {
        throw files::UserError("interrupted again");
      }
    };
    throw files::UserError("interrupted");
  });
  EXPECT_THAT(refused(), HasSubstr("interrupted; the heat is off"));
  EXPECT_GT(interrupts, 1);
  expect_left_alone();
}

TEST_F(LiveCommission, ASignalEndsTheHeat) {
  const auto before = std::signal(SIGINT, [](int) {});
  {
    const EndBySignal guard;
    once_heated([&] {
      EXPECT_GT(rig().flowing_A, 0);
      raise(SIGINT);
    });
    EXPECT_THAT(refused(), AllOf(HasSubstr("ended by a signal"), HasSubstr("the heat is off")));
  }
  std::signal(SIGINT, before);
  expect_left_alone();
}

TEST_F(LiveCommission, AFolderThatIsMissingIsFoundBeforeTheHeat) {
  options.path = folder / "none/run.csv";
  EXPECT_THAT(refused(), HasSubstr("none"));
  EXPECT_EQ(rig().flowing_A, 0);
}

}  // namespace
}  // namespace smaservo::commission
