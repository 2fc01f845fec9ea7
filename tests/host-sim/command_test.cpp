// host-sim as its user meets it: arguments, exit codes, messages, files.

#include <csignal>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "model/files/message.hpp"
#include "model/files/wrapped.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/host-sim/replay/replays.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::StartsWith;
using Texts = Program::Texts;

std::string unit_b() {
  return shipped("units/b.toml");
}

std::string short_trace() {
  return joined(first_lines("200MPa.csv", 400));
}

Texts replay_of(const std::string& trace, const Texts& more = {}) {
  Texts arguments{"replay", "--observer", "kalman", "--wire", unit_b(), trace};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// The program's own list of its sub-commands.
Texts sub_commands(const std::string& help) {
  Texts names;
  std::istringstream lines(help.substr(help.find("Subcommands:\n")));
  std::string line;
  for (std::getline(lines, line); std::getline(lines, line);) {
    std::istringstream words(line);
    if (std::string name; line.starts_with("  ") && line[2] != ' ' && words >> name) {
      names.push_back(name);
    }
  }
  return names;
}

TEST(Command, HelpExplainsEverySubCommand) {
  Program program;
  const Finished help = program.run({"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(help.err, "");
  const Texts commands = sub_commands(help.out);
  EXPECT_THAT(commands, IsSupersetOf({"can", "replay", "wires"}));
  const std::string readme = file_text(test::source_folder() + "/host-sim/README.md");
  const std::string manual = file_text(test::source_folder() + "/toolchain/package/host-sim.1");
  for (const std::string& command : commands) {
    const Finished own = program.run({command, "--help"});
    EXPECT_EQ(own.status, 0) << command;
    EXPECT_GT(own.out.size(), 200U) << command;
    std::istringstream lines(own.out);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(files::width_of(line), files::terminal_columns) << line;
    }
    EXPECT_NE(readme.find("\n| `" + command + "` | "), std::string::npos)
        << "host-sim/README.md has no row for " << command;
    std::string in_roff = command;
    for (std::size_t at = 0; (at = in_roff.find('-', at)) != std::string::npos; at += 2) {
      in_roff.insert(at, 1, '\\');
    }
    EXPECT_NE(manual.find("\n.B " + in_roff + "\n"), std::string::npos)
        << "toolchain/package/host-sim.1 has no entry for " << command;
  }
  EXPECT_THAT(program.run({"--version"}).out, Not(IsEmpty()));
}

/// Whatever files, their names and arguments hold: a terminal gets no control character, and nobody
/// writes a line in the program's name.
TEST(Command, WhatComesFromOutsideIsPrintedEscaped) {
  const std::string evil = "\x1B[2J\nhost-sim: all is well\x7F\xC2\x9B\r";
  Program program;
  const TemporaryFolder& folder = program.folder();
  const std::string header = "time_s,current_A,voltage_V,load_N";
  std::string binary;
  for (int i = 0; i < 3000; ++i) {
    binary += static_cast<char>(i * i % 251);
  }
  const std::string wire = "[wire]\nbased_on = \"smartflex-76um\"\n";
  const std::string quoted = R"("\u001B[2J\nhost-sim: all is well\u007F")";
  const std::string from[] = {
      folder.write("header.csv", "time_s,\x1B[2J\r,x\n0,1,2\n"),
      folder.write("field.csv", header + "\n0,1,\x1B[2J\x7F,2\n"),
      folder.write("binary.csv", binary),
      folder.write("long.csv", "time_s," + std::string(900'000, '\x1B') + "\n1,2\n"),
      folder / ("no" + evil + ".csv"),
  };
  std::vector<Texts> runs;
  for (const std::string& trace : from) {
    runs.push_back({"replay", "--wire", unit_b(), trace});
    runs.push_back({"replay", "--wire", unit_b(), "--lenient", trace});
  }
  const std::string good =
      folder.write("good" + evil + ".csv", joined(first_lines("200MPa.csv", 400)));
  runs.push_back({"replay", "--wire", unit_b(), "--lenient", good});
  runs.push_back({"wires", folder.write("key.toml", wire + quoted + " = 3\n")});
  runs.push_back({"wires", folder.write("value.toml", "[wire]\nbased_on = " + quoted + "\n")});
  runs.push_back({"wires", folder.write("name.toml", "name = " + quoted + "\n" + wire)});
  runs.push_back({"replay", "--wire", folder / "name.toml", good});
  runs.push_back({"replay", "--wire", unit_b(), "--set", evil + "=" + evil, good});
  runs.push_back({"replay", "--column", "time_s=" + evil, good});
  runs.push_back({"tune", "--wire", evil});
  runs.push_back({"simulate", "--scenario", evil});
  runs.push_back({"explain", evil});
  runs.push_back({"can", "--can", evil, "scan"});
  runs.push_back({evil});
  runs.push_back({"--" + evil});
  runs.push_back({"replay", "--" + evil, "a.csv"});
  runs.push_back({"replay", "--observer", evil, "a.csv"});
  for (const Texts& run : runs) {
    const Finished finished = program.run(run);
    const std::string all = finished.out + finished.err;
    EXPECT_THAT(all, Not(IsEmpty()));
    EXPECT_LT(all.size(), 10'000U);
    for (const char* const control : {"\x1B", "\x7F", "\xC2\x9B", "\r"}) {
      EXPECT_EQ(all.find(control), std::string::npos) << files::printable(all);
    }
    EXPECT_EQ(("\n" + all).find("\nhost-sim: all is well"), std::string::npos) << all;
  }
}

TEST(Command, WrongArgumentsEndWith2AndAMessage) {
  const Texts wrong[] = {{},
                         {"nonsense"},
                         {"--nonsense"},
                         {"replay"},
                         {"replay", "--nonsense", "t.csv"},
                         {"replay-device", "s.toml", "a.csv", "b.csv"},
                         {"replay", "--observer", "clairvoyant", "t.csv"},
                         {"replay", "--load-N", "heavy", "t.csv"},
                         {"replay", "--units", "imperial", "t.csv"},
                         {"can", "--can", "udp", "--units", "imperial", "info"},
                         {"can", "--can", "udp", "try", "--for", "0", "limits.power_W=1"},
                         {"replay", "--load-N", "1", "--stress-MPa", "2", "t.csv"},
                         {"replay", "--out"},
                         {"replay-device", "s.toml"},
                         {"replay-device", "s.toml", "t.csv", "--wire", "b"},
                         {"replay-device", "--tolerance", "1", "--allow-differences", "s", "t"},
                         {"simulate"}};
  for (const Texts& arguments : wrong) {
    Program program;
    const Finished f = program.run(arguments);
    EXPECT_EQ(f.status, 2) << ::testing::PrintToString(arguments);
    EXPECT_THAT(f.err, Not(IsEmpty()));
    EXPECT_EQ(f.out, "");
  }
}

TEST(Command, TheFormerOptionOfReplayNamesTheCommandThatItIsNow) {
  Program program;
  for (const Texts& former : {Texts{"replay", "--device", "s.toml", "t.csv"},
                              Texts{"replay", "t.csv", "--device=s.toml", "--tolerance", "1e-5"},
                              Texts{"replay", "--device"}}) {
    const Finished f = program.run(former);
    EXPECT_EQ(f.status, 2) << ::testing::PrintToString(former);
    EXPECT_THAT(f.err, HasSubstr("host-sim replay-device SETTINGS TRACE"));
  }
  EXPECT_THAT(program.run({"replay", "--help"}).out, Not(HasSubstr("--device")));
}

TEST(Command, ADeviceThatIsNotTheRecordedOneDiffers) {
  const std::string scenarios = test::source_folder() + "/host-sim/scenarios/";
  const std::string its = "its.toml";
  const std::string other = scenarios + "devices/sublayers-1000.toml";
  Program program;
  program.folder().write(its, file_text(scenarios + "devices/smartflex-76um.toml"));
  ASSERT_EQ(program.run({"simulate", scenarios + "modes.toml", "--out", "log.csv"}).status, 0);
  const Finished same = program.run({"replay-device", its, "log.csv", "--out", "again.csv"});
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_THAT(same.out, HasSubstr("outputs are the same to the last bit"));
  EXPECT_EQ(program.folder().names().size(), 3U);
  const Finished differs = program.run({"replay-device", other, "log.csv"});
  EXPECT_EQ(differs.status, 1);
  EXPECT_THAT(differs.out, HasSubstr("rows differ from the outputs in the trace"));
  EXPECT_EQ(differs.err, "host-sim: log.csv: the outputs differ from those in the trace\n");
  EXPECT_EQ(program.run({"replay-device", other, "log.csv", "--allow-differences"}).status, 0);
  EXPECT_EQ(program.run({"replay-device", its, "log.csv", "--out", "log.csv"}).status, 1);
  EXPECT_EQ(program.run({"replay-device", its, "log.csv", "--out", its}).status, 1);
}

TEST(Command, MistakesEndWith1AndNameWhatIsWrong) {
  const std::pair<Texts, const char*> wrong[] = {
      {{"replay", "missing.csv"}, "host-sim: missing.csv: No such file"},
      {replay_of("t.csv", {"--load-N", "-1"}), "--load-N -1: must be between 0 and"},
      {replay_of("t.csv", {"--stress-MPa", "nan"}), "--stress-MPa nan: must be between"},
      {replay_of("t.csv", {"--ambient-degC", "300"}), "--ambient-degC 300: must be between"},
      {replay_of("t.csv", {"--period-s", "0"}), "--period-s 0: must be between"},
      {replay_of("t.csv", {"--set", "nonsense"}), "--set nonsense: must be key=value"},
      {replay_of("t.csv", {"--set", "wire.length_mm=200000"}), "wire.length_mm = 200000"},
      {replay_of("t.csv", {"--set", "wire.colour=red"}), "wire.colour"},
      {replay_of("t.csv", {"--set", "observer.colour=1"}), "observer.colour"},
      {replay_of("t.csv", {"--set", "kalman.loss_walk=1"}), "is now called observer.loss_walk"},
      {replay_of("t.csv", {"--set", "limits.current_mA=90"}),
       "limits.current_mA = 90: is now called wire.limits.current_mA"},
      {replay_of("t.csv", {"--column", "time_s"}), "--column time_s: must be NAME=COLUMN"},
      {{"replay", "--wire", "nothing", "t.csv"}, "nothing"},
      {{"replay", "--wire", "nothing.toml", "t.csv"}, "nothing.toml"},
      {{"simulate", "nothing.toml"}, "nothing.toml: cannot be read"},
      {{"wires", "nothing"}, "nothing"},
  };
  Program program;
  program.folder().write("t.csv", short_trace());
  for (const auto& [arguments, said] : wrong) {
    const Finished f = program.run(arguments);
    EXPECT_EQ(f.status, 1) << said;
    EXPECT_THAT(f.err, StartsWith("host-sim: "));
    EXPECT_THAT(f.err, HasSubstr(said));
    EXPECT_EQ(f.out, "");
  }
  EXPECT_THAT(program.folder().names(), ElementsAre("t.csv"));
}

TEST(Command, ABadRowIsNamedAndNothingIsWritten) {
  Program program;
  program.folder().write("t.csv", short_trace() + "4.1,0.1,2,much,0.04\n");
  for (const char* estimate : {"e.csv", "-"}) {
    const Finished f =
        program.run(replay_of("t.csv", {"--out", estimate, "--report", "r.html", "--json"}));
    EXPECT_EQ(f.status, 1);
    EXPECT_EQ(f.err,
              "host-sim: t.csv: line 402, column 4 (load_N): 'much' is not a finite number\n");
    EXPECT_THAT(program.folder().names(), ElementsAre("t.csv"));
    EXPECT_THAT(f.out, Not(HasSubstr("error"))) << "no summary of half a run";
  }
  const Finished f = program.run(replay_of("t.csv", {"--lenient"}));
  EXPECT_EQ(f.status, 0);
  EXPECT_THAT(f.out, HasSubstr("1 bad rows skipped"));
  EXPECT_THAT(f.out, HasSubstr("line 402, column 4 (load_N)"));
}

TEST(Command, JsonIsValidAndHasTheNumbers) {
  Program program;
  const std::string path = program.folder().write("t.csv", short_trace());
  const Texts arguments{"replay", "--wire", unit_b(), "t.csv", "--json"};
  const Finished f = program.run(arguments);
  ASSERT_EQ(f.status, 0);
  EXPECT_EQ(f.err, "");
  const auto json = nlohmann::json::parse(f.out);
  replay::ReplayOptions options = replay_options(path, "b");
  options.observers = {"kalman", "open-loop", "line"};
  const replay::ReplayResult result = replay::replay(options);
  EXPECT_EQ(json.at("rows"), 400);
  EXPECT_EQ(json.at("bytes"), short_trace().size());
  EXPECT_NEAR(json.at("duration_s").get<double>(), 3.99, 1e-9);
  EXPECT_EQ(json.at("error").size(), 3U);
  for (const replay::ObserverResult& observer : result.observers) {
    const auto& error = json.at("error").at(observer.name);
    EXPECT_DOUBLE_EQ(error.at("mean_percent").get<double>(), observer.error.mean());
    EXPECT_DOUBLE_EQ(error.at("p95_percent").get<double>(), observer.error.quantile(0.95));
    EXPECT_DOUBLE_EQ(error.at("max_percent").get<double>(), observer.error.maximum());
    EXPECT_EQ(error.at("lost"), observer.lost);
  }
}

TEST(Command, JsonSurvivesOddNames) {
  Program program;
  const std::string name = "a \"b\"\\\n\xFF.csv";
  program.folder().write(name, short_trace());
  const Finished f = program.run(replay_of(name, {"--json"}));
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_TRUE(nlohmann::json::accept(f.out));
}

TEST(Command, EstimateOnStandardOutputKeepsTheSummaryApart) {
  Program program;
  program.folder().write("t.csv", short_trace());
  const Finished to_file = program.run(replay_of("t.csv", {"--out", "e.csv"}));
  const Finished piped = program.run(replay_of("-", {"--out", "-"}), short_trace());
  ASSERT_EQ(piped.status, 0);
  EXPECT_TRUE(piped.out == file_text(program.folder() / "e.csv"));
  EXPECT_THAT(piped.err, HasSubstr("kalman"));
  EXPECT_THAT(piped.err, StartsWith("standard input: 400 rows"));
  EXPECT_THAT(to_file.out, HasSubstr("kalman"));
  EXPECT_EQ(to_file.err, "") << "no progress where there is no terminal";
}

TEST(Command, ATraceIsNeverOverwrittenByItsEstimate) {
  Program program;
  program.folder().write("t.csv", short_trace());
  for (const Texts& same :
       {Texts{"--out", "t.csv"}, Texts{"--out", "./t.csv"}, Texts{"--report", "t.csv"}}) {
    EXPECT_EQ(program.run(replay_of("t.csv", same)).status, 1) << same[1];
    EXPECT_TRUE(file_text(program.folder() / "t.csv") == short_trace());
    program.folder().write("t.csv", short_trace());
  }
}

TEST(Command, AKilledReplayLeavesNoHalfEstimate) {
  Program program;
  program.folder().write("e.csv", "old");
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  const pid_t child =
      program.start(replay_of("-", {"--out", "e.csv"}), ends[0], program.folder() / "said");
  // Fed, and left waiting for more: it is in the middle for certain.
  const std::string rows = short_trace();
  ASSERT_EQ(write(ends[1], rows.data(), rows.size()), std::ssize(rows));
  const auto half_written = [&] { return program.folder().names().size() == 3; };
  while (!half_written()) {
    std::this_thread::yield();
    ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "it has ended";
  }
  kill(child, SIGKILL);
  EXPECT_EQ(program.wait(child).status, 128 + SIGKILL);
  close(ends[1]);
  EXPECT_EQ(file_text(program.folder() / "e.csv"), "old");
}

TEST(Command, AFullDiskIsAnError) {
  if (access("/dev/full", W_OK) != 0) {
    GTEST_SKIP() << "needs /dev/full";
  }
  Program program;
  const std::string trace = program.folder().write("t.csv", short_trace());
  const Texts commands[] = {replay_of("t.csv", {"--out", "-"}),
                            replay_of("t.csv", {"--json"}),
                            replay_of("t.csv"),
                            {"simulate", shipped("bath.toml")},
                            {"wires"},
                            {"wires", "smartflex-76um"}};
  for (const Texts& command : commands) {
    const Finished f = program.run_between(command, trace, "/dev/full");
    EXPECT_EQ(f.status, 1) << ::testing::PrintToString(command);
    EXPECT_THAT(f.err, HasSubstr("No space left on device"));
  }
}

TEST(Command, WithoutGnuplotTheEstimateIsKept) {
  Program program;
  program.folder().write("t.csv", short_trace());
  program.environment = {"PATH=/nonexistent"};
  const Finished f = program.run(replay_of("t.csv", {"--out", "e.csv", "--report", "r.html"}));
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("needs gnuplot"));
  EXPECT_THAT(program.folder().names(), ::testing::UnorderedElementsAre("t.csv", "e.csv"));
  EXPECT_EQ(lines_of(file_text(program.folder() / "e.csv")).size(), 401U);
}

TEST(Command, SimulatesToAFile) {
  Program program;
  const Finished f = program.run({"simulate", shipped("bath.toml"), "--out", "bath.csv"});
  EXPECT_EQ(f.status, 0);
  EXPECT_EQ(f.out, "");
  EXPECT_EQ(lines_of(file_text(program.folder() / "bath.csv")).front(),
            "temperature_degC,stress_MPa,strain_ref");
}

TEST(Command, WiresAreListedAndPrintedSoThatTheyLoadAgain) {
  Program program;
  const Finished list = program.run({"wires"});
  EXPECT_EQ(list.status, 0);
  for (const std::string& name : files::preset_names()) {
    EXPECT_THAT(list.out, HasSubstr(name));
  }
  const Finished printed = program.run({"wires", unit_b(), "--set", "wire.length_mm=123"});
  ASSERT_EQ(printed.status, 0);
  program.folder().write("w.toml", printed.out);
  EXPECT_EQ(program.run({"wires", "w.toml"}).out, printed.out);
  EXPECT_DOUBLE_EQ(files::load_wire(program.folder() / "w.toml").wire.geometry.length_m, 0.123);
}

}  // namespace
}  // namespace smaservo::test
