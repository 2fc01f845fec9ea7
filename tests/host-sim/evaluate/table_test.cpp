#include "host-sim/evaluate/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host-sim/evaluate/figures.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;

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
row            runs    mean    95 %     max   lost   in 2 sd          target                ihyp              sublayers
standard          2    0.50*   0.75    0.75      0      94.0   0.4 / 1.2 / 4   0.25 / 0.25 / 0.2      0.75 / 0.75 / 0.8
unknown-start     2   16.00   30.00   30.00      1      94.0                   2.00 / 2.00 / 2.0   30.00 / 30.00 / 30.0
coarse            2    0.65    0.65    0.65      0      94.0             0.7   0.65 / 0.65 / 0.7      0.65 / 0.65 / 0.7

row                                                        value   target   ihyp   sublayers
unknown-start  seconds of motion until within 6 %, median   0.40        1   0.40       never
unknown-start  seconds of motion until within 6 %, 90 %    never*       3   0.40       never
unknown-start  runs never found                                1*       0      0           1
unknown-start  runs unsure after one heating                   1*       0      0           1

worst runs
standard: mean 0.75, sublayers 1000, spring, seed 7
unknown-start: mean 30.00, sublayers 1000, unknown-start, seed 7
coarse: mean 0.65, ihyp 1000, coarse, seed 7
)");
}

TEST(Table, AsMarkdown) {
  const std::string text = evaluate::table_markdown(evaluation());
  EXPECT_THAT(text, HasSubstr("\n| row | runs | mean | 95 % | max | lost | in 2 sd | target | ihyp "
                              "| sublayers |\n|---|--:|"));
  EXPECT_THAT(text, HasSubstr("\n| standard | 2 | **0.50** | 0.75 | 0.75 | 0 | 94.0 | 0.4 / 1.2 / "
                              "4 | 0.25 / 0.25 / 0.2 | 0.75 / 0.75 / 0.8 |\n"));
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
  EXPECT_EQ(standard["targets"]["within_2_sd_percent"]["min"], 90);
  EXPECT_EQ(standard["each_run"][1]["condition"], "spring");
  EXPECT_EQ(standard["each_run"][1]["seed"], 7);
  const auto& start = json["observers"]["kalman"][1];
  EXPECT_TRUE(start["all"]["found_p90_s"].is_null()) << "infinite";
  EXPECT_EQ(start["targets"]["found_p90_s"]["missed"], true);
  EXPECT_EQ(start["targets"]["found_median_s"]["missed"], false);
  EXPECT_EQ(start["all"]["locked"], 1);
}

TEST(Table, CoarseIsComparedWithStandard) {
  evaluate::Evaluation made = evaluation();
  evaluate::ObserverEvaluation& kalman = made.observers.front();
  const auto mean = [&] { return evaluate::row_figures(kalman, kalman.rows.back()).front(); };
  EXPECT_NEAR(mean().max, 0.7, 1e-12);
  EXPECT_FALSE(mean().missed());
  kalman.rows.erase(kalman.rows.begin());
  EXPECT_FALSE(mean().has_target());
}

TEST(Table, ReportIsOneFileWithTheNumbers) {
  const TemporaryFolder folder;
  evaluate::write_table_report(folder / "r.html", evaluation());
  EXPECT_EQ(folder.names().size(), 1U);
  const std::string html = file_text(folder / "r.html");
  EXPECT_THAT(html, HasSubstr("<td>standard</td><td>2</td><td class=\"lost\">0.50</td>"));
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
