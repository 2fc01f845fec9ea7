// host-sim compare as its user meets it.

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <thread>

#include "tests/host-sim/papers/gru/small_network.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/host-sim/recordings.hpp"
#include "tests/host-sim/replay/replays.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;
using Texts = Program::Texts;

/// A bath run, which is identified in no time.
std::string bath_csv(double stress_MPa) {
  const Recording r;
  return csv({{"temperature_degC", r.temperature_degC},
              {"strain_ref", r.strain},
              {"resistance_ohm", r.ohm},
              {"stress_MPa", std::vector<double>(r.strain.size(), stress_MPa)}});
}

/// With a.csv to train on and t.csv to test on.
struct CompareCommand : ::testing::Test {
  CompareCommand() {
    program.folder().write("a.csv", bath_csv(150));
    program.folder().write("t.csv", bath_csv(140));
  }

  Finished run(const Texts& more) {
    Texts arguments{"compare", "--train", "a.csv", "--test", "t.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return program.run(arguments);
  }

  Program program;
};

TEST_F(CompareCommand, WritesWhatItIsAskedFor) {
  const Finished f = run({"--out", "c.json", "--report", "r.html", "--threads", "2"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_EQ(f.err, "") << "no progress where there is no terminal";
  EXPECT_THAT(f.out, StartsWith("Identified on a.csv; tested on t.csv."));
  for (const char* system : {"one line", "two lines", "stress-strain-resistance", "Duhem",
                             "Liang-Rogers", "Preisach", "ihyp", "ihyp observer"}) {
    EXPECT_THAT(f.out, HasSubstr(std::string("\n") + system + " "));
  }
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("a.csv", "t.csv", "c.json", "r.html"));
  const auto json = nlohmann::json::parse(file_text(program.folder() / "c.json"));
  EXPECT_EQ(json["systems"].size(), 9U);
  EXPECT_THAT(file_text(program.folder() / "r.html"), HasSubstr("<h2>t.csv: Duhem</h2>"));
}

TEST_F(CompareCommand, ANetworkIsOneSystemMore) {
  const Finished without = run({});
  program.folder().write("gru.json", small_network().dump());
  const Finished f = run({"--gru", "gru.json", "--out", "c.json"});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(without.out, Not(HasSubstr("GRU")));
  EXPECT_THAT(f.out, HasSubstr("\nGRU "));
  EXPECT_THAT(f.out, HasSubstr("\nGRU: no estimate: the tests lack what it needs.")) << "in a bath";
  const auto json = nlohmann::json::parse(file_text(program.folder() / "c.json"));
  ASSERT_EQ(json["systems"].size(), 10U);
  EXPECT_EQ(json["systems"][9]["name"], "GRU");
  EXPECT_EQ(json["systems"][9]["parameters"], 17);
}

TEST_F(CompareCommand, ListsWhatCanNotBeIdentifiedWithTheReason) {
  const Recording r;
  program.folder().write("a.csv", csv({{"temperature_degC", r.temperature_degC},
                                       {"strain_ref", r.strain},
                                       {"stress_MPa", std::vector<double>(r.strain.size(), 150)}}));
  const Finished f = run({});
  ASSERT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out, HasSubstr("one line: not identified: no run has a resistance."));
}

TEST_F(CompareCommand, JsonOnStandardOutputKeepsTheTableApart) {
  const Finished f = run({"--out", "-"});
  ASSERT_EQ(f.status, 0);
  EXPECT_TRUE(nlohmann::json::accept(f.out));
  EXPECT_THAT(f.err, StartsWith("Identified on a.csv"));
  const Finished json = run({"--json"});
  EXPECT_TRUE(nlohmann::json::accept(json.out));
  EXPECT_EQ(json.err, "");
}

TEST_F(CompareCommand, WhereAllAreLostTheResultIsOfNoUse) {
  Recording r;
  for (double& strain : r.strain) {
    strain += 0.02;  // half of the stroke: another zero
  }
  program.folder().write("t.csv", csv({{"temperature_degC", r.temperature_degC},
                                       {"strain_ref", r.strain},
                                       {"resistance_ohm", r.ohm},
                                       {"stress_MPa", std::vector<double>(r.strain.size(), 150)}}));
  const Finished f = run({"--out", "c.json"});
  EXPECT_EQ(f.status, 3);
  EXPECT_THAT(f.err, HasSubstr("every system is further from the tests than 20 %"));
  EXPECT_THAT(f.out, StartsWith("Identified on a.csv"));
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("a.csv", "t.csv", "c.json"));
}

TEST_F(CompareCommand, WrongArgumentsEndWith2) {
  for (const Texts& wrong : {Texts{"compare"}, Texts{"compare", "--train", "a.csv"},
                             Texts{"compare", "--test", "a.csv"}}) {
    EXPECT_EQ(program.run(wrong).status, 2) << ::testing::PrintToString(wrong);
  }
  for (const Texts& wrong : {Texts{"--nonsense"}, Texts{"--threads", "0"},
                             Texts{"--load-N", "1", "--stress-MPa", "2"}}) {
    const Finished f = run(wrong);
    EXPECT_EQ(f.status, 2) << ::testing::PrintToString(wrong);
    EXPECT_THAT(f.err, Not(IsEmpty()));
    EXPECT_EQ(f.out, "");
  }
}

TEST_F(CompareCommand, MistakesEndWith1BeforeAnythingIsDone) {
  std::filesystem::create_symlink("a.csv", program.folder() / "link.csv");
  std::filesystem::create_directory(program.folder() / "folder");
  program.folder().write("w.toml", "");
  program.folder().write("gru.json", small_network().dump());
  program.folder().write("other.json", "{}");
  const std::vector<std::string> before = program.folder().names();
  const std::pair<Texts, const char*> wrong[] = {
      {{"--train", "a.csv"}, "--train a.csv: is given twice"},
      {{"--train", "./t.csv"}, "--test t.csv: is a training run, too"},
      {{"--test", "./a.csv"}, "--test ./a.csv: is a training run, too"},
      {{"--test", "link.csv"}, "--test link.csv: is a training run, too"},
      {{"--test", "folder/../t.csv"}, "--test folder/../t.csv: is given twice"},
      {{"--test", "missing.csv"}, "missing.csv: No such file"},
      {{"--out", "a.csv"}, "a.csv: is the same file as a.csv"},
      {{"--out", "./t.csv"}, "./t.csv: is the same file as t.csv"},
      {{"--report", "link.csv"}, "link.csv: is the same file as a.csv"},
      {{"--from", "w.toml", "--out", "w.toml"}, "w.toml: is the same file as w.toml"},
      {{"--gru", "missing.json"}, "missing.json: cannot be read: No such file"},
      {{"--gru", "other.json"}, "other.json: format: is missing"},
      {{"--gru", "a.csv"}, "a.csv: is no JSON"},
      {{"--gru", "folder"}, "folder: cannot be read: it is a folder"},
      {{"--gru", "gru.json", "--out", "./gru.json"}, "./gru.json: is the same file as gru.json"},
      {{"--gru", "gru.json", "--report", "gru.json"}, "gru.json: is the same file as gru.json"},
      {{"--out", "x", "--report", "x"}, "x: is the same file as x"},
      {{"--out", "missing/c.json"}, "missing/c.json: cannot be written: No such file"},
      {{"--report", "missing/r.html"}, "missing/r.html: cannot be written: No such file"},
      {{"--out", "folder"}, "folder: cannot be written: Is a directory"},
      {{"--set", "wire.colour=red"}, "wire.colour"},
      {{"--load-N", "-1"}, "--load-N -1: must be between 0 and"},
      {{"--from", "nothing"}, "nothing"}};
  for (const auto& [arguments, said] : wrong) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.status, 1) << said;
    EXPECT_THAT(f.err, StartsWith("host-sim: "));
    EXPECT_THAT(f.err, HasSubstr(said));
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(program.folder().names(), before) << said;
  }
  EXPECT_EQ(file_text(program.folder() / "a.csv"), bath_csv(150));
}

TEST_F(CompareCommand, BadRunsAreNamed) {
  const std::string header = "time_s,current_A,voltage_V,load_N,strain_ref\n";
  const auto shipped_rows = [](std::size_t rows) {
    return joined(first_lines("400MPa.csv", rows));
  };
  const std::string whole = shipped_rows(2000);
  const std::pair<std::string, const char*> bad[] = {
      {"", "is empty"},
      {header, "has no usable row"},
      {whole + "60,nan,1,1,0.01\n", "line 2002, column 2 (current_A): 'nan' is not"},
      {shipped_rows(10), "has 10 rows, at least 20 are needed"},
      {shipped_rows(40), "the wire does not move"},
      {header + "0,0.1,2,0.9,3.9\n", "per cent are strain_ref_percent"},
      {"time_s,current_A,voltage_V,load_N\n0,0.1,2,0.9\n1,0.1,2,0.9\n", "at least 20 are needed"},
  };
  for (const auto& [text, said] : bad) {
    program.folder().write("bad.csv", text);
    for (const char* option : {"--train", "--test"}) {
      const Finished f = run({option, "bad.csv"});
      EXPECT_EQ(f.status, 1) << said;
      EXPECT_THAT(f.err, StartsWith("host-sim: bad.csv: "));
      EXPECT_THAT(f.err, HasSubstr(said));
    }
  }
}

TEST_F(CompareCommand, ALoadMayBeGivenForRunsWithoutOne) {
  const Recording r;
  const std::string unloaded =
      csv({{"temperature_degC", r.temperature_degC}, {"strain_ref", r.strain}});
  program.folder().write("u.csv", unloaded);
  const Finished none = run({"--test", "u.csv"});
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, HasSubstr("--load-N or --stress-MPa"));
  EXPECT_EQ(run({"--test", "u.csv", "--stress-MPa", "150"}).status, 0);
}

TEST_F(CompareCommand, APipeIsNotOpenedBeforeThereIsSomethingToSay) {
  const std::string pipe = program.folder() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { read = file_text(pipe); });
  EXPECT_EQ(run({"--out", "pipe"}).status, 0);
  reader.join();
  EXPECT_TRUE(nlohmann::json::accept(read));
}

TEST_F(CompareCommand, WithoutGnuplotTheNumbersAreKept) {
  program.environment = {"PATH=/nonexistent"};
  const Finished f = run({"--out", "c.json", "--report", "r.html"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("needs gnuplot"));
  EXPECT_TRUE(nlohmann::json::accept(file_text(program.folder() / "c.json")));
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("a.csv", "t.csv", "c.json"));
}

}  // namespace
}  // namespace smaservo::test
