#include "host-sim/evaluate/evaluate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/table.hpp"
#include "host-sim/parallel.hpp"
#include "model/files/error.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Wires that stand for calibrated ones, which take a minute each: the units as they were drawn.
void write_wires(const TemporaryFolder& folder) {
  for (const hal::Family family : hal::families) {
    folder.write(evaluate::calibrated_name(family, evaluate::first_test_seed),
                 files::to_toml(bench::random_unit(family, evaluate::first_test_seed).wire));
  }
}

evaluate::EvaluateOptions small(const TemporaryFolder& wires) {
  evaluate::EvaluateOptions options;
  options.units = 1;
  options.runs = 2;
  options.rows = {"standard", "hold", "coarse"};
  options.wires = wires.path();
  return options;
}

std::string error_of(const evaluate::EvaluateOptions& options) {
  try {
    evaluate::evaluate(options);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

/// The families that nothing is chosen by.
TEST(Evaluate, JudgesAnyFamilyByItself) {
  for (const hal::Family family : {hal::Family::free_energy, hal::Family::smooth_hardening}) {
    evaluate::EvaluateOptions options;
    options.families = {family};
    options.units = 1;
    options.runs = 3;
    options.rows = {"uncalibrated"};
    const evaluate::Evaluation evaluation = evaluate::evaluate(options);
    const evaluate::RowResult& row = evaluation.observers.front().rows.front();
    ASSERT_EQ(row.by_family.size(), 1U);
    EXPECT_EQ(row.by_family[0].family, family);
    EXPECT_EQ(row.by_family[0].figures.runs, 3);
    EXPECT_GT(row.all.error.mean(), 0.5) << "it is not the observer's model";
    EXPECT_LT(row.all.error.mean(), 6);
  }
}

TEST(Evaluate, IsTheSameForAnyNumberOfThreads) {
  const TemporaryFolder wires;
  write_wires(wires);
  evaluate::EvaluateOptions options = small(wires);
  std::vector<std::size_t> done;
  options.progress = [&](std::string_view stage, std::size_t parts, std::size_t total) {
    if (stage == "runs") {
      EXPECT_EQ(total, 6U);
      done.push_back(parts);
    }
  };
  const evaluate::Evaluation alone = evaluate::evaluate(options);
  EXPECT_THAT(done, ElementsAre(0, 1, 2, 3, 4, 5, 6));
  options.threads = 2;
  EXPECT_EQ(evaluate::table_json(evaluate::evaluate(options)), evaluate::table_json(alone));

  ASSERT_EQ(alone.observers.size(), 2U);
  EXPECT_EQ(alone.observers[0].rows.size(), 3U);
  EXPECT_EQ(alone.observers[1].observer, "open-loop");
  ASSERT_EQ(alone.observers[1].rows.size(), 1U) << "the hold";
  for (const evaluate::RowResult& row : alone.observers[0].rows) {
    EXPECT_EQ(row.all.runs, 2);
    EXPECT_EQ(row.by_family[0].figures.runs, 1);
    EXPECT_EQ(row.all.error.count(),
              row.by_family[0].figures.error.count() + row.by_family[1].figures.error.count());
    EXPECT_GT(row.all.error.mean(), 0.02);
    EXPECT_LT(row.all.error.mean(), 5);
  }
}

TEST(Evaluate, ObserversAreJudgedOnTheSameRuns) {
  const TemporaryFolder wires;
  write_wires(wires);
  evaluate::EvaluateOptions options = small(wires);
  options.rows = {"standard"};
  const double alone = evaluate::evaluate(options).observers[0].rows[0].all.error.mean();
  options.observers = {"line", "kalman"};
  const evaluate::Evaluation both = evaluate::evaluate(options);
  ASSERT_EQ(both.observers.size(), 2U);
  EXPECT_EQ(both.observers[1].rows[0].all.error.mean(), alone);
  EXPECT_GT(both.observers[0].rows[0].all.error.mean(), 2 * alone);
}

TEST(Evaluate, SettingsReachTheObserver) {
  const TemporaryFolder wires;
  write_wires(wires);
  evaluate::EvaluateOptions options = small(wires);
  options.rows = {"coarse"};
  const double usual = evaluate::evaluate(options).observers[0].rows[0].all.error.mean();
  options.settings = {{"observer.resistance_model_sd", "0.2"}};
  EXPECT_NE(evaluate::evaluate(options).observers[0].rows[0].all.error.mean(), usual);
}

TEST(Evaluate, MistakesAreNamed) {
  const TemporaryFolder folder;
  const evaluate::EvaluateOptions good = small(folder);
  evaluate::EvaluateOptions bad = good;
  bad.units = 0;
  EXPECT_THAT(error_of(bad), HasSubstr("--units 0: must be between 1 and 1000"));
  bad = good;
  bad.rows = {"windy"};
  EXPECT_THAT(error_of(bad), HasSubstr("--row windy: no such row; there are: standard, disturbed"));
  bad = good;
  bad.observers = {"oracle"};
  EXPECT_THAT(error_of(bad), HasSubstr("--observer oracle: no such observer"));
  bad = good;
  bad.observers = {"line", "line"};
  EXPECT_THAT(error_of(bad), HasSubstr("--observer line: is given twice"));
  bad = good;
  bad.settings = {{"wire.length_m", "1"}};
  EXPECT_THAT(error_of(bad), HasSubstr("--set: wire.length_m = 1: unknown table"));
  bad = good;
  bad.wires = folder.write("file", "");
  EXPECT_THAT(error_of(bad), HasSubstr("--wires " + bad.wires + ": "));
}

TEST(EvaluateCommand, WritesWhatItIsAskedFor) {
  Program program;
  const Finished run =
      program.run({"evaluate", "--row", "uncalibrated", "--units", "1", "--runs", "2", "--out",
                   "t.json", "--report", "t.html", "--threads", "2"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("\nkalman\nrow "));
  EXPECT_THAT(run.out, HasSubstr("\nuncalibrated  "));
  EXPECT_EQ(run.err, "");
  const auto json = nlohmann::json::parse(file_text(program.folder() / "t.json"));
  EXPECT_EQ(json["observers"]["kalman"][0]["all"]["runs"], 2);
  EXPECT_THAT(file_text(program.folder() / "t.html"), HasSubstr("uncalibrated"));
}

TEST(EvaluateCommand, RefusesBeforeItWorks) {
  Program program;
  EXPECT_EQ(program.run({"evaluate", "--row", "standard,windy"}).status, 2);
  EXPECT_EQ(program.run({"evaluate", "--observer", "oracle"}).status, 2);
  const Finished units = program.run({"evaluate", "--units", "0"});
  EXPECT_EQ(units.status, 1);
  EXPECT_THAT(units.err, HasSubstr("--units 0"));
  const Finished out = program.run({"evaluate", "--out", "table.txt"});
  EXPECT_EQ(out.status, 1);
  EXPECT_THAT(out.err, HasSubstr("--out table.txt: must be a folder or end in .json"));
}

TEST(Parallel, ThrowsWhatTheFirstFailureHasThrown) {
  for (int threads = 1; threads <= 4; ++threads) {
    std::size_t finished = 0;
    try {
      parallel(
          100, threads,
          [](std::size_t i) {
            if (i >= 10) {
              throw files::UserError(std::to_string(i));
            }
          },
          [&](std::size_t) { ++finished; });
      ADD_FAILURE() << "nothing thrown";
    } catch (const files::UserError& error) {
      EXPECT_STREQ(error.what(), "10");
    }
    EXPECT_GE(finished, 11U);
    EXPECT_LT(finished, 100U);
  }
}

}  // namespace
}  // namespace smaservo::test
