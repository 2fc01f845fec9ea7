// The rounds of the bus's thread, by a clock and on a bus of the test's own: no thread, no socket,
// nothing waits.

#include "firmware/daemon/bus/bus_rounds.hpp"

#include <algorithm>
#include <deque>
#include <gtest/gtest.h>

#include "expedited_client.hpp"
#include "firmware/parameters/store/store.hpp"
#include "hal/linux/system/file_store.hpp"
#include "tests/firmware/canopen/servo/ceilings_at.hpp"
#include "tests/firmware/device/test_device.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::bus_rounds_test {
namespace {

using canopen::Abort;
using canopen::as_bits;
using canopen::as_real;

constexpr Key gain{0x2100, 1}, limit{0x2020, 2}, tuning{0x2102, 1};

struct MemoryPort {
  std::deque<hal::CanFrame> in, out;
  hal::CanState now = hal::CanState::active;
  hal::CanStatistics counted;

  hal::CanState state() const { return now; }
  const hal::CanStatistics& statistics() const { return counted; }
  bool receive(hal::CanFrame& frame) {
    if (in.empty()) {
      return false;
    }
    frame = in.front();
    in.pop_front();
    return true;
  }
  bool send(const hal::CanFrame& frame) {
    out.push_back(frame);
    return true;
  }
};

struct MemoryJournal {
  std::vector<canopen::LoggedChange> changes;
  std::uint32_t count = 0;
  void add(const canopen::LoggedChange& change) { changes.push_back(change); }
  void set_count(std::uint32_t n) { count = n; }
};

/// Stores in the round after the request, or later if the test holds it up.
class StoreInRounds {
 public:
  explicit StoreInRounds(daemon::StoreThread::Keep keep) : keep_(std::move(keep)) {}
  void start(daemon::StoreJob job) {
    ASSERT_FALSE(job_) << "one at a time";
    job_ = std::move(job);
  }
  bool take(daemon::StoreResult& result) {
    if (!job_ || held) {
      return false;
    }
    result = {job_->request, job_->number, keep_(*job_)};
    job_.reset();
    return true;
  }
  bool is_busy() const { return job_.has_value(); }

  bool held = false;

 private:
  daemon::StoreThread::Keep keep_;
  std::optional<daemon::StoreJob> job_;
};

using Rounds = daemon::BusRounds<MemoryPort, StoreInRounds, MemoryJournal>;

using Bytes = std::array<std::uint8_t, 8>;

struct Rig;
struct Link {
  explicit Link(Rig& rig_) : rig(&rig_) {}
  void send(const hal::CanFrame& frame) const;
  /// Waits for a frame for up to ten seconds of the test's clock.
  std::optional<hal::CanFrame> wait(std::uint32_t id) const;
  Rig* rig;
};

template <class Change>
daemon::BusSetup setup_with(Change change) {
  daemon::BusSetup setup{};
  setup.board = "bench";
  change(setup);
  return setup;
}

/// A node, and the links to a loop, whose part the test plays.
struct Rig {
  Rig() : Rig([](daemon::BusSetup&) {}) {}
  explicit Rig(const TemporaryFolder& folder)
      : Rig([&](daemon::BusSetup& setup) { setup.folder = folder.path().string(); }) {}
  template <class Change>
  explicit Rig(Change change)
      : rounds(setup_with(change), desk, links, figures, port, journal), client(*this) {
    rounds.start(now_us);
    EXPECT_TRUE(client.wait(0x701)) << "boot-up";
  }

  void round() {
    now_us += 1000;
    rounds.round(now_us);
  }
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      round();
    }
  }
  /// Takes the new sets of parameters as the loop does, but makes no step.
  int take_sets() {
    int taken = 0;
    daemon::ParameterSet* set = nullptr;
    while (links.new_sets.pop(set)) {
      links.old_sets.push(set);
      ++taken;
    }
    return taken;
  }
  FaultSet external() {
    return rounds.source().listen(1e-6 * static_cast<double>(now_us)).external;
  }
  std::size_t sent(std::uint32_t id) const {
    return static_cast<std::size_t>(
        std::ranges::count(port.out, id, [](const hal::CanFrame& f) { return f.id; }));
  }

  std::uint64_t now_us = 5'000'000;
  MemoryPort port;
  MemoryJournal journal;
  daemon::LoopLinks links;
  daemon::LoopFigures figures;
  daemon::ParameterDesk desk{test_settings(), links};
  Rounds rounds;
  ExpeditedClient<Link> client;
};

void Link::send(const hal::CanFrame& frame) const {
  rig->port.in.push_back(frame);
}

std::optional<hal::CanFrame> Link::wait(std::uint32_t id) const {
  for (int i = 0; i < 10'000; ++i, rig->round()) {
    while (!rig->port.out.empty()) {
      const hal::CanFrame frame = rig->port.out.front();
      rig->port.out.pop_front();
      if (frame.id == id) {
        return frame;
      }
    }
  }
  return {};
}

TEST(BusRounds, TellsTheNodeOfLoopAndBoard) {
  Rig rig;
  rig.figures.cycles = 1234;
  rig.figures.missed = 5;
  rig.figures.wake.add(40'000);
  rig.figures.wake.add(20'000);
  rig.figures.execution.add(70'000);
  rig.client.get({0x1000, 0});
  EXPECT_EQ(rig.client.get({0x2210, 1}), 1234U);
  EXPECT_EQ(rig.client.get({0x2210, 2}), 5U);
  EXPECT_NEAR(as_real(rig.client.get({0x2210, 3})), 30e-6F, 1e-9F);
  EXPECT_NEAR(as_real(rig.client.get({0x2210, 4})), 40e-6F, 1e-9F);
  EXPECT_NEAR(as_real(rig.client.get({0x2210, 5})), 70e-6F, 1e-9F);
  EXPECT_EQ(rig.client.get({0x2211, 1}), 0U);
  EXPECT_EQ(rig.client.get({0x1021, 0}), text::eds_text().size())
      << "announced by the first segment";
}

// More changes than the loop has room for are refused; it gets each that was accepted.
TEST(BusRounds, RefusesWhatTheLoopHasNoRoomFor) {
  Rig rig;
  float said = 5;
  Abort answer = Abort::none;
  for (int i = 0; i < 20 && answer == Abort::none; ++i) {
    const float next = said + 0.125F;
    answer = rig.client.set(gain, as_bits(next));
    said = answer == Abort::none ? next : said;
  }
  EXPECT_EQ(answer, Abort::transfer);
  EXPECT_EQ(as_real(rig.client.get(gain)), said) << "the old value stays";
  EXPECT_EQ(rig.client.set(tuning, 1, 1), Abort::transfer);
  EXPECT_EQ(rig.take_sets(), 8);
  EXPECT_EQ(rig.desk.settings().strain.proportional, static_cast<double>(said));
  rig.round();
  EXPECT_EQ(rig.take_sets(), 0);
  EXPECT_EQ(rig.client.set(gain, as_bits(7.F)), Abort::none);
  EXPECT_EQ(rig.take_sets(), 1);
}

// A trial ends by itself, even while the loop has no room: the loop gets the earlier settings when
// there is room again.
TEST(BusRounds, TheEndOfATrialWaitsForRoom) {
  Rig rig;
  const double before = rig.desk.settings().strain.proportional;
  for (int i = 0; i < 7; ++i) {
    ASSERT_EQ(rig.client.set({0x2100, 2}, as_bits(2.F + 0.125F * static_cast<float>(i))),
              Abort::none);
  }
  ASSERT_EQ(rig.client.set({0x2102, 3}, as_bits(0.5F)), Abort::none);
  ASSERT_EQ(rig.client.set(tuning, 1, 1), Abort::none);
  ASSERT_EQ(rig.client.set(gain, as_bits(5.F)), Abort::none);
  ASSERT_EQ(rig.client.set(tuning, 2, 1), Abort::none);
  rig.run(1000);
  EXPECT_EQ(rig.desk.settings().strain.proportional, before) << "the trial is over";
  EXPECT_EQ(rig.client.set(gain, as_bits(6.F)), Abort::transfer);
  EXPECT_EQ(rig.take_sets(), 8) << "the last of them is the trial";
  rig.round();
  EXPECT_EQ(rig.take_sets(), 1) << "the settings from before the trial";
  EXPECT_EQ(rig.desk.settings().strain.proportional, before);
}

// After SIGHUP has read other settings, a write over the bus changes these, and does not bring back
// the earlier ones.
TEST(BusRounds, GoesOnFromSettingsThatOthersGive) {
  Rig rig;
  EXPECT_EQ(rig.client.set(tuning, 1, 1), Abort::none);
  EXPECT_EQ(rig.client.set(gain, as_bits(5.F)), Abort::none);
  Settings<double> given = rig.desk.settings();
  given.strain.proportional = 7;
  given.limits.power_W = 0.75;
  ASSERT_TRUE(rig.desk.change(given));
  EXPECT_EQ(as_real(rig.client.get(gain)), 7.F);
  EXPECT_EQ(rig.client.get({0x2102, 2}) & 0xFFU, 0U) << "the transaction is over";
  EXPECT_EQ(rig.client.set({0x2100, 2}, as_bits(2.F)), Abort::none);
  EXPECT_EQ(rig.desk.settings().strain.integral_1_s, 2);
  EXPECT_EQ(rig.desk.settings().strain.proportional, 7);
  EXPECT_EQ(rig.desk.settings().limits.power_W, 0.75);
}

// No write exceeds any of the board file's ceilings, neither a single write nor a set.
TEST(BusRounds, NoWriteRaisesACeilingOfTheBoard) {
  const Settings<double> s = test_settings();
  const canopen::Ceilings at = canopen::ceilings_at(s);
  Rig rig([&](auto& setup) { setup.ceilings = at; });
  const std::pair<Key, float> rows[] = {
      {{0x2020, 2}, at.current_A},      {{0x2020, 3}, at.power_W},
      {{0x2020, 4}, at.temperature_K},  {{0x2020, 8}, at.stress_Pa},
      {{0x2021, 1}, at.trip_current_A}, {{0x2021, 2}, at.trip_temperature_K},
      {{0x2021, 3}, at.trip_stress_Pa}};
  for (const bool as_set : {false, true}) {
    if (as_set) {
      EXPECT_EQ(rig.client.set(tuning, 1, 1), Abort::none);
    }
    for (const auto& [key, ceiling] : rows) {
      EXPECT_EQ(rig.client.set(key, as_bits(1.01F * ceiling)), Abort::too_high) << key.index;
      EXPECT_EQ(as_real(rig.client.get(key)), ceiling);
    }
  }
}

TEST(BusRounds, TheKeysOfTheBoardOpenTheLevels) {
  Rig rig([](auto& setup) { setup.keys = {.tune = 11, .set_up = 22}; });
  EXPECT_EQ(rig.client.get({0x2003, 1}), 0U);
  EXPECT_EQ(rig.client.set(gain, as_bits(1.F)), Abort::local);
  rig.client.set({0x2003, 2}, 11);
  EXPECT_EQ(rig.client.set(gain, as_bits(1.F)), Abort::none);
  EXPECT_EQ(rig.client.set({0x2110, 1}, as_bits(0.11F)), Abort::local);
  rig.client.set({0x2003, 2}, 22);
  EXPECT_EQ(rig.client.set({0x2110, 1}, as_bits(0.11F)), Abort::none);
}

TEST(BusRounds, AResetOfTheNodeEndsTheLoop) {
  Rig rig;
  rig.client.nmt(130);
  EXPECT_TRUE(rig.client.wait(0x701));
  EXPECT_FALSE(rig.links.stop) << "the communication alone begins anew";
  rig.client.nmt(129);
  rig.round();
  EXPECT_TRUE(rig.links.stop);
  EXPECT_TRUE(rig.links.restart);
  EXPECT_FALSE(rig.rounds.source().listen(0).command.arm);
  rig.port.out.clear();
  rig.run(1000);
  EXPECT_TRUE(rig.port.out.empty()) << "the boot-up is said by the next one";
}

/// The current limit that the next start would load.
float stored_current_A(const std::string& folder) {
  hal::FileStore store(folder);
  const Loaded<double> loaded = load_settings<double>(store);
  return loaded.reason == LoadReason::none ? 0
                                           : static_cast<float>(loaded.settings.limits.current_A);
}

// The communication is reset 0 to 3 rounds after a save has begun, and the disk finishes 1 to 4
// rounds later. The result of that save must not answer the next one.
TEST(BusRounds, ASaveAfterAResetIsItsOwn) {
  const TemporaryFolder folder;
  Rig rig(folder);
  const float given_A = as_real(rig.client.get(limit));
  constexpr int most = 4;
  for (int i = 0; i < most * most; ++i) {
    rig.take_sets();
    rig.rounds.store().held = true;
    rig.client.send(0x601, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
    rig.run(i / most);
    rig.port.out.clear();
    rig.client.nmt(130);
    rig.run(1 + i % most);
    if (rig.rounds.store().is_busy()) {
      EXPECT_EQ(rig.sent(0x701), 0U) << "a reset waits for the disk";
    }
    rig.rounds.store().held = false;
    ASSERT_TRUE(rig.client.wait(0x701)) << "boot-up";
    const float lower_A = given_A * (1.F - 0.01F * static_cast<float>(i + 1));
    ASSERT_EQ(rig.client.set(limit, as_bits(lower_A)), Abort::none);
    ASSERT_EQ(rig.client.set({0x1010, 1}, canopen::store_signature), Abort::none);
    EXPECT_EQ(stored_current_A(folder.path().string()), lower_A)
        << "it was said to be stored: " << i;
  }
}

// While the disk stands still for 8 s, the node goes on. The save is answered only when it is
// durable.
TEST(BusRounds, ADiskThatStandsStillHoldsUpItsSaveOnly) {
  const TemporaryFolder folder;
  Rig rig(folder);
  ASSERT_EQ(rig.client.set({0x1017, 0}, 100, 2), Abort::none);
  ASSERT_EQ(rig.client.set(limit, as_bits(0.125F)), Abort::none);
  rig.rounds.store().held = true;
  rig.client.send(0x601, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
  rig.port.out.clear();
  rig.run(8000);
  EXPECT_EQ(rig.sent(0x581), 0U);
  EXPECT_EQ(rig.sent(0x701), 80U) << "heartbeats";
  EXPECT_EQ(stored_current_A(folder.path().string()), 0);
  EXPECT_FALSE(rig.external().has(Fault::bus_lost));
  rig.rounds.store().held = false;
  rig.run(2);
  ASSERT_EQ(rig.sent(0x581), 1U);
  EXPECT_EQ(stored_current_A(folder.path().string()), 0.125F);
}

// The bus is lost, to the round, when nothing has been received for longer than the board file
// says, until something is received again.
TEST(BusRounds, ASilentBusIsLostAfterItsTime) {
  Rig rig([](auto& setup) { setup.lost_after_s = 0.5; });
  rig.client.get(gain);
  rig.round();
  const auto heard_us = rig.now_us;
  for (; rig.now_us < heard_us + 2'000'000; rig.round()) {
    ASSERT_EQ(rig.external().has(Fault::bus_lost), rig.now_us > heard_us + 500'000)
        << rig.now_us - heard_us;
  }
  rig.client.send(0x7FF, 0, {});
  rig.run(2);
  EXPECT_FALSE(rig.external().has(Fault::bus_lost));
  for (const hal::CanState state :
       {hal::CanState::bus_off, hal::CanState::down, hal::CanState::gone}) {
    rig.port.now = state;
    rig.round();
    EXPECT_TRUE(rig.external().has(Fault::bus_lost)) << hal::name(state);
    rig.port.now = hal::CanState::active;
    rig.round();
    EXPECT_FALSE(rig.external().has(Fault::bus_lost)) << hal::name(state);
  }
}

// If the bus's thread makes no more rounds, the loop sees a lost bus 0.1 s later by its own clock,
// and thus ends the heat.
TEST(BusRounds, AThreadThatStandsStillIsALostBus) {
  Rig rig;
  const double s = 1e-6 * static_cast<double>(rig.now_us);
  rig.round();
  daemon::CommandSource& source = rig.rounds.source();
  EXPECT_FALSE(source.listen(s).external.has(Fault::bus_lost));
  EXPECT_FALSE(source.listen(s + 0.0999).external.has(Fault::bus_lost));
  EXPECT_TRUE(source.listen(s + 0.1001).external.has(Fault::bus_lost));
  EXPECT_TRUE(source.listen(s + 8).external.has(Fault::bus_lost));
  rig.round();
  EXPECT_FALSE(source.listen(s + 8.001).external.has(Fault::bus_lost));
}

// The settings of a trial reach the loop, and so do the former ones when it ends.
TEST(BusRounds, ATrialRevertsInTheLoopAsWell) {
  Rig rig;
  const double before = rig.desk.settings().strain.proportional;
  ASSERT_EQ(rig.client.set({0x2102, 3}, as_bits(2.F)), Abort::none);
  ASSERT_EQ(rig.client.set(tuning, 1, 1), Abort::none);
  ASSERT_EQ(rig.client.set(gain, as_bits(5.F)), Abort::none);
  EXPECT_EQ(rig.desk.settings().strain.proportional, before) << "staged only";
  ASSERT_EQ(rig.client.set(tuning, 2, 1), Abort::none);
  const std::uint64_t tried_us = rig.now_us;
  EXPECT_EQ(rig.desk.settings().strain.proportional, 5);
  EXPECT_EQ(rig.take_sets(), 1);
  while (rig.desk.settings().strain.proportional == 5 && rig.now_us < tried_us + 10'000'000) {
    rig.round();
  }
  EXPECT_EQ(rig.desk.settings().strain.proportional, before);
  EXPECT_NEAR(static_cast<double>(rig.now_us - tried_us), 2e6, 1000);
  EXPECT_EQ(rig.take_sets(), 1);
}

TEST(BusRounds, WhatTheStoreHasLostIsInTheLog) {
  Rig rig([](auto& setup) { setup.lost = {{gain, as_bits(3.F), as_bits(2.F)}}; });
  ASSERT_EQ(rig.journal.changes.size(), 1U);
  EXPECT_EQ(rig.journal.changes[0].key, gain);
  EXPECT_EQ(rig.journal.changes[0].source, canopen::Source::device);
  EXPECT_EQ(rig.journal.count, 1U);
}

// If the stored image of the CANopen node is damaged, there is a fault until a client stores it
// anew by 1010h. A store by LSS does not count, since nobody has looked at the settings then.
void damaged_settings_of_the_bus(const std::string& content) {
  const TemporaryFolder folder;
  const std::string image = folder.write("communication", content);
  Rig rig(folder);
  const auto blocks = [&] { return rig.external().has(Fault::store_outdated); };
  // The state that the start of a daemon would find.
  rig.links.faults = FaultSet(Fault::store_outdated).bits();
  EXPECT_TRUE(blocks());
  rig.client.send(0x7E5, 8, {0x04, 1});
  rig.client.send(0x7E5, 8, {0x17});
  const auto answer = rig.client.wait(0x7E4);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->data[1], 2) << "media error";
  EXPECT_EQ(file_text(image), content);
  EXPECT_EQ(rig.client.set({0x1010, 2}, canopen::store_signature), Abort::none);
  rig.client.get({0x1000, 0});
  EXPECT_FALSE(blocks());
  EXPECT_NE(rig.links.faults, 0U) << "the device's settings are another matter";
  EXPECT_EQ(rig.client.set({0x1010, 3}, canopen::store_signature), Abort::none);
  EXPECT_EQ(rig.links.faults, 0U);
}

TEST(BusRounds, DamagedSettingsOfTheBusAreAFault) {
  damaged_settings_of_the_bus("SC, but no image");
  damaged_settings_of_the_bus("");
}

// LSS cannot change the interface's bit rate, and its answer says so.
TEST(BusRounds, AnotherBitRateIsNotSupported) {
  Rig rig;
  rig.client.send(0x7E5, 8, {0x04, 1});
  rig.client.send(0x7E5, 8, {0x13, 0, 2});
  const auto answer = rig.client.wait(0x7E4);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->data, (Bytes{0x13, 1}));
  rig.client.send(0x7E5, 8, {0x15, 10});
  rig.client.send(0x7E5, 8, {0x5E});
  const auto node_id = rig.client.wait(0x7E4);
  ASSERT_TRUE(node_id);
  EXPECT_EQ(node_id->data, (Bytes{0x5E, 1})) << "it goes on";
}

}  // namespace
}  // namespace smaservo::test::bus_rounds_test
