// `convert` by its command line: there and back, what it says, and what a mistake leaves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host-sim/program.hpp"

namespace smaservo::test::convert_test {
namespace {

using testing::HasSubstr;

constexpr const char* trace = "time_s,current_A,note\n0.000,-0,at rest\n0.010,,\n";

TEST(Convert, ThereAndBackIsTheSameText) {
  Program program;
  program.folder().write("t.csv", trace);
  EXPECT_EQ(program.run({"convert", "t.csv", "--out", "t.mcap"}).out, "t.csv: 2 rows, 3 columns\n");
  const Finished back = program.run({"convert", "t.mcap", "--out", "-"});
  EXPECT_EQ(back.out, trace);
  EXPECT_EQ(back.err, "t.mcap: 2 rows, 3 columns\n");
  EXPECT_EQ(program.run({"convert", "-", "--out", "-"}, file_text(program.folder() / "t.mcap")).out,
            trace);
}

TEST(Convert, AMistakeLeavesNoFile) {
  Program program;
  program.folder().write("t.csv", trace);
  program.folder().write("bad.csv", "time_s,current_A\n0,1\n1\n");
  program.folder().write("t.mcap", "no MCAP");
  const std::vector<std::pair<Program::Texts, std::string>> mistakes{
      {{"t.csv", "--out", "new.csv"}, "t.csv: is CSV, and so would be new.csv"},
      {{"bad.csv", "--out", "new.mcap"}, "bad.csv: line 3: the row has 1 columns, the header 2"},
      {{"t.mcap", "--out", "new.csv"}, "t.mcap: byte 0: is no MCAP file"},
      {{"none.csv", "--out", "new.mcap"}, "none.csv: No such file"},
      {{"t.csv", "--out", "t.csv"}, "is the same file"}};
  for (const auto& [arguments, message] : mistakes) {
    Program::Texts all{"convert"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Finished finished = program.run(all);
    EXPECT_EQ(finished.status, 1) << message;
    EXPECT_THAT(finished.err, HasSubstr(message));
  }
  EXPECT_EQ(program.run({"convert", "t.csv"}).status, 2);
  EXPECT_EQ(program.folder().names().size(), 3U);
}

}  // namespace
}  // namespace smaservo::test::convert_test
