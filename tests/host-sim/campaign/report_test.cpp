#include "host-sim/campaign/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host-sim/campaign/small_campaign.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

TEST(CampaignReport, RankCorrelationIsThatOfRanks) {
  const std::vector<double> x{1, 2, 3, 4, 5};
  EXPECT_DOUBLE_EQ(rank_correlation(x, {1, 10, 100, 1e4, 1e9}), 1) << "any rising curve";
  EXPECT_DOUBLE_EQ(rank_correlation(x, {5, 4, 3, 2, -1e9}), -1);
  // 1 - 6 (0 + 1 + 1 + 1 + 1) / (5 (25 - 1))
  EXPECT_DOUBLE_EQ(rank_correlation(x, {1, 3, 2, 5, 4}), 0.8);
  // Ranks 0.5, 0.5, 2 against 0, 1, 2.
  EXPECT_DOUBLE_EQ(rank_correlation({7, 7, 9}, {1, 2, 3}), 1.5 / std::sqrt(1.5 * 2));
  EXPECT_DOUBLE_EQ(rank_correlation({1, no_number, 2, 3}, {1, 99, 2, no_number}), 1);
  EXPECT_TRUE(std::isnan(rank_correlation({1, 1, 1}, {1, 2, 3})));
  EXPECT_TRUE(std::isnan(rank_correlation({1}, {1})));
}

/// Trials whose value rises with `cause`, and has nothing to do with `other`.
class RisingTrials final : public Trials {
 public:
  const std::vector<Column>& columns() const override {
    static const std::vector<Column> all{{"seed", true},
                                         {"cause", true},
                                         {"other", true},
                                         {"class", true, true},
                                         {"value_m", false}};
    return all;
  }
  std::string_view main_column() const override { return "value_m"; }
  double cost_s() const override { return 1; }
  TrialResult run(std::uint64_t index, const Stop& /*stop*/) const override {
    const auto cause = static_cast<double>(index * 37 % 200);
    return {{index, cause, static_cast<double>(index * 59 % 7), index % 2 == 0 ? "a,\"b\"" : "c",
             index == 13 ? no_number : cause * cause}};
  }
  std::string command(std::uint64_t index) const override { return fmt::format("run {}", index); }
};

std::unique_ptr<const Trials> read_rising(KindTable& /*table*/) {
  return std::make_unique<RisingTrials>();
}

class CampaignReportOf : public ::testing::Test {
 protected:
  static constexpr std::array kinds{Kind{"rising", read_rising}};
  CampaignReportOf() { run_into(campaign_, folder_ / "out"); }
  Report report(std::uint64_t most = 1000) const {
    return make_report(campaign_, Folder::existing(campaign_, folder_ / "out"), false, most);
  }

  TemporaryFolder folder_;
  Campaign campaign_ = read_plan(
      folder_.write("plan.toml", "kind = 'rising'\ntrials = 200\nchunk = 30\n[rising]\n"), kinds);
};

TEST_F(CampaignReportOf, FindsTheWorstAndWhatTheyDependOn) {
  const Report all = report();
  EXPECT_EQ(all.used, 200U);
  ASSERT_EQ(all.worst.size(), 10U);
  for (std::size_t i = 0; i < all.worst.size(); ++i) {
    // No trial but 13, whose cause is 81, has no number.
    const double cause = 199 - static_cast<double>(i);
    EXPECT_EQ(all.worst[i].value, cause * cause);
    EXPECT_EQ(all.worst[i].trial * 37 % 200, static_cast<std::uint64_t>(cause));
  }
  ASSERT_EQ(all.sensitivities.size(), 2U) << "a seed is no quantity";
  EXPECT_EQ(all.sensitivities[0].column, "cause");
  EXPECT_DOUBLE_EQ(all.sensitivities[0].correlation, 1);
  EXPECT_TRUE(all.sensitivities[0].certain);
  EXPECT_LT(std::abs(all.sensitivities[1].correlation), 0.1);
  EXPECT_FALSE(all.sensitivities[1].certain);
}

TEST_F(CampaignReportOf, ThinnedStatisticsKeepTheWorstOfAll) {
  const Report all = report();
  const Report some = report(30);
  EXPECT_EQ(some.used, 29U);
  for (std::size_t i = 0; i < all.worst.size(); ++i) {
    EXPECT_EQ(some.worst[i].trial, all.worst[i].trial);
  }
  EXPECT_THAT(
      report_text(campaign_, some),
      HasSubstr("200 trials of the kind rising; statistics of 29 of them, the worst of all"));
}

TEST_F(CampaignReportOf, IsPrintedInEightyColumnsAndAsHtml) {
  const Report all = report();
  const std::string text = report_text(campaign_, all);
  EXPECT_THAT(text, AllOf(HasSubstr("class: a,\"b\""), HasSubstr("3.96e+04"),
                          HasSubstr("\n  run " + std::to_string(all.worst[0].trial) + "\n")));
  std::istringstream lines(text.substr(text.find('\n')));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 80U) << line;
  }
  write_report(folder_ / "r.html", campaign_, all);
  EXPECT_THAT(
      file_text(folder_ / "r.html"),
      AllOf(HasSubstr("src=\"data:image/svg+xml;base64,"), HasSubstr("class: a,&quot;b&quot;"),
            HasSubstr("<code>run " + std::to_string(all.worst[9].trial) + "</code>")));
}

TEST_F(CampaignReportOf, IsMadeOfWholeChunksOnly) {
  std::filesystem::remove(folder_ / "out/chunks/000002.csv");
  EXPECT_THAT(error_of([&] { report(); }), HasSubstr("000002.csv: is missing"));
}

}  // namespace
}  // namespace smaservo::campaign::test
