#include "firmware/daemon/status/warning_journal.hpp"

#include <gmock/gmock.h>
#include <random>

#include "firmware/safety/standing.hpp"

namespace smaservo::daemon {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// What is due when the device has counted this.
std::vector<std::string> due(WarningJournal& journal, double time_s, Fault fault,
                             std::uint32_t causes) {
  WarningCounts all{};
  all.at(warning_index(fault)) = causes;
  return journal.lines(static_cast<std::uint64_t>(time_s * 1e6), all);
}

TEST(WarningJournal, TellsAWarningAtOnceAndThenOnceAMinute) {
  WarningJournal journal;
  EXPECT_THAT(due(journal, 1, Fault::heat_limit, 0), IsEmpty());
  EXPECT_THAT(due(journal, 2.5, Fault::heat_limit, 1),
              ElementsAre(HasSubstr("2.500 s: warning heat_limit: The heat put into the wire")));
  EXPECT_THAT(due(journal, 40, Fault::heat_limit, 5000), IsEmpty());
  EXPECT_THAT(due(journal, 62.5, Fault::heat_limit, 8401),
              ElementsAre("62.500 s: warning heat_limit: its cause has come 8400 times more in the "
                          "last 60 s"));
  EXPECT_THAT(due(journal, 300, Fault::heat_limit, 8401), IsEmpty());
  EXPECT_THAT(due(journal, 301, Fault::heat_limit, 8402),
              ElementsAre(HasSubstr("its cause has come once more in the last 238 s")));
}

TEST(WarningJournal, TellsADeviceThatHasStartedAnewAnew) {
  WarningJournal journal;
  due(journal, 100, Fault::drift, 1);
  EXPECT_THAT(due(journal, 0.5, Fault::drift, 0), IsEmpty());
  EXPECT_THAT(due(journal, 3, Fault::drift, 1), ElementsAre(HasSubstr("3.000 s: warning drift: ")));
}

/// Whatever comes, when, and however many outputs are missed: no more than one line a minute for
/// each warning, and the numbers of all lines add up to what the device has counted by then.
TEST(WarningJournal, IsBriefAndLeavesNothingOut) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    std::mt19937_64 random(seed);
    std::exponential_distribution<double> gap_s(1.0 / (0.01 + seed));
    std::poisson_distribution<std::uint32_t> more(seed % 3);
    WarningJournal journal;
    std::uint32_t causes = 0, told = 0;
    double last_s = -60;
    for (double time_s = 0; time_s < 4000; time_s += gap_s(random)) {
      causes += more(random);
      const auto lines = due(journal, time_s, Fault::duty, causes);
      ASSERT_LE(lines.size(), 1U);
      if (!lines.empty()) {
        ASSERT_GE(time_s - last_s, 60 - 1e-5);
        last_s = time_s;
        told = causes;
      }
      ASSERT_TRUE(told == causes || time_s - last_s < 60 + 1e-5);
    }
  }
}

}  // namespace
}  // namespace smaservo::daemon
