#pragma once
// Where measured data of others are, which the project may not ship.

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "tests/places.hpp"

namespace smaservo::test {

/// Tests say SKIPPED where the folder is not.
class MeasuredData : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* given = std::getenv("SMASERVO_SHARED");
    folder_ = std::filesystem::path(given != nullptr ? given : test::shared_folder()) / "data";
    if (!std::filesystem::is_directory(folder_)) {
      GTEST_SKIP() << folder_ << " is not there: third-party data that the project may not ship";
    }
  }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

}  // namespace smaservo::test
