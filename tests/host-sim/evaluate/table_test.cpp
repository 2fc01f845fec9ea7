#include "host-sim/evaluate/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "host-sim/evaluate/figures.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t row_named(std::string_view name) {
  const auto& rows = evaluate::evaluation_rows();
  return static_cast<std::size_t>(std::ranges::find(rows, name, &evaluate::EvaluationRow::name) -
                                  rows.begin());
}

evaluate::JudgedRun judged(hal::Family family, evaluate::Condition condition, double error) {
  evaluate::JudgedRun run{.run = {family, 1000, condition, false, 7}, .figures = {}, .start = {}};
  for (int i = 0; i < 100; ++i) {
    run.figures.error.add(error);
  }
  run.figures.with_sd = 100;
  run.figures.within_2_sd = 94;
  run.figures.lost = error > 20;
  return run;
}

evaluate::RowResult row(std::string_view name, const evaluate::JudgedRun& ihyp,
                        const evaluate::JudgedRun& sublayers) {
  evaluate::RowSum sum({hal::Family::ihyp, hal::Family::sublayers}, row_named(name));
  sum.add(ihyp);
  sum.add(sublayers);
  return sum.result({ihyp, sublayers});
}

/// Two rows and a start, made by hand.
evaluate::Evaluation evaluation() {
  evaluate::JudgedRun found = judged(hal::Family::ihyp, evaluate::Condition::unknown_start, 2);
  found.start = evaluate::StartFigures{0.4, false, true};
  evaluate::JudgedRun never =
      judged(hal::Family::sublayers, evaluate::Condition::unknown_start, 30);
  never.start = evaluate::StartFigures{std::numeric_limits<double>::infinity(), true, false};
  return {0.04,
          1,
          1000,
          {{"kalman",
            {row("standard", judged(hal::Family::ihyp, evaluate::Condition::constant, 0.25),
                 judged(hal::Family::sublayers, evaluate::Condition::spring, 0.75)),
             row("unknown-start", found, never),
             row("coarse", judged(hal::Family::ihyp, evaluate::Condition::coarse, 0.65),
                 judged(hal::Family::sublayers, evaluate::Condition::coarse, 0.65))}}}};
}

TEST(Table, AsText) {
  EXPECT_EQ(
      evaluate::table_text(evaluation()),
      R"(Error in % of the nominal stroke (4 % strain) after the first second, of units 1000 of each family
* misses its target

kalman
                                                               in 2
row            family     runs    mean    95 %    max   lost     sd      target
standard       all           2    0.50*   0.75    0.8      0   94.0   0.4/1.2/4
standard       ihyp          1    0.25    0.25    0.2      0   94.0   0.4/1.2/4
standard       sublayers     1    0.75*   0.75    0.8      0   94.0   0.4/1.2/4
unknown-start  all           2   16.00   30.00   30.0      1   94.0
unknown-start  ihyp          1    2.00    2.00    2.0      0   94.0
unknown-start  sublayers     1   30.00   30.00   30.0      1   94.0
coarse         all           2    0.65    0.65    0.7      0   94.0         0.7
coarse         ihyp          1    0.65*   0.65    0.7      0   94.0        0.45
coarse         sublayers     1    0.65    0.65    0.7      0   94.0        0.95

row                                           target     all   ihyp   sublayers
unknown-start  motion until found: median, s            0.40   0.40       never
unknown-start  motion until found: 90 %, s       0.2   never*  0.40*      never*
unknown-start  never found                         0       1*     0           1*
unknown-start  unsure after one heating            0       1*     0           1*

worst runs
standard: mean 0.75, sublayers 1000, spring, seed 7
unknown-start: mean 30.00, sublayers 1000, unknown-start, seed 7
coarse: mean 0.65, ihyp 1000, coarse, seed 7
)");
}

TEST(Table, AsMarkdown) {
  const std::string text = evaluate::table_markdown(evaluation());
  EXPECT_THAT(text, HasSubstr("\n| row | family | runs | mean | 95 % | max | lost | in 2 sd | "
                              "target |\n|---|---|--:|"));
  EXPECT_THAT(text, HasSubstr("\n| standard | all | 2 | **0.50** | 0.75 | 0.8 | 0 | 94.0 | "
                              "0.4/1.2/4 |\n| standard | ihyp | 1 | 0.25 |"));
  EXPECT_THAT(text, HasSubstr("\n| standard | sublayers | 1 | **0.75** |"));
}

/// A family whose wires were judged alone has the targets, too, and no line of all.
TEST(Table, OfOneFamily) {
  const evaluate::JudgedRun run = judged(hal::Family::ihyp, evaluate::Condition::gust, 3.5);
  evaluate::RowSum sum({hal::Family::ihyp}, row_named("gust"));
  sum.add(run);
  const std::string text =
      evaluate::table_markdown({0.04, 1, 1000, {{"kalman", {sum.result({run})}}}});
  EXPECT_THAT(text, HasSubstr("|\n| gust | ihyp | 1 | 3.50 | **3.50** | 3.5 | 0 | 94.0 | –/3 |\n"));
  EXPECT_THAT(text, Not(HasSubstr("| all |")));
}

/// With fewer runs than families a family has none: it has no line, no numbers, and misses nothing.
TEST(Table, AFamilyWithoutRunsHasNoLine) {
  const evaluate::JudgedRun run = judged(hal::Family::ihyp, evaluate::Condition::hold_ripple, 0.25);
  evaluate::RowSum sum({hal::Family::ihyp, hal::Family::sublayers}, row_named("hold"));
  sum.add(run);
  const evaluate::Evaluation made{0.04, 1, 1000, {{"kalman", {sum.result({run})}}}};
  EXPECT_THAT(evaluate::table_markdown(made), HasSubstr("| hold | ihyp |"));
  EXPECT_THAT(evaluate::table_markdown(made), Not(HasSubstr("| hold | sublayers |")));
  const auto json = nlohmann::json::parse(evaluate::table_json(made));
  const auto& none = json["observers"]["kalman"][0]["sublayers"];
  EXPECT_EQ(none["runs"], 0);
  EXPECT_TRUE(none["mean_percent"].is_null());
  EXPECT_TRUE(none["targets"].empty());
}

/// Three units, as --units has them, give at least 100 runs of each family.
TEST(Table, RowsHaveManyRuns) {
  for (const evaluate::EvaluationRow& row : evaluate::evaluation_rows()) {
    EXPECT_GE(evaluate::EvaluateOptions().units * row.runs, 100) << row.name;
  }
}

TEST(Table, AsJsonHasAllNumbersAndTargets) {
  const auto json = nlohmann::json::parse(evaluate::table_json(evaluation()));
  EXPECT_EQ(json["seed"], 1000);
  const auto& standard = json["observers"]["kalman"][0];
  EXPECT_EQ(standard["row"], "standard");
  EXPECT_EQ(standard["all"]["mean_percent"], 0.5);
  EXPECT_EQ(standard["sublayers"]["mean_percent"], 0.75);
  EXPECT_EQ(standard["targets"]["mean_percent"]["max"], 0.4);
  EXPECT_EQ(standard["targets"]["mean_percent"]["missed"], true);
  EXPECT_EQ(standard["targets"]["p95_percent"]["missed"], false);
  EXPECT_EQ(standard["targets"]["within_2_sd_percent"]["min"], 92);
  EXPECT_EQ(standard["ihyp"]["targets"]["mean_percent"]["missed"], false);
  EXPECT_EQ(standard["sublayers"]["targets"]["mean_percent"]["missed"], true);
  EXPECT_EQ(standard["each_run"][1]["condition"], "spring");
  EXPECT_EQ(standard["each_run"][1]["seed"], 7);
  const auto& start = json["observers"]["kalman"][1];
  EXPECT_TRUE(start["all"]["found_p90_s"].is_null()) << "infinite";
  EXPECT_EQ(start["targets"]["found_p90_s"]["missed"], true);
  EXPECT_FALSE(start["targets"].contains("found_median_s"));
  EXPECT_EQ(start["sublayers"]["targets"]["locked"]["missed"], true);
  EXPECT_EQ(start["ihyp"]["targets"]["locked"]["missed"], false);
  EXPECT_EQ(start["ihyp"]["targets"]["found_p90_s"]["missed"], true) << "0.4 s";
  const auto& coarse = json["observers"]["kalman"][2];
  EXPECT_NEAR(coarse["ihyp"]["targets"]["mean_percent"]["max"], 0.45, 1e-12);
  EXPECT_EQ(start["all"]["locked"], 1);
}

TEST(Table, CoarseIsComparedWithStandard) {
  evaluate::Evaluation made = evaluation();
  evaluate::ObserverEvaluation& kalman = made.observers.front();
  const auto mean = [&](std::optional<hal::Family> family) {
    return evaluate::row_figures(kalman, kalman.rows.back(), family).front();
  };
  EXPECT_NEAR(mean({}).max, 0.7, 1e-12);
  EXPECT_FALSE(mean({}).missed());
  EXPECT_NEAR(mean(hal::Family::ihyp).max, 0.45, 1e-12);
  EXPECT_TRUE(mean(hal::Family::ihyp).missed());
  EXPECT_NEAR(mean(hal::Family::sublayers).max, 0.95, 1e-12);
  EXPECT_FALSE(mean(hal::Family::sublayers).missed());
  kalman.rows.erase(kalman.rows.begin());
  EXPECT_FALSE(mean({}).has_target());
  EXPECT_FALSE(mean(hal::Family::ihyp).has_target());
}

TEST(Table, ReportIsOneFileWithTheNumbers) {
  const TemporaryFolder folder;
  evaluate::write_table_report(folder / "r.html", evaluation());
  EXPECT_EQ(folder.names().size(), 1U);
  const std::string html = file_text(folder / "r.html");
  EXPECT_THAT(html,
              HasSubstr("<td>standard</td><td>all</td><td>2</td><td class=\"lost\">0.50</td>"));
  EXPECT_THAT(html, HasSubstr("sublayers 1000, spring, seed 7"));
}

TEST(Table, IsRewrittenBetweenItsMarks) {
  const TemporaryFolder folder;
  const std::string file = folder.write(
      "a.md",
      "before\n<!-- evaluate: host-sim evaluate -->\nold\n<!-- end of evaluate -->\nafter\n");
  evaluate::TableFile(file).rewrite(evaluate::table_markdown(evaluation()));
  EXPECT_EQ(file_text(file), "before\n<!-- evaluate: host-sim evaluate -->\n\n" +
                                 evaluate::table_markdown(evaluation()) +
                                 "\n<!-- end of evaluate -->\nafter\n");
  const std::string once = file_text(file);
  evaluate::TableFile(file).rewrite(evaluate::table_markdown(evaluation()));
  EXPECT_EQ(file_text(file), once);
}

TEST(Table, KeepsWhatWasEditedDuringTheEvaluation) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("a.md", "before\n<!-- evaluate: x -->\nold\n<!-- end of evaluate -->\nafter\n");
  const evaluate::TableFile table(file);
  folder.write("a.md", "edited\n<!-- evaluate: y -->\nold\n<!-- end of evaluate -->\ntoo\n");
  table.rewrite("new");
  EXPECT_EQ(file_text(file),
            "edited\n<!-- evaluate: y -->\n\nnew\n<!-- end of evaluate -->\ntoo\n");
  folder.write("a.md", "all is gone\n");
  EXPECT_THROW(table.rewrite("new"), files::UserError);
  EXPECT_EQ(file_text(file), "all is gone\n");
}

TEST(Table, IsNotWrittenWithoutMarks) {
  const TemporaryFolder folder;
  for (const char* text :
       {"", "<!-- evaluate: x -->\n", "<!-- end of evaluate -->\n<!-- evaluate: x -->\n"}) {
    const std::string file = folder.write("a.md", text);
    EXPECT_THROW(evaluate::TableFile{file}, files::UserError);
    EXPECT_EQ(file_text(file), text);
  }
  EXPECT_THROW(evaluate::TableFile{folder / "missing.md"}, files::UserError);
}

}  // namespace
}  // namespace smaservo::test
