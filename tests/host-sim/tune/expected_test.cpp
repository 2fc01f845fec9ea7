#include "host-sim/tune/expected.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "firmware/device/device.hpp"
#include "hal/sim/simulated_wire.hpp"
#include "host-sim/tune/linear/uncertainty.hpp"
#include "host-sim/tune/tune.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::tune {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

TuneTask task_for(const char* wire, double stress_Pa) {
  return {{files::load_wire(wire).wire, {stress_Pa, stress_Pa, 0}, room_K, 1}, no_limit, 6, 1};
}

TEST(JudgeStep, OfALag) {
  const double period_s = 1e-3, lag_s = 0.1;
  std::vector<double> strain;
  strain.reserve(3000);
  for (int i = 0; i < 3000; ++i) {
    strain.push_back(0.04 - 0.02 * (1 - std::exp(-i * period_s / lag_s)));
  }
  const StepResponse s = judge_step(strain, 0, 3000, 0.04, 0.021, period_s, 4e-4);
  EXPECT_NEAR(s.rise_s, lag_s * std::log(9.0), 2 * period_s);
  EXPECT_NEAR(s.settling_s, lag_s * std::log(0.02 / 4e-4), 2 * period_s);
  EXPECT_NEAR(s.steady_error, -0.001, 1e-6);
  EXPECT_NEAR(s.overshoot, 0, 1e-6);
  EXPECT_NEAR(s.ripple, 0, 1e-6);
}

TEST(JudgeStep, OfAnOscillator) {
  const double period_s = 1e-3, w = 20, damping = 0.4;
  std::vector<double> strain;
  const double wd = w * std::sqrt(1 - damping * damping);
  for (int i = 0; i < 4000; ++i) {
    const double t = i * period_s;
    strain.push_back(0.01 * (1 - std::exp(-damping * w * t) *
                                     (std::cos(wd * t) + damping * w / wd * std::sin(wd * t))));
  }
  const StepResponse s = judge_step(strain, 0, 4000, 0, 0.01, period_s, 2e-4);
  EXPECT_NEAR(s.overshoot,
              0.01 * std::exp(-std::numbers::pi * damping / std::sqrt(1 - damping * damping)),
              1e-6);
}

/// The file's own wire, which the device knows: where it is told to be, still, soon, not too hot.
TEST(ExpectedSteps, OfTheFilesWireSettle) {
  const struct {
    const char* wire;
    double stress_Pa;
  } cases[] = {{"smartflex-25um", 100e6},     {"smartflex-76um", 50e6},
               {"smartflex-76um", 300e6},     {"smartflex-150um", 200e6},
               {"flexinol-lt-0.10mm", 100e6}, {"flexinol-ht-0.20mm", 120e6},
               {"smartflex-500um", 150e6}};
  for (const auto& c : cases) {
    const TuneTask t = task_for(c.wire, c.stress_Pa);
    const Proposal p = propose(t);
    const ExpectedSteps e = expected_steps(t, p, {t.plant});
    EXPECT_EQ(restless_wires(e, p.settings), 0) << c.wire;
    for (const StepResponse& s : e.runs.front().steps) {
      EXPECT_LT(std::abs(s.steady_error), 0.04 * 0.05) << c.wire << ' ' << s.to;
      const bool heats = s.to < s.from;
      // Heating as fast as the planner goes; cooling as fast as the wire and the planner's lead
      // let.
      const double way = std::abs(s.to - s.from);
      const double law_s = p.settings.feed_forward_s;
      const double asked_s = heats ? way / p.settings.trajectory.heating_rate_1_s + 3 * law_s
                                   : p.branches.cooling_s + way * law_s / Trajectory<double>::lead;
      EXPECT_LT(s.rise_s, asked_s) << c.wire << ' ' << s.to;
      EXPECT_LT(s.hottest_K, p.settings.limits.temperature_K) << c.wire;
    }
  }
}

TEST(ExpectedSteps, OfUncertainWiresHold) {
  const TuneTask t = task_for("smartflex-76um", 150e6);
  const Tuned tuned = tune("smartflex-76um", "smartflex-76um", t);
  EXPECT_EQ(tuned.expected.runs.size(), 12U);
  EXPECT_EQ(restless_wires(tuned.expected, tuned.proposal.settings), 0);
  EXPECT_TRUE(tuned.warnings.empty());
  for (std::size_t i = 0; i < tuned.worst.size(); ++i) {
    for (const ExpectedRun& r : tuned.expected.runs) {
      EXPECT_LE(r.steps[i].settling_s, tuned.worst[i].settling_s);
      EXPECT_LE(std::abs(r.steps[i].steady_error), std::abs(tuned.worst[i].steady_error));
    }
  }
}

/// The proposed gains on what their model is not: 24 segments with cold clamps, transition
/// temperatures that scatter, another convection.
class SegmentedLoop {
 public:
  SegmentedLoop(const TuneTask& task, const Settings<double>& settings)
      : prepared_(prepare(settings)),
        stress_Pa_(task.plant.load.low_Pa),
        area_m2_(task.plant.wire.geometry.area_m2()) {
    std::mt19937_64 random(3);
    wire_ = hal::make_simulated_wire(hal::Family::ihyp, task.plant.wire, {}, 0.5, random);
    wire_->rest(room_K, stress_Pa_);
  }

  /// Strains while this set-point is held.
  std::vector<double> hold(double setpoint, double seconds) {
    std::vector<double> strain;
    for (double t = 0; t < seconds; t += 1e-3) {
      command_.fresh = true;
      // Again where it was refused: the observer was not sure yet.
      command_.arm = !(command_.arm && device_.last.state == DeviceState::ready);
      command_.mode = Mode::strain;
      command_.setpoint = setpoint;
      Inputs<double> in{};
      in.fresh = true;
      in.sequence = sequence_++;
      in.sample = {current_A_, current_A_ * wire_->resistance_ohm(), stress_Pa_ * area_m2_};
      in.supply_V = in.driver_K = std::numeric_limits<double>::quiet_NaN();
      in.ambient_K = room_K;
      const Output<double> out = Device<double>::step(prepared_, device_, in, command_, 1e-3);
      current_A_ = out.drive_current_A;
      wire_->advance(current_A_, {stress_Pa_, room_K, 1}, 1e-3);
      strain.push_back(wire_->strain());
    }
    return strain;
  }
  double strain() const { return wire_->strain(); }

 private:
  Prepared<double> prepared_;
  double stress_Pa_, area_m2_;
  std::unique_ptr<hal::SimulatedWire> wire_;
  Device<double>::State device_ = Device<double>::start();
  Command<double> command_{};
  double current_A_ = 0;
  std::uint32_t sequence_ = 0;
};

TEST(ExpectedSteps, ComeTrueOnAWireOfManySegments) {
  for (const char* name : {"smartflex-76um", "smartflex-150um"}) {
    const TuneTask t = task_for(name, 150e6);
    const Proposal p = propose(t);
    SegmentedLoop loop(t, p.settings);
    const double rest = loop.strain();
    loop.hold(rest, 1.5);
    for (const double contraction : {0.5, 0.8, 0.4, 0.2}) {
      const double setpoint = rest - contraction * p.branches.stroke();
      const std::vector<double> strain = loop.hold(setpoint, 1 + 3 * p.branches.cooling_s);
      const auto tail = strain.end() - static_cast<std::ptrdiff_t>(strain.size() / 4);
      const auto [low, high] = std::minmax_element(tail, strain.end());
      EXPECT_LT(*high - *low, 0.04 * 0.01) << name << ": a limit cycle at " << contraction;
      EXPECT_NEAR(*tail, setpoint, 0.04 * 0.08) << name;
    }
  }
}

}  // namespace
}  // namespace smaservo::tune
