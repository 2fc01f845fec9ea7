// Ctrl-C in the middle of long work of the real program.

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "hal/linux/system/descriptor.hpp"
#include "model/files/wire/wire_fields.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/host-sim/recordings.hpp"
#include "tests/host-sim/replay/replays.hpp"
#include "tests/patience.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using Texts = Program::Texts;

/// A bath run without resistance.
std::string bath_file() {
  const Recording r;
  return csv({{"temperature_degC", r.temperature_degC},
              {"strain_ref", r.strain},
              {"stress_MPa", std::vector<double>(r.strain.size(), 150)}});
}

/// Whether the process catches SIGINT by now.
bool listens(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("SigCgt:")) {
      return (std::stoul(line.substr(7), nullptr, 16) >> (SIGINT - 1) & 1U) != 0;
    }
  }
  return false;
}

// Copies of the run make the fit longer than any pause of the test, and change nothing of its
// result.
TEST(Identify, CtrlCKeepsTheBestSoFar) {
  std::signal(SIGINT, SIG_DFL);  // jobs in the background inherit that it is ignored
  Program program;
  program.folder().write("bath.csv", bath_file());
  ASSERT_EQ(program.run({"identify", "--out", "near.toml", "bath.csv"}).status, 0);
  Texts arguments{"identify", "--out", "w.toml", "--from", "near.toml", "--threads", "1"};
  for (int copy = 0; copy < 40; ++copy) {
    arguments.push_back("bath" + std::to_string(copy) + ".csv");
    program.folder().write(arguments.back(), bath_file());
  }
  const pid_t child = program.start(arguments, open("/dev/null", O_RDONLY | O_CLOEXEC),
                                    program.folder() / "summary");
  ASSERT_TRUE(becomes([&] { return listens(child); }));
  kill(child, SIGINT);
  const Finished f = program.wait(child);
  EXPECT_EQ(f.status, 128 + SIGINT) << f.err;
  EXPECT_THAT(f.out, HasSubstr("INTERRUPTED"));
  EXPECT_THAT(file_text(program.folder() / "w.toml"), HasSubstr("interrupted"));
  EXPECT_NO_THROW(files::load_wire(program.folder() / "w.toml"));
}

/// A terminal whose other end is the test.
class Terminal {
 public:
  Terminal() : end_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (grantpt(end_.number()) != 0 || unlockpt(end_.number()) != 0 ||
        ptsname_r(end_.number(), name_.data(), name_.size()) != 0) {
      throw std::runtime_error("no terminal");
    }
  }
  std::string name() const { return name_.data(); }
  /// Waits until the program has written something; empty: it has ended without.
  std::string read() const {
    std::array<char, 256> text{};
    const ssize_t size = ::read(end_.number(), text.data(), text.size());
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "";
  }

 private:
  hal::Descriptor end_;
  std::array<char, 64> name_{};
};

// When it says on the terminal which system it identifies, it is in the middle.
TEST(CompareCommand, CtrlCLeavesNothingBehind) {
  std::signal(SIGINT, SIG_DFL);
  Program program;
  const Terminal terminal;
  program.terminal = terminal.name();
  program.folder().write("c.json", "old");
  const std::vector<std::string> before = program.folder().names();
  const pid_t child =
      program.start({"compare", "--train", shipped("150MPa.csv"), "--test", shipped("400MPa.csv"),
                     "--out", "c.json", "--report", "r.html"},
                    open("/dev/null", O_RDONLY | O_CLOEXEC), "/dev/null");
  EXPECT_THAT(terminal.read(), HasSubstr("compare, "));
  ASSERT_EQ(kill(child, SIGINT), 0);
  EXPECT_EQ(program.wait(child).status, 128 + SIGINT);
  EXPECT_EQ(program.folder().names(), before);
  EXPECT_EQ(file_text(program.folder() / "c.json"), "old");
}

/// A program of the user's leaves its process number and then does nothing for ever.
TEST(EvaluateCommand, CtrlCEndsTheUsersProgramAndItsFiles) {
  std::signal(SIGINT, SIG_DFL);
  Program program;
  const std::string number = program.folder() / "number";
  const std::string observer =
      program.folder().write("observer", "#!/bin/sh\necho $$ > " + number + ".new && mv " + number +
                                             ".new " + number + "\nexec sleep 100000\n");
  ASSERT_EQ(chmod(observer.c_str(), S_IRWXU), 0);
  const std::string scratch = program.folder() / "scratch";
  ASSERT_EQ(mkdir(scratch.c_str(), S_IRWXU), 0);
  setenv("TMPDIR", scratch.c_str(), 1);
  const pid_t child = program.start({"evaluate", "--units", "1", "--runs", "1", "--row",
                                     "uncalibrated", "--observer-program", observer},
                                    open("/dev/null", O_RDONLY | O_CLOEXEC), "/dev/null");
  unsetenv("TMPDIR");
  ASSERT_TRUE(becomes([&] { return std::ifstream(number).good(); }));
  ASSERT_EQ(kill(child, SIGINT), 0);
  EXPECT_EQ(program.wait(child).status, 128 + SIGINT);
  pid_t users = 0;
  ASSERT_TRUE(std::ifstream(number) >> users);
  EXPECT_EQ(kill(users, 0), -1) << "the user's program still runs";
  EXPECT_TRUE(std::filesystem::is_empty(scratch));
}

}  // namespace
}  // namespace smaservo::test
