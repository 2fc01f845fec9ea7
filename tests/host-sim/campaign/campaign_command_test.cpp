// The command of the real program.

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "firmware/text/device_names.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/evaluate/closed_loop/hottest.hpp"
#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string golden_wires() {
  return source_folder() + "/tests/golden/evaluate";
}

std::vector<std::string> last_words(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    words.push_back(line.substr(line.rfind(' ') + 1));
  }
  return words;
}

/// Those of a table's row that are not empty; none is in quotes here.
std::vector<std::string> cells_of_trial(const std::string& trial, const std::string& table) {
  std::istringstream lines(file_text(table));
  std::string line;
  while (std::getline(lines, line) && !line.starts_with(trial + ',')) {
  }
  std::istringstream row(line);
  std::vector<std::string> cells;
  std::string cell;
  std::getline(row, cell, ',');
  while (std::getline(row, cell, ',')) {
    if (!cell.empty()) {
      cells.push_back(cell);
    }
  }
  return cells;
}

class CampaignCommand : public ::testing::Test {
 protected:
  CampaignCommand() {
    program_.folder().write(
        "gains.toml", "kind = 'gains'\ntrials = 8\nseed = 3\nchunk = 2\n[gains]\nscenario = '" +
                          source_folder() + "/host-sim/scenarios/steps.toml'\n");
    program_.folder().write("scenarios.toml",
                            "kind = 'scenarios'\ntrials = 8\nseed = 1\n[scenarios]\nunits = 1\n"
                            "wires = '" +
                                golden_wires() + "'\n");
  }

  Finished run(Program::Texts arguments) {
    arguments.insert(arguments.begin(), "campaign");
    return program_.run(arguments);
  }

  Program program_;
};

TEST_F(CampaignCommand, ShardsAreJoinedWhenAllAreThere) {
  const Finished first = run({"gains.toml", "--out", "out", "--shard", "0/2"});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(first.out,
            "shard 0/2: 2 chunks: 2 computed, 0 were there. All shards are joined by: host-sim "
            "campaign gains.toml --out out --merge\n");
  const Finished early = run({"gains.toml", "--out", "out", "--merge"});
  EXPECT_EQ(early.status, 1);
  EXPECT_THAT(early.err,
              AllOf(HasSubstr("chunks are missing: 1 (trials 2 to 3), 3 (trials 6 to 7)"),
                    HasSubstr("host-sim campaign gains.toml --out out")));
  EXPECT_FALSE(std::filesystem::exists(program_.folder() / "out/trials.csv"));
  EXPECT_EQ(run({"gains.toml", "--out", "out", "--shard", "1/2"}).status, 0);
  const Finished merged = run({"gains.toml", "--out", "out", "--merge", "--report", "r.html"});
  EXPECT_EQ(merged.status, 0) << merged.err;
  EXPECT_THAT(merged.out, AllOf(HasSubstr("gains.toml: 8 trials of the kind gains\n"),
                                HasSubstr("8 trials in out/trials.csv\n")));
  EXPECT_THAT(file_text(program_.folder() / "r.html"), HasSubstr("rms_error_percent"));
  // One trial alone is its row of the table, without the cells that are empty.
  const Finished alone = run({"gains.toml", "--trial", "5"});
  EXPECT_EQ(alone.status, 0) << alone.err;
  EXPECT_EQ(last_words(alone.out), cells_of_trial("5", program_.folder() / "out/trials.csv"));
}

TEST_F(CampaignCommand, RefusesBeforeItBegins) {
  const std::vector<std::pair<Program::Texts, std::string>> wrong{
      {{"gains.toml"}, "--out is missing"},
      {{"none.toml", "--out", "out"}, "none.toml: cannot be read"},
      {{"gains.toml", "--out", "out", "--shard", "3/2"}, "--shard 3/2: must be K/N"},
      {{"gains.toml", "--out", "gains.toml"}, "--out gains.toml: "},
      {{"gains.toml", "--out", "out", "--merge"}, "--out out: there is no such folder"},
      {{"gains.toml", "--out", "out", "--report", "gains.toml"}, "gains.toml: is the same file"},
      {{"gains.toml", "--out", "out", "--report", "none/r.html"}, "none/r.html: cannot be written"},
      {{"gains.toml", "--trial", "8"}, "--trial 8: the plan has the trials 0 to 7"},
      {{"gains.toml", "--trial", "-1"}, "--trial -1: the plan has the trials 0 to 7"},
  };
  for (const auto& [arguments, message] : wrong) {
    const Finished f = run(arguments);
    EXPECT_EQ(f.status, 1) << message;
    EXPECT_THAT(f.err, HasSubstr(message));
  }
  EXPECT_EQ(program_.folder().names().size(), 2U) << "nothing but the plans";
  EXPECT_EQ(run({"gains.toml", "--out", "out", "--shard", "0/2", "--merge"}).status, 2);
}

TEST_F(CampaignCommand, OneOfSeveralProcessesDoesNotComputeAll) {
  const std::vector<std::pair<Program::Texts, std::string>> several{
      {{"OMPI_COMM_WORLD_SIZE=4"}, "OMPI_COMM_WORLD_SIZE=4"},
      {{"PMI_SIZE=4"}, "PMI_SIZE=4"},
      {{"SLURM_NTASKS=8", "SLURM_STEP_NUM_TASKS=4", "SLURM_PROCID=0"}, "SLURM_STEP_NUM_TASKS=4"}};
  const Program::Texts before = program_.environment;
  for (const auto& [variables, named] : several) {
    program_.environment = before;
    program_.environment.insert(program_.environment.end(), variables.begin(), variables.end());
    const Finished f = run({"gains.toml", "--out", "out"});
    EXPECT_EQ(f.status, 1);
    EXPECT_THAT(f.err, AllOf(HasSubstr("one of 4 processes that were started together (" + named),
                             HasSubstr("-DSMASERVO_MPI=ON"), HasSubstr("--shard K/4")));
    EXPECT_EQ(run({"gains.toml", "--out", "out", "--merge"}).status, 1);
    EXPECT_EQ(program_.folder().names().size(), 2U) << "nothing but the plans";
  }
  // Each has work of its own.
  EXPECT_EQ(run({"gains.toml", "--out", "out", "--shard", "3/4"}).status, 0);
  EXPECT_EQ(run({"gains.toml", "--trial", "5"}).status, 0);
  // Alone: a batch script of Slurm, whose job has tasks; a rank of one.
  const std::vector<Program::Texts> alone{
      {"SLURM_NTASKS=4", "SLURM_PROCID=0"},
      {"OMPI_COMM_WORLD_SIZE=1", "SLURM_STEP_NUM_TASKS=4", "SLURM_PROCID=0"}};
  for (const Program::Texts& variables : alone) {
    program_.environment = before;
    program_.environment.insert(program_.environment.end(), variables.begin(), variables.end());
    EXPECT_EQ(run({"gains.toml", "--out", "out"}).status, 0);
  }
}

TEST_F(CampaignCommand, ScenariosAreThoseOfEvaluateWhichRunsThemAgain) {
  const auto units = evaluate::calibrated_units(1, 1000, golden_wires());
  const campaign::Campaign plan =
      campaign::read_plan(program_.folder() / "scenarios.toml", campaign::all_kinds());
  for (const std::uint64_t trial : {0U, 2U}) {
    const evaluate::HottestRun run =
        evaluate::run_hottest(evaluate::random_scenario(units, 1 + trial));
    const campaign::Row row = plan.trials->run(trial, {}).row;
    EXPECT_EQ(std::get<double>(row.at(7)), run.above_limit_K);
    EXPECT_EQ(std::get<double>(row.at(8)), run.at_s);
    EXPECT_EQ(std::get<std::string>(row.at(9)), std::string(fault_name(run.first_cause)));
  }
  std::istringstream command(plan.trials->command(2));
  Program::Texts words{std::istream_iterator<std::string>(command), {}};
  ASSERT_EQ(words.front(), "host-sim");
  words.erase(words.begin());
  const Finished again = program_.run(words);
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("random 3: "));
}

}  // namespace
}  // namespace smaservo::test
