// The bus's thread, its disk and the machine's clock and multicast: that they are wired to the
// rounds (tests/firmware/daemon/bus/bus_rounds_test.cpp), which have the properties.

#include "firmware/daemon/bus/bus_service.hpp"

#include <gtest/gtest.h>

#include "bus_client.hpp"
#include "firmware/parameters/store/store.hpp"
#include "hal/linux/system/file_store.hpp"
#include "tests/firmware/device/test_device.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::bus_service_test {
namespace {

using canopen::Abort;

struct Rig {
  explicit Rig(const std::string& folder = "", double lost_after_s = 0)
      : service(setup(folder, lost_after_s), desk, links, figures) {
    service.start();
    EXPECT_TRUE(client.wait(0x701)) << "boot-up";
  }
  static daemon::BusSetup setup(const std::string& folder, double lost_after_s) {
    daemon::BusSetup setup{};
    setup.interface = MulticastLink::name();
    setup.lost_after_s = lost_after_s;
    setup.folder = folder;
    return setup;
  }

  BusClient client;
  daemon::LoopLinks links;
  daemon::LoopFigures figures;
  daemon::ParameterDesk desk{test_settings(), links};
  daemon::BusService service;
};

TEST(BusService, LivesByTheClockOfTheMachine) {
  Rig rig("", 0.05);
  rig.figures.cycles = 1234;
  rig.client.get({0x1000, 0});
  EXPECT_EQ(rig.client.get({0x2210, 1}), 1234U);
  EXPECT_TRUE(becomes([&] {
    return rig.service.command_source().listen(0).external.has(Fault::bus_lost);
  })) << "nobody says anything";
  EXPECT_EQ(rig.client.set({0x1017, 0}, 10, 2), Abort::none);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(rig.client.wait(0x701)) << "heartbeat " << i;
  }
  rig.client.nmt(129);
  EXPECT_TRUE(becomes([&] { return rig.links.stop.load(); }));
}

// Wherever the reset meets the save that is under way, in a thread of its own.
TEST(BusService, ASaveThatIsAnsweredIsOnTheDisk) {
  const TemporaryFolder folder;
  Rig rig(folder.path().string());
  constexpr Key limit{0x2020, 2};
  for (int i = 1; i <= 5; ++i) {
    rig.client.send(0x601, 8, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
    rig.client.nmt(130);
    ASSERT_TRUE(rig.client.wait(0x701)) << "boot-up";
    const float limit_A = 0.3F - 0.01F * static_cast<float>(i);
    ASSERT_EQ(rig.client.set(limit, canopen::as_bits(limit_A)), Abort::none);
    ASSERT_EQ(rig.client.set({0x1010, 1}, canopen::store_signature), Abort::none);
    hal::FileStore store(folder.path().string());
    const Loaded<double> loaded = load_settings<double>(store);
    ASSERT_NE(loaded.reason, LoadReason::none);
    EXPECT_EQ(static_cast<float>(loaded.settings.limits.current_A), limit_A);
  }
}

}  // namespace
}  // namespace smaservo::test::bus_service_test
