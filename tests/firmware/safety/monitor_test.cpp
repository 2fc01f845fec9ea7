// A healthy wire never triggers a fault, whatever it is asked for.

#include "firmware/safety/monitor.hpp"

#include <gtest/gtest.h>
#include <numbers>

#include "tests/firmware/device/rig.hpp"

namespace smaservo::monitor_test {
namespace {

/// A wire, its air and its load drawn at random, within what a calibrated unit leaves.
struct Scenario {
  explicit Scenario(std::uint64_t seed, bool distributed)
      : random(seed),
        unlike(random_unlike(random)),
        middle_Pa(60e6 + 160e6 * share()),
        amplitude_Pa(0.25 * middle_Pa * share()),
        period_s(1 + 4 * share()) {
    const Settings<double> settings = test_settings();
    std::unique_ptr<RigWire> wire;
    if (distributed) {
      wire = std::make_unique<DistributedRigWire>(settings.wire, unlike, middle_Pa, random);
    } else {
      wire = std::make_unique<LumpedRigWire>(settings.wire, unlike, middle_Pa);
    }
    rig = std::make_unique<Rig>(settings, std::move(wire), middle_Pa, seed);
    top = rig->wire->strain();
    rig->arm(Mode::strain, top);
  }

  double share() { return std::uniform_real_distribution<double>()(random); }

  /// One full cycle, then strains at random, with a load that waves and jumps and a draught.
  void step(double time_s) {
    if (time_s < 3) {
      rig->command.setpoint = time_s < 1.5 ? 0.008 : top - 0.002;
    } else if (next_s <= time_s) {
      next_s = time_s + 0.2 + 2.5 * share();
      rig->command.setpoint = 0.009 + (top - 0.01) * share();
      middle_Pa = std::clamp(middle_Pa * (0.8 + 0.4 * share()), 60e6, 220e6);
    }
    const double wave = std::sin(2 * std::numbers::pi * time_s / period_s);
    rig->stress_Pa = middle_Pa + amplitude_Pa * wave;
    rig->draught = 1 + 0.15 * std::sin(time_s / 3);
    rig->step();
  }

  std::mt19937_64 random;
  Unlike unlike;
  double middle_Pa, amplitude_Pa, period_s;
  std::unique_ptr<Rig> rig;
  double top;
  double next_s = 3;
};

class HealthyWire : public ::testing::TestWithParam<std::tuple<std::uint64_t, bool>> {};

TEST_P(HealthyWire, RaisesNoFalseAlarm) {
  const auto [seed, distributed] = GetParam();
  Scenario scenario(seed, distributed);
  ASSERT_EQ(scenario.rig->out.state, DeviceState::running);
  FaultSet seen;
  for (int i = 0; i < 40000; ++i) {
    scenario.step(i * Rig::dt_s);
    seen = seen | scenario.rig->out.active;
  }
  // A fault that only limits the current may occur at the end of the stroke, and is no false alarm.
  for_each_fault(seen - limiting_faults,
                 [](Fault fault) { ADD_FAILURE() << "false alarm: " << fault_name(fault); });
  EXPECT_EQ(scenario.rig->out.state, DeviceState::running);
  EXPECT_LE(scenario.rig->hottest_K, scenario.rig->settings.trips.temperature_K + 3);
}

INSTANTIATE_TEST_SUITE_P(Lumped, HealthyWire,
                         ::testing::Combine(::testing::Range<std::uint64_t>(1000, 1012),
                                            ::testing::Values(false)));
INSTANTIATE_TEST_SUITE_P(Distributed, HealthyWire,
                         ::testing::Combine(::testing::Range<std::uint64_t>(2000, 2006),
                                            ::testing::Values(true)));

}  // namespace
}  // namespace smaservo::monitor_test
