#include <atomic>
#include <csignal>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <thread>

#include "host-sim/hash.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// What a campaign of one thread in one shard leaves.
std::map<std::string, std::string> expected_files(const Campaign& campaign,
                                                  const TemporaryFolder& folder) {
  run_into(campaign, folder / "expected");
  merge_in(campaign, folder / "expected");
  return contents(folder / "expected");
}

TEST(CampaignHash, IsThePublishedFnv1a) {
  EXPECT_EQ(hash_of(""), "6c62272e07bb014262b821756295c58d");
  EXPECT_EQ(hash_of("a"), "d228cb696f1a8caf78912b704e4a8964");
  EXPECT_EQ(hash_of("foobar"), "343e1662793c64bf6f0d3597ba446f18");
}

TEST(Campaign, RowsDoNotDependOnHowTheyAreDivided) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  const auto expected = expected_files(campaign, folder);
  EXPECT_EQ(expected.size(), 15U + 3U);
  for (const std::uint64_t shards : {1U, 2U, 7U}) {
    for (const int threads : {1, 2}) {
      const std::string out = folder / fmt::format("{}-{}", shards, threads);
      // The last shard first: their order does not matter.
      for (std::uint64_t i = shards; i-- > 0;) {
        EXPECT_TRUE(run_into(campaign, out, {i, shards}, threads).whole());
      }
      merge_in(campaign, out);
      EXPECT_EQ(contents(out), expected) << out;
    }
  }
}

TEST(Campaign, TheTableHasEachTrialOnceAndInOrder) {
  const TemporaryFolder folder;
  // A chunk more than there are trials for, in each remainder.
  for (const int chunk : {1, 9, 10}) {
    const Campaign campaign = small_campaign(
        folder, fmt::format("kind = 'small'\ntrials = 10\nchunk = {}\n[small]\n", chunk));
    const std::string out = folder / std::to_string(chunk);
    run_into(campaign, out);
    merge_in(campaign, out);
    std::string expected = "trial,seed,class,value_m,maybe_s\n";
    for (std::uint64_t i = 0; i < 10; ++i) {
      expected += csv_line(i, campaign.trials->run(i, {}).row);
    }
    EXPECT_EQ(file_text(out + "/trials.csv"), expected);
    EXPECT_THAT(expected, HasSubstr("\n0,0,\"a, \"\"b\"\"\",0,\n1,1,c,0.2804903"));
  }
}

TEST(Campaign, FilesOfTrialsArePutBesideTheTable) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder, small_plan + "with_notes = true\n");
  const auto expected = expected_files(campaign, folder);
  std::size_t files = 0;
  for (const auto& [name, text] : expected) {
    files += name.starts_with("files/") ? 1U : 0U;
  }
  EXPECT_EQ(files, 2U * 20U);
  for (std::uint64_t i = 0; i < 1000; i += 50) {
    EXPECT_EQ(expected.at(fmt::format("files/{}.txt", i)), SmallTrials::left_text(i));
    EXPECT_EQ(expected.at(fmt::format("files/{} empty", i)), "");
  }
  for (const int threads : {1, 2}) {
    const std::string out = folder / fmt::format("out-{}", threads);
    run_into(campaign, out, {1, 2}, threads);
    run_into(campaign, out, {0, 2}, threads);
    merge_in(campaign, out);
    EXPECT_EQ(contents(out), expected);
  }
}

/// A chunk that one trial fills does not keep the other threads waiting.
TEST(Campaign, ThreadsTakeTrialsOfSeveralChunks) {
  const TemporaryFolder folder;
  const Campaign campaign =
      small_campaign(folder, "kind = 'small'\ntrials = 4\nchunk = 1\n[small]\n");
  std::atomic<int> inside = 0;
  std::atomic<int> most = 0;
  // Each waits until all four are in their trials: a thread that had to wait for the end of a chunk
  // would keep this test from ending.
  before_trial() = [&](std::uint64_t) {
    ++inside;
    while (inside < 4) {
      std::this_thread::yield();
    }
    most = std::max(most.load(), inside.load());
  };
  EXPECT_TRUE(run_into(campaign, folder / "out", {}, 4).whole());
  before_trial() = [](std::uint64_t) {};
  EXPECT_EQ(most, 4);
}

/// Trials of a number and beyond fail while one exists.
class FailingTrials {
 public:
  explicit FailingTrials(std::uint64_t from) {
    before_trial() = [from](std::uint64_t index) {
      if (index >= from) {
        throw std::runtime_error("lost");
      }
    };
  }
  ~FailingTrials() {
    before_trial() = [](std::uint64_t) {};
  }
  FailingTrials(const FailingTrials&) = delete;
  FailingTrials& operator=(const FailingTrials&) = delete;
};

TEST(Campaign, GoesOnAfterItWasBrokenOff) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  const auto expected = expected_files(campaign, folder);
  const std::string out = folder / "out";
  {
    const FailingTrials failing(500);
    EXPECT_THROW(run_into(campaign, out, {}, 2), std::runtime_error);
  }
  EXPECT_EQ(contents(out).size(), 7U + 2U) << "the chunks before trial 500, and nothing of its own";
  std::atomic<int> trials = 0;
  before_trial() = [&](std::uint64_t) { ++trials; };
  const RunResult result = run_into(campaign, out, {}, 2);
  before_trial() = [](std::uint64_t) {};
  EXPECT_EQ(result.found, 7U);
  EXPECT_EQ(result.computed, 8U);
  EXPECT_EQ(trials, 1000 - 7 * 70);
  merge_in(campaign, out);
  EXPECT_EQ(contents(out), expected);
}

TEST(Campaign, StopsBetweenTwoTrials) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  RunOptions options;
  std::atomic<int> asked = 0;
  options.stop = [&] { return ++asked > 100; };
  const Folder out = Folder::prepared(campaign, folder / "out");
  const RunResult result = run_campaign(campaign, out, options);
  EXPECT_TRUE(result.stopped);
  EXPECT_FALSE(result.whole());
  EXPECT_EQ(result.computed, 1U);
  EXPECT_EQ(contents(folder / "out").size(), 1U + 2U);
}

TEST(Campaign, ComputesBrokenChunksAgainAndSaysSo) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  const auto expected = expected_files(campaign, folder);
  const std::string out = folder / "expected";
  const std::string whole = expected.at("chunks/000003.csv");
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, whole.size() / 2,
                                 whole.rfind('\n', whole.size() - 2) + 1, whole.size() - 1}) {
    std::filesystem::resize_file(out + "/chunks/000003.csv", size);
    std::string warned;
    RunOptions options;
    options.warn = [&](const std::string& text) { warned += text; };
    const RunResult result = run_campaign(campaign, Folder::existing(campaign, out), options);
    EXPECT_EQ(result.computed, 1U) << size;
    EXPECT_THAT(warned, AllOf(HasSubstr("000003.csv: is cut off"), HasSubstr("computed again")));
    EXPECT_EQ(contents(out), expected);
  }
}

/// So that the time left is that of what is left.
TEST(Campaign, ProgressCountsWhatIsMissing) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  run_into(campaign, folder / "out", {0, 2});
  std::vector<std::pair<std::uint64_t, std::uint64_t>> shown;
  RunOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    shown.emplace_back(done, total);
  };
  const Folder out = Folder::existing(campaign, folder / "out");
  run_campaign(campaign, out, options);
  // Chunks 1, 3, ... 13 with 70 trials each.
  EXPECT_EQ(shown.front(), std::pair(std::uint64_t{0}, std::uint64_t{490}));
  EXPECT_EQ(shown.back(), std::pair(std::uint64_t{490}, std::uint64_t{490}));
  EXPECT_TRUE(std::ranges::is_sorted(shown));
  shown.clear();
  run_campaign(campaign, out, options);
  EXPECT_TRUE(shown.empty());
}

TEST(Campaign, AShardIsComputedByOneProcessOnly) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  const Folder out = Folder::prepared(campaign, folder / "out");
  {
    const hal::Descriptor held = out.lock({1, 2});
    EXPECT_THAT(error_of([&] { run_into(campaign, folder / "out", {1, 2}); }),
                HasSubstr("out: is in use: another process computes shard 1/2"));
    EXPECT_TRUE(run_into(campaign, folder / "out", {0, 2}).whole());
  }
  EXPECT_TRUE(run_into(campaign, folder / "out", {1, 2}).whole());
}

/// Begins one folder for all of these campaigns at the same time; returns the errors.
std::vector<std::string> begun_at_once(const std::vector<const Campaign*>& campaigns,
                                       const std::string& out) {
  std::vector<std::string> errors(campaigns.size());
  std::atomic<std::size_t> ready = 0;
  {
    std::vector<std::jthread> threads;
    threads.reserve(campaigns.size());
    for (std::size_t i = 0; i < campaigns.size(); ++i) {
      threads.emplace_back([&, i] {
        ++ready;
        while (ready < campaigns.size()) {
          std::this_thread::yield();
        }
        errors[i] = error_of([&] { Folder::prepared(*campaigns[i], out); });
      });
    }
  }
  return errors;
}

TEST(Campaign, ShardsMayBeginAtOnceAndOtherPlansMayNot) {
  const TemporaryFolder folder;
  const Campaign one = small_campaign(folder);
  const Campaign other = small_campaign(folder, small_plan, "1.2.4");
  for (int round = 0; round < 20; ++round) {
    const std::string same = folder / fmt::format("same-{}", round);
    EXPECT_THAT(begun_at_once({&one, &one, &one, &one}, same), ::testing::Each(""));
    EXPECT_EQ(file_text(same + "/identity.txt"), identity_text(one.plan));
    const std::string out = folder / fmt::format("out-{}", round);
    const std::vector<std::string> errors = begun_at_once({&one, &other}, out);
    const bool first = errors[0].empty();
    EXPECT_EQ(file_text(out + "/identity.txt"), identity_text((first ? one : other).plan));
    EXPECT_THAT(errors[first ? 1 : 0], HasSubstr("holds the results of another plan"));
  }
}

/// Files of this process cannot grow beyond this as long as it lives.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    before_signal_ = signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, before_signal_);
  }

 private:
  rlimit before_{};
  void (*before_signal_)(int) = nullptr;
};

TEST(Campaign, AFullDiskLeavesNoHalfFile) {
  const TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  const auto expected = expected_files(campaign, folder);
  const std::string out = folder / "out";
  std::string error;
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{50}, rlim_t{1000}}) {
    {
      const SmallDisk full(bytes);
      error = error_of([&] { run_into(campaign, out); });
    }
    EXPECT_THAT(error, AllOf(HasSubstr("out"), HasSubstr("File too large")));
    for (const auto& [name, text] : contents(out)) {
      EXPECT_EQ(text, expected.at(name)) << name;
    }
  }
  run_into(campaign, out);
  {
    const SmallDisk full(expected.at("trials.csv").size() - 1);
    error = error_of([&] { merge_in(campaign, out); });
  }
  EXPECT_THAT(error, HasSubstr("trials.csv: cannot be written: File too large"));
  EXPECT_FALSE(contents(out).contains("trials.csv"));
  merge_in(campaign, out);
  EXPECT_EQ(contents(out), expected);
}

}  // namespace
}  // namespace smaservo::campaign::test
