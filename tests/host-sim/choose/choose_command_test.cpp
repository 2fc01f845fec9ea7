// host-sim choose as its user meets it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using Texts = Program::Texts;

struct ChooseCommand : ::testing::Test {
  Finished run(const Texts& more) {
    Texts arguments{"choose"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return program.run(arguments);
  }
  void refuses(const Texts& arguments, const char* reason, int status = 1) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.status, status) << f.err;
    EXPECT_THAT(f.err, HasSubstr(reason));
    EXPECT_EQ(f.out, "");
    EXPECT_THAT(program.folder().names(), IsEmpty());
  }

  Program program;
};

/// In characters, not in bytes.
std::size_t widest_line(const std::string& text) {
  std::size_t widest = 0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const auto columns = std::ranges::count_if(
        line, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
    widest = std::max(widest, static_cast<std::size_t>(columns));
  }
  return widest;
}

TEST_F(ChooseCommand, PrintsTablesJsonAndAReport) {
  const Texts task{"--force-N", "5", "--stroke-mm", "4", "--time-s", "0.5"};
  const Finished text = run(task);
  ASSERT_EQ(text.status, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("switch to what holds it"));
  EXPECT_THAT(text.out, HasSubstr("flexinol-lt-0.20mm  120   159"));
  EXPECT_LE(widest_line(text.out), 80U);
  Texts more = task;
  more.insert(more.end(), {"--json", "--report", "c.html"});
  const Finished both = run(more);
  ASSERT_EQ(both.status, 0) << both.err;
  EXPECT_THAT(program.folder().names(), UnorderedElementsAre("c.html"));
  EXPECT_THAT(file_text(program.folder() / "c.html"), HasSubstr("Contraction"));
  const auto json = nlohmann::json::parse(both.out);
  ASSERT_FALSE(json["wires"].empty());
  for (const auto& wire : json["wires"]) {
    EXPECT_THAT(text.out, HasSubstr(wire["wire"].get<std::string>()));
    const auto& course = wire["course"];
    EXPECT_LE(course["time_s"].size(), 200U);
    EXPECT_EQ(course["time_s"].size(), course["contraction_m"].size());
    EXPECT_EQ(course["time_s"].size(), course["temperature_K"].size());
    EXPECT_EQ(course["fan_time_s"].size(), course["fan_contraction_m"].size());
    for (const char* times : {"time_s", "fan_time_s"}) {
      const auto values = course[times].get<std::vector<double>>();
      EXPECT_TRUE(std::ranges::is_sorted(values)) << times;
    }
  }
}

TEST_F(ChooseCommand, FitsATerminal) {
  const std::vector<Texts> tasks{
      {"--force-N", "2", "--stroke-mm", "1000"},
      {"--force-N", "1", "--stroke-mm", "4", "--one-way"},
      {"--force-N", "1e-6", "--stroke-mm", "0.001"},
      {"--force-N", "2", "--stroke-mm", "4", "--life", "short"},
      {"--force-N", "20", "--stroke-mm", "4", "--parallel", "8"},
      {"--force-N", "1", "--stroke-mm", "4", "--time-s", "0.01"},
      {"--force-N", "1", "--stroke-mm", "4", "--length-mm", "100"},
      {"--force-N", "1000", "--stroke-mm", "4", "--parallel", "32", "--supply-V", "1"},
      {"--force-N", "0", "--stroke-mm", "4", "--spring", "0.01,0.01"},
      {"--force-N", "5", "--stroke-mm", "4", "--ambient-degC", "90"},
  };
  for (const Texts& task : tasks) {
    const Finished f = run(task);
    EXPECT_LE(widest_line(f.out), 80U) << f.out;
  }
}

TEST_F(ChooseCommand, TheMakersTableIsTheReadmes) {
  const Finished f = run({"--makers"});
  ASSERT_EQ(f.status, 0) << f.err;
  const std::string readme = file_text(source_folder() + "/host-sim/choose/README.md");
  std::istringstream in(f.out);
  for (std::string line; std::getline(in, line);) {
    EXPECT_THAT(readme, HasSubstr("    " + line + "\n"));
  }
  EXPECT_LE(widest_line(f.out), 80U);
  EXPECT_EQ(nlohmann::json::parse(run({"--makers", "--json"}).out).size(), 24U);
}

TEST_F(ChooseCommand, RefusesWhatMakesNoSense) {
  refuses({}, "--force-N is required", 2);
  refuses({"--force-N", "5"}, "--stroke-mm is required", 2);
  refuses({"--makers", "--force-N", "5"}, "--makers", 2);
  refuses({"--force-N", "nan", "--stroke-mm", "4"}, "force_N = nan: must be between 0 and 1000");
  refuses({"--force-N", "5", "--stroke-mm", "0"}, "stroke_mm = 0: must be");
  refuses({"--force-N", "5", "--stroke-mm", "4", "--spring", "1"}, "--spring", 2);
  refuses({"--force-N", "5", "--stroke-mm", "4", "--life", "eternal"}, "--life", 2);
  refuses({"--force-N", "5", "--stroke-mm", "4", "--parallel", "99"}, "parallel = 99");
  refuses({"--force-N", "5 kg", "--stroke-mm", "4"}, "--force-N", 2);
  refuses({"--force-N", "5", "--stroke-mm", "4", "--report", "no/where.html"}, "no/where.html");
}

TEST_F(ChooseCommand, EndsWith3WhereNoWireDoesIt) {
  const Finished f = run({"--force-N", "999", "--stroke-mm", "4"});
  EXPECT_EQ(f.status, 3);
  EXPECT_THAT(f.out, HasSubstr("No wire of the makers' tables does it."));
  EXPECT_THAT(f.out, HasSubstr("flexinol-lt-0.51mm   999 N: 4890 MPa; suggested: 171 MPa"));
  EXPECT_THAT(f.err, HasSubstr("the reasons are above"));
}

}  // namespace
}  // namespace smaservo::test
