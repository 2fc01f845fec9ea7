#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/campaign/report.hpp"
#include "host-sim/evaluate/figures.hpp"
#include "host-sim/evaluate/runs_file.hpp"
#include "host-sim/evaluate/table.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"
#include "tests/places.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string golden_wires() {
  return smaservo::test::source_folder() + "/tests/golden/evaluate";
}

/// Runs without a calibration.
class CampaignEvaluate : public ::testing::Test {
 protected:
  Campaign read(const std::string& table, const std::string& plan = "") const {
    return read_plan(
        folder_.write("plan.toml", (plan.empty() ? "trials = 2\nseed = 1000\n" : plan) +
                                       "kind = 'evaluate'\n[evaluate]\n" + table),
        all_kinds());
  }
  std::string refusal(const std::string& table, const std::string& plan = "") const {
    return error_of([&] { read(table, plan); });
  }

  TemporaryFolder folder_;
};

std::string golden_table() {
  return "runs = 1\nrows = ['standard', 'unknown-start', 'hold']\nwires = '" + golden_wires() +
         "'\n";
}

evaluate::EvaluateOptions golden_options() {
  evaluate::EvaluateOptions options;
  options.units = 1;
  options.runs = 1;
  options.rows = {"standard", "unknown-start", "hold"};
  options.wires = golden_wires();
  return options;
}

/// Each unit's figures are those that `evaluate` gives to it alone, which the row's command runs.
TEST_F(CampaignEvaluate, ATrialIsTheEvaluationOfOneUnit) {
  const Campaign campaign = read(golden_table());
  for (std::uint64_t trial = 0; trial < 2; ++trial) {
    evaluate::EvaluateOptions options = golden_options();
    options.families = {hal::tuning_families.at(static_cast<std::size_t>(trial))};
    const evaluate::Evaluation alone = evaluate::evaluate(options);
    const TrialResult result = campaign.trials->run(trial, {});
    ASSERT_EQ(result.files.size(), 1U) << "no wire, since none was calibrated";
    EXPECT_EQ(result.files.front().text, evaluate::runs_csv(alone));
    std::vector<double> expected;
    for (const evaluate::RowResult& row : alone.observers.front().rows) {
      for (const evaluate::Figure& figure : evaluate::row_figures(alone.observers.front(), row)) {
        expected.push_back(figure.value);
      }
    }
    const std::size_t drawn = result.row.size() - expected.size();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_DOUBLE_EQ(std::get<double>(result.row.at(drawn + i)), expected[i])
          << campaign.trials->columns().at(drawn + i).name;
    }
    EXPECT_EQ(campaign.trials->command(trial),
              fmt::format("host-sim evaluate --family {} --units 1 --seed 1000 --runs 1 --row "
                          "standard,unknown-start,hold --wires {}",
                          hal::family_name(options.families.front()), golden_wires()));
  }
}

/// The table of all units is that of `evaluate`, but for the order in which sums are made.
TEST_F(CampaignEvaluate, TheTableIsThatOfAllRunsTogether) {
  const Campaign campaign = read(golden_table());
  const std::string out = folder_ / "out";
  run_into(campaign, out, {}, 2);
  merge_in(campaign, out);
  const Report report = make_report(campaign, Folder::existing(campaign, out));
  const evaluate::EvaluateOptions all = golden_options();
  evaluate::JoinedRuns joined(all.families);
  for (const hal::Family family : hal::tuning_families) {
    evaluate::EvaluateOptions options = golden_options();
    options.families = {family};
    for (const auto& run :
         evaluate::read_runs_csv(evaluate::runs_csv(evaluate::evaluate(options)))) {
      joined.add(run);
    }
  }
  EXPECT_EQ(report.table->text(), evaluate::table_text(joined.evaluation(1, 1000)));
  EXPECT_THAT(report_text(campaign, report),
              AllOf(HasSubstr("of units 1000 of each family"), HasSubstr("open-loop"),
                    HasSubstr("standard_mean_percent")));
  EXPECT_EQ(report.main, "standard_mean_percent");
  // In its file, too.
  const auto kept = evaluate::read_runs_csv(file_text(out + "/files/ihyp-1000.csv"));
  EXPECT_EQ(kept.size(), 3U + 1U);
}

TEST_F(CampaignEvaluate, RunsReadFromTheirFileAreTheSame) {
  evaluate::EvaluateOptions options = golden_options();
  options.observers = {"kalman", "line"};
  const evaluate::Evaluation whole = evaluate::evaluate(options);
  const std::vector<evaluate::KeptRun> runs = evaluate::read_runs_csv(evaluate::runs_csv(whole));
  evaluate::JoinedRuns joined(options.families);
  for (const evaluate::KeptRun& run : runs) {
    joined.add(run);
  }
  const evaluate::Evaluation again = joined.evaluation(1, 1000);
  EXPECT_EQ(evaluate::table_text(again), evaluate::table_text(whole));
  EXPECT_EQ(evaluate::table_markdown(again), evaluate::table_markdown(whole));
  // Each run by itself, too.
  evaluate::Evaluation one_by_one = again;
  for (evaluate::ObserverEvaluation& observer : one_by_one.observers) {
    for (evaluate::RowResult& row : observer.rows) {
      row.runs.clear();
      for (const evaluate::KeptRun& run : runs) {
        if (run.observer == observer.observer && run.row == row.row) {
          row.runs.push_back(run.judged);
        }
      }
    }
  }
  EXPECT_EQ(evaluate::table_json(one_by_one), evaluate::table_json(whole));
}

TEST_F(CampaignEvaluate, AFileOfRunsThatWasChangedIsRefused) {
  const std::string text =
      "observer,row,family,unit,condition,disturbed,seed,error_sum_percent,"
      "error_max_percent,lost,with_sd,within_2_sd,drift_percent,found_s,locked,"
      "sure,errors\n";
  const std::string line =
      "kalman,standard,ihyp,1000,constant,false,7,1.5,1,false,3,2,,,,,0:2 100:1\n";
  EXPECT_EQ(evaluate::read_runs_csv(text + line).front().judged.figures.error.count(), 3U);
  const auto refused = [&](const std::string& changed) {
    return error_of([&] { evaluate::read_runs_csv(changed); });
  };
  EXPECT_THAT(refused(line), HasSubstr("the first line is not"));
  EXPECT_THAT(refused(text + line + "kalman\n"), HasSubstr("line 3 has 1 cells, not 17"));
  const std::pair<const char*, const char*> changes[] = {
      {"standard", "light or so"}, {"ihyp", "steel"},          {"1.5", "1.5 %"}, {"1000", "-1"},
      {"0:2 100:1", "100:1 0:2"},  {"0:2 100:1", "9999999:1"}, {"0:2", "0"}};
  for (const auto& [part, other] : changes) {
    std::string changed = line;
    changed.replace(changed.find(part), std::string(part).size(), other);
    EXPECT_THAT(refused(text + changed), HasSubstr("line 2 has ")) << other;
  }
}

TEST_F(CampaignEvaluate, PlansThatCannotBeRunAreRefused) {
  EXPECT_THAT(refusal("rows = ['standard', 'heavy']\n"),
              AllOf(HasSubstr("plan.toml"), HasSubstr("rows"), HasSubstr("unknown-start")));
  EXPECT_THAT(refusal("rows = []\n"), HasSubstr("must be a list"));
  EXPECT_THAT(refusal("observers = ['kalman', 'kalman']\n"), HasSubstr("each once"));
  EXPECT_THAT(refusal("families = ['steel']\n"), HasSubstr("must be some of: ihyp"));
  EXPECT_THAT(refusal("runs = -1\n"), HasSubstr("runs"));
  EXPECT_THAT(refusal("units = 3\n"), HasSubstr("units"));
  EXPECT_THAT(refusal("", "seed = 1\n"), HasSubstr("trials"));
  EXPECT_THAT(refusal("", "trials = 2\nseed = 1000000001\n"), HasSubstr("above 1000000000"));
  EXPECT_THAT(refusal("wires = '" + golden_wires() + "'\n", "trials = 3\nseed = 1000\n"),
              HasSubstr("ihyp-1001.toml"));
}

TEST_F(CampaignEvaluate, StopsWithinATrial) {
  const Campaign campaign = read("runs = 1000\nrows = ['uncalibrated']\n");
  int asked = 0;
  EXPECT_THROW(campaign.trials->run(0, [&] { return ++asked > 1; }), Stopped);
  const Campaign calibrating = read("runs = 1\nrows = ['standard']\n");
  asked = 0;
  EXPECT_THROW(calibrating.trials->run(0, [&] { return ++asked > 1; }), Stopped);
}

}  // namespace
}  // namespace smaservo::campaign::test
