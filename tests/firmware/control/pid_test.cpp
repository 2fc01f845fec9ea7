#include "firmware/control/pid.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace smaservo::pid_test {
namespace {

using Loop = Pid<double>;

constexpr LoopGains<double> gains{.proportional = 2,
                                  .integral_1_s = 5,
                                  .derivative_s = 0.02,
                                  .derivative_filter_s = 0.004,
                                  .setpoint_weight = 1,
                                  .derivative_weight = 0,
                                  .tracking_s = 0.1,
                                  .cooling_factor = 1,
                                  .dead_band = 0};
constexpr GainScale<double> unscaled{};
constexpr double dt_s = 1e-3;

/// The parts of A&H's equation (3.20), each integrated by itself in steps a hundred times as fine,
/// where reference and measurement are straight lines.
double continuous_W(const LoopGains<double>& q, double seconds, double r0, double r_1_s, double y0,
                    double y_1_s) {
  const double fine_s = 1e-5;
  double integral = 0;
  double filtered = q.derivative_weight * r0 - y0;
  double derivative = 0;
  double r = r0;
  double y = y0;
  for (double t = 0; t < seconds - fine_s / 2; t += fine_s) {
    r += r_1_s * fine_s;
    y += y_1_s * fine_s;
    integral += q.proportional * q.integral_1_s * (r - y) * fine_s;
    derivative = (q.derivative_weight * r - y - filtered) / q.derivative_filter_s;
    filtered += derivative * fine_s;
  }
  return q.proportional * (r - y - (1 - q.setpoint_weight) * (r - r0)) + integral +
         q.proportional * q.derivative_s * derivative;
}

double discrete_W(const LoopGains<double>& q, double seconds, double r0, double r_1_s, double y0,
                  double y_1_s, double step_s = dt_s) {
  Loop::State s = Loop::start(q, r0, y0);
  double u = 0;
  const auto steps = static_cast<int>(std::lround(seconds / step_s));
  for (int i = 1; i <= steps; ++i) {
    u = Loop::step(q, unscaled, 1, s, r0 + r_1_s * i * step_s, y0 + y_1_s * i * step_s, step_s);
  }
  return u;
}

TEST(Pid, FollowsTheContinuousEquationToFirstOrder) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1), share(0, 1);
  for (int i = 0; i < 50; ++i) {
    LoopGains<double> q = gains;
    q.setpoint_weight = share(random);
    q.derivative_weight = share(random);
    const double r0 = any(random), r_1_s = any(random), y0 = any(random), y_1_s = any(random);
    const double exact = continuous_W(q, 0.3, r0, r_1_s, y0, y_1_s);
    const double at_1kHz = std::abs(discrete_W(q, 0.3, r0, r_1_s, y0, y_1_s) - exact);
    const double at_2kHz = std::abs(discrete_W(q, 0.3, r0, r_1_s, y0, y_1_s, dt_s / 2) - exact);
    EXPECT_LT(at_1kHz, 0.02);
    EXPECT_NEAR(at_2kHz, at_1kHz / 2, 1e-4);
  }
}

TEST(Pid, HeatWhereItLowersTheVariableIsTheMirrorImage) {
  Loop::State up = Loop::start(gains, 0, 0);
  Loop::State down = up;
  for (int i = 0; i < 100; ++i) {
    const double r = std::sin(0.1 * i), y = std::cos(0.07 * i);
    const double u = Loop::step(gains, unscaled, 1, up, r, y, dt_s);
    EXPECT_DOUBLE_EQ(u, -Loop::step(gains, unscaled, -1, down, r, y, dt_s));
  }
}

TEST(Pid, AStepOfTheSetpointKicksOnlyByItsWeights) {
  const auto kick_W = [](double setpoint_weight, double derivative_weight) {
    LoopGains<double> q = gains;
    q.integral_1_s = 0;
    q.setpoint_weight = setpoint_weight;
    q.derivative_weight = derivative_weight;
    Loop::State s = Loop::start(q, 0, 0);
    EXPECT_EQ(Loop::step(q, unscaled, 1, s, 0, 0, dt_s), 0);
    return Loop::step(q, unscaled, 1, s, 1, 0, dt_s);
  };
  EXPECT_DOUBLE_EQ(kick_W(1, 0), 2);
  EXPECT_DOUBLE_EQ(kick_W(0.25, 0), 0.5);
  EXPECT_DOUBLE_EQ(kick_W(0, 0), 0);
  // The derivative's part is K T_d/(T_f + dt).
  EXPECT_DOUBLE_EQ(kick_W(0, 1), 2 * 0.02 / 0.005);
}

TEST(Pid, TheWeightsDoNotTouchTheFeedback) {
  // The response to a disturbance of the measurement is the same with any weight.
  const auto answer_W = [](double weight) {
    LoopGains<double> q = gains;
    q.setpoint_weight = weight;
    q.derivative_weight = weight;
    Loop::State s = Loop::start(q, 0.7, 0.7);
    double u = 0;
    for (int i = 0; i < 50; ++i) {
      u = Loop::step(q, unscaled, 1, s, 0.7, 0.7 + 0.001 * i, dt_s);
    }
    return u;
  };
  EXPECT_NEAR(answer_W(0), answer_W(1), 1e-12);
  EXPECT_NEAR(answer_W(0.4), answer_W(1), 1e-12);
}

TEST(Pid, LessHeatHasGainsOfItsOwn) {
  LoopGains<double> q = gains;
  q.cooling_factor = 0.5;
  q.derivative_s = 0;
  Loop::State s = Loop::start(q, 0, 0);
  const double more = Loop::step(q, unscaled, 1, s, 0.1, 0, dt_s);
  s = Loop::start(q, 0, 0);
  EXPECT_DOUBLE_EQ(Loop::step(q, unscaled, 1, s, -0.1, 0, dt_s), -0.5 * more);
  s = Loop::start(q, 0, 0);
  // Where heat lowers the variable, a reference above it asks for less.
  EXPECT_DOUBLE_EQ(Loop::step(q, unscaled, -1, s, 0.1, 0, dt_s), -0.5 * more);
}

TEST(Pid, TheSignOfTheErrorMakesNoStep) {
  // A moving measurement passes its reference. Neither the other gain on that side (cooling_factor)
  // nor a set-point weight below 1 may make a step.
  LoopGains<double> q = gains;
  q.cooling_factor = 0.3;
  q.setpoint_weight = 0.5;
  Loop::State s = Loop::start(q, 0.5, 0);
  double before = 0;
  double max = 0;
  for (int i = 0; i < 400; ++i) {
    const double u = Loop::step(q, unscaled, 1, s, 1, 0.005 * i, dt_s);
    max = i > 50 ? std::max(max, std::abs(u - before)) : 0;
    before = u;
  }
  EXPECT_LT(max, 0.03);
}

TEST(Pid, InsideTheDeadBandTheOutputRests) {
  LoopGains<double> q = gains;
  q.dead_band = 0.1;
  q.derivative_s = 0;
  Loop::State s = Loop::start(q, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(Loop::step(q, unscaled, 1, s, 0.099 * std::sin(i), 0, dt_s), 0);
  }
  // At the edge of the dead band the output begins without a step.
  EXPECT_NEAR(Loop::step(q, unscaled, 1, s, 0.101, 0, dt_s), 2 * 0.001, 2e-5);
}

TEST(Pid, EachPartIsScaledByItself) {
  const auto u_W = [](GainScale<double> scale) {
    Loop::State s = Loop::start(gains, 0, 0);
    Loop::step(gains, scale, 1, s, 1, 0, dt_s);
    return Loop::step(gains, scale, 1, s, 1, 0.01, dt_s);
  };
  const double none = u_W({0, 0, 0});
  const double p = u_W({1, 0, 0}), i = u_W({0, 1, 0}), d = u_W({0, 0, 1});
  EXPECT_EQ(none, 0);
  EXPECT_DOUBLE_EQ(p, 2 * 0.99);
  EXPECT_NEAR(i, 2 * 5 * (1 + 0.99) * dt_s, 1e-15);
  EXPECT_DOUBLE_EQ(d, -2 * 0.02 * 0.01 / 0.005);
  EXPECT_NEAR(u_W({3, 0.5, 2}), 3 * p + 0.5 * i + 2 * d, 1e-12);
}

/// The set-point is out of reach and then comes back: the time for which the output stays at its
/// limit.
double stuck_s(double tracking_s) {
  LoopGains<double> q = gains;
  q.derivative_s = 0;
  q.tracking_s = tracking_s;
  Loop::State s = Loop::start(q, 0, 0);
  int stuck = 0;
  for (int i = 0; i < 4000; ++i) {
    const double reference = i < 2000 ? 1 : -0.1;
    const double wanted = Loop::step(q, unscaled, 1, s, reference, 0, dt_s);
    const double given = wanted < 0 ? 0 : wanted > 0.5 ? 0.5 : wanted;
    Loop::limited(q, s, wanted, given, dt_s);
    stuck += i >= 2000 && given > 0 ? 1 : 0;
  }
  return stuck * dt_s;
}

TEST(Pid, BackCalculationEmptiesTheIntegralInTheTrackingTime) {
  // In the limit the integral settles where K T_t/T_i feeds what tracking takes: wanted less given
  // is 2 * 5 * 0.1 = 1 W, and less than that after the step back.
  EXPECT_LT(stuck_s(0.1), 0.1);
  EXPECT_LT(stuck_s(0.02), 0.02);
  // Without tracking, the integral has grown for 2 s at 10 W/s, and takes 20 s to come down at 1
  // W/s.
  EXPECT_GE(stuck_s(1e9), 2);
}

TEST(Pid, WithoutIntegralGainNothingIsKept) {
  LoopGains<double> q = gains;
  Loop::State s = Loop::start(q, 0, 0);
  Loop::step(q, unscaled, 1, s, 1, 0, 0.1);
  ASSERT_GT(s.integral_W, 0.5);
  q.integral_1_s = 0;
  q.derivative_s = 0;
  Loop::resume(q, s, 1, 1);
  EXPECT_EQ(Loop::step(q, unscaled, 1, s, 1, 1, dt_s), 0);
  Loop::limited(q, s, 1, 0, dt_s);
  EXPECT_EQ(s.integral_W, 0);
}

TEST(Pid, ResumesWithItsIntegralAndWithoutAKick) {
  LoopGains<double> q = gains;
  q.derivative_weight = 0.3;
  Loop::State s = Loop::start(q, 1, 0);
  for (int i = 0; i < 100; ++i) {
    Loop::step(q, unscaled, 1, s, 1, 0.9, dt_s);
  }
  const double integral = s.integral_W;
  q.derivative_weight = 1;
  Loop::resume(q, s, 1, 0.9);
  EXPECT_EQ(s.integral_W, integral);
  EXPECT_NEAR(Loop::step(q, unscaled, 1, s, 1, 0.9, dt_s), 2 * 0.1 + integral, 0.002);
}

}  // namespace
}  // namespace smaservo::pid_test
