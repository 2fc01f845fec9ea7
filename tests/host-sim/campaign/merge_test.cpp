#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/hash.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A folder with all chunks, which a test then spoils.
class CampaignMerge : public ::testing::Test {
 protected:
  CampaignMerge() { run_into(campaign_, out_); }

  std::string chunk(int number) const { return fmt::format("{}/chunks/{:06}.csv", out_, number); }
  static void write(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
  }
  /// The refusal, which leaves a former table as it was.
  std::string refusal() const {
    write(out_ + "/trials.csv", "former");
    std::string error = error_of([&] { merge_in(campaign_, out_); });
    EXPECT_EQ(file_text(out_ + "/trials.csv"), "former");
    EXPECT_THAT(error, HasSubstr("cannot be merged"));
    return error;
  }
  /// A chunk as a campaign of another plan or version would have written it here.
  std::string other_chunk(const std::string& plan, const std::string& version, int number) const {
    const Campaign other = small_campaign(folder_, plan, version);
    std::vector<TrialResult> results;
    const auto at = static_cast<std::uint64_t>(number);
    for (std::uint64_t i = other.plan.first(at); i < other.plan.first(at + 1); ++i) {
      results.push_back(other.trials->run(i, {}));
    }
    return chunk_text(other, at, results);
  }

  TemporaryFolder folder_;
  Campaign campaign_ = small_campaign(folder_);
  std::string out_ = folder_ / "out";
};

TEST_F(CampaignMerge, NamesHolesAndTheCommandThatFillsThem) {
  for (const int number : {0, 3, 4, 5, 14}) {
    std::filesystem::remove(chunk(number));
  }
  EXPECT_THAT(refusal(),
              AllOf(HasSubstr("chunks are missing: 0 (trials 0 to 69), 3 to 5 (trials 210 to 419), "
                              "14 (trials 980 to 999)"),
                    HasSubstr("host-sim campaign " + folder_ / "plan.toml" + " --out " + out_)));
}

TEST_F(CampaignMerge, RefusesChunksThatAreCutOffOrEdited) {
  const std::string whole = file_text(chunk(2));
  write(chunk(2), whole.substr(0, whole.size() - 5));
  EXPECT_THAT(refusal(), HasSubstr("000002.csv is cut off"));
  std::string edited = whole;
  edited.replace(edited.find("\n141,148"), 8, "\n141,149");
  write(chunk(2), edited);
  EXPECT_THAT(refusal(), HasSubstr("000002.csv has been changed"));
  // Rows that are gone with an end that was made anew.
  std::string fewer = whole.substr(0, whole.find("\n141,") + 1);
  fewer += "# end: 70 rows, checksum " + hash_of(fewer) + "\n";
  write(chunk(2), fewer);
  EXPECT_THAT(refusal(), HasSubstr("000002.csv has 1 rows, not 70"));
}

TEST_F(CampaignMerge, RefusesChunksOfOthers) {
  const std::string whole = file_text(chunk(2));
  write(chunk(2), other_chunk(small_plan, "1.2.4", 2));
  EXPECT_THAT(refusal(), AllOf(HasSubstr("000002.csv is not of this plan"),
                               HasSubstr("\"# smaservo 1.2.4\" where \"# smaservo 1.2.3\"")));
  EXPECT_THAT(error_of([&] { run_into(campaign_, out_); }), HasSubstr("is not of this plan"));
  std::string seed = small_plan;
  seed.replace(seed.find("seed = 7"), 8, "seed = 8");
  write(chunk(2), other_chunk(seed, "1.2.3", 2));
  EXPECT_THAT(refusal(), HasSubstr("it has \"# plan "));
  // The right plan, and a wrong name: the trials of chunk 1 would be there twice.
  write(chunk(2), file_text(chunk(1)));
  EXPECT_THAT(refusal(), HasSubstr("\"# chunk 1: trials 70 to 139\" where \"# chunk 2"));
  write(chunk(2), whole);
  EXPECT_EQ(error_of([&] { merge_in(campaign_, out_); }), "");
}

TEST_F(CampaignMerge, RefusesWhatMayHoldTrialsTwice) {
  std::filesystem::copy(chunk(2), out_ + "/chunks/000002 (copy).csv");
  write(chunk(15),
        other_chunk("kind = 'small'\ntrials = 1000\nseed = 7\nchunk = 60\n[small]\n", "1.2.3", 15));
  EXPECT_THAT(refusal(), AllOf(HasSubstr("may hold trials twice: 000002 (copy).csv, 000015.csv"),
                               Not(HasSubstr("is computed by"))));
}

TEST_F(CampaignMerge, OverlooksPartsThatAKilledProcessLeft) {
  write(chunk(3) + ".n1.12345.part", "half");
  EXPECT_EQ(error_of([&] { merge_in(campaign_, out_); }), "");
}

TEST_F(CampaignMerge, ARunRemovesOldPartsOfItsShard) {
  const auto old_part = [&](const std::string& path) {
    write(path + ".n1.12345.part", "half");
    std::filesystem::last_write_time(
        path + ".n1.12345.part",
        std::filesystem::file_time_type::clock::now() - std::chrono::hours(3));
    return path + ".n1.12345.part";
  };
  const std::string mine = old_part(chunk(3));
  const std::string another = old_part(chunk(2));
  const std::string stranger = old_part(out_ + "/chunks/3.csv");
  write(chunk(1) + ".n2.12345.part", "is being written");
  run_into(campaign_, out_, {1, 2});
  EXPECT_FALSE(std::filesystem::exists(mine));
  EXPECT_TRUE(std::filesystem::exists(another));
  EXPECT_TRUE(std::filesystem::exists(stranger));
  EXPECT_TRUE(std::filesystem::exists(chunk(1) + ".n2.12345.part"));
}

TEST_F(CampaignMerge, TheFolderMustBeThatOfThePlan) {
  EXPECT_THAT(error_of([&] { merge_in(campaign_, folder_ / "none"); }),
              HasSubstr("there is no such folder"));
  EXPECT_THAT(error_of([&] { merge_in(campaign_, folder_.path()); }),
              HasSubstr("is not the folder of a campaign"));
  EXPECT_THAT(error_of([&] { run_into(campaign_, folder_.path()); }),
              HasSubstr("holds other files, such as "));
  EXPECT_THAT(error_of([&] { run_into(campaign_, folder_ / "plan.toml"); }),
              HasSubstr("--out " + folder_ / "plan.toml"));
}

}  // namespace
}  // namespace smaservo::campaign::test
