#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/simulate/closed_loop_run.hpp"
#include "tests/host-sim/campaign/small_campaign.hpp"
#include "tests/places.hpp"

namespace smaservo::campaign::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string devices() {
  return smaservo::test::source_folder() + "/host-sim/scenarios/devices/";
}

/// Steps of 8 s of the preset wire; no table [plant].
std::string loop_text(const std::string& device) {
  return "note = 'Steps.'\nseed = 3\n[device]\nsettings = '" + device +
         "'\n[[command]]\nmode = 'off'\nfor_s = 0.5\n[[command]]\nshape = 'random'\n"
         "strain_percent = [0.8, 3.6]\neach_s = [1, 2]\nfor_s = 8\n";
}

class CampaignGains : public ::testing::Test {
 protected:
  CampaignGains() { folder_.write("loop.toml", loop_text(devices() + "smartflex-76um.toml")); }

  Campaign read(const std::string& more = "") const {
    return read_plan(folder_.write("plan.toml",
                                   "kind = 'gains'\ntrials = 9\nseed = 3\nchunk = 2\n[gains]\n"
                                   "scenario = 'loop.toml'\n" +
                                       more),
                     all_kinds());
  }
  std::string refusal(const std::string& more = "") const {
    return error_of([&] { read(more); });
  }
  template <class Number>
  static Number cell(const Campaign& campaign, std::uint64_t trial, std::string_view column) {
    const auto& columns = campaign.trials->columns();
    const auto found = std::ranges::find(columns, column, &Column::name);
    return std::get<Number>(
        campaign.trials->run(trial, {}).row.at(static_cast<std::size_t>(found - columns.begin())));
  }

  TemporaryFolder folder_;
};

TEST_F(CampaignGains, TrialZeroIsTheScenarioOnThePresetWire) {
  const Campaign campaign = read("families = ['ihyp']\n");
  const bench::ClosedLoopScenario scenario = bench::load_closed_loop(folder_ / "loop.toml");
  const simulate::LoopRunResult run = simulate::run_closed_loop(scenario, {});
  EXPECT_EQ(cell<double>(campaign, 0, "above_limit_K"),
            run.max_hottest_K - scenario.settings.limits.temperature_K);
  EXPECT_EQ(cell<std::uint64_t>(campaign, 0, "steps"), run.strain_steps.size());
  EXPECT_EQ(
      cell<std::uint64_t>(campaign, 0, "unsettled_steps"),
      static_cast<std::uint64_t>(std::ranges::count_if(run.strain_steps, report::is_unreached)));
  double steady = 0;
  for (const report::StepFigures& step : run.strain_steps) {
    steady += step.error_percent;
  }
  EXPECT_DOUBLE_EQ(cell<double>(campaign, 0, "steady_error_percent"),
                   steady / static_cast<double>(run.strain_steps.size()));
  for (const char* const ratio : {"length_ratio", "martensite_strain_ratio", "latent_heat_ratio"}) {
    EXPECT_EQ(cell<double>(campaign, 0, ratio), 1) << ratio;
  }
}

TEST_F(CampaignGains, OtherTrialsAreWiresWithinTheTolerance) {
  const Campaign campaign = read();
  double squares = 0;
  for (std::uint64_t i = 1; i < 9; ++i) {
    EXPECT_NEAR(cell<double>(campaign, i, "length_ratio"), 1, 2.5 * 0.005);
    EXPECT_NEAR(cell<double>(campaign, i, "martensite_modulus_ratio"), 1, 2.5 * 0.08);
    const double shift_K = cell<double>(campaign, i, "m2a_shift_K");
    EXPECT_LE(std::abs(shift_K), 2.5 * 1.5);
    squares += shift_K * shift_K;
    EXPECT_EQ(cell<std::string>(campaign, i, "family"), i % 2 == 0 ? "ihyp" : "sublayers");
    EXPECT_LE(cell<double>(campaign, i, "mean_error_percent"),
              cell<double>(campaign, i, "rms_error_percent"));
    EXPECT_LE(cell<double>(campaign, i, "rms_error_percent"),
              cell<double>(campaign, i, "max_error_percent"));
  }
  EXPECT_GT(squares, 1) << "wires that are all alike prove nothing";
}

TEST_F(CampaignGains, GiveTheSameBytesInAnyDivision) {
  const Campaign campaign = read();
  run_into(campaign, folder_ / "one");
  merge_in(campaign, folder_ / "one");
  run_into(campaign, folder_ / "two", {1, 2}, 2);
  run_into(campaign, folder_ / "two", {0, 2}, 2);
  merge_in(campaign, folder_ / "two");
  EXPECT_EQ(contents(folder_ / "one"), contents(folder_ / "two"));
}

/// A wire that a trip has left cold stays away from what is demanded, and its errors count.
TEST_F(CampaignGains, ATripIsNoGoodResult) {
  const double good = cell<double>(read(), 0, "rms_error_percent");
  std::string text = loop_text(devices() + "smartflex-76um.toml");
  text += "[[event]]\nat_s = 2\nwire = 'broken'\n";
  folder_.write("loop.toml", text);
  const Campaign broken = read();
  EXPECT_NE(cell<std::string>(broken, 0, "first_fault"), "none");
  EXPECT_GT(cell<double>(broken, 0, "fault_s"), 2);
  EXPECT_GT(cell<double>(broken, 0, "rms_error_percent"), 3 * good);
}

TEST_F(CampaignGains, TheFingerprintHasAllThatTheDeviceKnows) {
  folder_.write("wire.toml", file_text(devices() + "sublayers-1000-wire.toml"));
  folder_.write("device.toml", "wire = 'wire.toml'\n[measurement]\ncurrent_full_scale_mA = 500\n");
  folder_.write("loop.toml", loop_text("device.toml"));
  const Plan before = read().plan;
  EXPECT_EQ(read().plan.fingerprint, before.fingerprint);
  std::string wire = file_text(folder_ / "wire.toml");
  wire.replace(wire.find("length_m = 0.1\n"), 15, "length_m = 0.11\n");
  folder_.write("wire.toml", wire);
  EXPECT_EQ(differences(before.identity, read().plan.identity),
            "file \"settings of the device\" has another content");
}

TEST_F(CampaignGains, RefusesWhatCannotBeDrawn) {
  EXPECT_THAT(refusal("families = ['ihyp', 'other']\n"),
              AllOf(HasSubstr("gains.families"),
                    HasSubstr("ihyp, sublayers, free-energy, smooth-hardening")));
  EXPECT_THAT(refusal("families = []\n"), HasSubstr("gains.families"));
  EXPECT_THAT(refusal("units = 3\n"), HasSubstr("gains.units = 3: unknown key"));
  folder_.write("loop.toml", "note = 'No loop.'\n");
  EXPECT_THAT(refusal(), HasSubstr("must be that of a closed loop"));
  folder_.write("loop.toml", loop_text("none.toml"));
  EXPECT_THAT(refusal(), HasSubstr("none.toml"));
  folder_.write("device.toml",
                "[wire]\nbased_on = 'smartflex-76um'\ndiameter_um = 100\n"
                "[measurement]\ncurrent_full_scale_mA = 500\n");
  folder_.write("loop.toml", loop_text("device.toml"));
  EXPECT_THAT(refusal(), HasSubstr("its device has a wire of 100 um; the tolerance is known of "
                                   "smartflex-76um alone, with 76 um"));
  folder_.write("loop.toml",
                loop_text(devices() + "smartflex-76um.toml") + "[pair]\ntype = 'passive'\n");
  EXPECT_THAT(refusal(), HasSubstr("has a [pair]"));
  std::filesystem::remove(folder_ / "loop.toml");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("gains.scenario = 'loop.toml'"),
                               HasSubstr("No such file or directory")));
}

}  // namespace
}  // namespace smaservo::campaign::test
