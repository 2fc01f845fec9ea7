#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <random>
#include <sstream>
#include <utility>

#include "firmware/signals.hpp"
#include "firmware/text/signal_names.hpp"
#include "host-sim/can/bus/network.hpp"
#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/outcome.hpp"
#include "host-sim/can/positions.hpp"
#include "host-sim/can/settings.hpp"
#include "host-sim/can/shown.hpp"
#include "host-sim/can/status.hpp"
#include "host-sim/can/step_test.hpp"
#include "host-sim/can/watch.hpp"
#include "host-sim/report/text_plot.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/can/simulated_bus.hpp"

namespace smaservo::can {
namespace {

using test::SimulatedBus;
using testing::HasSubstr;
using namespace std::string_literals;

constexpr Key gain{0x2100, 1};

struct CanClient : testing::Test {
  SimulatedBus bus;
  SdoClient client{bus, SimulatedBus::node};
  Remote remote{client};

  void run(double seconds) {
    hal::CanFrame passing;
    const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(seconds * 1e6);
    while (bus.receive(passing, until_us)) {
    }
  }
  static Change change(const char* name, const char* value) {
    const text::KnownObject object = text::find_object(name);
    return {object, text::value_bytes(object, value)};
  }
  std::string remarks;  ///< of all calls of watched()
  std::string watched(const WatchPlan& plan, bool in_place = false) {
    std::string text;
    watch(
        remote, plan, in_place, [&](const std::string& part) { text += part; },
        [&](const std::string& remark) { remarks += remark; });
    return text;
  }
  /// The header and the numbers of one row.
  std::pair<std::vector<std::string>, std::vector<double>> watched_row(
      const std::vector<std::string>& names, Units units) {
    std::istringstream lines(watched({names, 0.05, 1, "", units}));
    std::pair<std::vector<std::string>, std::vector<double>> row;
    std::string line;
    std::getline(lines, line);
    std::istringstream header(line);
    for (std::string field; std::getline(header, field, ',');) {
      row.first.push_back(field);
    }
    std::getline(lines, line);
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) {
      row.second.push_back(std::stod(field));
    }
    return row;
  }
  template <class F>
  static std::string refusal(F f) {
    try {
      f();
    } catch (const files::UserError& error) {
      return error.what();
    }
    return "";
  }
};

/// A node that has every object, with random values of random lengths.
class AnyNode final : public Bus {
 public:
  explicit AnyNode(unsigned seed) : random_(seed) {}
  void send(const hal::CanFrame& frame) override {
    if (frame.id != 0x601 || frame.data[0] != 0x40) {
      return;
    }
    const auto length = static_cast<unsigned>(random_() % 4 + 1);
    answer_ = {.id = 0x581, .length = 8, .data = frame.data};
    answer_.data[0] = static_cast<std::uint8_t>(0x43U | (4 - length) << 2U);
    constexpr std::array<std::uint64_t, 6> values{0, 3, 0xFF, 0x7FC00000, 0xFF800000, 0x71000000};
    const std::uint64_t value = random_() % 2 == 0 ? values.at(random_() % 6) : random_();
    canopen::put_number(std::span(answer_.data).subspan(4, length), value);
    waits_ = true;
  }
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
    frame = answer_;
    now_us_ = waits_ ? now_us_ : std::max(now_us_, until_us);
    return std::exchange(waits_, false);
  }
  std::int64_t now_us() const override { return now_us_; }
  std::string name() const override { return "any"; }

 private:
  std::mt19937 random_;
  hal::CanFrame answer_;
  bool waits_ = false;
  std::int64_t now_us_ = 0;
};

Bytes real_bytes(float value) {
  Bytes bytes(4);
  canopen::put_number(bytes, canopen::as_bits(value));
  return bytes;
}

TEST_F(CanClient, AllKindsOfTransfersGiveTheSame) {
  const Bytes name = client.upload({0x1008, 0});
  EXPECT_EQ(std::string(name.begin(), name.end()), "smaservo");
  EXPECT_EQ(client.upload_block({0x1008, 0}), name);
  client.download(gain, real_bytes(3));
  EXPECT_EQ(client.upload(gain), real_bytes(3));
  client.download_segmented(gain, real_bytes(4));
  EXPECT_EQ(client.upload(gain), real_bytes(4));
  client.download_block(gain, real_bytes(5));
  EXPECT_EQ(client.upload_block(gain), real_bytes(5));
}

TEST_F(CanClient, SaysWhatTheNodeRefuses) {
  EXPECT_THAT(refusal([&] { client.upload({0x1FFF, 0}); }),
              HasSubstr("1FFFh:0: refused: no such object (abort 06020000h)"));
  EXPECT_THAT(refusal([&] { remote.set("limits.current_mA", "99000"); }),
              HasSubstr("value too high (abort 06090031h); must be 1 to 20000 mA"));
  EXPECT_EQ(remote.number("limits.current_A"), static_cast<double>(0.4F));
  SdoClient nobody(bus, 9);
  EXPECT_THAT(refusal([&] { nobody.upload({0x1000, 0}); }),
              HasSubstr("node 9 on sim: 1000h:0: no answer within 0.5 s"));
}

// The first answer of a read may be lost; a write is not done twice.
TEST_F(CanClient, AsksForAReadAgain) {
  bus.lose_answer(1);
  EXPECT_EQ(client.upload({0x1008, 0}).size(), 8U);
  bus.lose_answer(1);
  EXPECT_EQ(client.upload_block({0x1008, 0}).size(), 8U);
  const std::uint32_t changes = remote.whole("2220:1");
  bus.lose_answer(1);
  EXPECT_THAT(refusal([&] { client.download(gain, real_bytes(6)); }), HasSubstr("no answer"));
  EXPECT_EQ(remote.whole("2220:1"), changes + 1);
}

// An answer that is lost costs this transfer, not the next one.
TEST_F(CanClient, GoesOnAfterALostAnswer) {
  for (int lost = 2; lost <= 3; ++lost) {
    bus.lose_answer(lost);
    EXPECT_THROW(client.upload({0x1008, 0}), SdoError) << lost;
    bus.lose_answer(0);
    EXPECT_EQ(client.upload({0x1008, 0}).size(), 8U);
  }
}

// A segment of a block that is lost is asked for again.
TEST_F(CanClient, BlocksRepeatWhatWasLost) {
  const RecordingPlan plan{{"wire_temperature_K", "position_m"}, 0.5, 0, ""};
  arm_recorder(remote, plan);
  run(0.6);
  remote.set("recorder.command", "0");
  const Bytes whole = client.upload_block({0x2300, 11});
  ASSERT_GT(whole.size(), 4000U);
  for (const int lost : {2, 60, 128, 129, 300}) {
    bus.lose_answer(lost);
    EXPECT_EQ(client.upload_block({0x2300, 11}), whole) << lost;
  }
}

TEST_F(CanClient, SetsAreInForceTogetherOrNotAtAll) {
  remote.change({change("limits.current_mA", "300"), change("strain.proportional_W", "6")});
  EXPECT_EQ(remote.text("limits.current_mA"), "300");
  EXPECT_EQ(remote.number("strain.proportional_W"), 6);
  const std::string why = refusal([&] {
    remote.change({change("limits.current_A", "0.55"), change("trips.current_A", "0.3")});
  });
  EXPECT_THAT(why, HasSubstr("nothing has changed: limits.current_A (2020h:2) = 0.55"));
  EXPECT_EQ(remote.text("limits.current_mA"), "300");
  EXPECT_EQ(remote.text("tuning.state"), "0");
}

TEST_F(CanClient, SettingsComeBackFromAFile) {
  const Settings<double> before = read_settings(remote);
  EXPECT_TRUE(same_settings(before, stored_settings<double>(bus.servo().servo().settings())));
  remote.set("limits.power_W", "1.25");
  const auto all = differences(before, read_settings(remote));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].row->path.text(), "limits.power_W");
  restore(remote, all);
  EXPECT_TRUE(differences(before, read_settings(remote)).empty());
}

// What is a state, a count or bits is one in the answer, or the answer is refused in words. The
// undefined-behaviour sanitizer sees a conversion of what is none.
TEST_F(CanClient, ANodeMayAnswerAnything) {
  int told = 0;
  int not_whole = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    AnyNode any(seed);
    Remote other(SdoClient(any, 1));
    const std::string refused = refusal([&] {
      switch (seed % 6) {
        case 0:
          info_text(other, Units::bench);
          break;
        case 1:
          faults_text(other);
          break;
        case 2:
          other.enable();
          break;
        case 3:
          other.hold(0.1);
          break;
        case 4:
          read_recording(other, {{"strain"}, 1, 0, ""});
          break;
        default:
          first_cause(other);
          break;
      }
    });
    told += refused.empty() ? 1 : 0;
    not_whole += refused.find("must be a whole number") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(told, 20);
  EXPECT_GT(not_whole, 500);
}

TEST_F(CanClient, TellsWhatWasWrittenAndRefused) {
  EXPECT_EQ(changes_text(remote), "none\n");
  remote.set("strain.proportional_W", "3");
  EXPECT_THROW(remote.set("6060", "9"), SdoError);
  const std::string text = changes_text(remote);
  const std::size_t gain_at = text.find("strain.proportional_W (2100h:1): 0 -> 3, by SDO\n");
  const std::size_t mode_at =
      text.find("Modes of operation (6060h:0): stays 0; 9 by SDO is refused");
  EXPECT_LT(gain_at, mode_at) << text;
  EXPECT_NE(mode_at, std::string::npos) << text;
}

TEST_F(CanClient, MovesAndStops) {
  run(0.5);
  EXPECT_THAT(refusal([&] { remote.move(800, 5); }), HasSubstr("is not enabled"));
  remote.enable();
  remote.move(800, 5);
  EXPECT_NEAR(remote.number("6064"), 800, 120);
  EXPECT_GT(bus.servo().rig().flowing_A, 0);
  remote.disable();
  run(0.01);
  EXPECT_EQ(bus.servo().rig().flowing_A, 0);
}

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

TEST_F(CanClient, FindsWhoIsThere) {
  const FoundNodes found = scan(bus, 200'000);
  ASSERT_EQ(found.nodes.size(), 1U);
  EXPECT_EQ(found.nodes[0].node, SimulatedBus::node);
  EXPECT_EQ(found.nodes[0].device_type & 0xFFFFU, 402U);
  EXPECT_FALSE(found.without_id);
  EXPECT_THAT(info_text(remote, Units::bench), HasSubstr("Switch on disabled"));
  EXPECT_THAT(faults_text(remote), testing::ContainsRegex("\nlatched  *none\n"));
}

TEST_F(CanClient, WatchShowsRows) {
  EXPECT_THAT(watched({{"live.wire_temperature_K", "6041"}, 0.05, 3, "live.wire_temperature_K"}),
              testing::AllOf(testing::StartsWith("time_s,live.wire_temperature_K,Statusword\n0.0"),
                             HasSubstr("\n0.10")));
}

// A name without a unit gets that of the choice, one with a unit keeps it, and both say the same
// in SI.
TEST_F(CanClient, WatchShowsTheChosenUnits) {
  const std::vector<std::string> names{
      "position", "live.wire_temperature", "stress",        "limits.current",
      "strain",   "live.stress_kPa",       "limits.power_W"};
  const auto [bench_names, bench] = watched_row(names, Units::bench);
  EXPECT_THAT(bench_names,
              testing::ElementsAre("time_s", "live.position_um", "live.wire_temperature_degC",
                                   "live.stress_MPa", "limits.current_mA", "live.strain_percent",
                                   "live.stress_kPa", "limits.power_W"));
  const auto [si_names, si] = watched_row(names, Units::si);
  EXPECT_THAT(si_names, testing::ElementsAre("time_s", "live.position_m", "live.wire_temperature_K",
                                             "live.stress_Pa", "limits.current_A", "live.strain",
                                             "live.stress_kPa", "limits.power_W"));
  for (std::size_t i = 1; i < bench_names.size(); ++i) {
    const text::KnownObject object = text::find_object(bench_names[i]);
    const text::KnownObject other = text::find_object(si_names[i]);
    EXPECT_EQ(object.key, other.key);
    const double value = object.unit.to_si(bench[i]);
    const double same = other.unit.to_si(si[i]);
    EXPECT_NEAR(value, same, 1e-3 * std::abs(same) + 1e-5) << bench_names[i];
  }
}

// A set-point is in the unit of its mode. Where that changes, no number stands under a wrong unit.
TEST_F(CanClient, WatchShowsSetPointsInTheUnitOfTheMode) {
  EXPECT_TRUE(watched({{"setpoint"}, 0.05, 1, ""}).starts_with("time_s,live.setpoint\n"));
  EXPECT_THAT(remarks, HasSubstr("no mode is set (6060h), so its unit is not known"));
  EXPECT_THAT(watched({{"setpoint"}, 0.05, 1, ""}, true),
              HasSubstr("no mode is set (6060h), so its unit is not known"));
  EXPECT_THAT(refusal([&] { watched({{"setpoint_um"}, 0.05, 1, ""}); }),
              HasSubstr("live.setpoint_um: no mode is set (6060h)"));
  run(0.5);
  remote.enable();
  remote.move(700, 5);
  const auto [names, values] = watched_row({"setpoint", "reference"}, Units::bench);
  EXPECT_THAT(names, testing::ElementsAre("time_s", "live.setpoint_um", "live.reference_um"));
  EXPECT_NEAR(values[1], 700, 1);
  // With the unit of a mode in its name it is found where the mode in force has that unit.
  const auto [typed_names, typed] =
      watched_row({"setpoint_um", "live.setpoint_mm", "reference_m"}, Units::si);
  EXPECT_THAT(typed_names, testing::ElementsAre("time_s", "live.setpoint_um", "live.setpoint_mm",
                                                "live.reference_m"));
  EXPECT_NEAR(typed[1], 1e3 * typed[2], 0.01);
  EXPECT_NEAR(typed[1], 700, 1);
  EXPECT_THAT(refusal([&] { watched({{"setpoint_mA"}, 0.05, 1, ""}); }),
              HasSubstr("live.setpoint_mA: the mode in force has another unit: m, mm, um"));
  EXPECT_THAT(watched({{"setpoint"}, 0.05, 1, "", Units::si}), HasSubstr("live.setpoint_m\n"));
  int shown = 0;
  std::string text;
  watch(
      remote, {{"setpoint", "setpoint_mm"}, 0.05, 3, ""}, false,
      [&](const std::string& part) {
        text += part;
        if (++shown == 2) {
          remote.set("6060", "-3");
          run(0.1);
        }
      },
      [&](const std::string& remark) { remarks += remark; });
  EXPECT_THAT(text, testing::EndsWith(",,\n"));
  EXPECT_THAT(text, HasSubstr("time_s,live.setpoint_um,live.setpoint_mm\n"));
  EXPECT_THAT(remarks,
              HasSubstr("live.setpoint_um: empty while the mode has another unit, first at"));
}

// The line is there exactly while a position loop has no gain.
TEST_F(CanClient, WatchSaysThatThePidDoesNothing) {
  constexpr const char* line = "strain.proportional_W is 0, its default: the model alone drives\n";
  const auto table = [&] { return watched({{"position"}, 0.05, 1, ""}, true); };
  EXPECT_THAT(table(), testing::Not(HasSubstr(line))) << "no mode is set";
  run(0.5);
  remote.enable();
  remote.set_profile_position();
  EXPECT_THAT(table(), HasSubstr(line));
  remote.set("strain.proportional_W", "0.5");
  EXPECT_THAT(table(), testing::Not(HasSubstr(line)));
  remote.set("strain.proportional_W", "0");
  remote.set_mode(-3);
  EXPECT_THAT(table(), testing::Not(HasSubstr(line)));
}

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

TEST(CanObjects, LiveValuesHaveTwoSpellings) {
  for (std::size_t i = 0; i < signal_count; ++i) {
    const std::string name(signal_rows<double>[i].name);
    for (const std::string& spelling : {name, "live." + name}) {
      EXPECT_EQ(text::find_object(spelling).key, (Key{live_values, sub_of(i)})) << spelling;
      EXPECT_EQ(text::find_object(spelling).name, "live." + name);
      EXPECT_EQ(text::signal_row(spelling), i);
    }
    for (const Unit& unit : text::signal_kind(i)) {
      const text::KnownObject object = text::in_unit(text::find_object(name), unit);
      EXPECT_EQ(text::find_object(object.name).key, object.key) << object.name;
      EXPECT_EQ(text::find_object(object.name).unit.suffix, unit.suffix) << object.name;
    }
  }
  EXPECT_THAT(
      [] { text::find_object("wire_temperatur_K"); },
      testing::ThrowsMessage<files::UserError>(HasSubstr("did you mean wire_temperature_K")));
  EXPECT_THAT(
      [] { text::find_object("temperature_K"); },
      testing::ThrowsMessage<files::UserError>("temperature_K: is now called wire_temperature_K"));
}

TEST(CanObjects, ValuesHaveUnitsBehindThem) {
  const text::KnownObject limit = text::find_object("limits.temperature_K");
  const std::string with_sign = std::string("+120\xC2\xB0") + 'C';
  for (const std::string& text :
       {std::string("393.15"), std::string("120degC"), std::string("120 degC"),
        std::string("393.15K"), with_sign, std::string("+393.15")}) {
    EXPECT_EQ(text::value_bytes(limit, text), real_bytes(393.15F)) << text;
  }
  const text::KnownObject strain = text::find_object("limits.max_strain");
  EXPECT_EQ(text::value_bytes(strain, "4%"), real_bytes(0.04F));
  EXPECT_EQ(text::value_bytes(strain, "4percent"), real_bytes(0.04F));
  const text::KnownObject rate = text::find_object("strain.integral_1_s");
  for (const char* const text : {"2", "2 1/s", "2/s", "2 /s", "2 1_s"}) {
    EXPECT_EQ(text::value_bytes(rate, text), real_bytes(2)) << text;
  }
  EXPECT_EQ(text::value_bytes(text::find_object("6060"), "+1"), Bytes{1});
  EXPECT_THROW(text::value_bytes(text::find_object("6060"), "+-1"), files::UserError);
  for (const char* const text :
       {"120mA", "120degF", "degC", "120 degC ", "1e400K", "+-120", "++120", "+", ""}) {
    EXPECT_THAT([&] { text::value_bytes(limit, text); },
                testing::ThrowsMessage<files::UserError>(
                    HasSubstr("must be a number, or one with a unit behind it: K, degC")))
        << text;
  }
}

// The text in any unit is short, and gives the same float.
TEST(CanObjects, TextsInAnyUnitComeBack) {
  const text::KnownObject kelvin = text::find_object("limits.temperature_K");
  const text::KnownObject degree = text::find_object("limits.temperature_degC");
  EXPECT_EQ(text::value_text(degree, text::value_bytes(degree, "90")), "90");
  EXPECT_EQ(text::value_text(degree, text::value_bytes(kelvin, "300")), "26.85");
  EXPECT_EQ(text::value_text(degree, text::value_bytes(degree, "0")), "0");
  std::mt19937 random(1);
  for (const text::KnownObject& object : text::known_objects()) {
    for (const Unit& unit : object.kind) {
      const text::KnownObject other = text::in_unit(object, unit);
      const Bytes bytes = real_bytes(static_cast<float>(random() % 100'000) *
                                     std::ldexp(1.F, -static_cast<int>(random() % 10)));
      EXPECT_EQ(text::value_bytes(other, text::value_text(other, bytes)), bytes) << other.name;
    }
  }
}

TEST(CanPositions, AreReadInAnyUnitOfLength) {
  for (const char* const text : {"1000", "1mm", "1000um", "0.001m", "1 mm", "1e3", "+1000",
                                 "1000\xC2\xB5m", "1000 \xCE\xBCm"}) {
    EXPECT_EQ(position_um(text, Units::bench), 1000) << text;
  }
  EXPECT_EQ(position_um("0.0011m", Units::si), 1100);
  for (const char* const text : {"1000", "0.001", "0"}) {
    EXPECT_THAT([&] { position_um(text, Units::si); },
                testing::ThrowsMessage<files::UserError>(
                    fmt::format("position {}: needs a unit behind it: m, mm, um", text)));
  }
  EXPECT_EQ(position_um("0.8mm", Units::bench), 800);
  EXPECT_EQ(position_um("-0.3mm", Units::si), -300);
  for (std::int32_t um = -2000; um < 2000; um += 7) {
    EXPECT_EQ(position_um(fmt::format("{}mm", um / 1e3), Units::bench), um);
    EXPECT_EQ(position_um(fmt::format("{}m", um / 1e6), Units::bench), um);
  }
  const auto refused = [](const char* text, const char* why) {
    EXPECT_THAT([&] { position_um(text, Units::bench); },
                testing::ThrowsMessage<files::UserError>(HasSubstr(why)))
        << text;
  };
  refused("1inch", "must be a number, alone (um) or with a unit behind it: m, mm, um");
  refused("1degC", "with a unit behind it: m, mm, um");
  refused("mm", "must be a number");
  refused("nan", "must be");
  refused("0.5", "is 0.5 um, must be a whole number of um");
  refused("2147483648", "must be -2147483648 to 2147483647 um");
  refused("3km", "with a unit behind it");
  refused("3000m", "is 3e+09 um, must be -2147483648 to 2147483647 um");
}

TEST(CanObjects, NamesWithoutAUnitGetTheChosenOne) {
  const auto found = [](const char* name, Units units) {
    const Shown shown = shown_object(name, units);
    return std::pair(shown.object.name, shown.names_unit);
  };
  EXPECT_EQ(found("limits.current", Units::bench), std::pair("limits.current_mA"s, false));
  EXPECT_EQ(found("limits.current", Units::si), std::pair("limits.current_A"s, false));
  EXPECT_EQ(found("position", Units::bench), std::pair("live.position_um"s, false));
  EXPECT_EQ(found("limits.current_A", Units::bench), std::pair("limits.current_A"s, true));
  EXPECT_EQ(found("live.strain", Units::bench), std::pair("live.strain_percent"s, false));
  EXPECT_EQ(found("strain", Units::si), std::pair("live.strain"s, true));
  EXPECT_EQ(found("strain_percent", Units::si), std::pair("live.strain_percent"s, true));
  EXPECT_EQ(found("limits.max_strain", Units::bench), std::pair("limits.max_strain"s, true));
  EXPECT_EQ(found("setpoint", Units::bench), std::pair("live.setpoint"s, false));
  EXPECT_EQ(found("setpoint_um", Units::bench), std::pair("live.setpoint"s, true));
  EXPECT_EQ(found("6041", Units::bench), std::pair("Statusword"s, true));
  EXPECT_THROW(shown_object("limits.currnt", Units::bench), files::UserError);
  EXPECT_THROW(shown_object("setpoint_ohm", Units::bench), files::UserError);
}

TEST(CanObjects, AreFoundByNameUnitAndKey) {
  EXPECT_EQ(text::find_object("strain.proportional_W").key, gain);
  EXPECT_EQ(text::find_object("2100:1").name, "strain.proportional_W");
  EXPECT_EQ(text::find_object("0x2100:1").key, gain);
  EXPECT_EQ(text::find_object("2100h:1").key, gain);
  EXPECT_EQ(text::value_bytes(text::find_object("limits.current_mA"), "250"), real_bytes(0.25F));
  EXPECT_EQ(text::value_text(text::find_object("limits.current_mA"), real_bytes(0.25F)), "250");
  EXPECT_EQ(text::find_object("5FFF:2").type, canopen::Type::octets);
  EXPECT_THROW(text::find_object("limits.currnt_A"), files::UserError);
  EXPECT_THAT([] { text::find_object("measuring.load_gain"); },
              testing::ThrowsMessage<files::UserError>(
                  "measuring.load_gain: is now called measurement.load_gain"));
  EXPECT_THROW(text::value_bytes(text::find_object("6040"), "65536"), files::UserError);
  EXPECT_THROW(text::value_bytes(text::find_object("6060"), "-129"), files::UserError);
  EXPECT_THROW(text::value_bytes(text::find_object("limits.current_A"), "0.1x"), files::UserError);
}

// Every object reads back what it writes as text.
TEST(CanObjects, TextsComeBack) {
  for (const text::KnownObject& object : text::known_objects()) {
    const std::size_t size = canopen::size_of(object.type);
    if (size == 0) {
      continue;
    }
    const Bytes one = object.type == canopen::Type::real ? real_bytes(1.5F) : Bytes(size, 0);
    const std::string text = text::value_text(object, one);
    EXPECT_EQ(text::value_bytes(object, text), one) << object.name << ' ' << text;
  }
}

TEST(CanTextPlot, DrawsARise) {
  const std::vector<double> values{0, 1, 2, std::nan("")};
  EXPECT_EQ(report::text_plot({values}, 10, 3), "         2 |  *\n           | *\n         0 |*\n");
  EXPECT_EQ(report::text_plot({values, {2, 2, 2, 0}}, 10, 3),
            "         2 |..*\n           | *\n         0 |*  .\n");
  EXPECT_EQ(report::text_plot({}, 10, 3), "");
  // No label moves the plot to the right.
  for (const double value : {-3.64505e-07, 0.000501024, -1234567.8, 1e-300, 123456.0}) {
    EXPECT_EQ(report::text_plot({{value}}, 10, 3).find(" |"), 10U) << value;
  }
}

TEST(CanFrames, AreSaidInWords) {
  EXPECT_EQ(frame_text({.id = 0, .length = 2, .data = {1, 5}}), "NMT: start, node 5");
  EXPECT_EQ(frame_text({.id = 0x705, .length = 1, .data = {0x7F}}),
            "heartbeat of 5: pre-operational");
  EXPECT_THAT(frame_text({.id = 0x85, .length = 8, .data = {0x30, 0x81, 0x11}}),
              HasSubstr("EMCY of 5: 8130h"));
  EXPECT_THAT(frame_text({.id = 0x585, .length = 8, .data = {0x80, 0, 0x10, 0, 0, 0, 2, 6}}),
              HasSubstr("06020000h no such object"));
}

}  // namespace
}  // namespace smaservo::can
