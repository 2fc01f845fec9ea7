#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/campaign/report.hpp"
#include "host-sim/shell_word.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"
#include "tests/host-sim/program.hpp"
#include "tests/host-sim/recordings.hpp"

namespace smaservo::campaign::test {
namespace {

using smaservo::test::bath_file;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Two pieces with a run each, one whose run does not move, and one without runs.
class CampaignLot : public ::testing::Test {
 protected:
  CampaignLot() {
    piece("b 2", bath_file(120));
    piece("a1", bath_file(100));
    std::filesystem::create_directory(folder() / "lot/c3");
    folder().write("lot/c3/still.csv", still_file());
    folder().write("lot/notes.txt", "no piece");
    std::filesystem::create_directory(folder() / "lot/d4");
  }

  const TemporaryFolder& folder() const { return program_.folder(); }
  void piece(const std::string& name, const std::string& run) const {
    std::filesystem::create_directories(folder() / ("lot/" + name));
    folder().write("lot/" + name + "/bath.csv", run);
  }
  static std::string still_file() {
    std::string text = "temperature_degC,strain_ref,stress_MPa\n";
    for (int i = 0; i < 50; ++i) {
      text += "25,0.01,100\n";
    }
    return text;
  }

  Campaign read(const std::string& table = "", const std::string& plan = "") const {
    return read_plan(
        folder().write("plan.toml", "kind = 'lot'\nchunk = 1\n" + plan +
                                        "[lot]\nfolder = 'lot'\nfrom = 'smartflex-76um'\n" + table),
        all_kinds());
  }
  std::string refusal(const std::string& table, const std::string& plan = "") const {
    return error_of([&] { read(table, plan); });
  }

  smaservo::test::Program program_;
};

/// What `identify` finds and writes of a piece, and the table's row of it, are the same.
TEST_F(CampaignLot, APieceIsWhatIdentifyFinds) {
  const Campaign campaign = read();
  ASSERT_EQ(campaign.plan.trials, 4U) << "as many as there are folders";
  const std::string out = folder() / "out";
  run_into(campaign, out, {1, 2});
  run_into(campaign, out, {0, 2}, 2);
  merge_in(campaign, out);
  for (const std::string name : {"a1", "b 2"}) {
    const smaservo::test::Finished alone = program_.run(
        {"identify", "--out", name + ".toml", "--threads", "1", "lot/" + name + "/bath.csv"});
    ASSERT_EQ(alone.status, 0) << alone.err;
    // Sources name the runs by the names of their files.
    EXPECT_EQ(file_text(out + "/files/" + name + ".toml"), file_text(folder() / (name + ".toml")));
  }
  EXPECT_FALSE(std::filesystem::exists(out + "/files/c3.toml"));
  const std::string rows = file_text(out + "/trials.csv");
  EXPECT_THAT(
      rows,
      AllOf(HasSubstr(
                "trial,piece,outcome,problem,strain_rms_percent,separate_r2a,separate_r2m,"
                "taper,memory,loop_order,mixture,m2a.temperature_degC,m2a.temperature_degC_sd,"),
            HasSubstr(",martensite.strain_percent,"), HasSubstr("\n0,a1,converged,,"),
            HasSubstr("\n1,b 2,converged,,"), HasSubstr("\n2,c3,refused,"),
            HasSubstr("still.csv")));
  const std::string text =
      report_text(campaign, make_report(campaign, Folder::existing(campaign, out)));
  EXPECT_THAT(text, AllOf(HasSubstr("outcome: refused"), HasSubstr("c3: refused: "),
                          HasSubstr("d4: refused: its folder has no files of runs\n"),
                          HasSubstr("m2a.temperature_degC"), HasSubstr("'b 2.toml'")));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("_sd"))) << "those are in the table alone";
  EXPECT_THAT(text, ::testing::Not(HasSubstr("piece: a1"))) << "a name is no class";
}

/// The command of a piece is that of its row.
TEST_F(CampaignLot, TheCommandOfAPieceCanBeGivenToAShell) {
  EXPECT_EQ(read("set = ['wire.length_mm=90']\nload_N = 0.5\n").trials->command(1),
            "host-sim identify --from smartflex-76um --out 'b 2.toml' --set wire.length_mm=90 "
            "--load-N 0.5 '" +
                (folder() / "lot/b 2/bath.csv") + "'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_word(""), "''");
}

/// A piece may have a wire of its own, whose length is not that of the others.
TEST_F(CampaignLot, APieceMayBeginWithItsOwnWire) {
  folder().write("lot/a1/wire.toml", "based_on = 'smartflex-76um'\n[wire]\nlength_mm = 250\n");
  const Campaign campaign = read();
  EXPECT_THAT(campaign.trials->command(0), HasSubstr("--from " + (folder() / "lot/a1/wire.toml")));
  // Where the plan lies does not matter.
  EXPECT_THAT(campaign.trials->run(0, {}).files.front().text,
              AllOf(HasSubstr("length_m = 0.25"), HasSubstr("kept from a1/wire.toml")));
}

TEST_F(CampaignLot, FilesThatChangeEndTheCampaign) {
  const Campaign campaign = read();
  const std::string fingerprint = campaign.plan.fingerprint;
  piece("a1", bath_file(101));
  EXPECT_THAT(error_of([&] { campaign.trials->run(0, {}); }),
              HasSubstr("bath.csv: has changed since the campaign was begun"));
  EXPECT_NE(read().plan.fingerprint, fingerprint);
  std::filesystem::remove(folder() / "lot/a1/bath.csv");
  EXPECT_THAT(error_of([&] { campaign.trials->run(0, {}); }), HasSubstr("bath.csv"));
}

TEST_F(CampaignLot, PlansThatCannotBeRunAreRefused) {
  EXPECT_THAT(refusal("", "trials = 5\n"), HasSubstr("must not be above 4"));
  EXPECT_EQ(read("", "trials = 2\n").plan.trials, 2U);
  EXPECT_THAT(refusal("load_N = 1\nstress_MPa = 1\n"), HasSubstr("load_N"));
  EXPECT_THAT(refusal("set = ['wire.length=1']\n"), HasSubstr("wire.length"));
  EXPECT_THAT(refusal("circuits = true\n"), HasSubstr("circuits"));
  std::filesystem::create_directory(folder() / "lot/e\n5");
  EXPECT_THAT(refusal(""), HasSubstr("control character"));
  std::filesystem::remove_all(folder() / "lot");
  EXPECT_THAT(refusal(""), HasSubstr("lot: No such file"));
  std::filesystem::create_directory(folder() / "lot");
  EXPECT_THAT(refusal(""), HasSubstr("no folders, one for each piece"));
}

TEST_F(CampaignLot, StopsWithinAFit) {
  int asked = 0;
  EXPECT_THROW(read().trials->run(0, [&] { return ++asked > 1; }), Stopped);
}

}  // namespace
}  // namespace smaservo::campaign::test
