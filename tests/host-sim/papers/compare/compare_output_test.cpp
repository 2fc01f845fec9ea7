// What is said about a comparison. This one has made-up systems, so that it is known by heart.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host-sim/papers/compare/compare.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

smaservo::identify::Run joule_run(const std::string& name) {
  smaservo::identify::Run run{};
  run.name = name;
  run.kind = identify::RunKind::joule;
  for (int i = 0; i < 200; ++i) {
    run.strain.push_back(0.001 + 0.0002 * (i < 100 ? i : 200 - i));
    run.resistance_ohm.push_back(18 + 100 * run.strain.back());
  }
  return run;
}

smaservo::identify::Run named_bath_run(const std::string& name) {
  smaservo::identify::Run run = joule_run(name);
  run.kind = identify::RunKind::bath;
  run.resistance_ohm.clear();
  for (const double strain : run.strain) {
    run.temperature_K.push_back(370 - 3000 * strain);
  }
  return run;
}

/// Wrong by so many per cent of a 4 % stroke everywhere. Says nothing in a bath unless `bath`.
compare::Compared wrong_by(const compare::Comparison& comparison, const char* name, double percent,
                           bool bath) {
  compare::Compared one;
  one.system = {name, "a meaning", 7, "",
                [](const smaservo::identify::Run& run) { return run.strain; }};
  for (const smaservo::identify::Run& test : comparison.tests) {
    compare::SystemRun run;
    for (const double strain : test.strain) {
      const bool silent = test.kind == identify::RunKind::bath && !bath;
      run.strain.push_back(silent ? std::nan("") : strain + 0.0004 * percent);
      if (!silent) {
        run.error.add(percent);
      }
    }
    one.error.add(run.error);
    one.runs.push_back(run);
  }
  one.step_s = 123e-9;
  return one;
}

compare::Comparison made_up() {
  compare::Comparison comparison{"a wire", 0.04, {joule_run("folder/train.csv")}, {}, {}, {}, {}};
  comparison.tests = {joule_run("folder/<b>&.csv"), named_bath_run("bath.csv")};
  comparison.free_zero = {false, true};
  comparison.beyond = {{0.125, 0}, {}};
  comparison.systems.push_back(wrong_by(comparison, "good", 0.5, true));
  comparison.systems.push_back(wrong_by(comparison, "by resistance", 2.25, false));
  compare::Compared refused;
  refused.system = {"refused", "", 0, "not identified: too <few> runs", {}};
  comparison.systems.push_back(refused);
  return comparison;
}

TEST(CompareOutput, TextHasARowForEachSystemAndSaysWhatIsMissing) {
  const std::string text = compare::comparison_text(made_up());
  EXPECT_THAT(text, HasSubstr("Identified on train.csv; tested on <b>&.csv, bath.csv."));
  EXPECT_THAT(text, HasSubstr("in % of a 4 % stroke"));
  EXPECT_THAT(text, HasSubstr("<b>&.csv goes beyond the training, where estimates are "
                              "extrapolated: by its stress in 12.5 % of the rows, by its "
                              "resistance in 0.0 %."));
  EXPECT_THAT(text, Not(HasSubstr("bath.csv goes beyond")));
  EXPECT_THAT(text, HasSubstr("bath.csv: the strain has a zero of its own"));
  EXPECT_THAT(text, Not(HasSubstr("&.csv: the strain has a zero")));
  EXPECT_THAT(text, HasSubstr("\ngood           0.50  0.50  0.50  123 ns           7\n"));
  EXPECT_THAT(text, HasSubstr("\nby resistance  2.25  2.25  2.25"));
  EXPECT_THAT(text, HasSubstr("\nrefused           -     -     -       -           -\n"));
  EXPECT_THAT(text, HasSubstr("\nrefused: not identified: too <few> runs.\n"));
}

TEST(CompareOutput, ASystemThatIsSilentInAllTestsSaysSo) {
  compare::Comparison comparison = made_up();
  comparison.tests.erase(comparison.tests.begin());
  comparison.free_zero = {false};
  comparison.systems = {wrong_by(comparison, "by resistance", 1, false)};
  const std::string text = compare::comparison_text(comparison);
  EXPECT_THAT(text, HasSubstr("\nby resistance     -     -    -      -           -\n"));
  EXPECT_THAT(text, HasSubstr("by resistance: no estimate: the tests lack"));
  const auto json = nlohmann::json::parse(compare::comparison_json(comparison));
  EXPECT_TRUE(json["systems"][0]["identified"]);
  EXPECT_EQ(json["systems"][0]["error"], nlohmann::json({{"rows", 0}}));
}

TEST(CompareOutput, AMovedTrainingRunIsNamed) {
  compare::Comparison comparison = made_up();
  for (double& strain : comparison.training[0].strain) {
    strain -= 0.021;
  }
  EXPECT_THAT(compare::comparison_text(comparison),
              HasSubstr("train.csv: the strain has a zero of its own"));
}

TEST(CompareOutput, JsonHasTheNumbers) {
  const compare::Comparison comparison = made_up();
  const auto json = nlohmann::json::parse(compare::comparison_json(comparison));
  EXPECT_EQ(json["from"], "a wire");
  EXPECT_EQ(json["nominal_stroke"], 0.04);
  EXPECT_THAT(json["training"], ElementsAre("folder/train.csv"));
  EXPECT_EQ(json["tests"][0], nlohmann::json({{"file", "folder/<b>&.csv"},
                                              {"free_zero", false},
                                              {"stress_beyond", 0.125},
                                              {"resistance_beyond", 0.0}}));
  EXPECT_EQ(json["tests"][1]["free_zero"], true);
  ASSERT_EQ(json["systems"].size(), 3U);
  const auto& other = json["systems"][1];
  EXPECT_EQ(other["name"], "by resistance");
  EXPECT_EQ(other["identified"], true);
  EXPECT_EQ(other["parameters"], 7);
  EXPECT_DOUBLE_EQ(other["step_s"], 123e-9);
  EXPECT_EQ(other["error"]["rows"], 200);
  EXPECT_DOUBLE_EQ(other["error"]["mean_percent"], 2.25);
  EXPECT_DOUBLE_EQ(other["error"]["p95_percent"], comparison.systems[1].error.quantile(0.95));
  EXPECT_DOUBLE_EQ(other["error"]["max_percent"], 2.25);
  EXPECT_EQ(other["tests"][0]["file"], "folder/<b>&.csv");
  EXPECT_EQ(other["tests"][1], nlohmann::json({{"file", "bath.csv"}, {"rows", 0}}));
  EXPECT_EQ(json["systems"][0]["tests"][1]["rows"], 200);
  EXPECT_EQ(json["systems"][2]["identified"], false);
  EXPECT_EQ(json["systems"][2]["remark"], "not identified: too <few> runs");
  EXPECT_FALSE(json["systems"][2].contains("error"));
}

TEST(CompareOutput, JsonSurvivesOddNames) {
  compare::Comparison comparison = made_up();
  comparison.tests[0].name = "a \"b\"\\\n\xFF.csv";
  EXPECT_TRUE(nlohmann::json::accept(compare::comparison_json(comparison)));
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

TEST(CompareOutput, ReportHasTheTableAndALoopForEachTestThatASystemTellsOf) {
  const TemporaryFolder folder;
  compare::write_comparison_report(folder / "r.html", made_up(), Units::bench);
  const std::string html = file_text(folder / "r.html");
  EXPECT_THAT(html, HasSubstr("<tr><td>good</td><td>0.50</td><td>0.50</td><td>0.50</td>"
                              "<td>123 ns</td><td>7</td><td>0.50</td><td>0.50</td></tr>"));
  EXPECT_THAT(html, HasSubstr("<td>7</td><td>2.25</td><td>-</td></tr>"));
  EXPECT_THAT(html, HasSubstr("<tr><td>refused</td><td>-</td><td>-</td>"));
  EXPECT_THAT(html, HasSubstr("<b>good</b>: a meaning.<br>"));
  EXPECT_THAT(html, HasSubstr("<b>refused</b>: not identified: too &lt;few&gt; runs.<br>"));
  EXPECT_EQ(count(html, "data:image/svg+xml;base64,"), 3U + 2U) << "and the errors of each test";
  EXPECT_THAT(html, HasSubstr("<h2>&lt;b&gt;&amp;.csv: good</h2>"));
  EXPECT_THAT(html, HasSubstr("<h2>bath.csv: good</h2>"));
  EXPECT_THAT(html, Not(HasSubstr("<h2>bath.csv: by resistance</h2>")));
  EXPECT_THAT(html, Not(HasSubstr("<b>&")));
}

TEST(CompareOutput, ReportIsNotWrittenWhereItCannotBe) {
  const TemporaryFolder folder;
  EXPECT_THROW(compare::write_comparison_report(folder / "missing/r.html", made_up(), Units::bench),
               files::UserError);
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace smaservo::test
