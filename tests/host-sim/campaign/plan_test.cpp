#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/campaign/kinds/kinds.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"
#include "tests/places.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string refused(const std::string& plan) {
  const TemporaryFolder folder;
  return error_of([&] { small_campaign(folder, plan); });
}

TEST(CampaignPlan, RefusesWhatItDoesNotMean) {
  EXPECT_THAT(refused("kind = 'small'\ntrials = 10\nsed = 3\n[small]\n"),
              AllOf(HasSubstr("plan.toml:3: sed = 3: unknown key (did you mean seed?); allowed:"),
                    HasSubstr("chunk"), HasSubstr("trials")));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 10\n[small]\nfiles = 'a'\n"),
              HasSubstr("plan.toml:4: small.files = 'a': unknown key (did you mean file?)"));
  EXPECT_THAT(refused("kind = 'large'\ntrials = 10\n[small]\n"),
              HasSubstr("must be one of: small"));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 0\n[small]\n"), HasSubstr("trials = 0"));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 1.5\n[small]\n"),
              HasSubstr("trials = 1.5: must be a whole number"));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 10\nchunk = 11\n[small]\n"),
              HasSubstr("chunk = 11: must not be above trials, 10"));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 10\nseed = -1\n[small]\n"), HasSubstr("seed = -1"));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 10\n"), HasSubstr("small: is missing"));
  EXPECT_THAT(refused("kind = 'small'\ntrials = 10\n[small]\nfile = 'none.toml'\n"),
              AllOf(HasSubstr("plan.toml:4: small.file = 'none.toml'"),
                    HasSubstr("No such file or directory")));
}

TEST(CampaignPlan, ChunksTakeMinutesIfThePlanDoesNotSay) {
  const TemporaryFolder folder;
  // A trial of the small kind says that it takes a second.
  EXPECT_EQ(small_campaign(folder, "kind = 'small'\ntrials = 1000\n[small]\n").plan.chunk, 180U);
  EXPECT_EQ(small_campaign(folder, "kind = 'small'\ntrials = 10\n[small]\n").plan.chunk, 10U);
}

TEST(CampaignPlan, TheFingerprintIsThatOfTheMeaning) {
  const TemporaryFolder folder;
  const std::string same =
      "# A remark.\nchunk = 70\nseed =   7\ntrials=1000\nkind = \"small\"\n"
      "[small]\n";
  const std::string print = small_campaign(folder).plan.fingerprint;
  EXPECT_EQ(small_campaign(folder, same).plan.fingerprint, print);
  EXPECT_NE(small_campaign(folder, small_plan, "1.2.4").plan.fingerprint, print);
  for (const auto& [was, is] : std::map<std::string, std::string>{
           {"seed = 7", "seed = 8"}, {"chunk = 70", "chunk = 71"}, {"1000", "1001"}}) {
    std::string other = small_plan;
    other.replace(other.find(was), was.size(), is);
    EXPECT_NE(small_campaign(folder, other).plan.fingerprint, print) << is;
  }
}

TEST(CampaignPlan, AFolderOfAnotherPlanIsRefusedWithWhatDiffers) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  folder.write("wire.toml", "one");
  const std::string plan = small_plan + "file = 'wire.toml'\n";
  run_into(small_campaign(folder, plan), out);
  const auto before = contents(out);
  const auto refusal = [&](const std::string& other, const std::string& version) {
    return error_of([&] { run_into(small_campaign(folder, other, version), out); });
  };
  EXPECT_EQ(refusal(plan, "1.2.3"), "");
  EXPECT_THAT(refusal(plan, "1.2.4"), HasSubstr("version is 1.2.3 in the folder, 1.2.4 here"));
  EXPECT_THAT(refusal(small_plan, "1.2.3"), HasSubstr("small.file is given in the folder"));
  std::string more = plan;
  more.replace(more.find("1000"), 4, "2000");
  EXPECT_THAT(refusal(more, "1.2.3"),
              AllOf(HasSubstr("trials is 1000 in the folder, 2000 here"), Not(HasSubstr("seed"))));
  folder.write("wire.toml", "two");
  EXPECT_THAT(refusal(plan, "1.2.3"), HasSubstr("file \"wire.toml\" has another content"));
  EXPECT_EQ(contents(out), before);
}

TEST(CampaignPlan, ShardsAreCountedFromZero) {
  EXPECT_EQ(shard_of("0/1").count, 1U);
  EXPECT_EQ(shard_of("6/7").index, 6U);
  for (const char* const wrong :
       {"3/2", "2/2", "1", "/2", "1/", "0/0", "-1/2", "1/2x", "a/b", ""}) {
    EXPECT_THAT(error_of([&] { shard_of(wrong); }), HasSubstr("must be K/N, such as 0/4")) << wrong;
  }
}

std::string scenarios_plan(const std::string& wires) {
  return "kind = 'scenarios'\ntrials = 6\nseed = 1\nchunk = 2\n[scenarios]\nunits = 1\nwires = '" +
         wires + "'\n";
}

TEST(CampaignScenarios, AWireThatDoesNotExistIsNamedWithTheCommandThatMakesIt) {
  const TemporaryFolder folder;
  const std::string plan = folder.write("plan.toml", scenarios_plan("none"));
  EXPECT_THAT(error_of([&] { read_plan(plan, all_kinds()); }),
              AllOf(HasSubstr("plan.toml:7: scenarios.wires"),
                    HasSubstr("none/ihyp-1000.toml: there is no such wire"),
                    HasSubstr("host-sim evaluate --closed-loop")));
}

TEST(CampaignScenarios, AreThoseOfEvaluateInAnyDivision) {
  const TemporaryFolder folder;
  const Campaign campaign = read_plan(
      folder.write("plan.toml",
                   scenarios_plan(smaservo::test::source_folder() + "/tests/golden/evaluate")),
      all_kinds());
  run_into(campaign, folder / "one");
  merge_in(campaign, folder / "one");
  run_into(campaign, folder / "two", {1, 2}, 2);
  run_into(campaign, folder / "two", {0, 2}, 2);
  merge_in(campaign, folder / "two");
  EXPECT_EQ(contents(folder / "one"), contents(folder / "two"));
  EXPECT_THAT(file_text(folder / "one/trials.csv"),
              AllOf(HasSubstr("trial,seed,mode,air,trouble,second_trouble,beyond,duration_s,"
                              "above_limit_K,at_s,first_cause,tripped_s,over_s,unanswered,"
                              "cooling_halved\n0,1,"),
                    HasSubstr("\n5,6,")));
  EXPECT_THAT(campaign.trials->command(5), HasSubstr("--random-seed 6"));
}

}  // namespace
}  // namespace smaservo::campaign::test
