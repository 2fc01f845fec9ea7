#include "firmware/device.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/test_device.hpp"

namespace smaservo {

// On the boards it runs in single precision: that must compile without a warning as well.
template struct Device<float>;

namespace {

TEST(Device, HoldsAStrain) {
  const Settings<double> settings = test_settings();
  const Prepared<double> p = prepare(settings);
  TestBench bench(settings.wire, 150e6);
  Device<double>::State s = Device<double>::start();
  const Command<double> command{
      .fresh = true, .arm = true, .mode = Mode::strain, .setpoint = bench.strain() - 0.02};
  for (int i = 0; i < 1000; ++i) {
    const Output<double> out = Device<double>::step(p, s, bench.inputs(), command, 1e-3);
    bench.advance(out.current_A, 1e-3);
  }
  EXPECT_NEAR(bench.strain(), command.setpoint, 4e-4);
}

}  // namespace
}  // namespace smaservo
