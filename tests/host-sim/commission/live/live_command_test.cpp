// The command line of the live half; the program itself.

#include <gmock/gmock.h>

#include "tests/host-sim/program.hpp"

namespace smaservo::commission {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct LiveCommand : testing::Test {
  test::Finished run(test::Program::Texts others) {
    others.insert(others.begin(), "commission");
    return program.run(others);
  }

  test::Program program;
};

TEST_F(LiveCommand, AWrongCommandLineEndsWith2) {
  EXPECT_EQ(run({}).status, 2);
  EXPECT_EQ(run({"--can", "none0"}).status, 2);
  EXPECT_EQ(run({"run.csv"}).status, 2) << "without --out";
  EXPECT_EQ(run({"run.csv", "--out", "w.toml", "--pace", "1"}).status, 2);
  EXPECT_EQ(run({"run.csv", "--out", "w.toml", "--can", "none0", "--record", "r.csv"}).status, 2);
  EXPECT_EQ(run({"--can", "none0", "--record", "r.csv", "--anchor", "1,2"}).status, 2);
  EXPECT_EQ(run({"--can", "none0", "--record", "run.csv", "--ask", "5"}).status, 2);
  EXPECT_EQ(run({"--can", "none0", "--record", "run.csv", "--pace", "nan"}).status, 2);
  EXPECT_EQ(run({"--can", "none0", "--record", "run.csv", "--node", "128"}).status, 2);
  EXPECT_THAT(program.folder().names(), IsEmpty());
}

TEST_F(LiveCommand, ABusThatIsNotThereLeavesNoFile) {
  const test::Finished f = run({"--can", "none0", "--record", "run.csv"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("none0"));
  EXPECT_THAT(program.folder().names(), IsEmpty());
}

TEST_F(LiveCommand, TheRunIsACsvFile) {
  for (const char* const name : {"-", "run.mcap"}) {
    const test::Finished f = run({"--can", "none0", "--record", name});
    EXPECT_EQ(f.status, 1);
    EXPECT_THAT(f.err, HasSubstr("the run is CSV"));
  }
  EXPECT_EQ(run({"--can", "none0", "--record", "a.csv", "--anchors", "a.csv"}).status, 1);
  EXPECT_THAT(program.folder().names(), IsEmpty());
}

}  // namespace
}  // namespace smaservo::commission
