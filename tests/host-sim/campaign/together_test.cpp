// What ranks do together, with ranks that are threads of this process.

#include "host-sim/campaign/cluster/together.hpp"

#include <algorithm>
#include <deque>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mutex>
#include <thread>

#include "tests/host-sim/campaign/small_campaign.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::Each;

/// What the threads share: the numbers of each call that all make.
class Meeting {
 public:
  explicit Meeting(std::uint64_t count) : count_(count) {}

  void add(std::size_t call, const Ranks::Numbers& own, Ranks::How how) {
    const std::scoped_lock lock(mutex_);
    calls_.resize(std::max(calls_.size(), call + 1));
    ++calls_[call].ranks;
    for (std::size_t i = 0; i < own.size(); ++i) {
      std::uint64_t& all = calls_[call].all.at(i);
      all = how == Ranks::How::sum ? all + own.at(i) : std::max(all, own.at(i));
    }
  }
  std::optional<Ranks::Numbers> result(std::size_t call) {
    const std::scoped_lock lock(mutex_);
    return calls_[call].ranks == count_ ? std::optional(calls_[call].all) : std::nullopt;
  }
  std::uint64_t count() const { return count_; }

 private:
  struct Call {
    std::uint64_t ranks = 0;
    Ranks::Numbers all{};
  };

  std::uint64_t count_;
  std::mutex mutex_;
  std::deque<Call> calls_;
};

class RankOfThread final : public Ranks {
 public:
  RankOfThread(Meeting& meeting, std::uint64_t rank) : meeting_(meeting), rank_(rank) {}
  std::uint64_t rank() const override { return rank_; }
  std::uint64_t count() const override { return meeting_.count(); }
  std::optional<Numbers> combine(const Numbers& own, How how) override {
    if (!begun_) {
      meeting_.add(call_, own, how);
      begun_ = true;
    }
    const auto result = meeting_.result(call_);
    if (result) {
      begun_ = false;
      ++call_;
    }
    return result;
  }

 private:
  Meeting& meeting_;
  std::uint64_t rank_;
  std::size_t call_ = 0;
  bool begun_ = false;
};

/// Does the same in each of several ranks at once.
template <class Work>
void in_ranks(std::uint64_t count, const Work& work) {
  Meeting meeting(count);
  std::vector<std::jthread> threads;
  threads.reserve(static_cast<std::size_t>(count));
  for (std::uint64_t rank = 0; rank < count; ++rank) {
    threads.emplace_back([&meeting, &work, rank] {
      RankOfThread own(meeting, rank);
      work(own);
    });
  }
}

class Together : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  Campaign campaign_ = small_campaign(folder_);
  std::string out_ = folder_ / "out";
  Folder results_ = Folder::prepared(campaign_, out_);
};

TEST_F(Together, RanksComputeTheBytesOfOneProcessAndKnowTheCountsOfAll) {
  run_into(campaign_, folder_ / "alone");
  run_into(campaign_, out_, {4, 5});
  std::vector<RunResult> all(3);
  std::vector<std::uint64_t> shown(3);
  in_ranks(3, [&](Ranks& ranks) {
    const auto rank = static_cast<std::size_t>(ranks.rank());
    RunOptions options;
    options.threads = 2;
    options.progress = [&shown, rank](std::uint64_t done, std::uint64_t) { shown[rank] = done; };
    all_do(ranks, [&] { all[rank] = run_together(ranks, campaign_, results_, options); });
  });
  for (const RunResult& result : all) {
    EXPECT_EQ(result.chunks, 15U);
    EXPECT_EQ(result.found, 3U);
    EXPECT_EQ(result.computed, 12U);
    EXPECT_FALSE(result.stopped);
  }
  EXPECT_EQ(shown[0], 1000U - 3 * 70 + 50) << "the last chunk, which was there, has 20 trials";
  EXPECT_EQ(shown[1] + shown[2], 0U);
  EXPECT_EQ(contents(out_), contents(folder_ / "alone"));
}

TEST_F(Together, AnErrorEndsAllRanksAndIsPrintedByTheFirst) {
  before_trial() = [](std::uint64_t trial) {
    if (trial / 70 % 4 == 1 || trial / 70 % 4 == 3) {
      throw files::UserError(fmt::format("no trial {}", trial));
    }
  };
  std::vector<int> ended(4);
  ::testing::internal::CaptureStderr();
  in_ranks(4, [&](Ranks& ranks) {
    try {
      all_do(ranks, [&] { run_together(ranks, campaign_, results_, {}); });
    } catch (const EndedTogether&) {
      ended[static_cast<std::size_t>(ranks.rank())] = 1;
    }
  });
  before_trial() = [](std::uint64_t) {};
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "host-sim: rank 1 of 4: no trial 70\n");
  EXPECT_THAT(ended, Each(1));
}

TEST_F(Together, ASignalEndsRanksThatAllHaveEnded) {
  std::vector<int> ended(3);
  RunOptions options;
  options.stop = [] { return true; };
  in_ranks(3, [&](Ranks& ranks) {
    try {
      all_do(ranks, [&] { run_together(ranks, campaign_, results_, options); });
    } catch (const EndedBySignal&) {
      ended[static_cast<std::size_t>(ranks.rank())] = 1;
    }
  });
  EXPECT_THAT(ended, Each(1));
}

}  // namespace
}  // namespace smaservo::campaign::test
