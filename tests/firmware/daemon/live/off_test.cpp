// smaservod --off, the real program, after runs that could not switch off by themselves.

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <sysexits.h>
#include <vector>

#include "daemon_program.hpp"
#include "firmware/daemon/process/last_run.hpp"
#include "tests/hal/linux/devices/kernel_tree.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test::off_test {
namespace {

/// A board with a PWM on the kernel's files of a test, and smaservod --off on it.
class OffBoard {
 public:
  OffBoard() {
    setenv("SMASERVO_ROOT", tree_.root().c_str(), 1);
    tree_.adc();
    for (const char* const chip : {"0", "1"}) {
      for (const char* const file : {"duty_cycle", "period", "enable"}) {
        tree_.put(pwm(chip) + file, "");
      }
    }
    write("0", "24");
  }
  OffBoard(const OffBoard&) = delete;
  OffBoard& operator=(const OffBoard&) = delete;
  ~OffBoard() {
    unsetenv("SMASERVO_ROOT");
    unsetenv("EXIT_STATUS");
  }

  const KernelTree& tree() const { return tree_; }
  std::string state(const std::string& file = "") const { return folder_ / "state" + file; }
  void write(const std::string& chip, const std::string& supply_V) const {
    std::ofstream(folder_ / "board.toml")
        << "name = \"a\"\n[front_end]\ntype = \"iio\"\ndevice = \"ad7606\"\n"
        << "current = { channel = \"in_voltage0\", per_code = 1e-6 }\n"
        << "voltage = { channel = \"in_voltage1\", per_code = 1e-6 }\n"
        << "[drive]\ntype = \"pwm\"\nmax_mA = 500\nchip = \"pwmchip" << chip
        << "\"\nsupply_V = " << supply_V << "\n";
  }
  /// As the daemon has left them when it could do nothing any more.
  void heat() const {
    for (const char* const chip : {"0", "1"}) {
      tree_.put(pwm(chip) + "duty_cycle", "30000");
    }
  }
  bool heats(const std::string& chip) const {
    return tree_.text(pwm(chip) + "duty_cycle").front() == '3';
  }
  Ended run(const std::string& option) const { return Program(folder_, arguments(option)).wait(); }
  /// Killed as soon as the board is its own.
  void run_and_kill() const {
    Program program(folder_, arguments("--no-real-time"));
    ASSERT_TRUE(becomes([&] { return std::filesystem::exists(state("/board.toml")); }));
    program.kill(SIGKILL);
    program.wait();
  }

 private:
  static std::string pwm(const std::string& chip) {
    return "sys/class/pwm/pwmchip" + chip + "/pwm0/";
  }
  std::vector<std::string> arguments(const std::string& option) const {
    return {"--board", folder_ / "board.toml", "--settings", state(), option};
  }
  TemporaryFolder folder_;
  KernelTree tree_;
};

TEST(Off, TheOutputsAreThoseOfTheRunAndOfTheFile) {
  const OffBoard board;
  board.run_and_kill();
  EXPECT_EQ(std::filesystem::status(board.state("/board.toml")).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const auto off = [&](int code, bool first_off, bool second_off, const std::string& says) {
    board.heat();
    const Ended ended = board.run("--off");
    EXPECT_TRUE(ended.exited_with(code)) << ended.errors;
    EXPECT_EQ(board.heats("0"), !first_off) << says;
    EXPECT_EQ(board.heats("1"), !second_off) << says;
    EXPECT_NE(ended.errors.find(says), std::string::npos) << ended.errors;
    EXPECT_EQ(ended.errors.empty(), says.empty()) << ended.errors;
  };
  off(0, true, false, "");
  board.write("0", "5000");
  off(EX_CONFIG, true, false, "supply_V = 5000: must be");
  board.write("1", "24");
  off(0, true, true, "");
  // A device or a copy that is not what it was keeps nothing else on.
  board.tree().remove("sys/class/pwm/pwmchip0");
  board.tree().put("sys/class/pwm/pwmchip0/pwm0/duty_cycle", "30000");
  off(1, true, true, "pwmchip0/pwm0/period");
  std::ofstream(board.state("/board.toml")) << "name = \"a\"\n";
  off(EX_CONFIG, false, true, "state/board.toml:1: front_end: is missing");
  std::filesystem::remove(board.state("/board.toml"));
  off(0, false, true, "");
}

// What udev asks for each device that appears.
TEST(Owns, IsWhatTheBoardFileNames) {
  const OffBoard board;
  board.tree().put("sys/bus/iio/devices/iio:device7/name", "other\n");
  const auto owns = [&](const char* device, int code) {
    const Ended ended = board.run(std::string("--owns=") + device);
    EXPECT_TRUE(ended.exited_with(code)) << device << ": " << ended.errors;
  };
  for (const char* const device : {"iio:device3", "pwmchip0"}) {
    owns(device, 0);
  }
  for (const char* const device : {"iio:device7", "iio:device9", "pwmchip1", "spidev0.0",
                                   "gpiochip0", "mem", "..", "../devices/iio:device3"}) {
    owns(device, 1);
  }
  board.write("1", "24");
  owns("pwmchip0", 1);
  owns("pwmchip1", 0);
  board.write("0", "5000");
  owns("pwmchip0", EX_CONFIG);
}

// ExecStopPost after a start that was refused: the journal need not have it twice.
TEST(Off, WhatTheDaemonHasSaidIsNotSaidAgain) {
  const OffBoard board;
  board.run_and_kill();
  board.write("0", "5000");
  board.heat();
  EXPECT_TRUE(board.run("--no-real-time").exited_with(EX_CONFIG));
  setenv("EXIT_STATUS", "78", 1);
  const Ended ended = board.run("--off");
  EXPECT_TRUE(ended.exited_with(EX_CONFIG));
  EXPECT_EQ(ended.errors, "");
  EXPECT_FALSE(board.heats("0"));
}

// Who has been refused has driven nothing: the copy is that of who runs.
TEST(Off, ASecondOneLeavesTheCopyAlone) {
  const OffBoard board;
  board.run_and_kill();
  const std::string copy = file_text(board.state("/board.toml"));
  const daemon::RunMark first(board.state(), "boot");
  board.write("1", "24");
  EXPECT_TRUE(board.run("--no-real-time").exited_with(1));
  EXPECT_EQ(file_text(board.state("/board.toml")), copy);
}

}  // namespace
}  // namespace smaservo::test::off_test
