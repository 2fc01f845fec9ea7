// host-sim commission as its user meets it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/host-sim/commission/commissioned_run.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;
using Texts = Program::Texts;

/// The run as a bench would record it, every fourth row.
const std::string& recording() {
  static const std::string csv = [] {
    const CommissionedRun run(hal::Family::ihyp, 520);
    std::string text = "time_s,current_mA,voltage_V,stress_MPa\n";
    for (std::size_t i = 0; i < run.run.time_s.size(); i += 4) {
      text += fmt::format("{:.3f},{:.3f},{:.5f},{:.2f}\n", run.run.time_s[i],
                          1e3 * run.run.current_A[i], run.run.voltage_V[i],
                          1e-6 * run.run.stress_Pa[i]);
    }
    return text;
  }();
  return csv;
}

std::string anchor(double time_s) {
  const commission::Anchor a = CommissionedRun(hal::Family::ihyp, 520).read(time_s, 0.013);
  return fmt::format("{:g},{:.4f}", a.time_s, 1e3 * a.displacement_m);
}

struct CommissionCommand : ::testing::Test {
  CommissionCommand() { program.folder().write("run.csv", recording()); }

  Finished run(const Texts& more) {
    Texts arguments{"commission", "--out", "w.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return program.run(arguments);
  }
  /// Ends with this status and this reason, and writes nothing.
  void refuses(const Texts& arguments, const char* reason, int status = 1) {
    const std::vector<std::string> before = program.folder().names();
    const Finished f = run(arguments);
    EXPECT_EQ(f.status, status) << f.err;
    EXPECT_THAT(f.err, HasSubstr(reason));
    EXPECT_EQ(f.out, "");
    EXPECT_EQ(program.folder().names(), before);
  }

  Program program;
};

TEST_F(CommissionCommand, WritesAWireAReportAndNumbers) {
  const Finished text =
      run({"run.csv", "--anchor", anchor(1.8), "--anchor", anchor(32.8), "--report", "r.html"});
  ASSERT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("run.csv and 2 readings"));
  EXPECT_THAT(text.out, HasSubstr("wire.martensite strain from 4 to"));
  std::istringstream lines(text.out);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 82U) << line;  // in bytes: "±" has two
  }
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("r.html", "run.csv", "w.toml"));
  EXPECT_THAT(file_text(program.folder() / "r.html"), HasSubstr("Resistance"));
  EXPECT_THAT(file_text(program.folder() / "w.toml"),
              HasSubstr("commissioned with run.csv and 2 readings"));
  const Finished again = program.run({"replay", "--wire", "w.toml", "run.csv"});
  EXPECT_EQ(again.status, 0) << again.err;

  const Finished json =
      run({"run.csv", "--anchor", anchor(1.8), "--anchor", anchor(32.8), "--json"});
  const auto document = nlohmann::json::parse(json.out);
  EXPECT_EQ(document["anchors"].size(), 2U);
  const auto& error = document["expected_error_of_stroke"];
  EXPECT_LT(error["after"]["stroke"], error["before"]["stroke"]);
}

TEST_F(CommissionCommand, TakesReadingsFromAFile) {
  const std::string cold = anchor(1.8), hot = anchor(32.8);
  program.folder().write("ruler.csv", "time_s,displacement_mm\n" + cold + "\n" + hot + "\n");
  const Finished file = run({"run.csv", "--anchors", "ruler.csv"});
  ASSERT_EQ(file.status, 0) << file.err;
  const std::string wire = file_text(program.folder() / "w.toml");
  ASSERT_EQ(run({"run.csv", "--anchor", cold, "--anchor", hot}).status, 0);
  EXPECT_EQ(file_text(program.folder() / "w.toml"), wire);
  program.folder().write("caliper.csv",
                         "time_s,displacement_mm,sd_mm\n" + cold + ",0.02\n" + hot + ",0.02\n");
  ASSERT_EQ(run({"run.csv", "--anchors", "caliper.csv"}).status, 0);
  const std::string finer = file_text(program.folder() / "w.toml");
  EXPECT_NE(finer, wire);
  ASSERT_EQ(run({"run.csv", "--anchor", cold + ",0.02", "--anchor", hot + ",0.02"}).status, 0);
  EXPECT_EQ(file_text(program.folder() / "w.toml"), finer);
}

TEST_F(CommissionCommand, SaysWhatARunWithoutReadingsTells) {
  const Finished none = run({"run.csv"});
  ASSERT_EQ(none.status, 0) << none.err;
  EXPECT_THAT(none.out, HasSubstr("no readings of the displacement"));
  EXPECT_THAT(none.out, HasSubstr("the readings cannot decide"));
}

TEST_F(CommissionCommand, NamesWrongReadings) {
  refuses({"run.csv", "--anchor", "1.8"}, "--anchor 1.8: has 1 number");
  refuses({"run.csv", "--anchor", "1.8,x"}, "'x' is not a finite number");
  refuses({"run.csv", "--anchor", "1.8,nan"}, "'nan' is not a finite number");
  refuses({"run.csv", "--anchor", "1.8,1,0"}, "must be 0.001 to 1000 mm");
  refuses({"run.csv", "--anchor", "1.8,1,0.1,2"}, "has 4 numbers");
  refuses({"run.csv", "--anchor", "1.8,0", "--anchor", "999,3"}, "the reading at 999 s is outside");
  refuses({"run.csv", "--anchor", "1.8,0", "--anchor", "32.8,3500"}, "is it in mm");
  refuses({"run.csv", "--anchors", "none.csv"}, "none.csv");
  refuses({"run.csv", "--anchor-sd-mm", "0"}, "--anchor-sd-mm 0");
  program.folder().write("r.csv", "time_s,load_N\n1,2\n");
  refuses({"run.csv", "--anchors", "r.csv"}, "needs the columns time_s and displacement_mm");
  program.folder().write("u.csv", "time_s,displacement_mm,sd_um\n1,0,20\n2,3,20\n");
  refuses({"run.csv", "--anchors", "u.csv"}, "column 'sd_um'");
  program.folder().write("b.csv", "time_s,displacement_mm\n2,0\n1,3\n");
  refuses({"run.csv", "--anchors", "b.csv"}, "rises in time");
  program.folder().write("s.csv", "time_s,displacement_mm,sd_mm\n1,0,0.1\n2,3,x\n");
  refuses({"run.csv", "--anchors", "s.csv"}, "s.csv: line 3: the deviation 'x'");
}

TEST_F(CommissionCommand, NamesWrongRuns) {
  program.folder().write("bath.csv", [] {
    std::string text = "temperature_degC,stress_MPa,strain_ref\n";
    for (int i = 0; i < 50; ++i) {
      text += fmt::format("{},150,{}\n", 25 + 2 * i, i < 25 ? 0.04 : 0.0);
    }
    return text;
  }());
  refuses({"bath.csv"}, "commissioning needs one that heats the wire by its current");
  program.folder().write("empty.csv", "");
  refuses({"empty.csv"}, "empty.csv");
  refuses({"run.csv", "--set", "wire.length_mm=150"}, "cold");
  refuses({"none.csv"}, "none.csv");
  refuses({"run.csv", "--stress-MPa", "-3"}, "--stress-MPa -3");
  EXPECT_EQ(program.run({"commission", "--out", "", "run.csv"}).status, 2);
  EXPECT_EQ(program.run({"commission", "--out", "w.csv", "run.csv"}).status, 1);
  refuses({"run.csv", "--report", "nowhere/r.html"}, "there is no folder nowhere");
}

TEST_F(CommissionCommand, OverwritesNoInput) {
  const Finished f =
      program.run({"commission", "--out", "w.toml", "--report", "run.csv", "run.csv"});
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(file_text(program.folder() / "run.csv"), recording());
  program.folder().write("w.toml", "mine");
  refuses({"run.csv", "--anchor", "1"}, "--anchor 1");
  EXPECT_EQ(file_text(program.folder() / "w.toml"), "mine");
}

}  // namespace
}  // namespace smaservo::test
