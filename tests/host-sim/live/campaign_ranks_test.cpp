// Campaigns of several processes that a real mpirun has started.

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "tests/host-sim/campaign/small_campaign.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/patience.hpp"
#include "tests/places.hpp"

namespace smaservo::test {
namespace {

using campaign::test::contents;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Texts = Program::Texts;

constexpr const char* mpirun = "/usr/bin/mpirun";

/// Trials of a campaign that takes an hour of a processor.
constexpr int many = 50'000;

/// How often a text has another one in it.
int times(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

/// The numbers of a process's children.
std::vector<pid_t> children(pid_t process) {
  const std::string folder = "/proc/" + std::to_string(process) + "/task";
  std::vector<pid_t> all;
  std::error_code ended;
  for (const auto& task : std::filesystem::directory_iterator(folder, ended)) {
    std::istringstream numbers(file_text(task.path() / "children"));
    all.insert(all.end(), std::istream_iterator<pid_t>(numbers), {});
  }
  return all;
}

/// Runs of a closed loop that take some 0.05 s each, in chunks of their own.
class CampaignRanks : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const std::string& program : {std::string(mpirun), host_sim_mpi_program()}) {
      if (access(program.c_str(), X_OK) != 0) {
        GTEST_SKIP() << program << " is not there: needs openmpi-bin and libopenmpi-dev when "
                     << "CMake is run, and no sanitizers";
      }
    }
    // As root, more ranks than processors, none bound to one of them. Where one rank has ended with
    // an error or by a signal, mpirun hands SIGTERM to the others, sleeps for so many seconds, and
    // kills what is left.
    for (const char* const text :
         {"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
          "OMPI_MCA_rmaps_base_oversubscribe=1", "OMPI_MCA_hwloc_base_binding_policy=none",
          "OMPI_MCA_odls_base_sigkill_timeout=0"}) {
      program_.environment.emplace_back(text);
    }
    write_plan("plan.toml", 12, 3);
  }

  void write_plan(const std::string& name, int trials, int seed) {
    program_.folder().write(name, "kind = 'gains'\nchunk = 1\ntrials = " + std::to_string(trials) +
                                      "\nseed = " + std::to_string(seed) +
                                      "\n[gains]\nscenario = '" + source_folder() +
                                      "/host-sim/scenarios/steps.toml'\n");
  }

  std::string in(const std::string& name) const { return program_.folder() / name; }

  /// "mpirun -np N host-sim campaign ..."
  Finished run(int ranks, const Texts& arguments) { return program_.wait(start(ranks, arguments)); }

  pid_t start(int ranks, const Texts& arguments) {
    program_.launcher = {mpirun, "-np", std::to_string(ranks), host_sim_mpi_program(), "campaign"};
    return program_.start(arguments, open("/dev/null", O_RDONLY | O_CLOEXEC), in("summary"));
  }

  /// One process without MPI computes the plan.
  void compute_alone(const std::string& out) {
    program_.launcher.clear();
    const Finished f = program_.run({"campaign", "plan.toml", "--out", out});
    ASSERT_EQ(f.status, 0) << f.err;
  }

  std::vector<std::string> chunks(const std::string& out) const {
    std::vector<std::string> all;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(in(out + "/chunks"), none)) {
      all.push_back(entry.path().filename().string());
    }
    return all;
  }

  /// A run of a campaign that would take long, when its first chunk is there.
  pid_t long_run(int ranks) {
    write_plan("long.toml", many, 3);
    const pid_t process = start(ranks, {"long.toml", "--out", "long"});
    EXPECT_TRUE(becomes([&] {
      const auto all = chunks("long");
      return std::ranges::any_of(all, [](const auto& name) { return name.ends_with(".csv"); });
    }));
    return process;
  }

  /// Of the long run.
  void expect_only_whole_chunks() {
    EXPECT_FALSE(std::filesystem::exists(in("long/trials.csv")));
    const std::vector<std::string> all = chunks("long");
    EXPECT_LT(all.size(), std::size_t{many} / 2) << "the ranks have gone on";
    for (const std::string& name : all) {
      EXPECT_TRUE(name.ends_with(".csv")) << name;
      EXPECT_THAT(file_text(in("long/chunks/" + name)), HasSubstr("\n# end: 1 rows, checksum "));
    }
  }

  Program program_;
};

TEST_F(CampaignRanks, GiveTheBytesOfOneProcess) {
  compute_alone("alone");
  const auto expected = contents(in("alone"));
  ASSERT_EQ(expected.size(), 15U) << "12 chunks, trials, plan, identity";
  for (const int ranks : {1, 2, 4}) {
    const std::string out = "ranks-" + std::to_string(ranks);
    const Finished f = run(ranks, {"plan.toml", "--out", out, "--report", out + ".html"});
    EXPECT_EQ(f.status, 0) << f.err;
    EXPECT_THAT(f.err, Not(HasSubstr("rank")));
    EXPECT_EQ(times(f.out, "12 trials of the kind gains"), 1) << f.out;
    EXPECT_THAT(f.out, HasSubstr("12 chunks: 12 computed, 0 were there; 12 trials in " + out));
    EXPECT_EQ(contents(in(out)), expected);
    EXPECT_TRUE(std::filesystem::exists(in(out + ".html")));
  }
  const Finished again = run(4, {"plan.toml", "--out", "ranks-2", "--threads", "2"});
  EXPECT_THAT(again.out, HasSubstr("12 chunks: 0 computed, 12 were there"));
  EXPECT_EQ(contents(in("ranks-2")), expected);
}

TEST_F(CampaignRanks, AKilledRankEndsAllAndTheRestIsComputedLater) {
  const pid_t process = start(2, {"plan.toml", "--out", "killed"});
  EXPECT_TRUE(becomes([&] { return std::filesystem::exists(in("killed/chunks/000000.csv")); }));
  const std::vector<pid_t> ranks = children(process);
  ASSERT_EQ(ranks.size(), 2U);
  kill(ranks.back(), SIGKILL);
  EXPECT_NE(program_.wait(process).status, 0);
  EXPECT_FALSE(std::filesystem::exists(in("killed/trials.csv")));
  // What a killed process was writing, here and on another computer, goes when it is an hour old.
  program_.folder().write("killed/chunks/000007.csv.elsewhere.7.part", "# half a chunk");
  for (const std::string& name : chunks("killed")) {
    if (name.ends_with(".part")) {
      const auto now = std::filesystem::file_time_type::clock::now();
      std::filesystem::last_write_time(in("killed/chunks/" + name), now - std::chrono::hours(2));
    }
  }
  const Finished rest = run(4, {"plan.toml", "--out", "killed"});
  EXPECT_EQ(rest.status, 0) << rest.err;
  EXPECT_THAT(rest.out, Not(HasSubstr("12 computed")));
  compute_alone("alone");
  EXPECT_EQ(contents(in("killed")), contents(in("alone")));
}

TEST_F(CampaignRanks, EndBySignalsBetweenTwoTrials) {
  program_.environment.back() = "OMPI_MCA_odls_base_sigkill_timeout=2";
  for (const int signal : {SIGTERM, SIGINT}) {
    std::filesystem::remove_all(in("long"));
    const pid_t process = long_run(2);
    kill(process, signal);
    const Finished f = program_.wait(process);
    EXPECT_NE(f.status, 0);
    EXPECT_EQ(times(f.err, "host-sim: interrupted; whole chunks are kept. The same"), 1) << f.err;
    expect_only_whole_chunks();
  }
}

TEST_F(CampaignRanks, KeepOthersFromTheirFolder) {
  const pid_t process = long_run(2);
  Program other;
  other.environment = program_.environment;
  for (const char* const ranks : {"1", "2", "3"}) {
    other.launcher = {mpirun, "-np", ranks, host_sim_mpi_program(), "campaign"};
    const Finished f = other.run({in("long.toml"), "--out", in("long")});
    EXPECT_EQ(f.status, 1) << ranks;
    EXPECT_EQ(times(f.err, "is in use: another process computes shard 0/1"), 1) << f.err;
  }
  kill(process, SIGTERM);
  EXPECT_NE(program_.wait(process).status, 0);
}

TEST_F(CampaignRanks, AnErrorOfOneEndsAllAndIsToldOnce) {
  // A chunk of another plan where the last but one of three ranks looks: the others would take
  // days.
  write_plan("long.toml", many, 3);
  write_plan("other.toml", 2, 4);
  run(1, {"other.toml", "--out", "other"});
  std::filesystem::create_directories(in("long/chunks"));
  std::filesystem::copy_file(in("other/chunks/000001.csv"), in("long/chunks/000001.csv"));
  const Finished f = run(3, {"long.toml", "--out", "long"});
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(times(f.err, "host-sim: rank "), 1) << f.err;
  EXPECT_THAT(f.err,
              AllOf(HasSubstr("host-sim: rank 1 of 3: long/chunks/000001.csv: is not of this"),
                    HasSubstr("remove it")));
  std::filesystem::remove(in("long/chunks/000001.csv"));
  expect_only_whole_chunks();

  // What is wrong in all is told once, too, by the first.
  const Finished none = run(3, {"none.toml", "--out", "none"});
  EXPECT_EQ(none.status, 1);
  EXPECT_EQ(times(none.err, "none.toml: cannot be read"), 1) << none.err;
  const Finished merge = run(3, {"plan.toml", "--out", "long", "--merge"});
  EXPECT_EQ(merge.status, 1);
  EXPECT_EQ(times(merge.err, "--merge computes nothing: start it as one process"), 1) << merge.err;
}

TEST_F(CampaignRanks, AFullDiskOfOneEndsAllAndLeavesNoHalfFile) {
  write_plan("long.toml", many, 3);
  // Rank 1 cannot write files; so its MPI talks through sockets.
  program_.launcher = {mpirun,
                       "--mca",
                       "btl",
                       "tcp,self",
                       "-np",
                       "1",
                       host_sim_mpi_program(),
                       "campaign",
                       "long.toml",
                       "--out",
                       "long",
                       ":",
                       "-np",
                       "1",
                       "/bin/sh",
                       "-c",
                       "trap '' XFSZ; ulimit -f 0; exec \"$0\" campaign long.toml --out long",
                       host_sim_mpi_program()};
  const Finished f = program_.run({});
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(times(f.err, "host-sim: rank "), 1) << f.err;
  EXPECT_THAT(f.err, AllOf(HasSubstr("host-sim: rank 1 of 2: long/"), HasSubstr("File too large")));
  expect_only_whole_chunks();
}

TEST_F(CampaignRanks, RefuseAPlanThatDiffersBetweenThem) {
  write_plan("other.toml", 12, 4);
  program_.launcher = {
      mpirun, "-np", "1", host_sim_mpi_program(), "campaign", "plan.toml",  "--out", "out",
      ":",    "-np", "1", host_sim_mpi_program(), "campaign", "other.toml", "--out", "out"};
  const Finished f = program_.run({});
  EXPECT_EQ(f.status, 1);
  EXPECT_EQ(times(f.err, "host-sim: rank "), 1) << f.err;
  EXPECT_THAT(f.err, AllOf(HasSubstr("rank 1 of 2: out: holds the results of another plan than "),
                           HasSubstr("seed is 3 in the folder, 4 here")));
  EXPECT_TRUE(chunks("out").empty());
}

TEST_F(CampaignRanks, OnlySeveralRanksUseMpi) {
  write_plan("plan.toml", 2, 3);
  // With this the library of MPI would end the program.
  program_.environment.emplace_back("OMPI_MCA_pml=none");
  program_.launcher = {host_sim_mpi_program()};
  const Finished alone = program_.run({"campaign", "plan.toml", "--out", "alone"});
  EXPECT_EQ(alone.status, 0) << alone.err;
  const Finished one = run(1, {"plan.toml", "--out", "one"});
  EXPECT_EQ(one.status, 0) << one.err;
  program_.launcher = {mpirun, "-np", "2", host_sim_mpi_program()};
  EXPECT_EQ(program_.run({"wires"}).status, 0);
  EXPECT_EQ(program_.run({"campaign", "plan.toml", "--trial", "0"}).status, 0);
  EXPECT_NE(program_.run({"campaign", "plan.toml", "--out", "two"}).status, 0);
}

TEST_F(CampaignRanks, AreNotThoseOfAnotherMpi) {
  program_.environment.emplace_back("PMI_SIZE=2");
  program_.launcher = {host_sim_mpi_program()};
  const Finished f = program_.run({"campaign", "plan.toml", "--out", "out"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, AllOf(HasSubstr("one of 2 processes that were started together (PMI_SIZE)"),
                           HasSubstr("finds 1: start it by the mpirun of this MPI")));
}

#ifndef SMASERVO_WITH_MPI
TEST_F(CampaignRanks, WithoutMpiEachRankWouldComputeAll) {
  program_.launcher = {mpirun, "-np", "2", host_sim_program()};
  const Finished f = program_.run({"campaign", "plan.toml", "--out", "out"});
  EXPECT_EQ(f.status, 1);
  EXPECT_THAT(f.err, HasSubstr("Build it with -DSMASERVO_MPI=ON, or give each process its part"));
  EXPECT_FALSE(std::filesystem::exists(in("out")));
}
#endif

}  // namespace
}  // namespace smaservo::test
