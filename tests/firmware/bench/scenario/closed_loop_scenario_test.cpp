// Scenarios with a device: what they mean, and what is wrong with them.

#include "firmware/bench/scenario/closed_loop_scenario.hpp"

#include <cmath>
#include <gmock/gmock.h>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* head = "note = 'n'\n[device]\nsettings = 'd.toml'\n";

bench::ClosedLoopScenario loaded(const std::string& text) {
  const TemporaryFolder folder;
  folder.write("d.toml", "wire = 'smartflex-76um'\n[timing]\nperiod_ms = 2\n");
  return bench::load_closed_loop(folder.write("loop.toml", text));
}

std::string refusal(const std::string& text) {
  try {
    loaded(text);
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "was accepted";
}

bench::CommandProgram program(const std::string& commands) {
  return bench::CommandProgram(loaded(head + commands).program);
}

TEST(ClosedLoopScenario, HasDefaultsForAllButCommands) {
  const bench::ClosedLoopScenario s =
      loaded(std::string(head) + "[[command]]\npower_mW = 20\nfor_s = 3\n");
  EXPECT_EQ(s.duration_s, 3);
  EXPECT_EQ(s.plant.family, bench::PlantFamily::ihyp);
  EXPECT_EQ(s.board.period_ns, 2'000'000);
  EXPECT_EQ(std::get<hal::ConstantLoad>(s.board.load).stress_Pa, 150e6);
  EXPECT_EQ(s.program.at(0).command.mode, Mode::power);
  EXPECT_DOUBLE_EQ(s.program.at(0).command.setpoint, 0.02);
  EXPECT_TRUE(s.program.at(0).command.arm);
  EXPECT_TRUE(s.events.empty());
}

TEST(ClosedLoopScenario, ChangesSettings) {
  const std::string command = "[[command]]\nmode = 'off'\nfor_s = 1\n";
  const bench::ClosedLoopScenario s =
      loaded(head + std::string("set = ['limits.duty=0.5', 'drive.kind=voltage']\n") + command);
  EXPECT_EQ(s.settings.limits.duty, 0.5);
  EXPECT_TRUE(s.board.converter.voltage_drive);
  EXPECT_THAT(refusal(head + std::string("set = ['limits.fun=1']\n") + command),
              HasSubstr("limits.fun"));
}

TEST(ClosedLoopScenario, TellsItsKindByTheDevice) {
  const TemporaryFolder folder;
  EXPECT_TRUE(bench::is_closed_loop(folder.write("a.toml", head)));
  EXPECT_FALSE(bench::is_closed_loop(folder.write("b.toml", "note = 'n'\n")));
}

TEST(ClosedLoopScenario, SetpointsComeInAnyUnit) {
  const auto first = [](const std::string& key) {
    const Command<double> c = program("[[command]]\n" + key + "\nfor_s = 1\n").at(0);
    return std::pair(c.mode, c.setpoint);
  };
  EXPECT_EQ(first("strain = 0.02"), std::pair(Mode::strain, 0.02));
  EXPECT_EQ(first("strain_percent = 2"), std::pair(Mode::strain, 0.02));
  EXPECT_EQ(first("temperature_degC = 80"), std::pair(Mode::temperature, 353.15));
  EXPECT_EQ(first("position_mm = 2"), std::pair(Mode::position, 0.002));
  EXPECT_EQ(first("current_mA = 100"), std::pair(Mode::current, 0.1));
  EXPECT_EQ(first("force_N = 0.5"), std::pair(Mode::force, 0.5));
  EXPECT_EQ(first("mode = 'off'").first, Mode::off);
  EXPECT_FALSE(program("[[command]]\nmode = 'off'\nfor_s = 1\n").at(0).arm);
}

TEST(CommandProgram, StaircasesGoThereAndBack) {
  bench::CommandProgram p =
      program("[[command]]\nshape = 'staircase'\nstrain = [0.03, 0.01]\nsteps = 2\neach_s = 1\n");
  EXPECT_EQ(p.duration_s(), 5);
  const double levels[] = {0.03, 0.02, 0.01, 0.02, 0.03, 0.03};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(p.at(i + 0.5).setpoint, levels[i], 1e-12) << i;
  }
}

TEST(CommandProgram, TrapezoidsAreLinesAndRests) {
  bench::CommandProgram p = program(
      "[[command]]\nshape = 'trapezoid'\nstrain = [0.04, 0.02]\nramp_s = 2\nhold_s = 1\ntimes = "
      "2\n");
  EXPECT_EQ(p.duration_s(), 12);
  for (const double t : {0.0, 6.0}) {
    EXPECT_NEAR(p.at(t + 0.5).setpoint, 0.035, 1e-12);
    EXPECT_NEAR(p.at(t + 2.5).setpoint, 0.02, 1e-12);
    EXPECT_NEAR(p.at(t + 4.5).setpoint, 0.035, 1e-12);
    EXPECT_NEAR(p.at(t + 5.5).setpoint, 0.04, 1e-12);
  }
}

TEST(CommandProgram, SweepsPassEveryFrequencyOnce) {
  bench::CommandProgram p =
      program("[[command]]\nshape = 'sine'\nstrain = [0.01, 0.03]\nHz = [1, 8]\nfor_s = 10\n");
  // T (f1 - f0)/ln(f1/f0) cycles, so twice as many turns through the middle.
  const int cycles = static_cast<int>(2 * 10 * 7 / std::log(8.0));
  int crossings = 0;
  double last = 0.02;
  double min = 1;
  double max = 0;
  for (int i = 1; i < 10000; ++i) {
    const double now = p.at(i * 1e-3).setpoint;
    crossings += (now - 0.02) * (last - 0.02) < 0 ? 1 : 0;
    last = now;
    min = std::min(min, now);
    max = std::max(max, now);
  }
  EXPECT_NEAR(crossings, cycles, 1);
  EXPECT_NEAR(min, 0.01, 1e-5);
  EXPECT_NEAR(max, 0.03, 1e-5);
}

TEST(CommandProgram, RandomStepsStayInTheirRangeAndFollowTheSeed) {
  const std::string commands =
      "[[command]]\nshape = 'random'\nstrain = [0.01, 0.03]\neach_s = [0.1, 0.3]\nfor_s = 20\n";
  const std::string seeded = "seed = 2\n" + std::string(head) + commands;
  const bench::ClosedLoopScenario a = loaded(head + commands);
  const bench::ClosedLoopScenario b = loaded(head + commands);
  const bench::ClosedLoopScenario c = loaded(seeded);
  EXPECT_NEAR(a.duration_s, 20, 1e-9);
  ASSERT_EQ(a.program.size(), b.program.size());
  for (std::size_t i = 0; i < a.program.size(); ++i) {
    EXPECT_EQ(a.program[i].command.setpoint, b.program[i].command.setpoint);
    EXPECT_TRUE(a.program[i].end >= 0.01 && a.program[i].end <= 0.03);
  }
  EXPECT_NE(a.program[0].end, c.program[0].end);
}

TEST(CommandProgram, FlagsAndScales) {
  bench::CommandProgram p = program(
      "[[command]]\nstrain = 0.02\nfor_s = 1\nscale = [2, 0.5, 0]\nclear_faults = true\nsilent = "
      "true\narm = false\n");
  const Command<double> c = p.at(0.5);
  EXPECT_FALSE(c.fresh);
  EXPECT_FALSE(c.arm);
  EXPECT_TRUE(c.clear_faults);
  EXPECT_EQ(c.scale.proportional, 2);
  EXPECT_EQ(c.scale.integral, 0.5);
  EXPECT_EQ(c.scale.derivative, 0);
}

TEST(ClosedLoopScenario, SaysWhatIsWrongAndWhere) {
  const std::string off = std::string(head) + "[[command]]\nmode = 'off'\nfor_s = 1\n";
  EXPECT_THAT(refusal(head), HasSubstr("one or more tables, each headed [[command]]"));
  EXPECT_THAT(refusal(off + "[plant]\nfamily = 'steel'\n"),
              AllOf(HasSubstr("loop.toml:8"), HasSubstr("lumped, ihyp, sublayers")));
  EXPECT_THAT(refusal(off + "[plant]\ncolour = 1\n"), HasSubstr("plant.colour = 1: unknown key"));
  EXPECT_THAT(refusal(std::string(head) + "[[command]]\nstrain = 2\nfor_s = 1\n"),
              AllOf(HasSubstr("loop.toml:5"), HasSubstr("command.strain = 2"),
                    HasSubstr("between -0.05 and 0.2")));
  EXPECT_THAT(refusal(std::string(head) + "[[command]]\nstrain = nan\nfor_s = 1\n"),
              HasSubstr("must be a number"));
  EXPECT_THAT(refusal(std::string(head) + "[[command]]\nstrain = 0.02\npower_W = 1\nfor_s = 1\n"),
              HasSubstr("another set-point"));
  EXPECT_THAT(refusal(std::string(head) + "[[command]]\nfor_s = 1\n"), HasSubstr("strain_percent"));
  EXPECT_THAT(refusal(off + "[[event]]\nat_s = 1\nsensor = 'voltage'\nfault = 'offset'\n"),
              HasSubstr("event.amount: is missing"));
  EXPECT_THAT(refusal(off + "[pair]\ntype = 'driven'\n[load]\ntype = 'spring'\nlow_MPa = "
                            "100\nhigh_MPa = 200\nstroke = 0.04\nlag_s = 0.1\n"),
              HasSubstr("constant load"));
  EXPECT_THAT(refusal(off + "[pair]\ntype = 'driven'\n[[event]]\nat_s = 1\nstop_percent = 2\n"),
              HasSubstr("not in a pair"));
}

}  // namespace
}  // namespace smaservo::test
