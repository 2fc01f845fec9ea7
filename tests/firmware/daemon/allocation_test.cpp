// The loop's thread takes no memory from the heap and makes no system call but those of a loop.

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "firmware/daemon/boards/simulation.hpp"
#include "firmware/daemon/bus/bus_pump.hpp"
#include "firmware/daemon/loop/desk.hpp"
#include "firmware/daemon/loop/loop.hpp"
#include "firmware/daemon/process/sandbox.hpp"
#include "firmware/text/settings_file.hpp"
#include "tests/firmware/device/allocation_trap.hpp"

namespace smaservo::test::daemon_allocation_test {
namespace {

constexpr std::int64_t ms = 1'000'000;

struct Bench {
  Bench()
      : desk(bench::standard_settings(), links),
        simulation(bench::standard_closed_loop(desk.settings())),
        demonstration(desk.settings()),
        device(desk.first()) {
    links.record = &ring;
  }
  daemon::LoopLinks links;
  daemon::LoopFigures figures;
  daemon::ParameterDesk desk;
  daemon::Simulation simulation;
  daemon::Demonstration demonstration;
  daemon::PreparedDevice device;
  daemon::Ring<daemon::CycleRecord> ring{256};
};

TEST(LoopAllocation, None) {
  Bench bench;
  daemon::Loop loop(bench.simulation, daemon::NoPace{}, bench.device, bench.demonstration,
                    bench.links, bench.figures, {ms, true});
  Settings<double> settings = bench.desk.settings();
  daemon::CycleRecord record{};
  bool heated = false;
  for (int i = 0; i < 5000; ++i) {
    if (i % 500 == 100) {
      settings.strain.proportional += 0.01;
      settings = stored_settings<double>(settings);
      ASSERT_TRUE(bench.desk.change(settings));
    }
    {
      const AllocationTrap trap;
      loop.cycle();
    }
    ASSERT_EQ(AllocationTrap::caught(), 0) << "cycle " << i;
    bench.ring.pop(record);
    heated = heated || record.cycle.output.drive_current_A > 0.1;
  }
  EXPECT_TRUE(heated);
}

#ifndef SMASERVO_SANITIZED
/// How a child ends whose loop's thread may make a loop's calls only, and then does this.
int end_of(void (*then)()) {
  const pid_t child = fork();
  if (child == 0) {
    auto bench = std::make_unique<Bench>();
    std::thread([&] {
      daemon::Loop loop(bench->simulation, daemon::Pace<hal::MonotonicClock>(ms), bench->device,
                        bench->demonstration, bench->links, bench->figures, {ms, true});
      if (!daemon::allow_loop_calls_only().empty()) {
        _exit(77);
      }
      for (int i = 0; i < 200; ++i) {
        loop.cycle();
      }
      then();
    }).join();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST(LoopCalls, AreThoseOfALoop) {
  const int status = end_of([] {});
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  if (WEXITSTATUS(status) == 77) {
    GTEST_SKIP() << "SKIPPED: the kernel has no seccomp filters";
  }
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const int caught = end_of([] { close(open("/dev/null", O_RDONLY)); });
  EXPECT_TRUE(WIFSIGNALED(caught));
  EXPECT_EQ(WTERMSIG(caught), SIGSYS);
}
#endif

}  // namespace
}  // namespace smaservo::test::daemon_allocation_test
