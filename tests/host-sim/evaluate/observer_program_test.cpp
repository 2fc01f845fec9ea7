#include "host-sim/evaluate/observer_program.hpp"

#include <bit>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sys/wait.h>

#include "host-sim/end_by_signal.hpp"
#include "host-sim/evaluate/evaluate.hpp"
#include "host-sim/evaluate/table.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Rows = std::vector<simulate::SimulatedRow>;

namespace fs = std::filesystem;

/// An executable file. A script has a first line that names its interpreter.
std::string executable(const TemporaryFolder& folder, const std::string& name,
                       const std::string& text) {
  std::string path = folder.write(name, text);
  fs::permissions(path, fs::perms::owner_all);
  return path;
}

std::string shell(const TemporaryFolder& folder, const std::string& script) {
  return executable(folder, "observer", "#!/bin/sh\n" + script + "\n");
}

const Wire<double>& wire() {
  static const Wire<double> preset = files::load_wire(std::string(files::default_wire)).wire;
  return preset;
}

Rows some_rows(std::size_t count) {
  Rows rows;
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = static_cast<double>(i);
    rows.push_back({1e-3 * number, 0.05, 3 + 1e-5 * number, 1e-6 * number, 0.02});
  }
  return rows;
}

std::vector<evaluate::ProgramAnswer> ask(const std::string& program, const Rows& rows) {
  return evaluate::ask_observer_program(program, wire(), rows, "standard, ihyp 1000");
}

/// What is said of a program that is a shell script.
std::string error_of(const std::string& script, std::size_t rows = 3,
                     std::chrono::milliseconds patience = evaluate::program_patience) {
  const TemporaryFolder folder;
  const std::string program = shell(folder, script);
  try {
    evaluate::ask_observer_program(program, wire(), some_rows(rows), "standard, ihyp 1000",
                                   patience);
  } catch (const files::UserError& error) {
    const std::string text = error.what();
    const std::string where = fmt::format("--observer-program {}: standard, ihyp 1000: ", program);
    EXPECT_THAT(text, StartsWith(where));
    return text.substr(where.size());
  }
  return "";
}

std::ptrdiff_t open_files() {
  const fs::directory_iterator files("/proc/self/fd");
  return std::distance(begin(files), end(files));
}

/// All that a program can do wrong. Each is told, and leaves neither a process nor a file behind.
TEST(ObserverProgram, MistakesAreNamed) {
  const std::ptrdiff_t before = open_files();
  EXPECT_EQ(
      error_of("cat >/dev/null; echo 0.1; echo 0.2; echo one >&2; echo 'two\tthree' >&2; exit 3"),
      "ends with 3, after 2 of 3 answers; it says \"two\\x09three\"; it must end with 0");
  EXPECT_EQ(error_of("exit 1"), "ends with 1, after 0 of 3 answers; it must end with 0");
  EXPECT_EQ(error_of("kill -SEGV $$"),
            "is ended by signal 11 (Segmentation fault), after 0 of 3 answers");
  EXPECT_EQ(error_of("cat >/dev/null; echo 0.1; echo 0.2"),
            "ends after 2 of 3 answers; it must write one line for each row, until its input ends");
  EXPECT_THAT(error_of("echo strain; exec yes 0.1"),
              StartsWith("writes more lines than the 3 rows that it is given; it must write one "));
  const auto line = [](int number, const char* text) {
    return StartsWith(
        fmt::format("line {} of its output is \"{}\"; it must be the strain, ", number, text));
  };
  EXPECT_THAT(error_of("echo strain,strain_sd; echo 0.1; echo much"), line(3, "much"));
  EXPECT_THAT(error_of("echo 0.1; echo strain"), line(2, "strain"));
  EXPECT_THAT(error_of("echo nan"), line(1, "nan"));
  EXPECT_THAT(error_of("echo 0.1,inf"), line(1, "0.1,inf"));
  EXPECT_THAT(error_of("echo 0.1,-0.01"), line(1, "0.1,-0.01"));
  EXPECT_THAT(error_of("echo 0.1,0.01,0"), line(1, "0.1,0.01,0"));
  EXPECT_THAT(error_of("echo 0.1 %"), line(1, "0.1 %"));
  EXPECT_THAT(error_of("echo 0.1; echo; echo 0.1"), line(2, ""));
  EXPECT_THAT(error_of("printf '0.1,\\033[31m\\n'"), line(1, "0.1,\\x1B[31m"));
  EXPECT_THAT(error_of("echo 0.1; cat >/dev/null; printf 0.1x"), line(2, "0.1x"));
  EXPECT_THAT(error_of("exec tr '\\0' 0 </dev/zero"), line(1, std::string(300, '0').c_str()));
  EXPECT_THAT(
      error_of("echo 0.1,0.01; echo 0.1"),
      StartsWith("line 2 of its output is \"0.1\"; either all lines of a run must have a "));
  EXPECT_EQ(open_files(), before);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "no process is left";
}

/// It never reads and never ends, so that any time is too long.
TEST(ObserverProgram, IsEndedWhenItStandsStill) {
  EXPECT_THAT(
      error_of("exec sleep 1000", 100'000, std::chrono::milliseconds(400)),
      StartsWith("neither reads nor answers for 0.4 s, after 0 of 100000 answers; it must "));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
}

/// More rows than a pipe holds: host-sim writes to a pipe without a reader.
TEST(ObserverProgram, MayCloseItsInput) {
  EXPECT_THAT(error_of("exit 0", 100'000), StartsWith("ends after 0 of 100000 answers; "));
  EXPECT_THAT(error_of("exec <&-; sleep 0.1; echo broken >&2; exit 2", 100'000),
              StartsWith("ends with 2, after 0 of 100000 answers; it says \"broken\""));
  sigset_t set;
  ASSERT_EQ(sigpending(&set), 0);
  EXPECT_EQ(sigismember(&set, SIGPIPE), 0);
  ASSERT_EQ(pthread_sigmask(SIG_BLOCK, nullptr, &set), 0);
  EXPECT_EQ(sigismember(&set, SIGPIPE), 0) << "as it was before";
}

TEST(ObserverProgram, AStrainInPercentIsRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(
      error_of("cat >/dev/null; echo 4.1; echo 4.0"),
      "its first strain is 4.1, beyond 50 % of the length; a strain is a share of the length, "
      "as 0.031 where it is 3.1 %");
  // An observer may lose its way.
  const auto lost = ask(shell(folder, "cat >/dev/null; echo -0.5; echo 4.0"), some_rows(2));
  EXPECT_EQ(lost.back().strain, 4.0);
}

/// As SIGHUP is by nohup.
TEST(ObserverProgram, GoesOnWhenASignalIsIgnored) {
  const TemporaryFolder folder;
  const std::string program = shell(folder, "cat >/dev/null; echo 0.1; echo 0.2");
  const auto before = std::signal(SIGHUP, SIG_IGN);
  {
    const EndBySignal end;
    raise(SIGHUP);
    EXPECT_EQ(ask(program, some_rows(2)).size(), 2U);
  }
  EXPECT_EQ(std::signal(SIGHUP, before), SIG_IGN);
}

/// A child that it leaves behind, which has its output open, is ended.
TEST(ObserverProgram, IsOverWhenItEnds) {
  const TemporaryFolder folder;
  const std::string program = shell(folder, "sleep 1000 & cat >/dev/null; echo 0.1; echo 0.2");
  EXPECT_EQ(ask(program, some_rows(2)).size(), 2U);
}

/// Whenever it answers, neither side waits for the other for ever: there are more rows than pipes
/// hold.
TEST(ObserverProgram, MayAnswerAtAnyTime) {
  constexpr std::size_t count = 50'000;
  const TemporaryFolder folder;
  const Rows rows = some_rows(count);
  const auto answers = [&](const std::string& awk) {
    std::vector<double> strains;
    for (const evaluate::ProgramAnswer& answer :
         ask(shell(folder, fmt::format("exec awk -F, '{}'", awk)), rows)) {
      EXPECT_TRUE(std::isnan(answer.strain_sd));
      strains.push_back(answer.strain);
    }
    return strains;
  };
  std::vector<double> loads;
  for (const simulate::SimulatedRow& row : rows) {
    loads.push_back(row.load_N);
  }
  EXPECT_EQ(answers("NR > 1 { print $4 }"), loads);
  EXPECT_EQ(answers("NR > 1 { print $4; fflush() }"), loads) << "row by row";
  EXPECT_EQ(answers("BEGIN { print \"strain\" } NR > 1 { kept[NR] = $4 } "
                    "END { for (i = 2; i <= NR; ++i) print kept[i] }"),
            loads)
      << "at the end";
  EXPECT_EQ(answers(fmt::format("BEGIN {{ for (i = 0; i < {}; ++i) print 0.25 }} {{ }}", count)),
            std::vector<double>(count, 0.25))
      << "before it reads";
}

TEST(ObserverProgram, LinesMayEndAsOnOtherSystems) {
  const TemporaryFolder folder;
  const auto answers =
      ask(shell(folder, "cat >/dev/null; printf 'strain,strain_sd\\r\\n 0.1 , 2e-3\\r\\n-1,0'"),
          some_rows(2));
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0].strain, 0.1);
  EXPECT_EQ(answers[0].strain_sd, 2e-3);
  EXPECT_EQ(answers[1].strain, -1);
  EXPECT_EQ(answers[1].strain_sd, 0);
}

/// Each column of any finite numbers comes back bit for bit.
TEST(ObserverProgram, GetsAllDigits) {
  std::mt19937_64 random(1);
  const auto any = [&] {
    double value = std::numeric_limits<double>::infinity();
    while (!std::isfinite(value)) {
      value = std::bit_cast<double>(random());
    }
    return value;
  };
  Rows rows{{0.1, 0.1, 0.1, 0.1, 0.1}};  // the first answer has to look like a strain
  for (int i = 0; i < 1000; ++i) {
    rows.push_back({any(), any(), any(), any(), any()});
  }
  const TemporaryFolder folder;
  constexpr double simulate::SimulatedRow::* columns[] = {
      &simulate::SimulatedRow::time_s, &simulate::SimulatedRow::current_A,
      &simulate::SimulatedRow::voltage_V, &simulate::SimulatedRow::load_N};
  for (std::size_t i = 0; i < std::size(columns); ++i) {
    const auto answers =
        ask(shell(folder, fmt::format("exec awk -F, 'NR > 1 {{ print ${} }}'", i + 1)), rows);
    ASSERT_EQ(answers.size(), rows.size());
    for (std::size_t row = 0; row < rows.size(); ++row) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(answers[row].strain),
                std::bit_cast<std::uint64_t>(rows[row].*columns[i]));
    }
  }
}

TEST(ObserverProgram, GetsHeaderAndWire) {
  const TemporaryFolder folder;
  const std::string program =
      shell(folder, fmt::format("cp \"$1\" '{0}/copy.toml'; echo \"$1 $#\" >'{0}/arguments'; "
                                "tee '{0}/input' | tail -n +2 | cut -d, -f4",
                                folder.path().string()));
  ask(program, some_rows(1));
  EXPECT_EQ(file_text(folder / "input"), "time_s,current_A,voltage_V,load_N\n0,0.05,3,0\n");
  const std::string arguments = file_text(folder / "arguments");
  EXPECT_THAT(arguments, EndsWith(".toml 1\n"));
  EXPECT_FALSE(fs::exists(fs::path(arguments.substr(0, arguments.find(' '))).parent_path()))
      << "the temporary folder";
  const std::string text = file_text(folder / "copy.toml");
  EXPECT_EQ(text, files::to_toml_si({"wire", wire(), {{"all", "host-sim evaluate"}}}));
  EXPECT_EQ(files::to_toml(files::load_wire(folder / "copy.toml")),
            files::to_toml({"wire", wire(), {{"all", "host-sim evaluate"}}}))
      << "the same numbers";
}

TEST(ObserverProgram, NamesAreShortAndDiffer) {
  using evaluate::observer_program_names;
  using ::testing::ElementsAre;
  EXPECT_THAT(observer_program_names({"mine.py", "/opt/a/other"}), ElementsAre("mine.py", "other"));
  EXPECT_THAT(observer_program_names({"a/mine", "b/mine", "c"}),
              ElementsAre("a/mine", "b/mine", "c"));
  EXPECT_THAT(observer_program_names({"mine", "b/mine"}), ElementsAre("./mine", "b/mine"));
  EXPECT_THAT(observer_program_names({"b/kalman", "line"}), ElementsAre("b/kalman", "./line"));
  EXPECT_THAT(observer_program_names({"a\nb"}), ElementsAre("a\\x0Ab"));
  EXPECT_THROW(observer_program_names({"mine", "./mine"}), files::UserError);
}

evaluate::EvaluateOptions small(const std::vector<std::string>& programs) {
  evaluate::EvaluateOptions options;
  options.units = 1;
  options.runs = 2;
  options.observers.clear();
  options.programs = programs;
  options.wires = fs::path(source_folder()) / "tests/golden/evaluate";
  return options;
}

nlohmann::json judged(const evaluate::EvaluateOptions& options) {
  return nlohmann::json::parse(evaluate::table_json(evaluate::evaluate(options)))["observers"];
}

/// The built-in observer as a program has the same figures to the digit, also in the row that gives
/// the type's wire. The row "coarse" is left out: there the built-in observer uses no resistance
/// below 39 mA, which a program is not told. The row "unknown-start" would differ in `sure`.
TEST(EvaluateProgram, IsJudgedAsABuiltInObserver) {
  evaluate::EvaluateOptions options = small({own_observer_program()});
  options.observers = {"kalman"};
  options.rows = {"standard", "uncalibrated", "hold"};
  options.threads = 2;
  const nlohmann::json both = judged(options);
  EXPECT_EQ(both.size(), 3U) << "with open-loop for the hold";
  EXPECT_EQ(both["kalman"].size(), 3U);
  EXPECT_EQ(both["own_observer"], both["kalman"]);
}

TEST(EvaluateProgram, IsTheSameForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  evaluate::EvaluateOptions options = small(
      {executable(folder, "load", "#!/bin/sh\nexec awk -F, 'NR > 1 { print $3 / $2 / 1000 }'\n")});
  options.rows = {"uncalibrated"};
  options.runs = 4;
  const nlohmann::json alone = judged(options);
  options.threads = 4;
  EXPECT_EQ(judged(options), alone);
}

TEST(EvaluateProgram, WithoutDeviationAndHealth) {
  const TemporaryFolder folder;
  evaluate::EvaluateOptions options =
      small({executable(folder, "rest.sh", "#!/bin/sh\nexec awk 'NR > 1 { print 0.02 }'\n")});
  options.rows = {"standard", "unknown-start"};
  const nlohmann::json rows = judged(options)["rest.sh"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_TRUE(rows[0]["all"]["within_2_sd_percent"].is_null()) << rows[0]["all"];
  EXPECT_GT(rows[0]["all"]["mean_percent"], 10);
  EXPECT_EQ(rows[1]["all"]["unsure"], 0);
}

/// A wire is calibrated in a minute: a program that cannot do it is found before.
TEST(EvaluateProgram, IsTriedBeforeTheCalibration) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& program) -> std::string {
    evaluate::EvaluateOptions options = small({program});
    options.rows = {"hold"};
    options.wires = folder / "wires";
    options.progress = [](std::string_view stage, std::size_t, std::size_t) {
      ADD_FAILURE() << "begins " << stage;
    };
    try {
      evaluate::evaluate(options);
    } catch (const files::UserError& thrown) {
      return thrown.what();
    }
    return "";
  };
  EXPECT_THAT(error(folder / "none"), EndsWith("/none: there is no such file; give the path of a "
                                               "program"));
  EXPECT_THAT(error(folder.path()), EndsWith(": is no file; give the path of a program"));
  EXPECT_THAT(error(folder.write("text", "0.1\n")),
              HasSubstr("/text: may not be executed; make it executable (chmod +x), "));
  EXPECT_THAT(error(executable(folder, "text", "0.1\n")),
              HasSubstr("/text: cannot be started: Exec format error; a script must begin with "));
  EXPECT_THAT(error(executable(folder, "text", "#!/no/such/interpreter\n")),
              HasSubstr("/text: cannot be started: No such file or directory; a script must "));
  EXPECT_THAT(error(shell(folder, "exit 4")),
              HasSubstr("/observer: hold, ihyp 1000, hold-ripple, seed 100000000: ends with 4, "));
  EXPECT_FALSE(fs::exists(folder / "wires"));
}

Finished run_evaluate(Program& program, std::vector<std::string> more) {
  std::vector<std::string> arguments{"evaluate", "--row", "uncalibrated", "--units", "1",
                                     "--runs",   "2",     "--threads",    "2",       "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return program.run(arguments);
}

TEST(EvaluateCommand, ProgramsBesideOrInsteadOfObservers) {
  Program program;
  executable(program.folder(), "rest", "#!/bin/sh\nexec awk 'NR > 1 { print 0.02 }'\n");
  executable(program.folder(), "long", "#!/bin/sh\nexec awk 'NR > 1 { print 0.04 }'\n");
  const auto observers = [&](const std::vector<std::string>& more) {
    std::string names;
    const Finished run = run_evaluate(program, more);
    EXPECT_EQ(run.status, 0) << run.err;
    const auto json = nlohmann::ordered_json::parse(run.out);
    for (const auto& [name, rows] : json["observers"].items()) {
      names += name + " ";
    }
    return names;
  };
  EXPECT_EQ(observers({"--observer-program", "rest"}), "rest ");
  EXPECT_EQ(observers({"--observer-program", "rest", "--observer-program", "./long", "--observer",
                       "line"}),
            "line rest long ");
  EXPECT_EQ(run_evaluate(program, {"--observer-program", "rest", "--closed-loop"}).status, 2);
  const Finished twice =
      run_evaluate(program, {"--observer-program", "rest", "--observer-program", "./rest"});
  EXPECT_EQ(twice.status, 1);
  EXPECT_THAT(twice.err, HasSubstr("--observer-program rest: is given twice"));
}

/// The example of host-sim/evaluate/README.md as it stands there.
TEST(EvaluateCommand, RunsTheExampleOfTheReadme) {
  const std::string readme = file_text(fs::path(source_folder()) / "host-sim/evaluate/README.md");
  const std::size_t from = readme.find("#!/usr/bin/env python3\n");
  ASSERT_NE(from, std::string::npos);
  const std::string example = readme.substr(from, readme.find("```", from) - from);
  Program program;
  executable(program.folder(), "line.py", example);
  const Finished run =
      run_evaluate(program, {"--observer-program", "line.py", "--observer", "line"});
  for (const char* const missing : {"env: ", "No module named 'tomllib'"}) {
    if (run.err.find(missing) != std::string::npos) {
      GTEST_SKIP() << "needs python3 from 3.11 on: " << run.err;
    }
  }
  ASSERT_EQ(run.status, 0) << run.err;
  const auto observers = nlohmann::json::parse(run.out)["observers"];
  const double mean = observers["line.py"][0]["all"]["mean_percent"];
  EXPECT_GT(mean, 2);
  EXPECT_LT(mean, 20) << "a straight line";
}

}  // namespace
}  // namespace smaservo::test
