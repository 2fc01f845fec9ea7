// What the loop does with frames, time and parameters, on a board and a clock of the test's.

#include "firmware/daemon/loop/loop.hpp"

#include <cmath>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/bench/closed_loop.hpp"
#include "firmware/daemon/boards/simulation.hpp"
#include "firmware/daemon/loop/desk.hpp"
#include "firmware/text/settings_file.hpp"
#include "hal/faulty_board.hpp"
#include "tests/places.hpp"

namespace smaservo::test::loop_test {
namespace {

constexpr std::int64_t ms = 1'000'000;

Settings<double> test_settings() {
  return bench::standard_settings();
}

TEST(Ring, GivesEverythingInItsOrder) {
  daemon::Ring<std::uint64_t> ring(5);
  EXPECT_EQ(ring.room(), 8U);
  constexpr std::uint64_t count = 20'000;
  const std::jthread writer([&] {
    for (std::uint64_t i = 1; i <= count;) {
      if (ring.push(i)) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  });
  for (std::uint64_t i = 1; i <= count;) {
    std::uint64_t value = 0;
    if (ring.pop(value)) {
      ASSERT_EQ(value, i++);
    } else {
      std::this_thread::yield();
    }
  }
}

TEST(Ring, RefusesWhatItHasNoRoomFor) {
  daemon::Ring<int> ring(4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(ring.push(i));
  }
  EXPECT_FALSE(ring.push(4));
  int value = 0;
  EXPECT_TRUE(ring.pop(value));
  EXPECT_TRUE(ring.push(5));
}

TEST(Latest, NeverTearsAndNeverGoesBack) {
  struct Value {
    std::uint64_t a, b[30];
  };
  daemon::Latest<Value> latest;
  Value seen{};
  EXPECT_FALSE(latest.take(seen));
  constexpr std::uint64_t count = 200'000;
  const std::jthread writer([&] {
    Value value{};
    for (std::uint64_t i = 1; i <= count; ++i) {
      value.a = i;
      for (std::uint64_t& b : value.b) {
        b = i;
      }
      latest.put(value);
    }
  });
  std::uint64_t last = 0;
  while (last < count) {
    if (latest.take(seen)) {
      ASSERT_GT(seen.a, last);
      last = seen.a;
      for (const std::uint64_t b : seen.b) {
        ASSERT_EQ(b, last);
      }
    }
  }
  EXPECT_FALSE(latest.take(seen));
}

TEST(Histogram, QuantilesAreThoseOfTheSortedTimes) {
  daemon::Histogram histogram;
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> times(10, 2);
  std::vector<std::int64_t> all;
  double sum = 0;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(static_cast<std::int64_t>(times(random)));
    histogram.add(all.back());
    sum += static_cast<double>(all.back());
  }
  std::ranges::sort(all);
  for (const double share : {0.001, 0.1, 0.5, 0.9, 0.999, 1.0}) {
    const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size())));
    const auto exact = static_cast<double>(all.at(n - 1));
    const auto said = static_cast<double>(histogram.quantile_ns(share));
    EXPECT_GE(said, exact) << share;
    EXPECT_LE(said, exact * 1.04 + 1) << share;
  }
  EXPECT_EQ(histogram.max_ns(), all.back());
  EXPECT_NEAR(histogram.mean_ns(), sum / 20'000, 1e-6 * sum);
}

/// A clock in which a sleep ends as late as the test says; between sleeps, time passes only where
/// the test adds it.
struct FakeClock {
  struct Time {
    std::int64_t now_ns = 1'000'000'007;
    std::int64_t late_ns = 0;
    std::int64_t suspended_ns = 0;  ///< sum of all suspensions, which now_ns does not contain
  };
  Time* time;
  hal::BootLead boot_lead() const { return {time->suspended_ns, time->suspended_ns}; }
  std::int64_t now_ns() const { return time->now_ns; }
  void sleep_until(std::int64_t until_ns) const {
    time->now_ns = std::max(time->now_ns, until_ns) + time->late_ns;
  }
};

TEST(Pace, CountsWhatItMissesAndNeverCatchesUp) {
  FakeClock::Time time;
  daemon::Pace<FakeClock> pace(ms, FakeClock{&time});
  pace.wait();
  const std::int64_t first_ns = time.now_ns;
  std::mt19937_64 random(3);
  std::int64_t cycles = 0;
  std::uint64_t missed = 0;
  std::int64_t before_ns = first_ns;
  for (int i = 0; i < 5000; ++i) {
    // The work takes up to a period, in each seventh cycle up to four; the sleep ends up to a tenth
    // of a period late.
    const std::int64_t work_ns = static_cast<std::int64_t>(random() % (i % 7 == 0 ? 4 * ms : ms));
    time.now_ns += work_ns;
    time.late_ns = static_cast<std::int64_t>(random() % (ms / 10));
    const daemon::Woke woke = pace.wait();
    ++cycles;
    missed += woke.missed;
    EXPECT_EQ(woke.late_ns, time.late_ns);
    // Cycles are due at whole periods, at most one in each.
    const std::int64_t at_ns = time.now_ns - woke.late_ns;
    EXPECT_EQ((at_ns - first_ns) % ms, 0);
    EXPECT_GE(at_ns, before_ns);
    before_ns = at_ns + ms;
    EXPECT_EQ(at_ns, first_ns + (cycles + static_cast<std::int64_t>(missed)) * ms);
  }
  EXPECT_GT(missed, 100U);
}

/// The parts that a loop needs.
struct Bench {
  explicit Bench(const bench::ClosedLoopScenario& scenario)
      : simulation(scenario),
        board(simulation),
        desk(scenario.settings, links),
        device(desk.first()),
        demonstration(scenario.settings) {}

  daemon::Loop<hal::FaultyBoard<daemon::Simulation>, daemon::NoPace> loop(
      daemon::CommandSource& source) {
    const auto period_ns =
        static_cast<std::int64_t>(std::llround(desk.settings().timing.period_s * 1e9));
    return {board, daemon::NoPace{}, device, source, links, figures, {period_ns, true}};
  }
  Output<double> output() {
    Output<double> now{};
    links.output.take(now);
    return now;
  }

  daemon::LoopLinks links;
  daemon::LoopFigures figures;
  daemon::Simulation simulation;
  hal::FaultyBoard<daemon::Simulation> board;
  daemon::ParameterDesk desk;
  daemon::PreparedDevice device;
  daemon::Demonstration demonstration;
};

TEST(Loop, IsTheVeryLoopOfHostSim) {
  const bench::ClosedLoopScenario scenario =
      bench::load_closed_loop(test::source_folder() + "/host-sim/scenarios/sensor-faults.toml");
  bench::ClosedLoop expected(scenario);
  Bench bench(scenario);
  auto loop = bench.loop(bench.simulation);
  std::uint64_t cycles = 0;
  bool heated = false;
  while (expected.step()) {
    ASSERT_TRUE(loop.cycle());
    const Output<double> now = bench.output();
    const Output<double>& then = expected.cycle().output;
    ASSERT_EQ(now.drive_current_A, then.drive_current_A) << cycles;
    ASSERT_EQ(now.estimate.strain, then.estimate.strain) << cycles;
    ASSERT_EQ(now.latched.bits(), then.latched.bits()) << cycles;
    ASSERT_EQ(now.time_us, then.time_us);
    heated = heated || now.drive_current_A > 0;
    ++cycles;
  }
  EXPECT_FALSE(loop.cycle());
  EXPECT_EQ(bench.figures.cycles.load(), cycles);
  EXPECT_TRUE(heated);
}

/// The current through the wire some cycles after a fault was injected into a wire that is heated.
double current_after(void (*inject)(hal::BoardFaults&), FaultSet& latched, bool& stops_counted) {
  Bench bench(bench::standard_closed_loop(test_settings()));
  auto loop = bench.loop(bench.demonstration);
  for (int i = 0; i < 1200; ++i) {
    loop.cycle();
  }
  EXPECT_GT(bench.simulation.truth().current_A, 0.01);
  EXPECT_TRUE(bench.output().latched.empty());
  inject(bench.board.faults);
  for (int i = 0; i < 20; ++i) {
    loop.cycle();
  }
  latched = bench.output().latched;
  stops_counted = std::ranges::any_of(
      bench.figures.stops,
      [](const daemon::LoopFigures::Stop& stop) { return stop.count.load() > 0; });
  return bench.simulation.truth().current_A;
}

TEST(Loop, WhateverFailsTheHeatGoesOff) {
  struct Case {
    const char* name;
    Fault fault;
    void (*inject)(hal::BoardFaults&);
  };
  const Case cases[] = {
      {"no frames", Fault::sample_stale, [](hal::BoardFaults& f) { f.lose_every = 1; }},
      {"no current", Fault::sensor_invalid, [](hal::BoardFaults& f) { f.current_missing = true; }},
      {"no voltage", Fault::sensor_invalid, [](hal::BoardFaults& f) { f.voltage_missing = true; }},
      {"stuck", Fault::sample_frozen, [](hal::BoardFaults& f) { f.stuck = true; }},
      {"stop", Fault::emergency_stop, [](hal::BoardFaults& f) { f.emergency_stop = true; }},
      {"driver", Fault::driver_fault, [](hal::BoardFaults& f) { f.driver_fault = true; }},
  };
  for (const Case& c : cases) {
    FaultSet latched;
    bool counted = false;
    EXPECT_EQ(current_after(c.inject, latched, counted), 0) << c.name;
    EXPECT_TRUE(latched.has(c.fault)) << c.name;
    EXPECT_TRUE(counted) << c.name;
  }
}

TEST(Loop, ADeadDriveLosesItsLease) {
  // No command arrives at the board any more, so the board itself ends the heat.
  FaultSet latched;
  bool counted = false;
  EXPECT_EQ(current_after([](hal::BoardFaults& f) { f.drive_dead = true; }, latched, counted), 0);
}

TEST(Loop, ParametersComeIntoForceAsAWholeAndAtOnce) {
  Bench bench(bench::standard_closed_loop(test_settings()));
  daemon::Ring<daemon::CycleRecord> ring(64);
  bench.links.record = &ring;
  auto loop = bench.loop(bench.demonstration);
  Settings<double> settings = bench.desk.settings();
  daemon::CycleRecord record{};
  for (int i = 0; i < 40; ++i) {
    if (i % 10 == 5) {
      settings.limits.current_A *= 0.9;
      settings.strain.proportional += 0.1;
      settings = stored_settings<double>(settings);
      ASSERT_TRUE(bench.desk.change(settings));
    }
    ASSERT_TRUE(loop.cycle());
    ASSERT_TRUE(ring.pop(record));
    EXPECT_EQ(record.set != 0, i % 10 == 5);
    if (record.set != 0) {
      const std::string text = bench.desk.take_text(record.set);
      EXPECT_NE(text.find("limits.current_A="), std::string::npos) << text;
      EXPECT_NE(text.find("strain.proportional"), std::string::npos) << text;
    }
    bench.desk.tidy();
  }
}

TEST(Loop, RefusesMoreChangesThanItHasRoomFor) {
  Bench bench(bench::standard_closed_loop(test_settings()));
  Settings<double> settings = bench.desk.settings();
  int taken = 0;
  for (int i = 0; i < 20; ++i) {
    settings.limits.current_A *= 0.99;
    settings = stored_settings<double>(settings);
    taken += bench.desk.change(settings) ? 1 : 0;
  }
  EXPECT_EQ(taken, 8);
}

// The parameters were given in the belief that the wire was off; the loop sees that it is heated
// and refuses them.
TEST(Loop, ParametersOfTheWireDoNotChangeWhileItIsHeated) {
  Bench bench(bench::standard_closed_loop(test_settings()));
  daemon::Ring<daemon::CycleRecord> ring(64);
  auto loop = bench.loop(bench.demonstration);
  for (int i = 0; i < 1200; ++i) {
    loop.cycle();
  }
  ASSERT_TRUE(is_heated(bench.output().state));
  bench.links.record = &ring;
  const Settings<double> before = bench.desk.settings();
  Settings<double> settings = before;
  settings.wire.geometry.length_m *= 1.5;
  settings.trips.temperature_K += 20;
  ASSERT_TRUE(bench.desk.change(stored_settings<double>(settings)));
  ASSERT_TRUE(loop.cycle());
  daemon::CycleRecord record{};
  ASSERT_TRUE(ring.pop(record));
  EXPECT_EQ(record.set, 0U);
  bench.desk.tidy();
  EXPECT_TRUE(same_settings(bench.desk.settings(), before)) << "the desk says what is in force";
  EXPECT_EQ(bench.desk.changes(), 2U) << "a new number, so that everybody follows";
  EXPECT_FALSE(bench.desk.change(settings, 1U)) << "made from what was taken back";
  const std::vector<std::string> refused = bench.desk.take_refused();
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_NE(refused[0].find("wire.length_m="), std::string::npos) << refused[0];
  // A parameter that may change at any time comes into force, also while the wire is heated.
  settings = before;
  settings.limits.current_A *= 0.9;
  ASSERT_TRUE(bench.desk.change(stored_settings<double>(settings), 2U));
  ASSERT_TRUE(loop.cycle());
  ASSERT_TRUE(ring.pop(record));
  EXPECT_EQ(record.set, 3U);
}

/// A source that commands to arm while `arm` is set.
class ArmingSource : public daemon::CommandSource {
 public:
  bool arm = false;
  Heard<double> listen(double /*time_s*/) override {
    return {{.fresh = true, .arm = arm, .mode = Mode::strain, .setpoint = 0.03}, {}};
  }
};

// Three sets of parameters of the wire were given while it was off: all are in force before it is
// armed. If the command to arm has stood all the time, the delay makes no new edge of it.
TEST(Loop, ArmsAfterWhatWasPromisedWithoutCurrent) {
  Bench bench(bench::standard_closed_loop(test_settings()));
  ArmingSource source;
  auto loop = bench.loop(source);
  for (int i = 0; i < 300; ++i) {
    loop.cycle();
  }
  ASSERT_EQ(bench.output().state, DeviceState::ready);
  Settings<double> settings = bench.desk.settings();
  const auto give_three = [&] {
    for (int i = 0; i < 3; ++i) {
      settings.trips.temperature_K -= 1;
      settings = stored_settings<double>(settings);
      ASSERT_TRUE(bench.desk.change(settings));
    }
  };
  give_three();
  source.arm = true;
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(is_heated(bench.output().state));
    loop.cycle();
  }
  for (int i = 0; i < 3; ++i) {
    loop.cycle();
  }
  EXPECT_TRUE(is_heated(bench.output().state));
  bench.desk.tidy();
  EXPECT_TRUE(bench.desk.take_refused().empty());
  EXPECT_TRUE(same_settings(bench.desk.settings(), settings));
  // A fault ends the heat; the command to arm stands.
  bench.board.faults.driver_fault = true;
  loop.cycle();
  bench.board.faults.driver_fault = false;
  give_three();
  for (int i = 0; i < 50; ++i) {
    loop.cycle();
    EXPECT_FALSE(is_heated(bench.output().state));
  }
}

/// A master that sends the given number of set-points before each cycle.
class BusyPartner : public daemon::CommandSource {
 public:
  std::deque<std::uint32_t> setpoints;
  Heard<double> listen(double /*time_s*/) override {
    const std::uint32_t come = setpoints.front();
    setpoints.pop_front();
    return {{.fresh = true}, {}, false, come};
  }
};

TEST(Loop, CountsSetpointsThatNewerOnesSupersede) {
  Bench bench(bench::standard_closed_loop(test_settings()));
  BusyPartner source;
  source.setpoints = {1, 0, 2, 1, 3};
  auto loop = bench.loop(source);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(loop.cycle());
  }
  EXPECT_EQ(bench.figures.setpoints.load(), 7U);
  EXPECT_EQ(bench.figures.superseded.load(), 3U);
}

/// Frames at the times that a test gives.
class TimesBoard {
 public:
  std::deque<std::int64_t> times_ns;
  hal::ReadStatus read(hal::Frame& frame) {
    if (times_ns.empty()) {
      return hal::ReadStatus::end;
    }
    frame = {};
    frame.time_ns = times_ns.front();
    times_ns.pop_front();
    return hal::ReadStatus::frame;
  }
  void drive(const hal::DriveCommand& /*command*/) {}
  void safe_off() { ++offs; }
  void kick() { ++kicks; }
  static std::int64_t now_ns() { return 0; }
  int offs = 0, kicks = 0;
};

TEST(Loop, TheDeviceStepsOverAllOfAPause) {
  daemon::LoopLinks links;
  daemon::LoopFigures figures;
  const daemon::ParameterDesk desk(test_settings(), links);
  daemon::PreparedDevice device(desk.first());
  daemon::NoCommandSource nobody;
  TimesBoard board;
  board.times_ns = {5 * ms, 6 * ms, 7 * ms, 507 * ms, 508 * ms, 508 * ms};
  daemon::Ring<daemon::CycleRecord> ring(16);
  links.record = &ring;
  daemon::Loop loop(board, daemon::NoPace{}, device, nobody, links, figures, {ms, true});
  const double expected_s[] = {0, 0.001, 0.002, 0.502, 0.503, 0.5031};
  for (const double time_s : expected_s) {
    ASSERT_TRUE(loop.cycle());
    daemon::CycleRecord record{};
    ASSERT_TRUE(ring.pop(record));
    EXPECT_DOUBLE_EQ(record.cycle.time_s, time_s);
  }
  EXPECT_FALSE(loop.cycle());
  EXPECT_EQ(board.offs, 1);
  EXPECT_EQ(board.kicks, 0) << "a wire that is not heated needs no lease";
}

/// A simulated wire on a board in real time: its frames are those of the clock. The converter keeps
/// frames from before a stall, as IIO's buffer does, and the wire's own time stands still.
class RealTimeBoard {
 public:
  static constexpr bool in_monotonic_time = true;
  RealTimeBoard(daemon::Simulation& wire, FakeClock::Time& time) : wire_(wire), time_(time) {}
  hal::ReadStatus read(hal::Frame& frame) {
    const hal::ReadStatus status = wire_.read(frame);
    time_.now_ns += blocks_ns;
    frame.time_ns = time_.now_ns - std::exchange(old_ns, 0);
    blocks_ns = 0;
    return status;
  }
  void drive(const hal::DriveCommand& command) {
    commanded_A = command.current_A;
    wire_.drive({command.current_A, command.voltage_V, wire_.now_ns() + 3 * ms});
  }
  void safe_off() {
    ++offs;
    wire_.safe_off();
  }
  void kick() {}
  std::int64_t now_ns() const { return time_.now_ns; }

  std::int64_t blocks_ns = 0;  ///< duration of the next read()
  std::int64_t old_ns = 0;     ///< age of the next frame
  double commanded_A = 0;
  int offs = 0;

 private:
  daemon::Simulation& wire_;
  FakeClock::Time& time_;
};

/// Heats a wire, lets something happen, and runs one more cycle.
struct Stalled {
  explicit Stalled(const std::function<void(FakeClock::Time&, RealTimeBoard&)>& happens) {
    daemon::LoopLinks links;
    daemon::LoopFigures figures;
    const bench::ClosedLoopScenario scenario = bench::standard_closed_loop(test_settings());
    const daemon::ParameterDesk desk(scenario.settings, links);
    daemon::PreparedDevice device(desk.first());
    daemon::Demonstration demonstration(scenario.settings);
    daemon::Simulation wire(scenario);
    FakeClock::Time time;
    RealTimeBoard board(wire, time);
    daemon::Ring<daemon::CycleRecord> ring(4);
    daemon::CycleRecord record{};
    links.record = &ring;
    daemon::Loop loop(board, daemon::Pace<FakeClock>(ms, FakeClock{&time}), device, demonstration,
                      links, figures, {ms, true});
    const auto cycle = [&] {
      EXPECT_TRUE(loop.cycle());
      EXPECT_TRUE(ring.pop(record));
    };
    for (int i = 0; i < 1200; ++i) {
      cycle();
    }
    EXPECT_GT(board.commanded_A, 0.01);
    EXPECT_TRUE(record.cycle.output.latched.empty());
    before = record.cycle;
    happens(time, board);
    cycle();
    after = record.cycle;
    commanded_A = board.commanded_A;
    offs = board.offs;
    for (int i = 0; i < 200; ++i) {
      cycle();
      EXPECT_FALSE(record.cycle.inputs.external.has(Fault::loop_stalled)) << "it is told once";
    }
    end = record.cycle;
  }
  Cycle before{}, after{}, end{};
  double commanded_A = 0;
  int offs = 0;
};

TEST(Loop, WhateverStopsItIsAStall) {
  using Time = FakeClock::Time;
  struct Case {
    const char* name;
    std::function<void(Time&, RealTimeBoard&)> happens;
    double time_s;
  };
  const Case cases[] = {
      {"a stopped process", [](Time& t, RealTimeBoard&) { t.now_ns += 5000 * ms; }, 5},
      {"a driver that blocks", [](Time&, RealTimeBoard& b) { b.blocks_ns = 8 * ms; }, 0.008},
      {"a suspended machine", [](Time& t, RealTimeBoard&) { t.suspended_ns += 3'600'000 * ms; },
       1000},
      {"a buffer of old frames",
       [](Time& t, RealTimeBoard& b) {
         t.now_ns += 400 * ms;
         b.old_ns = 390 * ms;
       },
       0.4},
  };
  for (const Case& c : cases) {
    const Stalled stalled(c.happens);
    EXPECT_EQ(stalled.after.output.first_cause, Fault::loop_stalled) << c.name;
    EXPECT_TRUE(stalled.after.inputs.deadline_missed) << c.name;
    EXPECT_NEAR(stalled.after.time_s - stalled.before.time_s, c.time_s, 0.002) << c.name;
    EXPECT_EQ(stalled.commanded_A, 0) << c.name;
    EXPECT_GE(stalled.offs, 1) << c.name << ": before the step";
    EXPECT_EQ(stalled.end.output.latched, FaultSet(Fault::loop_stalled)) << c.name;
    EXPECT_EQ(stalled.end.output.state, DeviceState::fault) << c.name;
  }
}

TEST(Loop, WithinTheLeaseIsNoStall) {
  const Stalled late(
      [](FakeClock::Time& time, RealTimeBoard& /*board*/) { time.now_ns += 2 * ms + ms / 2; });
  EXPECT_TRUE(late.after.inputs.deadline_missed);
  EXPECT_TRUE(late.end.output.latched.empty());
  EXPECT_TRUE(is_heated(late.end.output.state));
}

// A simulated wire's time stands still with its loop, so the scheduling delays of a PC are no
// stall, but a program that was stopped for a second is.
TEST(Loop, ASimulatedWireIsStalledAfterASecond) {
  for (const std::int64_t gone_ms : {30, 900, 1500, 8000}) {
    Bench bench(bench::standard_closed_loop(test_settings()));
    FakeClock::Time time;
    daemon::Loop loop(bench.simulation, daemon::Pace<FakeClock>(ms, FakeClock{&time}), bench.device,
                      bench.demonstration, bench.links, bench.figures, {ms, true});
    for (int i = 0; i < 1200; ++i) {
      ASSERT_TRUE(loop.cycle());
    }
    time.now_ns += gone_ms * ms;
    ASSERT_TRUE(loop.cycle());
    const Output<double> now = bench.output();
    EXPECT_EQ(now.latched, gone_ms < 1000 ? FaultSet{} : FaultSet(Fault::loop_stalled));
    EXPECT_EQ(now.time_us, 1'201'000U) << "the wire's own time";
  }
}

TEST(SuspendWatch, NeverSaysMoreThanItWas) {
  hal::SuspendWatch watch;
  // Another thread had the processor while the clocks were read.
  EXPECT_EQ(watch.suspended_ns({1000, 9000}), 0);
  EXPECT_EQ(watch.suspended_ns({5000, 5100}), 0);
  EXPECT_EQ(watch.suspended_ns({4000, 9000}), 0);
  EXPECT_EQ(watch.suspended_ns({5000, 5100}), 0);
  EXPECT_EQ(watch.suspended_ns({7'005'000, 7'005'100}), 7'005'000 - 5100);
  EXPECT_EQ(watch.suspended_ns({7'005'000, 7'005'100}), 0);
  hal::SuspendWatch clock;
  clock.suspended_ns(hal::boot_lead());
  EXPECT_EQ(clock.suspended_ns(hal::boot_lead()), 0) << "this machine's, while it is awake";
}

}  // namespace
}  // namespace smaservo::test::loop_test
