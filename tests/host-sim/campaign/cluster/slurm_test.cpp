// The scripts for Slurm, and what host-sim does with an sbatch that is none. The real one is in
// slurm_test.py.

#include "host-sim/campaign/cluster/slurm.hpp"

#include <algorithm>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "host-sim/shell_word.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::campaign::test {
namespace {

using smaservo::test::Finished;
using smaservo::test::Program;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

SlurmCalls calls_of(const std::string& out) {
  return {"/opt/smaservo/bin/host-sim", "/data/a plan.toml", out, "/data/o'r.html", 4, 2};
}

TEST(SlurmScripts, SayWhatIsCalled) {
  const std::string shards = shards_script(calls_of("/data/out"));
  EXPECT_THAT(
      shards,
      AllOf(StartsWith("#!/bin/sh\n"), HasSubstr("\n#SBATCH --array=0-3\n"),
            HasSubstr("\n#SBATCH --cpus-per-task=2\n"), HasSubstr("\n#SBATCH --requeue\n"),
            HasSubstr("\n#SBATCH --job-name=campaign-a_plan\n"),
            HasSubstr("\n#SBATCH --chdir=\"/data/out\"\n#SBATCH --output=slurm-%A_%a.log\n"),
            HasSubstr("\nexec /opt/smaservo/bin/host-sim campaign '/data/a plan.toml' --out "
                      "/data/out \\\n  --shard \"${SLURM_ARRAY_TASK_ID:?is set by sbatch}/4\" "
                      "--threads \"${SLURM_CPUS_PER_TASK:-1}\"\n")));
  const std::string merge = merge_script(calls_of("/data/out"));
  EXPECT_THAT(merge,
              AllOf(HasSubstr("\n#SBATCH --job-name=campaign-a_plan-merge\n"),
                    HasSubstr("exec /opt/smaservo/bin/host-sim campaign '/data/a plan.toml' --out "
                              "/data/out --merge --report '/data/o'\\''r.html'\n"),
                    Not(HasSubstr("--array"))));
  SlurmCalls plain = calls_of("/data/out");
  plain.report = "";
  EXPECT_THAT(merge_script(plain), Not(HasSubstr("--report")));
}

TEST(SlurmScripts, FolderNamesThatSlurmReadsOtherwiseAreRefused) {
  EXPECT_THAT(shards_script(calls_of("/data/it's \"here\" #1 $x")),
              HasSubstr("--chdir=\"/data/it's \\\"here\\\" #1 $x\"\n"));
  for (const std::string name : {"/a%j", "/a\\b", "/a\nb", "/a\tb"}) {
    EXPECT_THAT(error_of([&] { shards_script(calls_of(name)); }),
                HasSubstr("choose another folder"));
    EXPECT_THAT(error_of([&] { merge_script(calls_of(name)); }),
                HasSubstr("choose another folder"));
  }
}

/// A shell reads all words as they were.
TEST(SlurmScripts, WordsAreSafeInAShell) {
  const smaservo::test::TemporaryFolder folder;
  std::mt19937 random(1);
  std::string script = "printf '%s|' ";
  std::string expected;
  for (int i = 0; i < 300; ++i) {
    std::string word;
    for (int size = std::uniform_int_distribution(0, 12)(random); size > 0; --size) {
      word += i % 2 == 0 ? "'\"\\ $`!*?~#;&|<>(){}[]\n\t-=%"[random() % 27]
                         : static_cast<char>(1 + random() % 255);
    }
    script += shell_word(word) + ' ';
    expected += word + '|';
  }
  const std::string call =
      "LC_ALL=C sh " + folder.write("script", script) + " > " + folder / "words";
  ASSERT_EQ(std::system(call.c_str()), 0);  // NOLINT(*-command-processor,cert-env33-c): a test
  EXPECT_EQ(file_text(folder / "words"), expected);
}

TEST(SlurmScripts, AnyChangeShows) {
  const std::string script = shards_script(calls_of("/data/out"));
  EXPECT_TRUE(is_as_written(script));
  EXPECT_TRUE(is_as_written(merge_script(calls_of("/data/out"))));
  for (std::size_t i = 0; i < script.size(); ++i) {
    std::string changed = script;
    changed[i] ^= 1;
    EXPECT_FALSE(is_as_written(changed)) << i;
    EXPECT_FALSE(is_as_written(script.substr(0, i))) << i;
  }
  EXPECT_FALSE(is_as_written(script + "\n"));
}

TEST(SlurmTasks, AreAtMostOneForAChunk) {
  const smaservo::test::TemporaryFolder folder;
  const Campaign campaign = small_campaign(folder);
  EXPECT_EQ(slurm_tasks(campaign.plan, std::nullopt), 15U);
  EXPECT_EQ(slurm_tasks(campaign.plan, 15), 15U);
  EXPECT_EQ(slurm_tasks(campaign.plan, 1), 1U);
  EXPECT_THAT(error_of([&] { slurm_tasks(campaign.plan, 16); }),
              HasSubstr("--tasks 16: the plan has 15 chunks"));
  const Campaign many =
      small_campaign(folder, "kind = 'small'\ntrials = 5000\nchunk = 1\n[small]\n");
  EXPECT_EQ(slurm_tasks(many.plan, std::nullopt), 100U);
}

/// The real program, and an sbatch of ours on its PATH.
class SlurmCommand : public ::testing::Test {
 protected:
  SlurmCommand() {
    program_.folder().write(
        "plan.toml", "kind = 'gains'\ntrials = 8\nchunk = 2\n[gains]\nscenario = '" +
                         smaservo::test::source_folder() + "/host-sim/scenarios/steps.toml'\n");
  }

  Finished run(Program::Texts arguments) {
    arguments.insert(arguments.begin(), {"campaign", "plan.toml", "--out", "out"});
    return program_.run(arguments);
  }
  void sbatch_is(const std::string& script) {
    const std::string path = program_.folder().write("sbatch", "#!/bin/sh\n" + script);
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    program_.environment[0] = "PATH=" + program_.folder().path().string() + ":/usr/bin:/bin";
  }
  std::string text(const std::string& name) const { return file_text(program_.folder() / name); }

  Program program_;
};

TEST_F(SlurmCommand, SubmitsTheShardsAndThenTheMerge) {
  sbatch_is(
      "echo \"$*\" >>calls; n=$(wc -l <calls); echo 'welcome to our cluster'; echo \"4$n;ours\"");
  const Finished f = run({"--slurm", "--tasks", "3", "--threads", "2", "--report", "r.html"});
  EXPECT_EQ(f.status, 0) << f.err;
  EXPECT_THAT(f.out, AllOf(HasSubstr("4 chunks in 3 tasks: job 41. Job 42 joins them"),
                           HasSubstr("squeue --job 41,42\n"), HasSubstr("/out/slurm-41_*.log\n"),
                           HasSubstr("scancel 41 42\n")));
  const std::string out = program_.folder() / "out";
  EXPECT_EQ(text("calls"), "--parsable " + out + "/campaign.sbatch\n" +
                               "--parsable --dependency=afterok:41 --kill-on-invalid-dep=yes " +
                               out + "/merge.sbatch\n");
  EXPECT_THAT(
      text("out/campaign.sbatch"),
      AllOf(HasSubstr("#SBATCH --array=0-2\n#SBATCH --cpus-per-task=2\n"),
            HasSubstr("exec " +
                      std::filesystem::canonical(smaservo::test::host_sim_program()).string() +
                      " campaign " + program_.folder() / "plan.toml" + " --out " + out)));
  EXPECT_THAT(text("out/merge.sbatch"), HasSubstr(" --report " + program_.folder() / "r.html"));
  EXPECT_EQ(run({"--slurm", "--report", "-"}).status, 0) << "the same folder again";
  EXPECT_THAT(text("out/merge.sbatch"), HasSubstr(" --merge --report -\n"));
  EXPECT_THAT(text("out/campaign.sbatch"),
              HasSubstr("#SBATCH --array=0-3\n#SBATCH --cpus-per-task=1\n"));
}

TEST_F(SlurmCommand, KeepsTheScriptsWhenNothingCanBeSubmitted) {
  program_.environment[0] = "PATH=" + program_.folder().path().string();
  const Finished missing = run({"--slurm"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.err, AllOf(HasSubstr("sbatch has submitted nothing: "),
                                 HasSubstr("No such file"), HasSubstr("sbatch --parsable ")));
  EXPECT_TRUE(is_as_written(text("out/campaign.sbatch")));
  sbatch_is("echo 'sbatch: error: Batch job submission failed: Invalid account' >&2; exit 1");
  EXPECT_THAT(run({"--slurm"}).err, HasSubstr("nothing: sbatch: error: Batch job submission "
                                              "failed: Invalid account. The scripts are written"));
  sbatch_is("echo later");
  EXPECT_THAT(run({"--slurm"}).err, HasSubstr("nothing: later. "));
  sbatch_is("case $* in *afterok*) echo no more jobs >&2; exit 1;; esac; echo 7");
  EXPECT_THAT(run({"--slurm"}).err,
              AllOf(HasSubstr("nothing: no more jobs. Job 7 computes the chunks; then this joins "
                              "them: sbatch --dependency=afterok:7 "),
                    HasSubstr("out/merge.sbatch")));
}

TEST_F(SlurmCommand, WhatAUserHasChangedIsKept) {
  const Finished written = run({"--slurm", "--no-submit"});
  EXPECT_EQ(written.status, 0) << written.err;
  const std::string out = program_.folder() / "out";
  EXPECT_EQ(written.out, "The scripts are written. This submits them:\n  job=$(sbatch --parsable " +
                             out +
                             "/campaign.sbatch) && sbatch --dependency=afterok:$job "
                             "--kill-on-invalid-dep=yes " +
                             out + "/merge.sbatch\n");
  EXPECT_EQ(run({"--slurm", "--no-submit"}).status, 0) << "again";
  const std::string edited = text("out/merge.sbatch") + "# ours\n";
  program_.folder().write("out/merge.sbatch", edited);
  sbatch_is("echo 1");
  const Finished refused = run({"--slurm", "--tasks", "1"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("merge.sbatch: has been changed by hand and is kept"),
                                 HasSubstr("sbatch --parsable ")));
  EXPECT_EQ(text("out/merge.sbatch"), edited);
  EXPECT_THAT(text("out/campaign.sbatch"), HasSubstr("--array=0-3\n"));
}

TEST_F(SlurmCommand, RefusesOptionsThatContradict) {
  const std::vector<Program::Texts> wrong{{"--slurm", "--shard", "0/2"},
                                          {"--slurm", "--merge"},
                                          {"--slurm", "--trial", "1"},
                                          {"--slurm", "--tasks", "0"},
                                          {"--slurm", "--tasks", "1001"},
                                          {"--slurm", "--tasks", "-1"},
                                          {"--tasks", "2"},
                                          {"--no-submit"}};
  for (const Program::Texts& options : wrong) {
    const Finished f = run(options);
    EXPECT_EQ(f.status, 2) << ::testing::PrintToString(options);
    const auto last = std::ranges::find_if(options.rbegin(), options.rend(),
                                           [](const auto& word) { return word.starts_with("--"); });
    EXPECT_THAT(f.err, HasSubstr(*last)) << ::testing::PrintToString(options);
  }
  const Finished many = run({"--slurm", "--tasks", "5"});
  EXPECT_EQ(many.status, 1);
  EXPECT_THAT(many.err, HasSubstr("--tasks 5: the plan has 4 chunks"));
  EXPECT_FALSE(std::filesystem::exists(program_.folder() / "out"));
}

}  // namespace
}  // namespace smaservo::campaign::test
