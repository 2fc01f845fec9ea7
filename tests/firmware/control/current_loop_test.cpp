#include "firmware/control/current_loop.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace smaservo::current_loop_test {
namespace {

using Loop = CurrentLoop<double>;

constexpr DriveSettings<double> drive{DriveKind::current, 0.3, 50, 5, 30};
constexpr double ohm = 30;
constexpr double dt_s = 1e-3;

/// An output stage with errors of gain and offset.
struct Stage {
  double gain = 1, offset_A = 0;
  double given_A(double asked_A) const { return std::max(0.0, gain * asked_A + offset_A); }
};

TEST(CurrentLoop, TakesOutTheStagesOwnError) {
  for (const Stage& stage : {Stage{0.95, 0}, Stage{1.05, 0}, Stage{1.03, -0.005}}) {
    Loop::State s{};
    double measured_A = 0;
    for (const double asked_A : {0.2, 0.35, 0.1}) {
      for (int i = 0; i < 300; ++i) {
        measured_A = stage.given_A(Loop::step(drive, s, asked_A, measured_A, ohm, dt_s).current_A);
      }
      EXPECT_NEAR(measured_A, asked_A, 1e-5) << stage.gain << " " << asked_A;
    }
  }
}

TEST(CurrentLoop, WithoutGainsItAsksForWhatIsAsked) {
  DriveSettings<double> open = drive;
  open.proportional = open.integral_1_s = 0;
  Loop::State s{};
  for (const double asked_A : {0.1, 0.4, 0.012}) {
    const Loop::Result out = Loop::step(open, s, asked_A, 0.2, ohm, dt_s);
    EXPECT_EQ(out.current_A, asked_A);
    EXPECT_EQ(out.voltage_V, asked_A * ohm);
  }
}

TEST(CurrentLoop, NeverAddsNorTakesMoreThanItsShare) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(0, 0.4);
  Loop::State s{};
  for (int i = 0; i < 10000; ++i) {
    const double asked_A = any(random);
    // The sensor reads anything, also NaN.
    const double measured_A =
        i % 7 == 0 ? std::numeric_limits<double>::quiet_NaN() : 1e6 * (any(random) - 0.2);
    const double current_A = Loop::step(drive, s, asked_A, measured_A, ohm, dt_s).current_A;
    ASSERT_GE(current_A, 0.9 * asked_A - 1e-15);
    ASSERT_LE(current_A, 1.1 * asked_A + 1e-15);
  }
}

TEST(CurrentLoop, ZeroIsZero) {
  Loop::State s{};
  for (int i = 0; i < 100; ++i) {
    Loop::step(drive, s, 0.3, 0.2, ohm, dt_s);
  }
  const Loop::Result out = Loop::step(drive, s, 0, 0.2, ohm, dt_s);
  EXPECT_EQ(out.current_A, 0);
  EXPECT_EQ(out.voltage_V, 0);
  EXPECT_EQ(s.trim_A, 0);
}

TEST(CurrentLoop, WhatIsNotMeasuredIsNotCorrected) {
  Loop::State s{};
  double measured_A = 0;
  for (int i = 0; i < 300; ++i) {
    measured_A = 0.95 * Loop::step(drive, s, 0.2, measured_A, ohm, dt_s).current_A;
  }
  const double before_A = s.trim_A;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double out_A = Loop::step(drive, s, 0.2, nan, ohm, dt_s).current_A;
  EXPECT_EQ(s.trim_A, before_A);
  EXPECT_NEAR(0.95 * out_A, 0.2, 1e-5);
}

}  // namespace
}  // namespace smaservo::current_loop_test
