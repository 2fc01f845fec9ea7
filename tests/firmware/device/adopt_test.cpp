#include "firmware/device/adopt.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware/device/test_device.hpp"

namespace smaservo::adopt_test {
namespace {

/// A device on its way to a shorter wire, 50 ms after it has begun to run.
struct DeviceRun {
  Settings<double> settings = test_settings();
  Prepared<double> prepared = prepare(settings);
  TestBench bench{settings.wire, 150e6};
  Device<double>::State state = Device<double>::start();
  Command<double> command{
      .fresh = true, .arm = true, .mode = Mode::strain, .setpoint = bench.strain() - 0.02};

  DeviceRun() {
    int running = 0;
    for (int i = 0; i < 500 && running < 50; ++i) {
      running += step().state == DeviceState::running ? 1 : 0;
    }
  }
  Output<double> step() {
    const Output<double> out = Device<double>::step(prepared, state, bench.inputs(), command, 1e-3);
    bench.advance(out.drive_current_A, 1e-3);
    return out;
  }
};

Settings<double> with_new_gains() {
  Settings<double> settings = test_settings();
  settings.strain.proportional = 20;
  settings.strain.integral_1_s = 2;
  settings.feed_forward_s = 0.5;
  return settings;
}

TEST(Adopt, NewGainsDoNotMoveTheOutput) {
  const Prepared<double> next = prepare(with_new_gains());
  DeviceRun adopting;
  const double before_W = adopting.step().wanted_power_W;
  DeviceRun bare = adopting;
  bare.prepared = next;
  adopt(adopting.prepared, next, adopting.state);
  adopting.prepared = next;
  const double jump_W = std::abs(bare.step().wanted_power_W - before_W);
  const double step_W = std::abs(adopting.step().wanted_power_W - before_W);
  EXPECT_GT(jump_W, 0.1 * before_W) << "the gains would have made a difference";
  EXPECT_LT(step_W, 0.05 * jump_W);
  EXPECT_TRUE(adopting.state.observing);
}

TEST(Adopt, TheSameSettingsChangeNothingOfTheEstimate) {
  DeviceRun a;
  DeviceRun b = a;
  adopt(b.prepared, b.prepared, b.state);
  EXPECT_EQ(a.step().estimate.strain, b.step().estimate.strain);
}

TEST(Adopt, AnotherWireIsObservedFromTheStart) {
  DeviceRun run;
  Settings<double> settings = test_settings();
  settings.wire.geometry.length_m = 0.2;
  const Prepared<double> next = prepare(settings);
  adopt(run.prepared, next, run.state);
  EXPECT_FALSE(run.state.observing);
}

}  // namespace
}  // namespace smaservo::adopt_test
