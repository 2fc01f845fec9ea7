#include "firmware/device/servo.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "model/wire/wire_plant.hpp"
#include "tests/firmware/device/test_device.hpp"

namespace smaservo::servo_test {
namespace {

constexpr double dt_s = 1e-3;
constexpr double load_N = 0.68;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Settings<double> tuned() {
  Settings<double> settings = test_settings();
  settings.strain.proportional = 2;
  settings.strain.integral_1_s = 2;
  return settings;
}

/// A servo and its wire.
struct Loop {
  Servo<double> servo{tuned()};
  WirePlant<double> wire{tuned().wire, load_N};
  Output<double> out{};

  Sample<double> reading() const {
    const double A = out.drive_current_A;
    return {.current_A = A, .voltage_V = A * wire.output().resistance_ohm, .load_N = load_N};
  }
  void step(const Sample<double>& reading, const Command<double>& command) {
    out = servo.update(reading, command, dt_s);
    wire.update({.current_A = out.drive_current_A, .load_N = load_N}, dt_s);
  }
  void run(double seconds, const Command<double>& command) {
    for (int i = 0; i < std::lround(seconds / dt_s); ++i) {
      step(reading(), command);
    }
  }
};

Command<double> strain(double setpoint) {
  return {.mode = Mode::strain, .setpoint = setpoint};
}

TEST(Servo, GoesWhereItIsTold) {
  Loop loop;
  for (const double target : {0.03, 0.02, 0.01, 0.025, 0.035}) {
    loop.run(4, strain(target));
    EXPECT_EQ(loop.out.state, DeviceState::running);
    EXPECT_NEAR(loop.wire.output().strain, target, 4e-4);
    EXPECT_NEAR(loop.out.estimate.strain, target, 4e-4);
  }
  loop.run(0.01, {});
  EXPECT_EQ(loop.out.drive_current_A, 0);
  EXPECT_EQ(loop.out.state, DeviceState::ready);
}

TEST(Servo, IsTheDeviceToTheBit) {
  const Settings<double> settings = tuned();
  const Prepared<double> prepared = prepare(settings);
  Device<double>::State device = Device<double>::start();
  Loop loop;
  for (int i = 0; i < 5000; ++i) {
    const Sample<double> reading = loop.reading();
    const Command<double> wanted = strain(i < 3000 ? 0.03 : 0.015);
    Command<double> command = wanted;
    command.fresh = command.arm = true;
    Inputs<double> in{};
    in.fresh = true;
    in.sequence = static_cast<std::uint32_t>(i + 1);
    in.sample = reading;
    in.supply_V = in.ambient_K = in.driver_K = nan;
    const Output<double> same = Device<double>::step(prepared, device, in, command, dt_s);
    loop.step(reading, wanted);
    ASSERT_EQ(loop.out.drive_current_A, same.drive_current_A);
    ASSERT_EQ(loop.out.estimate.strain, same.estimate.strain);
    ASSERT_EQ(loop.out.latched.bits(), same.latched.bits());
  }
}

/// Each sensor that fails while the wire is heated ends the heat, for good and with its reason.
TEST(Servo, ASensorThatFailsEndsTheHeat) {
  for (const int which : {0, 1, 2}) {
    Loop loop;
    loop.run(2, strain(0.02));
    ASSERT_GT(loop.out.drive_current_A, 0.05);
    for (int i = 0; i < 500; ++i) {
      Sample<double> reading = loop.reading();
      (which == 0 ? reading.current_A : which == 1 ? reading.voltage_V : reading.load_N) = nan;
      loop.step(reading, strain(0.02));
    }
    EXPECT_EQ(loop.out.drive_current_A, 0);
    EXPECT_EQ(loop.out.state, DeviceState::fault);
    EXPECT_NE(loop.out.first_cause, Fault::none);
    // A sensor that comes back alone heats nothing.
    loop.run(1, strain(0.02));
    EXPECT_EQ(loop.out.drive_current_A, 0);
    loop.run(0.1, {.clear_faults = true});
    loop.run(4, strain(0.02));
    EXPECT_EQ(loop.out.state, DeviceState::running);
    EXPECT_NEAR(loop.wire.output().strain, 0.02, 4e-4);
  }
}

TEST(Servo, AnIntervalThatIsNoneGivesNoCurrent) {
  Loop loop;
  loop.run(2, strain(0.02));
  Servo<double> undisturbed = loop.servo;
  for (const double none_s : {0.0, -1e-3, nan}) {
    EXPECT_EQ(loop.servo.update(loop.reading(), strain(0.02), none_s).drive_current_A, 0);
  }
  const Sample<double> reading = loop.reading();
  const Output<double> a = loop.servo.update(reading, strain(0.02), dt_s);
  const Output<double> b = undisturbed.update(reading, strain(0.02), dt_s);
  EXPECT_GT(a.drive_current_A, 0);
  EXPECT_EQ(a.drive_current_A, b.drive_current_A);
}

/// Whatever it is given: a current within its trip limit, and none where faults are latched.
TEST(Servo, NeverGivesWhatIsNotAllowed) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto odd = std::to_array({0.0, -1.0, nan, infinite, -infinite, 1e300, 1e-300, 1e9});
  const double most_A = tuned().trips.current_A;
  int heated_seeds = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    const auto pick = [&](double usual, unsigned one_in) {
      return random() % one_in == 0 ? odd.at(random() % odd.size()) : usual;
    };
    Loop loop;
    int heated = 0;
    for (int i = 0; i < 5000; ++i) {
      const Sample<double> now = loop.reading();
      const Sample<double> reading{pick(now.current_A, 2000), pick(now.voltage_V, 2000),
                                   pick(now.load_N, 2000)};
      Command<double> command{.clear_faults = random() % 100 == 0,
                              .mode = static_cast<Mode>(i / 500 % mode_count),
                              .setpoint = pick(0.02, 1000)};
      if (i % 500 < 20) {
        command.mode = Mode::off;
      }
      loop.out = loop.servo.update(reading, command, pick(dt_s, 3000));
      loop.wire.update({.current_A = loop.out.drive_current_A, .load_N = load_N}, dt_s);
      ASSERT_TRUE(0 <= loop.out.drive_current_A && loop.out.drive_current_A <= most_A);
      ASSERT_TRUE(is_heated(loop.out.state) || loop.out.drive_current_A == 0);
      heated += loop.out.drive_current_A > 0 ? 1 : 0;
    }
    heated_seeds += heated > 100 ? 1 : 0;
  }
  EXPECT_GT(heated_seeds, 10);
}

}  // namespace
}  // namespace smaservo::servo_test
