#include "firmware/daemon/process/last_run.hpp"

#include <gtest/gtest.h>

#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::last_run_test {
namespace {

TEST(LastRun, KnowsAPowerCutByTheMachinesStart) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  {
    daemon::RunMark(state, "boot-1").set(daemon::RunMark::State::heated);
  }
  const daemon::RunMark mark(state, "boot-2");
  EXPECT_EQ(mark.last().ending, daemon::Ending::power);
  EXPECT_TRUE(mark.last().heated);
  EXPECT_EQ(daemon::describe(mark.last()),
            "the machine lost its power or was reset while the wire was heated");
}

TEST(LastRun, KeepsWhatTheServiceManagerSays) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  {
    EXPECT_EQ(daemon::RunMark(state, "boot").last().ending, daemon::Ending::none);
  }
  daemon::keep_service_result(state, "watchdog");
  {
    const daemon::RunMark mark(state, "boot");
    EXPECT_EQ(daemon::describe(mark.last()),
              "the last run was killed while the wire was off; service result: watchdog");
  }
  daemon::RunMark(state, "boot").set(daemon::RunMark::State::ended);
  EXPECT_FALSE(daemon::RunMark(state, "boot").last().unclean());
}

}  // namespace
}  // namespace smaservo::test::last_run_test
