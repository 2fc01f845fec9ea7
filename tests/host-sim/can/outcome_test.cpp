#include "host-sim/can/outcome.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <utility>

#include "host-sim/can/positions.hpp"
#include "host-sim/can/settings.hpp"
#include "tests/host-sim/can/can_client.hpp"

namespace smaservo::can {
namespace {

using testing::HasSubstr;

TEST_F(CanClient, SaysWhatIsSoNow) {
  run(0.5);
  remote.enable();
  EXPECT_EQ(enabled_text(remote),
            "enabled: may be heated until 5 s after the last enable, move or set-point "
            "(`host-sim can hold` keeps it)\n");
  remote.set("command_source.timeout_s", "2.5");
  EXPECT_THAT(enabled_text(remote), HasSubstr("until 2.5 s after the last enable, move"));
  remote.move(800, 5);
  const std::string at = remote.text("6064");
  EXPECT_EQ(moved_text(remote, 800, 0.417, Units::bench),
            fmt::format("within 100 um of 800 um after 0.42 s: at {} um\n", at));
  EXPECT_THAT(moved_text(remote, 800, 0.417, Units::si),
              HasSubstr("within 0.0001 m of 0.0008 m after 0.42 s: at 0.000"));
  remote.set("6067", "70");
  EXPECT_THAT(moved_text(remote, 800, 0.417, Units::bench), HasSubstr("within 70 um of 800 um"));
  remote.set("6067", "4294967295");
  EXPECT_THAT(moved_text(remote, 800, 0.417, Units::bench), HasSubstr("(target 800 um)"));
  remote.set("1400:5", "500");
  EXPECT_THAT(enabled_text(remote), HasSubstr("while the RPDO of 1400h comes"));
  remote.set("1016:2", std::to_string((9U << 16U) + 500));
  EXPECT_THAT(enabled_text(remote), HasSubstr("while the watched heartbeats (1016h) come"));
  remote.disable();
  EXPECT_THAT(disabled_text(remote, Units::bench),
              testing::MatchesRegex("disabled: current off, the wire relaxes from [-0-9]+ um, "
                                    "[.0-9]+ degC\n"));
  // Nobody has sent the heartbeat that is watched.
  EXPECT_THAT(faults_reset_text(remote, {}), HasSubstr("the drive is in \"Fault\""));
  remote.set("1016:2", "0");
  remote.reset_faults();
  EXPECT_EQ(
      faults_reset_text(remote, {}),
      "there was no fault to acknowledge; the drive is disabled, the wire's state is ready\n");
  EXPECT_THAT(faults_reset_text(remote, FaultSet(Fault::wire_open)),
              HasSubstr("acknowledged: wire_open; the drive is disabled"));
  remote.nmt(NmtCommand::start);
  EXPECT_THAT(started_text(remote), HasSubstr("operational: node 5"));
  remote.nmt(NmtCommand::reset_node);
  EXPECT_THAT(restarted_text(remote), HasSubstr("reset: node 5 has started anew after 0.0"));
  EXPECT_THAT(refusal([&] { restarted_text(remote); }),
              HasSubstr("node 5 on sim has not reported its start within 3 s"));
  Remote nobody{SdoClient(bus, 9)};
  EXPECT_THAT(refusal([&] { started_text(nobody); }), HasSubstr("node 9 on sim"));
  EXPECT_THAT(refusal([&] { restarted_text(nobody); }), HasSubstr("node 9 on sim"));
}

// What is said after reset-faults is so: it is not read before the heat is off.
TEST_F(CanClient, AcknowledgingFaultsOfARunningDriveTellsTheSettledState) {
  run(0.5);
  for (const std::int32_t target_um : {700, 1000, 1300}) {
    remote.enable();
    remote.move(target_um, 5);
    remote.reset_faults();
    EXPECT_EQ(
        faults_reset_text(remote, {}),
        "there was no fault to acknowledge; the drive is disabled, the wire's state is ready\n");
    EXPECT_EQ(bus.servo().rig().flowing_A, 0);
  }
}

// A target is refused exactly where the node would limit it: the demand does not arrive.
TEST_F(CanClient, RefusesTargetsThatTheNodeWouldLimit) {
  run(0.5);
  const auto refused = [&](std::int32_t target_um) {
    return !refusal([&] { require_allowed(remote, target_um, "x", Units::bench); }).empty();
  };
  const auto limited = [&](std::int32_t target_um) {
    remote.start_move(target_um);
    run(0.1);
    return remote.number("6062") != target_um;
  };
  const auto wire = allowed_positions(remote);
  EXPECT_LT(wire.low_um, 100);
  EXPECT_GT(wire.high_um, 1000);
  EXPECT_THAT(
      refusal([&] { require_allowed(remote, 1'000'000'000, "1000m", Units::si); }),
      testing::AllOf(HasSubstr("position 1000m: node 5 allows "),
                     HasSubstr(position_text(static_cast<double>(wire.high_um), Units::si))));
  EXPECT_EQ(bus.servo().rig().flowing_A, 0);
  for (const auto& [low_um, high_um] :
       {std::pair("-2147483648", "2147483647"), std::pair("300", "900")}) {
    remote.set("607D:2", high_um);
    remote.set("607D:1", low_um);
    const auto [low, high] = allowed_positions(remote);
    remote.enable();
    remote.set_profile_position();
    for (const std::int64_t target : {low - 1, low, (low + high) / 2, high, high + 1}) {
      const auto target_um = static_cast<std::int32_t>(target);
      EXPECT_EQ(refused(target_um), limited(target_um)) << target_um;
    }
    remote.disable();
  }
}

TEST_F(CanClient, SaysOldAndNewValues) {
  const std::vector<Change> changes{change("strain.proportional_W", "0.5"),
                                    change("limits.current_mA", "400"), change("6060", "1")};
  const std::vector<Bytes> before = values_before(remote, changes);
  EXPECT_EQ(changed_text(changes, before),
            "strain.proportional_W: 0 -> 0.5\nlimits.current_mA: was 400 already\n"
            "Modes of operation: 0 -> 1\n");
  const Settings<double> file = read_settings(remote);
  remote.set("limits.power_W", "1.25");
  const auto all = differences(file, read_settings(remote));
  const text::KnownObject power = text::find_object("limits.power_mW");
  EXPECT_EQ(restored_text(all, Units::bench),
            fmt::format("limits.power_mW: 1250 -> {}\n",
                        text::value_text(power, bytes_of(power, all.front().here))));
  EXPECT_TRUE(restored_text(all, Units::si).starts_with("limits.power_W: 1.25 -> "));
}

// A trial is in force at once, ends as if it had never been, and stays when it is kept.
TEST_F(CanClient, TrialsAreKeptOrTakenBack) {
  run(0.1);
  const std::vector<Change> changes{change("limits.current_mA", "300"),
                                    change("strain.proportional_W", "6")};
  const auto values = [&] {
    return std::pair(remote.text("limits.current_mA"), remote.text("strain.proportional_W"));
  };
  const auto before = values();
  const std::pair<std::string, std::string> tried("300", "6");
  for (const char* const verb : {"keep", "revert"}) {
    EXPECT_THAT(
        refusal([&] { verb == std::string("keep") ? keep_trial(remote) : revert_trial(remote); }),
        HasSubstr(fmt::format("node 5 has no trial to {}", verb)));
  }
  EXPECT_THAT(begin_trial(remote, changes, 30),
              testing::AllOf(HasSubstr("limits.current_mA: 400 -> 300\n"),
                             HasSubstr("strain.proportional_W: 0 -> 6\n"),
                             HasSubstr("\non trial for 30 s, until ")));
  EXPECT_EQ(values(), tried);
  EXPECT_THAT(refusal([&] { begin_trial(remote, changes, 30); }),
              testing::AllOf(HasSubstr("node 5 has a trial already, for "), HasSubstr("keep")));
  EXPECT_THAT(revert_trial(remote), HasSubstr("reverted, "));
  EXPECT_EQ(values(), before);
  begin_trial(remote, changes, 0.5);
  run(0.4);
  EXPECT_EQ(values(), tried);
  run(0.2);
  EXPECT_EQ(values(), before) << "it ends by itself";
  EXPECT_THAT(refusal([&] { keep_trial(remote); }), HasSubstr("no trial to keep"));
  // It lasts although nobody asks the node for longer than its usual patience.
  EXPECT_EQ(remote.number("tuning.client_timeout_s"), 5);
  begin_trial(remote, changes, 8);
  run(7.5);
  EXPECT_EQ(values(), tried);
  revert_trial(remote);
  begin_trial(remote, changes, 6);
  run(7);
  EXPECT_EQ(values(), before);
  EXPECT_THROW(keep_trial(remote), files::UserError);
  EXPECT_EQ(remote.number("tuning.client_timeout_s"), 5) << "a trial leaves it as it is";
  begin_trial(remote, changes, 0.5);
  EXPECT_THAT(keep_trial(remote), HasSubstr("kept, 0."));
  run(1);
  EXPECT_EQ(values(), tried);
}

TEST_F(CanClient, ATrialIsWholeOrNothing) {
  const std::string why = refusal([&] {
    begin_trial(remote, {change("limits.current_A", "0.3"), change("limits.min_strain", "0.05")},
                30);
  });
  EXPECT_THAT(why, HasSubstr("nothing has changed: limits.m"));
  EXPECT_THAT(refusal([&] { begin_trial(remote, {change("trips.current_A", "0.7")}, 30); }),
              HasSubstr("trips.current_A (2021h:1): cannot be tried"));
  EXPECT_EQ(remote.text("limits.current_mA"), "400");
  EXPECT_THAT(refusal([&] { keep_trial(remote); }), HasSubstr("no trial to keep"));
  EXPECT_THAT(refusal([&] { begin_trial(remote, {change("6060", "1")}, 30); }),
              HasSubstr("6060h:0): is no parameter"));
  remote.set("tuning.command", "1");
  EXPECT_THAT(refusal([&] { begin_trial(remote, {change("limits.power_W", "1")}, 30); }),
              HasSubstr("somebody else is writing a set of changes"));
}

}  // namespace
}  // namespace smaservo::can
