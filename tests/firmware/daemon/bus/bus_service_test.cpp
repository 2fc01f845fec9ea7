// The node of a daemon beside a loop, on a bus of this machine alone.

#include "firmware/daemon/bus/bus_service.hpp"

#include <gtest/gtest.h>
#include <thread>

#include "bus_client.hpp"
#include "firmware/parameters/store/store.hpp"
#include "firmware/text/reference/canopen_reference.hpp"
#include "hal/linux/system/file_store.hpp"
#include "tests/firmware/canopen/servo/ceilings_at.hpp"
#include "tests/firmware/device/test_device.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

using canopen::Abort;
using canopen::as_bits;
using canopen::as_real;

constexpr Key gain{0x2100, 1};

struct Rig {
  explicit Rig(const canopen::Ceilings& ceilings = {}, const canopen::AccessKeys& keys = {},
               const std::string& folder = "")
      : desk(test_settings(), links), service(setup(ceilings, keys, folder), desk, links, figures) {
    service.start();
    EXPECT_TRUE(client.wait(0x701)) << "boot-up";
  }
  static daemon::BusSetup setup(const canopen::Ceilings& ceilings, const canopen::AccessKeys& keys,
                                const std::string& folder) {
    return {.interface = BusClient::name(),
            .lost_after_s = 0,
            .folder = folder,
            .ceilings = ceilings,
            .keys = keys,
            .board = "bench"};
  }
  /// As the loop takes them, without stepping.
  int take_sets() {
    int taken = 0;
    daemon::ParameterSet* set = nullptr;
    while (links.new_sets.pop(set)) {
      links.old_sets.push(set);
      ++taken;
    }
    return taken;
  }

  BusClient client;
  daemon::LoopLinks links;
  daemon::LoopFigures figures;
  daemon::ParameterDesk desk;
  daemon::BusService service;
};

TEST(BusService, TellsTheNodeOfLoopAndBoard) {
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

// More changes than the loop takes are refused; what was promised comes when there is room.
TEST(BusService, RefusesWhatTheLoopHasNoRoomFor) {
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
  EXPECT_EQ(rig.client.set({0x2102, 1}, 1, 1), Abort::transfer);
  EXPECT_EQ(rig.take_sets(), 8);
  // The ninth had been promised: it comes by itself.
  const auto promised = static_cast<double>(said);
  for (int i = 0; i < 500 && rig.desk.settings().strain.proportional != promised; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(rig.desk.settings().strain.proportional, promised);
  EXPECT_EQ(rig.client.set(gain, as_bits(6.F)), Abort::none);
}

// SIGHUP has read other settings: a write over the bus does not take them back.
TEST(BusService, GoesOnFromSettingsThatOthersGive) {
  Rig rig;
  EXPECT_EQ(rig.client.set({0x2102, 1}, 1, 1), Abort::none);
  EXPECT_EQ(rig.client.set(gain, as_bits(5.F)), Abort::none);
  Settings<double> given = rig.desk.settings();
  given.strain.proportional = 7;
  given.limits.power_W = 0.75;
  ASSERT_TRUE(rig.desk.change(given));
  for (int i = 0; i < 500 && rig.client.get(gain) != as_bits(7.F); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(as_real(rig.client.get(gain)), 7.F);
  EXPECT_EQ(rig.client.get({0x2102, 2}) & 0xFFU, 0U) << "the transaction is over";
  EXPECT_EQ(rig.client.set({0x2100, 2}, as_bits(2.F)), Abort::none);
  for (int i = 0; i < 500 && rig.desk.settings().strain.integral_1_s != 2; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(rig.desk.settings().strain.proportional, 7);
  EXPECT_EQ(rig.desk.settings().limits.power_W, 0.75);
}

// Of the board file, each of them; neither one by one nor as a set.
TEST(BusService, NoWriteRaisesACeilingOfTheBoard) {
  const Settings<double> s = test_settings();
  const canopen::Ceilings at = canopen::ceilings_at(s);
  Rig rig(at);
  constexpr Key tuning{0x2102, 1};
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

TEST(BusService, TheKeysOfTheBoardOpenTheLevels) {
  Rig rig({}, {.tune = 11, .set_up = 22});
  EXPECT_EQ(rig.client.get({0x2003, 1}), 0U);
  EXPECT_EQ(rig.client.set(gain, as_bits(1.F)), Abort::local);
  rig.client.set({0x2003, 2}, 11);
  EXPECT_EQ(rig.client.set(gain, as_bits(1.F)), Abort::none);
  EXPECT_EQ(rig.client.set({0x2110, 1}, as_bits(0.11F)), Abort::local);
  rig.client.set({0x2003, 2}, 22);
  EXPECT_EQ(rig.client.set({0x2110, 1}, as_bits(0.11F)), Abort::none);
}

TEST(BusService, AResetOfTheNodeEndsTheLoop) {
  Rig rig;
  rig.client.nmt(130);
  EXPECT_TRUE(rig.client.wait(0x701));
  EXPECT_FALSE(rig.links.stop) << "the communication alone begins anew";
  rig.client.nmt(129);
  for (int i = 0; i < 500 && !rig.links.stop; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(rig.links.stop);
  EXPECT_TRUE(rig.links.restart);
  EXPECT_FALSE(rig.service.command_source().listen(0).command.arm);
  EXPECT_FALSE(rig.client.wait(0x701, 50)) << "that is said by the next one";
}

/// What the next start takes.
float stored_current_A(const std::string& folder) {
  hal::FileStore store(folder);
  const Loaded<double> loaded = load_settings<double>(store);
  return loaded.reason == LoadReason::none ? 0
                                           : static_cast<float>(loaded.settings.limits.current_A);
}

// A reset of the communication comes while a save is under way: its result answers no later one.
TEST(BusService, ASaveAfterAResetIsItsOwn) {
  const TemporaryFolder folder;
  Rig rig({}, {}, folder.path().string());
  constexpr Key limit{0x2020, 2};
  const float given_A = as_real(rig.client.get(limit));
  for (int i = 1; i <= 20; ++i) {
    rig.take_sets();
    rig.client.send(0x601, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
    std::this_thread::sleep_for(std::chrono::microseconds(100 * i));
    rig.client.nmt(130);
    ASSERT_TRUE(rig.client.wait(0x701)) << "boot-up";
    const float lower_A = given_A * (1.F - 0.01F * static_cast<float>(i));
    ASSERT_EQ(rig.client.set(limit, as_bits(lower_A)), Abort::none);
    ASSERT_EQ(rig.client.set({0x1010, 1}, canopen::store_signature), Abort::none);
    EXPECT_EQ(stored_current_A(folder.path().string()), lower_A)
        << "it was said to be stored: " << i;
  }
}

// What the bus has stored is damaged: a fault until somebody stores it anew. LSS is nobody who has
// looked at it.
void damaged_settings_of_the_bus(const std::string& content) {
  const TemporaryFolder folder;
  const std::string image = folder.write("communication", content);
  Rig rig({}, {}, folder.path().string());
  const auto blocks = [&] {
    return rig.service.command_source().listen(0).external.has(Fault::store_outdated);
  };
  rig.links.faults = FaultSet(Fault::store_outdated).bits();  // as the start of a daemon finds it
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

TEST(BusService, DamagedSettingsOfTheBusAreAFault) {
  damaged_settings_of_the_bus("SC, but no image");
  damaged_settings_of_the_bus("");
}

// LSS has no say in the interface's bit rate, and says so.
TEST(BusService, AnotherBitRateIsNotSupported) {
  Rig rig;
  rig.client.send(0x7E5, 8, {0x04, 1});
  rig.client.send(0x7E5, 8, {0x13, 0, 2});
  const auto answer = rig.client.wait(0x7E4);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->data, (BusClient::Bytes{0x13, 1}));
  rig.client.send(0x7E5, 8, {0x15, 10});
  rig.client.send(0x7E5, 8, {0x5E});
  const auto node_id = rig.client.wait(0x7E4);
  ASSERT_TRUE(node_id);
  EXPECT_EQ(node_id->data, (BusClient::Bytes{0x5E, 1})) << "it goes on";
}

}  // namespace
}  // namespace smaservo::test
