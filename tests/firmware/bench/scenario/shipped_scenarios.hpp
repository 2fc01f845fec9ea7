#pragma once
// The shipped scenarios of closed loops.

#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "tests/places.hpp"

namespace smaservo::test {

inline std::filesystem::path scenario_folder() {
  return std::filesystem::path(test::source_folder()) / "host-sim/scenarios";
}

inline std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(scenario_folder())) {
    if (entry.path().extension() == ".toml") {
      names.push_back(entry.path().stem().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

inline bench::ClosedLoopScenario shipped_scenario(const std::string& name) {
  bench::ClosedLoopScenario scenario =
      bench::load_closed_loop(scenario_folder() / (name + ".toml"));
#ifdef SMASERVO_SANITIZED
  // Many times slower; all have begun to move by then.
  scenario.duration_s = std::min(scenario.duration_s, 3.0);
#endif
  return scenario;
}

/// The end of a test's name.
inline std::string suffix(const ::testing::TestParamInfo<std::string>& tested) {
  std::string name = tested.param;
  std::erase(name, '-');
  return name;
}

}  // namespace smaservo::test
