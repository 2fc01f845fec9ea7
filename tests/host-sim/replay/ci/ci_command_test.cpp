// `host-sim replay` with several traces and with bounds, as a run in continuous integration calls
// it.

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/host-sim/program.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test::ci_command_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class ReplayInCi : public ::testing::Test {
 protected:
  ReplayInCi() {
    const std::vector<std::string> lines = first_lines("200MPa.csv", 500);
    folder().write("a.csv", joined(lines));
    folder().write("b.csv", joined(first_lines("100MPa.csv", 400)));
    std::string plain;
    for (const std::string& line : lines) {
      plain += line.substr(0, line.rfind(',')) + "\n";
    }
    folder().write("plain.csv", plain);
    std::vector<std::string> wrong = lines;
    for (std::size_t i = 1; i < wrong.size(); ++i) {
      wrong[i] = wrong[i].substr(0, wrong[i].rfind(',')) + ",0.9";
    }
    folder().write("lost.csv", joined(wrong));
    before_ = folder().names().size();
  }

  const TemporaryFolder& folder() const { return program_.folder(); }

  Finished replay(Program::Texts arguments) {
    const bool has_wire = std::ranges::find(arguments, "--wire") != arguments.end();
    if (!has_wire) {
      arguments.insert(arguments.begin(), {"--wire", shipped("units/b.toml")});
    }
    arguments.insert(arguments.begin(), "replay");
    return program_.run(arguments);
  }
  Finished expecting(const std::string& toml, Program::Texts traces) {
    folder().write("expect.toml", toml);
    traces.insert(traces.begin(), {"--expect", "expect.toml"});
    return replay(traces);
  }
  /// What is said about a command that is refused before anything is replayed or written.
  std::string refused(const Program::Texts& arguments) {
    const std::size_t files = folder().names().size();
    const Finished f = replay(arguments);
    EXPECT_EQ(f.status, 1);
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(folder().names().size(), files) << "it has left something";
    return f.err;
  }
  std::string unexpected(const std::string& toml, const Program::Texts& traces) {
    const Finished f = expecting(toml, traces);
    EXPECT_EQ(f.status, 1) << toml;
    EXPECT_EQ(f.out, "") << toml;
    return f.err;
  }

  Program program_;
  std::size_t before_ = 0;
};

/// Without the time it took, which JSON has.
nlohmann::json timeless(nlohmann::json json) {
  json.erase("elapsed_s");
  return json;
}

TEST_F(ReplayInCi, SeveralTracesAreTheirSections) {
  const Finished a = replay({"a.csv"}), b = replay({"b.csv"});
  const Finished both = replay({"a.csv", "b.csv"});
  EXPECT_EQ(both.status, 0) << both.err;
  EXPECT_EQ(both.out, a.out + "\n" + b.out);
  EXPECT_EQ(both.err, "");
}

TEST_F(ReplayInCi, JsonOfSeveralIsAList) {
  const nlohmann::json a = nlohmann::json::parse(replay({"--json", "a.csv"}).out);
  ASSERT_TRUE(a.is_object());
  EXPECT_FALSE(a.contains("misses"));
  const Finished f = replay({"--json", "a.csv", "missing.csv"});
  EXPECT_EQ(f.status, 1);
  const nlohmann::json all = nlohmann::json::parse(f.out);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(timeless(all[0]), timeless(a));
  EXPECT_EQ(all[1]["trace"], "missing.csv");
  EXPECT_EQ(all[1]["mistakes"].size(), 1U);
  const Finished judged = replay({"--json", "--fail-above", "mean=0,max=0", "a.csv"});
  EXPECT_EQ(nlohmann::json::parse(judged.out)["misses"].size(), 2U);
}

TEST_F(ReplayInCi, AnErrorDoesNotStopTheOthersAndTheWorstCounts) {
  const Finished bad = replay({"missing.csv", "a.csv", "lost.csv"});
  EXPECT_EQ(bad.status, 1);
  EXPECT_THAT(bad.out, AllOf(HasSubstr("a.csv: 500 rows"), HasSubstr("lost.csv: 500 rows")));
  EXPECT_THAT(bad.err, AllOf(HasSubstr("host-sim: missing.csv: "),
                             HasSubstr("host-sim: lost.csv: all observers were lost\n")));
  EXPECT_EQ(replay({"lost.csv", "a.csv"}).status, 3);
  EXPECT_EQ(replay({"lost.csv"}).status, 3);
  EXPECT_EQ(replay({"lost.csv", "--fail-above", "max=1"}).status, 1);
}

TEST_F(ReplayInCi, FailAboveSaysEachMiss) {
  const Finished f = replay({"a.csv", "b.csv", "--fail-above", "mean=0,p95=999,max=0.001"});
  EXPECT_EQ(f.status, 1);
  const std::vector<std::string> lines = lines_of(f.err);
  ASSERT_EQ(lines.size(), 4U) << f.err;
  EXPECT_THAT(lines[0], ::testing::MatchesRegex(
                            "host-sim: a.csv: kalman: mean error is [0-9.]+ %, allowed is 0 %"));
  EXPECT_THAT(lines[3], HasSubstr("b.csv: kalman: maximum error is "));
  const Finished line =
      replay({"--observer", "line", "--observer", "kalman", "a.csv", "--fail-above", "mean=1"});
  EXPECT_THAT(line.err, HasSubstr("a.csv: line: mean error is "));
  EXPECT_EQ(replay({"a.csv", "--fail-above", "mean=100,max=100"}).status, 0);
}

TEST_F(ReplayInCi, WithoutReferenceNothingCanBeJudged) {
  const Finished f = replay({"plain.csv", "a.csv", "--fail-above", "mean=100"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, AllOf(HasSubstr("host-sim: plain.csv: --fail-above: no error can be judged"),
                           Not(HasSubstr("a.csv:"))));
  EXPECT_EQ(expecting("[default]\nrows = 500\nmax_skipped = 0\n", {"plain.csv"}).status, 0);
  EXPECT_EQ(expecting("[default]\nmax = 100\n", {"plain.csv"}).status, 1);
}

TEST_F(ReplayInCi, OutAndReportAreOfOneTrace) {
  for (const char* option : {"--out", "--report"}) {
    EXPECT_THAT(refused({"a.csv", "b.csv", option, "made"}),
                AllOf(HasSubstr(option), HasSubstr("is of one trace, and 2 are given"),
                      HasSubstr("by a command of its own")));
  }
  EXPECT_EQ(replay({"a.csv", "--out", "made", "--junit", "j.xml"}).status, 0);
  EXPECT_EQ(folder().names().size(), before_ + 2);
}

TEST_F(ReplayInCi, NoInputIsOverwritten) {
  folder().write("expect.toml", "[default]\n");
  std::filesystem::copy(shipped("units/b.toml"), folder() / "wire.toml");
  const std::string text = file_text(folder() / "b.csv");
  for (const char* option : {"--junit", "--summary"}) {
    for (const char* input : {"a.csv", "b.csv", "expect.toml", "wire.toml"}) {
      EXPECT_THAT(refused({"a.csv", "b.csv", "--wire", "wire.toml", "--expect", "expect.toml",
                           option, input}),
                  HasSubstr("is the same file as"))
          << option << input;
    }
  }
  EXPECT_EQ(file_text(folder() / "b.csv"), text);
  EXPECT_THAT(refused({"a.csv", "--junit", "x", "--summary", "x"}), HasSubstr("the same file"));
  EXPECT_THAT(refused({"a.csv", "--junit", "-", "--summary", "-"}),
              HasSubstr("standard output is taken by --junit"));
}

TEST_F(ReplayInCi, StandardOutputHasTheSummaryAlone) {
  const Finished f = replay(
      {"a.csv", "plain.csv", "lost.csv", "gone|.csv", "--summary", "-", "--fail-above", "max=50"});
  const std::vector<std::string> lines = lines_of(f.out);
  ASSERT_EQ(lines.size(), 6U) << f.out;
  EXPECT_EQ(lines[0], "| trace | rows | mean | 95 % | maximum | verdict |");
  EXPECT_THAT(lines[2], AllOf(HasSubstr("| a.csv | 500 | "), HasSubstr("| passed |")));
  EXPECT_THAT(lines[3], HasSubstr("| plain.csv | 500 | - | - | - | **error: "));
  EXPECT_THAT(lines[4], HasSubstr("| **failed: kalman: maximum error is "));
  EXPECT_THAT(lines[5], HasSubstr("| gone\\|.csv | - |"));
  EXPECT_THAT(f.err, HasSubstr("a.csv: 500 rows"));
  EXPECT_THAT(replay({"a.csv", "--summary", "-"}).out, HasSubstr("| replayed |"));
}

TEST_F(ReplayInCi, EachTraceHasItsBoundsOrTheDefault) {
  const Finished f =
      expecting("[\"a.csv\"]\nmean = 0\nobserver = \"line\"\nrows = 501\n[default]\nmax = 100\n",
                {"./a.csv", "b.csv"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(lines_of(f.err), ElementsAre("host-sim: ./a.csv: has 500 rows, expected are 501",
                                           HasSubstr("host-sim: ./a.csv: line: mean error is ")));
  EXPECT_EQ(expecting("[\"a.csv\"]\nmean = 1.0\np95 = 3\nmax = 50\nrows = 500\nmax_skipped = 0\n"
                      "max_invalid = 10\nobserver = \"kalman\"\n",
                      {"a.csv"})
                .status,
            0);
  const Finished both = expecting("[default]\nmean = 0\n", {"a.csv", "--fail-above", "mean=0"});
  EXPECT_EQ(lines_of(both.err).size(), 1U) << "the same miss is said once";
}

TEST_F(ReplayInCi, ColumnsOfTheEstimateHaveBounds) {
  const auto of = [&](const std::string& bounds) {
    return expecting("[\"a.csv\".estimate]\n" + bounds + "\n", {"a.csv"});
  };
  EXPECT_EQ(of("strain = {min = 0.0, max = 0.06, mean = 0.03, tolerance = 0.03}").status, 0);
  EXPECT_EQ(of("resistance_ohm = {min = 1}\nmartensite = {min = 0, max = 1}").status, 0);
  const Finished hot = of("wire_temperature_degC = {max = 20}");
  EXPECT_EQ(hot.status, 1);
  EXPECT_THAT(hot.err, HasSubstr("a.csv: the greatest wire_temperature_degC is "));
}

TEST_F(ReplayInCi, MistakesInExpectationsAreNamedWithFileAndLine) {
  const std::vector<std::pair<std::string, std::string>> mistakes{
      {"[default]\nmedian = 1\n",
       "expect.toml:2: default.median = 1: unknown key (did you mean mean?); allowed: "},
      {"[\"a.csv\"]\n\nmean = -1\n", "expect.toml:3: a.csv.mean = -1: "},
      {"[default]\nmax = \"1\"\n", "expect.toml:2: default.max = '1'"},
      {"[default]\nmax = nan\n", "expect.toml:2: default.max = nan"},
      {"[default]\nrows = 1.5\n", "must be a whole number"},
      {"[default]\nobserver = \"best\"\n", "is not one of those that run: kalman, open-loop, line"},
      {"[a.csv]\nmean = 1\n", "expect.toml:1: a.csv = "},
      {"[a.csv]\nmean = 1\n", "needs quotes, as [\"run.csv\"]"},
      {"mean = 1\n", "expect.toml:1: mean = 1: stands in no table"},
      {"[default]\n[\"c.csv\"]\nmean = 1\n", "no trace of this name is given"},
      {"[\"b.csv\"]\nmean = 1\n", "no trace of this name is given"},
      {"", "has neither a table [\"a.csv\"] for a.csv nor [default]"},
      {"[default.estimate]\nstress = {min = 0}\n", "default.estimate.stress"},
      {"[default.estimate]\nstrain = {mean = 0}\n", "tolerance: is missing"},
      {"[default.estimate]\nstrain = {min = 0, tolerance = 1}\n", "is that of mean"},
      {"[default.estimate]\nstrain = {min = 2, max = 1}\n", "must not be above max"},
      {"[default\n", "expect.toml:1"},
  };
  for (const auto& [toml, said] : mistakes) {
    EXPECT_THAT(unexpected(toml, {"a.csv"}), HasSubstr(said)) << toml;
  }
  EXPECT_THAT(refused({"a.csv", "--expect", "none.toml"}), HasSubstr("none.toml"));
  EXPECT_NE(refused({"a.csv", "--expect", ""}), "") << "a variable that is not set";
  EXPECT_NE(refused({"a.csv", "--fail-above", ""}), "");
}

/// The keys that a message of an unknown key lists.
std::vector<std::string> allowed_keys(const std::string& message) {
  const std::string mark = "allowed: ";
  std::istringstream in(message.substr(message.find(mark) + mark.size()));
  std::vector<std::string> keys;
  for (std::string key; in >> key;) {
    keys.push_back(key.substr(0, key.find(',')));
  }
  return keys;
}

TEST_F(ReplayInCi, TheReadmeHasEveryKeyOfExpectations) {
  const std::string readme = file_text(source_folder() + "/host-sim/replay/README.md");
  for (const char* toml : {"[default]\nx = 1\n", "[default.estimate]\nx = 1\n",
                           "[default.estimate]\nstrain = {x = 1}\n"}) {
    const std::vector<std::string> keys = allowed_keys(unexpected(toml, {"a.csv"}));
    EXPECT_GE(keys.size(), 4U);
    for (const std::string& key : keys) {
      EXPECT_THAT(readme, HasSubstr("`" + key + "`"));
    }
  }
}

}  // namespace
}  // namespace smaservo::test::ci_command_test
