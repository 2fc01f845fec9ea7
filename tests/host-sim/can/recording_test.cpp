#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sstream>

#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/step_test.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/can/can_client.hpp"

namespace smaservo::can {
namespace {

using testing::HasSubstr;

TEST_F(CanClient, JudgesAStep) {
  run(0.5);
  const StepRun step = run_step(remote, {.amplitude_um = 600, .seconds = 1});
  const std::vector<double> setpoints = step.recording.column("setpoint");
  EXPECT_NEAR(*std::ranges::max_element(setpoints) - setpoints.front(), 600e-6, 60e-6)
      << "of the way there, which begins after the recording";
  const StepResult result = judge(step);
  EXPECT_GT(result.figures.rise_s, 0.005);
  EXPECT_LT(result.figures.rise_s, 0.5);
  EXPECT_LT(result.figures.error_percent, 10);
  EXPECT_GT(result.peak_K, 320);
  // It was off before.
  EXPECT_EQ(static_cast<unsigned>(remote.number("6041")) & 0x4FU, 0x40U);
  // What a file keeps gives the same figures.
  const test::TemporaryFolder folder;
  const std::string file = folder.write("step.csv", step_csv(step));
  const StepResult again = judge(load_step(file));
  EXPECT_NEAR(again.figures.rise_s, result.figures.rise_s, 1e-6);
  EXPECT_NEAR(again.figures.error_percent, result.figures.error_percent, 0.01);
  EXPECT_THAT(step_text({step}, {"now"}, Units::bench), HasSubstr("now"));
  // Runs lie over each other, whatever their lengths.
  StepRun shorter = step;
  shorter.recording.rows.resize(shorter.recording.rows.size() / 2);
  for (std::vector<double>& row : shorter.recording.rows) {
    row[1] += 100e-6;
  }
  shorter.recording.rows.front()[1] -= 50e-6;
  const std::string both = step_text({step, shorter}, {"now", "before"}, Units::bench);
  EXPECT_THAT(both, HasSubstr("um: * now, . before\n"));
  EXPECT_THAT(both.substr(both.find("um: *")), HasSubstr(" |"));
  const std::string drawn = both.substr(both.find('|'), both.rfind('|') - both.find('|'));
  EXPECT_GT(std::ranges::count(drawn, '.'), 5);
}

TEST_F(CanClient, ARecordingThatSomebodyElseStopsIsNotWhole) {
  const RecordingPlan plan{{"strain"}, 1, 0, ""};
  arm_recorder(remote, plan);
  run(0.3);
  remote.set("recorder.command", "0");
  wait_for_recorder(remote, plan, 5);
  const Recording part = read_recording(remote, plan);
  EXPECT_THROW(require_complete(part, plan, "r.csv"), files::NoResult);
  arm_recorder(remote, plan);
  wait_for_recorder(remote, plan, 5);
  EXPECT_NO_THROW(require_complete(read_recording(remote, plan), plan, "r.csv"));
}

// A node answers the later of two requests that meet; another client may ask at any time.
TEST_F(CanClient, AnyAnswerMayBeLostToARecording) {
  const RecordingPlan plan{{"strain", "current_A"}, 0.1, 0.02, "wire_temperature_K>200"};
  for (int lost = 1; lost <= 30; ++lost) {
    bus.lose_answer(lost);
    EXPECT_NO_THROW(arm_recorder(remote, plan)) << lost;
    bus.lose_answer(0);
    EXPECT_EQ(remote.number("recorder.state"), 1) << lost;
    EXPECT_EQ(remote.whole("recorder.channel_2"), sub_of(text::signal_row("current_A"))) << lost;
  }
}

TEST_F(CanClient, RefusesWhatIsNoRecording) {
  const test::TemporaryFolder folder;
  const auto said = [&](const char* text) {
    const std::string file = folder.write("step.csv", text);
    return refusal([&] { load_step(file); });
  };
  EXPECT_THAT(said(""), HasSubstr("is not a recording"));
  EXPECT_THAT(said("time_s,setpoint\n"), HasSubstr("has no rows"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0.1\n"), HasSubstr(":3: must have 2 fields"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0.1,2x\n"), HasSubstr(":3: 2x: is not a number"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0,2\n"), HasSubstr(":3: time_s must increase"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n,2\n"), HasSubstr(":3: time_s must increase"));
  EXPECT_THAT(said("time_s,setpoint\n0,1\n0.1,2\n0.3,2\n"),
              HasSubstr(":4: time_s is 0.2 s later than before, must be 0.1 s"));
  EXPECT_THAT(said("time_s,setpoint,\n0,1,2\n"), HasSubstr("needs the name of a signal"));
  EXPECT_THAT(said("time_s,setpoint\n0,1e39\n"), HasSubstr(":2: 1e39: is not a number"));
}

TEST_F(CanClient, RefusesARecordingThatBeginsBeforeItself) {
  EXPECT_THAT(refusal([&] { arm_recorder(remote, {{"strain"}, 1, 0.5, ""}); }),
              HasSubstr("--before 0.5 s: needs a --trigger"));
  EXPECT_THAT(refusal([&] { arm_recorder(remote, {{"strain"}, 1, 1, "strain>0"}); }),
              HasSubstr("--before 1 s: must be less than the 1 s"));
}

// A step's file has the gains that were in force; one without them says so.
TEST_F(CanClient, StepsKeepTheirGains) {
  remote.set("strain.proportional_W", "0.5");
  const auto first = read_gains(remote);
  remote.set("strain.proportional_W", "2");
  const auto second = read_gains(remote);
  EXPECT_EQ(first.size(), second.size());
  EXPECT_EQ(first.at("strain.proportional_W"), "0.5");
  EXPECT_TRUE(first.contains("trajectory.feed_forward_s"));
  EXPECT_TRUE(first.contains("limits.current_A"));
  EXPECT_FALSE(first.contains("wire.length_m"));
  StepRun run{{}, {{"setpoint", "position_m", "wire_temperature_K", "drive_current_A"}, 0.01, {}}};
  for (int i = 0; i < 100; ++i) {
    const double way_m = i < 10 || i >= 60 ? 0 : 500e-6;
    run.recording.rows.push_back({way_m, way_m, 300, 0.1});
  }
  const test::TemporaryFolder folder;
  const auto kept = [&](const std::map<std::string, std::string>& gains) {
    StepRun one = run;
    one.gains = gains;
    return load_step(folder.write("step.csv", step_csv(one)));
  };
  EXPECT_EQ(kept(first).gains, first);
  EXPECT_EQ(kept(first).recording.rows, run.recording.rows);
  EXPECT_TRUE(kept({}).gains.empty());
  const std::string text =
      step_text({kept(second), kept(first), kept({})}, {"three", "two", "one"}, Units::bench);
  EXPECT_THAT(text, HasSubstr("one: gains not recorded\n"));
  EXPECT_THAT(text, testing::ContainsRegex("gains and limits that differ  *three  *two\n"));
  EXPECT_THAT(text, testing::ContainsRegex("strain.proportional_mW  *2000  *500\n"));
  const std::size_t same = text.find("the same in all:");
  ASSERT_NE(same, std::string::npos);
  EXPECT_EQ(text.find("strain.proportional_", same), std::string::npos);
  EXPECT_THAT(text.substr(same), HasSubstr("temperature_degC 120"));
  EXPECT_THAT(text.substr(same), HasSubstr("\nstrain      cooling_factor "));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 80U) << line;
  }
  EXPECT_THAT(step_text({kept(first)}, {"now"}, Units::si),
              testing::AllOf(HasSubstr("\ngains and limits:\n"), HasSubstr("proportional_W 0.5"),
                             HasSubstr("peak K"), HasSubstr("contraction, m: * now")));
}

// A crossing of the level counts only when the rows before the trigger are there: who makes one is
// told when that is so.
TEST_F(CanClient, ARecorderSaysWhenItWaitsForItsTrigger) {
  const RecordingPlan plan{{"strain"}, 0.5, 0.2, "wire_temperature_K>2000"};
  arm_recorder(remote, plan);
  RecorderWatch watch(remote, plan, 60);
  EXPECT_EQ(watch.look(), RecorderStage::filling);
  run(0.1);
  EXPECT_EQ(watch.look(), RecorderStage::filling);
  run(0.2);
  EXPECT_EQ(watch.look(), RecorderStage::waiting);
  remote.set("recorder.command", "2");
  run(0.1);
  EXPECT_EQ(watch.look(), RecorderStage::recording);
  run(0.5);
  EXPECT_EQ(watch.look(), RecorderStage::complete);

  const RecordingPlan at_once{{"strain"}, 0.1, 0, ""};
  arm_recorder(remote, at_once);
  run(0.02);
  EXPECT_EQ(RecorderWatch(remote, at_once, 60).look(), RecorderStage::recording);
}

// A recording is the same by both spellings of its signals.
TEST_F(CanClient, RecordsBySignalsAndByLiveValues) {
  const RecordingPlan plan{
      {"live.wire_temperature_K", "strain"}, 0.1, 0.02, "live.wire_temperature_K>200"};
  arm_recorder(remote, plan);
  EXPECT_EQ(remote.number("recorder.trigger_signal"), remote.number("recorder.channel_1"));
  remote.set("recorder.command", "2");
  wait_for_recorder(remote, plan, 5);
  const Recording recording = read_recording(remote, plan);
  EXPECT_THAT(recording.signals, testing::ElementsAre("wire_temperature_K", "strain"));
  EXPECT_THAT(refusal([&] { arm_recorder(remote, {{"live.wire_temperatur_K"}, 1, 0, ""}); }),
              HasSubstr("did you mean wire_temperature_K?"));
  for (const char* const name : {"wire_temperature", "live.wire_temperature_degC"}) {
    EXPECT_THAT(refusal([&] { arm_recorder(remote, {{name}, 1, 0, ""}); }),
                HasSubstr(fmt::format("{}: signals are in SI: wire_temperature_K", name)));
  }
}

}  // namespace
}  // namespace smaservo::can
