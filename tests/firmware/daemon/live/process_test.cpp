// The real program, from outside: how it ends, and what the next one says of it.

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <sysexits.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "bus_client.hpp"
#include "daemon_program.hpp"
#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/canopen/node/communication.hpp"
#include "firmware/daemon/process/crash.hpp"
#include "firmware/daemon/process/sandbox.hpp"
#include "firmware/text/settings_file.hpp"
#include "hal/linux/system/descriptor.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/places.hpp"

namespace smaservo::test::process_test {
namespace {

std::vector<std::string> in_time(const std::string& state) {
  return {"--board", "sim", "--no-real-time", "--settings", state};
}
std::vector<std::string> at_once(const std::string& state) {
  return {"--board", "sim", "--at-once", "--for", "1", "--json", "--settings", state};
}

/// Heats, is ended by this signal, and starts again: what is said then. In simulated time: on a
/// machine with other work to do, a loop in time may see too many of its deadlines pass to heat.
nlohmann::json after(int signal, bool unclean) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  {
    Program program(folder, {"--board", "sim", "--at-once", "--settings", state});
    EXPECT_TRUE(becomes([&] { return file_text(state + "/run").starts_with("heated"); }));
    program.kill(signal);
    const Ended ended = program.wait();
    EXPECT_EQ(WIFSIGNALED(ended.status), unclean) << ended.errors;
    EXPECT_EQ(ended.exited_with(0), !unclean) << ended.errors;
  }
  Program again(folder, at_once(state));
  const Ended ended = again.wait();
  EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
  nlohmann::json said = nlohmann::json::parse(ended.out);
  const bool blocked = said.at("blocks").dump().find("unclean_boot") != std::string::npos;
  EXPECT_EQ(blocked, unclean) << ended.out;
  if (unclean) {
    EXPECT_EQ(said.at("drive_current_A"), 0) << "not before it is acknowledged";
    EXPECT_NE(file_text(state + "/history"), "");
  }
  return said;
}

TEST(Process, SaysThatItWasKilled) {
  EXPECT_EQ(after(SIGKILL, true).at("last_run"),
            "the last run was killed while the wire was heated");
}

TEST(Process, SaysThatItCrashed) {
  const std::string said = after(SIGSEGV, true).at("last_run");
  EXPECT_TRUE(said.starts_with("the last run crashed with signal 11")) << said;
  EXPECT_TRUE(said.ends_with("while the wire was heated")) << said;
}

/// It heats, in simulated time.
bool heats(const std::string& state) {
  return becomes([&] { return file_text(state + "/run").starts_with("heated"); });
}

// Each signal that there is: its own end with the outputs off, a crash with a mark, or nothing.
TEST(Process, NoSignalEndsItWithHeat) {
  constexpr std::array crash{SIGQUIT, SIGILL, SIGTRAP, SIGABRT, SIGBUS, SIGFPE, SIGSEGV, SIGSYS};
  constexpr std::array end{SIGINT, SIGTERM, SIGPWR, SIGXCPU};
  constexpr std::array unstoppable{SIGKILL, SIGSTOP};
  const auto is_in = [](const auto& list, int signal) {
    return std::ranges::find(list, signal) != list.end();
  };
  const TemporaryFolder folder;
  {
    const std::string state = folder / "ignored";
    Program program(folder, {"--board", "sim", "--at-once", "--settings", state});
    ASSERT_TRUE(heats(state));
    for (int signal = 1; signal <= 64; ++signal) {
      if (!is_in(crash, signal) && !is_in(end, signal) && !is_in(unstoppable, signal)) {
        program.kill(signal);
      }
    }
    program.kill(SIGTERM);
    const Ended ended = program.wait();
    EXPECT_TRUE(ended.exited_with(0)) << "status " << ended.status << ": " << ended.errors;
    EXPECT_TRUE(file_text(state + "/run").starts_with("ended"));
  }
  for (const int signal : end) {
    const std::string state = folder / "end" + std::to_string(signal);
    Program program(folder, {"--board", "sim", "--at-once", "--settings", state});
    ASSERT_TRUE(heats(state));
    program.kill(signal);
    const Ended ended = program.wait();
    EXPECT_TRUE(ended.exited_with(signal == SIGXCPU ? 1 : 0)) << signal << ": " << ended.errors;
    EXPECT_TRUE(file_text(state + "/run").starts_with("ended")) << signal;
  }
  for (const int signal : crash) {
    const std::string state = folder / "crash" + std::to_string(signal);
    Program program(folder, {"--board", "sim", "--at-once", "--settings", state});
    ASSERT_TRUE(heats(state));
    program.kill(signal);
    const Ended ended = program.wait();
    EXPECT_TRUE(WIFSIGNALED(ended.status) && WTERMSIG(ended.status) == signal) << signal;
    EXPECT_TRUE(file_text(state + "/run").starts_with("crashed:" + std::to_string(signal) + ":"))
        << signal << ": " << file_text(state + "/run");
  }
}

/// Stops all of its threads for at least so long.
void stop_for(const Program& program, std::chrono::milliseconds time) {
  program.kill(SIGSTOP);
  int status = 0;
  ASSERT_EQ(waitpid(program.process(), &status, WUNTRACED), program.process());
  ASSERT_TRUE(WIFSTOPPED(status)) << status;
  std::this_thread::sleep_for(time);
  program.kill(SIGCONT);
}

/// The output of a board: a file that says "on" until it is switched off.
struct FileOutput {
  explicit FileOutput(const std::string& path) : file(open(path.c_str(), O_RDWR | O_CREAT, 0644)) {
    EXPECT_EQ(pwrite(file.number(), "on ", 3, 0), 3);
  }
  hal::Descriptor file;
  std::string off = "off";
  std::vector<hal::OffAction> actions() { return {{file.number(), 0, off.data(), off.size()}}; }
};

/// Takes 4 KB of the stack for each level. Called by a pointer, so that no compiler makes a loop.
int descend(int levels);
int (*volatile const go_down)(int) = descend;
int descend(int levels) {
  volatile char room[4096];
  room[levels % 4096] = 1;
  return levels == 0 ? 0 : go_down(levels - 1) + room[0];
}

/// The signal that ends a process with a CrashGuard which does this; its output has to be off then.
template <class Misdeed>
int signal_that_ends(Misdeed misdeed) {
  const TemporaryFolder folder;
  FileOutput output(folder / "output");
  const pid_t child = fork();
  if (child == 0) {
    const std::atomic<bool> heated{true};
    const daemon::CrashGuard guard(output.actions(), nullptr, heated);
    misdeed();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << status;
  EXPECT_EQ(file_text(folder / "output"), "off");
  return WTERMSIG(status);
}

// A stack that has run over has no room for its handler.
TEST(Process, ACrashOfTheStackSwitchesOffAsWell) {
  EXPECT_EQ(signal_that_ends([] { go_down(1'000'000); }), SIGSEGV);
}

#ifndef SMASERVO_SANITIZED  // sanitizers make calls of their own
// What the sandbox forbids ends the program by a signal whose handler switches off.
TEST(Process, AForbiddenCallSwitchesOff) {
  EXPECT_EQ(signal_that_ends([] {
              daemon::allow_loop_calls_only();
              getppid();
            }),
            SIGSYS);
}
#endif

// Whoever reads the log has gone: the run goes on, and so does its log for those who come.
TEST(Process, ALogThatNobodyReadsEndsNothing) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  const std::string status = folder / "status.json";
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  close(ends[0]);
  Program program(folder,
                  {"--board", "sim", "--no-real-time", "--settings", state, "--status", status}, "",
                  ends[1]);
  close(ends[1]);
  ASSERT_TRUE(heats(state));
  program.kill(SIGHUP);  // is answered in the log
  stop_for(program, std::chrono::milliseconds(1500));
  // So is the fault.
  EXPECT_TRUE(becomes([&] {
    return file_text(status).find("\"first_cause\":\"loop_stalled\"") != std::string::npos;
  })) << file_text(status);
  program.kill(SIGTERM);
  EXPECT_TRUE(program.wait().exited_with(0));
}

// ulimit -f
TEST(Process, AFullQuotaEndsTheRecordingOnly) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{100'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  Program program(folder, {"--board", "sim", "--at-once", "--for", "3", "--settings", state,
                           "--record", folder / "run.csv"});
  setrlimit(RLIMIT_FSIZE, &before);
  const Ended ended = program.wait();
  EXPECT_TRUE(ended.exited_with(1)) << "status " << ended.status << ": " << ended.errors;
  EXPECT_NE(ended.out.find("File too large"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("3000 cycles"), std::string::npos) << ended.out;
  EXPECT_TRUE(file_text(state + "/run").starts_with("ended"));
}

// A stopped program does not go on heating, on a simulated wire either; and it is said at once.
TEST(Process, AStoppedProgramIsAStall) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  Program program(folder, in_time(state));
  ASSERT_TRUE(heats(state));
  stop_for(program, std::chrono::milliseconds(1500));
  const auto said = [&](const char* text) {
    return becomes([&] { return file_text(folder / "errors").find(text) != std::string::npos; });
  };
  EXPECT_TRUE(said("loop_stalled: The loop stood still")) << file_text(folder / "errors");
  program.kill(SIGTERM);
  const Ended ended = program.wait();
  EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
  EXPECT_NE(ended.out.find("state fault, first cause loop_stalled"), std::string::npos)
      << ended.out;
}

/// One thread of a program stands still, the others go on.
class HeldThread {
 public:
  HeldThread(pid_t process, const std::string& name) {
    for (const auto& task :
         std::filesystem::directory_iterator(fmt::format("/proc/{}/task", process))) {
      if (file_text(task.path() / "comm") == name + "\n") {
        thread_ = std::stoi(task.path().filename());
      }
    }
    held_ = thread_ > 0 && ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) == 0 &&
            ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr) == 0 &&
            waitpid(thread_, nullptr, __WALL) == thread_;
  }
  HeldThread(const HeldThread&) = delete;
  HeldThread& operator=(const HeldThread&) = delete;
  ~HeldThread() { ptrace(PTRACE_DETACH, thread_, nullptr, nullptr); }

  bool is_held() const { return held_; }

 private:
  pid_t thread_ = 0;
  bool held_ = false;
};

// The loop hangs: while it does, the guard switches off and the log says so.
TEST(Process, TheGuardSwitchesOffWhileTheLoopHangs) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  Program program(folder, in_time(state));
  ASSERT_TRUE(heats(state));
  {
    const HeldThread loop(program.process(), "loop");
    ASSERT_TRUE(loop.is_held()) << std::strerror(errno);
    EXPECT_TRUE(becomes([&] {
      return file_text(folder / "errors")
                 .find("the guard switched the outputs off, because the loop hung") !=
             std::string::npos;
    })) << file_text(folder / "errors");
  }
  EXPECT_TRUE(becomes([&] {
    return file_text(folder / "errors").find("loop_stalled") != std::string::npos;
  })) << file_text(folder / "errors");
  program.kill(SIGTERM);
  EXPECT_TRUE(program.wait().exited_with(0));
}

// It opens what it would use, and runs nothing, however busy the machine is.
TEST(Process, CheckOfASimulationJudgesItsFiles) {
  const TemporaryFolder folder;
  const std::string bad = folder / "bad.toml";
  std::ofstream(bad) << "note = 1\n";
  const std::string steps = test::source_folder() + "/host-sim/scenarios/steps.toml";
  struct Case {
    std::vector<std::string> arguments;
    int code;
    const char* says;
  };
  const Case cases[] = {
      {{"--board", "sim", "--check"}, 0, "settings         ok\n"},
      {{"--board", "sim=" + steps, "--check"}, 0, "scenario         ok\n"},
      {{"--board", "sim=" + bad, "--check"}, EX_CONFIG, "bad.toml"},
      {{"--board", "sim=" + folder / "none.toml", "--check"}, EX_CONFIG, "none.toml"},
      {{"--board", "sim", "--device", bad, "--check"}, EX_CONFIG, "bad.toml"},
      {{"--board", "sim", "--bus", "udp:1.2.3.4", "--check"}, EX_CONFIG, "is no multicast group"},
      {{"--board", "sim", "--bus", "none0", "--check"}, 1, "bus              none0: "},
      {{"--board", "replay=" + folder / "none.csv", "--check"}, EX_CONFIG, "none.csv"},
  };
  for (const Case& c : cases) {
    const Ended ended = Program(folder, c.arguments).wait();
    EXPECT_TRUE(ended.exited_with(c.code)) << c.says << ", status " << ended.status;
    EXPECT_NE((ended.out + ended.errors).find(c.says), std::string::npos)
        << c.says << " in:\n"
        << ended.out << ended.errors;
    EXPECT_EQ(ended.out.find("cycles"), std::string::npos) << ended.out;
  }
}

TEST(Process, EndsCleanlyWhenItIsAskedTo) {
  const nlohmann::json said = after(SIGTERM, false);
  EXPECT_EQ(said.at("last_run"), "the last run ended cleanly");
  EXPECT_EQ(said.at("cycles"), 1000);
  EXPECT_EQ(said.at("state"), "running");
  EXPECT_GT(said.at("drive_current_A"), 0);
}

TEST(Process, TellsTheServiceManagerHowItIs) {
  const TemporaryFolder folder;
  const std::string path = folder / "notify";
  const hal::Descriptor socket(::socket(AF_UNIX, SOCK_DGRAM, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(bind(socket.number(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  const timeval longest{std::chrono::seconds(patience).count(), 0};
  setsockopt(socket.number(), SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof(longest));
  const auto next = [&] {
    std::array<char, 256> text{};
    const ssize_t size = recv(socket.number(), text.data(), text.size(), 0);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "nothing";
  };
  Program program(folder, in_time(folder / "state"), path);
  EXPECT_EQ(next(), "READY=1");
  int alive = 0;
  bool status = false;
  while (alive < 3) {
    const std::string text = next();
    ASSERT_NE(text, "nothing");
    alive += text == "WATCHDOG=1" ? 1 : 0;
    status = status || text.starts_with("STATUS=");
  }
  EXPECT_TRUE(status);
  program.kill(SIGTERM);
  std::string text = next();
  while (text != "STOPPING=1" && text != "nothing") {
    text = next();
  }
  EXPECT_EQ(text, "STOPPING=1");
  EXPECT_TRUE(program.wait().exited_with(0));
}

// Over the bus: heat off, what is stored in force, nothing of the run before.
TEST(Process, AResetOfTheNodeIsANewStart) {
  using canopen::as_bits;
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  constexpr Key gain{0x2100, 1}, cycles{0x2210, 1}, current{0x2200, 10};
  BusClient client;
  Program program(folder, {"--board", "sim", "--no-real-time", "--settings", state, "--bus",
                           MulticastLink::name(), "--record", folder / "run.csv"});
  ASSERT_TRUE(client.wait(0x701)) << "boot-up";
  const auto gets_warm = [&] {
    for (const auto& [word, drive] : {std::pair{6U, 0x21U}, {7U, 0x23U}, {15U, 0x27U}}) {
      client.set({0x6040, 0}, word, 2);
      EXPECT_TRUE(becomes([&] { return (client.get({0x6041, 0}) & 0x6FU) == drive; })) << word;
    }
    return becomes([&] { return canopen::as_real(client.get(current)) > 0; });
  };
  EXPECT_EQ(client.set(gain, as_bits(9.F)), canopen::Abort::none);
  EXPECT_EQ(client.set({0x1010, 1}, canopen::store_signature), canopen::Abort::none);
  EXPECT_EQ(client.set(gain, as_bits(4.F)), canopen::Abort::none);
  EXPECT_EQ(client.set({0x6060, 0}, 1, 1), canopen::Abort::none);
  EXPECT_TRUE(becomes([&] { return client.get(cycles) > 500; })) << "it has started";
  EXPECT_TRUE(gets_warm());
  client.nmt(129);
  ASSERT_TRUE(client.wait(0x701)) << "boot-up";
  EXPECT_EQ(client.get(gain), as_bits(9.F));
  EXPECT_EQ(canopen::as_real(client.get(current)), 0);
  EXPECT_TRUE(becomes([&] { return (client.get({0x6041, 0}) & 0x4FU) == 0x40U; }))
      << "Switch on disabled, when the new run has begun";
  // What was refused stands in the log beside what was changed.
  EXPECT_EQ(client.set(gain, as_bits(-1.F)), canopen::Abort::too_low);
  EXPECT_EQ(client.set(gain, 0, 2), canopen::Abort::too_short);
  EXPECT_EQ(client.link().boot_ups(), 2) << "one of each start";
  program.kill(SIGTERM);
  const Ended ended = program.wait();
  EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
  for (const char* const says :
       {"bus: strain.proportional_W (2100h:1): 0 -> 9, by SDO", "(2100h:1): 9 -> 4, by SDO",
        "(2100h:1): stays 9; -1 by SDO is refused: value too low (abort 06090032h)",
        "(2100h:1): stays 9; 0h by SDO is refused: too short (abort 06070013h)"}) {
    EXPECT_NE(ended.errors.find(says), std::string::npos) << says << " in:\n" << ended.errors;
  }
  EXPECT_NE(ended.errors.find("reset over the bus"), std::string::npos) << ended.errors;
  EXPECT_NE(ended.errors.find("the recording has ended"), std::string::npos) << ended.errors;
}

// The store goes before the file, at the start and at SIGHUP.
TEST(Process, ASettingsFileDoesNotLoosenWhatIsStored) {
  using canopen::as_bits;
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  const std::string file = folder / "device.toml";
  std::ofstream(file) << text::to_toml(bench::standard_settings());
  constexpr Key limit{0x2020, 2};
  BusClient client;
  Program program(folder, {"--board", "sim", "--no-real-time", "--settings", state, "--device",
                           file, "--bus", MulticastLink::name()});
  ASSERT_TRUE(client.wait(0x701)) << "boot-up";
  const std::uint32_t in_file = client.get(limit);
  const std::uint32_t lower = as_bits(0.5F * canopen::as_real(in_file));
  EXPECT_EQ(client.set(limit, lower), canopen::Abort::none);
  program.kill(SIGHUP);
  EXPECT_TRUE(becomes([&] { return client.get(limit) == in_file; }))
      << "nothing is stored: the file is in force again";
  EXPECT_EQ(client.set(limit, lower), canopen::Abort::none);
  EXPECT_EQ(client.set({0x1010, 1}, canopen::store_signature), canopen::Abort::none);
  program.kill(SIGHUP);
  EXPECT_TRUE(becomes([&] {
    return file_text(folder / "errors").find("SIGHUP: nothing is changed: " + state) !=
           std::string::npos;
  })) << file_text(folder / "errors");
  EXPECT_EQ(client.get(limit), lower);
  EXPECT_EQ(client.set({0x1011, 1}, canopen::restore_signature), canopen::Abort::none);
  program.kill(SIGHUP);
  EXPECT_TRUE(becomes([&] { return client.get(limit) == in_file; })) << "the store is empty";
  program.kill(SIGTERM);
  const Ended ended = program.wait();
  EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
  EXPECT_NE(ended.errors.find("by the settings file"), std::string::npos) << ended.errors;
}

/// The reference board with more lines in its settings.
std::string reference_board(const TemporaryFolder& folder, const std::string& lines) {
  const std::string boards = test::source_folder() + "/hal/linux/boards/";
  std::filesystem::create_directories(folder / "devices");
  std::ofstream(folder / "board.toml") << file_text(boards + "reference.toml");
  std::ofstream(folder / "devices/current-sink.toml")
      << file_text(boards + "devices/current-sink.toml") << lines;
  return folder / "board.toml";
}

TEST(Process, RefusesWhatItDoesNotUnderstand) {
  const TemporaryFolder folder;
  struct Case {
    std::vector<std::string> arguments;
    int code;
    const char* says;
  };
  const std::string bad = folder / "bad.toml";
  std::ofstream(bad) << "name = \"a\"\n[front_end]\ntype = \"adc\"\n";
  const std::string wireless = folder / "wireless.toml";
  const std::string device =
      test::source_folder() + "/host-sim/scenarios/devices/sublayers-1000.toml";
  std::ofstream(wireless) << "note = \"\"\n[device]\nsettings = \"" << device
                          << "\"\n[plant]\nwire = \"none-wire.toml\"\n";
  const Case cases[] = {
      {{"--bord", "sim"}, 2, "--bord"},
      {{"--board", folder / "none.toml"}, EX_CONFIG, "none.toml: cannot be read"},
      {{"--board", bad},
       EX_CONFIG,
       "bad.toml:3: front_end.type = 'adc': must be one of: ads131m04, iio"},
      {{"--board", "sim=" + wireless}, EX_CONFIG, "none-wire.toml"},
      {{"--board", "sim", "--device", bad},
       EX_CONFIG,
       "bad.toml:3: front_end.type = 'adc': unknown"},
      {{"--board", "sim", "--bus", "udp:1.2.3.4"}, EX_CONFIG, "is no multicast group"},
      {{"--board", "replay=" + folder / "none.csv"}, EX_CONFIG, "none.csv"},
      {{"--board", "sim", "--at-once", "--for", "0.1", "--record", bad},
       EX_CONFIG,
       "never overwritten"},
      // What may be there another time.
      {{"--board", reference_board(folder, "")}, 1, "/dev/spidev"},
      {{"--board", "sim", "--bus", "none0"}, 1, "none0: "},
      {{"--board", "sim", "--settings", bad}, 1, "bad.toml: "},
      {{"--board", "sim", "--record", folder / "none/run.csv"}, 1, "No such file"},
  };
  for (const Case& c : cases) {
    const Ended ended = Program(folder, c.arguments).wait();
    EXPECT_TRUE(ended.exited_with(c.code)) << c.says;
    EXPECT_NE(ended.errors.find(c.says), std::string::npos) << ended.errors;
  }
}

#ifndef SMASERVO_SANITIZED  // sanitizers make calls of their own
TEST(Process, ItsLoopMakesALoopsCallsOnly) {
  const TemporaryFolder folder;
  const Ended ended = Program(folder, {"--board", "sim", "--no-real-time", "--sandbox", "--for",
                                       "0.3", "--record", folder / "run.csv"})
                          .wait();
  EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
}
#endif

// What it keeps is its own; the first one does not notice.
TEST(Process, ASecondOneWithTheSameFolderIsRefused) {
  const TemporaryFolder folder;
  const TemporaryFolder elsewhere;
  const std::string state = folder / "state";
  Program first(folder, {"--board", "sim", "--at-once", "--settings", state});
  ASSERT_TRUE(becomes([&] { return file_text(state + "/run").starts_with("heated"); }));
  const Ended second = Program(elsewhere, at_once(state)).wait();
  EXPECT_TRUE(second.exited_with(1)) << second.errors;
  EXPECT_NE(second.errors.find(state + ": another smaservod runs with this folder"),
            std::string::npos)
      << second.errors;
  EXPECT_TRUE(file_text(state + "/run").starts_with("heated"));
  first.kill(SIGTERM);
  EXPECT_TRUE(first.wait().exited_with(0));
  const Ended third = Program(elsewhere, at_once(state)).wait();
  EXPECT_TRUE(third.exited_with(0)) << third.errors;
  EXPECT_NE(third.out.find("the last run ended cleanly"), std::string::npos) << third.out;
}

TEST(Process, SaysWhatItRuns) {
  const TemporaryFolder folder;
  const auto errors = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"--board", "sim", "--at-once", "--for", "0.1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = Program(folder, arguments).wait();
    EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
    return ended.errors;
  };
  EXPECT_EQ(errors({}),
            "smaservod: board sim, no bus, wire 76 um x 100 mm, loop 1 ms; current off until its "
            "program heats\n");
  EXPECT_EQ(errors({"--quiet"}), "");
}

TEST(Process, CheckSaysOfEachDeviceWhyItIsNotThere) {
  const TemporaryFolder folder;
  const std::string board = reference_board(folder, "");
  const Ended ended = Program(folder, {"--board", board, "--check"}).wait();
  EXPECT_TRUE(ended.exited_with(1)) << ended.errors;
  EXPECT_EQ(ended.errors, "");
  for (const char* const says :
       {"drive            /dev/spidev", "front end        /dev/spidev0.0: No such file",
        "enable           line smaservo-enable: no such line",
        "kick             line smaservo-kick", "settings         ok"}) {
    EXPECT_NE(ended.out.find(says), std::string::npos) << says << " in:\n" << ended.out;
  }
}

TEST(Process, OwnsTheDevicesOfTheReferenceBoard) {
  const TemporaryFolder folder;
  const std::string board = reference_board(folder, "");
  for (const char* const device :
       {"spidev0.0", "spidev0.1", "spidev1.0", "spidev0.10", "iio:device0"}) {
    const bool owned =
        std::string(device).starts_with("spidev0.") && std::string(device).size() == 9;
    const Ended ended = Program(folder, {"--board", board, "--owns", device}).wait();
    EXPECT_TRUE(ended.exited_with(owned ? 0 : 1)) << device;
  }
}

// What a board lacks is no error, but nobody learns of it at the first fault only.
TEST(Process, CheckWarnsOfWhatNothingGuards) {
  const TemporaryFolder folder;
  const std::string board = reference_board(folder, "");
  std::string text = file_text(board);
  const std::size_t from = text.find("[lines.enable]");
  const std::size_t to = text.find("[lines.emergency_stop]");
  ASSERT_LT(from, to);
  std::ofstream(board) << text.erase(from, to - from);
  const Ended ended = Program(folder, {"--board", board, "--check"}).wait();
  for (const char* const says :
       {"enable           warning: not in the board file: no second switch ends the heat where the "
        "drive fails",
        "kick             warning: not in the board file: no one-shot ends the heat where the "
        "program"}) {
    EXPECT_NE(ended.out.find(says), std::string::npos) << says << " in:\n" << ended.out;
  }
}

// A name that is no UTF-8, or that commands a terminal, ends no run and commands none.
TEST(Process, NamesFromOutsideArePrintedEscaped) {
  const TemporaryFolder folder;
  const std::string name = "\xFF\x1B[2J\nsmaservod: all is well.toml";
  for (const char* const option : {"--json", "--no-real-time"}) {
    const Ended ended =
        Program(folder, {"--board", "sim=" + (folder / name), "--at-once", "--for", "0.1", option})
            .wait();
    EXPECT_NE(ended.errors.find("\\xFF\\x1B[2J\\x0Asmaservod: all is well.toml"),
              std::string::npos);
  }
  std::filesystem::copy(test::source_folder() + "/host-sim/scenarios", folder.path(),
                        std::filesystem::copy_options::recursive);
  std::filesystem::rename(folder / "steps.toml", folder / name);
  for (const char* const option : {"--json", "--no-real-time"}) {
    const Ended ended =
        Program(folder, {"--board", "sim=" + (folder / name), "--at-once", "--for", "0.1", option})
            .wait();
    EXPECT_TRUE(ended.exited_with(0)) << ended.errors;
    EXPECT_EQ((ended.out + ended.errors).find_first_of("\x1B\xFF"), std::string::npos) << ended.out;
    EXPECT_EQ(("\n" + ended.out).find("\nsmaservod: all is well"), std::string::npos);
  }
}

TEST(Process, APeriodThatNoBoardKeepsIsRefused) {
  const TemporaryFolder folder;
  for (const char* const period : {"0.4", "11"}) {
    const std::string board = reference_board(
        folder, std::string("[timing]\nsample_timeout_ms = 50\nperiod_ms = ") + period + "\n");
    const std::string says = folder / "devices/current-sink.toml" +
                             ": timing.period_ms = " + period +
                             ": must be between 0.5 and 10 on a board";
    const Ended ended = Program(folder, {"--board", board, "--settings", folder / "state"}).wait();
    EXPECT_TRUE(ended.exited_with(EX_CONFIG)) << period;
    EXPECT_NE(ended.errors.find(says), std::string::npos) << ended.errors;
    const Ended checked = Program(folder, {"--board", board, "--check"}).wait();
    EXPECT_TRUE(checked.exited_with(EX_CONFIG)) << period;
    EXPECT_NE(checked.out.find(says), std::string::npos) << checked.out;
  }
}

}  // namespace
}  // namespace smaservo::test::process_test
