// A campaign of the real program that is ended in the middle.

#include <csignal>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host-sim/program.hpp"
#include "tests/patience.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// 12 random scenarios of some tenths of a second each, in chunks of their own.
class CampaignEnded : public ::testing::Test {
 protected:
  CampaignEnded() {
    std::signal(SIGINT, SIG_DFL);
    program_.folder().write("plan.toml",
                            "kind = 'scenarios'\ntrials = 12\nseed = 1\nchunk = 1\n[scenarios]\n"
                            "units = 1\nwires = '" +
                                source_folder() + "/tests/golden/evaluate'\n");
  }

  /// Ends a run by this signal when its first chunk is there.
  Finished ended_by(int signal) {
    const pid_t child =
        program_.start({"campaign", "plan.toml", "--out", "ended", "--threads", "1"},
                       open("/dev/null", O_RDONLY | O_CLOEXEC), program_.folder() / "summary");
    EXPECT_TRUE(becomes([&] { return std::filesystem::exists(chunk("ended", 0)); }));
    kill(child, signal);
    return program_.wait(child);
  }

  /// The ended run goes on and gives the bytes of one that was never ended.
  void expect_that_it_goes_on() {
    EXPECT_FALSE(std::filesystem::exists(program_.folder() / "ended/trials.csv"));
    const Finished rest = program_.run({"campaign", "plan.toml", "--out", "ended"});
    EXPECT_EQ(rest.status, 0) << rest.err;
    EXPECT_THAT(rest.out, Not(HasSubstr("12 computed")));
    const Finished whole = program_.run({"campaign", "plan.toml", "--out", "whole"});
    EXPECT_EQ(whole.status, 0) << whole.err;
    EXPECT_THAT(whole.out, HasSubstr("12 chunks: 12 computed, 0 were there; 12 trials in"));
    EXPECT_EQ(file_text(program_.folder() / "ended/trials.csv"),
              file_text(program_.folder() / "whole/trials.csv"));
    for (int i = 0; i < 12; ++i) {
      EXPECT_EQ(file_text(chunk("ended", i)), file_text(chunk("whole", i)));
    }
  }

  std::string chunk(const std::string& out, int number) const {
    const std::string digits = std::to_string(number);
    return program_.folder() /
           (out + "/chunks/" + std::string(6 - digits.size(), '0') + digits + ".csv");
  }

  Program program_;
};

TEST_F(CampaignEnded, KilledItGoesOnToTheSameBytes) {
  EXPECT_EQ(ended_by(SIGKILL).status, 128 + SIGKILL);
  expect_that_it_goes_on();
}

TEST_F(CampaignEnded, CtrlCKeepsWholeChunksAndSaysHowToGoOn) {
  const Finished f = ended_by(SIGINT);
  EXPECT_EQ(f.status, 128 + SIGINT);
  EXPECT_THAT(f.err, HasSubstr("interrupted: 12 chunks: "));
  EXPECT_THAT(f.err, HasSubstr("The same command goes on"));
  expect_that_it_goes_on();
}

}  // namespace
}  // namespace smaservo::test
