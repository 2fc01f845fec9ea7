#include "firmware/daemon/bus/kept_settings.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/text/settings_file.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::kept_settings_test {
namespace {

/// The newest slot of two is damaged: the older one has looser limits.
TEST(KeptSettings, ADamagedNewestSlotIsAFault) {
  const TemporaryFolder folder;
  const std::string path = folder.path().string();
  Settings<double> settings = stored_settings<double>(bench::standard_settings());
  ASSERT_EQ(daemon::store_settings(path, settings), "");
  settings.limits.current_A *= 0.5;
  ASSERT_EQ(daemon::store_settings(path, settings), "");
  EXPECT_TRUE(daemon::keep_settings(path, settings, true).faults.empty());
  std::string image = file_text(path + "/settings.0");
  image[image.size() - 1] = static_cast<char>(image.back() ^ 1);
  std::ofstream(path + "/settings.0", std::ios::binary) << image;
  const daemon::KeptSettings kept = daemon::keep_settings(path, settings, true);
  EXPECT_EQ(kept.faults, FaultSet(Fault::store_outdated));
  EXPECT_EQ(kept.said.back(), "limits.current_A: 0.4 in force, 0.2 in slot 0");
  ASSERT_EQ(kept.lost.size(), 1U);
  EXPECT_EQ(kept.lost[0].key, (Key{0x2020, 2}));
  std::filesystem::remove(path + "/settings.0");
  EXPECT_EQ(daemon::keep_settings(path, settings, true).faults, FaultSet(Fault::store_outdated));
  ASSERT_EQ(daemon::store_settings(path, settings), "");
  EXPECT_TRUE(daemon::keep_settings(path, settings, true).faults.empty()) << "stored anew";
  std::filesystem::remove(path + "/settings.1");
  EXPECT_EQ(daemon::keep_settings(path, settings, true).faults, FaultSet(Fault::store_outdated));
  EXPECT_EQ(daemon::forget_settings(path), "");
  EXPECT_TRUE(daemon::keep_settings(path, settings, true).faults.empty());
  EXPECT_FALSE(daemon::has_settings(path));
}

}  // namespace
}  // namespace smaservo::test::kept_settings_test
