#include "firmware/device/device.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware/device/test_device.hpp"

namespace smaservo {

// On boards the device runs in single precision, which must compile without a warning as well.
template struct Device<float>;

}  // namespace smaservo

namespace smaservo::device_test {
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
    bench.advance(out.drive_current_A, 1e-3);
  }
  EXPECT_NEAR(bench.strain(), command.setpoint, 4e-4);
}

TEST(Device, FloatFollowsDouble) {
  const Prepared<double> p = prepare(test_settings());
  const Prepared<float> p_float = prepare(test_settings<float>());
  TestBench exact(p.settings.wire, 150e6), quick(p.settings.wire, 150e6);
  Device<double>::State s = Device<double>::start();
  Device<float>::State s_float = Device<float>::start();
  const double longest = exact.strain();
  const double stroke = p.settings.wire.nominal_stroke;
  double in_motion = 0, at_rest = 0;
  // Timers in float may end a step earlier than in double, so both devices are armed before the
  // wires move.
  for (int i = 0; i < 4000; ++i) {
    constexpr double contraction[] = {0, 0.01, 0.03, 0.02, 0.005};
    const double setpoint = longest - contraction[i / 800];
    const Command<double> command{
        .fresh = true, .arm = true, .mode = Mode::strain, .setpoint = setpoint};
    const Command<float> command_float{
        .fresh = true, .arm = true, .mode = Mode::strain, .setpoint = static_cast<float>(setpoint)};
    exact.advance(Device<double>::step(p, s, exact.inputs(), command, 1e-3).drive_current_A, 1e-3);
    const Output<float> out =
        Device<float>::step(p_float, s_float, quick.inputs<float>(), command_float, 1e-3F);
    quick.advance(static_cast<double>(out.drive_current_A), 1e-3);
    const double apart = std::abs(exact.strain() - quick.strain()) / stroke;
    in_motion = std::max(in_motion, apart);
    at_rest = i % 800 < 600 ? at_rest : std::max(at_rest, apart);
  }
  EXPECT_LT(exact.strain(), longest - 0.003);
  EXPECT_LT(in_motion, 2e-4);
  EXPECT_LT(at_rest, 1e-4);
}

/// While the wire pulls at its stop no reading can end a doubt, so the device must go on seeing the
/// pull: limits.stress_Pa holds in a doubtful stall as in any other.
TEST(Device, ADoubtDoesNotHideThePullAtTheStop) {
  Settings<double> settings = test_settings();
  const double load_Pa = 150e6;
  settings.measurement.has_load_cell = false;
  settings.measurement.constant_load_N = load_Pa * settings.wire.geometry.area_m2();
  settings.limits.stress_Pa = 250e6;
  settings.limits.temperature_K = settings.trips.temperature_K = 550;
  const auto greatest_MPa = [&](double mismatch) {
    TestBench bench(settings.wire, load_Pa);
    settings.axis.stop_strain = bench.strain() - 0.02;
    const Prepared<double> p = prepare(settings);
    Device<double>::State s = Device<double>::start();
    const Command<double> command{.fresh = true, .arm = true, .mode = Mode::power, .setpoint = 0.8};
    double greatest_Pa = 0;
    int doubtful = 0;
    for (int i = 0; i < 6000; ++i) {
      const Output<double> out = Device<double>::step(p, s, bench.inputs(), command, 1e-3);
      bench.advance(out.drive_current_A, 1e-3);
      auto& filter = s.observer.observer;
      if (KalmanObserver<double>::held(MultipleModelFilter<double>::likeliest(filter))) {
        filter.filter[filter.leader].mismatch = mismatch;
        doubtful += out.estimate.health == Health::doubtful ? 1 : 0;
      }
      EXPECT_TRUE(out.latched.empty()) << fault_name(out.first_cause) << ", " << i;
      greatest_Pa = std::max(greatest_Pa, out.wire_stress_Pa);
    }
    EXPECT_EQ(doubtful > 1000, mismatch > 0.01);
    return 1e-6 * greatest_Pa;
  };
  EXPECT_NEAR(greatest_MPa(0.02), greatest_MPa(0), 1);
  EXPECT_LT(greatest_MPa(0.02), 255);
  settings.limits.stress_Pa = 500e6;
  EXPECT_GT(greatest_MPa(0.02), 300) << "the limit is not what is tested";
}

}  // namespace
}  // namespace smaservo::device_test
